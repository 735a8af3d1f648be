"""How many runs would tell, where those so far do not: further ones are taken to be like them."""

from __future__ import annotations

from bisect import bisect_left
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

MOST_TO_TELL = 1000
"""Runs of a design beyond which it is not said how many would tell."""
SPARE = 1.5
"""Times as far from what is asked as the bounds reach: were the mean so far the true one, five of six are told then."""


def fewest(told: Callable[[int], bool], above: int) -> int | None:
    """The smallest number of runs, more than `above`, that tells; None: it is more than `MOST_TO_TELL`."""
    counts = range(above + 1, MOST_TO_TELL + 1)
    place = bisect_left(counts, True, key=told)
    return counts[place] if place < len(counts) else None
