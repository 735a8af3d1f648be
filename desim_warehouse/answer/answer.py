"""The answer to a question: plain data that can be printed, shown and saved.

For the values that questions return in Python, and for `--json` of their commands.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError

from desim_warehouse.answer.parts import AnswerData
from desim_warehouse.answer.text import printed
from desim_warehouse.errors import ReportError, reason
from desim_warehouse.folders import ANSWER, drop_page, write_whole

if TYPE_CHECKING:
    import pandas as pd


class Answer(AnswerData):
    """The answer to a question.

    Attributes:
        answer: sentences, the first of which answers the question.
        options: the designs that were tried.
        measures: titles of the measures of options (`ShownNumber.of`) by name.
        about: the design that the sentences recommend or describe, or None.
        tiles: large numbers of this design; empty if `about` is None.
        nearest: for each demand, a figure of the recommended option beside the option that only just fails.
        promise: the statement that holds with the given `confidence` (None if nothing is judged).
        runs: number of runs.
        command: the command as typed.
    """

    def save(self, folder: str | Path) -> None:
        """Write answer.json, from which `desim report` makes the page, into a folder."""
        text = self.model_dump_json(indent=1) + "\n"
        drop_page(Path(folder), ANSWER, text)
        write_whole(Path(folder, ANSWER), text)

    def keep(self, folder: str | Path | None, command: str) -> Answer:
        """Return the answer with its command, and save it in the folder of its runs if this exists."""
        answer = self.model_copy(update={"command": command})
        if folder is not None and Path(folder).is_dir():
            answer.save(folder)
        return answer

    @property
    def table(self) -> pd.DataFrame:
        """A row for each option: design, its settings, each number with the ends of its interval, verdict, runs.

        Ends have the name of the number with `_low` and `_high`; keys have _ instead of dots. Numbers are in the units
        of the model, even if the text uses other units.
        """
        from desim_warehouse.answer.frame import frame

        return frame(self)

    def __str__(self) -> str:
        return printed(self)

    def __repr__(self) -> str:
        return f"Answer({self.question})"

    def _repr_html_(self) -> str:
        """Return the page, without drawings of a run, in a frame for Jupyter."""
        from desim_warehouse.answer.page import page
        from desim_warehouse.look.web import StillPage

        return StillPage(self.question, page(self))._repr_html_()


class Answering:
    """Base of values that questions return: `print` prints the `answer`, Jupyter shows its page, `repr` is one line."""

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
        """Return the page of the answer in a frame for Jupyter."""
        return self.answer._repr_html_()


@dataclass(frozen=True, repr=False)
class Answered(Answering):
    """Data that a question returns, with its answer in words."""

    answer: Answer = field(repr=False, compare=False, kw_only=True)


def load(folder: str | Path) -> Answer:
    """Load the answer saved in a folder.

    Raises:
        ReportError: it is damaged, or another version wrote it in another format.
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
