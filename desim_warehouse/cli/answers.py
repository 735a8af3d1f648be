"""The end of every command that asks a question: its answer is saved, and printed as text or JSON."""

from __future__ import annotations

import json
import shlex
import shutil
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TextIO

import click

if TYPE_CHECKING:
    from pathlib import Path

    from desim_warehouse.answer.answer import Answer


_NARROWEST = 60
"""Columns of a terminal below which tables are not made narrower."""


def give(answer: Answer, out: str | Path | None, warnings: Sequence[Any] | None, *, as_json: bool = False) -> Answer:
    """Print an answer, and return it with the command as it was typed, kept in the folder of `--out`."""
    from desim_warehouse.answer.text import printed

    answer = answer if answer.command else keep(answer, out)
    if as_json:
        click.echo(json.dumps(answer.content(warnings=warnings)))
    else:
        click.echo(printed(answer, columns()))
    return answer


def columns() -> int:
    """Width of tables in columns: the terminal's, or the width of texts where the output is no terminal."""
    from desim_warehouse.answer.text import WIDTH

    return max(shutil.get_terminal_size().columns, _NARROWEST) if is_terminal(sys.stdout) else WIDTH


def is_terminal(stream: TextIO | None) -> bool:
    """Whether a stream is a terminal; False for a stream that was closed before the program began."""
    return stream is not None and stream.isatty()


def keep(answer: Answer, out: str | Path | None) -> Answer:
    """Save an answer with the command as typed in a folder, if there is one, and return it with the command."""
    return answer.keep(out, typed())


def typed() -> str:
    """The command as it was typed."""
    arguments: list[str] = click.get_current_context().find_root().meta["desim.typed"]
    return shlex.join(["desim", *arguments])
