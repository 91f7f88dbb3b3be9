"""Numerical stability at the ends of what can be asked: every case ends certified or in a named refusal.

pytest runs a sample, and all with `ASSESTO_STRESS=long`.
"""
