"""Dealing runs out to workers: few at first, then as many at a time as take about a tenth of a second."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from desim_warehouse.study.execution.work import Outcome, Wanted

BATCH_TIME = 0.1  # seconds of work in a batch: much longer than handing it over, too short to be missed
LEAST_TIME = 0.005  # seconds of work that are not worth dividing
_MOST = 200
_TRIES = 3


class Batches:
    """The runs still to be dealt out, by position; those that were lost with a worker are dealt out one by one."""

    def __init__(
        self, wanted: Sequence[Wanted], done: Callable[[int, Outcome], None], run_time: float | None = None
    ) -> None:
        self.wanted = wanted
        self.done = done
        self.waiting = deque(range(len(wanted)))
        self.alone: deque[int] = deque()
        self.tries: dict[int, int] = {}
        self.open = len(wanted)
        self.run_time = run_time  # seconds, mean of late

    def take(self, workers: int, seconds: float = BATCH_TIME) -> list[int]:
        """The next runs for one of so many workers; none if all are dealt out."""
        if self.alone:
            return [self.alone.popleft()]
        if not self.waiting:
            return []
        fair = len(self.waiting) // (2 * workers)  # so that all workers end at about the same time
        number = max(1, self._done_in(LEAST_TIME), min(self._done_in(seconds), fair))
        return [self.waiting.popleft() for _ in range(min(number, len(self.waiting)))]

    def _done_in(self, seconds: float) -> int:
        """How many runs take so long; 0 where that is not known yet."""
        return 0 if self.run_time is None else min(int(seconds / max(self.run_time, 1e-6)), _MOST)

    def finish(self, positions: Sequence[int], outcomes: Sequence[Outcome]) -> None:
        """These runs are finished; those without an outcome were not begun."""
        self.put_back(positions[len(outcomes) :])
        for position, outcome in zip(positions, outcomes, strict=False):
            before = outcome.run_time if self.run_time is None else self.run_time
            self.run_time = before + 0.2 * (outcome.run_time - before)
            self.open -= 1
            self.done(position, outcome)

    def put_back(self, positions: Iterable[int]) -> None:
        """These runs were dealt out, and not begun."""
        self.waiting.extendleft(reversed(list(positions)))

    def lost(self, positions: Sequence[int]) -> list[int]:
        """A worker was lost at these runs: they are dealt out again, one by one.

        Returns:
            Those that were alone with a lost worker so often that they are given up.
        """
        given_up = []
        for position in positions:
            if len(positions) == 1:
                self.tries[position] = self.tries.get(position, 0) + 1
            if self.tries.get(position, 0) >= _TRIES:
                given_up.append(position)
            else:
                self.alone.append(position)
        return given_up
