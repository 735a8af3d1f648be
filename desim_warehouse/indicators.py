"""The indicators of a run: the one list of them.

An indicator is added by adding it to `INDICATORS`, here: its name, unit, meaning, which direction is better, how it is
computed from the history of a run, and where it applies. Runs, studies, targets, reports, figures, the command line
and the reference in the documentation all read this list.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from desim_warehouse.errors import StudyError, nearest
from desim_warehouse.states import TIMES

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from desim_warehouse.history import History
    from desim_warehouse.states import State

Unit = Literal[
    "time", "length", "energy", "count", "tasks", "tasks per hour", "weighted", "share of tasks", "share of fleet time"
]
Better = Literal["less", "more"]


@dataclass(frozen=True)
class Indicator:
    """A number that a run is judged by.

    `title`: for people, on axes and in reports. `unit`: its kind of unit; the model says what time and length are
    counted in. `meaning`: for the reference. `better`: whether less or more of it is better, None: neither by itself.
    `compute`: its value, counted from the end of the warm-up to the end of the run. `applies`: whether a run has it.
    """

    name: str
    title: str
    unit: Unit
    meaning: str
    better: Better | None
    compute: Callable[[History], float]
    applies: Callable[[History], bool] = lambda _: True

    @property
    def is_share(self) -> bool:
        """Whether it lies from 0 to 1."""
        return self.unit.startswith("share")


def _total(tally: str) -> Callable[[History], float]:
    return lambda history: history.totals[tally]


def _count(tally: str) -> Callable[[History], int]:
    return lambda history: int(history.totals[tally])


def _collisions(history: History) -> int:
    return int(history.totals["rear_ends"] + history.totals["crossings"])


def _cost(history: History) -> float:
    """The paper's outlook: distance x w_d + time x w_t + S x w_c; the counted time, without a warm-up T."""
    weights, distance = history.model.cost, history.totals["distance"]
    return distance * weights.distance + history.counted * weights.time + _collisions(history) * weights.collisions


def _rotations(history: History) -> int:
    return sum(1 for ring in history.rotations if history.counts(ring.time))


def _throughput(history: History) -> float:
    hours = history.counted / history.model.units.hour
    return history.totals["delivered"] / hours if hours else math.nan


def _share(state: str) -> Callable[[History], float]:
    def compute(history: History) -> float:
        time = history.counted * len(history.log.robots)
        return history.totals[state] / time if time else math.nan

    return compute


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values) if values else math.nan


def quantile(ordered: Sequence[float], part: float) -> float:
    """Linear interpolation between order statistics, as numpy's default (kept here to start up without numpy)."""
    if not ordered:
        return math.nan
    place = part * (len(ordered) - 1)
    low = math.floor(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])


def _has_due_times(history: History) -> bool:
    return bool(history.lateness)


def _share_of(state: State) -> Indicator:
    """The share of the fleet's time in a state; waiting in traffic is counted apart, and they add up to 1."""
    better: Better | None = "less" if state.name in ("empty", "queueing", "returning", "waiting") else None
    name = f"share_{state.name}"
    return Indicator(name, f"Fleet {state.doing}", "share of fleet time", state.time, better, _share(state.name))


INDICATORS = {
    indicator.name: indicator
    for indicator in (
        Indicator(
            "T",
            "Task time T",
            "time",
            "task time: when the last robot is back with all goods delivered; lifelong demand: the run's length",
            "less",
            lambda history: history.end,
        ),
        Indicator(
            "S",
            "Collisions S",
            "count",
            "collisions: waiting episodes of all robots, `rear_ends + crossings`",
            "less",
            _collisions,
        ),
        Indicator(
            "C",
            "Chargings C",
            "count",
            "chargings after which a robot went out again",
            "less",
            _count("recharged"),
        ),
        Indicator(
            "tasks",
            "Tasks delivered",
            "count",
            "tasks delivered",
            "more",
            _count("delivered"),
        ),
        Indicator("moves", "Edges driven", "count", "edges driven", "less", _count("moves")),
        Indicator(
            "distance",
            "Distance driven",
            "length",
            "driven by all robots",
            "less",
            _total("distance"),
        ),
        Indicator("energy", "Energy drawn", "energy", "used by all robots", "less", _total("energy")),
        Indicator(
            "waiting",
            "Time waited in traffic",
            "time",
            "waited in traffic, all robots together",
            "less",
            _total("waiting"),
        ),
        Indicator(
            "cost",
            "Cost",
            "weighted",
            "`w_d distance + w_t time + w_c S`, with the weights of the section `cost`; time: what is counted of T",
            "less",
            _cost,
        ),
        Indicator(
            "rear_ends",
            "Waits behind a robot on an edge",
            "count",
            "collisions behind a robot on the same edge",
            "less",
            _count("rear_ends"),
        ),
        Indicator(
            "crossings",
            "Waits before an intersection",
            "count",
            "collisions before an intersection",
            "less",
            _count("crossings"),
        ),
        Indicator("rotations", "Gridlock rotations", "count", "full rings that turned", "less", _rotations),
        Indicator(
            "throughput_per_hour",
            "Throughput",
            "tasks per hour",
            "`tasks / (counted time × units.seconds / 3600)`",
            "more",
            _throughput,
        ),
        Indicator(
            "cycle_time_mean",
            "Cycle time, mean",
            "time",
            "from a task's release to its delivery, mean",
            "less",
            lambda history: _mean(history.cycle_times),
        ),
        Indicator(
            "cycle_time_median",
            "Cycle time, median",
            "time",
            "the same, median",
            "less",
            lambda history: quantile(history.cycle_times, 0.5),
        ),
        Indicator(
            "cycle_time_p95",
            "Cycle time, 95 % quantile",
            "time",
            "the same, 95 % quantile (linear between order statistics)",
            "less",
            lambda history: quantile(history.cycle_times, 0.95),
        ),
        Indicator(
            "backlog",
            "Backlog at the end",
            "tasks",
            "tasks released and not delivered, at the end",
            "less",
            lambda history: len(history.tasks) - len(history.delivered),
        ),
        Indicator(
            "tardiness_mean",
            "Tardiness, mean",
            "time",
            "mean of `max(delivery − due, 0)`; only where tasks have due times",
            "less",
            lambda history: _mean(history.lateness),
            _has_due_times,
        ),
        Indicator(
            "on_time",
            "Delivered on time",
            "share of tasks",
            "part of the tasks delivered by their due time; only where tasks have due times",
            "more",
            lambda history: _mean([not late for late in history.lateness]),
            _has_due_times,
        ),
        *(_share_of(state) for state in TIMES.values()),
    )
}
"""By name, in the order of tables."""


def kpis(history: History) -> dict[str, float]:
    """All indicators that a run has, in the units of its model file."""
    return {name: indicator.compute(history) for name, indicator in INDICATORS.items() if indicator.applies(history)}


def within(name: str) -> tuple[float, float]:
    """What an indicator of ours can be: a share 0 to 1, any other at least 0; of other numbers nothing is known."""
    if name not in INDICATORS:
        return -math.inf, math.inf
    return 0.0, 1.0 if INDICATORS[name].is_share else math.inf


def find(name: str) -> Indicator:
    """An indicator by its name; raises StudyError where there is none, naming the nearest."""
    if name not in INDICATORS:
        near = nearest(name, INDICATORS)
        hint = f"did you mean {near!r}?" if near else f"expected one of {', '.join(INDICATORS)}"
        raise StudyError(f"indicator {name!r}: there is none, {hint}")
    return INDICATORS[name]
