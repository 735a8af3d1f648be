"""Print text on a terminal with lines folded at its width and verdicts in colour; elsewhere as plain text."""

from __future__ import annotations

import os
import re
import shutil
import sys
import textwrap
from collections.abc import Callable, Mapping
from typing import TextIO

import click

GOOD, DOUBTFUL, BAD = "green", "yellow", "red"
"""Colours of verdicts."""


def is_terminal(stream: TextIO | None) -> bool:
    """Whether a stream is a terminal; False for a stream that was closed before the program began (None)."""
    return stream is not None and stream.isatty()


def is_coloured() -> bool:
    """Whether verdicts are in colour: on a terminal with colours, unless NO_COLOR is set (no-color.org)."""
    return is_terminal(sys.stdout) and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def show(text: str, colour: Callable[[str], str] = lambda _: "", standings: Mapping[str, str] | None = None) -> None:
    """Print text; on a terminal its lines are folded at spaces.

    Args:
        text: lines without colours.
        colour: returns the colour of a line, applied up to its first colon; "" for none.
        standings: colours of words that are cells of a table, or the end of a sentence.
    """
    if is_terminal(sys.stdout):
        width = shutil.get_terminal_size().columns
        paint = colour if is_coloured() else lambda _: ""
        text = "\n".join(_folded(line, width, paint(line)) for line in text.splitlines())
        if standings and is_coloured():
            listed = "|".join(sorted(map(re.escape, standings), key=len, reverse=True))
            cells = re.compile(rf"(?<=  )({listed})(?=  |$)|(?<=, )({listed})(?=\.$)", re.MULTILINE)
            text = cells.sub(lambda word: click.style(word[0], fg=standings[word[0]]), text)
    click.echo(text, color=is_terminal(sys.stdout))


def _folded(line: str, width: int, colour: str) -> str:
    """Fold a line into lines of at most `width` characters, indented after the first, with its label in a colour."""
    parts = [line]
    if len(line) > width:
        indent = line[: len(line) - len(line.lstrip())] + "  "
        parts = textwrap.wrap(line, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    if colour and parts:
        head, colon, rest = parts[0].partition(":")
        parts[0] = f"{click.style(head, fg=colour)}{colon}{rest}"
    return "\n".join(parts)
