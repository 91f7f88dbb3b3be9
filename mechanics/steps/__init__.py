"""One step of an analysis: an equilibrium, or a time step."""
