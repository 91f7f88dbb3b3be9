"""What two threads at the halves of a model tell each other (see halves), inside compiled loops.

Either runs the same loop on its own half, in the same steps: at a meeting it tells some numbers and goes on with those
of the other. `shared`: `gate` (2,), the meetings that either has come to; `board` (2, 2, n), of even and of odd ones
what either tells; which of the two this one is; and the number of rows, the last ones, that both halves have. A loop
that is alone has None, and nothing of this is compiled into it.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.cpython.unsafe.tuple import tuple_setitem
from numba.extending import intrinsic

from mechanics.block import Array
from mechanics.solvers.compiler import compiler

compiled = compiler()
_cgutils: Any = cgutils
_intrinsic: Any = intrinsic
_with: Any = tuple_setitem

BYTES = 8  # of a number of meetings
CLOCK = getattr(time, "CLOCK_MONOTONIC", 0)  # Windows has none, and nothing that waits
LOOKS = 1024  # at the gate, a microsecond at most, from one look at the clock to the next
PATIENCE = 100_000  # nanoseconds: after them a thread sleeps before it looks so often again
NAP = 50  # microseconds


@_intrinsic
def _come_to(typing_context: Any, address: Any, count: Any) -> Any:
    """Tell the number of meetings come to: whoever sees it sees all that was written before."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, count = arguments
        builder.store_atomic(count, builder.inttoptr(address, count.type.as_pointer()), "release", BYTES)
        return context.get_dummy_value()

    return types.void(types.intp, types.intp), generate


@_intrinsic
def _has_come_to(typing_context: Any, address: Any) -> Any:
    """The number of meetings that the other has come to."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        count = ir.IntType(64)
        return builder.load_atomic(builder.inttoptr(arguments[0], count.as_pointer()), "acquire", BYTES)

    return types.intp(types.intp), generate


@_intrinsic
def _sleep(typing_context: Any) -> Any:
    """For a NAP: the other has no core. One that is offered would be some other program's for milliseconds."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole = ir.IntType(32)
        of_the_system = ir.FunctionType(whole, [whole])
        builder.call(_cgutils.get_or_insert_function(builder.module, of_the_system, "usleep"), [whole(NAP)])
        return context.get_dummy_value()

    return types.void(), generate


@_intrinsic
def _now(typing_context: Any) -> Any:
    """Nanoseconds on a clock that nobody sets."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole, long = ir.IntType(32), ir.IntType(64)
        time_of = ir.FunctionType(whole, [whole, long.as_pointer()])
        clock = _cgutils.get_or_insert_function(builder.module, time_of, "clock_gettime")
        told = _cgutils.alloca_once(builder, long, 2)
        builder.call(clock, [whole(CLOCK), told])
        seconds, rest = (builder.load(builder.gep(told, [whole(k)])) for k in range(2))
        return builder.add(builder.mul(seconds, long(1_000_000_000)), rest)

    return types.intp(), generate


@compiled
def _exchanged(shared: Any, numbers: Any) -> Array:
    """These numbers are told at a meeting: those of the other."""
    gate, board, member, _ = shared
    count = gate[member] + 1
    told = board[count % 2, member]
    for k in range(len(numbers)):
        told[k] = numbers[k]
    _come_to(gate.ctypes.data + BYTES * member, count)
    other, looks, since = gate.ctypes.data + BYTES * (1 - member), 0, 0
    while _has_come_to(other) < count:
        looks += 1
        if looks == LOOKS:
            since = _now()
        elif looks % LOOKS == 0 and _now() > since + PATIENCE:
            _sleep()
    return board[count % 2, 1 - member]


@compiled
def add_up(shared: Any, numbers: Array) -> None:
    """Numbers (k,) of either become those of both together."""
    if shared is not None:
        others = _exchanged(shared, numbers)
        for k in range(len(numbers)):
            numbers[k] += others[k]


@compiled
def add_up_rows(shared: Any, x: Array) -> None:
    """The rows of x (m,) that both halves have become those of both together."""
    if shared is not None:
        add_up(shared, x[len(x) - shared[3] :])


@compiled
def together(shared: Any, numbers: Any) -> Any:
    """These few numbers of both halves together."""
    if shared is None:
        return numbers
    others, sums = _exchanged(shared, numbers), numbers
    for k in range(len(numbers)):
        sums = _with(sums, k, numbers[k] + others[k])
    return sums


@compiled
def largest(shared: Any, numbers: Any) -> Any:
    """The larger ones of these few numbers of either half; no number where either has none."""
    if shared is None:
        return numbers
    others, found = _exchanged(shared, numbers), numbers
    for k in range(len(numbers)):
        if not numbers[k] >= others[k] and not np.isnan(numbers[k]):
            found = _with(found, k, others[k])
    return found


@compiled
def share_of(shared: Any, row: int, rows: int) -> float:
    """Of the mass and load of one of so many rows, what counts here: half of the line's."""
    if shared is None:
        return 1.0
    return 1.0 if row < rows - shared[3] else 0.5
