"""An artificial record for projects that have none: compatible with an elastic spectrum, the same for the same seed."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from assessment.ntc.demand.spectrum import ElasticSpectrum
from assessment.runtime.files.atomic_files import write_atomically
from mechanics.records import compatible_record

RECORD = "records/artificial.csv"
DURATION, PLATEAU, TIME_STEP = 15.0, 10.0, 0.01  # s


def write_artificial_record(folder: Path, spectrum: ElasticSpectrum, seed: int = 1) -> Path:
    """Write `records/artificial.csv` of a project folder, time in s and acceleration in g, and return its path.

    15 s at 0.01 s with 10 s of strong motion, within 10 % of the spectrum at 0.15–2 s; the same seed gives the same
    file. Raises ConvergenceError where no such motion is found.
    """
    path = folder / RECORD
    write_atomically(path, _text(spectrum, seed))
    return path


@lru_cache(maxsize=4)
def _text(spectrum: ElasticSpectrum, seed: int) -> bytes:
    record = compatible_record(
        spectrum.acceleration, DURATION, TIME_STEP, seed, plateau=PLATEAU, name="artificial"
    )
    lines = [f"{t:.2f},{a:.6f}\n" for t, a in zip(record.time, record.acceleration, strict=True)]
    return "".join(lines).encode()
