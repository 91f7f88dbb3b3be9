"""The tolerances of static steps, of coming to rest, and of limit analysis."""

from __future__ import annotations

from dataclasses import dataclass

from mechanics.model.assembly import Behaviour
from mechanics.solvers import GOOD, USABLE


@dataclass(frozen=True, slots=True)
class StepTolerances:
    """Tolerances of the search for an equilibrium in its own displaced geometry.

    Programs. `rigid`, `elastic`: residuals, per weight and step, to which the first programs are solved before the
    geometry is updated (rigid joints yield nothing in a wrong geometry; gaps of blocks that carry little are known to
    the root of the residual, and they are the next geometry); a program with the last residual is repeated at most
    `rounds` times. `go_on`: distance from the bounds at which the next programs begin, over the residual of the last,
    and near one whose geometry was held; `wider`: so many times farther after one whose geometry may change and that
    was not solved to it, and sticks near its bounds. `yielding`: compliance, in steps per weight, of rigid joints to
    changes of their forces by Coulomb's law; `memory`: programs of a step after which these count from the same forces;
    `held`: programs of a step of rigid joints in held geometries, before forces change with the geometry in them.

    Acceptance. `slow`: residual, per weight and step, of what approaches its solution only slowly: forces and geometry
    of rigid joints, a rest of elastic ones, a program by Coulomb's law within the sequence. `fall`: a motion of this
    many steps is a fall, not a path of equilibrium.

    Contacts. `carrying`: least force of a joint that carries, as a share of the weight. As shares of the block size:
    `rounding`, a motion or distance that is none; `inside`, least penetration that counts; `look_ahead`, distance
    beyond a step within which contacts are looked for.

    Flows. `slides`: slip of a joint that slides, as a share of a step; `touching`: gap or slip, as a share of a step,
    that is none; `sticks`: share of its friction that a joint that sticks has more.
    """

    rigid: tuple[float, ...] = (1e-5, 1e-8, 1e-10)
    elastic: tuple[float, ...] = (1e-4, 1e-10)
    rounds: int = 16
    go_on: float = 0.1
    wider: float = 100.0
    yielding: float = 3e-4
    memory: int = 2
    held: int = 7
    slow: float = 1e-5
    fall: float = 10.0
    carrying: float = 1e-6
    rounding: float = 1e-10
    inside: float = 1e-6
    look_ahead: float = 0.05
    slides: float = 1e-3
    touching: float = 1e-7
    sticks: float = 1e-4

    def residuals(self, behaviour: Behaviour) -> tuple[float, ...]:
        """Return the residuals of the programs for joints of a behaviour; the last one is repeated."""
        return self.rigid if behaviour == "rigid" else self.elastic

    def certificate(self, behaviour: Behaviour) -> float:
        """Return the certificate, of the forces in the geometry that they lead to, that ends the repetition."""
        return GOOD if behaviour == "rigid" else USABLE


@dataclass(frozen=True, slots=True)
class RestTolerances:
    """Tolerances of a motion whose velocity is reset in every step.

    `rigid`, `elastic`: residuals, per weight and step, of its programs. Gaps are known to 1/WIDE times as much;
    where gaps of beds err by the length of a step, a motion turns back and rests where there is no equilibrium.
    `first`, in units of √(size/g): time of the first step. `stride`: motion in a step, as a share of the whole motion
    so far, and at least `way`. As shares of the block size: `way`; `lifted`, gap of joints that carry; `farthest`, way
    beyond which a block runs away (1 rad counts as 1): a block that leaves its seat or topples has collapsed, even if
    it comes to rest where it falls. `steps`: largest number of steps. `jump`: times the intended motion of a step, a
    longer one is a jump, or another solution of a program that is not convex; `faster`: times the way to which the last
    step leads, of a support or of a motion, likewise; `growth`: factor from one time step to the next, at most;
    after the n-th step that fails the time grows no sooner than n steps later; `steady`: share of the unbalanced force
    half-way that is left at the end of a motion that does not slow down.
    """

    rigid: float = 1e-7
    elastic: float = 1e-9
    first: float = 0.5
    way: float = 0.01
    stride: float = 0.2
    lifted: float = 5e-5
    steps: int = 400
    farthest: float = 0.3
    jump: float = 2.0
    faster: float = 3.0
    growth: float = 1.3
    steady: float = 0.9


@dataclass(frozen=True, slots=True)
class LimitTolerances:
    """Tolerances of limit analysis.

    As shares of the block size: `closed`, gap that counts as closed; `onset`, displacement of a mechanism at its onset.
    `repeats`: most programs for hinges that crush, of which after a quarter none moves back to its edge; `tries`: as
    many flows in a row lead to no lesser multiplier by Coulomb's law, fewer where they have more than `tried` joints in
    all; `other`: most that their frictions are changed by, as a share; `turn`: each so many of them is of the same
    frictions. `slight`: shares of μ|slip| by which joints lift where Coulomb's law has no flow, in turns; `idle`:
    force, per weight, or motion, per `onset`, that is none; `most_joints`: of a model whose least multiplier is sought:
    the linear programs grow faster than the flow's own.
    """

    closed: float = 1e-3
    onset: float = 1e-3
    repeats: int = 24
    tries: int = 64
    tried: int = 6000
    other: float = 0.5
    turn: int = 4
    slight: tuple[float, ...] = (1e-3, 1e-2)
    idle: float = 1e-9
    most_joints: int = 5000


STEP = StepTolerances()
REST = RestTolerances()
LIMIT = LimitTolerances()
