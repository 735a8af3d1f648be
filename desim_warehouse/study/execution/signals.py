"""Handling of Ctrl-C, which ends a study at any point, in every command that does runs."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import NoReturn, Self


def interrupt(number: int, _frame: FrameType | None) -> NoReturn:
    """Raise KeyboardInterrupt as Python's own handler does, with the number of the signal as its argument."""
    raise KeyboardInterrupt(number)


class Interrupts:
    """A context that remembers Ctrl-C, because Python drops exceptions raised while it closes a generator.

    Generators are closed after every run. Only signals that raise KeyboardInterrupt anyway are handled: SIGINT, and
    SIGTERM if its handler is `interrupt`. Both belong to the main thread; a study in another thread handles none. The
    context can be entered several times in turn.
    """

    def __init__(self) -> None:
        self.struck: int | None = None  # the signal
        self.holding = False
        self.handlers: dict[signal.Signals, Callable[[int, FrameType | None], object]] = {}  # that were there before

    def __enter__(self) -> Self:
        self.handlers.clear()
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                handler = signal.getsignal(number)
                if handler is signal.default_int_handler or handler is interrupt:
                    self.handlers[number] = handler
                    signal.signal(number, self._strike)
        self.hook = sys.unraisablehook
        if self.handlers:
            sys.unraisablehook = self._dropped
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self.handlers.items():
            signal.signal(number, handler)
        if sys.unraisablehook == self._dropped:
            sys.unraisablehook = self.hook
        if kind is None:
            self.heed()

    def heed(self) -> None:
        """Raise KeyboardInterrupt if Ctrl-C was pressed."""
        if self.struck is not None:
            raise KeyboardInterrupt(self.struck)

    @contextmanager
    def held(self) -> Iterator[None]:
        """Defer Ctrl-C until `heed`: a half-started process or a half-imported module cannot be repaired."""
        before, self.holding = self.holding, True
        try:
            yield
        finally:
            self.holding = before

    def _dropped(self, what: sys.UnraisableHookArgs) -> None:
        """Remember a Ctrl-C that Python dropped: the study ends after this run."""
        if self.struck is None or what.exc_type is not KeyboardInterrupt:
            self.hook(what)

    def _strike(self, number: int, _frame: FrameType | None) -> None:
        self.struck = number
        if not self.holding:
            raise KeyboardInterrupt(number)
