"""A small campaign on a lower block, which rests sooner, and whose base turns: short waves, two shares, one sign."""

from pathlib import Path

import numpy as np

from tests.support.block_project import ASSESSMENT, PROJECT, write_block

SEARCHES = """[campaign]
records = ["wave*.csv"]
shares = [0.0, 1.0]
signs = [1]
contacts = "rigid"
tolerance = 0.2
max_scale = 3.0
"""
STRIPES = """[campaign]
records = ["wave*.csv"]
shares = [0.0, 1.0]
contacts = "rigid"
method = "stripes"
levels_g = [0.1, 0.2, 0.3]
"""


HEIGHT = 2.4  # m


def write_campaign(folder: Path, table: str, records: int) -> Path:
    """Write drawing, records and project file with a table [campaign] into a folder; return it."""
    text = "scatter = 2\n" + PROJECT.replace("4.2]", f"{HEIGHT}]") + table + ASSESSMENT
    write_block(folder, text, HEIGHT)
    for number, rate in enumerate((4.0, 6.0, 5.0)[:records], 1):
        time = 0.02 * np.arange(36)
        wave = 0.5 * np.sin(rate * time) * np.exp(-0.3 * time)
        np.savetxt(folder / f"wave{number}.csv", np.column_stack([time, wave]), delimiter=",")
    return folder
