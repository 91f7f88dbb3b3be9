"""Inputs that attack the program: every one is refused in one message with file, key and remedy, or completes."""
