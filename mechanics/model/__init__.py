"""Blocks, the joints between them as drawn, and where they touch in a configuration."""
