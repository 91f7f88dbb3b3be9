"""The analyses: each reads as its pseudo-code."""
