"""What a worker does: simulate a few runs and say what came out of each."""

from __future__ import annotations

import ctypes
import threading
from time import monotonic, perf_counter, sleep
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from desim_warehouse.errors import LayoutError, SimulationError
from desim_warehouse.run import simulate

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from types import TracebackType

    from desim_warehouse.model import Model

TIME_OUT = "time-out"
ENOUGH = 1.0  # seconds after which a batch is handed in as far as it is
_LOOK = 0.05  # seconds between looks at the limits
_KEPT = 64  # models at hand
_SAID = 1000  # characters of an error that are kept
_AGAIN = 1.0  # seconds until a run that swallowed its interruption is interrupted again


class Wanted(NamedTuple):
    """A run to simulate: the changes that its design makes to the base model, and its seed."""

    design: int
    overrides: Mapping[str, Any]
    seed: int


class Outcome(NamedTuple):
    """What came out of a run: indicators, or an error.

    `final` is False for an error that may not happen again (a time-out, a worker that died). `deterministic`: no
    random stream and no policy of the user's own was used.
    """

    values: dict[str, float]
    run_time: float
    error: str | None = None
    final: bool = True
    deterministic: bool = False


class TimeOutError(BaseException):
    """A run took too long; no `except Exception` of a policy can swallow it."""


class Limit:
    """Interrupts what its thread does within it after so many seconds.

    One thread of the process watches all of them, so that a limit costs microseconds. Works in any thread and on
    every system, as a Dask worker needs; code that does not come back to Python is interrupted when it does.
    """

    lock = threading.Lock()
    open: ClassVar[dict[Limit, float]] = {}  # with the time at which each is over
    watching = False

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.thread = threading.get_ident()
        self.struck = False

    def __enter__(self) -> Self:
        with Limit.lock:
            Limit.open[self] = monotonic() + self.seconds
            if not Limit.watching:
                Limit.watching = True
                threading.Thread(target=_watch, daemon=True).start()
        return self

    def strike(self, what: type[BaseException] | None) -> None:
        """Raise this in the thread, or (None) take back what was raised and has not arrived."""
        error = None if what is None else ctypes.py_object(what)
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self.thread), error)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with Limit.lock:
            Limit.open.pop(self, None)
            if self.struck:
                self.strike(None)


def _watch() -> None:
    """Interrupt what is over its limit, and again if that was swallowed; end when nothing has a limit."""
    idle = 0
    while True:
        sleep(_LOOK)
        with Limit.lock:
            now = monotonic()
            for limit, over in Limit.open.items():
                if now > over:
                    limit.struck = True
                    limit.strike(TimeOutError)
                    Limit.open[limit] = now + _AGAIN
            idle = 0 if Limit.open else idle + 1
            if idle * _LOOK > _AGAIN:
                Limit.watching = False
                return


class Bench:
    """A base model with the models of designs made from it: the last few are kept."""

    def __init__(self, base: Model) -> None:
        import numpy.random  # noqa: F401 - here, so that the first run takes no longer than others

        import desim_warehouse.world  # noqa: F401 - the same

        self.base = base
        self.models: dict[int, tuple[Mapping[str, Any], Model]] = {}

    def model(self, wanted: Wanted) -> Model:
        """The model of a wanted run."""
        known = self.models.get(wanted.design)
        if known is not None and known[0] == wanted.overrides:
            return known[1]
        model = self.base.replace(wanted.overrides) if wanted.overrides else self.base
        if len(self.models) >= _KEPT:
            self.models.pop(next(iter(self.models)), None)
        self.models[wanted.design] = (wanted.overrides, model)
        return model

    def run(self, wanted: Wanted, timeout: float | None = None) -> Outcome:
        """Simulate one run; whatever goes wrong in it is its outcome."""
        begin = perf_counter()
        try:
            model = self.model(wanted)
            begin = perf_counter()
            if timeout is None:
                run = simulate(model, wanted.seed)
            else:
                with Limit(timeout):
                    run = simulate(model, wanted.seed)
        except TimeOutError:
            taken = _since(begin)
            return Outcome({}, taken, f"{TIME_OUT}: not finished after {timeout:g} s", final=False)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001 - one failing run, by sys.exit too, is a row with its error
            taken = _since(begin)
            said = " ".join(str(error)[:_SAID].split()) or "no message"
            return Outcome(
                {},
                taken,
                f"{type(error).__name__}: {said}",
                final=isinstance(error, SimulationError | LayoutError),
            )
        return Outcome(run.kpis, _since(begin), deterministic=run.deterministic)

    def batch(self, batch: Sequence[Wanted], timeout: float | None = None) -> list[Outcome]:
        """Simulate several runs, one after the other; fewer where they take longer than was thought."""
        outcomes = []
        end = monotonic() + ENOUGH
        for wanted in batch:
            outcomes.append(self.run(wanted, timeout))
            if monotonic() > end:
                break
        return outcomes


def _since(begin: float) -> float:
    """Seconds since then, to the microsecond."""
    return round(perf_counter() - begin, 6)
