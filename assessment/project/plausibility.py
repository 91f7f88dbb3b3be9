"""Values that are allowed and hardly meant: a warning that names the key and what was probably meant.

None is refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from assessment.ntc.demand.spectrum import ElasticSpectrum, Spectrum
from mechanics.types import GRAVITY

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable, TieTable
    from mechanics import Assembly

STEEPEST = 1.5  # friction of stone on stone is 0.4 to 0.8
ANGLES = (5.0, 90.0)  # degrees: what is a tangent in their place
LIGHT, HEAVY = 5.0, 40.0  # kN/m³
SUNK = 0.01  # of a block's height, by which its weight may press it into its bed
TURN = 0.5  # rad
STRONGEST, SLOWEST = 1.0, 2.0  # a_g, g; T_C*, s
LC1 = 1.35  # confidence factor where crushing is left out (Circolare 7/2019, C8.7.1.2)
ITALY = ((35.0, 48.0), (6.0, 19.0))  # latitude, longitude, degrees
DEEPEST = 100.0  # m, out of plane
SIZES = (0.01, 1000.0)  # m
HEAVIEST_TIE = 2000.0  # kN: more than anchorages in masonry bear
STEEL = 2.1e8  # kN/m²: modulus of elasticity
YIELDS = (1e5, 1.5e6)  # kN/m²: from wrought iron of poor quality to prestressing bars
BARS = (2e-5, 0.02)  # m²: sections, of a bar of 5 mm to one of 160 mm
UNITS = (("kg/m³", GRAVITY / 1e3), ("N/m³", 1e-3), ("t/m³", GRAVITY))  # of weight or mass, in kN/m³


def implausible(project: Project, model: Assembly) -> list[str]:
    """Return a warning for each value that is implausible for the project's model or for any masonry."""
    low, high = (
        bound(np.concatenate([b.polygon for b in model.blocks]), axis=0) for bound in (np.min, np.max)
    )
    size = float(np.max(high - low))
    found = [*_sizes(project, size), *_materials(project)]
    if project.elastic:
        found += _soft(project, model)
    for number, settlement in enumerate(project.settlements, 1):
        found += _movement(f"settlements[{number}]", settlement, size)
    for number, tie in enumerate(project.tie, 1):
        found += _tie(f"tie[{number}]", tie)
    assessment = project.assessment
    crushes = bool(np.isfinite(model.contacts.strength).all())
    if assessment and assessment.confidence_factor < LC1 and not crushes:
        found.append(
            f"assessment.confidence_factor: {assessment.confidence_factor:g} is below {LC1:g}, which Circolare 7/2019, "
            f"C8.7.1.2, asks for where compressive strength is left out, as here; write {LC1:g}"
        )
    return [f"{project.source}: {text}" for text in found]


def implausible_hazard(project: Project, demands: Mapping[str, Spectrum]) -> list[str]:
    """Return a warning for coordinates, a_g or T_C* that are implausible for a site in Italy."""
    site = project.assessment.site if project.assessment else None
    if site is None:
        return []
    typed = {name: table for name in ("SLD", "SLV", "SLC") if (table := getattr(site, name))}
    values = {name: (f"assessment.site.{name}", each.ag_g, each.Tc_star_s) for name, each in typed.items()}
    if site.grid is not None:
        grounds = {name: getattr(spectrum, "ground", spectrum) for name, spectrum in demands.items()}
        values = {
            name: (f"assessment.site.grid, {name}", ground.ag, ground.Tc_star)
            for name, ground in grounds.items()
            if isinstance(ground, ElasticSpectrum)
        }
    found = [*_place(site.latitude, site.longitude), *_hazards(values)]
    return [f"{project.source}: {text}" for text in found]


def _sizes(project: Project, size: float) -> Iterator[str]:
    if not SIZES[0] <= size <= SIZES[1]:
        own = project.geometry.unit
        yield f'geometry.unit: with "{own}" the structure is {size:.3g} m large; write the unit of the drawing'
    depths = {"geometry": project.geometry.depth_m}
    depths |= {f"layers.{name}": layer.depth_m for name, layer in project.layers.items() if layer.depth_m}
    for table, depth in depths.items():
        if depth > DEEPEST:
            yield f"{table}.depth_m: {depth:g} m out of plane; write {1e-3 * depth:g} if mm were meant"


def _materials(project: Project) -> Iterator[str]:
    tables = {"material": project.material} | {f"layers.{key}": each for key, each in project.layers.items()}
    for table, values in tables.items():
        weight, friction = values.unit_weight_kN_m3, values.friction
        if weight is not None and not LIGHT <= weight <= HEAVY:
            meant = next(((u, f * weight) for u, f in UNITS if LIGHT <= f * weight <= HEAVY), None)
            hint = (
                f"write {meant[1]:.3g} if {meant[0]} were meant"
                if meant
                else f"masonry has {LIGHT:g} to {HEAVY:g}"
            )
            yield f"{table}.unit_weight_kN_m3: {weight:g} kN/m³ is no masonry's; {hint}"
        if friction is not None and STEEPEST < friction < math.inf:
            degrees = math.degrees(math.atan(friction))
            hint = "stone on stone has 0.4 to 0.8; write inf where joints do not slide"
            if ANGLES[0] <= friction < ANGLES[1]:
                hint = f"write {math.tan(math.radians(friction)):.2g} if an angle of {friction:g}° was meant"
            yield f"{table}.friction: {friction:g} is the tangent of {degrees:.3g}°; {hint}"


def _soft(project: Project, model: Assembly) -> Iterator[str]:
    """Warn of beds so soft that what lies on the supports sinks into them; the weight is taken to be spread evenly."""
    joints = model.joints
    depth = np.array([block.depth for block in model.blocks])
    beds = np.flatnonzero(model.movable[joints.a] != model.movable[joints.b])
    if not beds.size:
        return
    a, b = joints.a[beds], joints.b[beds]
    pressure = model.weight / float((joints.length[beds] * np.minimum(depth[a], depth[b])).sum())
    layers = project.layers.items()
    own = {name.lower(): f"layers.{name}" for name, layer in layers if layer.normal_stiffness_kN_m3}
    worst: dict[str, tuple[float, int, float]] = {}
    for block in np.where(model.movable[a], a, b).tolist():
        stiffness = model.blocks[block].material.normal_stiffness
        share = pressure / stiffness / float(np.ptp(model.blocks[block].polygon[:, 1])) if stiffness else 0.0
        table = own.get(model.blocks[block].layer.lower(), "material")
        if share > max(SUNK, worst.get(table, (0.0,))[0]):
            worst[table] = (share, block, stiffness or 0.0)
    for table, (share, block, stiffness) in worst.items():
        yield (
            f"{table}.normal_stiffness_kN_m3: with {stiffness:g} kN/m³ the weight alone presses block {block} into its "
            f"bed by {share:.2g} of its height, more than a hundredth; 1 N/mm³ is 1e6 kN/m³"
        )


def _movement(key: str, settlement: SettlementTable, size: float) -> Iterator[str]:
    largest, turn = max(map(abs, settlement.displacement_m)), abs(settlement.rotation_rad)
    if largest > size:
        yield (
            f"{key}.displacement_m: {largest:g} m is more than the whole structure ({size:.3g} m); "
            f"write {1e-3 * largest:g} if mm were meant"
        )
    if turn > TURN:
        yield (
            f"{key}.rotation_rad: {turn:g} rad are {math.degrees(turn):.3g}°; "
            f"write {math.radians(turn):.3g} if degrees were meant, {1e-3 * turn:g} if mrad"
        )


def _tie(key: str, tie: TieTable) -> Iterator[str]:
    """Warn of a yield force, and of a stiffness E A/L, that no bar has: A from the yield force where it is known."""
    strength, stiffness = tie.yield_force_kN, tie.stiffness_kN_m
    if HEAVIEST_TIE < strength < math.inf:
        yield (
            f"{key}.yield_force_kN: {strength:g} kN is more than anchorages in masonry bear; "
            f"write {1e-3 * strength:g} if N were meant"
        )
    if stiffness is None:
        return
    length = math.dist(tie.from_m, tie.to_m)
    low, high = BARS if strength == math.inf else (strength / YIELDS[1], strength / YIELDS[0])
    least, most = STEEL * low / length, STEEL * high / length
    if not least <= stiffness <= most:
        bar = f"{length:.3g} m" if strength == math.inf else f"{length:.3g} m that yields at {strength:g} kN"
        hint = f"; write {1e-3 * stiffness:g} if N/m were meant" if least <= 1e-3 * stiffness <= most else ""
        yield (
            f"{key}.stiffness_kN_m: {stiffness:g} kN/m is not E A/L of a steel bar of {bar}, "
            f"{least:.2g} to {most:.2g}{hint or '; write that of bar and anchorages'}"
        )


def _place(latitude: float | None, longitude: float | None) -> Iterator[str]:
    if latitude is None or longitude is None:
        return
    (south, north), (west, east) = ITALY
    if west <= latitude <= east and south <= longitude <= north:
        yield (
            f"assessment.site.latitude: {latitude:g}, with longitude {longitude:g}, is not in Italy; "
            f"if they are swapped write latitude = {longitude:g}, longitude = {latitude:g}"
        )


def _hazards(values: Mapping[str, tuple[str, float, float]]) -> Iterator[str]:
    """Warn of a_g and T_C* (key, g, s) by limit state, the more frequent one first."""
    for key, ag, Tc_star in values.values():
        if ag > STRONGEST:
            yield (
                f"{key}.ag_g: {ag:g} g is more than any site has; write {ag / GRAVITY:.3g} if m/s² were meant, "
                f"{ag / 10.0:.3g} if g/10"
            )
        if Tc_star > SLOWEST:
            yield f"{key}.Tc_star_s: {Tc_star:g} s is longer than any site's; write {1e-3 * Tc_star:g} if ms were meant"
    order = [(name, *values[name]) for name in ("SLD", "SLV", "SLC") if name in values]
    for (often, _, ag, _), (seldom, key, less, _) in pairwise(order):
        if less < ag:
            yield (
                f"{key}.ag_g: {less:g} g at {seldom} is below the {ag:g} g of {often}, which comes more often; "
                "if they are exchanged exchange them, or correct one"
            )
