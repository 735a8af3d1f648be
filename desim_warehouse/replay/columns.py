"""Pack columns of integers into few bytes: seven bits per byte, then deflate, then base64 for the page.

The page unpacks them with `DecompressionStream`, and tests/report/replay/unpacked.py in Python.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.values.arrays import Ints

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


LARGEST = 2**31 - 1
"""The largest number in a column, as the page uses 32 bits."""
BITS = 7
MORE = 128
LEVEL = 9


def zigzag(values: Ints) -> Ints:
    """Map the integers 0, -1, 1, ... to 0, 1, 2, ..., so that numbers close to 0 stay small."""
    return np.where(values < 0, -2 * values - 1, 2 * values)


def to_bytes(values: ArrayLike) -> bytes:
    """Encode integers of either sign with seven bits per byte, low bits first; the high bit marks a continuation.

    Raises:
        OverflowError: a number that does not fit into 32 bits.
    """
    left = zigzag(np.asarray(values, dtype=np.int64))
    if left.size and int(left.max()) > 2 * LARGEST:
        raise OverflowError("a number of the replay does not fit into 32 bits")
    sizes = np.ones(len(left), dtype=np.int64)
    for more in range(1, 5):
        sizes += left >= 1 << (BITS * more)
    place = np.cumsum(sizes) - sizes
    out = np.zeros(int(sizes.sum()), dtype=np.uint8)
    for more in range(5):
        here = sizes > more
        byte = (left[here] >> (BITS * more)) & (MORE - 1)
        out[place[here] + more] = byte | np.where(sizes[here] > more + 1, MORE, 0)
    return out.tobytes()


def pack(columns: Mapping[str, ArrayLike]) -> tuple[list[tuple[str, int, int]], str]:
    """Return an index of columns (name, number of values, number of bytes each), and the columns as base64 text."""
    index, parts = [], []
    for name, values in columns.items():
        data = to_bytes(values)
        index.append((name, len(np.asarray(values)), len(data)))
        parts.append(data)
    squeeze = zlib.compressobj(LEVEL, zlib.DEFLATED, -zlib.MAX_WBITS)
    packed = squeeze.compress(b"".join(parts)) + squeeze.flush()
    return index, base64.b64encode(packed).decode("ascii")
