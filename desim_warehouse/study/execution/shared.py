"""What executors share that simulate in other processes: a thread of their own hands out the runs of all callers."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING

from desim_warehouse.errors import StudyError
from desim_warehouse.study.execution.batches import Batches
from desim_warehouse.study.execution.handle import Handle

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from desim_warehouse.study.execution.signals import Interrupts
    from desim_warehouse.study.execution.work import Wanted

_POLL = 0.1  # seconds between looks at Ctrl-C, and at what went wrong


class SharedExecutor(ABC):
    """Queues the runs of its callers, whose threads only wait. Its own thread works on them until `close`.

    Ctrl-C strikes the main thread, so it never strikes while a process is started or written to.
    """

    def __init__(self, interrupts: Interrupts) -> None:
        self.interrupts = interrupts
        self.batches = Batches()
        self.to_stop: SimpleQueue[Handle] = SimpleQueue()  # cancelled, and perhaps at work
        self.error: BaseException | None = None
        self.closing = False
        self._thread: threading.Thread | None = None
        self._beginning = threading.Lock()

    def submit(self, run: Wanted) -> Handle:
        """Have a run simulated."""
        handle = Handle(run, self.stop)
        self.add(handle)
        return handle

    def add(self, handle: Handle) -> None:
        """Have a run simulated that was submitted elsewhere."""
        with self.interrupts.held(), self._beginning:
            if self._thread is None:
                self.connect()
                self._thread = threading.Thread(target=self._work, daemon=True)
                self._thread.start()
        self.batches.add(handle)
        self.wake()

    def stop(self, handle: Handle) -> None:
        """Stop a run that was cancelled, wherever it is simulated."""
        self.to_stop.put(handle)
        self.wake()

    def ended(self, handles: Sequence[Handle]) -> Generator[Handle]:
        """These runs, each as soon as it has ended or was cancelled.

        Raises:
            StudyError: where nothing can be simulated any more.
            KeyboardInterrupt: on Ctrl-C.
        """
        told: SimpleQueue[Handle] = SimpleQueue()
        with self.interrupts.held():
            for handle in handles:
                handle.tell(told)
            left = len(handles)
            while left:
                self.interrupts.heed()
                try:
                    handle = told.get(timeout=_POLL)
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
        """Before the first run, in the thread of its caller."""

    @abstractmethod
    def wake(self) -> None:
        """There is something to do: from any thread."""

    @abstractmethod
    def turn(self) -> None:
        """Hand out runs, wait for a while, and take what has ended."""

    @abstractmethod
    def disconnect(self) -> None:
        """End all processes and connections."""
