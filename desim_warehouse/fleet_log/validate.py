"""Validation: whether a real day refutes a model, its figures ranked among figures of simulated days.

All days are measured by one code. For `desim validate`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from desim_warehouse.answer import words
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.text import WIDTH, printed_table
from desim_warehouse.errors import ReportError, SimulationError, first_of, number_of, shown, spoken
from desim_warehouse.fleet_log import read_logs
from desim_warehouse.fleet_log.demand import as_they_are
from desim_warehouse.fleet_log.measures import MEASURES, MeasuredDay, measured, parts_of
from desim_warehouse.fleet_log.ranks import LEVEL, Ranked, ranked
from desim_warehouse.fleet_log.runs import from_run
from desim_warehouse.fleet_log.table import DROP, PICK, FleetLog
from desim_warehouse.model import Model, Source, as_model
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.run import RunData
from desim_warehouse.study.statistics.limits import MOST_REPLICATIONS
from desim_warehouse.values.arguments import each, is_finite, is_whole
from desim_warehouse.values.arrays import Floats
from desim_warehouse.values.dates import Slashes

if TYPE_CHECKING:
    import pandas as pd

RUNS = 40
"""Simulated days for each real one: 39 is the least that can refute at the level."""
_POWER = 0.84
"""Standard normal quantile of 80 %, the chance with which an error should be seen."""
_ERROR = 0.1
_MOST = 1000
_TOLD = ("trip_mean", "approach_mean", "drops_per_hour")
"""Measures of which the power is said."""
_EDGES = 3
_LOOKED_AT = 3
_ORDERS = "drops_per_hour"
"""With other orders every share of time differs, so that nothing else is looked at before."""
HEAD = ("Measure", "Real", "Simulated", "Band", "Verdict")
"""Head of the measures as they are shown."""
_VISITS = 20
"""Messages on picks and drops for each station, from which on one without any is not in use."""


class MeasureRow(NamedTuple):
    """A measure, as the mean of all days: real, simulated, its band, and its largest deviation (SD)."""

    name: str
    real: float
    simulated: float
    low: float
    high: float
    off: float
    outside: bool

    @property
    def verdict(self) -> str:
        """Words for a measure inside or outside its band, and its distance from the mean in standard deviations."""
        off = round(self.off, 1) or 0.0  # no −0.0
        return f"{'OUTSIDE' if self.outside else 'inside'} ({off:+.1f})".replace("-", "−")


@dataclass(frozen=True, repr=False)
class Validation:
    """The test of a model against real days: the result of `validate`; `print` shows it as `desim validate` does.

    Attributes:
        model: the model that was tested.
        days: names of the logs.
        names: names of the measures that the logs provide.
        measures: the measures, which decide the verdict.
        parts: for each day, the instants between which drops are counted.
        drops: load units put down per hour in each part of each day.
        passed: number of passages of robots along each edge per hour; None: the logs are of trips.
        stood: time that robots stood on each edge per hour; None: the logs are of trips.
        unlike: in words, where the robots or stations of a log are not those of the model. Every share of time differs
            then, so nothing else is looked at.
    """

    model: Model
    days: tuple[str, ...]
    names: tuple[str, ...]
    measures: Ranked
    parts: tuple[Floats, ...]
    drops: tuple[Ranked, ...]
    passed: Ranked | None
    stood: Ranked | None
    unlike: tuple[str, ...] = ()

    @property
    def refuted(self) -> bool:
        """Whether the real days are unlike the simulated ones."""
        return self.measures.p_value <= LEVEL

    def rows(self) -> list[MeasureRow]:
        """Rows of the measures, each over all days together."""
        measures = self.measures
        columns = (
            measures.real.mean(axis=0),
            measures.simulated.mean(axis=(0, 1)),
            *measures.mean_band(),
            measures.off,
            measures.out,
        )
        return [
            MeasureRow(name, *values) for name, *values in zip(self.names, *(c.tolist() for c in columns), strict=True)
        ]

    @property
    def table(self) -> pd.DataFrame:
        """A row for each measure, in the units of the model: see `MeasureRow`."""
        import pandas as pd

        return pd.DataFrame(self.rows(), columns=list(MeasureRow._fields))

    def cells(self) -> list[tuple[str, ...]]:
        """Return the rows of the measures as they are shown below `HEAD`, the largest distances first."""
        shown_rows: list[tuple[str, ...]] = []
        for row in sorted(self.rows(), key=lambda row: -abs(row.off)):
            meaning, _, kind = MEASURES[row.name]
            scale = words.scale_of_kind(kind, self.model, (row.real, row.simulated))
            name = words.with_unit(capital(meaning), "" if scale.is_share else scale.unit)
            high = min(row.high, 1.0) if scale.is_share else row.high
            band = f"{scale.bare(row.low)} to {scale.single(high)}"
            shown_rows.append((name, scale.single(row.real), scale.single(row.simulated), band, row.verdict))
        return shown_rows

    @property
    def outside(self) -> list[str]:
        """The measures outside the simultaneous band, the farthest first."""
        return [row.name for row in sorted(self.rows(), key=lambda row: -abs(row.off)) if row.outside]

    def stood_longer(self) -> dict[str, tuple[float, float]]:
        """Return edges on which robots stood longer than simulated ones, the worst first: real and simulated time."""
        if self.stood is None:
            return {}
        real, simulated = self.stood.real.mean(axis=0), self.stood.simulated.mean(axis=(0, 1))
        edges = list(self.model.floor.graph.edges)
        longer = np.flatnonzero(self.stood.out & (real > simulated))
        worst = sorted(longer, key=lambda edge: simulated[edge] - real[edge])[:_EDGES]
        return {">".join(edges[edge]): (float(real[edge]), float(simulated[edge])) for edge in worst}

    def days_for(self, name: str, error: float = _ERROR) -> int | None:
        """Return the number of days needed to detect an error of this share in a measure with a power of 80 %.

        None: over 1,000.

        Raises:
            ReportError: an error that is not above 0.
        """
        if not (is_finite(error) and error > 0):
            raise ReportError(f"error {shown(error):.60}: expected a share above 0, such as 0.1")
        values = self.measures.simulated[:, :, self.names.index(name)]
        mean, spread = abs(float(values.mean())), float(values.std(axis=1, ddof=1).mean())
        days = math.ceil(((self.measures.bound + _POWER) * spread / (error * mean)) ** 2) if mean else _MOST + 1
        return max(days, 1) if days <= _MOST else None

    def lines(self) -> list[str]:
        """Return the verdict, its power, and measures to look at, as lines."""
        called = {name: MEASURES[name].meaning for name in self.names}
        days, runs, _ = self.measures.simulated.shape
        what = f"{number_of(days, 'day')}, {runs} simulated for each, p = {self.measures.p_value:.2g}"
        lines = [f"not refuted ({what})"]
        if self.refuted:
            by = first_of([called[name] for name in self.outside], _LOOKED_AT) or "all measures together"
            lines = [f"refuted by {by} ({what})"]
            if self.unlike:
                return [*lines, *(f"first of all: {text}" for text in self.unlike)]
            looked_at = [_ORDERS] if _ORDERS in self.outside else self.outside[:_LOOKED_AT]
            lines += [f"look at {called[name]}: {MEASURES[name].look_at}" for name in looked_at]
            edges = self.stood_longer()
            if edges:
                unit = self.model.units.time
                stands = [
                    f"on {edge} {real:.3g} {unit} an hour, simulated {sim:.3g}" for edge, (real, sim) in edges.items()
                ]
                lines.append(f"robots stood {'; '.join(stands)}")
        needed = {name: self.days_for(name) for name in _TOLD if name in self.names}
        needs = [f"{n or 'over 1,000'} day{'s' * (n != 1)} for {called[name]}" for name, n in needed.items()]
        if needs:
            lines.append(f"to notice a {100 * _ERROR:g} % error, with a chance of 80 %, takes {spoken(needs)}")
        return lines

    def text(self, width: int = WIDTH) -> str:
        """Return the verdict and the measures as text, `width` characters wide."""
        return printed_table("\n".join(self.lines()), HEAD, self.cells(), width)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"Validation({self.model.name}: {self.lines()[0]})"


def validate(
    model: Source,
    logs: str | Path | FleetLog | Sequence[str | Path | FleetLog],
    *,
    orders: str | Path | Sequence[str | Path] = (),
    runs: int = RUNS,
    dates: Slashes | None = None,
) -> Validation:
    """Test a model against real days: simulate each day many times, and test whether the real day differs.

    Args:
        model: a model, or its file.
        logs: one, or one per day, as for `calibrate`.
        orders: the orders of each day, one file for each log; none: those of the model.
        runs: number of simulations of each day, at least 39.
        dates: how to read 03/02/2026 in trips: "us", March 2, or "uk", 3 February.

    Returns:
        The verdict, and how real and simulated days differ in each measure; see `Validation`.

    Raises:
        ReportError: fewer runs, not as many files of orders as logs, or logs that cannot be read.
        SimulationError: a model that cannot simulate a day.
    """
    least = math.ceil(2 / LEVEL) - 1
    if not is_whole(runs, least, MOST_REPLICATIONS):
        limits = f"from {least}, as fewer can refute nothing, to {MOST_REPLICATIONS:,}"
        raise ReportError(f"runs {shown(runs):.60}: expected {limits}")
    days, sheets = each(logs), each(orders)
    if sheets and len(sheets) != len(days):
        raise ReportError(f"{len(sheets)} files of orders for {len(days)} logs, expected one for each")
    base = as_model(model)
    read = read_logs(days, dates)
    parts, real, simulated = [], [], []
    for day, log in enumerate(read):
        changed = base.replace(as_they_are(base, Path(sheets[day])) if sheets else {})
        parts.append(parts_of(changed, log))
        real.append(measured(changed, log, parts[-1]))
        simulated.append([_simulated(changed, log, parts[-1], day * runs + run) for run in range(runs)])
    figures = np.array([[real_day.figures[name] for name in MEASURES] for real_day in real])
    everything = np.array(
        [[[simulated_day.figures[name] for name in MEASURES] for simulated_day in runs] for runs in simulated]
    )
    comparable = np.isfinite(figures).all(axis=0) & np.isfinite(everything).all(axis=(0, 1))
    comparable &= (everything.std(axis=1).min(axis=0) > 0) | (figures != everything[:, 0]).any(axis=0)
    if not comparable.any():
        raise ReportError("no measure that all logs and all simulated days have")
    return Validation(
        model=base,
        days=tuple(log.name for log in read),
        names=tuple(name for name, is_comparable in zip(MEASURES, comparable, strict=True) if is_comparable),
        measures=ranked(figures[:, comparable], everything[:, :, comparable]),
        parts=tuple(parts),
        drops=tuple(
            ranked(real_day.drops[None], np.array([[run.drops for run in runs]]))
            for real_day, runs in zip(real, simulated, strict=True)
        ),
        passed=_by_edge("passed", real, simulated),
        stood=_by_edge("stood", real, simulated),
        unlike=tuple(text for log in read for text in _unlike(base, log)),
    )


def _unlike(model: Model, log: FleetLog) -> list[str]:
    """Return words for robots and stations in which a log differs from the model; other nodes are not compared."""
    texts, layout = [], model.floor
    if len(log.robots) != model.fleet.size:
        texts.append(f"{log.name} has {number_of(len(log.robots), 'robot')}, the model {model.fleet.size} (fleet.size)")
    at_work = log.table[log.table["action"].isin((PICK, DROP)) & (log.table["node"] >= 0)]
    used = {log.nodes[number] for number in at_work["node"].unique()}
    stations = set(layout.stations)
    if not used <= set(layout.graph) or len(at_work) < _VISITS * len(stations):
        return texts
    asked = stations.intersection(destinations(model, layout))
    idle, other = sorted(asked - used), sorted((used & stations) - asked)
    if idle:
        texts.append(f"in {log.name} no load is handled at {first_of(idle, _LOOKED_AT)}, where the model has some")
    if other:
        texts.append(f"in {log.name} loads are handled at {first_of(other, _LOOKED_AT)}, where the model has none")
    return texts


def _by_edge(what: str, real: list[MeasuredDay], simulated: list[list[MeasuredDay]]) -> Ranked | None:
    """Rank a measure of every edge; None where one of the logs is of trips."""
    days = [getattr(measured_day, what) for measured_day in real]
    if not all(day.size for day in days):
        return None
    return ranked(
        np.array(days),
        np.array([[getattr(measured_day, what) for measured_day in runs] for runs in simulated]),
        alike=True,
    )


def _simulated(model: Model, log: FleetLog, parts: Floats, seed: int) -> MeasuredDay:
    """Simulate a day as long as the real day, with messages at the same step, and measure it likewise."""
    seconds = model.units.seconds
    changes: dict[str, Any] = {"run.length": max(log.length / seconds, 1.0), "log": "all"}
    day = model.replace(changes)
    try:
        reported = from_run(RunData.simulated(day, seed), log.step or 1.0)
    except SimulationError as error:
        raise SimulationError(f"seed {seed}: the model cannot simulate {log.name}: {error}") from error
    return measured(day, reported, parts)
