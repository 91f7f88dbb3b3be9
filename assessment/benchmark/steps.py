"""Time of a dynamic step, elastic and rigid, and how it grows with the number of blocks.

The state at rest from which a motion begins is not counted. `geometry_ms` and `solve_ms` (the Newton solver) are
milliseconds a step; `repeated` is the share of the solves that repeated the last contact states. Times are elapsed;
those of PIQP are processor times.

Tried, and not kept (wall 18 x 19, elastic, strong motion): semismooth Newton alone, with augmented Lagrangian rounds
and an exact line search, 38 to 50 factorisations a step where the interior point method takes 8 (line searches end at
the next contact that slips). Of the interior point method, 5.9 iterations a step of which each costs 0.33 ms:
Gondzio's correctors, one and two, 5.3 and 5.0 iterations at 0.07 ms each; a start on the central path through the
last solution, 5.5, but 12 where arches take 8.8; one from forces and gaps extrapolated over two steps, 7.4, and 19
where the midpoint rule takes 10; from those of the last but one, 8.7 where the midpoint rule takes 8.3; from their
mean over the last ones (which serves the midpoint rule with elastic joints, that lets them ring: triumphal arch 13.0,
not 16.0, arch on piers 8.5, not 10.9), 7.3 where implicit Euler takes 7.0, and 4.7 where rigid joints take 4.3; one
from the last iterate of semismooth Newton, 6 to 9; another distance from the cone (a third, double), 5.6 and 6.3, for
arches the other way round; of the forces or of the gaps alone, a tenth to ten times, 5.4 to 7.0 where 6.2 (implicit
Euler, a quarter of a second), for arches 6.2 to 11.3 where 6.3 and 10.6, for 1008 blocks 9.0 to 10.7 where 10;
another power for the centring, 6.6 and 5.6, or share of the way to the cone, 5.9 to 6.3. Contacts that are too far
open to touch in a step, left out and checked afterwards: in the steps of these cases fewer than one in fifty are open
by more than a step's displacement, and the time stays the same. Tiles of 16 x 6 and 16 x 12 in the factorisation:
0.15 and 0.17 ms where 8 x 6 take 0.13, and 0.20 if they leave the registers before they are a part of the factor;
LAPACK 0.47; loops that leave the vectors to the compiler, 0.60. Contact points side by side instead of by columns:
their loops take 0.20 ms an iteration, not 0.13; columns a run after the other, not the first points of many runs,
then the second ones, in loops over few enough for the compiler to look whether they overlap: 0.13, not 0.09.
Substitutions that take six columns at a time, not three: 26 microseconds, not 22.

The certificate's complementarity is a sum over the contact points, so that a block of this wall is held to eleven
times the precision of one of the buttressed arch. Allowed for by the number of blocks (1e-5 instead of 1e-6), a step
takes 6.4 iterations, not 7.8 (2 s, 5 % damping), but the motion of the wall's top is off that of 1e-10 by 0.10 % of
its peak, not by 0.02 % (arch at 1e-6: 0.07 %), its peak without damping by 0.27 %, not 0.03 %. At 3e-6: 7.1
iterations, 0.05 %, 0.16 %.

The exponent, over 95 to 2997 blocks: the iterations alone grow from 4.5 to 11 a step (elastic), from 3.2 to 5.3
(rigid), a power of 0.25 and 0.15. The fronts of a nested dissection need 7.2 and 37 million products a factorisation of
the walls of 1008 and 2997 blocks where the band has 14 and 124 (250 and 1250 at 10 050), and take 0.55 and 2.4 ms
where it takes 0.80 and 6.0; a substitution 0.45 ms at 2997 blocks, not 1.6. Of 351 blocks they need 1.3 million
products, not 1.8, in the same time, and lose in substitutions: there the band stays. Parts of 4 to 20 blocks left
undivided, more directions and shares of the dividing lines: the same within a tenth. Substitutions whose loops were
functions of their own, called for every three columns: 0.051 ms at 351 blocks, not 0.026.

Of the iterations at 2997 blocks (elastic, the first ten steps, 12.2): one, two, three and six of Gondzio's correctors
10.4, 9.3, 9.1 and 8.4, each at a fifth of an iteration; Mehrotra's corrector by the best of nine shares 12.0, with one
of Gondzio's 9.8; a distance from the cone of a tenth to ten times 12.9 to 13.4 (the first fifteen: 12.8). Steps that a
few rays in a thousand do not hold up, these being stopped at the cone: 23 where 10 (1008 blocks), since what they lack
of equilibrium comes back. Semismooth Newton from the iterates: it finds the solution from the last two or three only,
by three to six factorisations.

A start that keeps off the cone by as much as solutions change from step to step (see warm_start), not always by a
hundredth of a weight and a step: elastic walls of 95 to 2997 blocks 4.5, 5.8, 8.5 and 10.9 iterations where 4.5, 6.3,
9.0 and 12.1, rigid ones 3.2, 3.6, 4.5 and 5.3 where 3.4, 3.9, 4.9 and 5.5, the triumphal arch 11.1 and 11.3 (second
order) where 11.7 and 12.4; arches of 30 to 70 blocks the same within a tenth; rigid walls of 40 blocks 2.6, not 2.5.
Forces by their whole change, whether rays changed sides or not: 11.3 at 2997 blocks, but rigid 4.9 where 3.5. Gaps no
nearer than 0.002 of a step: 11.2, but rigid walls of 70 blocks 3.2, not 2.9. From products s z all alike where forces
are large: 15. Correctors of Gondzio's only where a step is held up, below a fifth to nine tenths of the way: 12.5 to
10.8 iterations for one to ten of them, at a fifth of an iteration each.

Two threads, each at the blocks on one side of the line that is eliminated last (in an earlier version): one takes 1.6
and 1.7 times as long for a step of the elastic walls of 1008 and 2997 blocks, 1.4 and 1.5 of the rigid ones, where the
second core is free. Given up: the second core serves another analysis.

Substituting into each front as soon as it is eliminated: a thirtieth less. Loops over the contact points with a quarter
fewer numbers to read and write (what s z and z lack not stored, the predictor's right-hand side beside the matrix, its
changes not written): six per cent of an iteration; given up, as it moves the last digits of statics, and with them the
scatter of sliding joints.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import numpy as np

from assessment.artificial_record import RECORD
from assessment.benchmark.dynamics import INTEGRATORS, Integrator
from assessment.benchmark.measure import Row, exponent, newtons_laid_out, peak_memory, piqp, programs_kept
from assessment.benchmark.structures import arch_on_piers, assembly, block_on_base, running_bond, template
from mechanics import Assembly, TimeHistory, time_history
from mechanics.assembly import Behaviour
from mechanics.block import Array
from mechanics.ground_motion import read_record
from mechanics.program import Program
from mechanics.scene import Scene
from mechanics.solvers.newton import Newton

STEP, WINDOW = 0.005, (4.0, 11.0)  # s: of the artificial record that comes with every template
QUICK_WINDOW = (4.0, 5.0)
WALLS = ((9, 10), (18, 19), (31, 32), (54, 55))
QUICK_WALLS = ((6, 6), (9, 10), (14, 14))
SHARE = 0.07  # of the record, for the walls
EVERY = 20  # steps of a block; of so many programs PIQP solves one
ROUNDS, ENOUGH, QUICK = 6, 8.0, 0.0  # at least; and s of a row
PARTS = 4  # of the record in the first of which the parts of a step are watched


@dataclass
class Watch:
    """Time spent in a function."""

    spent: float = 0.0

    @contextmanager
    def of(self, owner: object, name: str) -> Iterator[None]:
        """Watch a method or function of that name."""
        function = getattr(owner, name)

        def watched(*arguments: Any) -> Any:
            began = time.perf_counter()
            result = function(*arguments)
            self.spent += time.perf_counter() - began
            return result

        with patch.object(owner, name, watched):
            yield


def steps(quick: bool) -> Iterator[Row]:
    """A row for every case, contact behaviour and integrator."""
    record = strong_record(QUICK_WINDOW if quick else WINDOW)
    for name, model, pga, share in cases(quick):
        shaking = pga * record[: round(share * len(record))]
        for contacts in ("elastic", "rigid"):
            for integrator in INTEGRATORS:
                yield measured(name, model, shaking, contacts, integrator, QUICK if quick else ENOUGH)


def growth(quick: bool) -> Iterator[Row]:
    """A row for every wall, implicit Euler; and the exponent of the time of a step over the number of blocks."""
    record = strong_record(WINDOW)
    record = 0.55 * record[: round(SHARE * len(record))]

    def wall(columns: int, courses: int, contacts: Behaviour) -> Row:
        model = running_bond(columns, courses, stiffness=1e7)
        enough = QUICK if quick else ENOUGH
        return measured(f"wall {columns} × {courses}", model, record, contacts, "implicit-euler", enough)

    walls = QUICK_WALLS if quick else WALLS
    behaviours: tuple[Behaviour, ...] = ("elastic", "rigid")
    for contacts in behaviours:
        rows = [wall(*size, contacts) for size in walls]
        yield from rows
        yield {"case": "exponent", "contacts": contacts, "step_ms": exponent(rows, "step_ms")}


def strong_record(window: tuple[float, float]) -> Array:
    """Accelerations (k,) of unit peak, STEP apart: a part of the artificial record of the templates, in s."""
    record = read_record(template("triumphal-arch").folder / RECORD).resampled(STEP).windowed(*window)
    return record.acceleration / record.pga


def cases(quick: bool) -> list[tuple[str, Assembly, float, float]]:
    """Name, structure, PGA in g and share of the record: impacts of rigid blocks by the dozen take minutes."""
    some = [
        ("2 blocks", block_on_base(0.6, 4.2, stiffness=1e6), 0.3, 1.0),
        ("buttressed arch", assembly("buttressed-arch", 0.5), 0.05, 1.0),
        ("arch on piers", arch_on_piers(), 0.05, 1.0),
    ]
    if quick:
        return some
    return [
        *some,
        ("wall 18 × 19", running_bond(18, 19, stiffness=1e7), 0.55, 1.0),
        ("triumphal arch", assembly("triumphal-arch"), 0.2, SHARE),
    ]


def measured(
    case: str, model: Assembly, record: Array, contacts: Behaviour, integrator: Integrator, enough: float
) -> Row:
    """Milliseconds a step, their ratio to PIQP once a step, and the counts that do not depend on the clock.

    The motion, and PIQP on every so manieth of its programs, are repeated in turn until they have taken `enough`
    seconds. Of each block of its steps, and of each program, the quickest counts: what else the machine does meanwhile
    is left out of both.
    """

    def run(acceleration: Array) -> TimeHistory:
        return time_history(model, acceleration, STEP, contacts, integrator=integrator)

    run(record[:4])  # what is compiled and laid out once
    counts, programs = _counted(run, record)
    blocks: list[Array] = []
    solved: list[list[float]] = []
    began = time.perf_counter()
    while len(blocks) < ROUNDS or time.perf_counter() - began < enough:
        blocks.append(_blocks(run, record))
        solved.append([piqp(program) for program in programs])
    step = 1e3 * float(np.min(blocks, axis=0).sum()) / counts["steps"]
    each = 1e3 * float(np.min(solved, axis=0).mean())
    return {
        "case": case,
        "blocks": int(model.movable.sum()),
        "points": len(model.contacts(contacts)),
        "contacts": contacts,
        "integrator": integrator,
        "step_ms": step,
        "piqp_ms": each,
        "ratio": step / each,
        "rounds": len(blocks),
        **counts,
        **_parts(run, record[: len(record) // PARTS]),
        "peak_memory_MB": peak_memory(),
    }


def _counted(run: Callable[[Array], TimeHistory], record: Array) -> tuple[Row, list[Program]]:
    """What is counted in a motion, and every so manieth of its programs."""
    with programs_kept(EVERY) as programs, newtons_laid_out() as newtons:
        motion = run(record)
    n, newton = len(motion.time) - 1, newtons[0]  # the second one brings the structure to rest
    counts = {
        "steps": n,
        "solves_per_step": motion.solves / n,
        "factorisations_per_step": newton.factorisations / n,
        "repeated": newton.repeated / max(newton.solved, 1),
        "resolved": motion.resolved,
        "fallbacks": motion.fallbacks,
        "collapsed": motion.collapsed,
    }
    return counts, programs


def _blocks(run: Callable[[Array], TimeHistory], record: Array) -> Array:
    """Time (s) of a motion in blocks of so many steps, without the state at rest that it begins from."""
    histories = sys.modules["mechanics.time_history"]  # its name in the package is the function's
    settled, collapse = histories._settled, histories.collapse
    stamps, steps = [time.perf_counter()], 0

    def at_rest(*arguments: Any) -> Any:
        stamps.append(time.perf_counter())
        state = settled(*arguments)
        stamps.append(time.perf_counter())
        return state

    def after_a_step(*arguments: Any) -> str:
        nonlocal steps
        steps += 1
        if steps % EVERY == 0:
            stamps.append(time.perf_counter())
        return str(collapse(*arguments))

    with patch.object(histories, "_settled", at_rest), patch.object(histories, "collapse", after_a_step):
        run(record)
    stamps.append(time.perf_counter())
    return np.delete(np.diff(stamps), 1)


def _parts(run: Callable[[Array], TimeHistory], record: Array) -> Row:
    """What the parts of a step take; to watch them costs a little itself."""
    geometry, solving = Watch(), Watch()
    with geometry.of(Scene, "geometry"), solving.of(Newton, "solve"):
        n = len(run(record).time) - 1
    return {"geometry_ms": 1e3 * geometry.spent / n, "solve_ms": 1e3 * solving.spent / n}
