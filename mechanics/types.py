"""Arrays by what they hold, how vectors turn, and the constants of the package."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

GRAVITY = 9.80665  # m/s²

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Mask = NDArray[np.bool_]


def turned(vectors: Array, angle: Array | float) -> Array:
    """Return vectors (…, 2) turned anticlockwise by angles (…,), rad."""
    c, s = np.cos(angle), np.sin(angle)
    x, z = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * z, s * x + c * z], axis=-1)
