"""Goods to fetch one by one, from a list, drawn or arriving, and how the demand is spread over the storage places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from desim_warehouse.errors import got
from desim_warehouse.layout.layout import StoragePlace
from desim_warehouse.layout.spec import NodeOrStation
from desim_warehouse.values.calendars import CalendarName
from desim_warehouse.values.fields import (
    SECTION,
    Count,
    Duration,
    Forms,
    Integer,
    Name,
    NotNegative,
    Part,
    Quantity,
    Rate,
    Share,
    Time,
    Usual,
    Whole,
    by_type,
    form,
    known,
    limited,
    see_sum,
    see_weights,
    wrong,
)

DUE = Usual("1 s", "7 d")
"""What is sooner than a robot can do it is DUE_TOO_SOON."""
GOODS_FORM = "a list of goods such as [11, 8], or {random: n}, {saturated: n} or {poisson: n per hour}"


class AbcClass(Part):
    """A class of storage places: `share` of all places draw `demand` of all tasks."""

    share: Annotated[float, Field(strict=True, gt=0, le=1), Quantity("share")] = Field(
        title="share of places", description="share of all places"
    )
    demand: Share = Field(title="share of tasks", description="share of all tasks")


class Popularity(Part):
    """How demand is spread over storage places: ABC classes, placed `by` a rule, or a weight for each place."""

    classes: tuple[AbcClass, ...] = Field((), description="A, B, C, ...: shares and demands add up to 1 each")
    by: Literal["number", "distance", "random"] | None = Field(
        None,
        title="where classes lie",
        description="with classes: which places are class A, and so on. number: the first places; distance: those "
        "nearest to a station that loads from storage go to (if none do, to a station that they come from); random: "
        "scattered, the same in all runs. Default: number",
    )
    weights: tuple[NotNegative, ...] = Field((), description="one for each storage place")

    @field_validator("classes")
    @classmethod
    def _sums(cls, classes: tuple[AbcClass, ...]) -> tuple[AbcClass, ...]:
        for name in ("share", "demand") if classes else ():
            see_sum((getattr(item, name) for item in classes), f"{name}s")
        return classes

    @field_validator("weights")
    @classmethod
    def _one_each(cls, weights: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        places = known(info).places
        see_weights(weights, len(weights) if places is None else places, "storage places")
        return weights

    @model_validator(mode="after")
    def _either(self) -> Popularity:
        if bool(self.classes) == bool(self.weights):
            both = "both classes and weights" if self.classes else "neither classes nor weights"
            raise wrong(f"{both}, expected one of the two")
        if self.by is not None and not self.classes:
            raise wrong(f"a weight for each place says where goods lie (got {got(self.by)}), expected classes", "by")
        return self


class WeightsFile(Part):
    """Weights from a column of a CSV file with one row for each storage place, in order of number or of `place`."""

    file: Name = Field(description="CSV file, relative to the model file")
    column: Name = Field("popularity", description="the column with the weights")


def _of_the_layout(popularity: str | Popularity, info: ValidationInfo) -> str | Popularity:
    """Refuse the weights of a layout that has none."""
    if popularity == "layout" and known(info).blocks:
        expected = "'uniform', classes or weights, as blocks say nothing of it"
        raise wrong(f"no popularity in the layout (got 'layout'), expected {expected}")
    return popularity


def only(demand_shares: Any) -> int | None:
    """Return the number of the place that all demand is for, by the shares; None for several, so chance decides."""
    asked_for = [] if demand_shares is None else demand_shares.nonzero()[0].tolist()
    return asked_for[0] if len(asked_for) == 1 else None


def is_drawn(popularity: Popularity | Literal["uniform", "layout"], model: Any) -> bool:
    """Whether chance decides which storage place of a model is asked for; most often known before it is built."""
    if model.layout.storage_places == 1:
        return False
    return popularity == "uniform" or only(shares(popularity, model.floor.storage)) is None


def shares(
    popularity: Popularity | Literal["uniform", "layout"],
    storage: Sequence[StoragePlace],
    order: Sequence[int] | None = None,
) -> Any:
    """Return the share of every storage place in the demand for drawn goods, a numpy array, or None for equal shares.

    Classes and weights need only the number of places, so that this does for items, too.

    `order`: the numbers of the places, the first class's places first; default: as they are numbered.
    """
    import numpy as np

    if popularity == "uniform":
        return None
    if isinstance(popularity, Popularity) and popularity.classes:
        weights = np.empty(len(storage))
        begin, share = 0, 0.0
        for item in popularity.classes:
            share += item.share
            end = round(share * len(storage))
            weights[begin:end] = item.demand / max(end - begin, 1)
            begin = end
        if order is not None:
            placed = np.empty(len(storage))
            placed[list(order)] = weights
            weights = placed
    elif isinstance(popularity, Popularity):
        weights = np.array(popularity.weights, dtype=float)
    else:
        weights = np.array([place.popularity for place in storage])
    return weights / weights.sum()


def _stored(good: int, info: ValidationInfo) -> int:
    """Refuse the number of a storage place that the layout does not have."""
    places = known(info).places
    if places and good >= places:
        expected = f"a number from 0 to {places - 1}" if places > 1 else "0, as there is one storage place"
        raise wrong(f"no such good (got {good}), expected {expected}")
    return good


class Good(Part):
    """A task in the list: the good, when it is released, due, how urgent (higher first), and where it goes."""

    good: Annotated[Whole, AfterValidator(_stored)] = Field(description="number of the storage place")
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
        """Return how many tasks are always open with a fleet of this size."""
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
    hours: CalendarName | None = Field(None, description="a calendar of when tasks arrive; default: at all times")

    def is_random(self, _model: Any) -> bool:
        """Return True: tasks arrive at random."""
        return True


def _goods_form(value: Any) -> str | None:
    if isinstance(value, list | tuple):
        return "\0list"
    for name, kind in (("random", RandomGoods), ("saturated", SaturatedGoods), ("poisson", PoissonGoods)):
        if isinstance(value, kind) or (isinstance(value, Mapping) and name in value):
            return f"\0{name}"
    return None


PopularityRule = Annotated[
    Annotated[Literal["uniform", "layout"], form("rule")] | Annotated[Popularity, form("given")],
    Forms(
        "'uniform', 'layout', or a section with classes, weights or file",
        WeightsFile,
        pick=by_type(rule=str, given=SECTION),
    ),
    AfterValidator(_of_the_layout),
]
"""Which storage places are asked for."""

GoodsRule = Annotated[
    Annotated[
        tuple[
            Annotated[
                Annotated[Whole, AfterValidator(_stored), form("number")] | Annotated[Good, form("task")],
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
