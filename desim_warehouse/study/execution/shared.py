"""Base of executors that simulate in other processes: a thread of the executor hands out the runs of all callers.

A worker first gets a single run, then batches that take about a tenth of a second.
"""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Generator, Sequence
from queue import Empty, SimpleQueue

from desim_warehouse.errors import StudyError
from desim_warehouse.model import Model
from desim_warehouse.study.execution.signals import Interrupts
from desim_warehouse.study.execution.work import Handle, Outcome, Wanted

BATCH_TIME = 0.1  # seconds of work in a batch: much longer than handing it over, too short to be missed
_MOST = 200
_TRIES = 3  # workers that a run may kill before it is given up
_DIED = Outcome({}, 0.0, "the worker process died at every attempt at this run (killed, or out of memory)", final=False)
_RECENT = 0.2  # weight of the latest run in the mean time of a run


class Batches:
    """The queue of runs to hand out; runs lost with a worker are handed out one by one.

    Any run of a lost batch may be the one that kills workers. Any thread may add runs; only the thread that hands them
    out may call the other methods.
    """

    def __init__(self) -> None:
        self.waiting: deque[Handle] = deque()
        self.alone: deque[Handle] = deque()
        self.deaths: dict[Handle, int] = {}  # of workers that were alone with a run
        self.out = 0  # runs that are handed out
        self.run_time: float | None = None  # seconds, recent mean

    @property
    def open(self) -> int:
        """The number of runs that are handed out, or still to be."""
        return self.out + len(self.waiting) + len(self.alone)

    def add(self, handle: Handle) -> None:
        """Queue a run."""
        self.waiting.append(handle)

    def take(self, workers: int, seconds: float = BATCH_TIME) -> list[Handle]:
        """Return the next runs, of one base model, for one of `workers` workers; none if all are handed out."""
        while self.alone:
            handle = self.alone.popleft()
            if not handle.ended:
                self.out += 1
                return [handle]
        number = 1
        if self.run_time is not None:
            fair = len(self.waiting) // (2 * workers)  # so that all workers end at about the same time
            number = max(1, min(int(seconds / max(self.run_time, 1e-6)), fair, _MOST))
        batch: list[Handle] = []
        while self.waiting and len(batch) < number:
            if batch and self.waiting[0].base is not batch[0].base:
                break
            handle = self.waiting.popleft()
            if not handle.ended:  # it was cancelled
                batch.append(handle)
        self.out += len(batch)
        return batch

    def finish(self, handles: Sequence[Handle], outcomes: Sequence[Outcome]) -> None:
        """Finish runs with their outcomes; put runs without an outcome, which were not begun, back into the queue."""
        self.out -= len(handles)
        self.waiting.extendleft(reversed(handles[len(outcomes) :]))
        for handle, outcome in zip(handles, outcomes, strict=False):
            if not handle.cancelled:
                before = outcome.run_time if self.run_time is None else self.run_time
                self.run_time = before + _RECENT * (outcome.run_time - before)
            handle.end(outcome)

    def died(self, handles: Sequence[Handle]) -> None:
        """Retry runs during which a worker died; give up a run that, alone, killed several workers."""
        self.out -= len(handles)
        for handle in handles:
            if len(handles) == 1:
                self.deaths[handle] = self.deaths.get(handle, 0) + 1
            if self.deaths.get(handle, 0) < _TRIES:
                self.alone.append(handle)
            else:
                handle.end(_DIED)

    def stuck(self, handles: Sequence[Handle], outcome: Outcome) -> None:
        """Handle a worker stuck at one of these runs: a single run gets this outcome, several are retried singly."""
        self.out -= len(handles)
        if len(handles) == 1:
            handles[0].end(outcome)
        else:
            self.alone.extend(handles)


_POLL = 0.1  # seconds between looks at Ctrl-C, and at what went wrong


class SharedExecutor(ABC):
    """An executor with a thread that works on the queued runs of all callers until `close`; their threads only wait.

    Ctrl-C interrupts the main thread, hence never while a process is started or written to.
    """

    def __init__(self, interrupts: Interrupts) -> None:
        self.interrupts = interrupts
        self.batches = Batches()
        self.to_stop: SimpleQueue[Handle] = SimpleQueue()  # cancelled, and perhaps at work
        self.error: BaseException | None = None
        self.closing = False
        self._thread: threading.Thread | None = None
        self._beginning = threading.Lock()

    def submit(self, base: Model, run: Wanted) -> Handle:
        """Have a run simulated."""
        handle = Handle(base, run, self.stop)
        self.add(handle)
        return handle

    def add(self, handle: Handle) -> None:
        """Queue a run that was submitted to another executor."""
        with self.interrupts.held(), self._beginning:
            if self._thread is None:
                self.connect()
                self._thread = threading.Thread(target=self._work, daemon=True)
                self._thread.start()
        self.batches.add(handle)
        self.wake()

    def stop(self, handle: Handle) -> None:
        """Request that a cancelled run be stopped, without waiting for this."""
        self.to_stop.put(handle)
        self.wake()

    def ended(self, handles: Sequence[Handle]) -> Generator[Handle]:
        """Yield these runs, each as soon as it has ended or was cancelled.

        Raises:
            StudyError: where nothing more can be simulated.
            KeyboardInterrupt: on Ctrl-C.
        """
        queue: SimpleQueue[Handle] = SimpleQueue()
        with self.interrupts.held():
            for handle in handles:
                handle.tell(queue)
            left = len(handles)
            while left:
                self.interrupts.heed()
                try:
                    handle = queue.get(timeout=_POLL)
                except Empty:
                    if self.error is not None:
                        raise self.error from None
                    continue
                left -= 1
                yield handle

    def close(self) -> None:
        """End all processes and connections."""
        with self.interrupts.held():
            self.closing = True
            if self._thread is not None:
                self.wake()
                self._thread.join()

    def _work(self) -> None:
        try:
            while not self.closing:
                self.turn()
        except BaseException as error:  # noqa: BLE001 - those who wait raise it
            self.error = error
        else:
            self.error = StudyError("closed, with runs that had not ended")
        finally:
            self.disconnect()

    # What an executor does

    @abstractmethod
    def connect(self) -> None:
        """Prepare for the first run, in the thread of its caller."""

    @abstractmethod
    def wake(self) -> None:
        """Wake the executor's thread, from any thread, because there is something to do."""

    @abstractmethod
    def turn(self) -> None:
        """Do one round of work: hand out runs, wait for a while, and take the outcomes of finished ones."""

    @abstractmethod
    def disconnect(self) -> None:
        """End all processes and connections."""
