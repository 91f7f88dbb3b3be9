"""The tolerances of static steps, of coming to rest, and of limit analysis."""

from __future__ import annotations

from dataclasses import dataclass

from mechanics.model.assembly import Behaviour


@dataclass(frozen=True, slots=True)
class StepTolerances:
    """Of the search for an equilibrium in its own displaced geometry.

    Programs. `rigid`, `elastic`: residuals, per weight and step, to which the programs are solved before the geometry
    is updated (rigid joints have no give in a wrong geometry); the last one is repeated, at most `rigid_rounds` or
    `elastic_rounds` times. `begin`: distance from the bounds, per weight and step, at which the first program begins
    near an earlier solution; `go_on`: the same of the next ones, per residual of the last. `slip_rounds`: programs in
    which Coulomb slips are updated; `slip_gap`: of a step, a gap left by slips that changed.

    What is accepted. `rigid_certificate`, `elastic_certificate`: of the forces in the geometry to which they lead;
    `slow`: the same where forces and geometry approach each other only slowly. `fall`: a motion so many times the step
    is a fall, not a path of equilibrium; `turn` (rad): a step that turns a block by more leaves the range in which its
    geometry is linear.

    Contacts. `carrying`: of the weight, the least force of a joint that carries; of the block size, `no_overlap`: an
    overlap that is none, `inside`: a penetration that is one, `look_ahead`: how far beyond a step contacts are looked
    for. `least_friction`: of a joint without friction.

    Short steps. `short`: of the block size, their length; `fewest`: of a step; `short_time`: of each, in units of
    √(size/g), so long that inertia hardly counts;
    `inertia`: of the weight, that of a structure that falls.
    """

    rigid: tuple[float, ...] = (1e-5, 1e-8)
    elastic: tuple[float, ...] = (1e-2, 1e-4, 1e-6, 1e-8)
    rigid_rounds: int = 8
    elastic_rounds: int = 12
    begin: float = 0.03
    go_on: float = 0.1
    slip_rounds: int = 6
    slip_gap: float = 1e-3
    rigid_certificate: float = 1e-8
    elastic_certificate: float = 1e-6
    slow: float = 1e-5
    fall: float = 10.0
    turn: float = 0.5
    carrying: float = 1e-6
    no_overlap: float = 1e-9
    inside: float = 1e-6
    look_ahead: float = 0.05
    least_friction: float = 1e-9
    short: float = 1e-2
    fewest: int = 4
    short_time: float = 4.5
    inertia: float = 1e-6

    def residuals(self, behaviour: Behaviour) -> tuple[float, ...]:
        """The residuals to which the programs of joints of a behaviour are solved before the last one is repeated."""
        return self.rigid if behaviour == "rigid" else self.elastic

    def certificate(self, behaviour: Behaviour) -> float:
        """The certificate that ends the repetition."""
        return self.rigid_certificate if behaviour == "rigid" else self.elastic_certificate

    def rounds(self, behaviour: Behaviour) -> int:
        """The most programs that are solved to the last of these residuals, after the first such."""
        return self.rigid_rounds if behaviour == "rigid" else self.elastic_rounds


@dataclass(frozen=True, slots=True)
class RestTolerances:
    """Of a motion with reset velocities.

    In units of √(size/g): `first`, the time of the first step, `longest` of one that hardly moves. Of the block size:
    `way`, what a step moves; `still`: what one of unit time moves at rest; `lifted`: the gaps of joints that carry;
    `farthest`: the longest way, beyond which it has run away (a turn of 1 rad counts as 1): what leaves its seat or
    topples has collapsed, though it may rest where it fell. `steps`: the most.
    """

    first: float = 0.5
    longest: float = 5.0
    way: float = 0.01
    still: float = 1e-5
    lifted: float = 5e-5
    steps: int = 200
    farthest: float = 0.3


@dataclass(frozen=True, slots=True)
class LimitTolerances:
    """Of limit analysis.

    Of the block size, `closed`: a gap that is none (dilatant sliding leaves some in a settled state), `onset`: the
    displacement of a mechanism at its onset. `far`: such displacements, the gap of an end that is open. `repeats`: the
    most programs with Coulomb friction after the first; `slip_gap`: of the onset, a gap left by slips that changed.
    """

    closed: float = 1e-3
    onset: float = 1e-3
    far: float = 1e3
    repeats: int = 12
    slip_gap: float = 1e-3


STEP = StepTolerances()
REST = RestTolerances()
LIMIT = LimitTolerances()
