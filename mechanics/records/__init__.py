"""Ground motions: files read, response spectra, synthetic records."""

from mechanics.records.record import SAME_TIME, Record, read_record
from mechanics.records.response_spectrum import response_spectrum
from mechanics.records.synthetic import compatible_record

__all__ = [
    "SAME_TIME",
    "Record",
    "compatible_record",
    "read_record",
    "response_spectrum",
]
