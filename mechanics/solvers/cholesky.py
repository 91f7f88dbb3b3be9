"""Cholesky's factorisation of banded matrices and its substitutions, compiled: for narrow bands quicker than LAPACK.

Matrices as in kernels: entry (i, j), i ≥ j, at [j, i − j], of a factor the inverse on the diagonal; and `PADDING`
columns of zeros beyond the band, so that a tile of ROWS × COLUMNS, no more columns than rows, may reach over its edge.
A tile stays in vector registers until it is a part of the factor.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from mechanics.block import Array
from mechanics.solvers.compiler import compiler

ROWS, COLUMNS = 8, 6  # of a tile
PADDING = ROWS + COLUMNS - 1
BYTES = 8  # of a number
_intrinsic: Any = intrinsic
compiled = compiler("contract", "reassoc")


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


def _sums(builder: Any, column: Any, count: Any, stride: Any, rows: Any) -> list[Any]:
    """Σₖ L[i + r, k] L[j + c, k] over `count` columns k, if any: a vector over r for every c; as in _diagonal."""
    nothing = ir.Constant(VECTOR, [0.0] * ROWS)
    before, loop = builder.block, builder.append_basic_block("tile")
    after = builder.append_basic_block("tiled")
    builder.cbranch(builder.icmp_signed(">", count, WHOLE(0)), loop, after)
    builder.position_at_end(loop)
    k, at = builder.phi(WHOLE), builder.phi(WHOLE)
    sums = [builder.phi(VECTOR) for _ in range(COLUMNS)]
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
    found = [builder.phi(VECTOR) for _ in range(COLUMNS)]
    for phi, new in zip(found, grown, strict=True):
        phi.add_incoming(nothing, before)
        phi.add_incoming(new, loop)
    return found


@_intrinsic
def _diagonal(typing_context: Any, column: Any, count: Any, stride: Any, out: Any) -> Any:
    """Σₖ L[j + r, k] L[j + c, k] into `out`, [c, r], over `count` columns k; all arguments are addresses in bytes.

    `column`: of L[j, k] for the first k; the next one is `stride` on.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        column, count, stride, out = arguments
        for c, total in enumerate(_sums(builder, column, count, stride, WHOLE(0))):
            target = builder.inttoptr(builder.add(out, WHOLE(BYTES * ROWS * c)), VECTOR.as_pointer())
            builder.store(total, target, align=BYTES)
        return context.get_dummy_value()

    return types.void(*[types.intp] * 4), generate


@_intrinsic
def _below(
    typing_context: Any, column: Any, count: Any, stride: Any, rows: Any, diagonal: Any, inverse: Any
) -> Any:
    """L[i + r, j + c] in place of the matrix: the sums as in _diagonal are taken off, and Lᵀ of the diagonal inverted.

    `rows`: from L[j, k] to L[i, k]; `diagonal`: of L[j, j]; `inverse`: of 1/L[j + c, j + c], one after the other.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        column, count, stride, rows, diagonal, inverse = arguments
        found: list[Any] = []
        columns: list[Any] = []
        at = diagonal
        for c, total in enumerate(_sums(builder, column, count, stride, rows)):
            target = builder.add(at, rows)
            value = builder.fsub(_at(builder, target, VECTOR), total, flags=("contract",))
            for other, start in zip(found, columns, strict=True):
                share = _everywhere(builder, builder.add(start, WHOLE(BYTES * c)))
                value = builder.fsub(value, _product(builder, other, share), flags=("contract",))
            value = _product(builder, value, _everywhere(builder, builder.add(inverse, WHOLE(BYTES * c))))
            builder.store(value, builder.inttoptr(target, VECTOR.as_pointer()), align=BYTES)
            found.append(value)
            columns.append(at)
            at = builder.add(at, stride)
        return context.get_dummy_value()

    return types.void(*[types.intp] * 6), generate


@compiled
def factorise(band: Array, envelope: Any) -> bool:
    """The factor L of LLᵀ in place of a positive definite matrix of that envelope (see band); False if it is none."""
    n, places = band.shape
    tile, inverse = np.empty((COLUMNS, ROWS)), np.empty(COLUMNS)
    base, out, stride = band.ctypes.data, tile.ctypes.data, BYTES * (places - 1)
    for j in range(0, n, COLUMNS):
        columns = min(COLUMNS, n - j)
        end = envelope[j + columns - 1, 1] + 1
        first = _first(envelope, j, end)
        _diagonal(base + BYTES * (first * places + j - first), j - first, stride, out)
        for c in range(columns):
            for r in range(c, ROWS):
                tile[c, r] = band[j + c, r - c] - tile[c, r]
        for c in range(columns):
            if not tile[c, c] > 0.0:
                return False
            inverse[c] = 1.0 / np.sqrt(tile[c, c])
            for r in range(c, ROWS):
                tile[c, r] *= inverse[c]
                band[j + c, r - c] = tile[c, r]
            band[j + c, 0] = inverse[c]
            for d in range(c + 1, columns):
                for r in range(d, ROWS):
                    tile[d, r] -= tile[c, d] * tile[c, r]
        for i in range(j + ROWS, end, ROWS):
            first = min(j, _first(envelope, i, end))
            _below(
                base + BYTES * (first * places + j - first), j - first, stride, BYTES * (i - j),
                base + BYTES * j * places, inverse.ctypes.data,
            )  # fmt: skip
    return True


@compiled
def _first(envelope: Any, i: int, end: int) -> int:
    """The first column that the rows of a tile reach."""
    first = i
    for r in range(i, min(i + ROWS, end)):
        first = min(first, envelope[r, 0])
    return int(first)


@compiled
def substitute(band: Array, envelope: Any, x: Array) -> None:
    """The solution of LLᵀx = b in place of b (m,), three rows a block."""
    n = len(x)
    for j in range(0, n, 3):
        p, q, r = band[j], band[j + 1], band[j + 2]
        a = x[j] * p[0]
        b = (x[j + 1] - p[1] * a) * q[0]
        c = (x[j + 2] - p[2] * a - q[1] * b) * r[0]
        x[j], x[j + 1], x[j + 2] = a, b, c
        below = x[j + 3 : envelope[j + 2, 1] + 1]
        p, q, r = p[3 : 3 + len(below)], q[2 : 2 + len(below)], r[1 : 1 + len(below)]
        for e in range(len(below)):
            below[e] -= a * p[e] + b * q[e] + c * r[e]
    for j in range(n - 3, -1, -3):
        p, q, r = band[j], band[j + 1], band[j + 2]
        below = x[j + 3 : envelope[j + 2, 1] + 1]
        u, v, w = p[3 : 3 + len(below)], q[2 : 2 + len(below)], r[1 : 1 + len(below)]
        a, b, c = 0.0, 0.0, 0.0
        for e in range(len(below)):
            a += u[e] * below[e]
            b += v[e] * below[e]
            c += w[e] * below[e]
        c = (x[j + 2] - c) * r[0]
        b = (x[j + 1] - b - q[1] * c) * q[0]
        a = (x[j] - a - p[1] * b - p[2] * c) * p[0]
        x[j], x[j + 1], x[j + 2] = a, b, c
