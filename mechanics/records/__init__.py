"""Ground motions: files read, response spectra, synthetic records."""

from mechanics.records.record import SAME_TIME, Record, read_record
from mechanics.records.spectrum import compatible_record, response_spectrum

__all__ = [
    "SAME_TIME",
    "Record",
    "compatible_record",
    "read_record",
    "response_spectrum",
]
