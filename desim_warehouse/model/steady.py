"""A day without its ups and downs: orders that come evenly, and calendars without breaks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from statistics import fmean
from typing import Any

from desim_warehouse.model import Model
from desim_warehouse.model.sections.flows import FlowSpec, OrdersArrivals, ProfileArrivals, ScheduleArrivals
from desim_warehouse.values.calendars import DAY, DAYS, Calendar, Pattern, Shifts, Stretch, clock_time

MOST_BREAK = 2.0
"""Hours: what is closed for longer between two stretches is no break."""
WAVES = 24
"""Waves into which the tasks of a schedule are spread."""


# Orders


def evenly(model: Model) -> dict[str, Any]:
    """Return the changes by which flows with peaks bring as many tasks in the evaluation period at one rate, if any."""
    changes = {name: _even(model, flow) for name, flow in model.tasks.flows.items() if "." not in name}
    return {f"tasks.flows.{name}.arrivals": even for name, even in changes.items() if even is not None}


def from_files(model: Model) -> list[str]:
    """Return the flows whose orders come from a file, which says when."""
    return [name for name, flow in model.tasks.flows.items() if isinstance(flow.when, OrdersArrivals)]


def _even(model: Model, flow: FlowSpec) -> dict[str, Any] | None:
    when, run = flow.when, model.run
    if isinstance(when, ProfileArrivals) and math.isfinite(run.end):
        expected = model.rates(when.profile).expected
        stretches = list(model.hours(flow.hours).between(run.warm_up, run.end))
        time = math.fsum(b - a for a, b in stretches)
        tasks = math.fsum(expected(b) - expected(a) for a, b in stretches)
        rate = tasks / time * model.units.hour if time else 0.0
        differs = any(not math.isclose(rate, hourly) for hourly in when.profile.per_hour)
        return {"poisson": float(f"{rate:.6g}")} if rate and differs else None
    if isinstance(when, ScheduleArrivals):
        return _spread(when, run.end)
    return None


def _spread(when: ScheduleArrivals, end: float) -> dict[str, Any] | None:
    """Spread the tasks of a schedule in equal waves over the run, or up to the last where the run has no length."""
    tasks = sum(batch.tasks for batch in when.schedule if batch.at <= end)
    until = end if math.isfinite(end) else max(batch.at for batch in when.schedule)
    waves = min(WAVES, tasks)
    if not until or waves <= 1:
        return None
    counts = [tasks * (n + 1) // waves - tasks * n // waves for n in range(waves)]
    spread = [{"at": until * n / waves, "tasks": count} for n, count in enumerate(counts)]
    return {"schedule": spread}


# Calendars


def opened(model: Model, calendars: Sequence[str | None]) -> float:
    """Return how much more time it is if calendars are always open, as a part of their open time; 0 if none."""
    shares = [model.hours(name).share(0.0, model.run.end) for name in calendars]
    return 1 / fmean(shares) - 1 if calendars and fmean(shares) else 0.0


def without_breaks(model: Model) -> Iterator[tuple[str, float, dict[str, Any]]]:
    """Iterate over the calendars of robots or stations with breaks: how much more time it is without, and the changes.

    The calendar without breaks is a new one, as orders, closures and people may go by the old one.
    """
    for name, users in _users(model).items():
        whole = _whole(model.calendars[name], MOST_BREAK * model.units.hour)
        if whole is None:
            continue
        new = f"{name.replace('.', ' ')} without breaks"
        changes: dict[str, Any] = {f"calendars.{new}": whole, **dict.fromkeys(users, new)}
        end = model.run.end
        before, after = model.hours(name).share(0.0, end), model.replace(changes).hours(new).share(0.0, end)
        if after > before > 0:
            yield name, after / before - 1, changes


def _users(model: Model) -> dict[str, list[str]]:
    """Return the keys of robots and stations that name a calendar, by its name."""
    keys_of: dict[str, list[str]] = {}
    parts = {
        "fleet": model.fleet.hours,
        **{f"fleet.kinds.{name}": kind.hours for name, kind in model.fleet.kinds.items()},
        **{f"layout.stations.{name}": station.hours for name, station in model.layout.stations.items()},
    }
    for key, hours in parts.items():
        if hours is not None and key.count(".") <= 2:  # noqa: PLR2004 - a name with a point is no dotted key
            keys_of.setdefault(hours, []).append(f"{key}.hours")
    return keys_of


def _whole(calendar: Calendar, longest: float) -> dict[str, Any] | None:
    """Return a calendar without its breaks, at most this long and half as long as the time before; None without any."""
    if isinstance(calendar, Shifts):
        spans = _joined_spans(calendar.open)
        days = {} if calendar.days == DAYS else {"days": list(calendar.days)}
        return {"open": spans, **days} if calendar.breaks or len(spans) < len(calendar.open) else None
    if isinstance(calendar, Pattern):
        gap = calendar.every - calendar.lasts
        whole = {**calendar.content(), "lasts": calendar.every}
        return whole if 0 < gap <= min(longest, calendar.lasts / 2) else None
    joined = _joined(calendar.between, longest)
    return {"between": [list(stretch) for stretch in joined]} if len(joined) < len(calendar.between) else None


def _joined(stretches: Iterable[Stretch], longest: float) -> list[Stretch]:
    """Join stretches in order that have only a break between them."""
    joined: list[Stretch] = []
    for begin, end in sorted(stretches):
        if joined and begin - joined[-1][1] <= min(longest, (joined[-1][1] - joined[-1][0]) / 2):
            joined[-1] = joined[-1][0], max(end, joined[-1][1])
        else:
            joined.append((begin, end))
    return joined


def _joined_spans(spans: Iterable[str]) -> list[str]:
    """Join stretches of a day, such as `06:00-14:00`, that have only a break between them."""
    texts: dict[float, str] = {}
    stretches: list[Stretch] = []
    for span in spans:
        begin, _, end = (part.strip() for part in span.partition("-"))
        first, last = clock_time(begin), clock_time(end)
        last += DAY if last <= first else 0.0
        texts |= {first: begin, -last: end}
        stretches.append((first, last))
    return [f"{texts[first]}-{texts[-last]}" for first, last in _joined(stretches, MOST_BREAK * DAY / 24)]
