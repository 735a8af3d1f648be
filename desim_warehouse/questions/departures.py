"""Words on departures in the answer of a plan: the latest orders that still make them."""

from __future__ import annotations

import math

from desim_warehouse.answer import numbers
from desim_warehouse.model import Model
from desim_warehouse.model.facts.day_parts import time_of_day
from desim_warehouse.study.fleet.hours import SURE, Lead

_FEW = math.ceil(1 / (1 - SURE))
"""Number of days below which the share of days on which the lead is enough is not printed."""


def in_time(model: Model, lead: Lead) -> str:
    """Return a sentence, after a blank, on orders that make their departure, with an example by the clock."""
    days = f"In {SURE:.0%} of days".replace("%", " %") if lead.days >= _FEW else f"On all {lead.days} days run"
    if not lead.time:
        return f" {days} no order misses its departure."
    before = numbers.duration(lead.time, model.units.time)
    example = _example(model, lead.time)
    return f" {days} orders that come more than {before} before a departure are in time for it{example}."


def _example(model: Model, lead: float) -> str:
    """Return the last departure by the clock and the latest order that makes it; empty without a periodic timetable."""
    tables = [model.timetable(flow) for flow in model.tasks.flows.values() if flow.due_at]
    last = next((table.last(model.run.end) for table in tables if math.isfinite(table.period)), None)
    if last is None:
        return ""
    return f": until {time_of_day(model, last - lead - model.units.hour / 120)} for {time_of_day(model, last)}"
