"""Analyses of variants of a project: convergence, scenarios, sensitivity."""
