"""The tables of time histories and of the incremental analysis."""

from __future__ import annotations

from collections.abc import Iterator

from assessment.results.schema import Results
from assessment.results.schema.campaign import Campaign
from assessment.results.schema.dynamic import History, Incremental, Loss, Range, Scanned
from assessment.results.table import Row, Table, cells, quoted_limit_state, reduction

HISTORY = (
    "state", "record", "pga_g", "contacts", "control", "peak_displacement_m", "residual_displacement_m", "collapsed",
    "time_of_collapse_s",
)  # fmt: skip
RANGES = (
    "state", "record", "integrator", "integrator_share", "members", "members_collapsed", "lowest_peak_m",
    "median_peak_m", "highest_peak_m",
)  # fmt: skip
ENERGY = (
    "input",
    "kinetic",
    "potential",
    "elastic",
    "friction",
    "impact",
    "viscous",
    "integrator",
    "residual",
)
SEARCH = (
    "state", "record", "record_pga_g", "pga_safe_g", "lowest_collapse_g", "pga_collapse_g", "level_50_g", "level_84_g",
    "resurrections", "widest_gap", "runs",
)  # fmt: skip
OF_STATES = (
    "state", "records", "mean_pga_collapse_g", "lowest_pga_collapse_g", "pga_collapse_g", "pga_all_collapse_g",
    "median_g", "dispersion",
)  # fmt: skip
OF_LOSS = ("capacity_loss", "dynamic_loss_low", "dynamic_loss_high", "distinguishable")
COMPARED = (
    "state", "analysis", "direction", "limit_state", "pga_surface_g", "over_static", "level_50_g", *OF_LOSS
)  # fmt: skip


def dynamic_tables(results: Results) -> list[Table]:
    """List all tables of the dynamic stages, long ones included."""
    return [
        histories(results),
        ranges(results),
        energy(results),
        history_curves(results),
        motions(results),
        incremental(results),
        incremental_states(results),
        incremental_curves(results),
        static_dynamic(results),
    ]


def histories(results: Results) -> Table:
    """List what every time history came to."""
    rows = []
    for state, entry in _histories(results):
        unasked = {None: "", True: "residual_displacement_m", False: "time_of_collapse_s"}[entry.collapsed]
        rows.append({"state": state} | cells(entry, [key for key in HISTORY if key != unasked]))
    return Table("history", rows, HISTORY)


def ranges(results: Results) -> Table:
    """List how every time history was integrated, by how many members, and the range of their peaks."""
    rows = []
    for state, entry in _histories(results):
        if not entry.curve:
            continue
        found: Row = {"state": state} | cells(entry, RANGES)
        if entry.peak_displacement_m_range:
            found["lowest_peak_m"], found["highest_peak_m"] = entry.peak_displacement_m_range
            found["median_peak_m"] = entry.peak_displacement_median_m
        rows.append(found)
    return Table("history_ranges", rows, RANGES)


def energy(results: Results) -> Table:
    """List the energy balance of every time history: input is what was stored and dissipated, and a residual, kNm."""
    columns = [f"{name}_kNm" for name in ENERGY]
    rows = [
        {"state": state, "record": entry.record} | cells(entry.energy, columns)
        for state, entry in _histories(results)
        if entry.energy
    ]
    return Table("history_energy", rows, ("state", "record", *columns))


def history_curves(results: Results) -> Table:
    """List the points of every control displacement history."""
    rows = [
        {"state": state, "record": entry.record, "time_s": time, "displacement_m": displacement}
        for state, entry in _histories(results)
        if entry.curve
        for time, displacement in zip(entry.curve.time_s, entry.curve.displacement_m, strict=True)
    ]
    return Table("history_curves", rows, ("state", "record", "time_s", "displacement_m"))


def motions(results: Results) -> Table:
    """List the spectral ordinates (5 % damping) of the records of the time histories."""
    rows = [
        {"record": motion.name, "T_s": period, "S_a_g": acceleration, "S_d_m": displacement}
        for motion in results.motions or []
        for period, acceleration, displacement in zip(motion.T_s, motion.S_a_g, motion.S_d_m, strict=True)
    ]
    return Table("record_spectra", rows, ("record", "T_s", "S_a_g", "S_d_m"))


def incremental(results: Results) -> Table:
    """List the bracket of the PGA at collapse of every record and state."""
    rows = [
        {"state": state} | cells(record, SEARCH) | bands(record, record.pga_collapse_g_range)
        for state, found in _incrementals(results)
        for record in found.records or []
    ]
    return Table("incremental", rows, SEARCH)


def incremental_states(results: Results) -> Table:
    """List mean, lowest and, of enough records, the standard's PGA at collapse, and the fragility of every state."""
    rows: list[Row] = []
    for state, found in _incrementals(results):
        of_state: Row = {"state": state} | cells(found, OF_STATES) | {"records": len(found.records or [])}
        if found.pga_collapse_g_range:
            of_state["pga_all_collapse_g"] = found.pga_collapse_g_range[1]
        if not found.rule:
            of_state.pop("pga_collapse_g", None)
        if found.fragility:
            of_state |= cells(found.fragility, ("median_g", "dispersion"))
        rows.append(of_state)
    return Table("incremental_states", rows, OF_STATES)


def incremental_curves(results: Results) -> Table:
    """List every run of the incremental analysis."""
    columns = (
        "pga_g",
        "peak_displacement_m",
        "members",
        "members_collapsed",
        "collapsed",
        "time_of_collapse_s",
    )
    rows = [
        {"state": state, "record": record.record} | cells(point, columns)
        for state, found in _incrementals(results)
        for record in found.records or []
        for point in record.points
    ]
    return Table("incremental_curves", rows, ("state", "record", *columns))


def static_dynamic(results: Results) -> Table:
    """Set static check, incremental analysis and campaign of each state on one reference: PGA at the surface, F_C = 1.

    The level of 50 % is the median of the fragility, and the loss of motions that of these levels, of each record by
    itself. `over_static` is over the least static capacity of the state.
    """
    rows: list[Row] = []
    for name, state in results.states.items():
        shaken = [*_of_incremental(state.incremental), *_of_campaign(results.campaign, name)]
        if not shaken:
            continue
        static = list(_of_check(name, results))
        known = [row["pga_surface_g"] for row in static if row["pga_surface_g"] is not None]
        gone = OF_LOSS if name == "original" else ()
        for row in (*static, *shaken):
            if known and row.get("pga_surface_g") is not None:
                row["over_static"] = row["pga_surface_g"] / min(known)
            rows.append({"state": name} | {key: value for key, value in row.items() if key not in gone})
    return Table("static_dynamic", rows, COMPARED)


def _of_check(name: str, results: Results) -> Iterator[Row]:
    """Yield the static capacity of a state in each direction, with its loss."""
    original = results.states.get("original")
    for direction, capacity in results.states[name].capacity.items():
        before = original.capacity.get(direction) if original else None
        was, now = (each.nominal if each else None for each in (before, capacity))
        row: Row = {"analysis": "static_check", "direction": direction}
        row["limit_state"] = quoted_limit_state(capacity.checks)
        row["pga_surface_g"] = now.pga_g if now else None
        if not results.states[name].strengthening:  # whose reduction is not that of a settlement
            row["capacity_loss"] = reduction(was.pga_g if was else None, row["pga_surface_g"])
        yield row


def _of_incremental(found: Incremental) -> Iterator[Row]:
    """Yield what the incremental analysis of a state came to."""
    if found.records is not None:
        median = found.fragility.median_g if found.fragility else None
        row: Row = {"analysis": "incremental", "pga_surface_g": found.pga_collapse_g, "level_50_g": median}
        yield row | lost(found.loss)


def _of_campaign(campaign: Campaign | None, name: str) -> Iterator[Row]:
    """Yield what a campaign came to in a state of the project: after none of a movement, or the whole."""
    for fit, loss in zip(campaign.fragility, campaign.loss, strict=True) if campaign else ():
        if (fit.settlement, fit.share) == (name, 1.0) or (name, fit.share) == ("original", 0.0):
            row: Row = {"analysis": "campaign", "pga_surface_g": fit.pga_collapse_g}
            if campaign and campaign.measure == "PGA":
                row["level_50_g"] = fit.median_g
            yield row | lost(loss)
            return


def lost(loss: Loss | None) -> Row:
    """Return the loss of motions, its bounds, and whether it is distinguishable from none."""
    if loss is None or loss.dynamic is None:
        return {}
    low, high = loss.dynamic_range
    row: Row = {"capacity_loss": loss.dynamic, "dynamic_loss_low": low, "dynamic_loss_high": high}
    return row | ({} if loss.distinguishable is None else {"distinguishable": loss.distinguishable})


def bands(found: Scanned, range_: Range | None) -> Row:
    """Return levels above the lowest collapse that stand, the widest gap, and from where all levels run collapse."""
    gap = "–".join(f"{level:.3f}" for level in found.widest_gap_g or [] if level is not None)
    stands = "; ".join(f"{level:.3f}" for level in found.resurrections_g)
    return {"resurrections": stands, "widest_gap": gap} | (
        {"pga_all_collapse_g": range_[1]} if range_ else {}
    )


def _histories(results: Results) -> Iterator[tuple[str, History]]:
    for name, state in results.states.items():
        for entry in state.history:
            yield name, entry


def _incrementals(results: Results) -> Iterator[tuple[str, Incremental]]:
    for name, state in results.states.items():
        if state.incremental.records is not None:
            yield name, state.incremental
