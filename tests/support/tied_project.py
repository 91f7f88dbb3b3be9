"""The project of one block on a base, held by a tie."""

TIE = """[[tie]]
name = "chain"
from_m = [-0.29, -0.1]
to_m = [-0.29, 4.0]
yield_force_kN = 5.0
"""
"""Vertical, at the left face: a push towards +x, about the toe at x = 0.3, lengthens it."""

ASSOCIATIVE = '[contacts]\nsliding = "associative"\n'
"""What only turns has one multiplier by both laws: by Coulomb's a tie that yields is searched for lesser ones."""
WIDTH, HEIGHT, WEIGHT = 0.6, 4.2, 0.6 * 4.2 * 18.0  # m, kN


def tie(**keys: str) -> str:
    """The tie with other values of some keys, as TOML; an empty text leaves a key out."""
    lines = [line for line in TIE.splitlines() if line.partition(" ")[0] not in keys]
    return "\n".join([*lines, *(f"{key} = {value}" for key, value in keys.items() if value)]) + "\n"


def strengthening(of: str = "base turned", name: str = "strengthened") -> str:
    """A strengthening of a state."""
    return f'[[strengthening]]\nname = "{name}"\nof = "{of}"\n'


STRENGTHENED = tie(states='["strengthened"]') + strengthening()


def overturning(force: float, arm: float) -> float:
    """α of the block about its toe: the weight at half the width, the force (kN) of a tie at its arm (m)."""
    return (WEIGHT * 0.5 * WIDTH + force * arm) / (WEIGHT * 0.5 * HEIGHT)
