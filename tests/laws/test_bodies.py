"""Laws of `Body` at the end of every instant of random runs: its place, its reservations, and its queue."""

from itertools import pairwise

import pytest

import desim_warehouse as dw
from desim_warehouse.world import World
from desim_warehouse.world.traffic.intersection import FreeIntersection
from desim_warehouse.world.traffic.rules import EPS
from tests.laws.features import EVERYTHING, ONE_WAY, warehouse
from tests.laws.two_way import KINDS

DAILY, LONG = 3, 6
EVERY_KIND = [
    *((features, ONE_WAY) for features in ("", "wider", "moving", "closures moving", "zones", EVERYTHING)),
    *(("", ground) for ground in KINDS),
]


def instants(world):
    """Run a world, and yield the time after all events of each instant."""
    world.begin()
    queue = world.env._queue
    while not world.over.processed:
        world.env.step()
        if not queue or queue[0][0] > world.env.now:
            yield world.env.now


def place_of(body):
    """Yield the faults of the place of a body."""
    lane, held = body.lane, body.held
    if lane is None:
        if body.ahead or body.behind or (held is None and (body.pos or body.target)):
            yield "is off the lanes, and in a queue or on its way"
        return
    if held is not None and held is not lane.end:
        yield "holds an intersection that is not at the end of its lane"
    if held is not None and not isinstance(held, FreeIntersection) and held.holder is not body:
        yield "holds an intersection that is another's"
    if not 0 <= body.pos <= body.target + EPS <= lane.length + 2 * EPS:
        yield f"is at {body.pos}, bound for {body.target} on a lane of {lane.length}"


def waits_of(body):
    """Yield the faults of the waits and grants of a body."""
    if body.claim is not None and body.waiting_behind is not None:
        yield "waits for an intersection and for a robot"
    if body.claim is not None and body not in [claim.robot for claim in body.claim.node.claims]:
        yield "waits for an intersection that does not know it"
    if body.waiting_behind is not None and (body.lane is None or body.ahead is None):
        yield "waits behind nobody"
    if body.granted is not None and (body.held is None or body.granted.entering is not body):
        yield "has room that is not kept for it"


def queue_of(lane):
    """Yield the faults of the queue of a lane."""
    queue, body = [], lane.last
    while body is not None:
        queue.append(body)
        body = body.ahead
    if queue and queue[0].behind is not None:
        yield "somebody is behind the last robot"
    for behind, ahead in pairwise(queue):
        if ahead.behind is not behind:
            yield "a robot does not know who is behind it"
        # In a turning ring, a robot enters a lane, at 0, before there is room for it.
        if not lane.inside and behind.target - EPS > max(ahead.target - lane.headway, 0.0):
            yield "a robot is bound for less than D behind the one ahead"
    if lane.entering is not None and lane.entering.granted is not lane:
        yield "room is kept for a robot that does not know of it"
    if any(body.lane is not lane for body in queue):
        yield "a robot is in the queue of a lane that it is not on"


def faults(model, seed):
    world = World(model, seed)
    looked_at = 0
    for now in instants(world):
        looked_at += 1
        bodies = [robot.body for robot in world.robots]
        lines = [f"robot {body.number} {fault}" for body in bodies for fault in (*place_of(body), *waits_of(body))]
        lines += [f"{lane.edge}: {fault}" for lane in world.traffic.lanes.values() for fault in queue_of(lane)]
        on_lanes = sum(body.lane is not None for body in bodies)
        queued = 0
        for lane in world.traffic.lanes.values():
            body = lane.last
            while body is not None:
                queued, body = queued + 1, body.ahead
        if queued != on_lanes:
            lines.append(f"{on_lanes} robots are on lanes, {queued} in queues")
        if lines:
            return [f"at {now}: {fault}" for fault in lines]
    assert looked_at > 5
    return []


@pytest.mark.parametrize("count", [DAILY, pytest.param(LONG, marks=pytest.mark.long)])
@pytest.mark.parametrize(("features", "ground"), EVERY_KIND)
def test_a_body_is_in_one_place_and_waits_for_one_thing(features, ground, count):
    numbers = range(count if ground == ONE_WAY else count // 3)
    by_number = {number: faults(dw.load(warehouse(number, features, ground)), number) for number in numbers}
    assert {number: some[:3] for number, some in by_number.items() if some} == {}
