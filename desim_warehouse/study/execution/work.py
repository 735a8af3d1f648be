"""Simulation of the runs of a study, in any process; each run ends with an outcome, which may be an error.

For all executors (`study.execution`), and for the runs of `desim serve`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import nullcontext
from itertools import zip_longest
from queue import SimpleQueue
from time import monotonic, perf_counter
from typing import Any, NamedTuple

from desim_warehouse.errors import CheckError, SimulationError
from desim_warehouse.model import Model
from desim_warehouse.outcome.history import Spans, in_spans
from desim_warehouse.policies.asked import place_in
from desim_warehouse.run import RunData
from desim_warehouse.run.stop import StoppedError, StopSignal
from desim_warehouse.study.execution.own_indicators import OwnIndicator
from desim_warehouse.study.execution.signals import Interrupts
from desim_warehouse.study.execution.time_limit import TimeLimit, TimeOutError
from desim_warehouse.world.robots.settled import UNSETTLED, SettledFleets

ENOUGH = 1.0  # seconds after which a batch is returned as far as it has got
_KEPT = 64  # models kept
_SAID = 1000  # characters kept of an error
_ending = threading.Lock()


class Wanted(NamedTuple):
    """A run to simulate: the changes that its design makes to the base model, and its seed.

    `spans`: number of equal parts into which the run is divided to show how deliveries settle; 0: none. `floor`:
    whether to record the floor for a while. `scout`: whether this is a pilot run, before which batteries need not
    settle. `own`: user-defined indicators.
    """

    design: int
    overrides: Mapping[str, Any]
    seed: int
    spans: int = 0
    floor: bool = False
    scout: bool = False
    own: tuple[OwnIndicator, ...] = ()


class Outcome(NamedTuple):
    """The outcome of a run: indicators, or an error.

    `final` is False for an error that may not recur (a time-out, a worker that died). `deterministic`: no random stream
    and no user-defined policy was used. `spans`: on request, the number of tasks delivered in each part of the run and
    the sums of their cycle times. `floor`: on request, the recording that a page plays (`Run.floor`).
    """

    values: dict[str, float]
    run_time: float
    error: str | None = None
    final: bool = True
    deterministic: bool = False
    spans: Spans | None = None
    floor: Mapping[str, Any] | None = None


class Handle:
    """A submitted run, whose outcome is None until it has ended, and if it was cancelled.

    A handle may be used from any thread.
    """

    __slots__ = ("_queue", "_stop", "base", "cancelled", "outcome", "wanted")

    def __init__(self, base: Model, wanted: Wanted, stop: Callable[[Handle], None]) -> None:
        self.base = base
        self.wanted = wanted
        self.outcome: Outcome | None = None
        self.cancelled = False
        self._stop = stop
        self._queue: SimpleQueue[Handle] | None = None

    @property
    def ended(self) -> bool:
        """Whether the run has an outcome, or was cancelled."""
        return self.cancelled or self.outcome is not None

    def cancel(self) -> None:
        """Stop the run, or keep it from starting; do nothing if it has ended."""
        if self._end(None):
            self._stop(self)

    def end(self, outcome: Outcome) -> None:
        """Store the outcome; a cancelled run has none."""
        self._end(outcome)

    def tell(self, queue: SimpleQueue[Handle]) -> None:
        """Put the handle into a queue as soon as the run has ended."""
        with _ending:
            if not self.ended:
                self._queue = queue
                return
        queue.put(self)

    def _end(self, outcome: Outcome | None) -> bool:
        with _ending:
            if self.ended:
                return False
            self.outcome, self.cancelled = outcome, outcome is None
            queue, self._queue = self._queue, None
        if queue is not None:
            queue.put(self)
        return True


class _Design(NamedTuple):
    """A design of a base model, and its own model."""

    base: Model
    overrides: Mapping[str, Any]
    model: Model


class Simulator:
    """Simulates designs of base models, and keeps the last few models."""

    def __init__(self, fleets: SettledFleets) -> None:
        import networkx as nx  # noqa: F401 - here, so that the first run takes no longer than others
        import numpy.random  # noqa: F401 - the same

        import desim_warehouse.world  # noqa: F401 - the same

        self.fleets = fleets
        self.models: dict[tuple[int, int], _Design] = {}  # by base and design

    def model(self, base: Model, wanted: Wanted) -> Model:
        """Return the model of a wanted run."""
        name = id(base), wanted.design
        design = self.models.get(name)
        if design is not None and design.base is base and design.overrides == wanted.overrides:
            return design.model
        model = base.replace(wanted.overrides) if wanted.overrides else base
        if len(self.models) >= _KEPT:
            self.models.pop(next(iter(self.models)), None)
        self.models[name] = _Design(base, wanted.overrides, model)
        return model

    def run(self, base: Model, wanted: Wanted, timeout: float | None = None, stop: StopSignal | None = None) -> Outcome:
        """Simulate one run; errors become part of its outcome."""
        begin = perf_counter()
        try:
            model = self.model(base, wanted)
            if wanted.floor:
                model = model.replace({"log": "all"})
            begin = perf_counter()
            fleets = UNSETTLED if wanted.scout else self.fleets
            with nullcontext() if timeout is None else TimeLimit(timeout):
                run = RunData.simulated(model, wanted.seed, stop, fleets=fleets)
            own = {indicator.name: indicator.value(run) for indicator in wanted.own}
        except StoppedError:
            return Outcome({}, _since(begin), "cancelled", final=False)
        except TimeOutError as error:
            place = place_in(error, model.policies.own())
            return Outcome({}, _since(begin), f"time-out: not finished after {timeout:g} s{place}", final=False)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001 - one failing run, by sys.exit too, is a row with its error
            text = " ".join(str(error)[:_SAID].split()) or "no message"
            text = f"{type(error).__name__}: {text}".encode(errors="backslashreplace").decode()  # no lone surrogates
            return Outcome({}, _since(begin), text, final=isinstance(error, SimulationError | CheckError))
        spans = in_spans(run.history.done, 0.0, run.T, wanted.spans) if wanted.spans else None
        taken = _since(begin)
        return Outcome(
            {**run.kpis, **own} if own else run.kpis,
            taken,
            deterministic=run.deterministic,
            spans=spans,
            floor=run.floor() if wanted.floor and not (stop is not None and stop.asked) else None,
        )

    def batch(
        self,
        base: Model,
        batch: Sequence[Wanted],
        timeout: float | None = None,
        stops: Sequence[StopSignal] = (),
    ) -> list[Outcome]:
        """Simulate several runs one after the other, or fewer if they take longer than expected.

        `base`: base model of their designs. `stops`: a stop signal for each run.
        """
        outcomes = []
        end = monotonic() + ENOUGH
        for wanted, stop in zip_longest(batch, stops):
            outcomes.append(self.run(base, wanted, timeout, stop))
            if monotonic() > end:
                break
        return outcomes


class Serial:
    """The executor that simulates in this process, one run after the other."""

    def __init__(self, timeout: float | None, interrupts: Interrupts, fleets: SettledFleets) -> None:
        self.fleets = fleets
        self.timeout = timeout
        self.interrupts = interrupts
        self.simulator: Simulator | None = None
        self.stops: dict[Handle, StopSignal] = {}  # of runs that are simulated now

    def submit(self, base: Model, run: Wanted) -> Handle:
        """Submit a run, which is simulated as soon as `ended` waits for it."""
        return Handle(base, run, self.stop)

    def stop(self, handle: Handle) -> None:
        """Stop a run that was cancelled, if it is simulated now."""
        stop = self.stops.get(handle)
        if stop is not None:
            stop.ask()

    def ended(self, handles: Sequence[Handle]) -> Generator[Handle]:
        """Simulate these runs now, in this order, and yield each."""
        if self.simulator is None:
            with self.interrupts.held():
                self.simulator = Simulator(self.fleets)
            self.interrupts.heed()
        for handle in handles:
            stop = self.stops[handle] = StopSignal()
            try:
                if not handle.ended:
                    handle.end(self.simulator.run(handle.base, handle.wanted, self.timeout, stop))
            finally:
                del self.stops[handle]
            yield handle
            self.interrupts.heed()

    def close(self) -> None:
        """Do nothing: there are no processes to end."""


def _since(begin: float) -> float:
    """Return the seconds since a time, to the microsecond."""
    return round(perf_counter() - begin, 6)
