"""The busiest group of a design, for the live page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from desim_warehouse.answer import busiest, numbers
from desim_warehouse.model import Model
from desim_warehouse.study.fleet.loads import loads
from desim_warehouse.study.table import Row


class Busy(NamedTuple):
    """A sentence on the busiest group, and the name and load of each group, the largest load first."""

    busiest: str
    loads: list[tuple[str, float]]


def busy(rows: Sequence[Row], model: Model, confidence: float) -> Busy:
    """Return the sentence on the busiest group of a design, and the load of each group, from its runs."""
    measured = loads(rows, model, confidence)
    line = busiest.are(measured)
    listed = [(numbers.capital(load.group.name), load.mean) for load in measured]
    return Busy(numbers.sentence(line) if line else "", listed)
