"""Blocks and joints in a configuration: where they are, what they carry, and how a mechanism moves them."""
