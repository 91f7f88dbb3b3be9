"""The compiled loops of the solvers; each is the only source of its loop."""
