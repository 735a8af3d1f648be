"""The answer to a question: plain data that prints, shows and saves itself.

For what every question returns in Python, and for `--json` of its command.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError

from desim_warehouse.answer.parts import AnswerData
from desim_warehouse.answer.text import printed
from desim_warehouse.errors import ReportError, reason
from desim_warehouse.folders import ANSWER, write_whole

if TYPE_CHECKING:
    import pandas as pd


class Answer(AnswerData):
    """The answer to a question.

    `answer`: sentences, the first of which is the answer. `about`: the design that they are about, None where they name
    none; only then there are `tiles`. `nearest`: for each demand the option that is enough beside that which nearly is.
    `measures`: by what numbers of options are `of`, what people call it. `promise`: what holds with which `confidence`
    (None: nothing is judged). `command`: as it was typed.
    """

    def save(self, folder: str | Path) -> None:
        """Write answer.json, from which `desim report` makes the page."""
        write_whole(Path(folder, ANSWER), self.model_dump_json(indent=1) + "\n")

    def keep(self, folder: str | Path | None, command: str) -> Answer:
        """Return the answer with the command that asked for it, written to the folder of its runs if there is one."""
        answer = self.model_copy(update={"command": command})
        if folder is not None and Path(folder).is_dir():
            answer.save(folder)
        return answer

    @property
    def table(self) -> pd.DataFrame:
        """A row for each option: design, what it sets, each number with the ends of its interval, verdict, runs.

        Ends are named as the number, with `_low` and `_high`; keys have _ instead of dots. Numbers are in the units of
        the model, also where the text has others.
        """
        from desim_warehouse.answer.frame import frame

        return frame(self)

    def __str__(self) -> str:
        return printed(self)

    def __repr__(self) -> str:
        return f"Answer({self.question})"

    def _repr_html_(self) -> str:
        """Show the page, without drawings of a run, in a frame of its own."""
        from desim_warehouse.answer.page import page
        from desim_warehouse.look.web import StillPage

        return StillPage(self.question, page(self))._repr_html_()


class Answering:
    """The value that a question returns: prints as the text of its `answer`, and shows itself as a page in Jupyter.

    `repr` is one line.
    """

    if TYPE_CHECKING:

        @property
        def answer(self) -> Answer:
            """The answer in words."""

    @property
    def table(self) -> pd.DataFrame:
        """A row for each design: see `Answer.table`."""
        return self.answer.table

    def in_short(self) -> str:
        """Return the answer in a few words, for `repr`."""
        return self.answer.name

    def __str__(self) -> str:
        return str(self.answer)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.in_short()})"

    def _repr_html_(self) -> str:
        """Show the page of the answer in a frame."""
        return self.answer._repr_html_()


@dataclass(frozen=True, repr=False)
class Answered(Answering):
    """Data that a question returns, with its answer in words."""

    answer: Answer = field(repr=False, compare=False, kw_only=True)


def load(folder: str | Path) -> Answer:
    """Return the answer in a folder.

    Raises:
        ReportError: where it is damaged, or of another version than this one can read.
    """
    path = Path(folder, ANSWER)
    try:
        return Answer.model_validate_json(path.read_text(encoding="utf-8"))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise ReportError(
            f"{path}: damaged, or made by another version: {where}: {first['msg']}; run the same command again"
        ) from error
    except (OSError, ValueError) as error:
        raise ReportError(f"{path}: damaged ({reason(error)})") from error
