"""Traffic in a model: collision rule, times at nodes, zones, closures, people in the aisles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator

from desim_warehouse.layout.spec import Aisle, see_node
from desim_warehouse.layout.zones import Members, ZoneSpec
from desim_warehouse.values.calendars import CalendarName
from desim_warehouse.values.distributions import Varying
from desim_warehouse.values.fields import (
    By,
    Count,
    Flag,
    FrozenMap,
    Named,
    Part,
    Rate,
    Speed,
    Time,
    Unit,
    Usual,
    limited,
    wrong,
)


class GiveWay(Part):
    """People step aside for a robot that has waited before their aisle, and for the next when that has waited, too."""

    after: Annotated[Time, Usual("0.5 s", "10 min")] = Field(
        title="wait until people step aside", description="how long a robot waits once both are there"
    )


class PeopleSpec(Part):
    """People who enter aisles, one for each visit: robots are not let in until they have left, but may drive on out.

    A robot that was let in at its stop line before they came may enter later.

    Each visit has its own random stream, so people come at the same times whatever robots do.
    """

    aisles: tuple[Aisle, ...] = Field(
        (),
        description="nodes along each aisle, such as [A, B] for an edge or [A, B, C] for two in a line, in both "
        "directions where there are two; all are equally likely; default: all edges with storage places, in "
        "proportion to demand there",
    )
    per_hour: Annotated[Rate | None, Usual(0, 2000)] = Field(
        None, title="visits", description="visits per hour on average, at random; this or times"
    )
    times: Annotated[tuple[Time, ...], Usual("1 min", instant=True)] = Field(
        (), title="times of visits", description="the times of the run at which people come"
    )
    hours: CalendarName | None = Field(None, description="with per_hour: people come only then; default: always")
    # one pick takes 10 s or more, with the walk into the aisle and out of it
    stay: Annotated[Varying, Usual("10 s", "4 h")] = Field(
        title="length of a visit", description="how long each stays in the aisle"
    )
    give_way: GiveWay | None = Field(
        None, description="they let robots pass; default: robots wait until they have left"
    )

    def is_random(self, model: Any) -> bool:
        """Whether chance decides when people come, into which aisle, or for how long."""
        return self.per_hour is not None or len(self.aisles) != 1 or super().is_random(model)

    @model_validator(mode="after")
    def _when(self) -> PeopleSpec:
        if (self.per_hour is None) == (not self.times):
            both = "neither per_hour nor times" if self.per_hour is None else "both per_hour and times"
            raise wrong(f"{both}, expected one of the two", "per_hour")
        if self.times and self.hours is not None:
            raise wrong("beside times, which say when people come; leave it out", "hours")
        return self


class NodeTraffic(Part):
    """The traffic rules of a single node."""

    time: Annotated[Time | None, Usual(0, "10 min")] = Field(
        None, title="node time", description="time for turning and replanning there; default: traffic.node_time"
    )
    free: Flag = Field(False, description="nobody waits there for another, to try what happens if it is no bottleneck")


class ClosureSpec(Part):
    """A part of the floor that is closed at times: no robot is let in then; one that is in it drives on and out.

    What counts is the claim at the stop line, D before the node: a robot that was let in before it closed may enter
    later, as a rule by seconds, at worst after a repair. All built-in routing policies know the calendars. A robot goes
    round if it would wait for longer than the way round takes. It decides when it sets out, when something closes
    while it is under way, and where it is held up, at most three times on a drive; on two-way lanes only where a
    change is safe. A place is behind a closure if no open way leads there, or, with a routing policy of the user's,
    if the usual way is closed.
    """

    members: Members = Field(
        description="edges as [A, B], in both directions where there are two, and nodes: all edges that lead to them"
    )
    hours: CalendarName = Field(description="when it is closed")
    tasks: Literal["hold", "go"] = Field(
        "hold",
        title="tasks behind a closure",
        description="tasks that no open way leads to: hold: they wait until one opens, and robots on their way to "
        "load turn off at the next node; go: robots are sent anyway, and wait in front of the closure",
    )


class SlowSpec(Part):
    """A part of the floor where robots drive slowly, always or at times.

    Without hours this equals `speed` of the edges, also for routes and estimates. With hours, only `congestion-aware`
    takes the present limit into account.
    """

    members: Members = Field(
        description="edges as [A, B], in both directions where there are two, and nodes: all edges that lead to them"
    )
    speed: Annotated[Speed, Usual("0.05 m/s", "3 m/s")] = Field(
        title="speed limit", description="the speed limit; a robot that is on an edge already keeps its speed there"
    )
    hours: CalendarName | None = Field(None, description="when it holds; default: always")


class TrafficSpec(Part):
    """Collision waiting."""

    collision_angle: Annotated[float, Field(strict=True, ge=0, le=90), Unit("angle")] = Field(
        30.0, description="theta, degrees"
    )
    # Without an acceleration speeds change at once, as in the paper; what that leaves out can be put into `node_time`
    node_time: Annotated[Time, Usual(0, "20 s")] = Field(
        0.0, description="time for turning and replanning at every node reached"
    )
    turn_time: Annotated[Time, Usual(0, "30 s")] = Field(
        0.0, description="time for every 90 degrees that a robot turns on a node, in addition to node_time"
    )
    gridlock: Literal["auto", "rotate", "avoid", "stop"] = Field(
        "auto",
        description="full rings of robots turn (rotate), cannot form (avoid), or are an error (stop); auto: avoid "
        "where a lane is two-way, else rotate",
    )
    most_out: Annotated[Count, limited("robots")] | None = Field(
        None,
        title="robots out at once",
        description="most robots out of their bays for work at once; default: all",
    )
    zones: Named[ZoneSpec] = Field(
        FrozenMap(),
        description="parts of the floor for one robot, or one direction, at a time, by name",
    )
    closures: Named[ClosureSpec] = Field(
        FrozenMap(), description="parts of the floor that are closed at times, by name"
    )
    slow: Annotated[Named[SlowSpec], By("in")] = Field(
        FrozenMap(), description="parts of the floor with a speed limit, always or at times"
    )
    nodes: Annotated[Named[NodeTraffic], By("at")] = Field(FrozenMap(), description="settings of single nodes, by name")

    @field_validator("nodes")
    @classmethod
    def _of_the_layout(cls, nodes: Mapping[str, NodeTraffic], info: ValidationInfo) -> Mapping[str, NodeTraffic]:
        for name in nodes:
            see_node(name, info, name)
        return nodes

    @property
    def node_times(self) -> tuple[tuple[str, float], ...]:
        """Nodes at which robots spend another time than `node_time`, and that time."""
        return tuple((name, node.time) for name, node in self.nodes.items() if node.time is not None)

    @property
    def free_nodes(self) -> frozenset[str]:
        """The nodes marked `free`, at which no robot ever has to wait for another."""
        return frozenset(name for name, node in self.nodes.items() if node.free)
