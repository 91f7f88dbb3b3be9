"""Drawings of the structure to scale, in black and white."""
