"""Progress of a study in a terminal or a cell of Jupyter: a bar with the results so far; elsewhere lines.

For every command and Python call that does the runs of a study.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from html import escape
from time import monotonic
from types import TracebackType
from typing import Any, Self, TextIO

from desim_warehouse.errors import number_of


def in_notebook() -> bool:
    """Whether a notebook's kernel runs this program."""
    shell = sys.modules.get("IPython")
    ipython = shell.get_ipython() if shell is not None else None
    return ipython is not None and "IPKernelApp" in ipython.config


class CellBar:
    """The progress bar of a cell; shown when it is made."""

    def __init__(self) -> None:
        from IPython.display import display

        self.done = self.total = 0
        self.lines: tuple[str, ...] = ("",)
        self._shown = display(self, display_id=True)  # type: ignore[no-untyped-call]

    def update(self, done: int, total: int, lines: Sequence[str]) -> None:
        """Show how many runs are done, with some lines of text, in the place of the last update."""
        self.done, self.total, self.lines = done, total, tuple(lines)
        self._shown.update(self)

    def __repr__(self) -> str:
        return "\n".join(self.lines)

    def _repr_html_(self) -> str:
        """The bar is the browser's own, in the colours of the notebook."""
        bar = f'<progress value="{self.done}" max="{max(self.total, 1)}" aria-label="runs"></progress> '
        return f"<div>{bar}{'<br>'.join(map(escape, self.lines))}</div>"


_EVERY = 10.0  # seconds between plain lines
_REFRESH = 0.1


class Progress:
    """A display of the number of finished runs and, except while designs are searched, of the runs left.

    Attributes:
        is_search: whether more runs may be requested later.
        looked: number of designs simulated so far.
    """

    def __init__(self, name: str, *, shown: bool = True, stream: TextIO | None = None) -> None:
        self.name = name
        self.shown = shown
        self.stream = stream or sys.stderr
        self.total = self.done = self.reused = self.failed = self.looked = 0
        self.is_search = False
        self.begin = self.shown_at = monotonic()
        self.results = ""
        self.bar: Any = None
        self.task: Any = None
        self.live: Any = None
        self.cell: CellBar | None = None
        self.below: list[str] = []

    def __enter__(self) -> Self:
        self.begin = self.shown_at = monotonic()
        if self.shown and in_notebook():
            self.cell = CellBar()
        elif self.shown and self.stream.isatty():
            from rich.console import Console, Group
            from rich.live import Live
            from rich.progress import BarColumn, TextColumn
            from rich.progress import Progress as Bar

            self.bar = Bar(TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[text]}"))
            self.live = Live(
                get_renderable=lambda: Group(self.bar, self.results) if self.results else self.bar,
                console=Console(file=self.stream),
                transient=True,
            )
            self.live.start()
            self.task = self.bar.add_task(self.name, total=None, text="")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.live is not None:
            self.live.stop()
            self.bar = self.live = None
        if self.results and kind is not None and issubclass(kind, KeyboardInterrupt):
            self.print(f"known so far: {self.results}")

    @property
    def rate(self) -> float:
        """Runs per second since the study began."""
        return self.done / max(monotonic() - self.begin, 1e-9)

    @property
    def pace(self) -> str:
        """The rate in words, or for slow runs the time per run."""
        if self.rate >= 1:
            return f"{self.rate:,.{0 if self.rate >= 100 else 1}f} runs/s"  # noqa: PLR2004 - three digits count
        return f"{1 / self.rate:,.1f} s a run"

    @property
    def in_words(self) -> str:
        """Return the progress in words: designs that a search has simulated, else the runs and the time left."""
        if self.is_search:
            return f"{number_of(self.looked, 'design')} looked at, {number_of(self.done, 'run')}, {self.pace}"
        left = _time((self.total - self.done) / self.rate)
        return f"{self.done} of {self.total} runs, {self.pace}, {left} left"

    def want(self, wanted: int, reused: int, looked: int = 0) -> None:
        """Count further runs as wanted, and existing runs as reused; `looked`: designs simulated so far."""
        self.total += wanted
        self.reused += reused
        self.looked = looked

    def step(self, *, failed: bool) -> None:
        """Count one more run as finished."""
        self.done += 1
        self.failed += failed
        now = monotonic()
        if not self.shown or now - self.shown_at < (_EVERY if self.bar is None and self.cell is None else _REFRESH):
            return
        self.shown_at = now
        line = f"{self.name}: {self.in_words}"
        if self.bar is not None:
            total = None if self.is_search else self.total
            self.bar.update(self.task, completed=self.done, total=total, text=self.in_words)
        elif self.cell is not None:
            self._show_in_cell(line, *[self.results] * bool(self.results))
        else:
            self.print(line)

    def tell(self, text: str) -> None:
        """Show results so far beside the bar, and again if Ctrl-C ends the runs."""
        self.results = text

    def print(self, text: str) -> None:
        """Print a line of its own, beside the bar."""
        if not self.shown:
            return
        if self.cell is not None:
            self.below.append(text)
            self._show_in_cell()
        elif self.bar is not None:
            self.live.console.print(text, highlight=False, markup=False)
        else:
            self.stream.write(f"{text}\n")
            self.stream.flush()

    def _show_in_cell(self, *lines: str) -> None:
        assert self.cell is not None
        self.cell.update(self.done, self.total, [*lines, *self.below])

    def summary(self) -> str:
        """Return a summary of the runs done."""
        taken = monotonic() - self.begin
        parts = [f"{number_of(self.done, 'run')} in {_time(taken)}" + (f" ({self.pace})" if self.done else "")]
        if self.reused:
            parts.append(f"{self.reused} were there already")
        if self.failed:
            parts.append(f"{self.failed} failed (see the column error)")
        return f"{self.name}: " + ", ".join(parts)


def _time(seconds: float) -> str:
    if seconds < 60:  # noqa: PLR2004 - a minute
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d} h" if hours else f"{minutes}:{rest:02d} min"
