"""Run time against error, and what skipping saves: `assesto benchmark`."""
