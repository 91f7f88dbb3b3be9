"""What a time history begins with (paper, §3): base, integrator, steps by the periods of its joints, state at rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import ConvergenceError, NoEquilibriumError, UnstableError, array_of, is_number, require
from mechanics.kernels.joint import H
from mechanics.kernels.law import BED, LEFT, SHEAR, bed_forces
from mechanics.kernels.linalg.factors import cholesky, substitute
from mechanics.kernels.matrix import diagonal, stiffen
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.model.block import connected
from mechanics.model.contacts import end_gaps
from mechanics.solvers.elimination import Elimination
from mechanics.steps.dynamic_system import DynamicSystem, Halving, Motion
from mechanics.steps.equilibrium import check_self_weight, rest, rest_size
from mechanics.steps.rest import come_down, way
from mechanics.steps.static_system import Sliding, carried, static_system
from mechanics.steps.tolerances import REST
from mechanics.types import GRAVITY, Array

RIGID_SHEAR = 1e3  # tangential over normal stiffness that replaces an infinite one in the first frequency

Integrator = Literal["auto", "moreau-jean", "second-order", "implicit-euler"]


@dataclass(frozen=True, slots=True)
class HistoryTolerances:
    """Tolerances of a time history.

    Halving of steps. `few`: most movable blocks for which every impact is located; `located`, second order with rigid
    joints: steps down to 1/1024 at impacts; `resolved`, Moreau and Jean: down to 1/64 where impacts take energy;
    `closing`, second order with elastic joints. Elastic joints by either rule: at most `contacts` times, until half the
    period of the stiffest contact has `steps_a_contact` steps. `unsolved`, implicit Euler: only steps that are not
    solved are halved.

    `accepted`: residual of a program, per weight and span; `skips`: whether rest is skipped; `chunk`: steps after which
    collapse is looked for; `checked`: steps of which one is checked against the model.

    Warnings. `balanced`: imbalance, as a share of the energy turned over, that needs none; `lifting`: share of the
    programs that are solved by the associative law which needs none; `slides`: error of slides that needs none, where
    friction takes more than the share `rubs` of the energy; `nothing`: energy, as a share of the weight lifted by a
    block's size, below which nothing moves; `rests`, rigid, and `trembles`, elastic joints: speed, of √(g·size), below
    which a block rests, the largest in the last `lately` s; `spent`: share of the potential energy from which the
    structure has come back, with less of which it does not fall.
    """

    few: int = 3
    located: Halving = Halving(10, 1e-4, of_moment=True)
    resolved: Halving = Halving(6, 4e-3, unsure=1e-4)
    closing: Halving = Halving(10, 2.5e-4, unsure=1e-4)
    contacts: int = 10
    steps_a_contact: int = 8
    unsolved: Halving = Halving(0, np.inf)
    accepted: float = 1e-7
    skips: bool = True
    chunk: int = 200
    checked: int = 100
    balanced: float = 1e-4
    lifting: float = 1e-3
    slides: float = 0.02
    rubs: float = 0.05
    nothing: float = 1e-6
    rests: float = 1e-5
    trembles: float = 1e-2
    lately: float = 0.5
    spent: float = 0.5


HISTORY = HistoryTolerances()


def base_acceleration(horizontal: ArrayLike, vertical: ArrayLike | None, time_step: float) -> Array:
    """Return the base acceleration (k, 3) in m/s²: x, z, and 0 for the rotation.

    Raises ArgumentError for what is no acceleration.
    """
    require(is_number(time_step) and 0.0 < time_step < np.inf, "time_step", time_step, "positive, in s")
    given = {"acceleration": horizontal} | ({} if vertical is None else {"vertical_acceleration": vertical})
    components = {
        name: array_of(name, values, "two or more samples, (k,), in g") for name, values in given.items()
    }
    a = components["acceleration"]
    require(a.ndim == 1 and len(a) > 1, "acceleration", a.shape, "two or more samples, (k,), in g")
    base = np.zeros((len(a), 3))
    for axis, (name, values) in enumerate(components.items()):
        require(values.shape == a.shape, name, values.shape, f"of the horizontal one's shape {a.shape}")
        require(bool(np.isfinite(values).all()), name, "nan or inf", "finite")
        base[:, axis] = GRAVITY * values
    return base


def check_arguments(
    model: Assembly, contacts: Behaviour, integrator: Integrator, damping_ratio: float, restitution: float
) -> None:
    """Raise ArgumentError for contacts that cannot move so, and what the contacts do not have of the others."""
    require(contacts == "elastic" or not model.crushes, "contacts", contacts,
            '"elastic" where joints have a compressive_strength: rigid ones forget what was crushed')  # fmt: skip
    names = ("auto", "moreau-jean", "second-order", "implicit-euler")
    require(integrator in names, "integrator", integrator, ", ".join(f'"{name}"' for name in names))
    require(
        is_number(damping_ratio) and 0.0 <= damping_ratio < 1.0,
        "damping_ratio",
        damping_ratio,
        "from 0 to less than 1",
    )
    require(damping_ratio == 0.0 or contacts == "elastic", "damping_ratio", damping_ratio,
            "0 with rigid contacts, which have no stiffness to be proportional to")  # fmt: skip
    require(is_number(restitution) and 0.0 <= restitution <= 1.0, "restitution", restitution, "from 0 to 1")
    require(restitution == 0.0 or (contacts == "rigid" and integrator != "implicit-euler"), "restitution", restitution,
            "0 except with rigid contacts and an integrator of second order")  # fmt: skip


class Rule(NamedTuple):
    """The integrator that is used, how often its steps are halved, and what there is to say of both."""

    integrator: Integrator
    halving: Halving
    why: str


def chosen_rule(
    model: Assembly, contacts: Behaviour, integrator: Integrator, time_step: float, tolerances: HistoryTolerances
) -> Rule:  # fmt: skip
    """Return by what rule a motion in steps of a length (s) is integrated."""
    used, why = _chosen_integrator(model, contacts, integrator, tolerances.few)
    halving, resolved = _chosen_halving(model, contacts, used, time_step, tolerances)
    return Rule(used, halving, why + resolved)


def _chosen_integrator(
    model: Assembly, contacts: Behaviour, integrator: Integrator, few: int
) -> tuple[Integrator, str]:
    """Return the integrator that is used, and why; `few`: see HistoryTolerances."""
    if integrator != "auto":
        return integrator, "as asked for"
    if contacts == "elastic":
        return "second-order", "elastic joints: steps are halved where closing joints take energy"
    movable = int(model.movable.sum())
    if movable <= few:
        return "second-order", f"{movable} movable blocks: every impact is located"
    return "moreau-jean", f"{movable} movable blocks: many impacts, resolved where they take energy"


def begun_motion(
    model: Assembly, contacts: Behaviour, sliding: Sliding, state: State, rule: Rule, damping_ratio: float,
    restitution: float, tolerances: HistoryTolerances,
) -> tuple[DynamicSystem, State, Motion, Message | None]:  # fmt: skip
    """Return the system, the state in which the motion begins, the motion, and a warning about that state.

    Raises ArgumentError for a damping ratio where nothing holds some block.
    """
    start, forces, undecided = _settled(model, contacts, sliding, state)
    statics = static_system(model, contacts, sliding).around(start.positions, 0.0)
    gaps = np.zeros(len(statics.contacts))
    if contacts == "rigid":
        # dilatant sliding leaves gaps in joints that carry: loose blocks must not fall through them
        gap = end_gaps(statics.places(start.positions, start)).min(axis=1).clip(0.0)
        gaps = np.where(carried(statics.contacts, start), gap, 0.0)
    theta = 1.0 if rule.integrator == "implicit-euler" else 0.5
    damping, accepted = _damping(model, damping_ratio), tolerances.accepted
    system = DynamicSystem(
        statics, theta, damping, restitution, rule.halving, accepted, skips=tolerances.skips
    )
    if forces is not None and len(forces) != len(statics.contacts):
        forces = None
    return system, start, system.begun(start, forces, gaps), undecided


def _damping(model: Assembly, damping_ratio: float) -> float:
    """Return viscous forces over elastic ones, s, that damp the first frequency as drawn by a share of critical."""
    if damping_ratio == 0.0:
        return 0.0
    frequency = first_frequency(model)
    require(frequency > 0.0, "damping_ratio", damping_ratio,
            "0 where nothing holds some block as drawn: there is no frequency to refer it to")  # fmt: skip
    return 2.0 * damping_ratio / frequency


def _chosen_halving(
    model: Assembly, contacts: Behaviour, integrator: Integrator, time_step: float, tolerances: HistoryTolerances
) -> tuple[Halving, str]:  # fmt: skip
    """Return when steps are halved, and how often, and what there is to say of it."""
    if integrator == "implicit-euler":
        return tolerances.unsolved, ""
    if contacts == "rigid":
        return tolerances.located if integrator == "second-order" else tolerances.resolved, ""
    halving = tolerances.closing if integrator == "second-order" else tolerances.resolved
    if int(model.movable.sum()) <= tolerances.few:
        halving = replace(halving, of_moment=True)
    if halving.levels == 0:
        return halving, ""
    half_period = np.pi * contact_period(model)
    asked = max(int(np.ceil(np.log2(tolerances.steps_a_contact * time_step / half_period))), 0)
    levels = min(asked, tolerances.contacts)
    halving, shortest = replace(halving, levels=levels), 1e3 * time_step / 2**levels
    if levels < asked:
        return halving, (
            f"; down to {shortest:.2g} ms: contacts of the stiffest joint last {1e3 * half_period:.2g} ms and are "
            "impacts without bounce"
        )
    return halving, f"; down to {shortest:.2g} ms, contacts of the stiffest joint are resolved"


def contact_period(model: Assembly) -> float:
    """Return √(m/k), s, of the stiffest joint as drawn, m the reduced mass: a contact lasts π times it."""
    contacts, mass = model.contacts, np.where(model.movable, model.mass[:, 0], np.inf)
    contacts = contacts.take(np.flatnonzero(~contacts.ties))
    stiffness = contacts.bed * 2.0 * contacts.places(model.initial.positions)[:, H]
    with np.errstate(divide="ignore"):
        lightness = 1.0 / mass[contacts.a] + 1.0 / mass[contacts.b]
    return float(1.0 / np.sqrt((stiffness * lightness).max(initial=1e-300)))


def first_frequency(model: Assembly) -> float:
    """Return the lowest circular frequency (rad/s) of the blocks as drawn: all joints closed and sticking, ties taut.

    It is 0 if some blocks are loose.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    system = static_system(model, "elastic")
    layout = Elimination.of(system.dof, model.initial.positions[model.movable, :2])
    places = system.contacts.places(model.initial.positions)
    ties, normal = system.contacts.ties, system.law[:, BED] * 2.0 * places[:, H]
    with np.errstate(divide="ignore"):
        shear = np.minimum(1.0 / system.law[:, SHEAR], RIGID_SHEAR * normal)
    mass, stored = model.mass[model.movable].ravel()[layout.order], layout.triangle()
    diagonal(np.zeros(len(mass)), stored, layout.pattern)
    for k, (i, j) in enumerate(layout.row):
        # all of it pressed, none crushed
        _, _, _, _, turns = bed_forces(system.law[k], np.inf, system.law[k, LEFT:], places[k, H], -1.0, 0.0)
        turns, slides = (0.0, 0.0) if ties[k] else (turns, shear[k])
        law = np.diag([normal[k], turns, slides]).ravel()
        stiffen(k, places[k], i, j, law, stored, layout.pattern)
    if _some_are_loose(model) or not cholesky(stored, layout.pattern):
        return 0.0
    root = np.sqrt(mass)

    def flexibility(x: Array) -> Array:
        y: Array = root * x.ravel()
        substitute(stored, stored, layout.pattern, y)
        return root * y

    operator = LinearOperator((len(mass), len(mass)), matvec=flexibility, dtype=float)
    largest = eigsh(operator, k=1, which="LA", v0=root, return_eigenvectors=False)
    # with few distinct modes ARPACK restarts from random vectors, and its last digits are not repeatable
    return float(f"{1.0 / np.sqrt(largest[0]):.10g}")


def _some_are_loose(model: Assembly) -> bool:
    """Whether some block is connected to no support by joints (a frequency of rounding alone might hide it)."""
    part = connected(model.joints.blocks, len(model.blocks))
    return not np.isin(part, part[~model.movable]).all()


def _settled(
    model: Assembly, contacts: Behaviour, sliding: Sliding, state: State
) -> tuple[State, Array | None, Message | None]:
    """Return the state in which the motion begins, and its joint forces (j, 3); None where they are not known.

    What cannot stand is released as it is; what only may not, too, with a warning.
    """
    if contacts == "rigid" or state.velocities.any():
        return state, None, None
    size = rest_size(model, contacts)
    try:
        if state.carrying is None:
            check_self_weight(model, state)
        system = static_system(model, contacts, sliding).around(state.positions, size)
        step = come_down(rest(system, state), size)
        # the joints of a pushed state carry the push too: that it stands without it has to be checked
        if (
            state.carrying is not None
            and way(state.positions, step.state.positions, model.size) > REST.lifted * model.size
        ):
            check_self_weight(model, state)
    except (UnstableError, NoEquilibriumError):
        return state, None, None
    except ConvergenceError as error:
        released = message(
            "whether the structure rests on its elastic joints before the motion was not decided: {reason}; it is "
            "released as it is", reason=error.message,
        )  # fmt: skip
        return state, None, released
    return replace(step.state, motion=None), step.forces, None
