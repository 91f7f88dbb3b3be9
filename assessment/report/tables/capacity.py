"""Tables of the assessment: capacity curves, checks, spectra, chosen mechanisms, and every step of the calculation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from assessment.ntc.limit_states import CHECKS, LINEAR
from assessment.results.schema import Results, State
from assessment.results.schema.checks import Capacity, Count, Direction, GivenMechanism
from assessment.results.schema.model import Line
from assessment.results.schema.part import Part, present
from assessment.results.table import Row, Table, cells, reduction
from assessment.results.undetermined import checks_asked, undetermined

VERIFICATION: tuple[str, ...] = (
    "d_star_m",
    "a_star_g",
    "T_s",
    "a_g_g",
    "demand_a_g_g",
    "pga_g",
    "demand_pga_g",
    "zeta_E",
    "verified",
    "return_period_years",
    "governing",
    "mechanism",
)
SCALINGS = ("a_g_g", "pga_g", "demand_pga_g", "zeta_E", "return_period_years")
OTHER_SCALING = "other_scaling"  # SLV by the way of scaling that the checks did not take
NOMINAL = "nominal"  # the check without confidence factor that is compared with a dynamic capacity
VERTICAL = "vertical"  # the linear check with the vertical component
BESIDE = (VERTICAL, OTHER_SCALING, NOMINAL)
SPECTRUM = ("limit_state", "T_s", "S_e_g", "S_De_m", "damping", "damped_S_e_g", "damped_S_De_m")
ACTION = (
    "limit_state",
    "kind",
    "return_period_years",
    "a_g_g",
    "pga_g",
    "F0",
    "Tc_star_s",
    "soil",
    "topography",
    "S",
    "T_B_s",
    "T_C_s",
    "T_D_s",
)
CHOSEN = (
    "mechanism",
    "state",
    "direction",
    "moving_weight_kN",
    "alpha_0_given",
    "alpha_0_limit",
    "ratio",
    "e_star",
    "a_0_star_g",
    "refused",
)
LINEAR_CHECK = (
    "state",
    "direction",
    "limit_state",
    "mechanism",
    "alpha_onset",
    "e_star",
    "a_0_star_g",
    "demand_a_star_g",
    "ratio",
    "verified",
)
CHOSEN_CHECK = (
    "d_star_m",
    "a_star_g",
    "T_s",
    "a_g_g",
    "demand_a_g_g",
    "zeta_E",
    "verified",
    "return_period_years",
)


def capacity_curves(results: Results) -> Table:
    """List the points of every capacity curve in spectral coordinates."""
    rows = [
        {"state": name, "direction": direction, "d_star_m": d_star, "a_star_g": a_star}
        for name, direction, capacity in capacities(results)
        for d_star, a_star in zip(capacity.curve.d_star_m, capacity.curve.a_star_g, strict=True)
    ]
    return Table("capacity", rows, ("state", "direction", "d_star_m", "a_star_g"))


@dataclass(frozen=True)
class SummaryLine:
    """A quantity in one direction, of a check where `limit_state` is not empty: the value of each state that has it.

    Null: not known, though asked for.
    """

    direction: Direction
    quantity: str
    limit_state: str
    values: Mapping[str, float | None]

    def reduction(self, state: str) -> float | None:
        """Return 1 − settled/original: positive where the movement costs capacity; None where one is not known."""
        return reduction(self.values.get("original"), self.values.get(state))


def summary(results: Results) -> Table:
    """Return the quantities of the paper's Table 1 per direction, a column per state, and the reductions."""
    rows: list[Row] = []
    for line in (line for direction in directions(results) for line in summary_lines(results, direction)):
        settled = [name for name in line.values if name != "original"]
        rows.append(
            {"direction": line.direction, "quantity": line.quantity, "limit_state": line.limit_state}
            | dict(line.values)
            | {f"reduction: {name}": line.reduction(name) for name in settled}
        )
    columns = [column for name in results.states for column in _with_reduction(name)]
    return Table("summary", rows, ("direction", "quantity", "limit_state", *columns))


def verification(results: Results) -> Table:
    """List the checks of every state and direction: what each limit state bears and what governs it.

    Null: there is no capacity to check, in a direction that was asked for.
    """
    rows: list[Row] = []
    for name, state in results.states.items():
        for direction, capacity in state.capacity.items():
            rows += [
                {"state": name, "direction": direction, "limit_state": limit}
                | cells(check, VERIFICATION)
                | {"mechanism": mechanism_text(capacity.mechanism)}
                for limit, check in capacity.checks.items()
            ]
        for direction in undetermined(results).get(name, ()):
            rows += [
                {"state": name, "direction": direction, "limit_state": limit} | _not_made(results, limit)
                for limit in checks_asked(results)
            ]
    columns = VERIFICATION
    if all(each.get("return_period_years") is None for each in rows):  # no hazard curve to read it from
        columns = tuple(column for column in VERIFICATION if column != "return_period_years")
    return Table("verification", rows, ("state", "direction", "limit_state", *columns))


def _not_made(results: Results, check: str) -> Row:
    """Return the cells of a check without capacity: null, but for the demand."""
    demand = (results.spectra or {}).get(check.partition(" ")[0])
    found: Row = {"a_g_g": None, "zeta_E": None, "verified": None}
    if demand is None:
        return found
    found["demand_a_g_g"] = demand.a_g_g
    return found | ({} if demand.pga_g is None else {"pga_g": None, "demand_pga_g": demand.pga_g})


def mechanism_text(mechanism: Count) -> str:
    """Return a mechanism as hinges + sliding joints."""
    return f"{mechanism.hinges} + {mechanism.sliding_joints}"


def spectrum(results: Results) -> Table:
    """List the points of the demand spectra: at 5 % damping and at that of the check."""
    rows = [
        {"limit_state": limit, "damping": demand.damping, "T_s": T, "S_e_g": S_e, "S_De_m": S_De}
        | {"damped_S_e_g": damped_S_e, "damped_S_De_m": damped_S_De}
        for limit, demand in (results.spectra or {}).items()
        for T, S_e, S_De, damped_S_e, damped_S_De in zip(
            demand.T_s, demand.S_e_g, demand.S_De_m, demand.damped_S_e_g, demand.damped_S_De_m, strict=True
        )
    ]
    return Table("spectrum", rows, SPECTRUM)


def action(results: Results) -> Table:
    """List the parameters of the demand spectra."""
    rows = [
        {"limit_state": limit} | cells(demand, ACTION) for limit, demand in (results.spectra or {}).items()
    ]
    return Table("action", rows, ACTION)


def chosen_mechanisms(results: Results) -> Table:
    """List the mechanisms that the user chose beside limit analysis; refused ones with the reason."""
    rows: list[Row] = []
    for given in results.mechanisms or []:
        alpha_0, limit = given.alpha_0, given.alpha_0_limit
        found: Row = {"mechanism": given.name} | cells(given, CHOSEN)
        found |= {
            "alpha_0_given": alpha_0,
            "ratio": alpha_0 / limit if alpha_0 is not None and limit else None,
        }
        rows.append(present(found))
    return Table("chosen_mechanisms", rows, CHOSEN)


def chosen_checks(results: Results) -> Table:
    """List the checks of the mechanisms that the user chose, linear and, where their motion is known, nonlinear."""
    rows = [
        {"mechanism": given.name, "state": given.state, "limit_state": name}
        | present(cells(check, CHOSEN_CHECK))
        for given in results.mechanisms or []
        for name, check in given.checks.items()
    ]
    return Table("chosen_checks", rows, ("mechanism", "state", "limit_state", *CHOSEN_CHECK))


def linear_checks(results: Results) -> Table:
    """List the linear kinematic checks, of mechanisms found and chosen: a_0* against a_g S/q, or a_Z/q at height.

    They are of the mechanism that is activated first, in the configuration of its state.
    """
    rows = [
        {"state": name, "direction": direction, "limit_state": limit, "mechanism": mechanism}
        | {"alpha_onset": check.alpha_0, "e_star": check.e_star, "a_0_star_g": check.a_star_g}
        | {"demand_a_star_g": check.demand_a_star_g, "ratio": check.zeta_E, "verified": check.verified}
        for name, direction, mechanism, found in _mechanisms_activated(results)
        for limit, check in found.checks.items()
        if limit in LINEAR and check.demand_a_star_g is not None
    ]
    return Table("linear_checks", rows, LINEAR_CHECK)


def _mechanisms_activated(
    results: Results,
) -> Iterator[tuple[str, Direction, str, Capacity | GivenMechanism]]:
    """Yield state, direction, name and checks of every mechanism: what is activated first, then those chosen."""
    for name, direction, capacity in capacities(results):
        pushed = results.states[name].pushover.get(direction)
        first = pushed.rigid.onset if pushed and pushed.rigid else None
        count = (
            Count(hinges=first.hinges, sliding_joints=len(first.sliding_joints))
            if first
            else capacity.mechanism
        )
        yield name, direction, mechanism_text(count), capacity
    for given in results.mechanisms or []:
        if given.direction:
            yield given.state, given.direction, given.name, given


def scalings(results: Results) -> Table:
    """Set the capacity at SLV by both ways of scaling side by side; `counts`: the one that the checks took."""
    rows = [
        {"state": name, "direction": direction, "limit_state": "SLV", "scaling": scaling}
        | cells(check, SCALINGS)
        | {"counts": check.used}
        for name, direction, capacity in capacities(results)
        for scaling, check in (capacity.scalings or {}).items()
    ]
    return Table("scalings", rows, ("state", "direction", "limit_state", "scaling", *SCALINGS, "counts"))


def traces(found: Capacity | GivenMechanism) -> Iterator[tuple[str, list[Line]]]:
    """Yield the traces of a direction or of a chosen mechanism: "capacity" for what its checks share, then theirs."""
    if found.trace:
        yield "capacity", found.trace
    for limit, check in found.checks.items():
        if check.trace:
            yield limit, check.trace
    if isinstance(found, GivenMechanism):
        return
    if found.vertical:
        yield VERTICAL, found.vertical.trace
    for scaling in (found.scalings or {}).values():
        if scaling.trace:
            yield OTHER_SCALING, scaling.trace
    if found.nominal and found.nominal.trace:
        yield NOMINAL, found.nominal.trace


def trace(results: Results) -> Table:
    """List every step of every calculation: formula, numbers put in, result and paragraph."""
    rows = [
        {
            "state": name,
            "direction": direction,
            "part": part,
            **cells(step, ("symbol", "formula", "result", "unit", "paragraph")),
            "inputs": "; ".join(f"{symbol}={value!r}" for symbol, value in step.inputs.items()),
        }
        for name, direction, part, steps in _all_traces(results)
        for step in steps
    ]
    columns = ("state", "direction", "part", "symbol", "formula", "inputs", "result", "unit", "paragraph")
    return Table("trace", rows, columns)


def _all_traces(results: Results) -> Iterator[tuple[str, str, str, list[Line]]]:
    for limit, demand in (results.spectra or {}).items():
        yield "", "", f"spectrum {limit}", demand.trace or []
    for name, direction, capacity in capacities(results):
        for part, steps in traces(capacity):
            yield name, direction, part, steps
    for name, state in results.states.items():
        yield name, "", "indices", state.indices.trace if state.indices else []
    yield "", "", "knowledge", results.knowledge.trace if results.knowledge else []
    for given in results.mechanisms or []:
        for part, steps in traces(given):
            yield given.state, given.direction or "", f"{given.name}: {part}", steps


def directions(results: Results) -> list[Direction]:
    """Return the directions in which any state was pushed."""
    return sorted({direction for state in results.states.values() for direction in state.pushover})


def summary_lines(results: Results, direction: Direction) -> Iterator[SummaryLine]:
    """Yield every quantity of the summary that any state has in a direction, and what each check asked for bears.

    A state without capacity there has null.
    """
    of_states = [list(_sources(state, direction)) for state in results.states.values()]
    missing = [name for name, without in undetermined(results).items() if direction in without]
    asked = checks_asked(results)
    for sources in zip(*of_states, strict=True):
        quantity, limit, _ = sources[0]
        values: dict[str, float | None] = {}
        for name, (_, _, part) in zip(results.states, sources, strict=True):
            if part is not None and (found := cells(part, [quantity])):
                values[name] = found[quantity]
        if limit in asked and (values or quantity in {"a_g_g", "zeta_E"}):
            values |= dict.fromkeys((name for name in missing if name not in values), None)
        if values:
            yield SummaryLine(direction, quantity, limit, values)


def _sources(state: State, direction: Direction) -> Iterator[tuple[str, str, Part | None]]:
    """Yield quantity, limit state and what has it in a state: the same of every state, None where it is not there."""
    pushover, capacity = state.pushover.get(direction), state.capacity.get(direction)
    rigid, elastic = (pushover.rigid, pushover.elastic) if pushover else (None, None)
    mechanism, checks = rigid and rigid.mechanism, capacity.checks if capacity else {}
    yield "alpha_0", "", rigid
    yield "alpha_u", "", elastic
    yield "alpha_y", "", elastic
    yield "d_y_m", "", elastic
    yield "d_0_m", "", rigid
    yield "e_star", "", mechanism
    yield "gamma_star", "", mechanism
    yield "T_0_s", "", capacity if capacity and capacity.T_0_s is not None else None  # a rigid curve has none
    for quantity in ("d_star_m", "T_s", "a_g_g", "zeta_E"):
        for limit in CHECKS:
            yield quantity, limit, checks.get(limit)


def _with_reduction(name: str) -> tuple[str, ...]:
    return (name,) if name == "original" else (name, f"reduction: {name}")


def capacities(results: Results) -> Iterator[tuple[str, Direction, Capacity]]:
    """Yield state, direction and capacity wherever there is one."""
    for name, state in results.states.items():
        for direction, capacity in state.capacity.items():
            yield name, direction, capacity
