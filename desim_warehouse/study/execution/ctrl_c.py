"""Ctrl-C ends a study wherever it strikes."""

from __future__ import annotations

import signal
import sys
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType, TracebackType


class CtrlC:
    """Remembers Ctrl-C: Python drops what is raised while it closes a generator, as it does after every run.

    Only signals that raise KeyboardInterrupt anyway are taken over: SIGINT, and SIGTERM where the command line says
    so. The number of the signal is the argument of the exception.
    """

    def __init__(self) -> None:
        self.struck: int | None = None
        self.ours: list[signal.Signals] = []
        self.holding = False

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            both = (signal.SIGINT, signal.SIGTERM)
            self.ours = [number for number in both if signal.getsignal(number) is signal.default_int_handler]
        for number in self.ours:
            signal.signal(number, self._strike)
        self.hook = sys.unraisablehook
        sys.unraisablehook = self._dropped
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number in self.ours:
            signal.signal(number, signal.default_int_handler)
        if sys.unraisablehook == self._dropped:
            sys.unraisablehook = self.hook
        if kind is None:
            self.heed()

    def heed(self) -> None:
        """Raise KeyboardInterrupt if there was a Ctrl-C."""
        if self.struck is not None:
            raise KeyboardInterrupt(self.struck)

    @contextmanager
    def held(self, holding: bool = True) -> Iterator[None]:
        """Within it Ctrl-C waits for `heed`: locks of other modules stay locked where it strikes at a bad instant."""
        before, self.holding = self.holding, holding
        try:
            yield
        finally:
            self.holding = before

    def _dropped(self, what: sys.UnraisableHookArgs) -> None:
        """Ctrl-C was dropped: nothing to tell, the study ends after this run."""
        if self.struck is None or what.exc_type is not KeyboardInterrupt:
            self.hook(what)

    def _strike(self, number: int, _frame: FrameType | None) -> None:
        self.struck = number
        if not self.holding:
            raise KeyboardInterrupt(number)
