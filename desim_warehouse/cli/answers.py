"""The end of every command that asks a question: its answer is saved, and printed as text or JSON."""

from __future__ import annotations

import json
import shlex
import shutil
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.terminal import BAD, DOUBTFUL, GOOD, is_terminal, show

if TYPE_CHECKING:
    from pathlib import Path

    from desim_warehouse.answer.answer import Answer

COLOURS = {
    **dict.fromkeys(("met", "best", "helps most"), GOOD),
    **dict.fromkeys(("needs more runs", "on the edge"), DOUBTFUL),
    **dict.fromkeys(("not met", "cannot keep up", "cannot last", "runs fail", "worse"), BAD),
}
"""The colours of the words of `answer.standing` that are good or bad news; a test holds them together."""
_NARROWEST = 60
"""Columns of a terminal below which tables are not made narrower."""


def give(answer: Answer, out: str | Path | None, warnings: Sequence[Any] | None, *, as_json: bool = False) -> Answer:
    """Print an answer, and return it with the command as it was typed, kept in the folder of `--out`."""
    from desim_warehouse.answer.text import printed

    answer = answer if answer.command else keep(answer, out)
    if as_json:
        click.echo(json.dumps(answer.content(warnings=warnings)))
    else:
        say(printed(answer, columns()))
    return answer


def say(text: str) -> None:
    """Print the text of an answer; on a terminal what options were shown to be is in colour."""
    show(text, standings=COLOURS)


def columns() -> int:
    """Width of tables in columns: the terminal's, or the width of texts where the output is no terminal."""
    from desim_warehouse.answer.text import WIDTH

    return max(shutil.get_terminal_size().columns, _NARROWEST) if is_terminal(sys.stdout) else WIDTH


def keep(answer: Answer, out: str | Path | None) -> Answer:
    """Save an answer with the command as typed in a folder, if there is one, and return it with the command."""
    return answer.keep(out, typed())


def typed() -> str:
    """Return the command as it was typed."""
    arguments: list[str] = click.get_current_context().find_root().meta["desim.typed"]
    return shlex.join(["desim", *arguments])
