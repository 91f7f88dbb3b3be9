"""How often Python's garbage collector runs."""

import gc

_NEW_OBJECTS = 50_000  # allocations between two collections: with Python's 700 the PDF takes a third longer


def collect_rarely() -> None:
    """Let the garbage collector run less often; processes that are started afterwards inherit the setting."""
    gc.set_threshold(_NEW_OBJECTS)
