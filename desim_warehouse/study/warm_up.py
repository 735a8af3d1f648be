"""Warm-up of a lifelong model, for `desim warm-up`: deliveries and cycle times over time, truncated by MSER-5.

The warm-up of a design is the longer of the truncation points of throughput and cycle time, from five pilot runs in
1,000 equal spans. Of 60 M/M/1 queues with 3,000 tasks and load 0.8, which settle at once, 1 was then judged not to
settle; with 200 spans, 12. Rejected: one warm-up for all designs, the longest (it discards most where data are scarce),
and truncating each replication by itself (noisy, and biased towards calm starts). A design that does not settle is
counted from the middle on and named; an error would stop every study that asks how much demand is too much.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from desim_warehouse.errors import StudyError
from desim_warehouse.model import Model
from desim_warehouse.outcome.history import Spans, in_spans
from desim_warehouse.run import RunData
from desim_warehouse.study.design import Point
from desim_warehouse.study.execution import Executor
from desim_warehouse.study.execution.work import Outcome, Wanted
from desim_warehouse.study.plan import StudyPlan, run_seed
from desim_warehouse.study.statistics.warmup import TAIL, WarmUp, averaged, mser

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


PILOT = 5  # runs of each design
SPANS = 1000  # that a pilot run is divided into: with 200 MSER-5 often takes chance for not settled
Observed = Literal["throughput", "cycle_time"]


@dataclass(frozen=True, eq=False)
class Settling:
    """The time after which a model is in steady state (settled): the end of its warm-up.

    `time`: value for `run.warm_up`, in the model's time unit; None if the runs are too short. `width`: time between
    observations. `unit`: unit of the observations. `series`: observations over time, averaged over replications.
    """

    time: float | None
    width: float
    observed: str
    unit: str
    time_unit: str
    result: WarmUp
    series: NDArray[np.float64]

    def figure(self) -> Figure:
        """Draw batch means over time, the cut, and below them the statistic whose minimum it is."""
        from matplotlib.figure import Figure

        drawn = Figure(figsize=(7.5, 5.5), layout="constrained")
        above, below = drawn.subplots(2, 1, sharex=True)
        times = (self.result.positions + self.result.batch) * self.width
        above.plot(times, self.result.means, color="#1f5fa8")
        above.set_ylabel(self.unit)
        above.set_title(f"{self.observed.replace('_', ' ')}, means of {self.result.batch} observations", fontsize=10)
        below.plot(self.result.positions * self.width, self.result.statistic, color="#555555")
        below.set_ylabel("MSER-5")
        below.set_xlabel(f"Time ({self.time_unit})")
        top = self.result.statistic[: max(1, len(self.result.statistic) - TAIL)].max()
        below.set_ylim(0, 1.05 * float(top) or 1)
        for axes in (above, below):
            axes.axvline(self.result.truncate * self.width, color="#c9463d", linestyle="--")
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
        model: with `run.length`. Its `run.warm_up` is ignored.
        replications: runs that are averaged.
        observations: equal intervals that a run is divided into.
        observed: deliveries per hour in each interval, or the mean cycle time of those delivered in it.
        seed: of the study.

    Raises:
        StudyError: where the work of the model ends, so that it has no steady state.

    Source: MSER-5, see `mser`.
    """
    length = steady_length(model)
    whole = model.replace({"log": "tasks", "run.warm_up": 0})
    spans = [
        in_spans(RunData.simulated(whole, run_seed(seed, replication)).history.done, 0.0, length, observations)
        for replication in range(replications)
    ]
    return _settling(model, spans, observed)


def settle_designs(
    plan: StudyPlan, designs: Sequence[Point], executor: Executor, done: Callable[[Outcome], None]
) -> tuple[tuple[float, ...], list[str]]:
    """Find the warm-up of each design from five pilot runs, with remarks on designs that finished none.

    It is the longer of the warm-ups by throughput and by cycle time. A design that has not settled by the middle of its
    runs is counted from there on, and a design without a finished pilot run as its model says.

    Args:
        plan: of the study. Run seeds are those of its first replications.
        designs: its points.
        executor: simulates the pilot runs.
        done: told of each pilot run that is finished.

    Source: as `settle`; five replications as Hoad, Robinson & Davies (2010), Automating warm-up length estimation,
    J. Operational Research Society 61(9), 1389-1403.
    """
    wanted = [
        Wanted(point.number, {**point.overrides, "log": "tasks", "run.warm_up": 0}, run_seed(plan.seed, r), SPANS)
        for point in designs
        for r in range(PILOT)
    ]
    handles = [executor.submit(plan.base, run) for run in wanted]
    for handle in executor.ended(handles):
        assert handle.outcome is not None  # nobody cancels it
        done(handle.outcome)
    times, remarks = [], []
    for number, point in enumerate(designs):
        model = plan.base.replace(point.overrides)
        pilots = [handle.outcome for handle in handles[number * PILOT : (number + 1) * PILOT] if handle.outcome]
        spans = [pilot.spans for pilot in pilots if pilot.spans is not None]
        if not spans:
            times.append(model.run.warm_up)
            remarks.append(f"{point}: no pilot run was finished ({pilots[0].error}), so run.warm_up is as in the model")
            continue
        settlings = [_settling(model, spans, observed) for observed in get_args(Observed)]
        if all(settling.time is not None for settling in settlings):
            times.append(max(settling.time for settling in settlings if settling.time is not None))
        else:
            times.append(steady_length(model) / 2)
    return tuple(times), remarks


def steady_length(model: Model) -> float:
    """Return the length of the runs of a model that has a steady state.

    Raises:
        StudyError: where its work ends.
    """
    length = model.run.length
    if length is None or not (model.tasks.never_end or hasattr(model.tasks.goods, "random")):
        raise StudyError(
            f"{model.name}: its work ends, so it has no steady state and needs no warm-up; lifelong demand such as "
            "tasks.goods {saturated: 20} or {poisson: 200} with run.length has"
        )
    return length


def _settling(model: Model, spans: Sequence[Spans], observed: Observed) -> Settling:
    """Find where the warm-up ends, by deliveries in equal spans of several runs."""
    width = steady_length(model) / len(spans[0][0])
    if observed == "throughput":
        hours = width / model.units.hour
        series = [[count / hours for count in counts] for counts, _ in spans]
    else:
        series = [_filled(counts, times) for counts, times in spans]
    cut = mser(series)
    unit = "tasks per hour" if observed == "throughput" else model.units.time
    time = cut.truncate * width if cut.valid else None
    return Settling(time, width, observed, unit, model.units.time, cut, averaged(series))


def _filled(counts: Sequence[int], times: Sequence[float]) -> list[float]:
    """Return mean cycle times by interval; an interval without a delivery takes the mean of the interval before."""
    filled: list[float] = []
    for count, time in zip(counts, times, strict=True):
        filled.append(time / count if count else filled[-1] if filled else 0.0)
    return filled
