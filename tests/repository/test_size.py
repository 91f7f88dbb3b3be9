"""Every folder of the program has a budget of lines, which may only fall.

`python -m tests.repository.test_size` prints the table for what is there now: where a folder has become smaller, its
line goes into the table below. A folder that outgrows its budget loses something first.
"""

import pytest

from tests import ROOT

LINES = {
    # of code, comments and blank lines in *.py
    "assessment": 183,
    "assessment/analyses": 3909,
    "assessment/app": 1240,
    "assessment/benchmark": 977,
    "assessment/cli": 595,
    "assessment/ntc": 1986,
    "assessment/project": 4289,
    "assessment/report": 5325,
    "assessment/results": 2951,
    "assessment/runtime": 1339,
    "assessment/studies": 2126,
    "assessment/workflow": 890,
    "mechanics": 930,
    "mechanics/kernels": 3519,
    "mechanics/model": 2998,
    "mechanics/procedures": 3644,
    "mechanics/records": 989,
    "mechanics/solvers": 933,
    "mechanics/steps": 1788,
}


def counted() -> dict[str, int]:
    """Return the number of lines of every folder of the packages, with its subfolders, and of what is in no folder."""
    found: dict[str, int] = {}
    for package in ("assessment", "mechanics"):
        for path in sorted((ROOT / package).rglob("*.py")):
            within = path.relative_to(ROOT).parts
            folder = "/".join(within[:2]) if len(within) > 2 else package
            found[folder] = found.get(folder, 0) + len(path.read_text(encoding="utf-8").splitlines())
    return found


@pytest.mark.parametrize("folder", counted())
def test_a_folder_keeps_to_its_budget(folder):
    lines = counted()[folder]
    assert folder in LINES, f"{folder}: new; give it a budget"
    assert lines <= LINES[folder], f"{folder}: {lines} lines; the budget is {LINES[folder]}"


def test_no_budget_is_of_a_folder_that_is_gone():
    assert LINES.keys() == counted().keys()


if __name__ == "__main__":
    for name, lines in sorted(counted().items()):
        print(f'    "{name}": {min(lines, LINES.get(name, lines))},')
