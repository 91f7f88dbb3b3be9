"""What is read off results: what was asked for, each state in each direction, what an identification found."""

import json
from collections.abc import Iterable
from math import inf
from typing import Any

from assessment.ntc.tables import INDEXED, SURFACE, farthest
from assessment.results import schema
from assessment.results.schema import CHECKS, Capacity, Direction, Mechanism, OtherLaw, Part, Pushovers
from assessment.results.schema.studies import Explanation, FittedMovement, Identification, ReadySettlement
from assessment.results.table import ORIGINAL, reduction, static_pga
from mechanics.messages import layer_key

EMPTY = schema.Summary(reference=SURFACE, governing=None, verified=None, rows=[])
"""Of results without any analysis."""
UNLIKELY = 0.05  # probability of a χ² as large, below which a movement explains nothing
UNMET = 9.0  # χ² of a measurement that is off by three standard deviations


def material(echo: schema.Echo, block: schema.DrawnBlock) -> dict[str, Any]:
    """Return what a block is made of and loaded by: keys of its region before those of its layer and of [material]."""
    own = {layer_key(name): table for name, table in (echo.layers or {}).items()}
    regions = {each["name"]: each for each in echo.region or ()}
    layer, region = own.get(layer_key(block.layer)), regions.get(block.region or "")
    return echo.material | schema.present(layer or {}) | schema.present(region or {})


def segments(echo: schema.Echo) -> list[int]:
    """Return the numbers of segments that joints are divided into, each once; of exact joints none."""
    tables = [echo.geometry, *(echo.layers or {}).values(), *(echo.region or ())]
    return sorted({table["segments_per_joint"] for table in tables if table.get("segments_per_joint")})


def coulomb(echo: schema.Echo) -> bool:
    """Return whether what slides does not lift."""
    return (echo.contacts or {}).get("sliding") == "coulomb"


def collisions(echo: schema.Echo) -> bool:
    """Return whether blocks that were apart may come to touch."""
    return bool((echo.contacts or {}).get("collisions", True))


def damped(echo: schema.Echo) -> bool:
    """Return whether joints of a motion have dashpots."""
    shaking = (*(echo.history or ()), echo.incremental or {}, echo.campaign or {})
    return any(each.get("damping_ratio") for each in shaking)


def taken_to_collapse(echo: schema.Echo) -> set[str]:
    """Return the settlements whose ultimate movement is to be found."""
    return {each["name"] for each in echo.settlements or () if each.get("to_collapse")}


def limit_states(echo: schema.Echo) -> list[str]:
    """Return the limit states of the project."""
    return list((echo.assessment or {}).get("limit_states", []))


def printed(echo: schema.Echo) -> dict[str, Any]:
    """Return the input to be printed: nominal life and use class only where the hazard is known to follow from them."""
    content = echo.model_dump(exclude_unset=True)
    assessment = echo.assessment or {}
    site = assessment.get("site") or {}
    typed = [site[limit] for limit in ("SLD", "SLV", "SLC") if site.get(limit)]
    if not typed or all(hazard.get("return_period_years") for hazard in typed):
        return content
    kept = {key: value for key, value in site.items() if key not in {"nominal_life_years", "use_class"}}
    return {**content, "assessment": {**assessment, "site": kept}}


def undetermined(results: schema.Results) -> dict[str, list[Direction]]:
    """Return by state the directions in which a capacity was asked for and none found; nothing of complete states."""
    if not results.echo.assessment:
        return {}
    asked = directions_asked(results)
    missing = {name: without(state.capacity, asked) for name, state in results.states.items()}
    return {name: directions for name, directions in missing.items() if directions}


def without(capacities: Iterable[Direction], asked: Iterable[Direction]) -> list[Direction]:
    """Return the directions asked for that are not among those with a capacity."""
    return [direction for direction in asked if direction not in set(capacities)]


def directions_asked(results: schema.Results) -> list[Direction]:
    """Return the directions of the pushover: those of the project file, then any other that a state was pushed in."""
    pushed = [direction for state in results.states.values() for direction in sorted(state.pushover)]
    return list(dict.fromkeys([*((results.echo.pushover or {}).get("directions") or ()), *pushed]))


def checks_asked(results: schema.Results) -> list[str]:
    """Return the checks of each direction: those that any has; where none has, those of the limit states."""
    capacities = [each for state in results.states.values() for each in state.capacity.values()]
    if made := {name for capacity in capacities for name in capacity.checks}:
        return [name for name in CHECKS if name in made]
    return [name for name in CHECKS if name.removesuffix(" linear") in limit_states(results.echo)]


def determined_indices(results: schema.Results) -> dict[str, schema.Indices]:
    """Return the indices of the states that have a capacity in every direction asked for."""
    found = schema.present({name: state.indices for name, state in results.states.items()})
    return {name: each for name, each in found.items() if name not in undetermined(results)}


def summary_of(results: schema.Results) -> schema.Summary:
    """Return the summary of every state and direction asked for, and where ζ_E is least."""
    asked: list[Direction | None] = [*directions_asked(results)]
    shaken = any(state.incremental.fragility for state in results.states.values())
    if not asked and shaken:
        asked = [None]
    limits = limit_states(results.echo)
    rows = [_row(results.states, name, way, limits) for name in results.states for way in asked]
    index = next((limit for limit in INDEXED if limit in limits), None)
    found = [
        schema.SummaryGoverning(state=row.state, direction=row.direction, limit_state=limit, zeta_E=ratio)
        for row in rows
        for limit, check in row.checks.items()
        if (ratio := check.zeta_E) is not None and row.direction is not None and limit == (index or limit)
    ]
    least = min(found, key=lambda each: each.zeta_E, default=None)
    verified = _all(row.verified for row in rows)
    return schema.Summary(reference=SURFACE, governing=least, verified=verified, rows=rows)


def _row(
    states: dict[str, schema.StateResults], name: str, direction: Direction | None, limits: Iterable[str]
) -> schema.SummaryRow:
    """Return the row of a state in a direction, its losses from the original state in the same direction."""

    def there(of: schema.StateResults | None) -> tuple[Capacity | None, Pushovers | None]:
        return (of.capacity.get(direction), of.pushover.get(direction)) if of and direction else (None, None)

    state, original = states[name], states.get(ORIGINAL) if name != ORIGINAL else None
    (capacity, pushed), (_, before) = there(state), there(original)
    checks = {limit: _counting(capacity, limit) for limit in limits}

    def change(of: schema.StateResults, limit: str) -> tuple[float | None, bool | None]:
        before, after = _counting(there(of)[0], limit), checks[limit]
        alike = before.check == after.check or limit not in INDEXED  # else one is linear, one is not
        lost = reduction(before.zeta_E, after.zeta_E) if alike else None
        return lost, None if lost is None else apart(before, after, "zeta_E")

    made = state.strengthening
    for limit, check in checks.items():
        if original:
            lost, distinct = change(original, limit)
            checks[limit] = check.replace(loss=lost, distinguishable=distinct)
        if made is not None and made.of in states:
            fallen, _ = change(states[made.of], limit)
            checks[limit] = checks[limit].replace(gain=None if fallen is None else -fallen)
    ratios = {limit: ratio for limit, check in checks.items() if (ratio := check.zeta_E) is not None}
    indexed = [limit for limit in INDEXED if limit in checks] or list(checks)
    row: dict[str, Any] = {"state": name, "direction": direction, "checks": checks}
    of = states.get(made.of) if made else state  # not reached: its configuration is that of the drawing
    row["reached"] = of is None or of.settlement is None or any(map(any, state.configuration))
    row["governing"] = min(ratios, key=lambda limit: ratios[limit], default=None)
    row["verified"] = _all(checks[limit].verified for limit in indexed)
    row["limit_state"] = farthest(capacity.checks) if capacity else None
    row["static_pga_g"] = static_pga(capacity)
    if pushed is not None:
        rigid, elastic = pushed.rigid, pushed.elastic
        row |= {"control": pushed.control, "run": pushed.run}
        row |= {"alpha_u": elastic.alpha_u} if elastic else {}
        if rigid is not None:
            row |= {"alpha_0": rigid.alpha_0, "d_0_m": rigid.d_0_m, "mechanism": _mechanism(rigid.mechanism)}
            if (law := rigid.other_law) is not None:
                row["other_law"] = OtherLaw(sliding=law.sliding, alpha_0=law.alpha_0)
        if before:
            alpha = "alpha_0" if before.rigid and rigid else "alpha_u"
            was, now = (before.rigid, rigid) if alpha == "alpha_0" else (before.elastic, elastic)
            if was and now:
                row["alpha_loss"] = reduction(getattr(was, alpha), getattr(now, alpha))
                row["alpha_distinguishable"] = apart(was, now, alpha)
    if capacity and capacity.alpha_0 is not None and capacity.other_law:
        row |= {"alpha_0": capacity.alpha_0, "other_law": capacity.other_law}
    if (fit := state.incremental.fragility) is not None:
        dynamic, loss = fit.pga_collapse_g, state.incremental.loss
        nominal = capacity.nominal.pga_g if capacity and capacity.nominal else None
        row |= {"dynamic_pga_g": dynamic, "static_nominal_pga_g": nominal}
        row["dynamic_to_static"] = dynamic / nominal if dynamic is not None and nominal else None
        if original is not None:
            row["dynamic_loss"] = loss.dynamic if loss else None
    return schema.SummaryRow(**row)


def apart(one: Part, other: Part, name: str) -> bool:
    """Return whether the ranges of a quantity do not overlap; one that does not scatter is its own range."""
    ranges = (getattr(each, f"{name}_range") or [getattr(each, name)] * 2 for each in (one, other))
    (low, high), (least, most) = ranges
    above, most = (inf if each is None else each for each in (high, most))
    return above < (least or 0.0) or most < (low or 0.0)


def _mechanism(found: Mechanism) -> schema.SummaryMechanism:
    slides, turns = len(found.sliding_joints), found.hinges
    alone = "overturning" if turns == 1 else "hinges"
    kind: Any = ("mixed" if turns else "sliding") if slides else alone
    weight = found.moving_weight_kN
    return schema.SummaryMechanism(kind=kind, hinges=turns, sliding_joints=slides, moving_weight_kN=weight)


def _counting(capacity: Capacity | None, limit: str) -> schema.SummaryCheck:
    """Return the check that counts at a limit state; without numbers where none has a ratio."""
    made = capacity.checks if capacity else {}
    names = [name for name in (limit, f"{limit} linear", f"{limit} elastic") if name in made]  # its own first
    known = [(ratio, name) for name in names if (ratio := made[name].zeta_E) is not None]
    if not known:
        return schema.SummaryCheck(check=limit, zeta_E=None, verified=None)
    # at SLV the linear check stands in for the nonlinear one
    ratio, name = known[0] if limit in INDEXED else min(known, key=lambda each: each[0])
    found = schema.SummaryCheck(check=name, zeta_E=ratio, verified=made[name].verified)
    return found.replace(zeta_E_range=each) if (each := made[name].zeta_E_range) else found


def _all(verified: Iterable[bool | None]) -> bool | None:
    """Whether all are true; None where none is false and one is not known, or there is none."""
    found = list(verified)
    if not found or (None in found and False not in found):
        return None
    return all(found)


def index_limit(results: schema.Results) -> str | None:
    """Return the limit state whose ratio is ζ_E: SLV, else SLC; without both the farthest one checked, None: none."""
    checked = list(dict.fromkeys(limit for row in results.summary.rows for limit in row.checks))
    return next((limit for limit in INDEXED if limit in checked), checked[-1] if checked else None)


def index_of(row: schema.SummaryRow, limit: str | None) -> schema.SummaryCheck | None:
    """Return the check of a row that is its index, None where it has no number."""
    check = row.checks.get(limit) if limit else None
    return check if check is not None and check.zeta_E is not None else None


def rows_of(results: schema.Results, state: str) -> list[schema.SummaryRow]:
    """Return the rows of a state."""
    return [row for row in results.summary.rows if row.state == state]


def least_row(results: schema.Results, state: str) -> schema.SummaryRow | None:
    """Return the row of a state with the least index, without any with the least multiplier; None: nothing is known."""
    limit = index_limit(results)
    known = [(check.zeta_E, row) for row in rows_of(results, state) if (check := index_of(row, limit))]
    known = known or [(row.alpha_0, row) for row in rows_of(results, state) if row.alpha_0 is not None]
    known = known or [(row.alpha_u, row) for row in rows_of(results, state) if row.alpha_u is not None]
    return min(known, key=lambda each: each[0] or 0.0)[1] if known else None


def settled(results: schema.Results) -> list[str]:
    """Return the states that a movement leads to, strengthened ones aside."""
    return [name for name, state in results.states.items() if state.settlement and not state.strengthening]


def worst_settled(results: schema.Results) -> str | None:
    """Return the settled state that bears least: one that was not reached, else of the least index or multiplier."""
    names = settled(results)
    fallen = [name for name in names if any(not row.reached for row in rows_of(results, name))]
    limit = index_limit(results)

    def borne(name: str) -> tuple[bool, float]:
        row = least_row(results, name)
        check = index_of(row, limit) if row else None
        value = check.zeta_E if check else row.alpha_0 if row else None
        return value is None, value or 0.0

    return fallen[0] if fallen else min(names, key=borne, default=None)


def best_of(found: Identification) -> Explanation | None:
    """Return the hypothesis with the least AIC; None where none could be followed."""
    return None if found.best is None else found.hypotheses[found.best]


def told_of(found: Identification) -> list[Explanation]:
    """Return the hypotheses that are not told from the best one, it first."""
    best = best_of(found)
    others = [each for each in found.hypotheses if each is not best and not each.distinguished]
    return [] if best is None else [best, *others]


def fits(best: Explanation) -> bool:
    """Return whether a movement explains the measurements.

    It does not where its χ² is improbable, where a measurement contradicts it, and where as many unknowns as
    measurements leave a χ² above that of one measurement off by three standard deviations.
    """
    unlikely = best.probability is not None and best.probability < UNLIKELY
    # with as many unknowns as measurements χ² is at most that of one measurement off by three standard deviations
    unmet = not best.degrees_of_freedom and (best.chi_squared or 0.0) > UNMET
    return not (unlikely or unmet or best.contradicting)


def settlement_lines(ready: ReadySettlement) -> list[str]:
    """Return the lines of a movement in a project file."""
    x, z = ready.displacement_m
    lines = [
        "[[settlements]]",
        f"name = {json.dumps(ready.name, ensure_ascii=False)}",
        f"support = {json.dumps(ready.support, ensure_ascii=False)}",
        f"displacement_m = [{_number(x)}, {_number(z)}]",
    ]
    return [*lines, f"rotation_rad = {_number(ready.rotation_rad)}"] if ready.rotation_rad else lines


def movement_text(each: FittedMovement) -> str:
    """Return a movement on one line, in mm and mrad, with the standard errors that are known."""
    told = []
    for name, unit in (("x", "m"), ("z", "m"), ("rotation", "rad")):
        key = f"{name}_standard_error_{unit}"
        if key in each.model_fields_set:
            value, error = getattr(each, f"{name}_{unit}"), getattr(each, key)
            known = f" m{unit} (not determined)" if error is None else f" ± {1e3 * error:.2g} m{unit}"
            told.append(f"{name} {1e3 * value:.3g}{known}")
    return f"{each.support}: {', '.join(told)}"


def _number(value: float) -> str:
    """Return a number as TOML has it: with a point, and without a power."""
    text = f"{value:.7f}".rstrip("0")
    return f"{text}0" if text.endswith(".") else text
