"""Goods to fetch, one by one: a list, drawn once, always some open, or arriving at random."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationInfo, field_validator

from desim_warehouse.errors import got
from desim_warehouse.layout.spec import NodeOrStation
from desim_warehouse.model.sections.popularity import is_drawn
from desim_warehouse.values.calendars import CalendarName
from desim_warehouse.values.fields import (
    SECTION,
    Count,
    Duration,
    Forms,
    Integer,
    Part,
    Rate,
    Time,
    Usual,
    Whole,
    by_type,
    form,
    known,
    limited,
    wrong,
)


def _stored(good: int, info: ValidationInfo) -> int:
    """Refuse the number of a storage place that the layout does not have."""
    places = known(info).places
    if places and good >= places:
        expected = f"a number from 0 to {places - 1}" if places > 1 else "0, as there is one storage place"
        raise wrong(f"no such good (got {good}), expected {expected}")
    return good


GoodNumber = Annotated[Whole, AfterValidator(_stored)]


class Good(Part):
    """A task in the list: the good, when it is released, due, how urgent (higher first), and where it goes."""

    good: GoodNumber = Field(description="number of the storage place")
    release: Time = Field(0.0, title="release time", description="time at which the task becomes known")
    due: Time | None = Field(None, title="due time", description="time by which it should be delivered")
    priority: Integer = Field(0, description="higher first")
    to: NodeOrStation | None = Field(
        None,
        description="where it is unloaded, a node or the name of a station; default: by unload_at",
    )

    @field_validator("due")
    @classmethod
    def _after_release(cls, due: float | None, info: ValidationInfo) -> float | None:
        release = info.data.get("release", 0.0)
        if due is not None and due < release:
            expected = f"a time not before its release at {got(release)}"
            raise wrong(f"due before it is known (got {got(due)}), expected {expected}")
        return due


class RandomGoods(Part):
    """`random: n`: n goods drawn by the run's seed, without repetition while they last."""

    random: Annotated[Count, limited("tasks")] = Field(title="goods", description="number of goods")

    def is_random(self, model: Any) -> bool:
        """Whether there is more than one place to draw."""
        return is_drawn(model.tasks.popularity, model)


def _open_form(value: Any) -> str:
    return "\0fleet" if value == "fleet" else "\0number"


DUE = Usual("1 s", "7 d")
"""What is sooner than a robot can do it is DUE_TOO_SOON."""


class SaturatedGoods(Part):
    """`saturated: n`: lifelong; n tasks are always open, a new one is released as one is taken."""

    saturated: Annotated[
        Annotated[Count, limited("open"), form("number")] | Annotated[Literal["fleet"], form("fleet")],
        Forms("a whole number, or fleet", pick=_open_form),
    ] = Field(title="open tasks", description="number of open tasks; fleet: as many as there are robots")
    due_within: Annotated[Duration | None, DUE] = Field(
        None, title="time until due", description="time from release to due"
    )

    def open(self, robots: int) -> int:
        """How many tasks are always open with a fleet of this size."""
        return robots if self.saturated == "fleet" else self.saturated

    def is_random(self, model: Any) -> bool:
        """Whether there is more than one place to draw."""
        return is_drawn(model.tasks.popularity, model)


class PoissonGoods(Part):
    """`poisson: n`: lifelong; tasks arrive at random, n per hour on average."""

    poisson: Annotated[Rate, limited("hourly")] = Field(title="tasks", description="tasks per hour")
    due_within: Annotated[Duration | None, DUE] = Field(
        None, title="time until due", description="time from release to due"
    )
    hours: CalendarName | None = Field(
        None, description="hours, a calendar: tasks arrive only then; default: at all times"
    )

    def is_random(self, _model: Any) -> bool:
        """They arrive at random."""
        return True


def _goods_form(value: Any) -> str | None:
    if isinstance(value, list | tuple):
        return "\0list"
    for name, kind in (("random", RandomGoods), ("saturated", SaturatedGoods), ("poisson", PoissonGoods)):
        if isinstance(value, kind) or (isinstance(value, Mapping) and name in value):
            return f"\0{name}"
    return None


GOODS_FORM = "a list of goods such as [11, 8], or {random: n}, {saturated: n} or {poisson: n per hour}"


GoodsRule = Annotated[
    Annotated[
        tuple[
            Annotated[
                Annotated[GoodNumber, form("number")] | Annotated[Good, form("task")],
                Forms(
                    "the number of a good, or a section with good, release, due, priority and to",
                    pick=by_type(number=int, task=SECTION),
                ),
            ],
            ...,
        ],
        Field(min_length=1),
        form("list"),
    ]
    | Annotated[RandomGoods, form("random")]
    | Annotated[SaturatedGoods, form("saturated")]
    | Annotated[PoissonGoods, form("poisson")],
    Forms(GOODS_FORM, pick=_goods_form),
]
"""The goods to fetch: a list, drawn once, always some open, or arriving at random."""
