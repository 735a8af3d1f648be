"""How long a lift is taken for its rides: from when a robot has it until the doors have closed behind the robot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import permutations
from statistics import fmean

from desim_warehouse.errors import spoken
from desim_warehouse.layout.layout import Edge, Lift
from desim_warehouse.model.facts.demand import open_share
from desim_warehouse.model.schema import Model
from desim_warehouse.values.distributions import mean_of
from desim_warehouse.values.disturbances import availability


def time_taken(model: Model, lift: Lift, rides: Mapping[Edge, float]) -> float:
    """Work out for how long a lift is taken at the least by so many rides along each way between two of its nodes.

    Its cabin is called from where it was left, and drives empty only as far as more robots ride one way than the other.
    """
    rank = {node: number for number, node in enumerate(lift.nodes)}
    more = [0.0] * len(rank)  # rides up from each floor to the next, less those down
    for (begin, end), count in rides.items():
        for floor in range(*sorted((rank[begin], rank[end]))):
            more[floor] += math.copysign(count, rank[end] - rank[begin])
    empty = lift.ride * math.fsum(map(abs, more))
    opening = math.fsum(count * (lift.doors + lift.carrying(*ride)) for ride, count in rides.items())
    return empty + opening + beside(model, lift, rides)


def with_people(model: Model, lift: Lift) -> float:
    """Return the share of the time for which people have a lift, 1 or more where it cannot carry all of them."""
    if (people := lift.people) is None:
        return 0.0
    call = fmean(map(lift.mean_call, lift.nodes))
    riding = fmean(lift.carrying(*way) for way in permutations(lift.nodes, 2))
    rate = people.per_hour / model.units.hour * open_share(model, people.hours)
    return rate * (call + riding + lift.doors + 2 * mean_of(people.transfer))


def called(names: Sequence[str]) -> str:
    """Write the names of lifts: `lift main`, or `lifts main and main 2`."""
    return f"lift{'s' * (len(names) > 1)} {spoken(names)}"


def left_for_robots(model: Model, lift: Lift) -> float:
    """Return the share of the time in which a lift works and people do not have it."""
    works = 1.0 if lift.outages is None else availability(lift.outages)
    return works * (1 - with_people(model, lift))


def beside(model: Model, lift: Lift, rides: Mapping[Edge, float]) -> float:
    """Return for how long a lift is taken beside waits for the cabin and rides: robots drive in and out of it."""
    own, drive = dict(model.traffic.node_times), 2 * model.fleet.contact / model.fleet.fastest + lift.doors
    stops = {node: own.get(node, model.traffic.node_time) for node in lift.nodes}
    return math.fsum(count * (drive + stops[begin] + stops[end]) for (begin, end), count in rides.items())
