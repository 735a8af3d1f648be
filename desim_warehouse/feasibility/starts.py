"""Starts of robots on the lanes: whether they can stand there, and drive home.

Each start must be free by the rules for robots under way: one robot on an intersection; robots D apart on a lane and D
clear of its ends; one direction on a two-way lane. If steps are guarded (`world.traffic.avoidance`), the start must
also be safe: the guard's search must find a plan by which all robots come home. Full rings of one-way lanes can turn,
however they arose.

For `desim check`, and for the examination before every run.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from desim_warehouse.feasibility.needs import jobs
from desim_warehouse.findings import Finding
from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import Edge
from desim_warehouse.layout.short import EPS, is_short
from desim_warehouse.layout.way_home import HomeSearch, Stands, room
from desim_warehouse.layout.zones import closed, intersections, zones_on
from desim_warehouse.model import Model
from desim_warehouse.model.facts.ahead import free_travel
from desim_warehouse.model.sections.fleet import Start

Stand = tuple[str, ...]
"""The place of one robot, or of robots of one direction: the nodes of an intersection, or the two ends of a lane."""


def errors(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find errors in `fleet.start_on_lanes`."""
    starts = {number: start for number, start in enumerate(model.fleet.starts(layout.bays)) if start.on_lanes}
    if not starts:
        return
    joined = intersections(layout, model.fleet.contact, zones_on(layout, model.traffic.zones))
    findings = [*_in_zones(model, layout, starts), *_places(layout, starts, joined, model.fleet.contact)]
    findings = findings or list(_cut_off(model, layout, starts))
    yield from findings
    if not findings and (model.traffic.gridlock == "avoid" or (model.traffic.gridlock == "auto" and layout.two_way)):
        yield from _stuck(model, layout, starts, joined)


def _in_zones(model: Model, layout: Layout, starts: dict[int, Start]) -> Iterator[Finding]:
    """Find robots that start in a zone, which they have not been let into."""
    for zone in zones_on(layout, model.traffic.zones):
        for number, start in starts.items():
            if start.edge in zone.edges or (start.edge is None and start.node in zone.nodes):
                yield _finding(number, start, f"is in zone {zone.name}", "start it outside, or in a bay")


def _finding(number: int, start: Start, text: str, cure: str) -> Finding:
    return Finding("START_ON_LANES", f"fleet.start_on_lanes.{number}", f"robot {number} {_where(start)} {text}", cure)


def _where(start: Start) -> str:
    return f"on node {start.node}" if start.edge is None else f"on {'>'.join(start.edge)} at {start.offset:g}"


def _lane(layout: Layout, edge: Edge) -> tuple[Stand, str]:
    """Return the lane of an edge; both directions of a two-way lane are one lane."""
    two_way = layout.graph.edges[edge].get("two_way")
    return tuple(sorted(edge)), "" if two_way else ">".join(edge)


def _places(layout: Layout, starts: dict[int, Start], joined: dict[str, Stand], contact: float) -> Iterator[Finding]:
    on_node: dict[Stand, int] = {}
    on_lane: dict[tuple[Stand, str], list[int]] = {}
    for number, start in starts.items():
        if start.edge is None:
            if any(start.node in lift.nodes for lift in layout.lifts):
                yield _finding(number, start, "is in a lift", "start it in front of the doors")
                continue
            bay = layout.bays.get(start.node)
            if bay is not None and bay.in_lane:
                text = "is where another may be parked"
                yield _finding(number, start, text, f"start it in the bay {bay.zone} (fleet.start), or elsewhere")
                continue
            other = on_node.setdefault(joined[start.node], number)
            if other != number:
                text = f"is on the same intersection as robot {other} {_where(starts[other])}"
                yield _finding(number, start, text, "one robot an intersection; start one of them elsewhere")
            continue
        length = layout.length(start.edge)
        if not contact - EPS <= start.offset <= length - contact + EPS:
            cure = f"an offset from {contact:g} to {length - contact:g}"
            if is_short(length, contact):
                cure = "start it on a node, or on an edge of at least 2 D"
            yield _finding(number, start, f"is nearer than {contact:g} (D) to a node", cure)
            continue
        for other in on_lane.setdefault(_lane(layout, start.edge), []):
            if starts[other].edge != start.edge:
                text = f"faces robot {other} {_where(starts[other])}"
                yield _finding(number, start, text, "a lane has one direction at a time; turn one of them")
                break
            if abs(starts[other].offset - start.offset) < contact - EPS:
                text = f"is nearer than {contact:g} (D) to robot {other} {_where(starts[other])}"
                yield _finding(number, start, text, f"offsets that are {contact:g} apart")
                break
        on_lane[_lane(layout, start.edge)].append(number)


def _cut_off(model: Model, layout: Layout, starts: dict[int, Start]) -> Iterator[Finding]:
    """Find robots from which no route leads to work or home."""
    travel, homes = free_travel(model, layout), model.fleet.homes(layout.bays)
    work = sorted({edge[0] for job in jobs(model, layout) for edge in job.picks.edges(layout)})
    for number, start in starts.items():
        if math.isinf(travel.times([start.node], [homes[number], *work]).max()):
            yield _finding(number, start, "cannot get to the goods, or home", "start it where all can be reached")


def _stuck(model: Model, layout: Layout, starts: dict[int, Start], joined: dict[str, Stand]) -> Iterator[Finding]:
    """Find robots that block each other's way home from the start, as none of them can make way for another."""
    travel = free_travel(model, layout)
    homes = model.fleet.homes(layout.bays)
    contact, inside = model.fleet.contact, closed(zones_on(layout, model.traffic.zones))
    refuges: dict[Hashable, int] = {
        _lane(layout, edge): room(length, contact)
        for edge, length, _, two_way in layout.edges
        if not two_way and not is_short(length, contact) and edge not in inside
    }
    ways: dict[int, _Way] = {}
    users: dict[Hashable, list[int]] = {}
    stands = Stands(ways, users, refuges)
    # Robots with larger offsets come first, as they are ahead on their lane.
    for number, start in sorted(starts.items(), key=lambda item: -item[1].offset):
        here: Hashable = joined[start.node] if start.edge is None else _lane(layout, start.edge)
        trail = [here] if start.edge is None else [here, joined[start.node]]
        for edge in pairwise(travel.way(start.node, homes[number])):
            trail += [_lane(layout, edge)] if not is_short(layout.length(edge), contact) else []
            trail.append(joined[edge[1]])
        ways[number] = _Way(trail)
        stands.put(number, (here,))
        for step in trail[1:]:
            users.setdefault(step, []).append(number)
    left = sorted(HomeSearch(stands, sorted(starts)).left)
    if left:
        named = ", ".join(f"{number} {_where(starts[number])}" for number in left)
        yield Finding(
            "START_STUCK",
            f"fleet.start_on_lanes.{left[0]}",
            f"robots {named} stand in each other's way home, where lanes are two-way, and none of them can make way on "
            "a one-way lane",
            "start one of them elsewhere, or turned round",
        )


@dataclass(frozen=True)
class _Way:
    """The way home of a robot: the nodes and lanes that it occupies, then those that it has yet to use."""

    trail: list[Hashable]
    at: int = 0
