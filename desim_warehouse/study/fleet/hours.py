"""Service level by the hour at which orders arrive: the worst hour of a design that suffices over the whole day."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from desim_warehouse.model import Model
from desim_warehouse.model.facts.day_parts import parts_of_the_day
from desim_warehouse.outcome.indicators import AT, part_in_words, split
from desim_warehouse.study.statistics.intervals import Estimate, TaskShare, estimate
from desim_warehouse.study.table import Row

DAYS = 10
"""Fewest days for results by the hour."""
ON_TIME = "on_time"
DEPARTURE_LEAD = "departure_lead"
SURE = 0.95
"""Share of the days on which an order that arrives by the lead time is in time."""


@dataclass(frozen=True)
class Hour:
    """A part of the day (`parts_of_the_day`): orders that arrive in it per day, and the share of them on time.

    `indicator`: name of the indicator whose mean is `share`, such as `on_time@11:30-13:00`.
    """

    indicator: str
    orders: float
    share: Estimate

    @property
    def named(self) -> str:
        """The part of the day by the clock: `11:30 to 13:00`."""
        return part_in_words(split(self.indicator)[2])


@dataclass(frozen=True)
class Lead:
    """The order lead time: how long before departure an order must arrive to be in time on `SURE` of `days` days."""

    time: float
    days: int


def lead_of(days: Sequence[Row]) -> Lead | None:
    """Return the order lead time of a design from the days on which it was run; None if nothing departs."""
    leads = sorted(lead for row in days if math.isfinite(lead := row.value(DEPARTURE_LEAD)))
    return Lead(leads[math.ceil(SURE * len(leads)) - 1], len(leads)) if leads else None


def by_hour(model: Model, days: Sequence[Row], confidence: float) -> tuple[Hour, ...]:
    """Estimate the share of orders on time for each part of the day in which they arrive, from a design's days.

    All intervals hold simultaneously with the confidence.
    """
    parts = parts_of_the_day(model)
    level = 1 - (1 - confidence) / max(len(parts), 1)
    hours = []
    for part in parts:
        indicator = f"{ON_TIME}{AT}{part}"
        values = [row.value(indicator) for row in days]
        shares = [value for value in values if isinstance(value, TaskShare)]  # of days with orders in this part
        if len(shares) > 1:
            orders = math.fsum(share.of for share in shares) / len(shares)
            hours.append(Hour(indicator, orders, estimate(shares, level, within=(0.0, 1.0))))
    return tuple(hours)
