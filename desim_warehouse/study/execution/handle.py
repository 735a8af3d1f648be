"""A run that was submitted, and who is told when it has ended."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from queue import SimpleQueue

    from desim_warehouse.study.execution.work import Outcome, Wanted

_ending = threading.Lock()


class Handle:
    """A run that was submitted: its outcome once it has ended, None before that and where it was cancelled.

    It is used from any thread.
    """

    __slots__ = ("_stop", "_told", "cancelled", "outcome", "wanted")

    def __init__(self, wanted: Wanted, stop: Callable[[Handle], None]) -> None:
        self.wanted = wanted
        self.outcome: Outcome | None = None
        self.cancelled = False
        self._stop = stop
        self._told: SimpleQueue[Handle] | None = None

    @property
    def ended(self) -> bool:
        """Whether it has an outcome, or was cancelled."""
        return self.cancelled or self.outcome is not None

    def cancel(self) -> None:
        """Have it stopped, or not begun. Nothing happens where it has ended."""
        if self._end(None):
            self._stop(self)

    def end(self, outcome: Outcome) -> None:
        """It has an outcome, of which nothing is known where it was cancelled before."""
        self._end(outcome)

    def tell(self, queue: SimpleQueue[Handle]) -> None:
        """Put it into a queue when it has ended."""
        with _ending:
            if not self.ended:
                self._told = queue
                return
        queue.put(self)

    def _end(self, outcome: Outcome | None) -> bool:
        with _ending:
            if self.ended:
                return False
            self.outcome, self.cancelled = outcome, outcome is None
            told, self._told = self._told, None
        if told is not None:
            told.put(self)
        return True
