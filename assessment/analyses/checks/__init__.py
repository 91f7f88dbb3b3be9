"""Demand on a project, and the checks of every mechanism against it."""
