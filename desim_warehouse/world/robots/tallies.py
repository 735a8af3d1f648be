"""Tallies up to an instant, as rows of plain numbers: for each robot, edge, intersection and station.

Traffic is ahead of the clock: a robot that sets out from a stop line has already entered its next lane, and a wait
behind a slower robot is known before it begins. Tallies count only what has happened, so they may be taken at any
instant (the end of the warm-up, the end of a run) and agree with the log. Taking them changes nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from desim_warehouse.world.places.station import Station
from desim_warehouse.world.robots.robot import Robot
from desim_warehouse.world.traffic.intersection import Intersection
from desim_warehouse.world.traffic.lane import Lane
from desim_warehouse.world.traffic.traffic import Traffic

Rows = list[dict[str, Any]]


def tallies(
    robots: Sequence[Robot], traffic: Traffic, stations: Mapping[str, Station], now: float
) -> tuple[Rows, Rows, Rows, Rows]:
    """Return rows of robots, edges, intersections and stations."""
    early: dict[Lane, int] = {}  # robots that will enter a lane
    later: dict[Lane, int] = {}  # episodes that will end
    blocked: dict[Lane | Intersection, float] = {}  # time of waiting to be added to what places have counted
    for body in (robot.body for robot in robots):
        if body.entered_at > now:
            early[body.lane] = early.get(body.lane, 0) + 1
        if body.delay is not None and body.delay.end > now and not body.delay.in_lift:
            lane = body.delay.lane
            later[lane] = later.get(lane, 0) + 1
            blocked[lane] = blocked.get(lane, 0.0) - body.delay_after(now)
        if body.is_waiting and (body.claim is None or body.claim.because is None):
            place = body.lane if body.claim is None else body.claim.node
            blocked[place] = blocked.get(place, 0.0) + (now - body.waiting_since)
    passages = {edge: lane.passages - early.get(lane, 0) for edge, lane in traffic.lanes.items()}
    edges = [
        {
            "edge": ">".join(edge),
            "passages": passages[edge],
            "waits": lane.waits - later.get(lane, 0),
            "blocked": lane.blocked + blocked.get(lane, 0.0),
        }
        for edge, lane in traffic.lanes.items()
    ]
    nodes = [
        {
            "node": "+".join(node.nodes),
            "passages": sum([passages[lane.edge] for lane in node.outs]),
            "waits": node.waits,
            "blocked": node.blocked + blocked.get(node, 0.0),
        }
        for node in dict.fromkeys(traffic.nodes.values())
    ]
    served: dict[Station, float] = {}
    for robot in robots:
        if robot.docked is not None:
            served[robot.docked] = served.get(robot.docked, 0.0) + robot.served_for(now)
    station_rows = [
        {"station": node, "busy": station.busy + served.get(station, 0.0)} for node, station in stations.items()
    ]
    return [robot.tally(now) for robot in robots], edges, nodes, station_rows


def less(rows: Rows, before: Rows) -> Rows:
    """Return rows of tallies minus the tallies of an earlier instant."""
    return [
        {key: value if isinstance(value, str) else value - earlier[key] for key, value in row.items()}
        for row, earlier in zip(rows, before, strict=True)
    ]
