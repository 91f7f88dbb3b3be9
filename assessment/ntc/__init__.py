"""NTC 2018 and its Circolare: hazard, spectra, capacity and verification; usable alone."""
