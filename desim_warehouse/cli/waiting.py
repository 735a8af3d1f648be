"""Progress of a command: a line on a terminal after two seconds, and nothing elsewhere."""

from __future__ import annotations

import sys
import threading
from time import monotonic
from typing import TYPE_CHECKING, Self, TextIO

from desim_warehouse.answer import numbers
from desim_warehouse.cli.terminal import is_terminal
from desim_warehouse.run.stop import StopSignal

if TYPE_CHECKING:
    from types import TracebackType

    from desim_warehouse.model import Model
    from desim_warehouse.world.traffic.events import Clock

PATIENCE, EVERY = 2.0, 0.5
"""Time until the line is shown, and between its updates, in seconds."""
_LEAST = 0.01
"""Least share of a run from which the remaining time is estimated."""
_CLEAR = "\r\x1b[K"


class Waiting(StopSignal):
    """A progress line of work under way, on a terminal only; as the stop signal of a run it follows the run's clock."""

    def __init__(
        self, what: str, model: Model | None = None, until: float | None = None, stream: TextIO | None = None
    ) -> None:
        """Prepare the line: `what` is under way, for a run of `model` up to `until`, if these are given.

        `stream`: the output, by default stderr.
        """
        super().__init__()
        self.what = what
        self.model = model
        self.end = until or (None if model is None or model.run.length is None else model.run.end)
        self.stream = stream or sys.stderr
        self.clock: Clock | None = None
        self._over = threading.Event()
        self._thread: threading.Thread | None = None
        self._begin = monotonic()

    def __enter__(self) -> Self:
        self._begin = monotonic()
        if is_terminal(self.stream):
            self._thread = threading.Thread(target=self._say, daemon=True)
            self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join()

    def obey(self, clock: Clock) -> None:
        """Follow the clock of a run that is about to begin; raise StoppedError if a stop is already requested."""
        self.clock = clock
        super().obey(clock)

    def line(self, lasted: float) -> str:
        """Follow the clock of a run that is about to begin; raise StoppedError if a stop is requested already."""
        so_far = f"{numbers.duration(lasted, 's')} so far"
        if self.clock is None or self.model is None:
            return f"{self.what}: {so_far}"
        unit, now = self.model.units.time, self.clock.now
        if not self.end:
            return f"{self.what}: {numbers.duration(now, unit)} of the run, {so_far}"
        part = min(now / self.end, 1.0)
        left = f", {numbers.duration(lasted * (1 - part) / part, 's')} left" if part >= _LEAST else ""
        return f"{self.what}: {100 * part:.0f} % of {numbers.duration(self.end, unit)}, {so_far}{left}"

    def _say(self) -> None:
        if self._over.wait(PATIENCE):
            return
        while True:
            self.stream.write(f"{_CLEAR}{self.line(monotonic() - self._begin)}")
            self.stream.flush()
            if self._over.wait(EVERY):
                break
        self.stream.write(_CLEAR)
        self.stream.flush()
