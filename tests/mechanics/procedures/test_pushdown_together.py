"""Several supports that move at once: what follows from the movements of each, and from rigid motions."""

import numpy as np
import pytest

from mechanics import ArgumentError, Assembly, pushdown
from mechanics.procedures import SupportMovement, pushdown_together
from tests.support.structures import arch_on_piers
