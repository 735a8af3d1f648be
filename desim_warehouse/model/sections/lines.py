"""Lines of an order: a number, the least and the most, or some numbers by their shares."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from pydantic import AfterValidator, Field

from desim_warehouse.errors import got
from desim_warehouse.values.fields import NUMBER, SECTION, Count, Forms, Part, Weights, by_type, form, limited, wrong

if TYPE_CHECKING:
    from numpy.random import Generator


LineCount = Annotated[Count, limited("lines")]


def _in_order(pair: tuple[int, int]) -> tuple[int, int]:
    if pair[0] > pair[1]:
        raise wrong(f"the least is above the most (got {got(list(pair))}), expected [least, most]")
    return pair


class LineCounts(Part):
    """Numbers of lines, and their relative frequencies."""

    values: tuple[LineCount, ...] = Field(min_length=1, description="numbers of lines")
    weights: Weights = Field((), description="one for each value; default: all equal")


class DiscreteLines(Part):
    """`discrete: {values: [1, 2, 5], weights: [6, 3, 1]}`: one of a few numbers."""

    discrete: LineCounts = Field(description="values and weights")


Lines = Annotated[
    Annotated[LineCount, form("number")]
    | Annotated[tuple[LineCount, LineCount], AfterValidator(_in_order), form("between")]
    | Annotated[DiscreteLines, form("discrete")],
    Forms(
        "a whole number, [least, most], or {discrete: {values: [1, 2], weights: [3, 1]}}",
        pick=by_type(number=NUMBER, between=(list, tuple), discrete=SECTION),
    ),
]


def shares_of(lines: int | tuple[int, int] | DiscreteLines) -> dict[int, float]:
    """Return the probability of each number of lines."""
    if isinstance(lines, int):
        return {lines: 1.0}
    if isinstance(lines, tuple):
        least, most = lines
        return dict.fromkeys(range(least, most + 1), 1 / (most + 1 - least))
    values, shares = lines.discrete.values, dict.fromkeys(lines.discrete.values, 0.0)
    weights = lines.discrete.weights or (1.0,) * len(values)
    total = math.fsum(weights)
    for value, weight in zip(values, weights, strict=True):
        shares[value] += weight / total
    return {value: share for value, share in shares.items() if share}


def mean_lines(lines: int | tuple[int, int] | DiscreteLines) -> float:
    """Return the mean number of lines of an order, given the number or its distribution."""
    return math.fsum(count * share for count, share in shares_of(lines).items())


def draw_lines(lines: int | tuple[int, int] | DiscreteLines, generator: Generator) -> int:
    """Draw the number of lines of one order."""
    return int(generator.choice(list(shares_of(lines)), p=list(shares_of(lines).values())))


def lines_in_words(lines: int | tuple[int, int] | DiscreteLines) -> str:
    """Write numbers of lines, such as `2 lines each`, or `1 to 4 lines each`."""
    shares = shares_of(lines)
    if len(shares) == 1:
        (only,) = shares
        return f"{only} lines each" if only > 1 else "1 line each"
    return f"{min(shares)} to {max(shares)} lines each"
