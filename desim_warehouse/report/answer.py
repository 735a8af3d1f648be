"""The answer to a question as plain data: everything that is shown of it is made of one `Answer`.

The terminal prints it, `--json` and the file answer.json hold it, and `report.answer_page` makes its page, so no two
of them can differ. What one question alone knows stands beside, under keys of its own. Nine composers made answers
before, and contradicted each other: the page of `why` had the numbers of "one charger more", that of `plan` the
bottleneck of a rejected fleet, and a mean had the interval of its verdict in one place and the usual one in another.

No command stands beside each number: `what-if` looks once and a verdict at several looks, so the command that should
show a number again would print another interval. The command as it was typed gives the same answer from the same
runs.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from desim_warehouse.errors import ReportError, reason
from desim_warehouse.report.text.standing import Standing
from desim_warehouse.run.folder import ANSWER, write_whole

if TYPE_CHECKING:
    T = TypeVar("T")


class _Plain(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class SaidNumber(_Plain):
    """A mean with its one interval, that of the verdict on it (None: exact); `text` is how everybody prints it."""

    of: str
    mean: float
    low: float | None = None
    high: float | None = None
    text: str


class Option(_Plain):
    """What was tried, one row; `same` are others whose runs are equal to these.

    `also`: further numbers of it. `said`: instead of a number, such as what an option delivers that cannot keep up.
    `set`: what makes the model into it. `group`: for which demand, or in which indicator, where there are several.
    `cost`: a year, in the currency of the model. `p`: of a difference.
    """

    name: str
    standing: Standing
    number: SaidNumber | None = None
    also: tuple[SaidNumber, ...] = ()
    said: str = ""
    runs: int
    cost: float | None = None
    p: float | None = None
    group: str = ""
    set: dict[str, Any] = {}
    same: tuple[str, ...] = ()

    @property
    def numbers(self) -> tuple[SaidNumber, ...]:
        """All of its numbers."""
        return (() if self.number is None else (self.number,)) + self.also

    @property
    def text(self) -> str:
        """Its first number, or what is said instead."""
        return self.said or (self.numbers[0].text if self.numbers else "no value")

    @property
    def full_name(self) -> str:
        """Its name, with those of the options that are the same."""
        return f"{self.name} (the same: {', '.join(self.same)})" if self.same else self.name


class BigNumber(_Plain):
    """A large number, what it is, and a note such as its interval."""

    value: str
    what: str
    note: str = ""


class Bar(_Plain):
    """A row of a figure: an interval, or a bar from 0 where there is only a mean."""

    label: str
    mean: float
    low: float | None = None
    high: float | None = None
    text: str
    standing: str = ""


class Rows(_Plain):
    """Intervals below one another on one scale, with a line at `at`: a target, or 0 for no effect."""

    title: str
    at: float | None = None
    at_words: str = ""
    rows: tuple[Bar, ...]


class PairGrid(_Plain):
    """Which pairs of two counts are enough: a panel for each demand, a row for each count of `down`."""

    title: str
    across: tuple[str, ...]
    down: tuple[str, ...]
    panels: dict[str, tuple[tuple[Standing, ...], ...]]


class Folded(_Plain):
    """A table that is folded away on the page; `printed`: the terminal has it, too."""

    title: str
    note: str = ""
    printed: bool = False
    head: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()


class Subject(_Plain):
    """The one design that a page shows: its name, its model as a file has it, and the seed of the run shown."""

    name: str
    model: dict[str, Any]
    seed: int


class Answer(_Plain):
    """The answer to a question.

    `answer`: sentences, the first of which is the answer. `about`: the design that they are about, None where they name
    none; only then there are `tiles`. `measures`: by what numbers of options are `of`, what people call it. `promise`:
    what holds with which `confidence` (None: nothing is judged). `command`: as it was typed.
    """

    model_config = ConfigDict(frozen=True, extra="allow")

    format: Literal[1] = 1
    kind: str
    name: str
    description: str = ""
    question: str
    answer: tuple[str, ...]
    tiles: tuple[BigNumber, ...] = ()
    measures: dict[str, str] = {}
    options: tuple[Option, ...] = ()
    figure: Rows | PairGrid | None = None
    about: Subject | None = None
    tables: tuple[Folded, ...] = ()
    promise: str = ""
    notes: tuple[str, ...] = ()
    runs: int
    confidence: float | None
    command: str = ""
    made: dict[str, str] = {}

    def content(self, **more: Any) -> dict[str, Any]:
        """What `--json` prints: all but the model itself."""
        return self.model_dump(mode="json", exclude={"about": {"model"}}) | more

    def groups(self) -> dict[str, list[Option]]:
        """The options of each group."""
        found: dict[str, list[Option]] = {}
        for option in self.options:
            found.setdefault(option.group, []).append(option)
        return found

    def save(self, folder: str | Path) -> None:
        """Write answer.json, from which `desim report` makes the page."""
        write_whole(Path(folder, ANSWER), self.model_dump_json(indent=1) + "\n")

    def __str__(self) -> str:
        from desim_warehouse.report.text.printed import printed

        return printed(self)

    def _repr_html_(self) -> str:
        """The page without the run, in a frame of its own."""
        from desim_warehouse.report.answer_page import page
        from desim_warehouse.report.web import StillPage

        return StillPage(self.question, page(self, run=None))._repr_html_()


def load(folder: str | Path) -> Answer:
    """The answer in a folder.

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


def merged(options: Sequence[T], runs: Callable[[T], Hashable]) -> list[tuple[T, list[T]]]:
    """Options whose `runs` are equal together: the first of them, and the others."""
    found: dict[Hashable, tuple[T, list[T]]] = {}
    for option in options:
        key = runs(option)
        if key in found:
            found[key][1].append(option)
        else:
            found[key] = option, []
    return list(found.values())
