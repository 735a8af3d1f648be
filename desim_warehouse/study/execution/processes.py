"""Runs in processes of this machine: each worker is a process of its own, replaced if it dies.

Every worker is a `ProcessPoolExecutor` of one process, started afresh ("spawn"): so it is known which runs a
process had when it died, and another worker's runs are not disturbed. This process takes part in studies of
short runs: with two workers it does half of the work while the other worker is still starting.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections import deque
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.context import SpawnContext, SpawnProcess
from time import monotonic
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from desim_warehouse.errors import StudyError, reason
from desim_warehouse.study.execution import child
from desim_warehouse.study.execution.batches import Batches
from desim_warehouse.study.execution.work import ENOUGH, TIME_OUT, Bench, Outcome, Wanted
from desim_warehouse.study.plan import own_policies

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from types import TracebackType

    from desim_warehouse.model import Model
    from desim_warehouse.study.execution.ctrl_c import CtrlC

_AHEAD = 2  # batches that a worker has: one to work on, one to go on with
_GRACE = 2.0  # seconds beyond its time-out until the process of a run that cannot be interrupted is killed
_POLL = 0.2  # seconds
_HELP = 0.02  # seconds of work that this process does between looking after the workers
_BREATH = 0.0001  # seconds between such pieces of work in which the threads that talk to the workers get their turn
_SHORT = 0.05  # seconds: runs of this length at most are done here ...
_LONG = 3  # ... until so many in a row were longer
_STUCK = 0.5  # seconds after which a run begun here is left to a worker
_STARTS = 3  # processes of one worker that may die before they are ready


class Batch(NamedTuple):
    """Runs that a worker was given, by position."""

    positions: list[int]
    result: Future[list[Outcome]]


class Worker:
    """One process and the batches it was given, the first of which it is at."""

    def __init__(self, base: Model, timeout: float | None) -> None:
        self.base = base
        self.timeout = timeout
        self.batches: deque[Batch] = deque()
        self.starts = 0
        self.start()

    def start(self) -> None:
        """Begin a new process."""
        self.starts += 1
        self.context = _Spawn()
        self.executor = ProcessPoolExecutor(1, self.context, child.prepare)
        try:
            with _bare_main(), _without_ctrl_c():
                self.hello: Future[None] = self.executor.submit(child.begin, self.base)
        except BaseException as error:
            self.kill()
            self.close()
            if isinstance(error, OSError):
                said = "try --workers 1, from a working directory that exists"
                raise StudyError(f"worker processes cannot be started ({reason(error)}); {said}") from error
            raise
        self.ready = False
        self.begun: float | None = None

    def give(self, positions: list[int], runs: list[Wanted]) -> None:
        """Give it a further batch."""
        if not self.batches:
            self.begun = None
        try:
            result = self.executor.submit(child.work, runs, self.timeout)
        except BrokenProcessPool as error:  # it died since we last looked
            result = Future()
            result.set_exception(error)
        self.batches.append(Batch(positions, result))

    @property
    def awaited(self) -> Future[Any] | None:
        """What comes next from it, if anything does."""
        if not self.ready:
            return self.hello
        return self.batches[0].result if self.batches else None

    def late(self) -> bool:
        """Whether the run it is at can neither end nor be interrupted."""
        if self.timeout is None or not self.batches:
            return False
        if self.begun is None:
            self.begun = monotonic()
        before = ENOUGH if len(self.batches[0].positions) > 1 else 0.0
        return monotonic() - self.begun > before + self.timeout + _GRACE

    def kill(self) -> None:
        """End the process at once, and those that policies started in it."""
        for process in self.context.processes:
            if process.pid is None:  # it could not be started
                continue
            if hasattr(os, "killpg"):
                with suppress(OSError):
                    os.killpg(process.pid, signal.SIGKILL)
            with suppress(OSError):
                process.kill()  # it may have no group of its own yet

    def close(self, *, wait: bool = False) -> None:
        """Let go of a process that was killed."""
        self.executor.shutdown(wait=wait, cancel_futures=True)


class Processes:
    """Simulates in `count` processes, this one among them while runs are short."""

    def __init__(
        self, base: Model, count: int, timeout: float | None, say: Callable[[str], None], ctrl_c: CtrlC
    ) -> None:
        self.ctrl_c = ctrl_c
        self.base = base
        self.count = count
        self.timeout = timeout
        self.say = say
        self.workers: list[Worker] = []
        self.bench: Bench | None = None  # None: this process does no runs
        self.run_time: float | None = None
        self.long = 0

    def __enter__(self) -> Self:
        try:
            with self.ctrl_c.held():
                for _ in range(self.count - 1):
                    self.workers.append(Worker(self.base, self.timeout))
            self.ctrl_c.heed()
            self.bench = Bench(self.base)  # what that imports is imported while the workers begin
        except BaseException:
            self.end(wait=True)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end(wait=kind is not None)  # this process may be about to end: Python wants no worker half gone then

    def end(self, *, wait: bool) -> None:
        """End all workers."""
        for worker in self.workers:
            worker.kill()
        for worker in self.workers:
            worker.close(wait=wait)

    def run(self, wanted: Sequence[Wanted], done: Callable[[int, Outcome], None]) -> None:
        """Simulate every wanted run.

        Raises:
            StudyError: where worker processes cannot be started.
        """
        batches = Batches(wanted, done, self.run_time)
        with self.ctrl_c.held():
            self.deal(wanted, batches)

    def deal(self, wanted: Sequence[Wanted], batches: Batches) -> None:
        """Deal runs out until all are finished; Ctrl-C is heeded between two turns, and in runs that are done here."""
        while batches.open:
            self.ctrl_c.heed()
            for worker in self.workers:
                while worker.ready and len(worker.batches) < _AHEAD and (positions := batches.take(self.count)):
                    worker.give(positions, [wanted[position] for position in positions])
            self.run_time = batches.run_time
            positions = [] if self.bench is None else batches.take(self.count, _HELP)
            if self.bench is not None and positions:
                with self.ctrl_c.held(False):
                    self.help(self.bench, positions, batches)
            if awaited := [future for worker in self.workers if (future := worker.awaited) is not None]:
                wait(awaited, _BREATH if positions else _POLL, FIRST_COMPLETED)
            self.collect(batches)

    def collect(self, batches: Batches) -> None:
        """Take what the workers have finished, and replace those that died."""
        for worker in self.workers:
            while (awaited := worker.awaited) is not None and awaited.done():
                error = awaited.exception()
                if isinstance(error, BrokenProcessPool):
                    self.died(worker, batches)
                    break
                if error is not None:
                    what = "a worker process failed" if worker.ready else "worker processes cannot begin"
                    raise StudyError(f"{what} ({type(error).__name__}: {error})") from error
                if not worker.ready:
                    worker.ready = True
                    continue
                positions, result = worker.batches.popleft()
                worker.begun = None
                worker.starts = 0
                batches.finish(positions, result.result())
            if worker.late():
                self.stuck(worker, batches)

    def died(self, worker: Worker, batches: Batches) -> None:
        """A process is gone: what it was at is dealt out again, run by run, to find one that kills workers."""
        if worker.ready:
            at = worker.batches.popleft().positions
            said = "the worker process died each time it was at this run (killed, or out of memory)"
            for position in batches.lost(at):
                batches.finish([position], [Outcome({}, 0.0, said, final=False)])
        elif worker.starts >= _STARTS:
            error = worker.hello.exception()
            raise StudyError(f"worker processes end before they can begin ({error}); try --workers 1")
        self.replace(worker, batches, "a worker process died; its runs are done again")

    def stuck(self, worker: Worker, batches: Batches) -> None:
        """A run does not end, not even when interrupted: its process is killed."""
        at = worker.batches.popleft().positions
        if len(at) == 1:
            said = f"time-out: not finished after {self.timeout:g} s, and its process had to be killed"
            batches.finish(at, [Outcome({}, float(self.timeout or 0), said, final=False)])
        batches.lost(at if len(at) > 1 else [])
        self.replace(worker, batches, "a run did not end and could not be interrupted; its process was killed")

    def replace(self, worker: Worker, batches: Batches, why: str) -> None:
        """Start a new process for a worker; the batches it had not begun are dealt out again."""
        for batch in reversed(worker.batches):
            batches.put_back(batch.positions)
        worker.batches.clear()
        worker.kill()
        worker.close()
        self.say(why)
        worker.start()

    def help(self, bench: Bench, positions: list[int], batches: Batches) -> None:
        """Do some runs here, if they are short and of our code, which does not end the process."""
        limit = _STUCK if self.timeout is None else min(_STUCK, self.timeout)
        for rank, position in enumerate(positions):
            if own_policies(bench.model(batches.wanted[position])):
                self.stop_helping(batches, positions[rank:])
                return
            outcome = bench.run(batches.wanted[position], limit)
            stuck = outcome.error is not None and outcome.error.startswith(TIME_OUT)
            if not stuck:
                batches.finish([position], [outcome])
            self.long = self.long + 1 if outcome.run_time > _SHORT else 0
            if stuck or self.long == _LONG:
                self.stop_helping(batches, positions[rank + (not stuck) :])
                return

    def stop_helping(self, batches: Batches, positions: Sequence[int]) -> None:
        """Leave these runs, and all that follow, to the workers; there is one more of them now."""
        batches.put_back(positions)
        self.bench = None
        with self.ctrl_c.held():
            self.workers.append(Worker(self.base, self.timeout))


class _Spawn(SpawnContext):
    """Starts processes afresh and remembers them: one can be killed that has not said hello."""

    def __init__(self) -> None:
        super().__init__()
        self.processes: list[SpawnProcess] = []

    def Process(self, *args: Any, **more: Any) -> SpawnProcess:  # type: ignore[override]  # noqa: N802
        process = SpawnProcess(*args, **more)
        self.processes.append(process)
        return process


_hiding = threading.Lock()


@contextmanager
def _bare_main() -> Iterator[None]:
    """Hide the main module from new processes: they need ours only.

    So they start sooner, and a script that runs a study needs no `if __name__ == "__main__"`. One thread at a time,
    so that it is the main module that comes back.
    """
    with _hiding:
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            yield
        finally:
            sys.modules["__main__"] = main


@contextmanager
def _without_ctrl_c() -> Iterator[None]:
    """New processes inherit that Ctrl-C is not for them; here it is only held up."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # it would let signals through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
