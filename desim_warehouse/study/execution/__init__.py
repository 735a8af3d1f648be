"""Executors for the runs of a study: in this process, in worker processes of this machine, or on a Dask cluster.

The results are the same. A run is submitted, which gives a `Handle`, and is simulated in any process (`work`). `pool`
has the worker processes, whose own code is `worker`, and says when they are worth it; `threads` keeps numerical
libraries to one in each. `shared` hands out runs, in a thread of its own. `signals` makes Ctrl-C safe. `store` keeps
finished runs in a folder, or in the user's `cache`, with the `kept_fleets` that settled. A `crew` is all of it that a
command has.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Generator, Sequence
from typing import TYPE_CHECKING, Protocol

from desim_warehouse.errors import StudyError
from desim_warehouse.study.execution.signals import Interrupts

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.study.execution.kept_fleets import KeptFleets
    from desim_warehouse.study.execution.work import Handle, Wanted


MOST_WORKERS = 61 if sys.platform == "win32" else 256  # Windows waits for no more at once


class Executor(Protocol):
    """Simulates runs, in any order, for any number of callers, each in a thread of its own.

    Processes and connections are made when the first run is wanted.
    """

    def submit(self, base: Model, run: Wanted) -> Handle:
        """Have a run of a design of a base model simulated.

        `Handle.cancel`, from any thread, stops it or has it never begun.
        """
        ...

    def ended(self, handles: Sequence[Handle]) -> Generator[Handle]:
        """Wait for runs that were submitted here, and yield each as soon as it has ended or was cancelled.

        What is simulated in this process is simulated now, in the thread that asks.
        """
        ...

    def close(self) -> None:
        """End all worker processes and connections, whatever they are doing."""
        ...


def make_executor(
    workers: int | str,
    cluster: str | None,
    timeout: float | None,
    say: Callable[[str], None],
    interrupts: Interrupts,
    fleets: KeptFleets,
) -> Executor:
    """Make the executor of a command: on `cluster`, else in worker processes, else in this process.

    `timeout` is in seconds a run. Messages about workers that were lost go to `say`. Processes of this machine share
    the settled `fleets`; those of a cluster have their own.

    Raises:
        StudyError: where the number of workers is out of range.
    """
    count = worker_count(workers)
    if cluster is not None:
        from desim_warehouse.study.execution.cluster import Cluster

        return Cluster(cluster, count, timeout, say, interrupts)
    from desim_warehouse.study.execution.work import Serial

    if count > 1:
        from desim_warehouse.study.execution.pool import Pool

        pool = Pool(count, timeout, say, interrupts, fleets)
        if workers == "auto":
            from desim_warehouse.study.execution.pool import Auto

            return Auto(Serial(timeout, interrupts, fleets), pool)
        return pool
    return Serial(timeout, interrupts, fleets)


def worker_count(workers: int | str) -> int:
    """Return the number of workers: `auto` is one for each processor available."""
    if workers == "auto":
        affinity = getattr(os, "sched_getaffinity", None)
        return min(len(affinity(0)) if affinity else os.cpu_count() or 1, MOST_WORKERS)
    try:
        count = int(str(workers))
    except ValueError:
        count = 0
    if not 1 <= count <= MOST_WORKERS:
        raise StudyError(f"workers {workers!r:.60}: expected a number from 1 to {MOST_WORKERS}, or auto")
    return count
