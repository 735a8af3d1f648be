"""Targets that make sense, their indifference zones, and how many runs a first look at them takes.

For `--target` of every command that has it, and for study files.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from desim_warehouse.errors import StudyError, shown
from desim_warehouse.model import Model
from desim_warehouse.model.facts.ahead import handling_of
from desim_warehouse.outcome.indicators import Indicator, refuse_unknown, split
from desim_warehouse.outcome.targets import Target, amount_of, parse_target
from desim_warehouse.study.statistics.checks import is_constant
from desim_warehouse.study.statistics.limits import FIRST, FIRST_OF_MEANS, MOST_ZONE
from desim_warehouse.values.arguments import is_finite
from desim_warehouse.values.units import SECONDS, UnitNames


def read_target(text: str, units: UnitNames | None = None) -> Target:
    """Read a target as users write it, such as `on_time >= 95 %` (or 0.95), `cycle_time_p95 <= 5 min` or `T <= 300`.

    Args:
        text: an indicator, a bound, a number, and a unit or none: then it is in the unit of the model.
        units: those of the model; None: not known yet, and the target has none.

    Raises:
        StudyError: not a target, a unit of another kind, a share outside 0 to 1, or one that is met by doing worse.
    """
    if not isinstance(text, str):
        raise StudyError(f"target {shown(text):.60}: expected words such as 'on_time >= 95 %'")
    goal = parse_target(text, units)
    _refuse_share(text, goal)
    _right_way_round(text, goal)
    return goal


def read_targets(texts: str | Sequence[str], units: UnitNames | None = None) -> tuple[Target, ...]:
    """Read a target, or several that are all to be met.

    Args:
        texts: a target, or a sequence of them.
        units: see `read_target`.

    Raises:
        StudyError: as `read_target`; none, or two bounds of one kind on an indicator.
    """
    listed = list(texts) if isinstance(texts, Sequence) and not isinstance(texts, str) else [texts]
    if not listed:
        raise StudyError("target: none, expected words such as 'on_time >= 95 %'")
    goals = tuple(read_target(text, units) for text in listed)
    for place, goal in enumerate(goals):
        if (goal.indicator, goal.sign) in {(earlier.indicator, earlier.sign) for earlier in goals[:place]}:
            raise StudyError(
                f"target {listed[place]!r}: a second bound on {goal.indicator}, expected the stricter one alone"
            )
    return goals


def check_zone(measure: Indicator, zone: float, aim: float | None = None) -> None:
    """Refuse an indifference zone so wide that nearly all designs lie in it.

    Args:
        measure: the indicator.
        zone: in the indicator's unit.
        aim: the target; None: there is none, and only shares have a largest zone.

    Raises:
        StudyError: no number from 0 on, or above a fifth of the target, or of all there is of a share.
    """
    if not (is_finite(zone) and zone >= 0):
        raise StudyError(f"indifference zone {shown(zone):.60} of {measure.name}: expected a number from 0 on")
    share = measure.is_share
    most = MOST_ZONE if share else math.inf if aim is None else MOST_ZONE * abs(aim)
    if zone <= most:
        return
    size = f"{zone:g} ({zone:.0%})" if share else f"{zone:g}"
    least = f"{most:.0%}" if share else f"{most:g}, a fifth of the target"
    meant = f"; did you mean {zone:g} %?" if share and 0 < zone <= 100 * MOST_ZONE else ""
    raise StudyError(f"indifference zone {size} of {measure.name}: expected at most {least}{meant}")


def indifference(goal: Target, zone: float | str | None, units: UnitNames) -> float:
    """Return the zone as given, else 0.01 of a share or 1 % of the target; at most halfway to the range's end.

    Raises:
        StudyError: no amount of the indicator, or one in which nearly all designs lie.
    """
    if zone is None:
        zone = 0.01 if goal.measure.is_share else 0.01 * abs(goal.value)
    if isinstance(zone, str):
        zone = amount_of(goal.measure, zone, units, "--zone")
    check_zone(goal.measure, zone, goal.value)
    least, largest = goal.measure.within
    return min(zone, abs((largest if goal.sign > 0 else least) - goal.value) / 2)


@dataclass(frozen=True)
class Days:
    """The days behind a mean: how many, the worst value of the target's indicator, and how many miss the target.

    `median`: the value of the day in the middle, of two of them the worse. `worst_run` and `median_run`: which
    replications these two are, the first of equal ones.
    """

    days: int
    worst: float
    missed: int
    median: float
    worst_run: int
    median_run: int


def days_of(values: Iterable[float], goal: Target) -> Days | None:
    """Summarise the days of a design; None for fewer than two days, or where all of them agree.

    Args:
        values: one for each replication, by its number; nan where it failed or is missing.
        goal: the target.
    """
    by_run = {run: float(value) for run, value in enumerate(values) if math.isfinite(value)}
    if len(by_run) < 2 or is_constant(np.asarray([*by_run.values()])):  # noqa: PLR2004 - the mean says it all
        return None
    order = sorted(by_run, key=lambda run: (goal.sign * by_run[run], run))
    worst, middle = order[0], order[(len(order) - 1) // 2]
    missed = sum(not goal.met_by(value) for value in by_run.values())
    return Days(len(by_run), by_run[worst], missed, by_run[middle], worst, middle)


def first_look(goal: Target, cap: int) -> int:
    """Return the default replications at the first look at a design; more for an unbounded, maybe skewed indicator."""
    return min(FIRST if goal.measure.is_share else FIRST_OF_MEANS, cap)


def is_cycle_time(goal: Target) -> bool:
    """Whether a target is about the time of a task, or of an order, from its release until it is done."""
    return "cycle_time_" in goal.indicator and goal.measure.unit == "time"


def too_short(text: str, model: Model) -> str:
    """Return the problem of a target for cycle times below the shortest handling of a task; else an empty text.

    Raises:
        StudyError: no target, or one of a flow or part of the day that the model has not.
    """
    goal, units = read_target(text, model.units.names), model.units
    refuse_unknown(goal.indicator, [model])
    least = handling_of(model, model.floor).means().least
    _, mark, flow = split(goal.indicator)
    handled = min(map(least, [flow] if mark == ":" else model.tasks.flows or [""]))
    if not is_cycle_time(goal) or goal.sign > 0 or goal.value >= handled:
        return ""
    times = ((name, float(SECONDS[name]) / units.seconds) for name in ("min", "h"))
    meant = next((f"; did you mean {goal.value:g} {name}?" for name, size in times if goal.value * size > handled), "")
    return (
        f"target {text!r}: {goal.value:g} {units.time}, and loading and unloading alone take {handled:g}, so no fleet "
        f"meets it{meant}"
    )


def _refuse_share(text: str, goal: Target) -> None:
    """Refuse a target of a share that lies outside 0 to 1, or below 1 % where per cent were forgotten."""
    if not goal.measure.is_share:
        return
    bare = not text.rstrip().endswith("%")
    if not 0 <= goal.value <= 1:
        meant = f"; did you mean {goal.value:g} %?" if bare and 1 < goal.value <= 100 else ""  # noqa: PLR2004
        raise StudyError(f"target {text!r}: {goal.indicator} is a share, expected a number from 0 to 1, or a %{meant}")
    if not bare and goal.sign > 0 and 0 < goal.value < 0.01:  # noqa: PLR2004
        share = f"{100 * goal.value:g} %"
        raise StudyError(f"target {text!r}: {share} is hardly a target; did you mean {10_000 * goal.value:g} %?")


def _right_way_round(text: str, goal: Target) -> None:
    """Refuse a target that is met by doing worse."""
    better = goal.measure.better
    if better is None or (better == "more") == (goal.sign > 0):
        return
    turned = goal.sense.translate(str.maketrans("<>", "><"))
    meant = text.replace("≤", "<=").replace("≥", ">=").replace(goal.sense, turned).strip()
    raise StudyError(
        f"target {text!r}: {better} {goal.indicator} is better, expected {turned}; did you mean {meant!r}?"
    )
