"""The tables of the scenarios side by side and of the sensitivity."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields

from assessment.results.echo import taken_to_collapse
from assessment.results.schema import Results
from assessment.results.schema.studies import Capacities, Scenarios, Sensitivity, SensitivityRun
from assessment.results.table import Row, Table, cells, quoted_check

CAPACITY = ("collapses", "alpha_0", "alpha_u", "d_0_m", "limit_state", "a_g_g", "zeta_E")
SCENARIOS = (
    *("state", "movement_m", "direction", *CAPACITY),
    *("reduction", "ultimate_rigid_m", "ultimate_elastic_m", "worst"),
)
SENSITIVITY = ("state", "property", "factor", "direction", *CAPACITY)
ROUNDING = 1e-6  # of a capacity: what the solver may leave of a difference that is none


@dataclass(frozen=True)
class Bar:
    """A state's capacity a_g with a property lower, as in the project and higher; None: not known.

    `swing_g` spans the three, None where one of them is not known.
    """

    state: str
    property: str
    low_factor: float
    high_factor: float
    a_g_low_g: float | None
    a_g_base_g: float | None
    a_g_high_g: float | None
    swing_g: float | None

    def capacities(self) -> list[float]:
        """Those of the three capacities that are known, g."""
        return [a_g for a_g in (self.a_g_low_g, self.a_g_base_g, self.a_g_high_g) if a_g is not None]

    def ends(self) -> dict[str, tuple[float, float | None]]:
        """Factor and capacity (g) at the "low" and the "high" end."""
        return {"low": (self.low_factor, self.a_g_low_g), "high": (self.high_factor, self.a_g_high_g)}


TORNADO = tuple(field.name for field in fields(Bar))


def study_tables(results: Results) -> list[Table]:
    """List all tables of the studies, long ones included."""
    return [scenarios(results), sensitivity(results), tornado(results)]


def reported_studies(results: Results) -> list[Table]:
    """Return the tables of the report: the scenarios without what holds for all of them, and the tornado."""
    table = scenarios(results)
    left_out = {"limit_state", "worst"} | (
        {"collapses"} - {key for each in table.rows for key in each if each[key]}
    )
    return [Table(table.name, table.rows, tuple(c for c in SCENARIOS if c not in left_out)), tornado(results)]


def scenarios(results: Results) -> Table:
    """List every point of every scenario; the ultimate movements stand with the whole movement.

    `reduction` is that of a_g, of α0 where there is no assessment; `worst` marks the lowest of them.
    """
    found, rows = results.scenarios, []
    if not found:
        return Table("scenarios", [], SCENARIOS)
    for point in found.points:
        judged = _judged(point, SCENARIOS, found) | {"worst": point == found.worst}
        if point.share == 1.0 and point.state in taken_to_collapse(results.echo):
            paths = results.states[point.state].pushdown
            judged |= {f"ultimate_{contacts}_m": path.ultimate_movement_m for contacts, path in paths.items()}
        rows.append(judged)
    return Table("scenarios", rows, SCENARIOS)


def sensitivity(results: Results) -> Table:
    """List every run of the sensitivity: state, property and its factor, direction, capacity."""
    found = results.sensitivity
    rows = [_judged(run, SENSITIVITY, found) for run in found.runs] if found else []
    return Table("sensitivity", rows, SENSITIVITY)


def tornado(results: Results) -> Table:
    """Set the bars of the tornado in a table."""
    return Table("tornado", [asdict(each) for each in bars(results)], TORNADO)


def bars(results: Results) -> list[Bar]:
    """Set the capacity a_g of each state with a property lower and higher beside that of the project.

    The capacity of a state is that of its weaker direction, in each run anew; None where one of them is not known.
    `swing_g` spans the three capacities. The properties of a state stand in the order of their swing.
    """
    runs = results.sensitivity.runs if results.sensitivity else []
    found: list[Bar] = []
    for state in dict.fromkeys(run.state for run in runs):
        own = [run for run in runs if run.state == state]
        directions = dict.fromkeys(run.direction for run in own)
        checks = [quoted_check(results.states[state].capacity.get(direction)) for direction in directions]
        base = _weaker(check.a_g_g if check else None for check in checks)
        of_state = [_bar(state, name, own, base) for name in dict.fromkeys(run.property for run in own)]
        found += sorted(of_state, key=lambda bar: -float("inf") if bar.swing_g is None else -bar.swing_g)
    return found


def _bar(state: str, name: str, runs: Iterable[SensitivityRun], base: float | None) -> Bar:
    of_property = [run for run in runs if run.property == name]
    low, high = sorted({run.factor for run in of_property})
    at = {factor: _weaker(run.a_g_g for run in of_property if run.factor == factor) for factor in (low, high)}
    known = [value for value in (at[low], base, at[high]) if value is not None]
    return Bar(state, name, low, high, at[low], base, at[high], _swing(known) if len(known) == 3 else None)


def _swing(capacities: list[float]) -> float:
    """Return the span of the capacities, none where nothing but rounding tells them apart."""
    span = max(capacities) - min(capacities)
    return span if span > ROUNDING * max(capacities) else 0.0


def _weaker(capacities: Iterable[float | None]) -> float | None:
    values = list(capacities)
    known = [value for value in values if value is not None]
    return min(known) if known and len(known) == len(values) else None


def _judged(numbers: Capacities, columns: Sequence[str], study: Scenarios | Sensitivity) -> Row:
    """Return a row with the limit state of its capacity, where there is an assessment."""
    limit = study.limit_state
    return cells(numbers, columns) | ({"limit_state": limit} if limit else {})
