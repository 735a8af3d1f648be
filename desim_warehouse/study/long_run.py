"""What one long run says about the steady state: its indicators of tasks, each with an interval of its own."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.outcome.indicators import find, within
from desim_warehouse.study import statistics
from desim_warehouse.study.warm_up import steady_length

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.outcome.history import History
    from desim_warehouse.outcome.records import TaskHistory
    from desim_warehouse.run import Run

QUANTILES = {"cycle_time_median": 0.5, "cycle_time_p95": 0.95}
INDICATORS = ("throughput_per_hour", "cycle_time_mean", *QUANTILES, "tardiness_mean", "on_time")
"""Indicators of the tasks in turn of their delivery."""


def long_run(
    run: Run, indicators: Sequence[str] | None = None, confidence: float = 0.95
) -> dict[str, statistics.OneRun]:
    """Indicators of one run with intervals, from batches of its deliveries in order of time.

    Args:
        run: with lifelong demand, long after its warm-up; `log: tasks` is enough.
        indicators: of `INDICATORS`, also of flows such as `cycle_time_p95:outbound` (default: all that the run has).
        confidence: of the intervals.

    Returns:
        For each indicator its value and interval in its unit, and whether the run was long enough (`independent`).

    Raises:
        StudyError: the work of the model ends, an indicator that is not of this kind or that the run does not have,
            or fewer than 100 deliveries after the warm-up.

    Source: `statistics.batch_means`, `statistics.quantile_in_run`.
    """
    steady_length(run.model)
    chosen = [name for name in INDICATORS if name in run.kpis] if indicators is None else list(indicators)
    return {name: _of(run, name, confidence) for name in chosen}


def _of(run: Run, name: str, confidence: float) -> statistics.OneRun:
    """One indicator of a run."""
    find(name)
    base, _, flow = name.partition(":")
    if base not in INDICATORS or name not in run.kpis:
        has = [one for one in run.kpis if one.partition(":")[0] in INDICATORS]
        raise StudyError(f"indicator {name!r}: not one that batches of a run tell, expected one of {', '.join(has)}")
    history = run.history
    of = history.of_flow(flow) if flow else history
    times = [task.cycle_time for task in of.counted_done]
    if base in QUANTILES:
        return statistics.quantile_in_run(times, QUANTILES[base], confidence)
    if base == "throughput_per_hour":
        rates = statistics.batch_means(_rates(history, of.counted_deliveries), confidence, within=within(name))
        return replace(rates, worth=math.inf)  # of a hundredth of the run each: no single observations to be counted
    if base == "cycle_time_mean":
        observed = times
    else:
        late = base == "tardiness_mean"
        observed = [one.overrun(history.end) if late else float(not one.missed) for one in of.deadlines]
    return statistics.batch_means(observed, confidence, within=within(name))


def _rates(history: History, tasks: Sequence[TaskHistory]) -> list[float]:
    """Deliveries per hour in each hundredth of the counted time."""
    times = [task.delivered for task in tasks]
    counts, _ = np.histogram(times, statistics.SMALL_BATCHES, (history.begin, history.end))
    hours = history.counted / len(counts) / history.model.units.hour
    return [float(count) / hours for count in counts]
