"""Does a real day refute a model? It is ranked among simulated days, all measures and all days at once.

Each real figure is set beside those of n simulated days, measured by the same code. How far it lies out is counted in
standard deviations of these. What decides is the largest such distance of all measures, of single days and of all days
together, and its rank among the same largest distance of simulated days that take the place of the real ones. So many
figures do not make a refutation more likely, nor do skewed ones: a right model is refuted at most at the stated level.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import ReportError, SimulationError, number_of
from desim_warehouse.fleet_log import read_logs
from desim_warehouse.fleet_log.demand import as_they_are
from desim_warehouse.fleet_log.measures import MEASURES, measured
from desim_warehouse.fleet_log.runs import from_run
from desim_warehouse.model import load
from desim_warehouse.run import simulate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from desim_warehouse.fleet_log.table import FleetLog
    from desim_warehouse.model import Model

    Floats = NDArray[np.float64]

LEVEL = 0.05
RUNS = 40
"""Simulated days for each real one: 39 is the least that can refute at the level."""
_POWER = 0.84
"""Standard normal quantile of 80 %, the chance with which an error should be seen."""
_ERROR = 0.1
_MOST = 1000
_TOLD = ("trip_mean", "approach_mean", "drops_per_hour")
"""Measures of which the power is said."""
_EDGES = 3


@dataclass(frozen=True)
class Validation:
    """What real days say of a model.

    Attributes:
        names: of the measures that the logs have.
        real: a row for each day, a column for each measure.
        simulated: for each day a table, a row for each simulated day.
        p_value: the share of simulated days that lie out as far as the real ones.
        bound: standard deviations beyond which a figure lies out, all of them taken together.
        off: for each measure how far it lies out: the most of single days and of all days together.
        edges: those where robots stood longer than simulated, the worst first: real and simulated, time an hour.
    """

    names: tuple[str, ...]
    real: Floats
    simulated: Floats
    p_value: float
    bound: float
    off: dict[str, float]
    edges: dict[str, tuple[float, float]]

    @property
    def refuted(self) -> bool:
        """Whether the real days are unlike the simulated ones."""
        return self.p_value <= LEVEL

    @property
    def outside(self) -> list[str]:
        """Measures outside the simultaneous band, the farthest first."""
        out = [name for name in self.names if abs(self.off[name]) > self.bound]
        return sorted(out, key=lambda name: -abs(self.off[name]))

    def days_for(self, name: str, error: float = _ERROR) -> int | None:
        """How many days would show an error of this share in a measure, with a chance of 80 %; None: over 1,000."""
        values = self.simulated[:, :, self.names.index(name)]
        mean, spread = abs(float(values.mean())), float(values.std(axis=1, ddof=1).mean())
        days = math.ceil(((self.bound + _POWER) * spread / (error * mean)) ** 2) if mean else _MOST + 1
        return max(days, 1) if days <= _MOST else None

    def lines(self) -> list[str]:
        """The verdict in words, with its power, and what to look at."""
        days = len(self.real)
        what = f"{number_of(days, 'day')}, {self.simulated.shape[1]} simulated for each, p = {self.p_value:.2g}"
        found = [f"not refuted ({what})"]
        if self.refuted:
            by = ", ".join(self.outside) or "all measures together"
            found = [f"refuted by {by} ({what})"]
            found += [f"look at {name}: {MEASURES[name].look_at}" for name in self.outside[:_EDGES]]
            if self.edges:
                worst = ", ".join(f"{edge} ({real:.3g} for {sim:.3g})" for edge, (real, sim) in self.edges.items())
                found.append(f"robots stood longest beyond what is simulated on {worst}, each in an hour")
        needed = {name: self.days_for(name) for name in _TOLD if name in self.names}
        said = [f"{name} with {n or 'over 1,000'} day{'s' * (n != 1)}" for name, n in needed.items()]
        if said:
            found.append(f"power: a {100 * _ERROR:g} % error would be seen in {', '.join(said)} (chance 80 %)")
        return found


def validate(
    model: str | Path | Model,
    logs: Sequence[str | Path | FleetLog],
    *,
    orders: Sequence[str | Path] = (),
    runs: int = RUNS,
) -> Validation:
    """Hold a model against real days: simulate each of them and see whether it is like the others.

    Args:
        model: a model, or its file.
        logs: a day each, as for `calibrate`.
        orders: the orders of each day, one file for each log; none: those of the model.
        runs: how often each day is simulated, at least 39.

    Raises:
        ReportError: fewer runs, not as many files of orders as logs, or logs that cannot be read.
        SimulationError: a model that cannot simulate a day.
    """
    if runs < math.ceil(2 / LEVEL) - 1:
        raise ReportError(f"{runs} runs can refute nothing, expected at least {math.ceil(2 / LEVEL) - 1}")
    if orders and len(orders) != len(logs):
        raise ReportError(f"{len(orders)} files of orders for {len(logs)} logs, expected one for each")
    base = load(model) if isinstance(model, str | Path) else model
    read = read_logs(logs)
    real, simulated, stood = [], [], []
    for day, log in enumerate(read):
        changed = base.replace(as_they_are(base, Path(orders[day])) if orders else {})
        found, at = measured(changed, log)
        days = [_simulated(changed, log, day * runs + run) for run in range(runs)]
        real.append([found[name] for name in MEASURES])
        simulated.append([[one[name] for name in MEASURES] for one, _ in days])
        stood.append((at, [edges for _, edges in days]))
    everything, there = np.array(simulated), np.array(real)
    known = np.isfinite(there).all(axis=0) & np.isfinite(everything).all(axis=(0, 1))
    known &= (everything.std(axis=1).min(axis=0) > 0) | (there != everything[:, 0]).any(axis=0)
    names = tuple(name for name, is_known in zip(MEASURES, known, strict=True) if is_known)
    if not names:
        raise ReportError("no measure that all logs and all simulated days have")
    p_value, bound, off = _judged(there[:, known], everything[:, :, known])
    return Validation(
        names, there[:, known], everything[:, :, known], p_value, bound,
        dict(zip(names, off.tolist(), strict=True)), _stood_longer(stood),
    )  # fmt: skip


def _simulated(model: Model, log: FleetLog, seed: int) -> tuple[dict[str, float], dict[str, float]]:
    """A simulated day as long as the real one, with messages as far apart, measured as that is."""
    seconds = model.units.seconds
    changes: dict[str, Any] = {"run.length": max(log.length / seconds, 1.0), "log": "all"}
    day = model.replace(changes)
    try:
        reported = from_run(simulate(day, seed), log.step or 1.0)
    except SimulationError as error:
        raise SimulationError(f"seed {seed}: the model cannot simulate {log.name}: {error}") from error
    return measured(day, reported)


def _judged(real: Floats, simulated: Floats) -> tuple[float, float, Floats]:
    """The p-value of the real days, the bound of the simultaneous band, and how far each measure lies out."""
    days, runs, _ = simulated.shape
    pooled = np.concatenate([real[:, None, :], simulated], axis=1)  # so the real day and a simulated one are alike
    spread = pooled.std(axis=1, ddof=1, keepdims=True)
    z = np.divide(pooled - pooled.mean(axis=1, keepdims=True), spread, out=np.zeros_like(pooled), where=spread > 0)
    together = z.sum(axis=0, keepdims=True) / math.sqrt(days)
    far = np.concatenate([z, together]) if days > 1 else z
    largest = np.abs(far).max(axis=(0, 2))
    p_value = float((largest >= largest[0]).mean())
    bound = float(np.sort(largest[1:])[math.ceil((1 - LEVEL) * (runs + 1)) - 1])
    ours = far[:, 0, :]
    off = np.take_along_axis(ours, np.abs(ours).argmax(axis=0)[None], axis=0)[0]
    return p_value, bound, off


def _stood_longer(stood: list[tuple[dict[str, float], list[dict[str, float]]]]) -> dict[str, tuple[float, float]]:
    """Edges on which robots stood longer in the real days than in any simulated one, by the difference."""
    found = {}
    for edge in stood[0][0]:
        real = float(np.mean([at[edge] for at, _ in stood]))
        days = np.array([[one[edge] for one in days] for _, days in stood]).mean(axis=0)
        if real > days.max():
            found[edge] = real, float(days.mean())
    worst = sorted(found, key=lambda edge: found[edge][1] - found[edge][0])[:_EDGES]
    return {edge: found[edge] for edge in worst}
