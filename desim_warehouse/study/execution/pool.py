"""Runs in worker processes of this machine.

The parent simulates nothing: it starts the processes, hands batches to those that are idle, and passes on what is
finished. It kills and replaces a process that is stuck or dead. Every process has a pipe of its own and at most one
batch. So the runs lost with it are known, and the others go on. (`ProcessPoolExecutor` shares its pipes: one dead
process breaks the pool, and none can be killed alone.)
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections import deque
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from time import monotonic
from types import ModuleType
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import StudyError, reason
from desim_warehouse.study.execution import worker as child
from desim_warehouse.study.execution.batches import Batches
from desim_warehouse.study.execution.safe_path import safe_path
from desim_warehouse.study.execution.work import ENOUGH, Outcome, Wanted

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Sequence

    from desim_warehouse.model import Model
    from desim_warehouse.study.execution.signals import Interrupts

_CONTEXT = multiprocessing.get_context("spawn")  # a process of many threads, such as a notebook, must not be forked
_POLL = 0.1  # seconds between looks at Ctrl-C, time-outs and dead processes
_GRACE = 2.0  # seconds beyond its time-out until the process of a run that cannot be interrupted is killed
_START = 120.0  # seconds that a process may take to start
_STARTS = 3  # processes in a row that may end before they are ready
_END = 2.0  # seconds that a dying process may take to end


class Worker:
    """A process as the parent sees it, and the runs it is simulating, by position, none while it is idle."""

    def __init__(self) -> None:
        """Start the process.

        Raises:
            OSError: where the system cannot.
        """
        self.connection, theirs = _CONTEXT.Pipe()
        self.process = _CONTEXT.Process(target=child.main, args=(theirs,))
        self.begun = False  # it is ready for batches
        self.positions: list[int] = []
        self.since = monotonic()
        try:
            with _inheriting_nothing():
                self.process.start()
        except BaseException:
            self.connection.close()
            raise
        finally:
            theirs.close()

    def send(self, message: Any) -> None:
        """Send what it is waiting for."""
        self.since = monotonic()
        with suppress(OSError):  # it is dead, which `run` notices
            self.connection.send(message)

    def late(self, timeout: float | None) -> bool:
        """Whether it does not start, or its run can neither end nor be interrupted."""
        taken = monotonic() - self.since
        if not self.begun:
            return taken > _START
        if timeout is None or not self.positions:
            return False
        before = ENOUGH if len(self.positions) > 1 else 0.0
        return taken > before + timeout + _GRACE

    def kill(self) -> None:
        """Kill the process, and those that policies started in it."""
        assert self.process.pid
        if hasattr(os, "killpg"):
            with suppress(OSError):  # it may have no group of its own yet
                os.killpg(self.process.pid, signal.SIGKILL)
        self.process.kill()

    def close(self) -> None:
        """Clean up after a process that was killed."""
        self.process.join(_END)
        self.connection.close()


class Pool:
    """The executor that simulates in `count` processes, which begin when they are needed and stay until `close`."""

    def __init__(
        self, base: Model, count: int, timeout: float | None, say: Callable[[str], None], interrupts: Interrupts
    ) -> None:
        self.base = base
        self.count = count
        self.timeout = timeout
        self.say = say
        self.interrupts = interrupts
        self.workers: list[Worker] = []
        self.run_time: float | None = None
        self.false_starts = 0  # processes that ended before they were ready, since the last that was

    def run(self, wanted: Sequence[Wanted]) -> Generator[tuple[int, Outcome]]:
        """Simulate every wanted run.

        Raises:
            StudyError: where worker processes cannot be started.
            KeyboardInterrupt: on Ctrl-C, between two outcomes.
        """
        finished: deque[tuple[int, Outcome]] = deque()
        batches = Batches(wanted, lambda *one: finished.append(one), self.run_time)
        with self.interrupts.held(), self._cancelling():
            while batches.open:
                self._start(min(self.count, batches.open))
                for worker in self.workers:
                    self._hand_out(worker, batches)
                self.interrupts.heed()
                ready = wait([worker.connection for worker in self.workers], _POLL)
                for worker in list(self.workers):
                    if worker.connection in ready:
                        self._receive(worker, batches)
                    elif not worker.process.is_alive():  # its pipe need not end: a policy may have forked
                        self._replace(worker, batches)
                    elif worker.late(self.timeout):
                        self._replace(worker, batches, stuck=True)
                while finished:
                    yield finished.popleft()
        self.run_time = batches.run_time

    @contextmanager
    def _cancelling(self) -> Iterator[None]:
        """However the block ends, no process is left at work: what it would say next is not for those who ask next."""
        try:
            yield
        finally:
            for worker in [worker for worker in self.workers if worker.positions]:
                self.workers.remove(worker)
                worker.kill()
                worker.close()

    def close(self) -> None:
        """End all processes."""
        with self.interrupts.held():
            for worker in self.workers:
                worker.kill()
            while self.workers:
                self.workers.pop().close()

    def _start(self, count: int) -> None:
        """Start processes until there are `count`."""
        while len(self.workers) < count:
            self.interrupts.heed()
            try:
                self.workers.append(Worker())
            except OSError as error:
                raise StudyError(
                    f"worker processes cannot be started ({reason(error)}); try --workers 1, "
                    "from a working directory that exists"
                ) from error

    def _hand_out(self, worker: Worker, batches: Batches) -> None:
        """Give a worker that is idle its next batch."""
        if worker.begun and not worker.positions:
            worker.positions = batches.take(self.count)
            if worker.positions:
                worker.send([batches.wanted[position] for position in worker.positions])

    def _receive(self, worker: Worker, batches: Batches) -> None:
        """Handle a worker's message. It works on its next batch while the outcomes of this one are written down."""
        try:
            kind, content = worker.connection.recv()
        except (EOFError, OSError):
            self._replace(worker, batches)
            return
        if kind == "failed":
            raise StudyError(f"a worker process failed ({content}); try --workers 1")
        if kind == "hello":
            worker.send((self.base, self.timeout))
            return
        worker.begun = True
        self.false_starts = 0
        finished, worker.positions = worker.positions, []
        self._hand_out(worker, batches)
        batches.finish(finished, content)

    def _replace(self, worker: Worker, batches: Batches, *, stuck: bool = False) -> None:
        """A process died, or is stuck: others retry its runs, and `run` starts a new one."""
        self.workers.remove(worker)
        if not stuck:
            worker.process.join(_END)  # so that its exit status is its own
        worker.kill()
        worker.close()
        if not worker.begun:
            self.false_starts += 1
            if self.false_starts == _STARTS:
                status = worker.process.exitcode
                raise StudyError(f"worker processes end before they are ready (exit status {status}); try --workers 1")
        if stuck and worker.begun:
            self.say("a run did not end and could not be interrupted; its process was killed")
            text = f"time-out: not finished after {self.timeout:g} s, and its process had to be killed"
            batches.stuck(worker.positions, Outcome({}, float(self.timeout or 0), text, final=False))
        else:
            self.say("a worker process died; its runs are retried")
            batches.died(worker.positions)


_starting = threading.Lock()


@contextmanager
def _inheriting_nothing() -> Iterator[None]:
    """Start a process without our main module and without Ctrl-C.

    It needs our package only, so it starts sooner, and a script that runs a study needs no `if __name__ == "__main__"`.
    One thread at a time, so that it is the main module that comes back. Ctrl-C at a terminal goes to all processes.
    Here it is only delayed.
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
