"""What a study shows in a cell of Jupyter: one bar that changes in place, and what was said below it."""

from __future__ import annotations

import sys
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence


def in_notebook() -> bool:
    """Whether a notebook's kernel runs this program."""
    shell = sys.modules.get("IPython")
    found = shell.get_ipython() if shell is not None else None
    return found is not None and "IPKernelApp" in found.config


class CellBar:
    """The bar; shown when it is made."""

    def __init__(self) -> None:
        from IPython.display import display

        self.done = self.total = 0
        self.lines: tuple[str, ...] = ("",)
        self._shown = display(self, display_id=True)  # type: ignore[no-untyped-call]

    def update(self, done: int, total: int, lines: Sequence[str]) -> None:
        """Show how many runs are done, with some lines of text, in the place of what was shown."""
        self.done, self.total, self.lines = done, total, tuple(lines)
        self._shown.update(self)

    def __repr__(self) -> str:
        return "\n".join(self.lines)

    def _repr_html_(self) -> str:
        """The bar is the browser's own, in the colours of the notebook."""
        bar = f'<progress value="{self.done}" max="{max(self.total, 1)}" aria-label="runs"></progress> '
        return f"<div>{bar}{'<br>'.join(map(escape, self.lines))}</div>"
