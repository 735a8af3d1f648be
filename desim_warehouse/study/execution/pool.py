"""Execution of runs in worker processes of this machine.

For `--workers` of every command that does a study, and for `desim serve`.

The parent process does not simulate: it starts workers, hands batches to idle ones, and passes on finished runs. It
kills and replaces a worker that is stuck or dead, or does not stop a cancelled run. Every worker has its own pipe and
at most one batch, so the runs lost with a worker are known, and other workers go on. (`ProcessPoolExecutor` shares its
pipes: one dead process breaks the pool, and no process can be killed alone.)

Workers start only when they pay off, because a short study is over before a worker process has started.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from queue import Empty
from time import monotonic
from types import ModuleType
from typing import Any

from desim_warehouse.errors import StudyError, reason
from desim_warehouse.model import Model
from desim_warehouse.study.execution import worker as child
from desim_warehouse.study.execution.kept_fleets import KeptFleets
from desim_warehouse.study.execution.process import safe_path
from desim_warehouse.study.execution.shared import SharedExecutor
from desim_warehouse.study.execution.signals import Interrupts
from desim_warehouse.study.execution.work import ENOUGH, Handle, Outcome, Serial, Wanted

_CONTEXT = multiprocessing.get_context("spawn")  # a process of many threads, such as a notebook, must not be forked
_POLL = 0.1  # seconds between looks at time-outs and dead processes
_HEED = 0.5  # seconds that a run may take to stop
_GRACE = 2.0  # seconds beyond its time-out until the process of a run that cannot be interrupted is killed
_START = 120.0  # seconds that a process may take to start
_STARTS = 3  # processes in a row that may end before they are ready
_END = 2.0  # seconds that a dying process may take to end
_starting = threading.Lock()
ALONE = 1.0
"""Seconds of runs in this process: about as long as worker processes take to start."""


class Worker:
    """A worker process as its parent sees it, and the runs it is simulating, none while it is idle."""

    def __init__(self) -> None:
        """Start the process.

        Raises:
            OSError: where the system cannot.
        """
        self.connection, theirs = _CONTEXT.Pipe()
        self.process = _CONTEXT.Process(target=child.main, args=(theirs,))
        self.begun = False  # it is ready for batches
        self.handles: list[Handle] = []
        self.batches = 0  # sent to it
        self.bases: list[Model] = []  # sent to it
        self.since = monotonic()
        self.stopped_at: float | None = None  # when one of these runs was last to be stopped
        try:
            with _inheriting_nothing():
                self.process.start()
        except BaseException:
            self.connection.close()
            raise
        finally:
            theirs.close()

    def send(self, message: Any) -> None:
        """Send the process the message for which it waits."""
        self.since = monotonic()
        self._write(message)

    def give(self, handles: list[Handle]) -> None:
        """Give the process a batch to simulate."""
        self.handles, self.stopped_at = handles, None
        self.batches += 1
        base = handles[0].base
        number = next((n for n, model in enumerate(self.bases) if model is base), None)
        if number is None:
            self.bases.append(base)
        runs = [handle.wanted for handle in handles]
        self.send(
            child.RunBatch(len(self.bases) - 1, base, runs) if number is None else child.RunBatch(number, None, runs)
        )

    def stop(self, handle: Handle) -> None:
        """Send the process the message to stop a run, or not to begin it."""
        self.stopped_at = monotonic()
        self._write((self.batches, self.handles.index(handle)))

    def _write(self, message: Any) -> None:
        with suppress(OSError):  # it is dead, which `turn` notices
            self.connection.send(message)

    def late(self, timeout: float | None) -> bool:
        """Whether the process fails to start, or hangs in a run that neither ends nor can be interrupted."""
        taken = monotonic() - self.since
        if not self.begun:
            return taken > _START
        if timeout is None or not self.handles:
            return False
        return taken > self._before + timeout + _GRACE

    @property
    def deaf(self) -> bool:
        """Whether the process continues a run despite a message to stop it."""
        if not self.handles or self.stopped_at is None:
            return False
        return monotonic() - self.stopped_at > self._before + _HEED

    @property
    def _before(self) -> float:
        """Return the seconds that other runs of the process's batch may take before one."""
        return ENOUGH if len(self.handles) > 1 else 0.0

    def kill(self) -> None:
        """Kill the process, and all processes that policies started in it."""
        assert self.process.pid
        if hasattr(os, "killpg"):
            with suppress(OSError):  # it may have no group of its own yet
                os.killpg(self.process.pid, signal.SIGKILL)
        self.process.kill()

    def close(self) -> None:
        """Clean up after a process that was killed."""
        self.process.join(_END)
        self.connection.close()


class Pool(SharedExecutor):
    """The executor that simulates in `count` processes, which start when they are needed and stay until `close`."""

    def __init__(
        self,
        count: int,
        timeout: float | None,
        say: Callable[[str], None],
        interrupts: Interrupts,
        fleets: KeptFleets,
    ) -> None:
        super().__init__(interrupts)
        self.fleets = fleets
        self.count = count
        self.timeout = timeout
        self.say = say
        self.workers: list[Worker] = []
        self.false_starts = 0  # processes that ended before they were ready, since the last that was
        self._waking = threading.Lock()
        self._awake = True  # or there is nobody to wake

    def connect(self) -> None:
        """Make the pipe that wakes our thread."""
        self._woken, self._wake = _CONTEXT.Pipe(duplex=False)
        self._awake = False

    def wake(self) -> None:
        """Wake the executor's thread, because there is something to do."""
        with self._waking:
            if not self._awake:
                self._awake = True
                self._wake.send_bytes(b"!")

    def turn(self) -> None:
        """Do one round of work: start processes, hand out runs, and take the outcomes of finished ones.

        Raises:
            StudyError: where worker processes cannot be started.
        """
        self._start(min(self.count, self.batches.open))
        for worker in self.workers:
            self._hand_out(worker)
        at_work = any(worker.handles or not worker.begun for worker in self.workers)
        ready = wait([self._woken, *(worker.connection for worker in self.workers)], _POLL if at_work else None)
        if self._woken in ready:
            self._heed()
        for worker in list(self.workers):
            if worker.connection in ready:
                self._receive(worker)
            elif not worker.process.is_alive():  # its pipe need not end: a policy may have forked
                self._replace(worker)
            elif worker.late(self.timeout):
                self._replace(worker, stuck=True)
            elif worker.deaf:
                self._end(worker)
                self.batches.stuck(worker.handles, Outcome({}, 0.0, "cancelled", final=False))

    def disconnect(self) -> None:
        """End all processes."""
        for worker in self.workers:
            worker.kill()
        while self.workers:
            self.workers.pop().close()
        with self._waking:
            self._awake = True
            self._woken.close()
            self._wake.close()

    def _heed(self) -> None:
        """Stop cancelled runs in the processes that simulate them."""
        with self._waking:
            self._woken.recv_bytes()
            self._awake = False
        with suppress(Empty):
            while True:
                handle = self.to_stop.get_nowait()
                for worker in self.workers:
                    if handle in worker.handles:
                        worker.stop(handle)

    def _start(self, count: int) -> None:
        """Start processes until there are `count`."""
        while len(self.workers) < count and not self.closing:
            try:
                self.workers.append(Worker())
            except OSError as error:
                raise StudyError(
                    f"worker processes cannot be started ({reason(error)}); try --workers 1, "
                    "from a working directory that exists"
                ) from error

    def _hand_out(self, worker: Worker) -> None:
        """Give a worker that is idle its next batch."""
        if worker.begun and not worker.handles:
            handles = self.batches.take(self.count)
            if handles:
                worker.give(handles)

    def _receive(self, worker: Worker) -> None:
        """Handle a worker's message; the worker starts its next batch before these outcomes are stored."""
        try:
            kind, content = worker.connection.recv()
        except (EOFError, OSError):
            self._replace(worker)
            return
        if kind == "failed":
            raise StudyError(f"a worker process failed ({content}); try --workers 1")
        if kind == "hello":
            worker.send((self.fleets.folder, self.timeout))
            return
        worker.begun = True
        self.false_starts = 0
        finished, worker.handles = worker.handles, []
        self._hand_out(worker)
        self.batches.finish(finished, content)

    def _end(self, worker: Worker) -> None:
        self.workers.remove(worker)
        worker.kill()
        worker.close()

    def _replace(self, worker: Worker, *, stuck: bool = False) -> None:
        """Remove a process that died or is stuck; others retry its runs, and `turn` starts a new process."""
        if not stuck:
            worker.process.join(_END)  # so that its exit status is its own
        self._end(worker)
        if not worker.begun:
            self.false_starts += 1
            if self.false_starts == _STARTS:
                status = worker.process.exitcode
                raise StudyError(f"worker processes end before they are ready (exit status {status}); try --workers 1")
        if stuck and worker.begun:
            self.say("a run did not end and could not be interrupted; its process was killed")
            text = f"time-out: not finished after {self.timeout:g} s, and its process had to be killed"
            self.batches.stuck(worker.handles, Outcome({}, float(self.timeout or 0), text, final=False))
        else:
            self.say("a worker process died; its runs are retried")
            self.batches.died(worker.handles)


@contextmanager
def _inheriting_nothing() -> Iterator[None]:
    """Start a process without our main module and without Ctrl-C.

    The process needs only our package, so it starts faster, and a script that runs a study needs no
    `if __name__ == "__main__"`. Only one thread at a time may do this, so that the true main module is restored. Ctrl-C
    at a terminal reaches all processes; in this process it is only delayed.
    """
    masks = hasattr(signal, "pthread_sigmask")
    with _starting, safe_path():
        if masks:
            resource_tracker.ensure_running()  # started below, it would let signals through again
        before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT]) if masks else set()
        main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
        try:
            yield
        finally:
            sys.modules["__main__"] = main
            if masks:
                signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Auto:
    """The executor that first simulates in this process, and hands the runs that remain after a while to a pool."""

    def __init__(self, alone: Serial, pool: Pool) -> None:
        self.alone = alone
        self.pool = pool
        self.left = ALONE if pool.timeout is None else 0.0  # a pool can kill what runs too long

    def submit(self, base: Model, run: Wanted) -> Handle:
        """Submit a run, which is simulated as soon as `ended` waits for it."""
        return Handle(base, run, self._stop)

    def ended(self, handles: Sequence[Handle]) -> Generator[Handle]:
        """Yield these runs, each as soon as it has ended; raises as `Pool.ended`."""
        first = 0
        while first < len(handles) and self.left > 0:
            for handle in self.alone.ended([handles[first]]):
                self.left -= 0.0 if handle.outcome is None else handle.outcome.run_time
                yield handle
            first += 1
        for handle in handles[first:]:
            self.pool.add(handle)
        yield from self.pool.ended(handles[first:])

    def close(self) -> None:
        """End all processes."""
        self.pool.close()

    def _stop(self, handle: Handle) -> None:
        self.alone.stop(handle)
        self.pool.stop(handle)
