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

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from desim_warehouse.answer.numbers import capital, number, p_value
from desim_warehouse.answer.standing import WORDS, Standing
from desim_warehouse.errors import ReportError, number_of, reason
from desim_warehouse.folders import ANSWER, write_whole
from desim_warehouse.look.web import page_of

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

    def keep(self, folder: str | Path | None) -> Answer:
        """Write answer.json where a search has its folder, and return the answer; None: the search has no folder."""
        if folder is not None and Path(folder).is_dir():
            self.save(folder)
        return self

    def __str__(self) -> str:
        return printed(self)

    def _repr_html_(self) -> str:
        """The page without the run, in a frame of its own."""
        return page_of(self)._repr_html_()


@dataclass(frozen=True)
class Answered:
    """Data that a question returns, with its answer in words, which Jupyter shows."""

    answer: Answer = field(repr=False, compare=False, kw_only=True)

    def _repr_html_(self) -> str:
        """Show the page of the answer in a frame."""
        return self.answer._repr_html_()


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


WIDTH = 100
"""Columns where the output is no terminal."""
_NAME = 28
"""The fewest columns of the names of options, as far as they are so long."""
_GAP = 2


def printed(answer: Answer, width: int = WIDTH) -> str:
    """The lines of an answer in so many columns."""
    parts = ["\n".join(answer.answer)]
    parts += [_printed_table(one.title, one.head, one.rows, width) for one in answer.tables if one.printed]
    for group, options in answer.groups().items():
        parts += _tables(capital(group), answer.measures, options, width)
    return "\n\n".join([*parts, "\n".join([*answer.notes, how_sure(answer)])])


def how_sure(answer: Answer) -> str:
    """What holds with which confidence, and of how many runs."""
    runs = f"{number_of(answer.runs, 'run')}." if answer.runs else ""
    return f"{answer.promise} {runs}".strip()


def table(measures: Mapping[str, str], options: Sequence[Option]) -> tuple[list[str], list[list[str]]]:
    """The head and the rows of a table of options: name, a column for each measure, and what is known besides.

    What is said instead of a number stands in the first of these columns. What no option has, has no column.
    """
    shown = [of for of in measures if any(number.of == of for one in options for number in one.numbers)]
    shown = shown or list(measures)[:1]
    rows = [[one.full_name, *_cells(one, shown)] for one in options]
    heads = ["option", *(measures[of] for of in shown)]
    more: list[tuple[str, list[str]]] = [
        ("", [WORDS[one.standing] for one in options]),
        ("p", [p_value(one.p) if one.p is not None else "" for one in options]),
        ("runs", [number(one.runs) for one in options]),
        ("a year", ["" if one.cost is None else number(one.cost) for one in options]),
    ]
    for head, column in more:
        if any(column):
            heads.append(head)
            rows = [[*row, cell] for row, cell in zip(rows, column, strict=True)]
    return heads, rows


def _cells(one: Option, shown: Sequence[str]) -> list[str]:
    found = {number.of: number.text for number in one.numbers}
    first = one.said or (found.get(shown[0], "") if shown else one.text)
    return [first, *(found.get(of, "") for of in shown[1:])]


def _tables(title: str, measures: Mapping[str, str], options: Sequence[Option], width: int) -> Iterator[str]:
    """A table, or where not all measures fit beside one another, one below the other."""
    fit = _that_fit(measures, options, width)
    first = dict(list(measures.items())[:fit])
    yield _printed_table(title, *table(first, options), width)
    rest = {of: name for of, name in measures.items() if of not in first}
    bare = [one.model_copy(update={"said": "", "same": (), "number": None}) for one in options if one.also]
    while rest and bare:
        fit = _that_fit(rest, bare, width)
        heads, rows = table(dict(list(rest.items())[:fit]), bare)
        yield _printed_table("", heads[: fit + 1], [row[: fit + 1] for row in rows], width)
        rest = dict(list(rest.items())[fit:])


def _that_fit(measures: Mapping[str, str], options: Sequence[Option], width: int) -> int:
    """How many measures fit, at least one."""
    for many in range(len(measures), 1, -1):
        heads, rows = table(dict(list(measures.items())[:many]), options)
        widths = [max(map(len, column)) + _GAP for column in zip(heads, *rows, strict=True)]
        if min(widths[0], _NAME) + sum(widths[1:]) <= width:
            return many
    return 1


def _printed_table(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> str:
    from rich.console import Console
    from rich.table import Table

    made = Table(box=None, pad_edge=False, padding=(0, _GAP, 0, 0))
    for head in heads:
        made.add_column(head, justify="right" if head in {"p", "runs", "a year"} else "left")
    for row in rows:
        made.add_row(*row)
    stream = StringIO()
    Console(file=stream, width=width, highlight=False, markup=False).print(made)
    lines = [line.rstrip() for line in stream.getvalue().splitlines()]
    return "\n".join([title, *lines] if title else lines)
