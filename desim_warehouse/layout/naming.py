"""Names of the nodes of a block layout, and of storage places by a pattern of aisle, bay and level."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from string import Formatter, ascii_uppercase

from desim_warehouse.layout.layout import StoragePlace

FIELDS = ("aisle", "bay", "level", "number", "aisle_letter", "level_letter")
"""Fields that the pattern of a storage place's name may contain."""
_FORM = re.compile(r"(0?\d)?d?")


def block_nodes(columns: int, rows: int, floor: int = 0) -> tuple[tuple[str, ...], ...]:
    """Name the nodes around blocks, row by row from the top, each row from the left.

    Up to 26 nodes are A, B, C, ...; in a larger layout the node in row 0 and column 3 is `r0c3`. Above the ground floor
    the number of the floor follows: `A1`, or `r0c3f1`.

    Args:
        columns: blocks side by side; there is one more column of nodes.
        rows: blocks one below the other; there is one more row of nodes.
        floor: number of the floor; 0 is the ground floor.

    Returns:
        One tuple of names for each row of nodes.
    """
    across, down = columns + 1, rows + 1
    if across * down <= len(ascii_uppercase):
        above = str(floor) if floor else ""
        return tuple(
            tuple(f"{letter}{above}" for letter in ascii_uppercase[row * across : (row + 1) * across])
            for row in range(down)
        )
    above = f"f{floor}" if floor else ""
    return tuple(tuple(f"r{row}c{column}{above}" for column in range(across)) for row in range(down))


def wrong_part(pattern: str) -> str:
    """Return the problem of a pattern of names; empty if there is none."""
    try:
        parts = list(Formatter().parse(pattern))
    except ValueError as error:
        return str(error)
    fields = [(name, form or "", turned) for _, name, form, turned in parts if name is not None]
    strange = [name for name, form, turned in fields if name not in FIELDS or turned or not _FORM.fullmatch(form)]
    return f"unknown field {strange[0]!r}" if strange else "" if fields else "no field"


def named_by(pattern: str, levels: int, storage: Sequence[StoragePlace]) -> Iterator[tuple[str, int]]:
    """Yield the names that a pattern gives to storage places, each with the number of its place.

    A place with several levels has a name for each. An aisle is an edge beside which there are places; aisles are
    numbered in the order of the storage list, bays along the aisle.
    """
    aisles: dict[tuple[str, str], list[StoragePlace]] = {}
    for place in storage:
        aisles.setdefault(place.edge, []).append(place)
    for aisle, places in enumerate(aisles.values(), 1):
        for bay, place in enumerate(sorted(places, key=lambda place: (place.offset, place.number)), 1):
            for level in range(1, levels + 1):
                letters = {"aisle_letter": _letters(aisle), "level_letter": _letters(level)}
                numbers = {"aisle": aisle, "bay": bay, "level": level, "number": place.number}
                yield pattern.format(**numbers, **letters), place.number


def _letters(number: int) -> str:
    """Return the n-th of A, B, ..., Z, AA, AB, ..., the names of columns in a spreadsheet."""
    number, rest = divmod(number - 1, len(ascii_uppercase))
    return (_letters(number) if number else "") + ascii_uppercase[rest]
