"""What has happened up to an instant, as rows of plain numbers: for each robot, edge and intersection.

Traffic is ahead of the clock: a robot that sets out from a stop line has entered its next lane already, and a wait
behind a slower robot is known before it begins. Here both count only as far as they have come to pass, so that tallies
may be taken at any instant (the end of the warm-up, the end of a run) and agree with the log. Nothing is changed by it.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.world.robot import Robot
    from desim_warehouse.world.traffic import Traffic

Rows = list[dict[str, Any]]


def tallies(robots: Sequence[Robot], traffic: Traffic, now: float) -> tuple[Rows, Rows, Rows]:
    """Rows of robots, edges and intersections."""
    early: Counter[Any] = Counter()  # robots that will enter a lane
    later: Counter[Any] = Counter()  # episodes that will end
    blocked: defaultdict[Any, float] = defaultdict(float)  # time of waiting to be added to what places have counted
    for body in (robot.body for robot in robots):
        if body.entered_at > now:
            early[body.lane] += 1
        if body.delay is not None and body.delay.end > now:
            later[body.delay.lane] += 1
            blocked[body.delay.lane] -= body.delay_after(now)
        if body.is_waiting:
            blocked[body.lane if body.claim is None else body.claim.node] += now - body.waiting_since
    edges = [
        {
            "edge": ">".join(edge),
            "passages": lane.passages - early[lane],
            "waits": lane.waits - later[lane],
            "blocked": lane.blocked + blocked[lane],
        }
        for edge, lane in traffic.lanes.items()
    ]
    nodes = [
        {
            "node": "+".join(node.nodes),
            "passages": node.passages - sum(early[lane] for lane in node.outs),
            "waits": node.waits,
            "blocked": node.blocked + blocked[node],
        }
        for node in dict.fromkeys(traffic.nodes.values())
    ]
    return [robot.tally(now) for robot in robots], edges, nodes


def less(rows: Rows, before: Rows) -> Rows:
    """Rows, less what they were before."""
    return [
        {key: value if isinstance(value, str) else value - earlier[key] for key, value in row.items()}
        for row, earlier in zip(rows, before, strict=True)
    ]
