"""What an analysis found and what is to be told of it; the accuracy that a project asks for, and its increments."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from assessment.project.project import Project
from assessment.project.schema import SettlementTable
from assessment.results.schema import WORST, Part, Quality, QualityRow, finite
from mechanics.messages import Message, headed

Value = TypeVar("Value")
Kind = TypeVar("Kind", bound=Part)


@dataclass
class Found(Generic[Value]):
    """The `value` that an analysis found; None: nothing, and the `failures` say why."""

    value: Value | None = None
    warnings: list[Message] = field(default_factory=list)  # what to know about the value
    failures: list[Message] = field(default_factory=list)
    quality: list[QualityRow] = field(default_factory=list)  # certificates of what was solved
    seconds: float = 0.0  # computing time
    scatters: bool = False  # whether the value turns on the last digits of the input: runs have a range

    def warn(self, title: str, *texts: Message) -> None:
        """Add warnings about what has that title."""
        self.warnings += [headed(title, text) for text in texts]

    def fail(self, title: str, reason: Message) -> None:
        """Add why what has that title has no value."""
        self.failures.append(headed(title, reason))


def as_part(kind: type[Kind], *found: object, **more: Any) -> Kind:
    """Return a part with the keys that what was `found` has, and `more`; null: not finite."""
    names = kind.model_fields.keys() - more.keys()
    values = {name: getattr(each, name) for each in found for name in names if hasattr(each, name)}
    for name, value in values.items():
        if isinstance(value, float):
            values[name] = finite(value)
        elif isinstance(value, tuple):
            values[name] = list(value)
    return kind(**values, **more)


SHOWN = 1.25  # ratio of successive differences below which they hardly shrink
FIRST_ORDER = 2.0  # ratio of a first-order method: a higher observed order is not relied on
# of α, of a_g in g and of the model's size: smaller values and differences are errors of the solver
NOISE = 1e-6
LEVELS = 3  # at least: two may agree by chance
FASTEST = 6.0  # largest ratio of differences that counts as convergence: second order has 4


@dataclass(frozen=True)
class Accuracy:
    """A relative `tolerance` of the estimated error (None: no error is estimated) and the most `halvings` allowed."""

    tolerance: float | None
    halvings: int


PRESETS = {"fast": Accuracy(None, 0), "standard": Accuracy(0.05, 2), "fine": Accuracy(0.01, 4)}
MOST_HALVINGS = 4  # for a tolerance given as a number


def accuracy_of(project: Project) -> Accuracy:
    """Return the preset of the project's key `accuracy`."""
    asked = project.accuracy
    return PRESETS[asked] if isinstance(asked, str) else Accuracy(asked, MOST_HALVINGS)


def observed_order(values: Sequence[float | None]) -> float | None:
    """Return the order of the last three values at steps h, h/2, h/4…; None: unknown, or they do not shrink like it."""
    if len(values) < LEVELS:
        return None
    a, b, c = values[-LEVELS:]
    if a is None or b is None or c is None or c == b:
        return None
    ratio = abs((b - a) / (c - b))
    return math.log2(ratio) if SHOWN <= ratio <= FASTEST else None


def in_increments(project: Project, factor: float) -> Project:
    """Return the project with increments `factor` times as large: a settlement has a whole number of equal ones."""
    pushover = project.pushover
    larger = pushover and pushover.model_copy(update={"increment_m": factor * pushover.increment_m})

    def divided(settlement: SettlementTable) -> SettlementTable:
        count = max(1, round(settlement.increments / factor))
        movement, rotation = max(map(abs, settlement.displacement_m)), abs(settlement.rotation_rad)
        shares = {"increment_m": movement / count, "increment_rad": rotation / count}
        return settlement.model_copy(update={key: share for key, share in shares.items() if share > 0.0})

    settlements = tuple(map(divided, project.settlements))
    return project.model_copy(update={"settlements": settlements, "pushover": larger})


def refined(project: Project, halvings: int) -> Project:
    """Return the project with the increments halved `halvings` times: exactly so many times as many."""
    return in_increments(project, 0.5**halvings) if halvings else project


def finest(project: Project, halvings: Mapping[str, int]) -> list[tuple[Project, SettlementTable]]:
    """Return each settlement, and the project, in the increments at which its state converged, by their `halvings`."""
    projects = [refined(project, halvings.get(each.name, 0)) for each in project.settlements]
    return [(each, each.settlements[number]) for number, each in enumerate(projects)]


def joined(state: str | None, stage: str, rows: Sequence[QualityRow]) -> QualityRow:
    """Return one row for the rows of several analyses."""
    lifting = sum(row.lifting or 0 for row in rows) or None
    solves = sum(row.solves for row in rows)
    return QualityRow(state=state, stage=stage, solves=solves, lifting=lifting, **_worst(rows))


def quality_of(rows: Sequence[QualityRow], warnings: Sequence[str]) -> Quality:
    """Return the certificates and the warnings of a run; null: no analysis has such a certificate."""
    worst, solves = dict.fromkeys(WORST) | _worst(rows), sum(row.solves for row in rows)
    return Quality(solves=solves, warnings=list(warnings), by_stage=list(rows), **worst)


def _worst(rows: Sequence[QualityRow]) -> dict[str, float]:
    """Return the worst certificates of some rows; motions have no penetration and no cone violation."""
    known = {key: [value for row in rows if (value := getattr(row, key)) is not None] for key in WORST}
    return {key: max(values) for key, values in known.items() if values}
