"""Motions: the gaps and the program of a time step, the step, and steps one after another."""
