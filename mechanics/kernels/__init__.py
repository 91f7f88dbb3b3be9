"""The compiled loops: each is the only source of its loop."""
