"""The structure that a project describes: its assembly, that of each state, mechanisms and gauges on it."""
