"""What is wrong with a file of orders, summed up by kind, and what was assumed of its columns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

from desim_warehouse.errors import got

MOST_PROBLEMS = 20
"""Kinds of problems of one file that are listed."""
_DISTINCT, _COMMON = 1000, 5  # values of a kind of problem that are told apart, and that are shown


@dataclass
class Problems:
    """What is wrong with a file, summed up by kind: how often, with which values, first where.

    A kind is a column, "" for whole rows, and what is wrong. By column also how the file is read: the mark of
    `decimals`, whether points stand between `thousands` for all that is known, the time zone that is left out.
    """

    file: str
    kinds: dict[tuple[str, str], list[Any]] = field(default_factory=dict)
    values: dict[tuple[str, str], Counter[str]] = field(default_factory=dict)
    decimals: dict[str, str] = field(default_factory=dict)
    thousands: set[str] = field(default_factory=set)
    zones: dict[str, str] = field(default_factory=dict)

    def add(self, column: str, wrong: str, expected: str, rows: Sequence[int], values: Iterable[Any]) -> None:
        """Some rows that have the same problem, and what stands there."""
        kind = column, wrong
        self.kinds.setdefault(kind, [0, rows[0], expected])[0] += len(rows)
        counts = self.values.setdefault(kind, Counter())
        for value in values:
            if (said := got(_plain(value))) in counts or len(counts) < _DISTINCT:
                counts[said] += 1

    def told(self) -> list[str]:
        """A line for each kind, up to 20."""
        lines = []
        for (column, wrong), (count, row, expected) in islice(self.kinds.items(), MOST_PROBLEMS):
            counts = self.values[column, wrong]
            if count == 1:
                where, said = f"{self.file}, row {row}", f"got {next(iter(counts))}"
            else:
                where, number = self.file, f"{len(counts)}{' or more' * (len(counts) == _DISTINCT)}"
                common = ", ".join(value for value, _ in counts.most_common(_COMMON)) + ", ..." * (
                    len(counts) > _COMMON
                )
                many = "values" if len(counts) > 1 else "value"
                said = f"{count:,} rows from row {row} on, {number} {many}: {common}"
            where += f", {column}" * bool(column)
            lines.append(f"{where}: {wrong} ({said}), expected {expected}")
        more = len(self.kinds) - MOST_PROBLEMS
        return [*lines, *[f"{self.file}: and {more} more kinds of problems"] * (more > 0)]


def _plain(value: Any) -> Any:
    return value.item() if hasattr(value, "item") else str(value) if hasattr(value, "isoformat") else value
