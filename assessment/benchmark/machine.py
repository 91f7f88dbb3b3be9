"""Where and with what the measurements were made."""

from __future__ import annotations

import os
import platform
import subprocess
from pathlib import Path

from assessment.runtime.fingerprint import installed

PACKAGES = ("assesto", "numpy", "scipy", "piqp", "numba", "ezdxf", "matplotlib", "weasyprint")


def machine() -> str:
    """Processor, cores, memory, system, versions, commit and load, in a sentence or two."""
    versions = ", ".join(f"{name} {installed(name)}" for name in PACKAGES)
    return (
        f"{processor()}, {os.cpu_count()} cores, {_memory()}{platform.system()}; Python "
        f"{platform.python_version()}, {versions}; commit {_commit()}; load {load()} at the start."
    )


def load() -> str:
    """How many processes want to run, in the mean over a minute; Windows does not count them."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"


def _memory() -> str:
    if not hasattr(os, "sysconf"):  # Windows
        return ""
    return f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30:.0f} GB, "


def processor() -> str:
    """The processor's name."""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        for line in cpuinfo.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _commit() -> str:
    """The commit of the source, with a plus sign where files differ from it; unknown outside a checkout."""
    git = ("git", "-C", str(Path(__file__).parent))
    try:
        head = subprocess.run(
            [*git, "rev-parse", "--short", "HEAD"], check=True, capture_output=True, text=True
        )
        changed = subprocess.run([*git, "diff", "--quiet", "HEAD"], check=False).returncode != 0
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return head.stdout.strip() + "+" * changed
