"""The pace of a whole fleet where work always waits, measured on its own floor, with traffic, queues and choice.

For the quick estimate (`run.quick`).

Robots are always on duty, and never broken or empty: the time for hours, repairs and charging is worked out from it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import pairwise

from desim_warehouse.model import Model
from desim_warehouse.model.sections.flows import SaturatedArrivals
from desim_warehouse.model.sections.goods import SaturatedGoods
from desim_warehouse.outcome.log import Log
from desim_warehouse.run.backlog import Backlog
from desim_warehouse.run.probe import always_there, log_of, ridden, shares_of_flows
from desim_warehouse.states import STATES, Phase
from desim_warehouse.values.fields import FrozenMap

TASKS = 400
"""Tasks that are counted, about."""
MOST_ROBOTS = 60
"""Robots that a check lets drive together: more take too long."""
CHOICE = 20
"""Tasks among which others may choose."""
LINES = 100
"""Lines that wait at a station with pods where work piles up."""
ROUNDS = 2
"""Tasks of each robot before those that are counted."""


@dataclass(frozen=True)
class Pace:
    """The pace of a fleet with some tasks always waiting.

    `rate`: tasks per time unit. `empty`: time of the empty drives of a task. `work`: time that a task takes a robot,
    without its queues. `free`: the share of their time in which robots have no task. `lines`: picked at a visit of a
    pod. `rides`: by edge of a lift, rides for each task.
    """

    rate: float
    empty: float
    work: float
    free: float
    lines: float
    rides: Mapping[str, float]


@dataclass(frozen=True)
class Together:
    """The pace of a fleet whose backlog grows, with `many` tasks to choose from.

    With pods, where one line waits for another, also with `few` of them, so that each robot just finds its next.
    """

    few: Pace
    many: Pace
    waiting: int


def together(model: Model, known_tasks: int) -> Together | None:
    """Simulate all robots of a model with work always waiting, `known_tasks` for each; None where they come to a stall.

    With pods no more than `MOST_ROBOTS` drive; other fleets of more are not looked at.
    """
    robots = model.fleet.size
    if model.pods is None and robots > MOST_ROBOTS:
        return None
    fleet = model.fleet
    if robots > MOST_ROBOTS:
        robots = MOST_ROBOTS
        fleet = fleet.model_copy(update={"size": robots, "kinds": {}, "start": fleet.start[:robots]})
    model = model.model_copy(update={"fleet": fleet})
    few, many = _waiting(model, known_tasks)
    rates = shares_of_flows(model)  # means over the run, as that of a probe has no end
    model = always_there(model)
    pace = _pace(model, few, rates)
    crowded_pace = pace if many == few else _pace(model, many, rates)
    return None if pace is None or crowded_pace is None else Together(pace, crowded_pace, many)


def _waiting(model: Model, known_tasks: int) -> tuple[int, int]:
    """Return how many lines of pods wait where robots just find their next line, and tasks where the backlog grows."""
    tasks, robots = model.tasks, model.fleet.size
    if isinstance(tasks.goods, SaturatedGoods):
        return (always := tasks.goods.open(robots)), always
    always = sum(flow.when.saturated for flow in tasks.flows.values() if isinstance(flow.when, SaturatedArrivals))
    if tasks.flows and all(isinstance(flow.when, SaturatedArrivals) for flow in tasks.flows.values()):
        return always, always
    if model.pods is not None:  # a line waits until it is picked
        return robots + known_tasks, LINES * len(model.floor.stations) + robots
    return (many := max(CHOICE, known_tasks)), many


@lru_cache(maxsize=64)
def _pace(model: Model, waiting: int, rates: FrozenMap[str, float]) -> Pace | None:
    """Measure the pace of the fleet with so many tasks waiting."""
    before = ROUNDS * model.fleet.size
    demand = partial(
        Backlog,
        flows=tuple(model.tasks.flows),
        count=before + TASKS + waiting,
        waiting=waiting,
        in_turn=False,
        rates=rates,
        pause=0.0,
    )
    log = log_of(model, demand)
    released = max((row.time for row in log.of("released")), default=0.0)
    done = [time for time in sorted(row.time for row in log.of("delivered")) if time <= released]
    if len(done) <= before + 1:
        return None
    begin, end = done[before], done[-1]
    count = len(done) - before - 1
    if end <= begin:
        return None
    spent = _spent(log, begin, end)
    every = math.fsum(spent.values())
    free = spent[Phase.REST] + spent[Phase.TO_BAY]
    visits = sum(begin < row.time <= end for row in log.of("stored"))
    return Pace(
        rate=count / (end - begin),
        empty=spent[Phase.TO_GOOD] / count,
        work=(every - free - spent[Phase.QUEUE]) / count,
        free=free / every,
        lines=count / visits if visits else 1.0,
        rides=ridden(log, model.floor),
    )


def _spent(log: Log, begin: float, end: float) -> dict[Phase, float]:
    """Return the time of all robots in each phase between two times."""
    spent: dict[Phase, float] = defaultdict(float)
    for row, then in pairwise(sorted(log.of(*STATES), key=lambda row: row.robot)):
        phase = STATES[row.kind].phase
        if row.robot == then.robot and phase is not None:
            spent[phase] += max(min(then.time, end) - max(row.time, begin), 0.0)
    return spent
