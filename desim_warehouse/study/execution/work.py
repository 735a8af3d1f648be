"""What a worker does: simulate a few runs and say what came out of each."""

from __future__ import annotations

import ctypes
import threading
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from desim_warehouse.errors import LayoutError, SimulationError
from desim_warehouse.run import simulate

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from types import TracebackType

    from desim_warehouse.model import Model

TIME_OUT = "time-out"
_KEPT = 64  # models at hand
_AGAIN = 1.0  # seconds until a run that swallowed its interruption is interrupted again


class Wanted(NamedTuple):
    """A run to simulate: the changes that its design makes to the base model, and its seed."""

    design: int
    overrides: Mapping[str, Any]
    seed: int


class Outcome(NamedTuple):
    """What came out of a run: indicators, or an error.

    `final` is False for an error that may not happen again (a time-out, a worker that died).
    """

    values: dict[str, float]
    run_time: float
    error: str | None = None
    final: bool = True


class TimeOutError(BaseException):
    """A run took too long; no `except Exception` of a policy can swallow it."""


class Limit:
    """Interrupts what its thread does within it after so many seconds; does nothing for None.

    Works in any thread and on every system, as a Dask worker needs; code that does not come back to Python is
    interrupted only when it does.
    """

    def __init__(self, seconds: float | None) -> None:
        self.seconds = seconds
        self.thread = threading.get_ident()
        self.lock = threading.Lock()
        self.over = threading.Event()

    def __enter__(self) -> Self:
        if self.seconds is not None:
            threading.Thread(target=self.watch, daemon=True).start()
        return self

    def watch(self) -> None:
        """Wait, and strike until the thread has left."""
        wait = self.seconds
        while not self.over.wait(wait):
            with self.lock:
                if not self.over.is_set():
                    self.strike(ctypes.py_object(TimeOutError))
            wait = _AGAIN

    def strike(self, what: ctypes.py_object[type[BaseException]] | None) -> None:
        """Raise this in the thread, or take back what was raised and has not arrived."""
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self.thread), what)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.seconds is not None:
            with self.lock:
                self.over.set()
                self.strike(None)  # take back what has not arrived yet


class Bench:
    """A base model with the models of designs made from it: the last few are kept."""

    def __init__(self, base: Model) -> None:
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
                values = simulate(model, wanted.seed).kpis
            else:
                with Limit(timeout):
                    values = simulate(model, wanted.seed).kpis
        except TimeOutError:
            taken = _since(begin)
            return Outcome({}, taken, f"{TIME_OUT}: not finished after {timeout:g} s", final=False)
        except Exception as error:  # noqa: BLE001 - one failing run is a row with its error
            taken = _since(begin)
            said = " ".join(str(error).split()) or "no message"
            return Outcome(
                {},
                taken,
                f"{type(error).__name__}: {said}",
                final=isinstance(error, SimulationError | LayoutError),
            )
        return Outcome(values, _since(begin))

    def batch(self, batch: Sequence[Wanted], timeout: float | None = None) -> list[Outcome]:
        """Simulate several runs, one after the other."""
        return [self.run(wanted, timeout) for wanted in batch]


def _since(begin: float) -> float:
    """Seconds since then, to the microsecond."""
    return round(perf_counter() - begin, 6)
