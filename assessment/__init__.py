"""Standards, projects and reports on top of `mechanics`."""

from importlib import import_module
from typing import Any

from assessment.project.catalogue import NAMES

_NAMES = {  # by the module that has them
    "ntc.spectrum": "ElasticSpectrum RecordSpectrum",
    "ntc.hazard": "site_hazard",
    "ntc.capacity_curve": "capacity_curve fit_curve participation",
    "ntc.verification": "verify",
    "scripting": " ".join(("fragility", "incremental", *NAMES)).replace("-", "_"),
}
_HOME = {name: home for home, names in _NAMES.items() for name in names.split()}
__all__ = sorted(_HOME)  # noqa: PLE0605 - each is named once


def __getattr__(name: str) -> Any:
    """Import a public name where it is first asked for: the command line starts without numpy."""
    if name not in _HOME:
        raise AttributeError(f"module 'assessment' has no attribute {name!r}")
    return getattr(import_module(f"assessment.{_HOME[name]}"), name)
