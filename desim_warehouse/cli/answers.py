"""Save the answer of a command, and print it as text or JSON."""

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
"""Colours of the words of `answer.standing` for good and bad results; a test checks that the words agree."""
_NARROWEST = 60
"""Least width of tables, in characters."""


def give(answer: Answer, out: str | Path | None, warnings: Sequence[Any] | None, *, as_json: bool = False) -> Answer:
    """Print an answer, save it with the command as typed in the folder of `--out`, and return it."""
    from desim_warehouse.answer.text import printed

    answer = answer if answer.command else keep(answer, out)
    if as_json:
        click.echo(json.dumps(answer.content(warnings=warnings)))
    else:
        say(printed(answer, columns()))
    return answer


def say(text: str) -> None:
    """Print the text of an answer; on a terminal the standings of options are in colour."""
    show(text, standings=COLOURS)


def columns() -> int:
    """Return the width of tables in characters: the terminal's, or a fixed width if the output is not a terminal."""
    from desim_warehouse.answer.text import WIDTH

    return max(shutil.get_terminal_size().columns, _NARROWEST) if is_terminal(sys.stdout) else WIDTH


def keep(answer: Answer, out: str | Path | None) -> Answer:
    """Return an answer with the command as typed, and save it in a folder if this exists."""
    return answer.keep(out, typed())


def typed() -> str:
    """Return the command as it was typed."""
    arguments: list[str] = click.get_current_context().find_root().meta["desim.typed"]
    return shlex.join(["desim", *arguments])
