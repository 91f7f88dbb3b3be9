"""The tables of the stress tests: `python -m tests.stress [--long] [--each] [--beds]`."""

import sys

from tests.stress import beds
from tests.stress.cases import CASES
from tests.stress.harness import outcomes, table

if __name__ == "__main__":
    if "--beds" in sys.argv:
        print(beds.table())
        sys.exit()
    judged = outcomes(case for case in CASES.values() if "--long" in sys.argv or not case.long)
    for case, outcome in judged:
        if outcome.verdict == "failed" or "--each" in sys.argv:
            print(f"{outcome.verdict} {outcome.seconds:.2f} s {case.label}: {outcome.words}", file=sys.stderr)
    print(table(judged))
    sys.exit(any(outcome.verdict == "failed" for _, outcome in judged))
