"""Carrying out runs: here, in processes of this machine, or on a Dask cluster; the results are the same."""

from __future__ import annotations

import os
from contextlib import AbstractContextManager, ExitStack
from typing import TYPE_CHECKING, Protocol, Self

from desim_warehouse.errors import StudyError
from desim_warehouse.study.execution.ctrl_c import CtrlC

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from types import TracebackType

    from desim_warehouse.model import Model
    from desim_warehouse.study.execution.work import Outcome, Wanted


class Execution(Protocol):
    """Simulates runs, in any order, and hands over each as soon as it is finished."""

    def run(self, wanted: Sequence[Wanted], done: Callable[[int, Outcome], None]) -> None:
        """Simulate every wanted run; `done` is told the run's position and what came out, in this thread."""
        ...


class Opened:
    """The way to run, opened when a first run is wanted: a finished study starts no process.

    `cluster` (a Dask scheduler's address, or `local`), else so many processes, else this one.
    """

    def __init__(
        self,
        base: Model,
        workers: int | str,
        cluster: str | None,
        timeout: float | None,
        say: Callable[[str], None],
    ) -> None:
        """Raise StudyError where there is no such number of workers."""
        self.base = base
        self.count = worker_count(workers)
        self.cluster = cluster
        self.timeout = timeout
        self.say = say
        self.stack = ExitStack()
        self.ctrl_c = CtrlC()
        self.execution: Execution | None = None

    def __enter__(self) -> Self:
        self.stack.enter_context(self.ctrl_c)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stack.__exit__(kind, error, trace)

    def run(self, wanted: Sequence[Wanted], done: Callable[[int, Outcome], None]) -> None:
        """Simulate every wanted run."""
        if self.execution is None:
            self.execution = self.stack.enter_context(self._open())

        def heeded(position: int, outcome: Outcome) -> None:
            done(position, outcome)
            self.ctrl_c.heed()

        self.execution.run(wanted, heeded)

    def _open(self) -> AbstractContextManager[Execution]:
        if self.cluster is not None:
            from desim_warehouse.study.execution.cluster import Cluster

            return Cluster(self.base, self.cluster, self.count, self.timeout, self.say)
        if self.count > 1:
            from desim_warehouse.study.execution.processes import Processes

            return Processes(self.base, self.count, self.timeout, self.say, self.ctrl_c)
        from desim_warehouse.study.execution.serial import Serial

        return Serial(self.base, self.timeout)


def worker_count(workers: int | str) -> int:
    """The number of workers: `auto` is one for each processor that we may use."""
    if workers == "auto":
        affinity = getattr(os, "sched_getaffinity", None)
        return len(affinity(0)) if affinity else os.cpu_count() or 1
    try:
        count = int(str(workers))
    except ValueError:
        count = 0
    if count < 1:
        raise StudyError(f"workers {workers!r}: expected a number of at least 1, or auto")
    return count
