"""Figures that subcommands write."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.errors import ReportError, reason

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure


def save(drawn: Figure | None, folder: Path, name: str) -> None:
    """Write a figure to a folder as PNG and SVG; raises ReportError where that is not possible."""
    assert drawn is not None
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for ending in ("png", "svg"):
            drawn.savefig(folder / f"{name}.{ending}", dpi=150)
    except OSError as error:
        raise ReportError(f"{folder}: the figure cannot be written there ({reason(error)})") from error
