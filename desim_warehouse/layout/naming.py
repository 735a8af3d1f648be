"""Names of the nodes of a block layout: the letters of the paper, or row and column where letters run out."""

from __future__ import annotations

from string import ascii_uppercase


def block_nodes(columns: int, rows: int) -> tuple[tuple[str, ...], ...]:
    """Name the nodes around blocks, row by row from the top, each row from the left.

    Up to 26 nodes are A, B, C, ...; in a larger layout the node in row 0 and column 3 is `r0c3`.

    Args:
        columns: blocks side by side; there is one more column of nodes.
        rows: blocks one below the other; there is one more row of nodes.

    Returns:
        One tuple of names for each row of nodes.
    """
    across, down = columns + 1, rows + 1
    if across * down <= len(ascii_uppercase):
        return tuple(tuple(ascii_uppercase[row * across : (row + 1) * across]) for row in range(down))
    return tuple(tuple(f"r{row}c{column}" for column in range(across)) for row in range(down))
