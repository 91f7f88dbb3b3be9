"""Tables of the assessment: capacity curves, checks, spectra, chosen mechanisms, and every step of the calculation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from assessment.ntc.limit_states import CHECKS, LINEAR
from assessment.results.table import Results, Row, Table, reduction

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
    "alpha_0",
    "e_star",
    "a_0_star_g",
    "demand_a_star_g",
    "ratio",
    "verified",
)
AT_SURFACE = ("pga_g", "demand_pga_g", "return_period_years")
BEHIND = (
    "d_star_m",
    "a_star_g",
    "T_s",
    "mechanism",
    *AT_SURFACE,
)  # of a check, in other tables of the report
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
        if capacity.get("curve")
        for d_star, a_star in zip(capacity["curve"]["d_star_m"], capacity["curve"]["a_star_g"], strict=True)
    ]
    return Table("capacity", rows, ("state", "direction", "d_star_m", "a_star_g"))


def summary(results: Results) -> Table:
    """Return the quantities of the paper's Table 1 per direction, a column per state, and the reductions.

    A reduction is 1 − settled/original: positive where the movement costs capacity.
    """
    names = list(results["states"])
    rows: list[Row] = []
    for direction in directions(results):
        for quantity, limit, values in _quantities(results, direction):
            row: Row = {"direction": direction, "quantity": quantity, "limit_state": limit} | values
            original = values.get("original")
            for name in names:
                if name != "original" and name in values:
                    row[f"reduction: {name}"] = reduction(original, values[name])
            rows.append(row)
    columns = [column for name in names for column in _with_reduction(name)]
    return Table("summary", rows, ("direction", "quantity", "limit_state", *columns))


def verification(results: Results) -> Table:
    """List the checks of every state and direction: what each limit state bears and what governs it."""
    rows = [
        {"state": name, "direction": direction, "limit_state": limit}
        | {key: capacity[limit][key] for key in VERIFICATION if key in capacity[limit]}
        | ({"mechanism": mechanism_text(capacity["mechanism"])} if "mechanism" in capacity else {})
        for name, direction, capacity in capacities(results)
        for limit in CHECKS
        if capacity.get(limit)
    ]
    columns = VERIFICATION
    if all(row.get("return_period_years") is None for row in rows):  # no hazard curve to read it from
        columns = tuple(column for column in VERIFICATION if column != "return_period_years")
    return Table("verification", rows, ("state", "direction", "limit_state", *columns))


def verification_surface(results: Results) -> Table:
    """List the same checks at the surface, and their return periods: the report's other half of `verification`."""
    whole = verification(results)
    columns = tuple(
        column for column in ("state", "direction", "limit_state", *AT_SURFACE) if column in whole.columns
    )
    rows = [{key: row[key] for key in columns if key in row} for row in whole.rows]
    return Table("verification_surface", [row for row in rows if row.get("pga_g") is not None], columns)


def mechanism_text(mechanism: Mapping[str, int]) -> str:
    """Return a mechanism as hinges + sliding joints."""
    return f"{mechanism['hinges']} + {mechanism['sliding_joints']}"


def spectrum(results: Results) -> Table:
    """List the points of the demand spectra: at 5 % damping and at that of the check."""
    rows = [
        {"limit_state": limit, "damping": content["damping"]}
        | {key: content[key][k] for key in SPECTRUM if isinstance(content.get(key), list)}
        for limit, content in (results.get("spectra") or {}).items()
        for k in range(len(content["T_s"]))
    ]
    return Table("spectrum", rows, SPECTRUM)


def action(results: Results) -> Table:
    """List the parameters of the demand spectra."""
    rows = [
        {"limit_state": limit} | {key: content[key] for key in ACTION if key in content}
        for limit, content in (results.get("spectra") or {}).items()
    ]
    return Table("action", rows, ACTION)


def chosen_mechanisms(results: Results) -> Table:
    """List the mechanisms that the user chose beside limit analysis; refused ones with the reason."""
    rows: list[Row] = []
    for given in results.get("mechanisms") or []:
        row: Row = {"mechanism": given["name"]} | {key: given[key] for key in CHOSEN if key in given}
        limit = given.get("alpha_0_limit")
        row |= {"alpha_0_given": given.get("alpha_0"), "ratio": given["alpha_0"] / limit if limit else None}
        rows.append({key: value for key, value in row.items() if value is not None})
    return Table("chosen_mechanisms", rows, CHOSEN)


def chosen_checks(results: Results) -> Table:
    """List the checks of the mechanisms that the user chose, linear and, where their motion is known, nonlinear."""
    rows = [
        {"mechanism": given["name"], "state": given["state"], "limit_state": name}
        | {key: given[name][key] for key in CHOSEN_CHECK if given[name].get(key) is not None}
        for given in results.get("mechanisms") or []
        for name in CHECKS
        if name in given
    ]
    return Table("chosen_checks", rows, ("mechanism", "state", "limit_state", *CHOSEN_CHECK))


def linear_checks(results: Results) -> Table:
    """List the linear kinematic checks, of mechanisms found and chosen: a_0* against a_g S/q, or a_Z/q at height."""
    rows = [
        {"state": name, "direction": direction, "limit_state": limit, "mechanism": mechanism}
        | {
            "alpha_0": content["alpha_0"],
            "e_star": content["e_star"],
            "a_0_star_g": content[limit]["a_star_g"],
        }
        | {"demand_a_star_g": content[limit]["demand_a_star_g"], "ratio": content[limit]["zeta_E"]}
        | {"verified": content[limit]["verified"]}
        for name, direction, mechanism, content in _mechanisms_checked(results)
        for limit in LINEAR
        if (content.get(limit) or {}).get("demand_a_star_g") is not None
    ]
    return Table("linear_checks", rows, LINEAR_CHECK)


def _mechanisms_checked(results: Results) -> Iterator[tuple[str, str, str, Mapping[str, Any]]]:
    """Yield state, direction, name and checks of every mechanism: those found, then those chosen."""
    for name, direction, capacity in capacities(results):
        text = mechanism_text(capacity["mechanism"]) if "mechanism" in capacity else ""
        yield name, direction, text, capacity
    for given in results.get("mechanisms") or []:
        if "alpha_0" in given:
            yield given["state"], given["direction"], given["name"], given


def scalings(results: Results) -> Table:
    """Set the capacity at SLV by both ways of scaling side by side; `counts`: the one that the checks took."""
    rows = [
        {"state": name, "direction": direction, "limit_state": "SLV", "scaling": scaling}
        | {key: check[key] for key in SCALINGS if key in check}
        | {"counts": check["used"]}
        for name, direction, capacity in capacities(results)
        for scaling, check in (capacity.get("scalings") or {}).items()
    ]
    return Table("scalings", rows, ("state", "direction", "limit_state", "scaling", *SCALINGS, "counts"))


def traces(content: Mapping[str, Any]) -> Iterator[tuple[str, list[Mapping[str, Any]]]]:
    """Yield the traces of a direction or of a chosen mechanism: "capacity" for what its checks share, then theirs."""
    if content.get("trace"):
        yield "capacity", content["trace"]
    for limit in CHECKS:
        if (content.get(limit) or {}).get("trace"):
            yield limit, content[limit]["trace"]
    if content.get(VERTICAL):
        yield VERTICAL, content[VERTICAL]["trace"]
    for scaling in (content.get("scalings") or {}).values():
        if scaling.get("trace"):
            yield OTHER_SCALING, scaling["trace"]
    if (content.get(NOMINAL) or {}).get("trace"):
        yield NOMINAL, content[NOMINAL]["trace"]


def trace(results: Results) -> Table:
    """List every step of every calculation: formula, numbers put in, result and paragraph."""
    rows = [
        {
            "state": name,
            "direction": direction,
            "part": part,
            **{key: step.get(key) for key in ("symbol", "formula", "result", "unit", "paragraph")},
            "inputs": "; ".join(f"{symbol}={value!r}" for symbol, value in step["inputs"].items()),
        }
        for name, direction, part, steps in _all_traces(results)
        for step in steps
    ]
    columns = ("state", "direction", "part", "symbol", "formula", "inputs", "result", "unit", "paragraph")
    return Table("trace", rows, columns)


def _all_traces(results: Results) -> Iterator[tuple[str, str, str, list[Mapping[str, Any]]]]:
    for limit, content in (results.get("spectra") or {}).items():
        yield "", "", f"spectrum {limit}", content.get("trace") or []
    for name, direction, capacity in capacities(results):
        for part, steps in traces(capacity):
            yield name, direction, part, steps
    for name, content in results["states"].items():
        yield name, "", "indices", (content.get("indices") or {}).get("trace") or []
    yield "", "", "knowledge", (results.get("knowledge") or {}).get("trace") or []
    for given in results.get("mechanisms") or []:
        for part, steps in traces(given):
            yield given["state"], given["direction"], f"{given['name']}: {part}", steps


def directions(results: Results) -> list[str]:
    """Return the directions in which any state was pushed."""
    found = {
        direction for content in results["states"].values() for direction in content.get("pushover") or {}
    }
    return sorted(found)


def _quantities(results: Results, direction: str) -> Iterator[tuple[str, str, Row]]:
    """Yield quantity, limit state and the value of each state that has it."""
    sources: dict[str, tuple[str, ...]] = {
        "alpha_0": ("pushover", direction, "rigid", "alpha_0"),
        "alpha_u": ("pushover", direction, "elastic", "alpha_u"),
        "alpha_y": ("pushover", direction, "elastic", "alpha_y"),
        "d_y_m": ("pushover", direction, "elastic", "d_y_m"),
        "d_0_m": ("pushover", direction, "rigid", "d_0_m"),
        "e_star": ("pushover", direction, "rigid", "mechanism", "e_star"),
        "gamma_star": ("pushover", direction, "rigid", "mechanism", "gamma_star"),
        "T_0_s": ("capacity", direction, "T_0_s"),
    }
    listed = [(quantity, "", path) for quantity, path in sources.items()]
    listed += [
        (quantity, limit, ("capacity", direction, limit, quantity))
        for quantity in ("d_star_m", "T_s", "a_g_g", "zeta_E")
        for limit in CHECKS
    ]
    for quantity, limit, path in listed:
        values = {}
        for name, content in results["states"].items():
            found, value = _look_up(content, path)
            if found:
                values[name] = value
        if values:
            yield quantity, limit, values


def _look_up(content: Any, path: Sequence[str]) -> tuple[bool, Any]:
    for key in path:
        if not isinstance(content, Mapping) or key not in content:
            return False, None
        content = content[key]
    return True, content


def _with_reduction(name: str) -> tuple[str, ...]:
    return (name,) if name == "original" else (name, f"reduction: {name}")


def capacities(results: Results) -> Iterator[tuple[str, str, Any]]:
    """Yield state, direction and capacity wherever there is one."""
    for name, content in results["states"].items():
        for direction, capacity in (content.get("capacity") or {}).items():
            if capacity:
                yield name, direction, capacity
