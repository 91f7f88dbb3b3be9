"""Arrays by what they hold, and the constants of the package."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

GRAVITY = 9.80665  # m/s²

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Mask = NDArray[np.bool_]
