"""People who ride in a lift of a model, beside robots."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from desim_warehouse.values.calendars import CalendarName
from desim_warehouse.values.distributions import Varying
from desim_warehouse.values.fields import Part, Rate, Usual


class RidersSpec(Part):
    """People who ride in a lift at random, each from one of its floors to another, all equally likely.

    People who called the cabin no later than a robot ride first, in the order of their calls.
    """

    per_hour: Annotated[Rate, Usual(0, 400)] = Field(
        title="rides of people", description="rides per hour on average, at random; several cabins share them"
    )
    transfer: Annotated[Varying, Usual("1 s", "2 min")] = Field(
        title="transfer time", description="time the doors stay open for them to get in, and again to get out"
    )
    hours: CalendarName | None = Field(None, description="a calendar of when they ride; default: always")

    def is_random(self, model: Any) -> bool:  # noqa: ARG002 - when they come always is
        """Whether chance decides when people ride, from where to where, or for how long."""
        return True
