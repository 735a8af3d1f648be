"""What one long run says about the steady state: its indicators of tasks, each with an interval of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.errors import StudyError
from desim_warehouse.history import deliveries, lateness
from desim_warehouse.indicators import find, within
from desim_warehouse.study import statistics
from desim_warehouse.study.warm_up import steady_length

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.history import History, TaskHistory
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
        indicators: of `INDICATORS`, also of flows (`cycle_time_p95:outbound`); default: all that the run has.
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
    tasks = [task for task in history.counted_deliveries if task.flow == flow or not flow]
    if base == "throughput_per_hour":
        return statistics.batch_means(_rates(history, tasks), confidence, within=within(name))
    if base in QUANTILES:
        return statistics.quantile_in_run([task.cycle_time for task in tasks], QUANTILES[base], confidence)
    return statistics.batch_means(_observed(base, tasks), confidence, within=within(name))


def _rates(history: History, tasks: Sequence[TaskHistory]) -> list[float]:
    """Deliveries per hour in each hundredth of the counted time."""
    counts, _ = deliveries(tasks, history.begin, history.end, statistics.SMALL_BATCHES)
    hours = history.counted / len(counts) / history.model.units.hour
    return [count / hours for count in counts]


def _observed(base: str, tasks: Sequence[TaskHistory]) -> list[float]:
    """What is known of each task, of those that were due where that counts."""
    if base == "cycle_time_mean":
        return [task.cycle_time for task in tasks]
    late = lateness(tasks)
    return late if base == "tardiness_mean" else [float(not one) for one in late]
