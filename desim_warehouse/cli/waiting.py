"""What a command says while somebody waits: one line on a terminal, from two seconds on, and nothing elsewhere."""

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
"""Seconds until the line is shown, and between two states of it."""
_LEAST = 0.01
"""The part of a run from which on the time that is left is said."""
_CLEAR = "\r\x1b[K"


class Waiting(StopSignal):
    """A line about work under way, on a terminal only; as the signal of a run it knows how far the run is."""

    def __init__(
        self, what: str, model: Model | None = None, until: float | None = None, stream: TextIO | None = None
    ) -> None:
        """`what` goes on, for a run of `model` up to `until`, where that is known; `stream`: default stderr."""
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
        """Follow the clock of a run that is about to begin; raises StoppedError where it is to be stopped already."""
        self.clock = clock
        super().obey(clock)

    def line(self, lasted: float) -> str:
        """What is known after so many seconds: the part of the run, and the time left where that can be told."""
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
