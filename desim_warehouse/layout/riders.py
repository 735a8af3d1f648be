"""The section of a lift about people who ride in it besides robots."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from desim_warehouse.values.calendars import CalendarName
from desim_warehouse.values.distributions import Varying
from desim_warehouse.values.fields import Part, Rate, Usual


class RidersSpec(Part):
    """People who ride in a lift at random times, each from one of its floors to another, with equal probabilities.

    People who called the cabin no later than a robot ride first, in the order of their calls.
    """

    per_hour: Annotated[Rate, Usual(0, 400)] = Field(
        title="rides of people", description="rides per hour on average, at random; several cabins share them"
    )
    transfer: Annotated[Varying, Usual("1 s", "2 min")] = Field(
        title="transfer time", description="time the doors stay open for them to get in, and again to get out"
    )
    hours: CalendarName | None = Field(None, description="a calendar of when they ride; default: always")

    def is_random(self, model: Any) -> bool:  # noqa: ARG002 - arrivals are always random
        """Return True: chance decides when people ride, between which floors, and for how long."""
        return True
