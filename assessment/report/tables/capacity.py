"""Tables of the assessment: curves, checks, spectra, chosen mechanisms, every step of the calculation, indices."""

from collections.abc import Iterator

from assessment.ntc.tables import EXCEEDANCE, LINEAR, USE_COEFFICIENT, return_period
from assessment.report.tables import Curves, Found, capacities, curves, table
from assessment.results.schema import Capacity, Count, Direction, GivenMechanism, Line, Results, present
from assessment.results.summary import checks_asked, determined_indices, undetermined
from assessment.results.table import ORIGINAL, Row, cells, reduction

VERIFICATION = """d_star_m a_star_g T_s a_g_g demand_a_g_g pga_g demand_pga_g zeta_E verified
return_period_years governing"""
CHOSEN = "state direction moving_weight_kN alpha_0_limit e_star a_0_star_g refused"
SAFETY = "zeta_SLV zeta_SLC ratio_SLD T_SLV_years T_R_SLV_years I_S f_a acceptable_nominal_life_years"
RISK = "IS_V IS_V_class PAM PAM_class risk_class"
HEADLINES = ("zeta_SLV", "acceptable_nominal_life_years", "IS_V", "risk_class")
CHECKS = f"state direction limit_state {VERIFICATION.replace('return', '?return')} reduction mechanism"
OWN = "mechanism state direction moving_weight_kN alpha_0_given alpha_0_limit ratio e_star a_0_star_g refused"
ACTIVE = "state direction limit_state mechanism alpha_onset e_star a_0_star_g demand_a_star_g ratio verified"
ACTION = "kind return_period_years a_g_g pga_g F0 Tc_star_s soil topography S T_B_s T_C_s T_D_s"


@curves("capacity", "state direction d_star_m a_star_g")
def capacity_curves(results: Results) -> Curves:
    """List the points of every capacity curve in spectral coordinates."""
    for name, direction, capacity in capacities(results):
        yield (name, direction), (capacity.curve.d_star_m, capacity.curve.a_star_g)


@curves("spectrum", "limit_state T_s S_e_g S_De_m damping damped_S_e_g damped_S_De_m")
def spectrum(results: Results) -> Curves:
    """List the points of the demand spectra: at 5 % damping and at that of the check."""
    for limit, each in (results.spectra or {}).items():
        damped = [each.damping] * len(each.T_s), each.damped_S_e_g, each.damped_S_De_m
        yield (limit,), (each.T_s, each.S_e_g, each.S_De_m, *damped)


@table("vertical", "state direction a_v_g alpha_0 a_0_star_g demand_a_star_g ratio verified")
def vertical(results: Results) -> Found:
    """List the linear checks at SLV with the vertical component of the seismic action."""
    for name, direction, capacity in capacities(results):
        if capacity.vertical:
            yield {"state": name, "direction": direction}, capacity.vertical


@table("summary", "state direction alpha_0 alpha_u alpha_y d_y_m d_0_m e_star gamma_star T_0_s reduction")
def summary(results: Results) -> Found:
    """List the quantities of the paper's Table 1 of every state and direction; `reduction`: of α_0, else of α_u."""
    for row in results.summary.rows:
        state, direction = results.states[row.state], row.direction
        if direction and (pushed := state.pushover.get(direction)):
            found = cells(pushed.rigid, ("alpha_0", "d_0_m")) if pushed.rigid else {}
            found |= cells(pushed.rigid.mechanism, ("e_star", "gamma_star")) if pushed.rigid else {}
            found |= cells(pushed.elastic, ("alpha_u", "alpha_y", "d_y_m")) if pushed.elastic else {}
            found |= cells(state.capacity[direction], ["T_0_s"]) if direction in state.capacity else {}
            found |= {"reduction": row.alpha_loss} if "alpha_loss" in row.model_fields_set else {}
            yield {"state": row.state, "direction": direction} | found


@table("verification", CHECKS)
def verification(results: Results) -> Found:
    """List the checks of every state and direction: what each limit state bears and what governs it.

    Null: there is no capacity to check, in a direction that was asked for. `reduction`: of a_g from the original state.
    """
    found = [check for _, _, each in capacities(results) for check in each.checks.values()]
    known = any(check.return_period_years for check in found)  # by the hazard curve
    columns = [key for key in VERIFICATION.split() if known or key != "return_period_years"]
    drawn = results.states.get(ORIGINAL)
    for name, state in results.states.items():
        for direction, capacity in state.capacity.items():
            for limit, check in capacity.checks.items():
                row: Row = {"state": name, "direction": direction, "limit_state": limit}
                row |= cells(check, columns) | {"mechanism": mechanism_text(capacity.mechanism)}
                original = drawn.capacity.get(direction) if drawn else None
                if name != ORIGINAL and original and limit in original.checks:
                    row["reduction"] = reduction(original.checks[limit].a_g_g, check.a_g_g)
                yield row
        for direction in undetermined(results).get(name, ()):
            for limit in checks_asked(results):
                row = {"state": name, "direction": direction, "limit_state": limit}
                row |= {"a_g_g": None, "zeta_E": None, "verified": None}
                if demand := (results.spectra or {}).get(limit.partition(" ")[0]):
                    row["demand_a_g_g"] = demand.a_g_g
                    row |= {} if demand.pga_g is None else {"pga_g": None, "demand_pga_g": demand.pga_g}
                yield row


def mechanism_text(mechanism: Count) -> str:
    """Return a mechanism as hinges + sliding joints."""
    return f"{mechanism.hinges} + {mechanism.sliding_joints}"


@table("action", f"limit_state ?P_VR {ACTION}")
def action(results: Results) -> Found:
    """List the parameters of the demand spectra; P_VR and T_R where a reference life is known."""
    site = (results.echo.assessment or {}).get("site") or {}
    life, use = site.get("nominal_life_years"), site.get("use_class")
    for limit, demand in (results.spectra or {}).items():
        row: Row = {"limit_state": limit} | present(cells(demand, ACTION.split()))
        if life and use in USE_COEFFICIENT and demand.kind != "record":
            row = {"P_VR": EXCEEDANCE[limit], "return_period_years": return_period(limit, life, use)} | row
        yield row


@table("chosen_mechanisms", OWN)
def chosen_mechanisms(results: Results) -> Found:
    """List the mechanisms that the user chose beside limit analysis; refused ones with the reason."""
    for given in results.mechanisms or []:
        own, limit = given.alpha_0, given.alpha_0_limit
        found = {"mechanism": given.name, "alpha_0_given": own} | cells(given, CHOSEN.split())
        yield present(found | {"ratio": own / limit if own is not None and limit else None})


@table("chosen_checks", f"mechanism state limit_state {VERIFICATION}")
def chosen_checks(results: Results) -> Found:
    """List the checks of the mechanisms that the user chose, linear and, where their motion is known, nonlinear."""
    for given in results.mechanisms or []:
        for name, check in given.checks.items():
            where = {"mechanism": given.name, "state": given.state, "limit_state": name}
            yield where | present(cells(check, VERIFICATION.split()))


@table("linear_checks", ACTIVE)
def linear_checks(results: Results) -> Found:
    """List the linear kinematic checks, of mechanisms found and chosen: a_0* against a_g S/q, or a_Z/q at height.

    They are of the mechanism that is activated first, in the configuration of its state.
    """
    activated: list[tuple[str, Direction, str, Capacity | GivenMechanism]] = []
    for name, direction, capacity in capacities(results):
        pushed, count = results.states[name].pushover.get(direction), capacity.mechanism
        if pushed and pushed.rigid and (first := pushed.rigid.onset):
            count = Count(hinges=first.hinges, sliding_joints=len(first.sliding_joints))
        activated.append((name, direction, mechanism_text(count), capacity))
    for given in results.mechanisms or []:
        activated += [(given.state, given.direction, given.name, given)] if given.direction else []
    for name, direction, mechanism, found in activated:
        where = {"state": name, "direction": direction, "mechanism": mechanism}
        for limit, check in found.checks.items():
            if limit in LINEAR and check.demand_a_star_g is not None:
                numbers = {"alpha_onset": check.alpha_0, "a_0_star_g": check.a_star_g, "ratio": check.zeta_E}
                yield where | {"limit_state": limit, "e_star": check.e_star} | numbers, check


def calculations(results: Results) -> Iterator[tuple[str, str, str, list[Line]]]:
    """Yield state, direction and part of every calculation with its steps; of a mechanism "name: part".

    "capacity" is what the checks of a direction share.
    """
    for limit, demand in (results.spectra or {}).items():
        yield "", "", f"spectrum {limit}", demand.trace or []
    found: list[tuple[str, str, str, Capacity | GivenMechanism]] = []
    found += [(name, direction, "", capacity) for name, direction, capacity in capacities(results)]
    found += [(each.state, each.direction or "", f"{each.name}: ", each) for each in results.mechanisms or []]
    for state, direction, prefix, of in found:
        steps = {"capacity": of.trace} | {limit: check.trace for limit, check in of.checks.items()}
        if isinstance(of, Capacity):
            beside = {"vertical": of.vertical, "nominal": of.nominal}
            steps |= {part: each.trace for part, each in beside.items() if each}
        for part, own in steps.items():
            if own:
                yield state, direction, f"{prefix}{part}", own
    for name, each in results.states.items():
        if each.indices:
            yield name, "", "indices", each.indices.trace
    if results.knowledge:
        yield "", "", "knowledge", results.knowledge.trace


@table("trace", "state direction part symbol formula inputs result unit paragraph")
def trace(results: Results) -> Found:
    """List every step of every calculation: formula, numbers put in, result and paragraph."""
    for state, direction, part, steps in calculations(results):
        for step in steps:
            inputs = "; ".join(f"{symbol}={value!r}" for symbol, value in step.inputs.items())
            yield {"state": state, "direction": direction, "part": part, "inputs": inputs}, step


def _indices(results: Results, columns: str) -> Iterator[Row]:
    """Yield the indices of every state; what is not known for want of a return period is left out.

    Null: the state has no capacity in a direction.
    """
    found = determined_indices(results).items()
    known = {name: present(cells(each, columns.split())) for name, each in found}
    told = {key for row in known.values() for key in row} | {"zeta_SLV", "IS_V"}
    nothing = dict.fromkeys(key for key in HEADLINES if key in told and key in columns.split())
    yield from ({"state": name} | known.get(name, nothing) for name in _states(results))


indices = table("indices", f"state {SAFETY}")(lambda results: _indices(results, SAFETY))
risk = table("risk", f"state {RISK}")(lambda results: _indices(results, RISK))


@table("interventions", "state use_class intervention ?zeta_before zeta_SLV required_zeta ?attained")
def interventions(results: Results) -> Found:
    """List ζ_E of every state and what each kind of intervention must reach (NTC 2018, §8.4).

    Of a strengthened state that follows from ζ_E before, and `attained` tells whether it is reached.
    """
    known = determined_indices(results)
    for name in _states(results):
        if found := known.get(name):
            row: Row = {"state": name} | cells(found, ("use_class", "zeta_SLV", "zeta_before"))
            for kind, least in present(found.required_zeta).items():
                reached = present({"attained": (found.attained or {}).get(kind)})
                yield row | {"intervention": kind, "required_zeta": least} | reached
        else:
            yield {"state": name, "zeta_SLV": None}


@table("knowledge", "parameter factor_component origin")
def knowledge(results: Results) -> Found:
    """List the components of F_C and the origin of each parameter, as given."""
    if found := results.knowledge:
        for name, value in found.components.items():
            yield {"parameter": name, "factor_component": value, "origin": found.origins.get(name, "")}
        for name, text in found.origins.items():
            if text and name not in found.components:
                yield {"parameter": name, "origin": text}


def _states(results: Results) -> list[str]:
    """Return the states with indices, and those that would have them had they a capacity in every direction."""
    known, missing = determined_indices(results), undetermined(results)
    assessment = results.echo.assessment or {}
    asked = bool(known) or ("site" in assessment and assessment.get("spectrum") != "record")
    return [name for name in results.states if name in known or (asked and name in missing)]
