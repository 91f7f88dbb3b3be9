"""Ground motions: files read, response spectra, synthetic records."""

from mechanics.records.record import (
    HIGHEST_CREDIBLE_PGA,
    SAME_TIME,
    Record,
    compatible_record,
    read_record,
    response_spectrum,
)

__all__ = [
    "HIGHEST_CREDIBLE_PGA",
    "SAME_TIME",
    "Record",
    "compatible_record",
    "read_record",
    "response_spectrum",
]
