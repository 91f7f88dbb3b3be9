"""Ground motions: files read, response spectra, synthetic records."""
