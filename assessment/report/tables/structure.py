"""Tables of the structure: blocks, layers, loads, movements, ties, pressures; cracks calculated and surveyed."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Annotated

import numpy as np
import shapely

from assessment.ntc.tables import farthest
from assessment.report.language import Words
from assessment.report.tables import Curves, Found, curves, moves, pushes, table, without
from assessment.results.hand_check import block_size, outline_area
from assessment.results.joint_states import faces_of, joint_states, loaded
from assessment.results.schema import Direction, Point, Results, SummaryRow, named, present
from assessment.results.schema.model import WORST, DrawnBlock, LayerLoads
from assessment.results.schema.static import Behaviour, TieTension
from assessment.results.summary import material, taken_to_collapse
from assessment.results.table import Row, Table, cells, columns_of, reduction
from mechanics.model import H, V, end_gaps, end_points
from mechanics.types import Array, Mask

VARIABLE = {"variable_load_kN", "use_category", "psi_2"}
MATERIAL = (
    "unit_weight_kN_m3 friction normal_stiffness_kN_m3 tangential_stiffness_kN_m3 compressive_strength_kN_m2"
)
SETTLEMENTS = """state ?after support displacement_x_m displacement_z_m rotation_rad
ultimate_rigid_m ultimate_elastic_m"""
TIES = "tie from_x_m from_z_m to_x_m to_z_m yield_force_kN stiffness_kN_m pretension_kN ultimate_elongation states"
STRENGTHENING = "state of direction alpha_0 d_0_m alpha_u limit_state a_g_g zeta_E dynamic_pga_g gain"
COMPARED = ("a_g_g", "alpha_0", "alpha_u", "dynamic_pga_g")  # of which the first that is known gives the gain
COMPARISON = "state direction limit_state static_pga_g static_reduction dynamic_pga_g dynamic_reduction"
AT = 0.999  # of the yield force: a tension that is it
PLATES_M = {"plate_20_MPa": 0.20, "plate_30_MPa": 0.30, "plate_40_MPa": 0.40}  # sides of square plates
PRINTED = {"short": 10, "full": 40}  # joints of a table of the report, those that matter most

# as in results.json: loads of layers, settled states beside the original one, certificates
loads = table("loads", LayerLoads)(lambda results: results.loads or ())
comparison = table("comparison", COMPARISON)(lambda results: results.comparison)
quality = table("quality", f"state stage solves {' '.join(WORST)}")(lambda results: results.quality.by_stage)


@table("strengthening", STRENGTHENING)
def strengthening(results: Results) -> Found:
    """List the capacities of each strengthened state and direction below those of the state before; `of`: its name.

    The limit state of ζ_E is SLV (NTC 2018, §8.3), the farthest one where it was not checked.
    """

    def measured(row: SummaryRow) -> Row:
        capacity = results.states[row.state].capacity.get(row.direction) if row.direction else None
        checks = capacity.checks if capacity else {}
        limit = "SLV" if "SLV" in checks else farthest(checks)
        found = cells(row, ("state", "direction", "alpha_0", "d_0_m", "alpha_u", "dynamic_pga_g"))
        return found | ({"limit_state": limit} | cells(checks[limit], ("a_g_g", "zeta_E")) if limit else {})

    places = {(row.state, row.direction): row for row in results.summary.rows}
    for row in results.summary.rows:
        made = results.states[row.state].strengthening
        if made is not None and (before := places.get((made.of, row.direction))) is not None:
            was, now = measured(before), measured(row)
            by = next((name for name in COMPARED if was.get(name) is not None), "")
            loss = reduction(was.get(by), now.get(by))
            yield from (was, now | {"of": made.of, "gain": None if loss is None else -loss})


@table("blocks", "block layer support x_m z_m area_m2 depth_m vertical_load_kN")
def blocks(results: Results) -> Found:
    """List every block: layer, support, centroid, area, volume and extra load."""
    for number, block in enumerate(results.geometry.blocks):
        x, z = block.centroid_m
        yield {"block": number, "x_m": x, "z_m": z, "area_m2": outline_area(block.vertices_m)}, block


@table("layers", f"layer support blocks depth_m area_m2 {MATERIAL} vertical_load_kN")
def layers(results: Results) -> Found:
    """Sum up each layer: its role, blocks, depth, material and loads; defaults from [material]."""
    by_layer: dict[str, list[DrawnBlock]] = {}
    for block in results.geometry.blocks:
        name = f"{block.layer}, {block.region}" if block.region else block.layer
        by_layer.setdefault(name, []).append(block)
    for layer, own in sorted(by_layer.items()):
        row: Row = {"layer": layer, "support": own[0].support, "depth_m": own[0].depth_m, "blocks": len(own)}
        row["area_m2"] = sum(outline_area(block.vertices_m) for block in own)
        row["vertical_load_kN"] = sum(block.vertical_load_kN for block in own)
        given = material(results.echo, own[0])
        yield row | {key: given[key] for key in MATERIAL.split() if given.get(key) is not None}


def reported_loads(results: Results, words: Words) -> Table:
    """Return the loads with their sums, without what no layer has."""
    own = results.loads or []
    variable = any(each.variable_load_kN for each in own)
    columns = [name for name in LayerLoads.model_fields if variable or name not in VARIABLE]
    rows = [present(cells(each, columns)) for each in own]
    if len(own) > 1:
        kept = [name for name in columns if name not in {"layer", "use_category", "psi_2"}]
        rows.append({"layer": words.plain("value.sum")} | {key: sum(a[key] for a in rows) for key in kept})
    return Table("loads", rows, tuple(columns))


@table("settlements", SETTLEMENTS)
def settlements(results: Results) -> Found:
    """List the movements and how far each may go: the ultimate movement by kind of contact."""
    sought = taken_to_collapse(results.echo)
    for name, state in results.states.items():
        if settlement := state.settlement:
            x, z = settlement.displacement_m
            found: Row = {"state": name, "displacement_x_m": x, "displacement_z_m": z}
            found |= cells(settlement, ("support", "rotation_rad")) | present({"after": settlement.after})
            for contacts, path in state.pushdown.items():
                if name in sought or path.ultimate_movement_m is not None:
                    found[f"ultimate_{contacts}_m"] = path.ultimate_movement_m
            yield found


@curves("pushdown", "state contacts movement_m reaction_x_kN reaction_z_kN")
def pushdown_curves(results: Results) -> Curves:
    """List the points of every pushdown curve."""
    for where, path in moves(results):
        yield tuple(where.values()), (path.movement_m, path.reaction_x_kN, path.reaction_z_kN)


@curves("pushover", "state direction contacts displacement_m multiplier")
def pushover_curves(results: Results) -> Curves:
    """List the points of every pushover curve; displacements along x: towards −x they are negative."""
    for where, push in pushes(results):
        yield tuple(where.values()), (push.curve.displacement_m, push.curve.multiplier)


@table("ties", TIES)
def ties(results: Results) -> Found:
    """List the ties as drawn; null: no yield force, rigid, or no ultimate elongation."""
    for tie in results.model.ties or ():
        ends = zip(("from_x_m", "from_z_m", "to_x_m", "to_z_m"), (*tie.start_m, *tie.end_m), strict=True)
        yield {"tie": tie.name, "states": "; ".join(tie.states), **dict(ends)}, tie


def tensions(results: Results) -> Iterator[tuple[Row, TieTension]]:
    """Yield the tension of every tie along every path, behind its state, direction and contacts."""
    for paths in (moves(results), pushes(results)):
        for where, path in paths:
            for each in path.ties or ():
                yield where, each


@table("tie_tensions", "tie state direction contacts rest_kN peak_kN greatest_kN yields lengthening_m")
def tie_tensions(results: Results) -> Found:
    """List the tension of every tie along every path: movements of supports, and pushes by direction."""
    by_state = list(results.states)
    return sorted(tensions(results), key=lambda each: by_state.index(each[0]["state"]))


def tie_strength(results: Results) -> dict[str, float | None]:
    """Return the yield force (kN) of every tie; None: none."""
    return {tie.name: tie.yield_force_kN for tie in results.model.ties or ()}


@table("shaken_ties", "tie state record greatest_kN time_of_greatest_s yields lengthening_m")
def shaken_ties(results: Results) -> Found:
    """List the greatest tension of every tie in every motion.

    Of a tie that yields it is the yield force: the instants that are kept may lie beside the one at which it does, and
    then that is not known.
    """
    for name, state in results.states.items():
        for entry in state.history:
            for each in entry.ties or ():
                limit = tie_strength(results)[each.tie] if each.yields else None
                between = limit is not None and each.greatest_kN is not None and each.greatest_kN < AT * limit
                row: Row = {"tie": each.tie, "state": name, "record": entry.record, "yields": each.yields}
                row["lengthening_m"] = each.lengthening_m
                row["greatest_kN"] = limit if between else each.greatest_kN
                yield row | ({} if between else {"time_of_greatest_s": each.time_s})


def tie_demands(results: Results) -> Table:
    """List the greatest tension of every tie, its share of the yield force, and the pressure below square plates.

    Bar, anchorage and masonry below the plate are for the engineer to check against these.
    """
    greatest: dict[str, Row] = {}
    for each in [*tie_tensions(results).rows, *shaken_ties(results).rows]:
        force, most = each["greatest_kN"], greatest.get(each["tie"])
        if force is not None and (most is None or force > most["greatest_kN"]):
            greatest[each["tie"]] = {key: each[key] for key in ("tie", "state", "greatest_kN", "yields")}
    for tie, row in greatest.items():
        force, limit = row["greatest_kN"], tie_strength(results)[tie]
        row.update({"yield_force_kN": limit, "yields": bool(row["yields"])})
        row.update({"share_used": force / limit} if limit else {})
        row.update({name: 0.001 * force / side**2 for name, side in PLATES_M.items()})
    columns = ("tie", "state", "greatest_kN", "yield_force_kN", "share_used", "yields", *PLATES_M)
    return Table("tie_demands", list(greatest.values()), columns)


@dataclass(frozen=True)
class EdgePressure:
    """The greatest edge pressure of a `joint` (None: faces that met) between two blocks, and where it was found."""

    joint: int | None
    block_a: int
    block_b: int
    edge_pressure_kN_m2: Annotated[float, named("Pressione al bordo|Edge pressure", shown="MPa")]
    # the same without a strength
    uncrushed_pressure_kN_m2: Annotated[float, named("Senza schiacciamento|Without crushing", shown="MPa")]
    state: str
    direction: Direction | None  # of the push, None at rest
    contacts: Behaviour


def edge_pressures(results: Results) -> list[EdgePressure]:
    """Return the greatest edge pressure of every joint, the greatest first.

    Over the states at rest and the peaks of the pushover curves with elastic joints, as far as there are any: in a
    rigid mechanism hinges press without bound.
    """
    situations = list(loaded(results))
    elastic = [each for each in situations if each.contacts == "elastic"]
    drawn = len(results.geometry.joints)
    greatest: dict[int | str, EdgePressure] = {}
    for at in elastic or situations:
        states = joint_states(results, at)
        for number, (a, b) in enumerate(states.blocks.tolist()):
            key = number if number < drawn else str(at.met[number - drawn].faces_m)
            pressures = float(states.pressure[number]), float(states.uncrushed[number])
            if key not in greatest or pressures[1] > greatest[key].uncrushed_pressure_kN_m2:
                joint = number if number < drawn else None
                greatest[key] = EdgePressure(joint, a, b, *pressures, at.state, at.direction, at.contacts)
    return sorted(greatest.values(), key=lambda each: -each.uncrushed_pressure_kN_m2)


edge_pressure_table = table("edge_pressures", EdgePressure)(edge_pressures)


def printed(results: Results) -> int:
    """Return how many joints a table of the report has."""
    return PRINTED[results.echo.report.get("annexes", "short")]


def reported_pressures(results: Results) -> Table:
    """Return the joints that are pressed most; without the pressures of no crushing where no joint crushes.

    No rows where the greatest has no bound, as in the hinges of rigid joints.
    """
    found, left_out = edge_pressure_table(results), () if crushes(results) else ("uncrushed_pressure_kN_m2",)
    rows = found.rows[: printed(results)] if bounded(edge_pressures(results)) else []
    return without(Table(found.name, [*map(present, rows)], found.columns), *left_out)


def bounded(found: Sequence[EdgePressure]) -> bool:
    """Return whether the greatest pressure, the first, is a number."""
    return not found or math.isfinite(found[0].uncrushed_pressure_kN_m2)


def crushes(results: Results) -> bool:
    """Return whether any joint has a compressive strength."""
    return any(joint.compressive_strength_kN_m2 is not None for joint in results.geometry.joints)


SEEN = 0.5e-3  # m: the least opening that a survey sees
DIGITS = 6  # of metres: what is less is rounding, not a crack
SURVEY = {"crack": "opening_mm", "slip": "slip_mm"}  # kinds of measurements that a joint shows
BESIDE = 0.25  # of a block's size: a line that is farther from every joint goes through the stone
SAMPLES = np.linspace(0.05, 0.95, 11)  # along a line that was drawn: where its distance from joints is taken


@dataclass(frozen=True)
class Crack:
    """A joint of a settled state, between two blocks, that opened or slipped by more than `SEEN`."""

    state: str
    joint: int
    block_a: Annotated[int, named("Blocco a|Block a")]
    block_b: Annotated[int, named("Blocco b|Block b")]
    x_m: float  # of the wider end
    z_m: float
    # None: the faces have slid off each other; a slip has no sign
    opening_m: Annotated[float | None, named("Apertura|Opening", shown="mm", decimals=1)]
    other_opening_m: Annotated[
        float | None, named("All’altro estremo|At the other end", shown="mm", decimals=1)
    ]
    slip_m: Annotated[float | None, named("Scorrimento|Slip", shown="mm", decimals=1)]


@dataclass(frozen=True)
class Surveyed:
    """What was surveyed, beside what the joint nearest to it does in a settled state.

    `mark`: M and the number of the measurement, F and that of a line drawn as a crack, of which nothing was measured;
    `joint`: None where the line is beside none; `calculated_mm`: the opening there, of a slip the slip, None without a
    joint or where its faces are apart; `line` (n, 2) m as drawn; `seen`: whether the joint opens or slips by `SEEN`.
    """

    state: str
    mark: Annotated[str, named("Segno|Mark")]
    measurement: str
    measured_kind: Annotated[str, named("Tipo|Kind")]
    measured_mm: Annotated[float | None, named("Misurato|Measured", decimals=1, null="none")]
    sigma_mm: Annotated[float | None, named("σ", decimals=1, null="none")]
    joint: int | None
    calculated_mm: Annotated[float | None, named("Calcolato|Calculated", decimals=1, null="none")]
    line: list[Point]
    seen: bool


def survey(results: Results) -> Iterator[tuple[str, str, str, float | None, float | None, list[Point]]]:
    """Yield mark, name, kind, measured value and its deviation (mm), and place (m) of every surveyed crack and slip."""
    for number, each in enumerate(results.echo.measurement or (), 1):
        kind = each.get("kind", "")
        if kind in SURVEY and each.get(SURVEY[kind]) is not None:
            value, sigma = each[SURVEY[kind]], each.get("sigma_mm")
            yield f"M{number}", each["name"], kind, value, sigma, [each["point_m"]]
    for number, line in enumerate(results.geometry.cracks_m or (), 1):
        yield f"F{number}", "", "crack", None, None, line


def surveyed(results: Results, state: str) -> list[Surveyed]:
    """Return what was surveyed beside the joints of a settled state; of any other state nothing."""
    found = list(survey(results))
    joints = np.array([joint.ends_m for joint in results.geometry.joints], dtype=float)
    if not found or not len(joints) or not results.states[state].settlement:
        return []
    gaps, slips, apart = _openings(results, state)
    reach = BESIDE * block_size(results)
    rows = []
    for mark, name, kind, value, sigma, line in found:
        points = np.asarray(line, dtype=float)  # of a line, points at even shares of its length
        if len(points) > 1:
            at = shapely.line_interpolate_point(shapely.linestrings(points), SAMPLES, normalized=True)
            points = shapely.get_coordinates(at)
        away = shapely.distance(shapely.linestrings(joints)[:, None], shapely.points(points)[None, :])
        k = int(np.argmin(away.mean(axis=1)))
        middle = points[len(points) // 2]
        joint = shapely.linestrings(joints[k])
        share = float(shapely.line_locate_point(joint, shapely.Point(middle), normalized=True))
        opening = float(max(0.0, (1.0 - share) * gaps[k, 0] + share * gaps[k, 1]))
        calculated = 1000.0 * (float(slips[k]) if kind == "slip" else opening)
        off = value is None and away[k].mean() > reach
        seen = not off and bool(apart[k] or max(gaps[k].max(), slips[k]) > SEEN)
        there = None if off else k, None if off or apart[k] else calculated
        rows.append(Surveyed(state, mark, name, kind, value, sigma, *there, line, seen))
    return rows


def survey_table(results: Results) -> Table:
    """List what was surveyed beside what each settled state has there."""
    columns = columns_of(Surveyed)[:-1]
    rows = [asdict(each) for state in results.states for each in surveyed(results, state)]
    kept = [name for name in columns if any(row[name] not in (None, "") for row in rows)]
    shown = [{key: row[key] for key in kept if key != "joint" or row[key] is not None} for row in rows]
    return Table("survey", shown, tuple(kept))


def cracks_of(results: Results, state: str) -> list[Crack]:
    """Return the cracks of a settled state, the widest first; of any other state none."""
    if not results.states[state].settlement:
        return []
    faces = faces_of(results)
    contacts = faces.contacts
    ends = end_points(contacts, faces.positions(np.asarray(results.states[state].configuration, dtype=float)))
    gaps, slips, apart = _openings(results, state)
    shown = np.flatnonzero(apart | (gaps.max(axis=1) > SEEN) | (slips > SEEN))
    found = []
    for joint in shown[np.argsort(-np.where(apart, np.inf, gaps.max(axis=1))[shown], kind="stable")]:
        wide = int(np.argmax(gaps[joint]))
        x, z = ends[joint, wide].tolist()
        between = int(contacts.a[joint]), int(contacts.b[joint])
        widths = float(gaps[joint, wide]), max(0.0, float(gaps[joint, 1 - wide])), float(slips[joint])
        known = [None if apart[joint] else max(0.0, round(width, DIGITS)) for width in widths]
        found.append(Crack(state, int(joint), *between, x, z, *known))
    return found


@table("cracks", Crack)
def cracks(results: Results) -> Found:
    """List the cracks of every settled state."""
    for state in results.states:
        yield from cracks_of(results, state)


def reported_cracks(results: Results) -> Table:
    """Return the rows of the report: of each state the widest."""
    most = printed(results)
    found = [asdict(each) for state in results.states for each in cracks_of(results, state)[:most]]
    return Table("cracks", found, columns_of(Crack))


def _openings(results: Results, state: str) -> tuple[Array, Array, Mask]:
    """Return the gaps at both ends (j, 2) and the slips (j,) of the joints of a state, m, and which are apart (j,)."""
    faces = faces_of(results)
    places = faces.contacts.places(faces.positions(np.asarray(results.states[state].configuration)))
    return end_gaps(places), abs(places[:, V]), places[:, H] <= 0.0
