"""Inputs that attack the program: every one is refused in one message with file, key and remedy, or completes.

`python -m tests.support.hostile [FACTOR]` tries them all, FACTOR times as many, and prints the counts.
"""
