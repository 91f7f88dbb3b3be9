"""The seismic demand: hazard of a site, elastic spectra at the ground and at height."""
