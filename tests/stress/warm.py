"""What every case's process inherits: all modules imported and the compiled loops loaded, by runs of two samples."""

from __future__ import annotations

from tests.stress.cases import CASES
from tests.stress.harness import judge

for case in CASES.values():
    if "two samples" in case.name:
        judge(case)
