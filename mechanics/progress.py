"""How far a procedure has come, as a share of all that is expected of it: told to whoever listens in this context.

Nobody listens unless `listening` says so, and nothing depends on what is told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Listener = Callable[[float], None]
"""Is given a share, from 0 to 1."""

_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


def tell(share: float) -> None:
    """Tell the share that is done; a few times a second at most is enough."""
    listener = _listener.get()
    if listener is not None:
        listener(min(max(share, 0.0), 1.0))


@contextmanager
def listening(listener: Listener) -> Iterator[None]:
    """Have all that is told within go to a listener."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


@contextmanager
def stretch(begin: float, end: float) -> Iterator[None]:
    """Have what is told within count as the part from share `begin` to `end` of a larger procedure."""
    outer = _listener.get()
    if outer is None:
        yield
        return
    with listening(lambda share: outer(min(max(begin + (end - begin) * share, 0.0), 1.0))):
        yield
