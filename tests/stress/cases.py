"""All cases, by label."""

from tests.stress import geometry, paths, records, scales, scatter, shaken
from tests.stress.harness import Case

CASES: dict[str, Case] = {
    case.label: case
    for module in (scales, geometry, paths, records, shaken, scatter)
    for case in module.cases()
}
