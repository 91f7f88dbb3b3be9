"""Tiles of ROWS × COLUMNS of Cholesky factors stored by columns, in vector registers until they are done with.

An intrinsic takes addresses, and distances, in bytes. `column`: of L[j, k] for the first of `count` columns k, the next
one being `stride` on; `rows`: from L[j, k] to L[i, k].
"""

from __future__ import annotations

from typing import Any

import numba
from llvmlite import ir
from numba.core import types

ROWS, COLUMNS = 8, 6
BYTES = 8  # of a number
_intrinsic: Any = numba.extending.intrinsic

VECTOR, WHOLE = ir.VectorType(ir.DoubleType(), ROWS), ir.IntType(64)


def _at(builder: Any, address: Any, kind: Any) -> Any:
    return builder.load(builder.inttoptr(address, kind.as_pointer()), align=BYTES)


def _everywhere(builder: Any, address: Any) -> Any:
    """The number at an address, in every place of a vector."""
    undefined, first = ir.Constant(VECTOR, ir.Undefined), ir.IntType(32)(0)
    number = builder.insert_element(undefined, _at(builder, address, ir.DoubleType()), first)
    return builder.shuffle_vector(
        number, undefined, ir.Constant(ir.VectorType(ir.IntType(32), ROWS), [0] * ROWS)
    )


def _product(builder: Any, left: Any, right: Any) -> Any:
    return builder.fmul(left, right, flags=("contract",))


def _sums(builder: Any, column: Any, count: Any, stride: Any, rows: Any, columns: int = COLUMNS) -> list[Any]:
    """Σₖ L[i + r, k] L[j + c, k] over `count` columns k, if any: a vector over r for every c."""
    nothing = ir.Constant(VECTOR, [0.0] * ROWS)
    before, loop = builder.block, builder.append_basic_block("tile")
    after = builder.append_basic_block("tiled")
    builder.cbranch(builder.icmp_signed(">", count, WHOLE(0)), loop, after)
    builder.position_at_end(loop)
    k, at = builder.phi(WHOLE), builder.phi(WHOLE)
    sums = [builder.phi(VECTOR) for _ in range(columns)]
    left, grown = _at(builder, builder.add(at, rows), VECTOR), []
    for c, total in enumerate(sums):
        right = _everywhere(builder, builder.add(at, WHOLE(BYTES * c)))
        grown.append(builder.fadd(total, _product(builder, left, right), flags=("contract",)))
    following = builder.add(k, WHOLE(1))
    for phi, start, new in [
        (k, WHOLE(0), following),
        (at, column, builder.add(at, stride)),
        *((total, nothing, new) for total, new in zip(sums, grown, strict=True)),
    ]:
        phi.add_incoming(start, before)
        phi.add_incoming(new, loop)
    builder.cbranch(builder.icmp_signed("<", following, count), loop, after)
    builder.position_at_end(after)
    found = [builder.phi(VECTOR) for _ in range(columns)]
    for phi, new in zip(found, grown, strict=True):
        phi.add_incoming(nothing, before)
        phi.add_incoming(new, loop)
    return found


@_intrinsic
def sums(typing_context: Any, column: Any, count: Any, stride: Any, rows: Any, out: Any, apart: Any) -> Any:
    """Σₖ L[i + r, k] L[j + c, k] for every c and r, into `out`, from one c to the next `apart`."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        *where, out, apart = arguments
        for total in _sums(builder, *where):
            builder.store(total, builder.inttoptr(out, VECTOR.as_pointer()), align=BYTES)
            out = builder.add(out, apart)
        return context.get_dummy_value()

    return types.void(*[types.intp] * 6), generate


def _below(columns: int) -> Any:
    @_intrinsic
    def below(
        typing_context: Any, column: Any, count: Any, stride: Any, rows: Any, diagonal: Any, inverse: Any
    ) -> Any:
        """L[i + r, j + c] in place of the matrix: the sums are taken off, and Lᵀ of the diagonal tile inverted.

        `diagonal`: of L[j, j]; `inverse`: of 1/L[j + c, j + c], one after the other.
        """

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            column, count, stride, rows, diagonal, inverse = arguments
            found: list[Any] = []
            starts: list[Any] = []
            at = diagonal
            for c, total in enumerate(_sums(builder, column, count, stride, rows, columns)):
                target = builder.add(at, rows)
                value = builder.fsub(_at(builder, target, VECTOR), total, flags=("contract",))
                for other, start in zip(found, starts, strict=True):
                    share = _everywhere(builder, builder.add(start, WHOLE(BYTES * c)))
                    value = builder.fsub(value, _product(builder, other, share), flags=("contract",))
                value = _product(builder, value, _everywhere(builder, builder.add(inverse, WHOLE(BYTES * c))))
                builder.store(value, builder.inttoptr(target, VECTOR.as_pointer()), align=BYTES)
                found.append(value)
                starts.append(at)
                at = builder.add(at, stride)
            return context.get_dummy_value()

        return types.void(*[types.intp] * 6), generate

    return below


below = _below(COLUMNS)
half_below = _below(COLUMNS // 2)
