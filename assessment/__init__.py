"""Standards, projects and reports on top of `mechanics`."""

from importlib import import_module
from typing import Any

_HOME = {
    "ElasticSpectrum": "ntc.spectrum",
    "RecordSpectrum": "ntc.spectrum",
    "site_hazard": "ntc.hazard",
    "fit_curve": "ntc.curve_fit",
    "capacity_curve": "ntc.capacity_curve",
    "participation": "ntc.capacity_curve",
    "verify": "ntc.verification",
    **dict.fromkeys(
        (
            *(
                "arcade",
                "arch",
                "barrel_vault",
                "bell_gable",
                "block",
                "buttressed_arch",
                "facade",
                "pointed_arch",
            ),
            *("triumphal_arch", "tympanum", "wall", "wall_with_openings", "incremental", "fragility"),
        ),
        "scripting",
    ),
}
__all__ = [
    "ElasticSpectrum",
    "RecordSpectrum",
    "arcade",
    "arch",
    "barrel_vault",
    "bell_gable",
    "block",
    "buttressed_arch",
    "capacity_curve",
    "facade",
    "fit_curve",
    "fragility",
    "incremental",
    "participation",
    "pointed_arch",
    "site_hazard",
    "triumphal_arch",
    "tympanum",
    "verify",
    "wall",
    "wall_with_openings",
]


def __getattr__(name: str) -> Any:
    """Import a public name where it is first asked for: the command line starts without numpy."""
    if name not in _HOME:
        raise AttributeError(f"module 'assessment' has no attribute {name!r}")
    return getattr(import_module(f"assessment.{_HOME[name]}"), name)
