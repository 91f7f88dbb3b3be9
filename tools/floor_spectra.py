"""Draws docs/pictures/floor_spectra.svg, S_eZ over T at three heights of a building; tools.docs_pages runs it.

Three storeys, H = 12 m, T_1 = 0.05 H^(3/4) = 0.322 s, 5 % damping; SLV at L'Aquila (a_g = 0.261 g), ground B.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from assessment.ntc.floor_spectrum import FloorSpectrum, first_mode, fundamental_period
from assessment.ntc.spectrum import ElasticSpectrum
from tools.pictures import write_picture

GROUND = ElasticSpectrum(0.261, 2.36, 0.35, "B")
BUILDING_M, STOREYS = 12.0, 3
HEIGHTS_M = (4.0, 8.0, 12.0)
PERIODS = np.linspace(0.0, 1.5, 301)  # s
DASHES = ("-", "--", ":")


def at_height(z: float) -> FloorSpectrum:
    """Return the floor spectrum at a height z (m) of the building, of its first mode."""
    T_1 = fundamental_period(BUILDING_M).result
    return FloorSpectrum(GROUND, (first_mode(T_1, STOREYS, z, BUILDING_M),))


def draw(axes: Axes) -> None:
    """Draw the ground's spectrum and those of the three heights, the highest first in the legend."""
    for z, dashes in zip(reversed(HEIGHTS_M), DASHES, strict=True):
        axes.plot(
            PERIODS, at_height(z).acceleration(PERIODS), dashes, color="black", lw=1.3, label=f"z = {z:g} m"
        )
    axes.plot(PERIODS, GROUND.acceleration(PERIODS), color="#1050b0", lw=2.0, label="ground, $S_e$")
    T_1 = fundamental_period(BUILDING_M).result
    for share in (0.8, 1.1):
        axes.axvline(share * T_1, color="0.7", lw=0.8, zorder=0)
    axes.text(1.1 * T_1 + 0.02, 4.5, "0.8 to 1.1 $T_1$", fontsize=8, va="center", color="0.3")
    axes.set(xlabel="$T$ [s]", ylabel="$S_{eZ}$ [g]", xlim=(0.0, 1.5), ylim=(0.0, None))
    axes.legend(frameon=False, fontsize=8)


def write() -> None:
    """Write the picture; the same bytes each time."""
    write_picture("floor_spectra.svg", (6.0, 3.6), lambda figure: draw(figure.subplots()), font_size=9.0)


if __name__ == "__main__":
    write()
