"""Forecasts by free driving, without waits: where and when a busy robot will be free, and its task's remaining need."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.states import STATES, Phase
from desim_warehouse.world.places.stops import driven, handled, time_at
from desim_warehouse.world.robots.reach import loaded_time

if TYPE_CHECKING:
    from desim_warehouse.policies import RobotView
    from desim_warehouse.world.robots.reach import Reach
    from desim_warehouse.world.robots.robot import Robot


def time_to_node(robot: Robot, now: float) -> float:
    """Return the free driving time to the node that a robot comes to next, its node time included."""
    body = robot.body
    if body.lane is None or body.held is not None:
        return 0.0
    if body.stretch is not None:
        return float(max(body.until - now, 0.0) + (body.lane.length - body.target) / body.pace + body.lane.node_time)
    return float((body.lane.length - body.position(now)) / body.pace + body.lane.node_time)


def need_now(robot: Robot, reach: Reach, now: float, charger: str) -> float:
    """Return the energy that a robot on the way to its good still needs for the task and the way to a charger."""
    assert robot.job is not None
    view = robot.view(free_in=time_to_node(robot, now))
    stops = robot.tour.stops
    return reach.need(view, robot.job, stops[-1].node, charger, stops)


def busy_view(robot: Robot, reach: Reach, now: float) -> RobotView:
    """Return a robot at work as policies see it: the node where it will be free, and the time until then."""
    in_hand = robot.job is not None and robot.job.is_tour
    node, time = (_end_of_tour if in_hand else _free_at)(robot, reach, now)
    return robot.view(node=node, free=False, free_in=time)


def _free_at(robot: Robot, reach: Reach, now: float) -> tuple[str, float]:
    speed, job = robot.speed, robot.job
    travel, with_load = reach.travel(speed), reach.travel(robot.loaded_speed)
    ways, time = travel.ways, time_to_node(robot, now)
    if job is None:
        bay = robot.bay.node if robot.bay is not None else robot.home
        return bay, time + ways.time(robot.node, bay)
    since = now - robot.since_state
    station, (load, unload) = robot.tour.stops[-1].node, reach.handling.times(job, robot.tour.stops[-1].node)
    phase = STATES[robot.doing].phase
    if phase is Phase.UNLOADING or (phase is Phase.QUEUE and len(robot.tour.stops) == 1):
        rest = 0.0 if job.drop is None else with_load.along(*job.drop)[1]
        return station, max(unload - (since if phase is Phase.UNLOADING else 0.0), 0.0) + rest
    if phase is Phase.TO_STATION:
        if job.drop is None:
            return station, time + with_load.ways.time(robot.node, station) + unload
        start = with_load.ways.time(robot.node, job.drop[0][0])
        return station, time + start + math.fsum(with_load.along(*job.drop)) + unload
    length = reach.length(job.edge)
    onward = with_load.ways.time(job.edge[1], station) if job.drop is None else loaded_time(with_load, job, station)
    beyond = (length - job.offset) / robot.loaded_speed + onward + unload
    if phase in (Phase.LOADING, Phase.QUEUE):
        return station, max(load - (since if phase is Phase.LOADING else 0.0), 0.0) + beyond
    if robot.body.lane is not None and robot.body.lane.edge == job.edge:
        to_good = max(time - (length - job.offset) / speed, 0.0)
    else:
        to_good = time + ways.time(robot.node, job.edge[0]) + job.offset / speed
    return station, to_good + load + beyond


def _end_of_tour(robot: Robot, reach: Reach, now: float) -> tuple[str, float]:
    """Return the node where the tour in hand ends, and the time until then."""
    travel, stops, handling = reach.travel(robot.speed), robot.tour.stops, reach.handling
    first, length = stops[0], reach.length(stops[0].edge)
    rest, phase = time_at(handling, first), STATES[robot.doing].phase
    if phase in (Phase.LOADING, Phase.UNLOADING):
        rest = max(rest - (now - robot.since_state), 0.0)
    elif phase is not Phase.QUEUE:
        time = time_to_node(robot, now)
        if robot.body.lane is not None and robot.body.lane.edge == first.edge:
            rest += max(time - (length - first.offset) / robot.speed, 0.0)
        else:
            rest += time + travel.ways.time(robot.node, first.edge[0]) + travel.along(first.edge, first.offset)[0]
    return stops[-1].node, float(rest + driven(reach.travel(robot.loaded_speed), stops) + handled(handling, stops[1:]))
