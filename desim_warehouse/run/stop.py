"""Ending a run from outside.

For Ctrl-C in `desim run`, and for runs of a study that are no longer needed.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from desim_warehouse.errors import Interruption

if TYPE_CHECKING:
    from desim_warehouse.world.traffic.events import Clock


class StoppedError(Interruption):
    """Raised by a run that was stopped, because its result is no longer needed."""


class StopSignal:
    """Stops a run, from any thread, before or while it is simulated: it then raises StoppedError."""

    def __init__(self) -> None:
        self.asked = False
        self._clock: Clock | None = None
        self._lock = threading.Lock()

    def ask(self) -> None:
        """Ask the run to stop."""
        with self._lock:
            self.asked = True
            if self._clock is not None:
                self._clock.stop(StoppedError())

    def obey(self, clock: Clock) -> None:
        """Note the clock of a run that is about to begin, by which the run can be stopped.

        Raises:
            StoppedError: where it is to be stopped already.
        """
        with self._lock:
            if self.asked:
                raise StoppedError
            self._clock = clock
