"""How long a lifelong model takes to settle: deliveries and cycle times over time, and where MSER-5 cuts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from desim_warehouse.errors import StudyError
from desim_warehouse.run import simulate
from desim_warehouse.study import statistics
from desim_warehouse.study.plan import run_seed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from desim_warehouse.history import History
    from desim_warehouse.model import Model

Observed = Literal["throughput", "cycle_time"]


@dataclass(frozen=True)
class Settling:
    """When a model has settled.

    `time`: for `run.warm_up`, in the model's time unit, None if the runs are too short to tell. `width`: time
    between observations. `unit`: what was observed.
    """

    time: float | None
    width: float
    observed: str
    unit: str
    time_unit: str
    found: statistics.WarmUp

    def figure(self) -> Figure:
        """Batch means over time, the cut, and below them the statistic whose minimum it is."""
        from matplotlib.figure import Figure

        drawn = Figure(figsize=(7.5, 5.5), layout="constrained")
        above, below = drawn.subplots(2, 1, sharex=True)
        times = (self.found.positions + self.found.batch) * self.width
        above.plot(times, self.found.means, color="#1f5fa8")
        above.set_ylabel(self.unit)
        above.set_title(f"{self.observed.replace('_', ' ')}, means of {self.found.batch} observations", fontsize=10)
        below.plot(self.found.positions * self.width, self.found.statistic, color="#555555")
        below.set_ylabel("MSER-5")
        below.set_xlabel(f"Time ({self.time_unit})")
        top = self.found.statistic[: max(1, len(self.found.statistic) - statistics.warmup.TAIL)].max()
        below.set_ylim(0, 1.05 * float(top) or 1)
        for axes in (above, below):
            axes.axvline(self.found.truncate * self.width, color="#c9463d", linestyle="--")
            axes.spines[["top", "right"]].set_visible(False)
        return drawn


def settle(
    model: Model,
    *,
    replications: int = 10,
    observations: int = 200,
    observed: Observed = "throughput",
    seed: int = 0,
) -> Settling:
    """Find the warm-up of a lifelong model from runs over its whole length, averaged over replications.

    Args:
        model: with `run.length`; its `run.warm_up` is ignored.
        replications: runs that are averaged.
        observations: equal intervals that a run is divided into.
        observed: deliveries per hour in each interval, or the mean cycle time of those delivered in it.
        seed: of the study.

    Raises:
        StudyError: where the work of the model ends, so that it has no steady state.

    Source: MSER-5, see `statistics.mser`.
    """
    length = model.run.length
    if length is None or not (model.tasks.never_end or hasattr(model.tasks.goods, "random")):
        raise StudyError(
            f"{model.name}: its work ends, so it has no steady state and needs no warm-up; lifelong demand such as "
            "tasks.goods {saturated: 20} or {poisson: 200} with run.length has"
        )
    width = length / observations
    whole = model.replace({"log": "tasks", "run.warm_up": 0})
    hours = width / model.units.hour
    series = []
    for replication in range(replications):
        history = simulate(whole, run_seed(seed, replication)).history
        counts, times = _spans(history, width, observations)
        if observed == "throughput":
            series.append([count / hours for count in counts])
        else:
            series.append(_filled(counts, times))
    found = statistics.mser(series)
    unit = "tasks per hour" if observed == "throughput" else model.units.time
    time = found.truncate * width if found.valid else None
    return Settling(time, width, observed, unit, model.units.time, found)


def _spans(history: History, width: float, many: int) -> tuple[list[int], list[float]]:
    """Deliveries and the sum of their cycle times in each interval."""
    counts, times = [0] * many, [0.0] * many
    for task in history.delivered:
        span = min(int(task.delivered / width), many - 1)
        counts[span] += 1
        times[span] += task.cycle_time
    return counts, times


def _filled(counts: list[int], times: list[float]) -> list[float]:
    """Mean cycle times; an interval without a delivery has that of the one before."""
    filled: list[float] = []
    for count, time in zip(counts, times, strict=True):
        filled.append(time / count if count else filled[-1] if filled else 0.0)
    return filled
