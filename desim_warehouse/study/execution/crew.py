"""The executors that a command shares among its studies: processes that start once, and settled fleets.

For every command whose question does runs of its own: `plan`, `size`, `best`, `orient`, `why`, `what-if` and `study`.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

from desim_warehouse.study.execution import Executor, make_executor
from desim_warehouse.study.execution.kept_fleets import FleetsOfACommand
from desim_warehouse.study.execution.repeats import Repeats
from desim_warehouse.study.execution.signals import Interrupts


class Crew:
    """The executors of a command, one for each time-out, and its settled fleets; `close` ends them all."""

    def __init__(self, workers: int | str, cluster: str | None, *, cache: bool) -> None:
        self.workers = workers
        self.cluster = cluster
        self.interrupts = Interrupts()
        """Entered by a study while it is under way."""
        self.fleets = FleetsOfACommand(cache=cache)
        self.repeats = Repeats(self._elsewhere)
        """Repeated runs that check the user's own policies."""
        self._executors: dict[float | None, Executor] = {}
        self._report: Callable[[str], None] = lambda _: None

    def executor(self, timeout: float | None, say: Callable[[str], None]) -> Executor:
        """Return the executor for runs with this time-out; from now on `say` receives messages about lost workers.

        Raises:
            StudyError: the number of workers is out of range.
        """
        self._report = say
        if timeout not in self._executors:
            self._executors[timeout] = make_executor(
                self.workers, self.cluster, timeout, self._say, self.interrupts, self.fleets
            )
        return self._executors[timeout]

    def close(self) -> None:
        """End all processes and connections, even if they are busy."""
        with self.interrupts, ExitStack() as ending:
            ending.callback(self.fleets.close)
            ending.callback(self.repeats.close)
            for executor in self._executors.values():
                ending.callback(executor.close)

    def _elsewhere(self) -> Executor:
        """Make one more process on this machine."""
        from desim_warehouse.study.execution.pool import Pool

        return Pool(1, None, self._say, self.interrupts, self.fleets)

    def _say(self, text: str) -> None:
        self._report(text)
