"""Columns of a replay page read back, as the page's script reads them."""

import base64
import zlib

import numpy as np

from desim_warehouse.replay.columns import BITS, MORE


def unzigzag(values):
    """The inverse of `zigzag`."""
    return np.where(values & 1, -((values + 1) >> 1), values >> 1)


def from_bytes(data):
    """The inverse of `to_bytes`."""
    values, value, shift = [], 0, 0
    for byte in data:
        value |= (byte & (MORE - 1)) << shift
        shift += BITS
        if byte < MORE:
            values.append(value)
            value, shift = 0, 0
    return unzigzag(np.array(values, dtype=np.int64))


def unpack(index, text):
    """The inverse of `pack`."""
    data = zlib.decompress(base64.b64decode(text), -zlib.MAX_WBITS)
    columns, at = {}, 0
    for name, _, size in index:
        columns[name] = from_bytes(data[at : at + size])
        at += size
    return columns
