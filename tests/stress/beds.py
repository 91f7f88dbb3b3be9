"""The exact bed beside one of 32 points, on random assemblies, templates and example projects: what fails of each.

Every assembly is settled elastically and pushed over from the drawn and from the settled state; where its project names
no stiffness of the joints it is STIFFNESS. `python -m tests.stress.beds` prints the table.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import import_module
from unittest.mock import patch

import numpy as np

from assessment.benchmark.structures import assembly
from assessment.project.catalogue.new_project import TEMPLATES
from mechanics import Assembly, pushdown, pushover
from mechanics.errors import CollapseError, ConvergenceError, NoEquilibriumError, UnstableError
from tests.stress.corpus import assemblies
from tests.support.drawn_projects import FOLDER, drawn

STIFFNESS = 1e6  # kN/m³
BEDS = {"exact": None, "32 points": 32}
STEPS = import_module("mechanics.procedures.step_control")
COLUMNS = ("paths", "lost", "refused", "not solved", "steps", "no equilibrium", "attempts failed")


def structures(count: int) -> Iterator[tuple[str, Assembly]]:
    """Random assemblies, then the templates and the example projects as drawn."""
    for number, model in assemblies(count):
        yield f"random {number}", model
    for name in TEMPLATES:
        yield f"template {name}", elastic(assembly(name))
    for project in sorted(FOLDER.glob("*/project.toml")):
        yield f"project {project.parent.name}", elastic(drawn(project.parent.name))


def elastic(model: Assembly) -> Assembly:
    """The assembly, with a stiffness for joints that have none."""
    blocks = [
        block
        if block.material.normal_stiffness
        else replace(block, material=replace(block.material, normal_stiffness=STIFFNESS))
        for block in model.blocks
    ]
    return replace(model, blocks=blocks)


def counted(model: Assembly) -> Counter[str]:
    """What becomes of a settlement and of two pushes of an assembly, and of the steps on their way."""
    found: Counter[str] = Counter()
    find = STEPS.find_equilibrium

    def watched(*arguments: object) -> object:
        found["steps"] += 1
        try:
            return find(*arguments)
        except ConvergenceError:
            found["attempts failed"] += 1
            raise
        except NoEquilibriumError:
            found["no equilibrium"] += 1
            raise

    def path(run: Callable[[], object]) -> object:
        found["paths"] += 1
        try:
            return run()
        except CollapseError as collapse:
            found["lost"] += 1
            return collapse.path
        except ConvergenceError:
            found["not solved"] += 1
        except (UnstableError, NoEquilibriumError, ValueError):
            found["refused"] += 1
        return None

    support = next(b.support for b in model.blocks if b.support)
    top = max((b for b in model.blocks if b.support is None), key=lambda b: float(b.polygon[:, 1].max()))
    control, size = top.centroid, model.size
    with patch.object(STEPS, "find_equilibrium", watched):
        way = (0.05 * size, -0.05 * size)
        moved = path(lambda: pushdown(model, support, way, increment=0.0125 * size, contacts="elastic"))
        for state in (None, getattr(moved, "final", None)):
            path(lambda state=state: pushover(model, control, "+x", "elastic", 0.02 * size, state, until=0.5))
    return found


def table(count: int = 100) -> str:
    """Markdown: each bed a row."""
    lines = [f"| bed | {' | '.join(COLUMNS)} |", "|---" * (len(COLUMNS) + 1) + "|"]
    totals = {name: Counter[str]() for name in BEDS}
    for _, model in structures(count):
        for name, segments in BEDS.items():
            totals[name] += counted(replace(model, segments_per_joint=segments))
    for name, total in totals.items():
        lines.append(f"| {name} | {' | '.join(str(total[column]) for column in COLUMNS)} |")
    return "\n".join(lines)


def same_peak(model: Assembly) -> float:
    """By how much 32 points are stronger than the exact bed, of the exact one's largest multiplier."""
    top = max((b for b in model.blocks if b.support is None), key=lambda b: float(b.polygon[:, 1].max()))
    peaks = [
        pushover(
            Assembly(model.blocks, segments), top.centroid, "+x", "elastic", 0.01 * model.size, until=0.9
        ).multiplier.max()
        for segments in BEDS.values()
    ]
    return float(np.diff(peaks)[0] / peaks[0])


if __name__ == "__main__":
    print(table())
