"""The busiest group at a design, as the live page shows it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from desim_warehouse.answer import busiest, numbers
from desim_warehouse.model import Model
from desim_warehouse.study.fleet.loads import loads
from desim_warehouse.study.table import Row


class Busy(NamedTuple):
    """The busiest group in a sentence, and each group by its name with its load, the largest first."""

    busiest: str
    loads: list[tuple[str, float]]


def busy(rows: Sequence[Row], model: Model, confidence: float) -> Busy:
    """Find the busiest group of a design from its runs: the sentence on it, and the load of each group."""
    measured = loads(rows, model, confidence)
    line = busiest.are(measured)
    listed = [(numbers.capital(load.group.name), load.mean) for load in measured]
    return Busy(numbers.sentence(line) if line else "", listed)
