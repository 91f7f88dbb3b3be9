"""Programs that several tests solve."""

from __future__ import annotations

from assessment.benchmark.measure import euler_step

__all__ = ["euler_step"]
