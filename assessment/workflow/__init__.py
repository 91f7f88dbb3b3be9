"""A run: which analyses a project needs, in what order, and what they leave in the output folder."""
