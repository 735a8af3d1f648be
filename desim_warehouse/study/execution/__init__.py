"""Executors for the runs of a study: in this process, in worker processes of this machine, or on a Dask cluster.

Results do not depend on the executor. Submitting a run returns a `Handle`, and any process may simulate the run
(`work`). `pool` manages the worker processes, which execute `worker`, and decides when they pay off; `process` keeps
numerical libraries to one thread in each. `shared` hands out runs, in a thread of its own. `signals` makes Ctrl-C
safe. `store` keeps finished runs in a folder or in the user's `cache`, along with settled fleets (`kept_fleets`). A
`crew` holds all executors of a command.
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
        """Submit a run of a design of a base model.

        `Handle.cancel` stops the run, or keeps it from starting, and may be called from any thread.
        """
        ...

    def ended(self, handles: Sequence[Handle]) -> Generator[Handle]:
        """Wait for submitted runs, and yield each as soon as it has ended or was cancelled.

        Runs of this process are simulated now, in the calling thread.
        """
        ...

    def close(self) -> None:
        """End all worker processes and connections, even if they are busy."""
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

    `timeout`: seconds per run. `say` receives messages about lost workers. Processes of this machine share the settled
    `fleets`; processes of a cluster have their own.

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
    """Return the number of workers; `auto` means one for each available processor."""
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
