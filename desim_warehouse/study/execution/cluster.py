"""Execution of runs on a Dask cluster, whose scheduler replaces dead workers and repeats their runs.

For `--cluster` of every command that does a study.
"""

from __future__ import annotations

import importlib
import pickle
import queue
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from typing import Any, cast

from desim_warehouse._version import __version__
from desim_warehouse.errors import StudyError, reason
from desim_warehouse.model import Model
from desim_warehouse.study.execution.process import safe_path
from desim_warehouse.study.execution.shared import SharedExecutor
from desim_warehouse.study.execution.signals import Interrupts
from desim_warehouse.study.execution.work import Handle, Outcome, Simulator, Wanted
from desim_warehouse.world.robots.settled import SettledFleets

_AHEAD = 3  # batches for each thread of the cluster
_POLL = 1.0  # seconds
_WAIT = 10  # seconds for a scheduler to answer
_BATCH_TIME = 0.25  # seconds of work in a batch: a scheduler takes some milliseconds for each


def make_simulator(version: str) -> Simulator:
    """Return the simulator of a worker, made once per worker."""
    if version != __version__:
        raise StudyError(
            f"a worker of the cluster has desim-warehouse {__version__}, the study {version}: "
            "the results would be mixed up; install the same version on all machines"
        )
    return Simulator(SettledFleets())


def read_base(base: bytes) -> Model:
    """Read a base model on a worker, which keeps it."""
    return cast("Model", pickle.loads(base))  # noqa: S301 - our own model, from our own process


def simulate_batch(simulator: Simulator, base: Model, batch: Sequence[Wanted], timeout: float | None) -> list[Outcome]:
    """Simulate runs on a worker, one after the other; return fewer outcomes than runs if they take long."""
    return simulator.batch(base, batch, timeout)


class Cluster(SharedExecutor):
    """The executor that simulates on the cluster of a scheduler, or on one of this machine (`local`)."""

    def __init__(
        self,
        address: str,
        workers: int,
        timeout: float | None,
        say: Callable[[str], None],
        interrupts: Interrupts,
    ) -> None:
        super().__init__(interrupts)
        self.address = address
        self.workers = workers
        self.timeout = timeout
        self.say = say
        self.client: Any = None
        self.local: Any = None
        self.threads = 0
        self.simulator: Any = None
        self.bases: list[tuple[Model, Any]] = []  # sent to the cluster
        self.handed_out: dict[str, tuple[Any, list[Handle]]] = {}
        self.finished: queue.SimpleQueue[Any] = queue.SimpleQueue()  # None: something else is to be done
        self._children = ExitStack()

    def wake(self) -> None:
        """Wake the executor's thread, because there is something to do."""
        self.finished.put(None)

    def turn(self) -> None:
        """Do one round of work: hand out runs, and take the outcomes of finished ones.

        Raises:
            StudyError: where the cluster is lost, or its workers cannot run our models.
        """
        while len(self.handed_out) < _AHEAD * max(self.threads, 1):
            handles = self.batches.take(max(self.threads, 1), _BATCH_TIME)
            if not handles:
                break
            runs = [handle.wanted for handle in handles]
            base = self._sent(handles[0].base)
            future = self.client.submit(simulate_batch, self.simulator, base, runs, self.timeout, pure=False)
            self.handed_out[future.key] = (future, handles)
            future.add_done_callback(self.finished.put)
        try:
            future = self.finished.get(timeout=_POLL)
        except queue.Empty:
            self._check()
            self.threads = self._threads()
            return
        if future is None:
            self._heed()
        elif future.key in self.handed_out:
            _, handles = self.handed_out.pop(future.key)
            self._finish(future, handles)

    def disconnect(self) -> None:
        """Disconnect from the cluster, and shut down a local one."""
        if self.client.status == "running":
            self.client.cancel([future for future, _ in self.handed_out.values()])
        for part in (self.client, self.local):
            if part is not None:
                part.close()
        self._children.close()

    def _heed(self) -> None:
        """Cancel batches all of whose runs were cancelled; a batch that has begun is not stopped."""
        with suppress(queue.Empty):
            while True:
                self.to_stop.get_nowait()
        gone = [key for key, (_, handles) in self.handed_out.items() if all(handle.ended for handle in handles)]
        for key in gone:
            future, handles = self.handed_out.pop(key)
            self.client.cancel([future])
            self.batches.finish(handles, [])

    def connect(self) -> None:
        """Find the cluster.

        Raises:
            StudyError: where none answers.
        """
        try:
            distributed: Any = importlib.import_module("distributed")
        except ImportError as error:
            raise StudyError("--cluster needs Dask: install it by pip install 'desim-warehouse[dask]'") from error
        try:
            if self.address == "local":
                self._children.enter_context(safe_path())  # a worker that dies is replaced at any time
                self.local = distributed.LocalCluster(
                    n_workers=self.workers, threads_per_worker=1, dashboard_address=None
                )
            else:  # a bad address would leave the client half constructed
                importlib.import_module("distributed.comm").resolve_address(self.address)
            self.client = distributed.Client(self.local or self.address, timeout=_WAIT, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise StudyError(
                f"cluster {self.address}: no Dask scheduler answers there ({reason(error)}); "
                "expected an address such as tcp://10.0.0.1:8786, or local"
            ) from error
        self.threads = self._threads()
        self.simulator = self.client.submit(make_simulator, __version__)
        if not self.threads:
            self.say(f"cluster {self.address}: no workers yet; waiting for them")

    def _sent(self, base: Model) -> Any:
        """Send a base model to the cluster the first time, and return its future."""
        for sent_base, future in self.bases:
            if sent_base is base:
                return future
        sent = self.client.submit(read_base, pickle.dumps(base))
        self.bases.append((base, sent))
        return sent

    def _threads(self) -> int:
        """Return how many runs the cluster can do at a time."""
        return sum(self.client.nthreads().values())

    def _check(self) -> None:
        """Check that the scheduler is still there."""
        if self.client.status != "running":
            raise StudyError(
                f"cluster {self.address}: the connection to the scheduler is lost; the runs finished so far are "
                "kept: start the study again when it is back"
            )

    def _finish(self, future: Any, handles: list[Handle]) -> None:
        """Take the outcomes of a batch."""
        if future.status == "finished":
            self.batches.finish(handles, future.result())
            return
        error = future.exception() if future.status == "error" else None
        if error is not None and type(error).__name__ != "KilledWorker":
            if isinstance(error, StudyError):
                raise error
            raise StudyError(
                f"cluster {self.address}: its workers cannot run our models ({type(error).__name__}: {error}); "
                "is desim-warehouse installed there?"
            ) from error
        self._check()
        self.say("workers of the cluster were lost; their runs are retried")
        self.batches.died(handles)
