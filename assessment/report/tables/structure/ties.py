"""Ties: what they are, their tension along the paths and in the motions, and what a strengthening gains."""

from __future__ import annotations

from collections.abc import Sequence

from assessment.results.schema import Results
from assessment.results.schema.checks import StrengtheningRow
from assessment.results.schema.static import TieTension
from assessment.results.table import Row, Table, cells

TIES = (
    "tie",
    "from_x_m",
    "from_z_m",
    "to_x_m",
    "to_z_m",
    "yield_force_kN",
    "stiffness_kN_m",
    "pretension_kN",
    "states",
)
TENSIONS = ("tie", "state", "direction", "contacts", "rest_kN", "peak_kN", "greatest_kN", "yields")
SHAKEN = ("tie", "state", "record", "greatest_kN", "time_of_greatest_s", "yields")
AT = 0.999  # of the yield force: a tension that is it
STRENGTHENING = tuple(StrengtheningRow.model_fields)


def ties(results: Results) -> Table:
    """List the ties as drawn; null: no yield force, or rigid."""
    rows: list[Row] = [
        {
            "tie": tie.name,
            "from_x_m": tie.start_m[0],
            "from_z_m": tie.start_m[1],
            "to_x_m": tie.end_m[0],
            "to_z_m": tie.end_m[1],
            "yield_force_kN": tie.yield_force_kN,
            "stiffness_kN_m": tie.stiffness_kN_m,
            "pretension_kN": tie.pretension_kN,
            "states": "; ".join(tie.states),
        }
        for tie in results.model.ties or ()
    ]
    return Table("ties", rows, TIES)


def tie_tensions(results: Results) -> Table:
    """List the tension of every tie along every path: movements of supports, and pushes by direction."""
    paths: list[tuple[Row, Sequence[TieTension]]] = []
    for name, state in results.states.items():
        paths += [
            ({"state": name, "contacts": behaviour}, moved.ties or ())
            for behaviour, moved in state.pushdown.items()
        ]
        paths += [
            ({"state": name, "direction": direction, "contacts": behaviour}, push.ties or ())
            for direction, pushed in state.pushover.items()
            for behaviour, push in pushed.by_contacts.items()
        ]
    rows = [{**where, **cells(each, TENSIONS)} for where, ties in paths for each in ties]
    return Table("tie_tensions", rows, TENSIONS)


def shaken_ties(results: Results) -> Table:
    """List the greatest tension of every tie in every motion.

    Of a tie that yields it is the yield force: the instants that are kept may lie beside the one at which it does, and
    then that is not known.
    """
    strength = {tie.name: tie.yield_force_kN for tie in results.model.ties or ()}
    rows: list[Row] = []
    for name, state in results.states.items():
        for entry in state.history:
            for each in entry.ties or ():
                row: Row = {"tie": each.tie, "state": name, "record": entry.record, "yields": each.yields}
                limit = strength[each.tie] if each.yields else None
                between = limit is not None and each.greatest_kN is not None and each.greatest_kN < AT * limit
                row["greatest_kN"] = limit if between else each.greatest_kN
                if not between:
                    row["time_of_greatest_s"] = each.time_s
                rows.append(row)
    return Table("shaken_ties", rows, SHAKEN)


PLATES_M = {"plate_20_MPa": 0.20, "plate_30_MPa": 0.30, "plate_40_MPa": 0.40}  # sides of square plates
DEMANDS = ("tie", "state", "greatest_kN", "yield_force_kN", "share_used", "yields", *PLATES_M)


def tie_demands(results: Results) -> Table:
    """List the greatest tension of every tie, its share of the yield force, and the pressure below square plates.

    Bar, anchorage and masonry below the plate are for the engineer to check against these.
    """
    strength = {tie.name: tie.yield_force_kN for tie in results.model.ties or ()}
    greatest: dict[str, tuple[float, str, bool]] = {}
    shaken = shaken_ties(results).rows
    for each in [*tie_tensions(results).rows, *shaken]:
        tie, force, yields = each["tie"], each["greatest_kN"], bool(each["yields"])
        if force is not None and (tie not in greatest or force > greatest[tie][0]):
            greatest[tie] = force, each["state"], yields
    rows: list[Row] = []
    for tie, (force, state, yields) in greatest.items():
        limit = strength[tie]
        row: Row = {
            "tie": tie,
            "state": state,
            "greatest_kN": force,
            "yield_force_kN": limit,
            "yields": yields,
        }
        row |= {"share_used": force / limit} if limit else {}
        rows.append(row | {name: 0.001 * force / side**2 for name, side in PLATES_M.items()})
    return Table("tie_demands", rows, DEMANDS)


def strengthening(results: Results) -> Table:
    """List the capacities of every strengthened state beside those of the state before, as in results.json."""
    rows = [cells(each, STRENGTHENING) for each in results.strengthening or ()]
    return Table("strengthening", rows, STRENGTHENING)


GAINS = (  # quantity, and the key of its value before
    ("alpha_0", "alpha_0_before"),
    ("d_0_m", "d_0_before_m"),
    ("alpha_u", "alpha_u_before"),
    ("a_g_g", "a_g_before_g"),
    ("zeta_E", "zeta_E_before"),
    ("dynamic_pga_g", "dynamic_pga_before_g"),
)


def gains(row: StrengtheningRow) -> list[tuple[str, float | None, float | None, float | None]]:
    """Return each quantity of a strengthened state that was asked for, before and after, and the relative increase."""
    found = []
    for quantity, earlier in GAINS:
        if quantity in row.model_fields_set:
            before, after = getattr(row, earlier), getattr(row, quantity)
            found.append(
                (quantity, before, after, after / before - 1.0 if before and after is not None else None)
            )
    return found
