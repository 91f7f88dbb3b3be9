"""What every case's process inherits: compiled loops, loaded by runs of two samples, and what several cases need."""

from tests.stress.cases import CASES
from tests.stress.harness import judge
from tests.stress.scales import CONTACTS, plain_curve
from tests.stress.shaken import structures

for case in CASES.values():
    if "two samples" in case.name:
        judge(case)
structures()
for make in ("block", "arch"):
    for contacts in CONTACTS:
        plain_curve(make, contacts)
