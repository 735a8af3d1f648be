"""What a model says of people in the aisles: pickers, forklift drivers, and others that robots keep away from."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any

from pydantic import AfterValidator, Field, ValidationInfo, model_validator

from desim_warehouse.errors import got
from desim_warehouse.layout.spec import NodeName
from desim_warehouse.values.calendars import CalendarName
from desim_warehouse.values.distributions import Varying
from desim_warehouse.values.fields import Part, Rate, Time, Usual, known, wrong


def _line(nodes: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
    edges = known(info).edges
    if len(nodes) == 1:
        raise wrong(f"one node (got {got(nodes[0])}), expected two or more along an aisle, such as [A, B]")
    for a, b in pairwise(nodes):
        if edges and (a, b) not in edges and (b, a) not in edges:
            raise wrong(f"no edge from one to the next (got {got([a, b])}), expected nodes along edges")
    return nodes


Aisle = Annotated[tuple[NodeName, ...], Field(min_length=1), AfterValidator(_line)]


class GiveWay(Part):
    """People step aside for a robot that has waited before their aisle, and for the next when that has waited, too."""

    after: Annotated[Time, Usual("0.5 s", "10 min")] = Field(
        title="wait until people step aside", description="how long the robot has waited since both are there"
    )


class PeopleSpec(Part):
    """People who come into aisles, each into one: no robot is let in until they have left; one that is in it drives on.

    A robot that was let in at its stop line before they came may enter later.

    Each visit draws what it needs from a random stream of its own, so people come alike whatever robots do.
    """

    aisles: tuple[Aisle, ...] = Field(
        (),
        description="nodes along each aisle, such as [A, B] for an edge or [A, B, C] for two in a line, in both "
        "directions where there are two; a visit is as likely to any; default: all edges with storage places, as "
        "likely as demand there",
    )
    per_hour: Annotated[Rate | None, Usual(0, 2000)] = Field(
        None, title="visits", description="visits an hour, on average, at random; this or times"
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
        """Whether it is left to chance when people come, into which aisle, or for how long."""
        return self.per_hour is not None or len(self.aisles) != 1 or super().is_random(model)

    @model_validator(mode="after")
    def _when(self) -> PeopleSpec:
        if (self.per_hour is None) == (not self.times):
            both = "neither per_hour nor times" if self.per_hour is None else "both per_hour and times"
            raise wrong(f"{both}, expected one of the two", "per_hour")
        if self.times and self.hours is not None:
            raise wrong("beside times, which say when people come; leave it out", "hours")
        return self
