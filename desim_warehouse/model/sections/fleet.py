"""The fleet of a model: kinds of robots, their batteries, where they start and with which charge."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field, ValidationInfo, field_validator, model_validator

from desim_warehouse.errors import got
from desim_warehouse.layout.layout import BayPlaces
from desim_warehouse.layout.spec import (
    EdgeName,
    NodeName,
    NodesOfBays,
    Offset,
    edge_or_node,
)
from desim_warehouse.model.sections.policy import Policy, PolicySpec, in_model_units
from desim_warehouse.policies import catalogue
from desim_warehouse.values.calendars import CalendarName
from desim_warehouse.values.disturbances import BreakdownSpec, DelaySpec
from desim_warehouse.values.fields import (
    NUMBER,
    SECTION,
    Acceleration,
    Count,
    Distance,
    Energy,
    Forms,
    Fraction,
    FrozenMap,
    Length,
    Name,
    Named,
    Part,
    Positive,
    Power,
    Share,
    Speed,
    Time,
    Unit,
    Usual,
    by_type,
    form,
    known,
    limited,
    wrong,
)

LoadTypes = tuple[Name, ...]
Keeps = Literal["distance", "braking"]

GATHERS = Usual("0.05 m/s^2", "5 m/s^2")
BRAKES = Usual("0.05 m/s^2", "10 m/s^2")
"""Loads slip above 1 m/s² or so; 10 is an emergency stop."""

_NO_BRAKES = "braking without a deceleration, so that the braking distance is not known, expected deceleration too"

_NUMBER_OR_SPREAD = by_type(number=(*NUMBER, str), spread=SECTION)


class Consumption(Part):
    """Energy per time unit by state."""

    standing: Power = Field(title="consumption standing", description="waiting or idle")
    empty: Power = Field(title="consumption without a load", description="driving without a load")
    loaded: Power = Field(title="consumption with a load", description="driving with a load")
    handling: Power = Field(title="consumption in handling", description="loading and unloading")


class Taper(Part):
    """A charge curve: full rate up to `start`, then falling linearly to `end_rate` when full."""

    start: Fraction = Field(title="level at which charging slows down", description="fraction of capacity")
    end_rate: Fraction = Field(0.1, title="charge rate when full", description="fraction of charge_rate at full")


class BatterySpec(Part):
    """The battery of every robot."""

    nominal: Annotated[Positive, Unit("energy")] = Field(
        alias="capacity", title="battery capacity", description="energy of a full battery"
    )
    usable: Annotated[Share | None, Field(gt=0)] = Field(
        None,
        title="usable part of the battery",
        description="part of the capacity in use, for aged batteries or if the rest is never drawn; levels refer to "
        "this part; default: all",
    )
    threshold: Energy = Field(
        0.0,
        title="charging threshold",
        description="level at which the threshold policy sends a robot home; that policy needs it, others have their "
        "own levels",
    )
    consumption: Annotated[
        Annotated[Power, form("number")] | Annotated[Consumption, form("states")],
        Forms(
            "a number of at least 0, or a section with standing, empty, loaded and handling",
            pick=by_type(number=NUMBER, states=SECTION),
        ),
    ] = Field(
        description="energy per time unit; nothing is drawn while a battery is charged, or at rest in a bay with a "
        "charger for each slot"
    )
    charge_rate: Annotated[Positive, Unit("power")] = Field(description="energy per time unit at a charger")
    taper: Taper | None = Field(None, description="default: full rate until the battery is full")
    # The paper's program lets batteries fall below 0; beyond the reserve that is an error here, not a statistic
    reserve: Energy = Field(
        0.0,
        title="energy reserve",
        description="energy below 0 that a robot may still draw; beyond that it is flat, an error",
    )

    @field_validator("threshold")
    @classmethod
    def _below_capacity(cls, threshold: float, info: ValidationInfo) -> float:
        usable = info.data.get("usable")
        capacity = info.data.get("nominal", math.inf) * (1.0 if usable is None else usable)
        if threshold >= capacity:
            part = "" if usable is None else "the usable part of "
            expected = f"a level below {part}battery.capacity, {got(capacity)}"
            raise wrong(f"too large (got {got(threshold)}), expected {expected}")
        return threshold

    def content(self) -> Any:
        """Return the section as any other; a threshold that is not given is left out, as a policy may ask for it."""
        content: dict[str, Any] = super().content()
        return (
            content if "threshold" in self.model_fields_set else {k: v for k, v in content.items() if k != "threshold"}
        )

    @property
    def capacity(self) -> float:
        """The energy of a full battery, as far as it is usable."""
        return self.nominal if self.usable is None else self.nominal * self.usable

    @property
    def draws(self) -> Consumption:
        """The energy per time unit in every state, also where the file has one number for all."""
        energy = self.consumption
        if isinstance(energy, Consumption):
            return energy
        return Consumption(standing=energy, empty=energy, loaded=energy, handling=energy)


class RobotSpec(Part):
    """A robot's size and speed."""

    radius: Annotated[Length, Usual("5 cm", "2.5 m")] = Field(description="half of its diameter")
    speed: Speed = Field(description="length units per time unit")
    margin: Annotated[Distance, Usual(0, "2 m")] = Field(
        0.0, description="added to r_i + r_j: the distance at which robots stop"
    )
    speed_loaded: Speed | None = Field(
        None,
        title="speed with a load",
        description="speed from the first load of a task or tour to the end of it; default: speed",
    )
    acceleration: Annotated[Acceleration | None, GATHERS] = Field(
        None,
        description="acceleration, in length units per time unit squared; default: full speed at once",
    )
    deceleration: Annotated[Acceleration | None, BRAKES] = Field(
        None, description="deceleration, in the same unit; default: as it accelerates"
    )
    keeps: Keeps = Field(
        "distance",
        title="distance kept",
        description="distance: D, moving or not, as in the paper; braking: while it drives, also its braking "
        "distance, v^2 / (2 x deceleration), so that it claims intersections that much earlier; it then gains speed "
        "no faster than it brakes",
    )
    capacity: Annotated[Count, limited("loads")] = Field(
        1,
        title="loads carried at once",
        description="loads that it carries at once; more than one needs policies.batching",
    )
    carries: LoadTypes = Field(
        (), title="load types carried", description="load types (of flows) that it carries; default: all"
    )
    breakdowns: BreakdownSpec | None = Field(None, description="none: it never breaks down")
    delays: DelaySpec | None = Field(None, description="none: it loses no time at nodes")

    @property
    def loaded_speed(self) -> float:
        """The speed with a load."""
        return self.speed if self.speed_loaded is None else self.speed_loaded

    @property
    def motion(self) -> tuple[float, float]:
        """The times in which it gathers a unit of speed, and in which it brakes from one: 0 where it does so at once.

        One that keeps its braking distance gathers speed no faster than it brakes. Then the distance to a robot that
        sets off before it grows as fast as its braking distance.
        """
        braking = self.acceleration if self.deceleration is None else self.deceleration
        gathers, brakes = 1 / self.acceleration if self.acceleration else 0.0, 1 / braking if braking else 0.0
        return max(gathers, brakes) if self.keeps == "braking" else gathers, brakes

    @model_validator(mode="after")
    def _brakes(self) -> RobotSpec:
        if self.keeps == "braking" and not self.motion[1]:
            raise wrong(_NO_BRAKES, "keeps")
        return self


class Kind(Part):
    """Robots of the fleet that differ in size, speed or load (the first `count`, then the next kind)."""

    count: Annotated[Count, limited("robots")] = Field(title="number of robots", description="robots of this kind")
    radius: Annotated[Length | None, Usual("5 cm", "2.5 m")] = Field(None, description="default: fleet.robot.radius")
    speed: Speed | None = Field(None, description="default: fleet.robot.speed")
    speed_loaded: Speed | None = Field(
        None,
        title="speed with a load",
        description="default: its own speed, if it has one, else fleet.robot.speed_loaded",
    )
    acceleration: Annotated[Acceleration | None, GATHERS] = Field(None, description="default: fleet.robot.acceleration")
    deceleration: Annotated[Acceleration | None, BRAKES] = Field(
        None,
        description="default: its own acceleration, if it has one, else fleet.robot.deceleration",
    )
    keeps: Keeps | None = Field(None, title="distance kept", description="default: fleet.robot.keeps")
    capacity: Annotated[Count, limited("loads")] | None = Field(
        None, title="loads carried at once", description="default: fleet.robot.capacity"
    )
    carries: LoadTypes | None = Field(None, title="load types carried", description="default: fleet.robot.carries")
    breakdowns: BreakdownSpec | None = Field(None, description="default: fleet.robot.breakdowns")
    delays: DelaySpec | None = Field(None, description="default: fleet.robot.delays")
    hours: CalendarName | None = Field(None, description="default: fleet.hours")
    battery: BatterySpec | None = Field(
        None, description="a battery of its own; all other robots have the model's, which is the default"
    )
    charging: Policy | None = Field(
        None, description="built-in policy that says when its robots charge; default: policies.charging"
    )

    @field_validator("charging")
    @classmethod
    def _of_ours(cls, charging: PolicySpec | None, info: ValidationInfo) -> PolicySpec | None:
        if charging is None:
            return None
        if charging.own:
            cure = "a policy of ours here; your own, as policies.charging, sees the kind of each robot (robot.kind)"
            raise wrong(f"a policy of your own (got {got(charging.name)}), expected {cure}")
        spec = in_model_units(charging, "charging", info)
        for parameter, text in catalogue.problems("charging", spec.name, spec.params):
            raise wrong(text, *([parameter] if parameter else ()))
        return spec


class SpreadEnergy(Part):
    """`uniform: [a, b]`: drawn for every robot between two shares of the capacity, by the run's seed."""

    uniform: tuple[Share, Share] = Field(description="lower and upper end, as shares of the capacity")

    @field_validator("uniform")
    @classmethod
    def _in_order(cls, uniform: tuple[float, float]) -> tuple[float, float]:
        if uniform[0] > uniform[1]:
            raise wrong(f"in the wrong order (got {got(uniform)}), expected the lower end first")
        return uniform

    def is_random(self, model: Any) -> bool:
        """Whether there are batteries, and they hold more or less."""
        return model.battery is not None and self.uniform[0] < self.uniform[1]


def _form_of_energy(value: Any) -> str | None:
    return "\0settled" if value == "settled" else _NUMBER_OR_SPREAD(value)


class OnEdge(Part):
    """Where a robot stands at the start: on an edge, `offset` from the edge's start."""

    edge: EdgeName = Field(description="[from, to]; on a two-way lane, the direction in which it continues")
    offset: Offset = Field(description="distance from the edge's start: at least D, and at least D before its end")


class OnNode(Part):
    """Where a robot stands at the start: on a node."""

    node: NodeName = Field(description="the node")


class Start(NamedTuple):
    """Where a robot is at the start: in a bay at `node`, on the node (`on_lanes`), or on an `edge` that leads there."""

    node: str
    on_lanes: bool = False
    edge: tuple[str, str] | None = None
    offset: float = 0.0


class Fleet(Part):
    """The robots and where they start."""

    size: Annotated[Count, limited("robots")] = Field(title="number of robots", description="number of robots")
    start: NodesOfBays = Field(
        (), description="nodes with bays, or names of bays, assigned round-robin; default: all nodes with bays"
    )
    start_on_lanes: tuple[
        Annotated[
            Annotated[OnEdge, form("edge")] | Annotated[OnNode, form("node")],
            Forms("a section with edge and offset, or with node", pick=edge_or_node),
        ],
        ...,
    ] = Field(
        (),
        description="positions of robots at the start, from robot 0 on; the others start in their bays, and every "
        "robot has a slot in its bay",
    )
    hours: CalendarName | None = Field(
        None,
        description="shifts and breaks (a calendar), outside which robots start no work; default: always at work",
    )
    robot: RobotSpec
    kinds: Named[Kind] = Field(FrozenMap(), description="robots that differ from the others, by name of their kind")
    first_exit_time: Annotated[Time, Usual(0, "10 min")] = Field(
        0.0, description="time from the start of a run until a robot stands at its start node"
    )
    exit_time: Annotated[Time, Usual(0, "10 min")] = Field(
        0.0, description="time from being sent out of a bay until a robot stands at its node"
    )
    start_energy: Annotated[
        Annotated[Share, form("number")]
        | Annotated[SpreadEnergy, form("spread")]
        | Annotated[Literal["settled"], form("settled")],
        Forms("a share of the capacity from 0 to 1, {uniform: [a, b]}, or settled", pick=_form_of_energy),
    ] = Field(
        1.0,
        title="energy at the start",
        description="charge of the batteries at the start, as a share of the capacity; settled: as at some instant "
        "in the long run, with the robots that charge then at the chargers; for work that ends: drawn between the "
        "levels at which charging begins and ends",
    )

    @field_validator("size")
    @classmethod
    def _size(cls, size: int, info: ValidationInfo) -> int:
        known(info).robots, known(info).kinds = size, ()
        return size

    @field_validator("start_on_lanes")
    @classmethod
    def _not_more(cls, places: tuple[Any, ...], info: ValidationInfo) -> tuple[Any, ...]:
        size = info.data.get("size", math.inf)
        if len(places) > size:
            raise wrong(f"{len(places)} places for fleet.size, {size}, expected at most one for each robot")
        return places

    @field_validator("kinds", mode="before")
    @classmethod
    def _names(cls, kinds: Any, info: ValidationInfo) -> Any:
        """Make the names of kinds known even where a kind is wrong, as other sections are not to blame for it."""
        known(info).kinds = tuple(map(str, kinds)) if isinstance(kinds, Mapping) else None
        return kinds

    @field_validator("kinds")
    @classmethod
    def _of_the_fleet(cls, kinds: Mapping[str, Kind], info: ValidationInfo) -> Mapping[str, Kind]:
        left = size = info.data.get("size", math.inf)
        for name, kind in kinds.items():
            if kind.count > left:
                text = f"more robots than are left of fleet.size, {size} (got {kind.count}), expected at most {left}"
                raise wrong(text, name, "count")
            left -= kind.count
        return kinds

    @model_validator(mode="after")
    def _loads(self, info: ValidationInfo) -> Fleet:
        pairs = zip(self.kinds_of_robots(), self.robots(), strict=True)
        known(info).carries = {kind: robot.carries for kind, robot in pairs}
        return self

    def robots(self) -> list[RobotSpec]:
        """Return every robot, by number: robots of the kinds first, then the ordinary ones."""
        of_kinds = {"": self.robot, **{name: self._of(kind) for name, kind in self.kinds.items()}}
        return [of_kinds[kind] for kind in self.kinds_of_robots()]

    def distinct(self) -> list[RobotSpec]:
        """Return the robots that differ: one of each kind, and an ordinary one, if there is one."""
        special = [self._of(kind) for kind in self.kinds.values()]
        return special + [self.robot] * (self.size > sum(kind.count for kind in self.kinds.values()))

    def _of(self, kind: Kind) -> RobotSpec:
        return RobotSpec(
            radius=kind.radius or self.robot.radius,
            speed=kind.speed or self.robot.speed,
            margin=self.robot.margin,
            speed_loaded=kind.speed_loaded or kind.speed or self.robot.speed_loaded,
            acceleration=kind.acceleration or self.robot.acceleration,
            deceleration=kind.deceleration or kind.acceleration or self.robot.deceleration,
            keeps=kind.keeps or self.robot.keeps,
            capacity=kind.capacity or self.robot.capacity,
            carries=self.robot.carries if kind.carries is None else kind.carries,
            breakdowns=kind.breakdowns or self.robot.breakdowns,
            delays=kind.delays or self.robot.delays,
        )

    def kinds_of_robots(self) -> list[str]:
        """Return the kind of every robot, by number, None for ordinary ones."""
        special = [name for name, kind in self.kinds.items() for _ in range(kind.count)]
        return special + [""] * (self.size - len(special))

    def hours_of_robots(self) -> list[str | None]:
        """Return the calendar of every robot, by number, None if it is always at work."""
        of_kinds = {"": self.hours, **{name: kind.hours or self.hours for name, kind in self.kinds.items()}}
        return [of_kinds[kind] for kind in self.kinds_of_robots()]

    @property
    def has_hours(self) -> bool:
        """Whether any robot has a calendar."""
        return any(name is not None for name in self.hours_of_robots())

    def is_random(self, model: Any) -> bool:
        """Whether chance decides anything of the fleet, such as the battery levels at the start."""
        return (model.battery is not None and self.start_energy == "settled") or super().is_random(model)

    def homes(self, bays: Mapping[str, BayPlaces]) -> list[str]:
        """Return the node beside which every robot starts, by number, given the bays by their nodes.

        Kinds with chargers for some kinds alone start there; others only if no bay is left to them.
        """
        start, kinds = self.start or tuple(bays), self.kinds_of_robots()
        reserved = [node for node in start if node in bays and bays[node].kinds]
        if not reserved:
            return [start[number % len(start)] for number in range(self.size)]
        for_all = tuple(node for node in start if node not in reserved) or start
        own = {
            kind: tuple(node for node in reserved if bays[node].charges(kind)) or for_all
            for kind in dict.fromkeys(kinds)
        }
        rank: Counter[str] = Counter()
        homes = []
        for kind in kinds:
            homes.append(own[kind][rank[kind] % len(own[kind])])
            rank[kind] += 1
        return homes

    def starts(self, bays: Mapping[str, BayPlaces]) -> list[Start]:
        """Return where every robot is at the start, by number, given the bays by their nodes."""
        starts = [Start(home) for home in self.homes(bays)]
        for number, place in enumerate(self.start_on_lanes):
            starts[number] = (
                Start(place.node, on_lanes=True)
                if isinstance(place, OnNode)
                else Start(place.edge[1], on_lanes=True, edge=place.edge, offset=place.offset)
            )
        return starts

    @property
    def fastest_empty(self) -> float:
        """The highest speed of any robot without a load."""
        return max(robot.speed for robot in self.distinct())

    @property
    def largest_capacity(self) -> int:
        """The most loads that any robot carries at once."""
        return max(robot.capacity for robot in self.distinct())

    @property
    def fastest(self) -> float:
        """The highest speed of any robot, with a load or without."""
        return max(max(robot.speed, robot.loaded_speed) for robot in self.distinct())

    @property
    def slowness(self) -> float:
        """The most that a stop takes for each unit of speed, beyond a drive at a steady pace: v / 2a + v / 2d."""
        return max(sum(robot.motion) for robot in self.distinct()) / 2

    @property
    def longest_braking(self) -> float:
        """The longest braking distance that any robot keeps; 0 if all keep D alone."""
        keeps = [robot for robot in self.distinct() if robot.keeps == "braking"]
        return max((max(robot.speed, robot.loaded_speed) ** 2 * robot.motion[1] / 2 for robot in keeps), default=0.0)

    @property
    def breaks_down(self) -> bool:
        """Whether any robot breaks down."""
        return any(robot.breakdowns is not None for robot in self.distinct())

    @property
    def contact(self) -> float:
        """D: the distance that the two largest robots keep.

        One D for all: with a distance for each pair a large robot would not fit where a small one stood, and a full
        ring could not turn.
        """
        return 2 * max(robot.radius for robot in self.distinct()) + self.robot.margin
