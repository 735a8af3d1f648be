"""The parts of the day with the fleet that is enough: the worst, and a table of all."""

from __future__ import annotations

from dataclasses import replace

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.parts import Folded
from desim_warehouse.outcome.indicators import AT, find
from desim_warehouse.questions import departures, judged
from desim_warehouse.questions.plan.planned import Planned
from desim_warehouse.study.fleet import Sized
from desim_warehouse.study.fleet.hours import ON_TIME, Hour


def worst(planned: Planned, sized: Sized) -> str:
    """Return the sentence on the worst part of the day with the best fleet: `11:30 to 13:00: 97 %`.

    It is left out if the target itself is about a part of the day. The sentence on departures follows, if there are
    any.
    """
    lead = "" if sized.lead is None else departures.in_time(planned.model, sized.lead)
    if not sized.hours or AT in planned.goal.indicator:
        return lead
    worst = _worst_of(sized)
    return f" {worst.named}: {words.reached(ON_TIME, _on_time(planned, worst))}.{lead}"


def _worst_of(sized: Sized) -> Hour:
    return min(sized.hours, key=lambda hour: hour.share.mean)


def _on_time(planned: Planned, hour: Hour) -> str:
    low, high = hour.share.interval or (None, None)
    scale = words.scale(ON_TIME, planned.model, (hour.share.mean,))
    return judged.within(ON_TIME, scale, (hour.share.mean, low, high)).text


def table(planned: Planned) -> list[Folded]:
    """Return the table of orders, and of shares on time, by the hour of the day."""
    sized = planned.answered
    if sized is None or sized.best is None or not sized.hours:
        return []
    rows = [(hour.named, numbers.number(hour.orders), _on_time(planned, hour)) for hour in sized.hours]
    note = f"With {planned.fleet(sized.best.counts)}, by when orders come. All intervals hold together."
    if planned.goal.indicator == ON_TIME:
        worst = replace(planned.goal, measure=find(_worst_of(sized).indicator))
        note += f' A fleet for the worst part: --target "{worst.text}".'
    return [Folded(title="On time by the hour", note=note, head=("time", "orders", "done on time"), rows=tuple(rows))]
