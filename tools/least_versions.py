"""Print the least version of every dependency that pyproject.toml allows: `make least` runs on these."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

PYPROJECT = Path(__file__).parents[1] / "pyproject.toml"


def least_versions() -> list[str]:
    """Return `name==version` of each dependency of the program, and of the cluster."""
    project = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"]
    bounded = [*project["dependencies"], *project["optional-dependencies"]["cluster"]]
    return [re.sub(">=", "==", text) for text in bounded]


if __name__ == "__main__":
    print("\n".join(least_versions()))
