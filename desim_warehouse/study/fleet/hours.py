"""Orders on time by the hour at which they come: the worst hour of a design that is enough over the whole day."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from desim_warehouse.model import Model
from desim_warehouse.model.facts.day_parts import parts_of_the_day
from desim_warehouse.outcome.indicators import AT, said_part, split
from desim_warehouse.study.statistics.intervals import Estimate, TaskShare, estimate
from desim_warehouse.study.table import Row

DAYS = 10
"""Days that are looked at by the hour, at least."""
ON_TIME = "on_time"
DEPARTURE_LEAD = "departure_lead"
SURE = 0.95
"""Part of the days on which an order that comes so early is in time."""


@dataclass(frozen=True)
class Hour:
    """A part of the day (`parts_of_the_day`): how many orders come in it a day, and the share of them on time.

    `indicator`: whose mean the share is, such as `on_time@11:30-13:00`.
    """

    indicator: str
    orders: float
    share: Estimate

    @property
    def named(self) -> str:
        """The part of the day by the clock: `11:30 to 13:00`."""
        return said_part(split(self.indicator)[2])


@dataclass(frozen=True)
class Lead:
    """The order lead time: how long before its departure an order must come to be in time on `SURE` of `days` days."""

    time: float
    days: int


def lead_of(days: Sequence[Row]) -> Lead | None:
    """The order lead time at a design that was run on some days; None where nothing departs."""
    leads = sorted(lead for row in days if math.isfinite(lead := row.value(DEPARTURE_LEAD)))
    return Lead(leads[math.ceil(SURE * len(leads)) - 1], len(leads)) if leads else None


def by_hour(model: Model, days: Sequence[Row], confidence: float) -> tuple[Hour, ...]:
    """The orders on time by the part of the day in which they come, on the days that a design was run.

    All intervals hold at once with the confidence.
    """
    parts = parts_of_the_day(model)
    level = 1 - (1 - confidence) / max(len(parts), 1)
    hours = []
    for part in parts:
        indicator = f"{ON_TIME}{AT}{part}"
        values = [row.value(indicator) for row in days]
        shares = [value for value in values if isinstance(value, TaskShare)]  # of the days on which orders came then
        if len(shares) > 1:
            orders = math.fsum(share.of for share in shares) / len(shares)
            hours.append(Hour(indicator, orders, estimate(shares, level, within=(0.0, 1.0))))
    return tuple(hours)
