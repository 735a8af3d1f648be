"""The course of a run on a page: curves of `outcome.day` in lanes over a common time axis, and the worst stretch.

For the page and answer of a run, and for its replay.

Reports and the replay share this drawing; its text is HTML, so that it is legible on a phone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from desim_warehouse.answer import numbers
from desim_warehouse.answer.numbers import capital
from desim_warehouse.errors import number_of
from desim_warehouse.look import html
from desim_warehouse.model import Model
from desim_warehouse.model.facts.day_parts import time_of_day
from desim_warehouse.model.sections.goods import SaturatedGoods
from desim_warehouse.outcome.day import DOING, Day
from desim_warehouse.outcome.halts import Halt
from desim_warehouse.values.arrays import Floats
from desim_warehouse.values.calendars import clock_of

if TYPE_CHECKING:
    from markupsafe import Markup


_HELD = {
    "batteries": "robots charged or waited to charge, with {}",
    "off duty": "robots were off duty",
    "closed": "stations were closed",
    "lanes": "lanes were closed",
    "people": "people were in lanes",
    "lifts": "robots waited for lifts, or for people in them",
    "broken": "robots had broken down",
    "queues": "robots waited for each other",
    "pickers": "robots waited for pickers",
    "no stock": "no pod held any more of what they asked for",
    "no task": "robots were given no task",
}
"""Main activity of robots in a standstill of deliveries, by the causes of `outcome.halts`."""
WIDTH, HEIGHT = 1000, 100
"""Horizontal and vertical resolution of lanes, in steps; a step is less than a pixel on most screens."""
_OPEN = "Open tasks"
"""The second lane of a short course, below the lane of robots; where work never ends it shows deliveries instead."""
_LOW = 4
"""Vertical resolution of low lanes, in steps: less than two pixels there."""
_TICKS = 8
"""Largest number of times below the lanes."""
_STEPS = (1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 21600, 43200, 86400)
"""Intervals between these times, in seconds."""
_BY_HOURS, _BY_MINUTES = 7200, 600
"""Lengths of a window from which times are given in hours and minutes, or in minutes, in seconds."""
_NUMBERED = 100
"""Largest fleet whose robots are shown by number."""
_SEEN = 0.01
"""Least share of the fleet in an activity for it to be shown."""


class Layer(NamedTuple):
    """An area in a lane of the drawing: its CSS class, its SVG path, and its label (None: the name of the lane)."""

    kind: str
    words: str | None
    path: str


class CourseLane(NamedTuple):
    """A lane of the drawing, with one curve or several stacked: name, unit, and the number at its top."""

    name: str
    unit: str
    top: str
    layers: tuple[Layer, ...]


class Curve(NamedTuple):
    """A curve below the lane of robots: its name, unit, CSS class (`kind`), values, and the value at the top."""

    name: str
    unit: str
    kind: str
    values: Floats
    top: float

    @property
    def top_text(self) -> str:
        """The number at the top of the lane, as text."""
        return numbers.PERCENT.value(self.top) if self.kind == "battery" else numbers.measured(self.top)


def stood_still(halt: Halt, model: Model, chargers: int, times: int = 1) -> str:
    """Return the sentence on a standstill of deliveries, with its time and its cause.

    `times`: number of standstills with this cause, of which `halt` is the longest.
    """
    start, end = moment(model, halt.start), moment(model, halt.end)
    when = f"from {start} to {end}"
    if start == end:
        when = f"for {numbers.duration(halt.end - halt.start, model.units.time)} at {start}"
    more = f" (the longest of {times} times)" if times > 1 else ""
    why = _HELD[halt.cause].format(number_of(chargers, "charger"))
    return f"Deliveries stood still {when}{more} with {number_of(halt.open, 'task')} open: {why}."


def worst(day: Day, model: Model, chargers: int) -> str:
    """Return the sentences on the worst stretch of a run, or a sentence that none stands out."""
    worst = day.worst
    if worst is None:
        return "No part of the run stands out."
    if isinstance(worst, Halt):
        return stood_still(worst, model, chargers)
    most, usual = (numbers.number(round(value)) for value in (worst.most, worst.usual))
    do = f"{numbers.PERCENT.value(worst.share)} of the robots were {DOING[worst.doing]}"
    begin, end = moment(model, worst.start), moment(model, worst.end)
    return f"Most tasks were open from {begin} to {end}: {most}, usually {usual}. {do}."


def _as_on_axis(model: Model, time: float) -> str:
    """Return a time of a run in hours and minutes, as on the axis: `14:35`."""
    if model.run.start != "00:00":
        return time_of_day(model, time)
    minutes = round(time * model.units.seconds / 60)
    return f"{minutes // 60:02d}:{minutes % 60:02d}"


def flag(day: Day) -> str:
    """Return the label of the worst stretch, `nothing delivered` or `most tasks open`; empty without one."""
    return "" if day.worst is None else "nothing delivered" if isinstance(day.worst, Halt) else "most tasks open"


def moment(model: Model, time: float) -> str:
    """Return a time of a run in words: the time of day if it starts by the clock, else the time since its start."""
    return time_of_day(model, time) if model.run.start != "00:00" else numbers.duration(time, model.units.time)


def worst_hour(day: Day, model: Model) -> str:
    """Return the sentence on the hour of the evaluation period with the most open tasks; empty below two hours.

    If tasks are always available, it is the hour with the fewest deliveries.
    """
    endless, hour = isinstance(model.tasks.goods, SaturatedGoods), model.units.hour
    starts, end = day.bounds[:-1], float(day.bounds[-1])
    begins = starts[(starts >= day.begin) & (starts + hour <= end)]
    if len(begins) == 0 or end - day.begin < 2 * hour:
        return ""
    values = day.delivered if endless else day.open
    so_far = np.concatenate([[0.0], np.cumsum(values * np.diff(day.bounds))])

    def mean(first: float, last: float) -> float:
        low, high = np.interp([first, last], day.bounds, so_far)
        return float(high - low) / (last - first)

    means = [mean(float(begin), float(begin) + hour) for begin in begins]
    index = int(np.argmin(means) if endless else np.argmax(means))
    first, last = (_as_on_axis(model, float(begins[index]) + more) for more in (0.0, hour))
    span = f"{first} to {last}"
    worst, usual = numbers.measured(means[index]), numbers.measured(mean(day.begin, end))
    if endless:
        return f"The worst hour was {span}: {worst} loads were delivered, against {usual} an hour over the whole run."
    return f"The worst hour was {span}: {worst} tasks were open on average, against {usual} over the whole run."


def figure(
    day: Day,
    model: Model,
    chargers: int,
    shown: tuple[float, float] | None = None,
    *,
    named: str = "",
    in_short: bool = False,
) -> Markup:
    """Draw the course of a run as a figure of a page.

    Args:
        day: the course.
        model: the warehouse.
        chargers: the number of its chargers.
        shown: start and end of the part that is drawn; None for the whole run.
        named: the rank of the run among others, such as `the worst of 33 days, 94.5 % on time`.
        in_short: draw two lanes only, and name the worst hour if no stretch stands out.
    """
    start, end = shown or (float(day.bounds[0]), float(day.bounds[-1]))
    part = numbers.duration(float((day.bounds[1:] - day.bounds[:-1]).max()), model.units.time)
    band = None
    if day.worst is not None and day.worst.end > start and day.worst.start < end:
        low, high = (_across(time, start, end) for time in (day.worst.start, day.worst.end))
        span = f"{moment(model, day.worst.start)} to {moment(model, day.worst.end)}"
        band = low, max(high - low, 2), f"{span}: {flag(day)}"
    drawn = lanes(day, model, chargers, start, end)
    summary = worst(day, model, chargers)
    if in_short:
        drawn = [drawn[0], next((lane for lane in drawn if lane.name == _OPEN), drawn[1])]
        summary = summary if day.worst is not None else worst_hour(day, model) or summary
    title = f"{capital(named)}," if named else "How it went"
    title = capital(named) if in_short else f"{title} by the clock, in means of {part}"
    made: Markup = html.template("course.html").module.course(  # type: ignore[attr-defined] # a macro
        drawn, band, _across(day.begin, start, end), ticks(model, start, end), title, summary, in_short
    )
    return made


def by_robot(shares: dict[str, Floats]) -> Markup:
    """Draw the stacked shares of the activities of each robot, by number or, for a large fleet, the busiest first.

    `shares`: a value for each robot, by activity (`outcome.day.DOING`).
    """
    count = len(next(iter(shares.values())))
    few = count <= _NUMBERED
    order = np.arange(count) if few else np.argsort(-shares.get("work", np.zeros(count)), kind="stable")
    ends = [_across(number, 0, count) for number in range(count + 1)]
    below, layers = np.zeros(count), []
    for name, values in shares.items():
        below = below + values[order]
        if values.max() >= _SEEN:
            layers.append(Layer(name, DOING[name], _area(below, ends, 1.0)))
    step = -(-count // _TICKS)
    places = [(round(100 * (n + 0.5) / count, 2), str(n)) for n in range(0, count, step)] if few else []
    lane = CourseLane("Robots", "by number" if few else f"all {count}, the busiest first", "100 %", tuple(layers[::-1]))
    made: Markup = html.template("course.html").module.robots(lane, places)  # type: ignore[attr-defined] # a macro
    return made


def curves(day: Day, model: Model, chargers: int) -> list[Curve]:
    """Return the curves of a run that are drawn below the lane of robots."""
    most = float(day.queue.max())
    workers = any(station.work_time is not None for station in model.layout.stations.values())
    listed = [Curve("Delivered", "an hour", "delivered", day.delivered, _top(day.delivered))]
    if not isinstance(model.tasks.goods, SaturatedGoods):
        listed.append(Curve(_OPEN, "at a time", "open", day.open, _top(day.open)))
    if most >= _SEEN * model.fleet.size:
        who = "before workers" if workers else "at stations"
        listed.append(Curve("Queue", who, "queue", day.queue, most))
    if day.chargers is not None:
        listed.append(Curve("Chargers", f"in use, of {chargers}", "charging", day.chargers, float(chargers)))
    if day.battery is not None:
        listed.append(Curve("Battery", "mean", "battery", day.battery, 1.0))
    return listed


def lanes(day: Day, model: Model, chargers: int, start: float, end: float) -> list[CourseLane]:
    """Return the lanes of a run between two times."""
    inside = (day.bounds[1:] > start) & (day.bounds[:-1] < end)
    ends = [_across(time, start, end) for time in (*day.bounds[:-1][inside], day.bounds[1:][inside][-1])]
    fleet, below, layers = model.fleet.size, np.zeros(len(ends) - 1), []
    for name, values in day.robots.items():
        if values[inside].max() >= _SEEN * fleet:
            below = below + values[inside]
            layers.append(Layer(name, DOING[name], _area(below, ends, fleet)))
    who = f"what all {fleet} do" if fleet > 1 else "what it does"
    every = [CourseLane("Robots", who, str(fleet), tuple(layers[::-1]))]
    for curve in curves(day, model, chargers):
        area = Layer(curve.kind, None, _area(curve.values[inside], ends, curve.top, _LOW))
        every.append(CourseLane(curve.name, curve.unit, curve.top_text, (area,)))
    return every


def _top(values: Floats) -> float:
    return float(values.max()) or 1.0


def ticks(model: Model, start: float, end: float) -> list[tuple[float, str]]:
    """Return round times between two times, as pairs of the horizontal position in per cent and the text."""
    seconds, begin = model.units.seconds, clock_of(model.run.start)
    first, last = begin + start * seconds, begin + end * seconds
    step = next(
        (each for each in _STEPS if (last - first) / each <= _TICKS), _STEPS[-1] * max(int((last - first) / 1e6), 1)
    )
    by_hours = begin > 0 or last - begin >= _BY_HOURS
    by_minutes = last - begin >= _BY_MINUTES
    placed, now = [], -(-first // step) * step
    while now <= last + 1e-6:
        minutes = round(now / 60)
        text = f"{minutes // 60 % (24 if begin else 10**6):02d}:{minutes % 60:02d}" if by_hours else ""
        text = text or (f"{minutes} min" if by_minutes else f"{now:g} s")
        placed.append((round(100 * (now - first) / (last - first or 1.0), 2), text))
        now += step
    return placed


def _across(time: float, start: float, end: float) -> int:
    return round(WIDTH * min(max((time - start) / (end - start), 0.0), 1.0))


def _area(values: Floats, ends: Sequence[int], top: float, step: int = 1) -> str:
    """Return the SVG path of the area below a step function; adjacent steps of equal height are merged."""
    heights = [step * round(HEIGHT / step * min(float(value) / top, 1.0)) for value in values]
    path, across, height = [f"M{ends[0]} {HEIGHT}"], ends[0], 0
    for start, high in zip(ends, heights, strict=False):
        if high != height:
            path.append(f"{f'h{start - across}' if start > across else ''}v{height - high}")
            across, height = start, high
    return "".join([*path, f"H{ends[-1]}V{HEIGHT}Z"])
