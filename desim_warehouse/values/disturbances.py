"""Disturbances in a model: breakdowns of robots, outages of chargers and lifts, delays at nodes."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, Field

from desim_warehouse.errors import got
from desim_warehouse.values.distributions import Varying, mean_of
from desim_warehouse.values.fields import Part, Share, Usual, wrong


def _not_at_once(time: Varying) -> Varying:
    if not mean_of(time) > 0:
        raise wrong(f"no time at all (got {got(mean_of(time))}), expected a mean above 0")
    return time


Between = Annotated[Varying, AfterValidator(_not_at_once)]
"""A time from one failure to the next: not always 0, or there would be nothing but failures."""


class BreakdownSpec(Part):
    """How often a robot breaks down, and how long it stands until it is repaired.

    A breakdown takes effect where the robot next stops or passes: at the end of its edge, behind the robot ahead, or
    before it sets off from where it loads or unloads. It stands there until it is repaired, and then resumes what it
    was doing. A robot that was cleared once is repaired in its place if it breaks down there again. `congestion-aware`
    routes go round it if the detour takes less than the mean time left until it is repaired or cleared. Tasks that can
    only be reached past it are held back as long as that time exceeds the way there. Charge levels and forecasts do not
    foresee breakdowns: a robot with a small battery may run flat while it waits for a repair, and the error says so.
    """

    # AMRs run for some hundred hours between failures, worn fleets need help several times a shift
    every: Annotated[Between, Usual("30 min", "1000 d")] = Field(
        title="time between breakdowns",
        description="time in operation between breakdowns: driving, loading and unloading, waits not counted",
    )
    repair: Annotated[Varying, Usual("1 min", "3 d")] = Field(
        title="repair time", description="from a breakdown until the robot can go on"
    )
    clear: Annotated[Varying | None, Usual("1 min", "1 d")] = Field(
        None,
        title="time until cleared",
        description="time from a breakdown until the robot is moved off the lanes, where it is in nobody's way until "
        "it is repaired; it returns at the node ahead or, if it still has to stop on its lane, at the node behind, "
        "and drives the lane again; default: it is repaired where it stands",
    )


class OutageSpec(Part):
    """How often a charger or a lift fails, and how long until it is repaired.

    Failures follow the clock, in use or not. A robot at a charger that fails is first in the queue for the next working
    one. A rider in a lift completes the ride.
    """

    every: Annotated[Between, Usual("30 min", "1000 d")] = Field(
        title="time between outages",
        description="from one repair to the next failure of a charger or lift, in use or not",
    )
    repair: Annotated[Varying, Usual("1 min", "30 d")] = Field(
        title="repair time of an outage", description="from a failure of a charger or lift until it is repaired"
    )


def availability(spec: BreakdownSpec | OutageSpec) -> float:
    """Return the share of the time in which what fails now and then works, in the long run: MTBF / (MTBF + MTTR)."""
    every = mean_of(spec.every)
    return every / (every + mean_of(spec.repair))


class DelaySpec(Part):
    """Time that a robot loses at some of the nodes it passes, because it slips, replans, or rereads a mark."""

    share: Share = Field(title="share of nodes with a delay", description="share of the nodes at which it loses time")
    time: Annotated[Varying, Usual("0.1 s", "10 min")] = Field(title="delay at a node", description="time lost there")

    def is_random(self, model: Any) -> bool:
        """Whether chance decides at which nodes time is lost, or how much."""
        return 0 < self.share < 1 or (self.share > 0 and super().is_random(model))
