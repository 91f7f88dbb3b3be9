"""The limit states of NTC 2018, §2.1, in the orders that checks, quotations and indices use; references of a_g."""

from typing import Final

# SLO, SLD and "SLV linear" are the linear kinematic check (a_0* of the rigid multiplier); "elastic" is the end of the
# elastic branch of a curve that has one; SLV and SLC are the nonlinear check
CHECKS = ("SLO", "SLO elastic", "SLD", "SLD elastic", "SLV linear", "SLV", "SLC")
LINEAR = ("SLO", "SLD", "SLV linear")
QUOTED = ("SLC", "SLV", "SLD", "SLO")  # the farthest first
INDEXED = (
    "SLV",
    "SLC",
)  # the ratio of a_g borne to a_g demanded at the first that is checked is ζ_E (NTC 2018, §8.3)
INDEX = INDEXED[0]

# of an acceleration: on rigid ground (category A) without S, or with it
ROCK: Final = "rock"
SURFACE: Final = "surface"
