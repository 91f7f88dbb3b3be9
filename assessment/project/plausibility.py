"""Values that are allowed and hardly meant: a warning that names the key and, typed, what was probably meant."""

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from assessment.ntc.floor_spectrum import Spectrum, ground_of
from assessment.ntc.hazard import Hazard, hazard_range
from assessment.ntc.tables import return_period
from assessment.project.project import Project
from assessment.project.schema import LayerTable, MaterialTable, SettlementTable, TieTable
from mechanics import Assembly
from mechanics.messages import Message, headed, layer_key, linked, message
from mechanics.types import GRAVITY

STEEPEST = 1.5  # friction of stone on stone is 0.4 to 0.8
ANGLES = (5.0, 90.0)  # degrees: what is a tangent in their place
LIGHT, HEAVY = 5.0, 40.0  # kN/m³
SUNK = 0.01  # of a block's height, by which its weight may press it into its bed
TURN = 0.5  # rad
F0_RANGE, TC_RANGE = (2.2, 3.3), (0.1, 0.6)  # –; s: of all nodes of Allegato B, at any return period
ROUNDED = 0.02  # of a_g: typed values are rounded
LOCAL_FACTOR = 2.0  # behaviour factor q of local mechanisms, C8.7.1.2
LC1 = 1.35  # confidence factor where crushing is left out (Circolare 7/2019, C8.7.1.2)
ITALY = ((35.0, 48.0), (6.0, 19.0))  # latitude, longitude, degrees
DEEPEST = 100.0  # m, out of plane
SIZES = (0.01, 1000.0)  # m
HEAVIEST_TIE = 2000.0  # kN: more than anchorages in masonry bear
STEEL = 2.1e8  # kN/m²: modulus of elasticity
YIELDS = (1e5, 1.5e6)  # kN/m²: from wrought iron of poor quality to prestressing bars
BARS = (2e-5, 0.02)  # m²: sections, of a bar of 5 mm to one of 160 mm
Told = tuple[str, Message]  # a key and its warning
UNITS = (("kg/m³", GRAVITY / 1e3), ("N/m³", 1e-3), ("t/m³", GRAVITY))  # of weight or mass, in kN/m³


def implausible(project: Project, model: Assembly) -> list[Message]:
    """Return a warning for each value that is implausible for the project's model or for any masonry."""
    size = float(np.ptp(np.concatenate([block.polygon for block in model.blocks]), axis=0).max())
    found = [*_sizes(project, size), *_materials(project)]
    if project.elastic:
        found += _soft(project, model)
    for number, settlement in enumerate(project.settlements, 1):
        found += _movement(f"settlements[{number}]", settlement, size)
    for number, tie in enumerate(project.tie, 1):
        found += _tie(f"tie[{number}]", tie)
    for point in project.control:
        on = [str(block) for block in model.blocks_at(point.point_m) if model.movable[block]]
        text = message("on blocks {on}: it moves with the first; write a point inside one", on=", ".join(on))
        found += [(f"control.{point.name}.point_m", text)] * (len(on) > 1)
    assessment = project.assessment
    if assessment and assessment.confidence_factor < LC1 and np.isinf(model.contacts.strength).any():
        found.append(("assessment.confidence_factor", message(
            "{factor:g} is below {least:g}, which Circolare 7/2019, C8.7.1.2, asks for where compressive strength is "
            "left out, as here; write {meant}, or give compressive_strength_kN_m2 (motions then need elastic contacts)",
            factor=assessment.confidence_factor, least=LC1, meant=f"{LC1:g}",
        )))  # fmt: skip
    if assessment and assessment.behaviour_factor > LOCAL_FACTOR:
        found.append(("assessment.behaviour_factor", message(
            "{factor:g} is above {most:g}, the factor of local mechanisms (Circolare 7/2019, C8.7.1.2)",
            factor=assessment.behaviour_factor, most=LOCAL_FACTOR,
        )))  # fmt: skip
    if assessment and assessment.floor and project.dynamic_contacts:
        found.append(("assessment.floor", message(
            "static checks contain what the building amplifies up to this height, motions only what their records do: "
            "their PGA are not to be compared, unless the records are of the floor"
        )))  # fmt: skip
    return [headed(project.source, headed(key, text)) for key, text in found]


def implausible_hazard(project: Project, demands: Mapping[str, Spectrum]) -> list[Message]:
    """Return a warning for coordinates, a_g, F0 or T_C* that are implausible for a site in Italy."""
    site = project.assessment.site if project.assessment else None
    if site is None:
        return []
    numbers = {
        name: (ground.ag, ground.F0, ground.Tc_star)
        for name, spectrum in demands.items()
        if site.grid and (ground := ground_of(spectrum))
    } or {name: (each.ag_g, each.F0, each.Tc_star_s) for name, each in site.typed.items()}
    values = {}
    for name, each in numbers.items():
        hazard = Hazard(*each, return_period(name, site.nominal_life_years, site.use_class))
        values[name] = "assessment.site.grid" if site.grid else f"assessment.site.{name}", hazard
    found = [*_place(site.latitude, site.longitude), *_hazards(values)]
    return [headed(project.source, headed(key, text)) for key, text in found]


def _sizes(project: Project, size: float) -> Iterator[Told]:
    if not SIZES[0] <= size <= SIZES[1]:
        yield "geometry.unit", message(
            'with "{own}" the structure is {size:.3g} m large; write the unit of the drawing',
            own=project.geometry.unit, size=size,
        )  # fmt: skip
    depths = {name: part.depth_m or 0.0 for name, part in project.parts.items()}
    for table, depth in {"geometry": project.geometry.depth_m, **depths}.items():
        if depth > DEEPEST:
            yield f"{table}.depth_m", message(
                "{size:g} m out of plane; write {meant} if mm were meant",
                size=depth, meant=f"{1e-3 * depth:g}",
            )  # fmt: skip


def _materials(project: Project) -> Iterator[Told]:
    tables: dict[str, MaterialTable | LayerTable] = {"material": project.material, **project.parts}
    for table, values in tables.items():
        weight, friction = values.unit_weight_kN_m3, values.friction
        if weight is not None and not LIGHT <= weight <= HEAVY:
            meant = [(u, f"{f * weight:.3g}") for u, f in UNITS if LIGHT <= f * weight <= HEAVY]
            usual = message("masonry has {least:g} to {most:g}", least=LIGHT, most=HEAVY)
            hint = _if_meant(*meant[:1]) or usual
            odd = message("{weight:g} kN/m³ is no masonry's; {hint}", weight=weight, hint=hint)
            yield f"{table}.unit_weight_kN_m3", odd
        if friction is not None and STEEPEST < friction < math.inf:
            hint = message("stone on stone has 0.4 to 0.8; write inf where joints do not slide")
            if ANGLES[0] <= friction < ANGLES[1]:
                hint = message("write {meant} if an angle of {angle:g}° was meant", angle=friction,
                               meant=f"{math.tan(math.radians(friction)):.2g}")  # fmt: skip
            yield f"{table}.friction", message(
                "{friction:g} is the tangent of {angle:.3g}°; {hint}",
                friction=friction, angle=math.degrees(math.atan(friction)), hint=hint,
            )  # fmt: skip


def _if_meant(*meant: tuple[str, str]) -> Message | None:
    """Return the remedy where a value was given in another unit: those that would do, and the value in each."""
    hints = [message("write {meant} if {unit} were meant", meant=text, unit=unit) for unit, text in meant]
    return linked(hints) if hints else None


def _soft(project: Project, model: Assembly) -> Iterator[Told]:
    """Warn of beds so soft that what lies on the supports sinks into them; the weight is taken to be spread evenly."""
    joints = model.joints
    depth = np.array([block.depth for block in model.blocks])
    beds = np.flatnonzero(model.movable[joints.a] != model.movable[joints.b])
    if not beds.size:
        return
    a, b = joints.a[beds], joints.b[beds]
    pressure = model.weight / float((joints.length[beds] * np.minimum(depth[a], depth[b])).sum())
    stiff = {name for name, table in project.parts.items() if table.normal_stiffness_kN_m3}
    layers = {layer_key(name): f"layers.{name}" for name in project.layers}
    regions = {each.name: f"region[{k}]" for k, each in enumerate(project.region, 1)}
    worst: dict[str, tuple[float, int, float]] = {}
    for block in np.where(model.movable[a], a, b).tolist():
        stiffness = model.blocks[block].material.normal_stiffness
        share = pressure / stiffness / float(np.ptp(model.blocks[block].polygon[:, 1])) if stiffness else 0.0
        own = (regions.get(model.blocks[block].region), layers.get(layer_key(model.blocks[block].layer)))
        table = next((name for name in own if name in stiff), None) or "material"
        if share > max(SUNK, worst.get(table, (0.0,))[0]):
            worst[table] = (share, block, stiffness or 0.0)
    for table, (share, block, stiffness) in worst.items():
        yield f"{table}.normal_stiffness_kN_m3", message(
            "with {stiffness:g} kN/m³ the weight alone presses block {block} into its bed by {share:.2g} of its "
            "height, more than a hundredth; 1 N/mm³ is 1e6 kN/m³",
            stiffness=stiffness, block=block, share=share,
        )  # fmt: skip


def _movement(key: str, settlement: SettlementTable, size: float) -> Iterator[Told]:
    largest, turn = max(map(abs, settlement.displacement_m)), abs(settlement.rotation_rad)
    if largest > size:
        yield f"{key}.displacement_m", message(
            "{movement:g} m is more than the whole structure ({size:.3g} m); write {meant} if mm were meant",
            movement=largest, size=size, meant=f"{1e-3 * largest:g}",
        )  # fmt: skip
    if turn > TURN:
        yield f"{key}.rotation_rad", message(
            "{turn:g} rad are {angle:.3g}°; write {degrees} if degrees were meant, {mrad} if mrad",
            turn=turn, angle=math.degrees(turn), degrees=f"{math.radians(turn):.3g}", mrad=f"{1e-3 * turn:g}",
        )  # fmt: skip


def _tie(key: str, tie: TieTable) -> Iterator[Told]:
    """Warn of a yield force, and of a stiffness E A/L, that no bar has: A from the yield force where it is known."""
    strength, stiffness = tie.yield_force_kN, tie.stiffness_kN_m
    if HEAVIEST_TIE < strength < math.inf:
        yield f"{key}.yield_force_kN", message(
            "{force:g} kN is more than anchorages in masonry bear; write {meant} if N were meant",
            force=strength, meant=f"{1e-3 * strength:g}",
        )  # fmt: skip
    if stiffness is None:
        return
    length = math.dist(tie.from_m, tie.to_m)
    low, high = BARS if strength == math.inf else (strength / YIELDS[1], strength / YIELDS[0])
    least, most = STEEL * low / length, STEEL * high / length
    if least <= stiffness <= most:
        return
    bar = message("{length:.3g} m", length=length)
    if strength < math.inf:
        bar = message("{length:.3g} m that yields at {force:g} kN", length=length, force=strength)
    meant = [("N/m", f"{1e-3 * stiffness:g}")] if least <= 1e-3 * stiffness <= most else []
    yield f"{key}.stiffness_kN_m", message(
        "{stiffness:g} kN/m is not E A/L of a steel bar of {bar}, {least:.2g} to {most:.2g}; {hint}",
        stiffness=stiffness, bar=bar, least=least, most=most,
        hint=_if_meant(*meant) or message("write that of bar and anchorages"),
    )  # fmt: skip


def _place(latitude: float | None, longitude: float | None) -> Iterator[Told]:
    if latitude is None or longitude is None:
        return
    (south, north), (west, east) = ITALY
    if west <= latitude <= east and south <= longitude <= north:
        yield "assessment.site.latitude", message(
            "{latitude:g}, with longitude {longitude:g}, is not in Italy; "
            "if they are swapped write latitude = {north}, longitude = {east}",
            latitude=latitude, longitude=longitude, north=f"{longitude:g}", east=f"{latitude:g}",
        )  # fmt: skip


def _hazards(values: Mapping[str, tuple[str, Hazard]]) -> Iterator[Told]:
    """Warn of hazards (key, values) by limit state that no node of Allegato B has at their return period."""
    compare = message("compare it with the hazard of the site")
    for limit_state, (key, hazard) in values.items():
        least, most = hazard_range(hazard.return_period)
        if not (1.0 - ROUNDED) * least.ag <= hazard.ag <= (1.0 + ROUNDED) * most.ag:
            units = (("m/s²", hazard.ag / GRAVITY), ("g/10", hazard.ag / 10.0))
            yield f"{key}.ag_g", message(
                "{ag:g} g at {limit} is outside {least:.3g} to {most:.3g} g, which Italian sites have at {period:.0f} "
                "years (Allegato B); {hint}",
                ag=hazard.ag, limit=limit_state, least=least.ag, most=most.ag, period=hazard.return_period,
                hint=_if_meant(*((u, f"{g:.3g}") for u, g in units if least.ag <= g <= most.ag)) or compare,
            )  # fmt: skip
        if not F0_RANGE[0] <= hazard.F0 <= F0_RANGE[1]:
            yield f"{key}.F0", message(
                "{value:g} is outside {least:g} to {most:g}, which Italian sites have (Allegato B); correct it",
                value=hazard.F0, least=F0_RANGE[0], most=F0_RANGE[1],
            )  # fmt: skip
        if not TC_RANGE[0] <= hazard.Tc_star <= TC_RANGE[1]:
            shorter = 1e-3 * hazard.Tc_star
            meant = [("ms", f"{shorter:g}")] if TC_RANGE[0] <= shorter <= TC_RANGE[1] else []
            yield f"{key}.Tc_star_s", message(
                "{value:g} s is outside {least:g} to {most:g} s, which Italian sites have (Allegato B); {hint}",
                value=hazard.Tc_star, least=TC_RANGE[0], most=TC_RANGE[1], hint=_if_meant(*meant) or compare,
            )  # fmt: skip
    order = [(name, *values[name]) for name in ("SLD", "SLV", "SLC") if name in values]
    for (often, _, more), (seldom, key, hazard) in pairwise(order):
        if hazard.ag < more.ag:
            yield f"{key}.ag_g", message(
                "{ag:g} g at {limit} is below the {most:g} g of {often}, which comes more often; "
                "if they are exchanged exchange them, or correct one",
                ag=hazard.ag, limit=seldom, most=more.ag, often=often,
            )  # fmt: skip
