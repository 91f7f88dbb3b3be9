"""Records with spikes, of one sample, of a million; steps of time far too long and too short."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from mechanics import Assembly, time_history
from mechanics.errors import ConvergenceError
from mechanics.model.assembly import Behaviour
from mechanics.types import GRAVITY
from tests.stress.harness import Case, sound
from tests.support.structures import arch_on_piers, block_on_base, running_bond

SCHEMES: list[tuple[Behaviour, str]] = [
    ("rigid", "implicit-euler"),
    ("elastic", "implicit-euler"),
    ("rigid", "second-order"),
    ("elastic", "second-order"),
]


def spike(model: Assembly, contacts: Behaviour, integrator: str, g: float) -> None:
    """One sample of many g in a still record: the velocity it leaves is at most its impulse."""
    record = np.zeros(60)
    record[5] = g
    motion = time_history(model, record, 0.005, contacts, integrator=integrator)
    sound(motion)
    assert motion.collapsed or len(motion.time) == 60
    assert motion.worst <= 1e-6
    # the base sheds its impulse on the blocks by friction and contact: none moves faster than a free one, in reason
    impulse = g * GRAVITY * 0.005
    assert abs(motion.velocities[:8, :, 0]).max() <= 2.0 * impulse + 0.1


def sliding(integrator: str) -> None:
    """A flat frictionless block is left behind by its base: it moves with minus the base's motion, however wild."""
    model = block_on_base(2.0, 0.2, friction=0.0)
    rng = np.random.default_rng(3)
    record = np.where(rng.random(300) < 0.05, rng.normal(0.0, 30.0, 300), 0.0)
    record[0] = 0.0
    motion = time_history(model, record, 0.001, "rigid", integrator=integrator)
    sound(motion)
    dt = 0.001
    if integrator == "implicit-euler":
        velocity = -GRAVITY * dt * np.cumsum(np.r_[0.0, record[1:]])
    else:
        velocity = -GRAVITY * dt * np.r_[0.0, np.cumsum(0.5 * (record[1:] + record[:-1]))]
    found = motion.velocities[:, 1, 0]
    np.testing.assert_allclose(found, velocity[: len(found)], atol=1e-6 * abs(velocity).max())


def two_samples(contacts: Behaviour, integrator: str) -> None:
    motion = time_history(block_on_base(), np.zeros(2), 0.005, contacts, integrator=integrator)
    sound(motion)
    assert len(motion.time) == 2


def steps_of(time_step: float, contacts: Behaviour, integrator: str) -> None:
    """A block at rest under a push below its multiplier stays, whatever the step."""
    model = block_on_base(stiffness=1e8)
    motion = time_history(model, np.full(20, 0.1), time_step, contacts, integrator=integrator)
    sound(motion)
    still = abs(motion.positions[-1] - motion.positions[0]).max()
    assert still < (1e-6 if contacts == "rigid" else 1e-3)


def million(collapsing: bool, contacts: Behaviour) -> None:
    """A million samples: a block overturned early ends there, one left alone stays to the end."""
    record = np.zeros(1_000_000)
    if collapsing:
        record[:400] = 1.0
    motion = time_history(block_on_base(), record, 0.001, contacts)
    sound(motion)
    assert motion.collapsed == collapsing
    if not collapsing:
        assert len(motion.time) == len(record)
        assert abs(motion.positions[-1] - motion.positions[0]).max() < 1e-6


def cases() -> Iterator[Case]:
    models = {
        "block": block_on_base(),
        "arch": arch_on_piers(voussoirs=9, courses=3),
        "wall": running_bond(3, 3),
    }
    for contacts, integrator in SCHEMES:
        scheme = f"{contacts}, {integrator}"
        for name, model in models.items():
            for g in (10.0, 1e3):
                run = partial(spike, model, contacts, integrator, g)
                yield Case("records", f"{name}, spike of {g:g} g, {scheme}", run, (ConvergenceError,))
        yield Case("records", f"two samples, {scheme}", partial(two_samples, contacts, integrator))
        for time_step in (1e-7, 1e-5, 0.1, 10.0):
            name = f"at rest in steps of {time_step:g} s, {scheme}"
            yield Case("records", name, partial(steps_of, time_step, contacts, integrator))
    for integrator in ("implicit-euler", "second-order"):
        yield Case(
            "records", f"spikes under a frictionless block, {integrator}", partial(sliding, integrator)
        )
    yield Case("records", "1e6 samples, collapse", partial(million, True, "rigid"))
    for contacts in ("rigid", "elastic"):
        yield Case(
            "records", f"1e6 samples at rest, {contacts}", partial(million, False, contacts), long=True
        )
