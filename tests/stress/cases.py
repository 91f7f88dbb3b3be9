"""All cases, by label."""

from __future__ import annotations

from tests.stress import geometry, paths, records, scales
from tests.stress.harness import Case

CASES: dict[str, Case] = {
    case.label: case for module in (scales, geometry, paths, records) for case in module.cases()
}
