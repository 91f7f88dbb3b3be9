"""The tables of studies: scenarios, sensitivity, ranges of what scatters, discretisation errors, identification."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

from assessment.report.tables import Found, capacities, moves, pushes, table, without
from assessment.results.schema import Explanation, Part, Results, Scenarios, Sensitivity, named
from assessment.results.summary import taken_to_collapse, told_of
from assessment.results.table import Row, Table, cells, quoted_check, weaker

CAPACITY = "collapses alpha_0 alpha_u d_0_m limit_state a_g_g zeta_E"
SCENARIOS = f"state movement_m direction {CAPACITY} reduction ultimate_rigid_m ultimate_elastic_m worst"
SENSITIVITY = f"state property factor direction {CAPACITY}"
ROUNDING = 1e-6  # of a capacity: what the solver may leave of a difference that is none
RANGE = "_range"  # behind the name of a quantity, in the schema: the ends of its range
HYPOTHESES = "hypothesis unknowns chi_squared degrees_of_freedom chi_squared_probability aic told_apart"
MOVEMENTS = """hypothesis support displacement_x_m x_error_m displacement_z_m z_error_m
rotation_mrad rotation_error_mrad"""
MEASUREMENTS = """hypothesis number measurement measured_kind x_m z_m unit
measured sigma predicted residual residual_in_sigma"""


@dataclass(frozen=True)
class Bar:
    """A state's capacity a_g with a property lower, as in the project and higher; None: not known.

    `swing_g` spans the three, None where one of them is not known.
    """

    state: str
    property: str
    low_factor: Annotated[float, named("Fattore basso|Low factor", unit="")]
    high_factor: Annotated[float, named("Fattore alto|High factor", unit="")]
    a_g_low_g: Annotated[float | None, named("a_g (fattore basso)|a_g (low factor)", ground="rock")]
    a_g_base_g: Annotated[float | None, named("a_g (valore assegnato)|a_g (as given)", ground="rock")]
    a_g_high_g: Annotated[float | None, named("a_g (fattore alto)|a_g (high factor)", ground="rock")]
    swing_g: Annotated[float | None, named("Escursione|Swing", null="not_determined")]

    def capacities(self) -> list[float]:
        """Those of the three capacities that are known, g."""
        return [a_g for a_g in (self.a_g_low_g, self.a_g_base_g, self.a_g_high_g) if a_g is not None]


def reported_studies(results: Results) -> list[Table]:
    """Return the tables of the report: the scenarios without what holds for all of them, and the tornado."""
    found = scenarios(results)
    standing = not any(each.get("collapses") for each in found.rows)
    return [without(found, "limit_state", "worst", *["collapses"] * standing), tornado(results)]


@table("scenarios", SCENARIOS)
def scenarios(results: Results) -> Found:
    """List every point of every scenario; the ultimate movements stand with the whole movement.

    `reduction` is that of a_g, of α0 where there is no assessment; `worst` marks the lowest of them.
    """
    found = results.scenarios
    for point in found.points if found else ():
        row = _of_study(found) | {"worst": found is not None and point == found.worst}
        if point.share == 1.0 and point.state in taken_to_collapse(results.echo):
            paths = results.states[point.state].pushdown
            row |= {f"ultimate_{contacts}_m": path.ultimate_movement_m for contacts, path in paths.items()}
        yield row, point


@table("sensitivity", SENSITIVITY)
def sensitivity(results: Results) -> Found:
    """List every run of the sensitivity: state, property and its factor, direction, capacity."""
    found = results.sensitivity
    for run in found.runs if found else ():
        yield _of_study(found), run


def _of_study(study: Scenarios | Sensitivity | None) -> Row:
    return {"limit_state": study.limit_state} if study and study.limit_state else {}


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
        # of the weaker direction, in each run anew; None where one is not known
        base = weaker(check.a_g_g if check else None for check in checks)
        of_state = []
        for name in dict.fromkeys(run.property for run in own):
            of_property = [run for run in own if run.property == name]
            low, high = sorted({run.factor for run in of_property})
            least, most = (weaker(r.a_g_g for r in of_property if r.factor == each) for each in (low, high))
            known = [value for value in (least, base, most) if value is not None]
            swing = max(known) - min(known) if len(known) == 3 else None
            if swing is not None and swing <= ROUNDING * max(known):  # nothing but rounding
                swing = 0.0
            of_state.append(Bar(state, name, low, high, least, base, most, swing))
        found += sorted(of_state, key=lambda bar: -float("inf") if bar.swing_g is None else -bar.swing_g)
    return found


tornado = table("tornado", Bar)(bars)


@table("static_ranges", "state direction contacts limit_state quantity value lowest highest")
def static_ranges(results: Results) -> Found:
    """List the ranges of what scatters, in units of results.json, state by state: pushdowns, pushovers, checks."""
    parts: list[tuple[Row, Part]] = [*moves(results), *pushes(results)]
    for name, direction, capacity in capacities(results):
        where = {"state": name, "direction": direction}
        parts += [(where | {"limit_state": limit}, check) for limit, check in capacity.checks.items()]
    for name in results.states:
        for where, part in (each for each in parts if each[0]["state"] == name):
            numbers = cells(part, type(part).model_fields)
            for quantity in (key.removesuffix(RANGE) for key in numbers if key.endswith(RANGE)):
                ends = dict(zip(("lowest", "highest"), numbers[f"{quantity}{RANGE}"], strict=True))
                yield where | {"quantity": quantity, "value": numbers[quantity]} | ends


# estimated errors: of capacities by state and direction, of peak displacements, of the PGA at collapse by record
convergence = table(
    "convergence",
    "state direction halvings alpha_0_error d_0_error_m alpha_u_error a_g_error_g relative_error met",
)(lambda results: [each for each in results.convergence.rows if each.direction])
history_convergence = table(
    "history_convergence",
    "state record halvings order peak_displacement_error_m peak_displacement_scatter_m relative_error "
    "relative_scatter met",
)(lambda results: [each for each in results.convergence.rows if each.record])
incremental_convergence = table(
    "incremental_convergence", "state record order pga_collapse_error_g relative_error met"
)(lambda results: results.convergence.incremental or [])


def reported_identification(results: Results) -> list[Table]:
    """Return the tables of the report: of movements and measurements those of hypotheses not told from the best."""
    told = [each.hypothesis for each in told_of(results.identification)] if results.identification else []

    def of_told(found: Table) -> Table:
        rows = [row for row in found.rows if row["hypothesis"] in told]
        return replace(found, rows=sorted(rows, key=lambda row: told.index(row["hypothesis"])))

    gone = ("x_m", "z_m", "residual", *["hypothesis"] * (len(told) < 2))
    fitted = without(of_told(measurements(results)), *gone)
    return [hypotheses(results), of_told(identified_movements(results)), fitted]


def _explanations(results: Results) -> Sequence[Explanation]:
    return results.identification.hypotheses if results.identification else []


@table("hypotheses", HYPOTHESES)
def hypotheses(results: Results) -> Found:
    """List every hypothesis: how well it fits, with how many unknowns."""
    for each in _explanations(results):
        yield {"chi_squared_probability": each.probability, "told_apart": each.distinguished}, each


@table("identified_movements", MOVEMENTS)
def identified_movements(results: Results) -> Found:
    """List the movement of each support of each hypothesis; without error: not determined, or held."""
    for each in _explanations(results):
        for moved in each.movement:
            rotation = moved.rotation_standard_error_rad
            x, z = (moved.x_m, moved.x_standard_error_m), (moved.z_m, moved.z_standard_error_m)
            turn = 1e3 * moved.rotation_rad, None if rotation is None else 1e3 * rotation
            values = (each.hypothesis, moved.support, *x, *z, *turn)
            yield dict(zip(MOVEMENTS.split(), values, strict=True))


@table("measurements", MEASUREMENTS)
def measurements(results: Results) -> Found:
    """List every measurement beside what each hypothesis predicts; numbers are those of the drawing."""
    sites = results.identification.sites if results.identification else []
    for each in _explanations(results):
        for number, (row, site) in enumerate(zip(each.fit, sites, strict=True), 1):
            x, z = site.point_m
            where = {"hypothesis": each.hypothesis, "number": number, "measured_kind": row.kind}
            yield cells(row, MEASUREMENTS.split()) | where | {"x_m": x, "z_m": z}
