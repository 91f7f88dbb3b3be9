"""Numerical stability at the ends of what can be asked: every case ends certified or in a named refusal.

`python -m tests.stress` prints the table of outcomes; `--long` adds the cases that take minutes. Under pytest
`ASSESTO_STRESS=long` does.
"""
