"""How often a run looks for garbage."""

import gc

_NEW_OBJECTS = 50_000  # between two looks: with Python's 700 the PDF takes a third longer


def collect_rarely() -> None:
    """Let garbage wait; processes begun afterwards inherit it."""
    gc.set_threshold(_NEW_OBJECTS)
