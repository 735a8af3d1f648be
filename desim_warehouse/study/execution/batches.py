"""Which runs a worker gets next: one at first, then as many as take about a tenth of a second."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from desim_warehouse.study.execution.work import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from desim_warehouse.study.execution.work import Wanted

BATCH_TIME = 0.1  # seconds of work in a batch: much longer than handing it over, too short to be missed
_MOST = 200
_TRIES = 3  # workers that a run may kill before it is given up
_DIED = Outcome({}, 0.0, "the worker process died at every attempt at this run (killed, or out of memory)", final=False)
_RECENT = 0.2  # weight of the latest run in the mean time of a run


class Batches:
    """The runs still to be handed out, by position. Those lost with a worker are handed out one by one.

    One by one, because any run of the lost batch may be the one that kills workers.
    """

    def __init__(
        self, wanted: Sequence[Wanted], done: Callable[[int, Outcome], None], run_time: float | None = None
    ) -> None:
        self.wanted = wanted
        self.done = done
        self.waiting = deque(range(len(wanted)))
        self.alone: deque[int] = deque()
        self.deaths: dict[int, int] = {}  # of workers that were alone with a run
        self.open = len(wanted)  # not finished yet
        self.run_time = run_time  # seconds, recent mean

    def take(self, workers: int, seconds: float = BATCH_TIME) -> list[int]:
        """The next runs for one of `workers` workers, or none if all are handed out."""
        if self.alone:
            return [self.alone.popleft()]
        number = 1
        if self.run_time is not None:
            fair = len(self.waiting) // (2 * workers)  # so that all workers end at about the same time
            number = max(1, min(int(seconds / max(self.run_time, 1e-6)), fair, _MOST))
        return [self.waiting.popleft() for _ in range(min(number, len(self.waiting)))]

    def finish(self, positions: Sequence[int], outcomes: Sequence[Outcome]) -> None:
        """These runs are finished. Those without an outcome were not begun, and are put back."""
        self.waiting.extendleft(reversed(positions[len(outcomes) :]))
        for position, outcome in zip(positions, outcomes, strict=False):
            before = outcome.run_time if self.run_time is None else self.run_time
            self.run_time = before + _RECENT * (outcome.run_time - before)
            self.open -= 1
            self.done(position, outcome)

    def died(self, positions: Sequence[int]) -> None:
        """A worker died at these runs, which are retried. A run that killed several workers alone is given up."""
        for position in positions:
            if len(positions) == 1:
                self.deaths[position] = self.deaths.get(position, 0) + 1
            if self.deaths.get(position, 0) < _TRIES:
                self.alone.append(position)
            else:
                self.finish([position], [_DIED])

    def stuck(self, positions: Sequence[int], outcome: Outcome) -> None:
        """A worker was stuck at one of these runs. A single one has this outcome, several are retried one by one."""
        if len(positions) == 1:
            self.finish(positions, [outcome])
        else:
            self.alone.extend(positions)
