"""Numerical stability at the ends of what can be asked: every case ends certified or in a named refusal.

`python -m tests.stress` prints the table of outcomes; `--long` adds the cases that take minutes. pytest runs a
sample, and all with `ASSESTO_STRESS=long`.
"""
