"""The parts of an answer as plain data: numbers, options, figures, tables, and the answer that holds them.

All views of an answer are made from these values, so that the terminal (`text`), `--json`, the file answer.json and the
page (`page`) cannot differ. Keys of a single question are added to the common keys.

No command reproduces a single number: `what-if` looks once, but a verdict repeatedly (interim analyses), so that such a
command would print another interval. The original command gives an identical answer from the stored runs.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from desim_warehouse.answer.standing import Standing


class _Plain(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class ShownNumber(_Plain):
    """A mean with the interval of its verdict (None: exact); `text` is its form on the terminal, pages and in files."""

    of: str
    mean: float
    low: float | None = None
    high: float | None = None
    text: str


class Option(_Plain):
    """A design that was tried: a row of the table.

    Attributes:
        name: the design in words.
        standing: its standing with respect to the target or the other options.
        number: its main number, and `also` its further numbers.
        days: the worst of its days, and the number of days that miss the target.
        instead: text instead of a number, such as the deliveries of an option that cannot keep up.
        runs: number of runs.
        cost: annual cost, in the currency of the model.
        p: p-value of a difference.
        group: the demand or indicator of the row, if there are several.
        set: overrides that turn the model into the design.
        same: names of designs with equal runs.
    """

    name: str
    standing: Standing
    number: ShownNumber | None = None
    also: tuple[ShownNumber, ...] = ()
    days: str = ""
    instead: str = ""
    runs: int
    cost: float | None = None
    p: float | None = None
    group: str = ""
    set: dict[str, Any] = {}
    same: tuple[str, ...] = ()

    @property
    def numbers(self) -> tuple[ShownNumber, ...]:
        """All numbers of the option."""
        return (() if self.number is None else (self.number,)) + self.also

    @property
    def text(self) -> str:
        """The option's first number, or the words that replace it."""
        return self.instead or (self.numbers[0].text if self.numbers else "no value")

    @property
    def full_name(self) -> str:
        """The option's name, with the names of options with equal runs."""
        return f"{self.name} (same results: {', '.join(self.same)})" if self.same else self.name


class BigNumber(_Plain):
    """A number shown large on a page (a tile), with its name and a note such as its interval."""

    value: str
    what: str
    note: str = ""


class Bar(_Plain):
    """A row of a figure: an interval, or a bar from 0 if there is only a mean."""

    label: str
    mean: float
    low: float | None = None
    high: float | None = None
    text: str
    standing: str = ""


class Rows(_Plain):
    """A figure of intervals in rows on a common scale, with a line at `at`: a target, or 0 for no effect."""

    title: str
    at: float | None = None
    at_words: str = ""
    rows: tuple[Bar, ...]


class PairGrid(_Plain):
    """A figure of the standings of pairs of counts: a panel for each demand, with rows `down` and columns `across`."""

    title: str
    across: tuple[str, ...]
    down: tuple[str, ...]
    panels: dict[str, tuple[tuple[Standing, ...], ...]]


class Dot(_Plain):
    """An option in a figure of two means; it has a `name` and `standing` only if it stands out."""

    x: float
    y: float
    name: str = ""
    standing: str = ""


class Points(_Plain):
    """A figure of options by two indicators, `across` and `up`, with a line at `at` across: the target.

    `ends`: labels of the least and the largest value on the horizontal axis, then on the vertical axis.
    """

    title: str
    across: str
    up: str
    at: float
    at_words: str
    ends: tuple[str, str, str, str]
    points: tuple[Dot, ...]


class Folded(_Plain):
    """A table that is folded on the page; without a head each row is a name and a fact, or a sentence.

    `printed`: the terminal also prints it, and the page shows it unfolded. `on_sheet`: only the page has it, unfolded
    beside other such tables, as the sheet for printing. `numbers`: all columns but the first hold numbers.
    """

    title: str
    note: str = ""
    printed: bool = False
    on_sheet: bool = False
    numbers: bool = False
    head: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()


class ShownDay(_Plain):
    """A day that a page shows: its seed, and its rank among the days, such as `the worst of 33 days, 94 % on time`."""

    words: str
    seed: int


class Subject(_Plain):
    """The design that a page shows: its name, the content of its model file, and the seed of the run shown.

    `day`: rank of this run among the simulated days; empty for the first day. `worst`: the worst day.
    """

    name: str
    model: dict[str, Any]
    seed: int
    day: str = ""
    worst: ShownDay | None = None


class AnswerData(_Plain):
    """The content of an answer, which `text` and `page` show; see `answer.Answer` for its fields."""

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
    figure: Rows | PairGrid | Points | None = None
    nearest: tuple[Rows, ...] = ()
    about: Subject | None = None
    tables: tuple[Folded, ...] = ()
    promise: str = ""
    notes: tuple[str, ...] = ()
    runs: int
    confidence: float | None
    command: str = ""
    made: dict[str, str] = {}

    def content(self, **more: Any) -> dict[str, Any]:
        """Return the content that `--json` prints: everything but the model."""
        return self.model_dump(mode="json", exclude={"about": {"model"}}) | more

    def groups(self) -> dict[str, list[Option]]:
        """Return the options of each group."""
        groups: dict[str, list[Option]] = {}
        for option in self.options:
            groups.setdefault(option.group, []).append(option)
        return groups
