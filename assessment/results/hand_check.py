"""The hand check: a mechanism as a few rigid macro-blocks, and its multiplier by virtual work from their figures."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import numpy as np

from assessment.results.frames import lengthening, ties_of
from assessment.results.joint_states import outlines
from assessment.results.schema import Direction, Results, RigidPush, known, named
from assessment.results.summary import material
from assessment.results.table import Row, Table, columns_of, sense
from mechanics.model import connected
from mechanics.pictures import field, place
from mechanics.types import Array

TOGETHER = 0.01  # of the largest velocity: across a joint, what does not part two blocks
BY_HAND = 15  # macro-blocks that are printed and numbered; more are no check by hand
STILL = 1e-3  # of the largest velocity: a block that does not take part
NOTHING = 1e-9  # kN, m or rad: what rounding leaves of zero
TURNING = 1e-7  # rad, beside displacements of up to 1 m: what the solver leaves of no rotation is less
TAUT = 1e-3  # of the yield force: a tie that bears less does not yield in a mechanism
EQUAL = 1e-6  # multipliers that differ by less are one
FIGURES = 4  # significant figures that the reader is given, and that the check is made with


@dataclass(frozen=True)
class HandCheck:
    """Multipliers of a mechanism: of the program, by virtual work over all blocks and over macro-blocks as printed.

    Deviations are relative to the program's.
    """

    state: str
    direction: Direction
    macro_blocks: Annotated[int, named("Macroblocchi|Macro-blocks")]
    alpha_mechanism: Annotated[float, named("α programma|α program")]
    virtual_work_alpha: float
    deviation: Annotated[float, named("Scarto|Deviation", shown="%", digits=2)]
    hand_alpha: Annotated[float, named("α macroblocchi|α macro-blocks")]
    hand_deviation: Annotated[
        float, named("Scarto, macroblocchi|Deviation, macro-blocks", shown="%", digits=2)
    ]


@dataclass(frozen=True)
class MacroBlock:
    """Blocks that move as one, every number rounded to the figures that are printed and that the check is made with.

    `macro_block`: its number; `blocks`: how many it is made of; (x_G_m, z_G_m) its centroid, (x_C_m, z_C_m) its centre
    of rotation, None for a translation; `omega` rad, `delta_x` and `delta_z` m: the motion of the centroid, scaled so
    that the largest one in the mechanism is 1 m. Of a drawing far from (0, 0) places count from its origin: four
    figures would not tell them apart.
    """

    state: str
    direction: Direction
    macro_block: Annotated[int, named("N.|No.")]
    members: list[int]
    blocks: int
    weight_kN: float
    seismic_weight_kN: float
    x_G_m: Annotated[float, named("x_G")]
    z_G_m: Annotated[float, named("z_G")]
    omega: Annotated[float, named("ω", unit="rad")]
    x_C_m: Annotated[float | None, named("x_C", null="none")]
    z_C_m: Annotated[float | None, named("z_C", null="none")]
    delta_x: Annotated[float, named("δ_x", unit="m")]
    delta_z: Annotated[float, named("δ_z", unit="m")]

    @property
    def work_load(self) -> float:
        """Work of the seismic weight along the loads, W_s δ_x, kNm."""
        return sense(self.direction) * self.seismic_weight_kN * self.delta_x

    @property
    def work_weight(self) -> float:
        """Work against the weight, W δ_z, kNm."""
        return self.weight_kN * self.delta_z


def macro_blocks(results: Results, state: str, direction: Direction) -> list[MacroBlock]:
    """Group the blocks of a mechanism that move as one, the largest group first."""
    (weight, seismic), origin = weights(results), np.array(results.geometry.origin_m or (0.0, 0.0))
    groups, largest = _groups(results, state, direction)
    rigid, found = rigid_push(results, state, direction), []
    places = outlines(results).moved(rigid.mechanism_configuration).centroids
    rate = np.asarray(rigid.mechanism.displacements, dtype=float)
    for number, own in enumerate(sorted(groups, key=lambda own: (-weight[own].sum(), own)), 1):
        share = weight[own] / weight[own].sum()
        centroid, motion = share @ places[own] - origin, share @ rate[own] / largest
        omega, *centre = rotation(centroid, motion)
        numbers = (weight[own].sum(), seismic[own].sum(), *centroid, omega, *centre, *motion[:2])
        rounded: Any = (None if value is None else _rounded(value) for value in numbers)
        found.append(MacroBlock(state, direction, number, own, len(own), *rounded))
    return found


def rotation(centroid: Array, motion: Array) -> tuple[float, float | None, float | None]:
    """Return ω (rad) of a motion (3,) of the centroid and its centre (m); 0 and None for a translation."""
    dx, dz, omega = motion.tolist()
    if abs(omega) < TURNING:
        return 0.0, None, None
    return omega, centroid[0] - dz / omega, centroid[1] + dx / omega


def _groups(results: Results, state: str, direction: Direction) -> tuple[list[list[int]], float]:
    """Return the blocks of a mechanism that move as one, and the largest displacement of a group in the results."""
    rigid = rigid_push(results, state, direction)
    rate = np.asarray(rigid.mechanism.displacements, dtype=float)
    drawn = outlines(results)
    at = np.asarray(rigid.mechanism_configuration)
    shape = drawn.moved(at)
    speed = np.linalg.norm(field(shape.points, shape.owner, shape.centroids, rate), axis=1)
    fastest = float(speed.max())
    moving = np.zeros(len(rate), dtype=bool)
    np.maximum.at(moving, shape.owner, speed > STILL * fastest)
    pairs = np.array([joint.blocks for joint in results.geometry.joints], dtype=np.intp).reshape(-1, 2)
    ends = np.array([joint.ends_m for joint in results.geometry.joints], dtype=float).reshape(-1, 2)
    first, second = np.repeat(pairs, 2, axis=0).T
    points = place(ends, first, drawn.centroids, at)
    slip = field(points, first, shape.centroids, rate) - field(points, second, shape.centroids, rate)
    apart = np.linalg.norm(slip, axis=1).reshape(-1, 2).max(axis=1)  # of both ends of a joint
    group = connected(pairs[(apart < TOGETHER * fastest) & moving[pairs].all(axis=1)], len(rate))
    weight, _ = weights(results)
    groups = [np.flatnonzero(group == number).tolist() for number in np.unique(group[moving])]
    moved = [weight[own] @ rate[own, :2] / weight[own].sum() for own in groups]
    return groups, max(float(np.hypot(*each)) for each in moved)


def takers(results: Results, state: str, direction: Direction) -> list[tuple[str, float]]:
    """Return ties that yield in a mechanism and friction with the work (kNm) they take, as printed.

    It is scaled as that of the macro-blocks, and of figures rounded to those of the check.
    """
    rigid = rigid_push(results, state, direction)
    rate, at = np.asarray(rigid.mechanism.displacements, dtype=float), rigid.mechanism_configuration
    longer = zip(ties_of(results, state), lengthening(results, state, at, rate).tolist(), strict=True)
    _, size = _groups(results, state, direction)
    pulled = {each.tie: each.peak_kN or 0.0 for each in rigid.ties or ()}
    found = [
        (tie.name, _rounded(tie.yield_force_kN) * _rounded(more / size))
        for tie, more in longer
        if tie.yield_force_kN is not None
        and more > STILL * size
        and pulled[tie.name] > (1.0 - TAUT) * tie.yield_force_kN
    ]
    friction = (rigid.mechanism.friction_work_kNm or 0.0) / size
    return [*found, ("Σ T v", _rounded(friction))] if friction > NOTHING else found


def hand_checks(results: Results) -> Iterator[HandCheck]:
    """Yield the hand check of every mechanism whose multiplier by virtual work is known."""
    for name, direction, rigid in mechanisms(results):
        if rigid.virtual_work_alpha is not None and rigid.alpha_0:
            computed, by_blocks = rigid.mechanism.alpha, rigid.virtual_work_alpha
            figures = macro_blocks(results, name, direction)
            by_hand = multiplier(figures, takers(results, name, direction))
            whole, hand = by_blocks / computed - 1.0, by_hand / computed - 1.0
            yield HandCheck(name, direction, len(figures), computed, by_blocks, whole, by_hand, hand)


def governing_mechanisms(results: Results) -> list[tuple[str, Direction]]:
    """Return each state with the direction in which its multiplier is least, the first one of equals."""
    least: dict[str, tuple[Direction, float]] = {}
    for name, direction, rigid in mechanisms(results):
        if name not in least or rigid.alpha_0 < (1.0 - EQUAL) * least[name][1]:
            least[name] = direction, rigid.alpha_0
    return [(name, direction) for name, (direction, _) in least.items()]


def governing_view(results: Results) -> tuple[str, Direction] | None:
    """Return state and direction of the rigid mechanism that governs; None where there is none."""
    pushed = {(name, direction): rigid.alpha_0 for name, direction, rigid in mechanisms(results)}
    least = results.summary.governing
    if least and (least.state, least.direction) in pushed:
        return least.state, least.direction
    return min(pushed, key=lambda view: pushed[view], default=None)


def virtual_work_table(figures: Sequence[MacroBlock], taken: Sequence[tuple[str, float]] = ()) -> Table:
    """List the macro-blocks of a mechanism, and what takes work, with their virtual work, and the sums of both."""
    works = [{"work_load": each.work_load, "work_weight": each.work_weight} for each in figures]
    rows: list[Row] = [asdict(each) | work for each, work in zip(figures, works, strict=True)]
    summed = ("blocks", "weight_kN", "seismic_weight_kN", "work_load")
    total: Row = {"macro_block": "Σ"} | {key: sum(row[key] for row in rows) for key in summed}
    rows += [{"macro_block": name, "work_weight": work} for name, work in taken]
    columns = columns_of(MacroBlock)[2:]  # state and direction stand in the caption
    total["work_weight"] = work_taken(figures, taken)
    return Table("macro_blocks", [*rows, total], (*columns, "work_load", "work_weight"))


def work_taken(figures: Sequence[MacroBlock], taken: Sequence[tuple[str, float]]) -> float:
    """Return the work against the weights, Σ W δ_z, of ties that yield, Σ F e, and of friction, Σ T v, kNm."""
    return sum(each.work_weight for each in figures) + sum(work for _, work in taken)


def multiplier(figures: Sequence[MacroBlock], taken: Sequence[tuple[str, float]] = ()) -> float:
    """Return α = (Σ W δ_z + Σ F e + Σ T v)/Σ W_s δ_x of the figures of a mechanism, δ_x along the loads."""
    return work_taken(figures, taken) / sum(each.work_load for each in figures)


def mechanisms(results: Results) -> Iterator[tuple[str, Direction, RigidPush]]:
    """Yield state, direction and the rigid results of every mechanism."""
    for name, state in results.states.items():
        for direction, pushover in state.pushover.items():
            if pushover.rigid:
                yield name, direction, pushover.rigid


def rigid_push(results: Results, state: str, direction: Direction) -> RigidPush:
    """Return the rigid results of a mechanism that is there."""
    return known(results.states[state].pushover[direction].rigid)


def weights(results: Results) -> tuple[Array, Array]:
    """Return weights and seismic weights (b,) kN, worked out from outlines, depths and the project's own figures."""
    weight, seismic = [], []
    for block in results.geometry.blocks:
        given = material(results.echo, block)
        unit_weight = float(given.get("unit_weight_kN_m3") or 0.0)
        stone = unit_weight * block.depth_m * outline_area(block.vertices_m)
        load = block.vertical_load_kN
        weight.append(stone + load)
        seismic.append(stone + (load if given.get("load_has_mass", True) else 0.0))
    return np.array(weight), np.array(seismic)


def outline_area(vertices: Any) -> float:
    """Return the area of a simple polygon in m² (shoelace)."""
    x, z = (np.asarray(vertices, dtype=float) - vertices[0]).T  # the products with the first vertex are 0
    return float(abs(np.dot(x[:-1], z[1:]) - np.dot(z[:-1], x[1:])) / 2.0)


def _rounded(value: float) -> float:
    return 0.0 if abs(value) < NOTHING else float(f"{value:.{FIGURES - 1}e}")


def block_size(results: Results) -> float:
    """Return the usual size of a block, m: the median of the roots of their areas."""
    return float(np.median([outline_area(block.vertices_m) ** 0.5 for block in results.geometry.blocks]))
