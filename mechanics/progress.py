"""Progress of a procedure as a share of its expected work, reported to the listener of the current context.

There is no listener outside `listening`, and no result depends on one.

The loops are compiled where no compiled ones are kept: about a minute in which no procedure reports anything.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Listener = Callable[[float], None]
"""Is given a share, from 0 to 1."""

_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


def tell(share: float) -> None:
    """Report the share that is done, 0 to 1; a few times a second is enough."""
    listener = _listener.get()
    if listener is not None:
        listener(min(max(share, 0.0), 1.0))


@contextmanager
def listening(listener: Listener) -> Iterator[None]:
    """Send the shares reported within the context to a listener."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


@contextmanager
def stretch(begin: float, end: float) -> Iterator[None]:
    """Count the shares reported within the context as the part from `begin` to `end` of a larger procedure."""
    outer = _listener.get()
    if outer is None:
        yield
        return
    with listening(lambda share: outer(min(max(begin + (end - begin) * share, 0.0), 1.0))):
        yield


_before_compiling: list[Callable[[], None]] = []


def before_compiling(call: Callable[[], None]) -> None:
    """Call a function once, before the first loop of this process is compiled."""
    _before_compiling.append(call)


def compiles() -> None:
    """Say that a loop is about to be compiled."""
    while _before_compiling:
        _before_compiling.pop()()
