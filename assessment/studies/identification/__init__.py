"""Identification: the movement of supports that explains what was measured."""
