"""Showing text on a terminal: lines folded at its width, verdicts in colour; elsewhere plain."""

from __future__ import annotations

import os
import shutil
import sys
import textwrap
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.answers import is_terminal

if TYPE_CHECKING:
    from collections.abc import Callable

GOOD, DOUBTFUL, BAD = "green", "yellow", "red"
"""Colours of verdicts."""


def is_coloured() -> bool:
    """Whether verdicts are in colour: on a terminal that knows colours, unless NO_COLOR is set (no-color.org)."""
    return is_terminal(sys.stdout) and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def show(text: str, colour: Callable[[str], str] = lambda _: "") -> None:
    """Print text; on a terminal its lines are folded at spaces.

    Args:
        text: lines without colours.
        colour: finds the colour of a line, which holds up to its first colon; "" for none.
    """
    if is_terminal(sys.stdout):
        width = shutil.get_terminal_size().columns
        paint = colour if is_coloured() else lambda _: ""
        text = "\n".join(_folded(line, width, paint(line)) for line in text.splitlines())
    click.echo(text, color=is_terminal(sys.stdout))


def _folded(line: str, width: int, colour: str) -> str:
    """Fold a line into parts of a number of columns, the later parts indented, its head in a colour."""
    parts = [line]
    if len(line) > width:
        indent = line[: len(line) - len(line.lstrip())] + "  "
        parts = textwrap.wrap(line, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    if colour and parts:
        head, colon, rest = parts[0].partition(":")
        parts[0] = f"{click.style(head, fg=colour)}{colon}{rest}"
    return "\n".join(parts)
