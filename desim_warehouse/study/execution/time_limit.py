"""A limit on the time that a run may take.

For `--timeout` of `desim run` and of every command that does a study.
"""

from __future__ import annotations

import ctypes
import threading
from contextlib import suppress
from types import TracebackType
from typing import Self

from desim_warehouse.errors import Interruption

_AGAIN = 1.0  # seconds until a run that swallowed its interruption is interrupted again


class TimeOutError(Interruption):
    """Raised in a run that took too long; no `except Exception` of a policy can catch it."""


class TimeLimit:
    """A block that raises TimeOutError in its thread when it takes longer than a number of seconds.

    Unlike signals, it works in any thread and on every system, as a Dask worker needs. Code outside Python is
    interrupted when it returns to Python.
    """

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.thread = threading.get_ident()
        self.over = threading.Event()
        self.raised = False
        self.watcher = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> Self:
        self.watcher.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.over.set()
        self.watcher.join()
        if self.raised:
            with suppress(TimeOutError):
                self._raise()
                while True:  # it arrives here at the latest; Python 3.11 would wait for ever for a withdrawn one
                    pass

    def _watch(self) -> None:
        seconds = self.seconds
        while not self.over.wait(min(seconds, threading.TIMEOUT_MAX)):
            self.raised = True
            self._raise()
            seconds = _AGAIN

    def _raise(self) -> None:
        error = ctypes.py_object(TimeOutError)
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self.thread), error)
