"""The model: what one simulation run is made of, as frozen, checked values."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field

from desim_warehouse.findings import Acceptable  # noqa: TC001 - pydantic reads it
from desim_warehouse.layout.spec import (
    Count,
    FrozenMap,
    Integer,
    LayoutSpec,
    Name,
    Named,
    NotNegative,
    Part,
    Positive,
    Says,
    Text,
    Whole,
    tagged,
)
from desim_warehouse.model.policy import Policies

METRES = {"m": 1.0, "mm": 0.001, "cm": 0.01, "dm": 0.1, "km": 1000.0}
"""Metres in the units of length that are known by name."""


class Units(Part):
    """Names of the units the file is written in, and the seconds in one time unit."""

    length: Name = Field("m", description="name of the length unit")
    time: Name = Field("s", description="name of the time unit")
    seconds: Positive = Field(1.0, description="seconds in one time unit, for reports and hourly rates")

    @property
    def metre(self) -> float | None:
        """Metres in the length unit; None where its name does not say."""
        return METRES.get(self.length)

    @property
    def hour(self) -> float:
        """Time units in an hour."""
        return 3600 / self.seconds


class Robot(Part):
    """A robot's size and speed."""

    radius: Positive = Field(description="half of its diameter")
    speed: Positive = Field(description="length units per time unit")
    margin: NotNegative = Field(0.0, description="added to r_i + r_j: the distance at which robots stop")


class Kind(Part):
    """Some robots of the fleet that differ in size or speed (the first `count`, then the next kind's)."""

    count: Count = Field(description="robots of this kind")
    radius: Positive | None = Field(None, description="default: fleet.robot.radius")
    speed: Positive | None = Field(None, description="default: fleet.robot.speed")


Share = Annotated[float, Field(strict=True, ge=0, le=1)]


class SpreadEnergy(Part):
    """`uniform: [a, b]`: for every robot drawn evenly between two parts of the capacity, by the run's seed."""

    uniform: tuple[Share, Share] = Field(description="the least and the most, parts of the capacity")


def _energy_form(value: Any) -> str:
    return "\0spread" if isinstance(value, Mapping | SpreadEnergy) else "\0number"


class Fleet(Part):
    """The robots and where they start."""

    size: Count = Field(description="number of robots")
    start: tuple[Name, ...] = Field((), description="nodes with bays, dealt out in turn; default: all nodes with bays")
    robot: Robot
    kinds: Named[Kind] = Field(FrozenMap(), description="robots that differ, by the name of their kind")
    first_exit_time: NotNegative = Field(0.0, description="from the start of a run to standing at the start node")
    exit_time: NotNegative = Field(0.0, description="from being sent out of a bay to standing at its node")
    start_energy: Annotated[
        Annotated[Share, tagged("number")] | Annotated[SpreadEnergy, tagged("spread")],
        Discriminator(_energy_form),
        Says("a part of the capacity from 0 to 1, or {uniform: [a, b]}"),
    ] = Field(1.0, description="what the batteries hold at the start, as a part of the capacity")

    def robots(self) -> list[Robot]:
        """Every robot, by number: those of the kinds first, then the ordinary ones."""
        special = [
            Robot(
                radius=kind.radius or self.robot.radius,
                speed=kind.speed or self.robot.speed,
                margin=self.robot.margin,
            )
            for kind in self.kinds.values()
            for _ in range(kind.count)
        ]
        return special + [self.robot] * (self.size - len(special))

    def homes(self, bays: Iterable[str]) -> list[str]:
        """The node beside which every robot starts, by number, given the nodes with bays."""
        start = self.start or tuple(bays)
        return [start[number % len(start)] for number in range(self.size)]

    @property
    def contact(self) -> float:
        """D: the distance that the two largest robots keep."""
        return 2 * max(robot.radius for robot in self.robots()) + self.robot.margin


class Good(Part):
    """A task in the list: the good, and when it is released, due, and how urgent (higher first)."""

    good: Whole = Field(description="number of the storage place")
    release: NotNegative = Field(0.0, description="time at which the task becomes known")
    due: NotNegative | None = Field(None, description="time by which it should be delivered")
    priority: Integer = Field(0, description="higher first")


class RandomGoods(Part):
    """`random: n`: n goods drawn by the run's seed, without repetition while they last."""

    random: Count = Field(description="number of goods")


class SaturatedGoods(Part):
    """`saturated: n`: lifelong; n tasks are always open, a new one is released as one is taken."""

    saturated: Count = Field(description="number of open tasks")
    due_within: Positive | None = Field(None, description="due so long after release")


class PoissonGoods(Part):
    """`poisson: n`: lifelong; tasks arrive at random, n per hour on average."""

    poisson: Positive = Field(description="tasks per hour")
    due_within: Positive | None = Field(None, description="due so long after release")


def _good_form(value: Any) -> str:
    return "\0task" if isinstance(value, Mapping | Good) else "\0number"


def _goods_form(value: Any) -> str | None:
    if isinstance(value, list | tuple):
        return "\0list"
    for form, kind in (("random", RandomGoods), ("saturated", SaturatedGoods), ("poisson", PoissonGoods)):
        if isinstance(value, kind) or (isinstance(value, Mapping) and form in value):
            return f"\0{form}"
    return None


class AbcClass(Part):
    """A class of storage places: `share` of all places draw `demand` of all tasks."""

    share: Annotated[float, Field(strict=True, gt=0, le=1)] = Field(description="part of all places")
    demand: Annotated[float, Field(strict=True, ge=0, le=1)] = Field(description="part of all tasks")


class Popularity(Part):
    """Which storage places are asked for: ABC classes (in order of number), or a weight for each."""

    classes: tuple[AbcClass, ...] = Field((), description="A, B, C, ...: shares and demands add up to 1 each")
    weights: tuple[NotNegative, ...] = Field((), description="one for each storage place")


class WeightsFile(Part):
    """Weights from a column of a CSV file with one row for each storage place, in order of number."""

    file: Name = Field(description="CSV file, relative to the model file")
    column: Name = Field("popularity", description="the column with the weights")


def _popularity_form(value: Any) -> str:
    return "\0given" if isinstance(value, Mapping | Popularity) else "\0rule"


class Tasks(Part):
    """The work: which goods, where they are unloaded, how long handling takes."""

    goods: Annotated[
        Annotated[
            tuple[
                Annotated[
                    Annotated[Whole, tagged("number")] | Annotated[Good, tagged("task")],
                    Discriminator(_good_form),
                    Says("the number of a good, or a section with good, release, due and priority"),
                ],
                ...,
            ],
            Field(min_length=1),
            tagged("list"),
        ]
        | Annotated[RandomGoods, tagged("random")]
        | Annotated[SaturatedGoods, tagged("saturated")]
        | Annotated[PoissonGoods, tagged("poisson")],
        Discriminator(_goods_form),
        Says("a list of goods such as [11, 8], or {random: n}, {saturated: n} or {poisson: n per hour}"),
    ] = Field(description="the goods to fetch, one by one or drawn")
    popularity: Annotated[
        Annotated[Literal["uniform", "layout"], tagged("rule")] | Annotated[Popularity, tagged("given")],
        Discriminator(_popularity_form),
        Says("'uniform', 'layout', or a section with classes, weights or file", WeightsFile),
    ] = Field("uniform", description="for drawn goods: uniform, the layout's popularity column, classes or weights")
    unload_at: tuple[Name, ...] = Field(min_length=1, description="nodes: one for all robots, or one each")
    station_choice: Literal["each", "nearest", "least-loaded", "random"] = Field(
        "each", description="each: one for all or one each; else any of unload_at, chosen for every task"
    )
    load_time: NotNegative = Field(description="at the storage place")
    unload_time: NotNegative = Field(description="at the station")
    clear_time: NotNegative = Field(
        0.0, description="after unloading, before driving on; the next good is given out before it"
    )


class Consumption(Part):
    """Energy per time unit by state."""

    standing: NotNegative = Field(description="waiting or idle")
    empty: NotNegative = Field(description="driving without a good")
    loaded: NotNegative = Field(description="driving with a good")
    handling: NotNegative = Field(description="loading and unloading")


def _consumption_form(value: Any) -> str:
    return "\0states" if isinstance(value, Mapping | Consumption) else "\0number"


class Taper(Part):
    """A charge curve: full rate up to `start`, then falling linearly to `end_rate` when full."""

    start: Annotated[float, Field(strict=True, gt=0, lt=1)] = Field(description="fraction of capacity")
    end_rate: Annotated[float, Field(strict=True, gt=0, lt=1)] = Field(
        0.1, description="fraction of charge_rate at full"
    )


class Battery(Part):
    """The battery of every robot."""

    capacity: Positive = Field(description="energy of a full battery")
    threshold: NotNegative = Field(description="level at which the threshold policy sends a robot home")
    consumption: Annotated[
        Annotated[NotNegative, tagged("number")] | Annotated[Consumption, tagged("states")],
        Discriminator(_consumption_form),
        Says("a number of at least 0, or a section with standing, empty, loaded and handling"),
    ] = Field(description="energy per time unit outside the charging zone")
    charge_rate: Positive = Field(description="energy per time unit at a charger")
    taper: Taper | None = Field(None, description="default: full rate until the battery is full")
    reserve: NotNegative = Field(
        0.0, description="energy below 0 that a robot may still draw; beyond that it is flat, an error"
    )

    @property
    def draws(self) -> Consumption:
        """Energy per time unit in every state, also where the file has one number for all."""
        one = self.consumption
        if isinstance(one, Consumption):
            return one
        return Consumption(standing=one, empty=one, loaded=one, handling=one)


class Traffic(Part):
    """Collision waiting."""

    collision_angle: Annotated[float, Field(strict=True, ge=0, le=90)] = Field(30.0, description="theta, degrees")
    node_time: NotNegative = Field(0.0, description="turning and re-planning at every node reached")
    gridlock: Literal["auto", "rotate", "avoid", "stop"] = Field(
        "auto",
        description="full rings of robots turn (rotate), cannot form (avoid), or are an error (stop); auto: avoid "
        "where a lane is two-way, else rotate",
    )


class Run(Part):
    """How long a run lasts; lifelong demand needs a length."""

    length: Positive | None = Field(None, description="default: until all work is done")
    warm_up: NotNegative = Field(0.0, description="indicators count from here on")


class Cost(Part):
    """Weights of Cost_total = distance x w_d + time x w_t + collisions x w_c (the paper's outlook)."""

    distance: NotNegative = Field(1.0, description="w_d, for each length unit driven")
    time: NotNegative = Field(1.0, description="w_t, for each time unit of T")
    collisions: NotNegative = Field(1.0, description="w_c, for each collision")


class Model(Part):
    """A complete model: everything a run depends on but the seed."""

    name: Text = Field("model", description="a short name, for reports")
    description: Text = Field("", description="a sentence or two")
    units: Units = Units()
    layout: LayoutSpec
    fleet: Fleet
    tasks: Tasks
    battery: Battery | None = Field(None, description="none: robots never need charging")
    traffic: Traffic = Traffic()
    policies: Policies = Policies()
    run: Run = Run()
    cost: Cost = Cost()
    log: Literal["all", "moves", "tasks"] = Field("all", description="how much is recorded")
    accept: tuple[Acceptable, ...] = Field(
        (), description="codes of errors of `desim check` to simulate in spite of; the report says so"
    )

    def content(self) -> dict[str, Any]:
        """Everything in the model, defaults too, as plain JSON values: equal models, equal content.

        Keys of sections stand in the order of the schema; named parts (nodes, bays, stations, kinds) in
        the order of the file, which numbers them. `load` reads it back.
        """
        found: dict[str, Any] = super().content()
        return found

    def digest(self) -> str:
        """The SHA-256 of the content and of the user's own policies: the same for the same model, however written."""
        content = json.dumps(self.content(), separators=(",", ":")).encode()
        return hashlib.sha256(content + self.policies.sources()).hexdigest()

    def replace(self, overrides: Mapping[str, Any]) -> Model:
        """Make a changed copy, checked like a file.

        Args:
            overrides: dotted keys and their values, such as `{"fleet.size": 3}`.

        Raises:
            ModelError: with every problem of the changed model.
        """
        from desim_warehouse.model.reading import changed

        return changed(self, overrides)
