"""Collision waiting as resource contention: the Highways as lanes and intersections that robots reserve.

See `drive` for the progress of a robot, `lane` for the queue on an edge, `intersection` for the right to cross,
`gridlock` for the proof that work never stalls, `rules` for the distances.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Container, Mapping, Sequence
from functools import partial

from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import Edge
from desim_warehouse.layout.short import exact_length
from desim_warehouse.layout.zones import TrafficZone, closed, intersections
from desim_warehouse.model.sections.fleet import Start
from desim_warehouse.outcome.log import Log
from desim_warehouse.world.traffic.avoidance import Avoidance
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.closures import Restrictions
from desim_warehouse.world.traffic.drive import Drive
from desim_warehouse.world.traffic.events import Clock
from desim_warehouse.world.traffic.gridlock import Gridlock, Rule
from desim_warehouse.world.traffic.intersection import FreeIntersection, Intersection
from desim_warehouse.world.traffic.lane import Lane, RestrictedLane
from desim_warehouse.world.traffic.lift import LiftCrossing, Ride
from desim_warehouse.world.traffic.lift_users import LiftUsers
from desim_warehouse.world.traffic.rulebook import Rules
from desim_warehouse.world.traffic.wide import WideLane, WideRestrictedLane
from desim_warehouse.world.traffic.zones import ZoneDirection, directions


class Traffic:
    """The Highways in use: lanes by edge, intersections by node.

    `contact` is D and `theta` the collision angle in radians (see `rules.Rules`, also for the times and `mixed`).
    `rule` is how rings of waiting robots are treated (see `gridlock`). With `avoid` robots declare their routes to
    `rules.guard`, which decides on every step and has `patience`. For `zones` see that module. `node_times` are nodes
    with a time other than `node_time`. `free` are nodes at which no robot waits. `restrictions`: lanes that are closed
    or slow at times. `wide`: lanes beside which robots stand while they load or unload; `looks` as in `wide.WideLane`.
    """

    def __init__(
        self,
        env: Clock,
        layout: Layout,
        log: Log,
        *,
        contact: float,
        theta: float,
        node_time: float,
        turn_time: float = 0.0,
        mixed: bool = True,
        rule: Rule = "rotate",
        patience: float = math.inf,
        zones: Sequence[TrafficZone] = (),
        node_times: Mapping[str, float] | None = None,
        free: Collection[str] = (),
        restrictions: Restrictions | None = None,
        wide: Collection[Edge] = (),
        looks: bool = True,
    ) -> None:
        restrictions = Restrictions() if restrictions is None else restrictions
        mixed = mixed or bool(free) or bool(restrictions.slow)
        self.gridlock = Gridlock(env, log, headway=contact, mixed=mixed, rule=rule)
        of_zones = directions(zones)
        guard = Avoidance(env, patience, has_zones=bool(of_zones)) if rule == "avoid" else None
        self.rules = Rules(
            env,
            log,
            self.gridlock,
            contact,
            theta,
            node_time,
            mixed,
            mixed or log.everything or bool(wide),
            guard,
            turn_time,
        )
        self.wide = frozenset(wide)
        lengths = {edge: exact_length(length, contact) for edge, length, _, _ in layout.edges}
        self.nodes = _intersections(layout, self.rules, zones, frozenset(free))
        self.lanes = _lanes(
            layout,
            self.rules,
            self.nodes,
            lengths,
            closed(zones),
            of_zones,
            node_times or {},
            _kinds(layout, restrictions, self.wide, yields=rule == "rotate", looks=looks),
        )
        if guard is not None:
            guard.rely_on(self.lanes.values())

    def share_lifts(self, users: Mapping[str, LiftUsers]) -> None:
        """Let people and repairs use lifts as well as robots, by the name of the lift."""
        for node in self.nodes.values():
            if isinstance(node, LiftCrossing):
                node.users = users.get(node.shaft.name)

    def drive(self, robot: Body, route: Sequence[Lane], stop: float | None = None) -> Drive:
        """Drive the lanes of `route` to `stop` on the last of them (None: to its end) from wherever the robot is.

        To be used with `yield from`. A stop is at least D from the nodes (see `Lane.clear_stop`). If the route is
        empty, the stop is on the robot's present lane.
        """
        if stop is not None:
            stop = (route[-1] if route else robot.lane).clear_stop(stop)
        return Drive(self.rules, robot, route, stop)

    def stand(self, robot: Body, start: Start) -> None:
        """Put a robot onto the lanes at the start of a run. On each lane robots must be added from the front."""
        if start.edge is None:
            node = self.nodes[start.node]
            node.grant(robot, None)
            robot.begin_on_node(node)
        else:
            self.lanes[start.edge].place(robot, start.offset)

    def clear(self, robot: Body, name: str) -> None:
        """Move a robot off the lanes to beside a node: its places become free, and robots behind move up."""
        now, node = self.rules.env._now, self.nodes[name]
        held, lane, behind, granted = robot.held, robot.lane, robot.behind, robot.granted
        robot.be_cleared(node)
        if self.rules.guard is not None:
            self.rules.guard.left(robot)
        if held is not None and held.holder is robot:
            held.holder = None
        if lane is not None and (behind is not None or lane.wanted):
            lane.made_room(behind, now)
        # At the end of a two-way lane that it was on, or was let onto, others wait to come in.
        for place in (held, *(used.end for used in (lane, granted) if used is not None)):
            if place is not None and place.claims:
                place.freed(now)

    def into_bay(self, robot: Body) -> None:
        """Move a robot at once from its node into the bay beside it, which opens the node to all."""
        now = self.rules.env._now
        node, lane = robot.held, robot.lane
        if lane is not None:
            robot.off_lane(now)
            lane.out_at = -math.inf  # it no longer blocks any robot
        robot.into_bay(node)
        if self.rules.guard is not None:
            self.rules.guard.left(robot)
        if node.holder is robot:
            node.holder = None
        if node.claims:
            node.freed(now)


def _intersections(
    layout: Layout,
    rules: Rules,
    zones: Sequence[TrafficZone],
    free: frozenset[str],
) -> dict[str, Intersection]:
    """Make the intersections, by node. An intersection with a free node is free as a whole."""
    made: dict[str, Intersection] = {}
    for shaft in layout.lifts:
        made.update(dict.fromkeys(shaft.nodes, LiftCrossing(rules, shaft)))
    for name, group in intersections(layout, rules.headway, zones).items():
        if name not in made:
            node = Intersection(rules, list(group)) if free.isdisjoint(group) else FreeIntersection(rules, list(group))
            made.update(dict.fromkeys(group, node))
    return made


def _kinds(
    layout: Layout, restrictions: Restrictions, wide: frozenset[Edge], *, yields: bool, looks: bool
) -> dict[Edge, Callable[..., Lane]]:
    """Return the class or maker of each lane that is no ordinary one, by edge."""
    kinds: dict[Edge, Callable[..., Lane]] = dict.fromkeys(wide, partial(WideLane, yields=yields, looks=looks))
    for edge in restrictions.edges:
        restricted = partial(WideRestrictedLane, yields=yields, looks=looks) if edge in wide else RestrictedLane
        kinds[edge] = partial(
            restricted, closures=restrictions.closures.get(edge, ()), slow=restrictions.slow.get(edge, ())
        )
    return kinds | dict.fromkeys(layout.rides, Ride)


def _lanes(
    layout: Layout,
    rules: Rules,
    nodes: dict[str, Intersection],
    lengths: Mapping[Edge, float],
    inside: Container[Edge],
    of_zones: Mapping[Edge, ZoneDirection],
    node_times: Mapping[str, float],
    kinds: Mapping[Edge, Callable[..., Lane]],
) -> dict[Edge, Lane]:
    """Make the lanes, by edge."""
    lanes: dict[Edge, Lane] = {}
    points, headings = layout.points, layout.headings
    for edge, _, limit, two_way in layout.edges:
        source, target = edge
        lane = kinds.get(edge, Lane)(
            rules,
            edge,
            length=lengths[edge],
            limit=limit,
            heading=headings[edge],
            tail=points[source],
            head=points[target],
            start=nodes[source],
            end=nodes[target],
            inside=edge in inside,
            node_time=node_times.get(target, rules.node_time),
            twin=lanes.get((target, source)) if two_way else None,
            zone_direction=of_zones.get(edge),
        )
        lane.start.outs.append(lane)
        lanes[edge] = lane
    return lanes
