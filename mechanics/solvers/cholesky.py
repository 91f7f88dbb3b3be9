"""Cholesky's factorisation of banded matrices and its substitutions, compiled: for narrow bands quicker than LAPACK.

Matrices as in kernels: entry (i, j), i ≥ j, at [j, i − j], and `PADDING` columns of zeros beyond the band, so that a
tile of ROWS × COLUMNS products, which is held in vector registers, may reach over its edge.
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


@_intrinsic
def _tile(typing_context: Any, column: Any, count: Any, stride: Any, rows: Any, out: Any) -> Any:
    """Σₖ L[i + r, k] L[j + c, k] into `out`, [c, r], over `count` columns k; all arguments are addresses in bytes.

    `column`: of L[j, k] for the first k; the next one is `stride` on; `rows`: from L[j, k] to L[i, k].
    """
    vector, whole = ir.VectorType(ir.DoubleType(), ROWS), ir.IntType(64)
    undefined, nothing = ir.Constant(vector, ir.Undefined), ir.Constant(vector, [0.0] * ROWS)
    everywhere = ir.Constant(ir.VectorType(ir.IntType(32), ROWS), [0] * ROWS)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        column, count, stride, rows, out = arguments

        def pointer(address: Any, kind: Any) -> Any:
            return builder.inttoptr(address, kind.as_pointer())

        before, loop = builder.block, builder.append_basic_block("tile")
        after = builder.append_basic_block("tiled")
        builder.branch(loop)
        builder.position_at_end(loop)
        k, at = builder.phi(whole), builder.phi(whole)
        sums = [builder.phi(vector) for _ in range(COLUMNS)]
        left = builder.load(pointer(builder.add(at, rows), vector), align=BYTES)
        grown = []
        for c, total in enumerate(sums):
            right = builder.load(pointer(builder.add(at, whole(BYTES * c)), ir.DoubleType()), align=BYTES)
            spread = builder.shuffle_vector(
                builder.insert_element(undefined, right, ir.IntType(32)(0)), undefined, everywhere
            )
            product = builder.fmul(left, spread, flags=("contract",))
            grown.append(builder.fadd(total, product, flags=("contract",)))
        following = builder.add(k, whole(1))
        for phi, start, new in [
            (k, whole(0), following),
            (at, column, builder.add(at, stride)),
            *((total, nothing, new) for total, new in zip(sums, grown, strict=True)),
        ]:
            phi.add_incoming(start, before)
            phi.add_incoming(new, loop)
        builder.cbranch(builder.icmp_signed("<", following, count), loop, after)
        builder.position_at_end(after)
        for c, new in enumerate(grown):
            builder.store(new, pointer(builder.add(out, whole(BYTES * ROWS * c)), vector), align=BYTES)
        return context.get_dummy_value()

    return types.void(*[types.intp] * 5), generate


@compiled
def factorise(band: Array, envelope: Any) -> bool:
    """The factor L of LLᵀ in place of a positive definite matrix of that envelope (see band); False if it is none."""
    n, places = band.shape
    tile = np.empty((COLUMNS, ROWS))
    base, out, stride = band.ctypes.data, tile.ctypes.data, BYTES * (places - 1)
    for j in range(0, n, COLUMNS):
        columns = min(COLUMNS, n - j)
        end = envelope[j + columns - 1, 1] + 1
        for i in range(j, end, ROWS):
            first = j
            for r in range(i, min(i + ROWS, end)):
                first = min(first, envelope[r, 0])
            if first < j:
                _tile(base + BYTES * (first * places + j - first), j - first, stride, BYTES * (i - j), out)
                for c in range(columns):
                    for r in range(c if i == j else 0, ROWS):
                        band[j + c, i - j - c + r] -= tile[c, r]
        for c in range(columns):
            column = band[j + c, : end - j - c]
            if not column[0] > 0.0:
                return False
            inverse = 1.0 / np.sqrt(column[0])
            for e in range(len(column)):
                column[e] *= inverse
            for d in range(c + 1, columns):
                other, below, share = band[j + d, : end - j - d], column[d - c :], column[d - c]
                for e in range(len(other)):
                    other[e] -= share * below[e]
    return True


@compiled
def substitute(band: Array, envelope: Any, x: Array) -> None:
    """The solution of LLᵀx = b in place of b (m,), three rows a block."""
    n = len(x)
    for j in range(0, n, 3):
        p, q, r = band[j], band[j + 1], band[j + 2]
        a = x[j] / p[0]
        b = (x[j + 1] - p[1] * a) / q[0]
        c = (x[j + 2] - p[2] * a - q[1] * b) / r[0]
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
        c = (x[j + 2] - c) / r[0]
        b = (x[j + 1] - b - q[1] * c) / q[0]
        a = (x[j] - a - p[1] * b - p[2] * c) / p[0]
        x[j], x[j + 1], x[j + 2] = a, b, c
