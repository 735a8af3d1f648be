"""Zones of the floor with their own traffic rule: one robot at a time, or one direction at a time.

Other systems call them blocks (openTCS: single vehicle only, same direction only) or mutex groups (Open-RMF).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationInfo

from desim_warehouse.errors import got
from desim_warehouse.findings import Finding
from desim_warehouse.layout.layout import Edge, Layout
from desim_warehouse.layout.short import is_short, joins
from desim_warehouse.layout.spec import NodeName
from desim_warehouse.values.fields import Forms, Name, Part, by_type, form, known, wrong

Rule = Literal["one-robot", "one-direction"]


def _edge(edge: tuple[str, str], info: ValidationInfo) -> tuple[str, str]:
    edges = known(info).edges
    if edges and edge not in edges and edge[::-1] not in edges:
        raise wrong(f"no such edge (got {got(edge)}), expected an edge of the layout")
    return edge


Members = Annotated[
    tuple[
        Annotated[
            Annotated[NodeName, form("node")] | Annotated[tuple[Name, Name], AfterValidator(_edge), form("edge")],
            Forms("the name of a node, or an edge as [A, B]", pick=by_type(node=str, edge=(list, tuple))),
        ],
        ...,
    ],
    Field(min_length=1),
]
"""A part of the floor: nodes by name, and edges as [A, B], in both directions where both exist."""


class ZoneSpec(Part):
    """A part of the floor with its own traffic rule."""

    members: Members = Field(
        description="nodes by name, and edges as [A, B], which hold in both directions of a two-way lane"
    )
    rule: Rule = Field(
        description="one-robot: one robot at a time in the members and on the nodes at the ends of its edges; "
        "one-direction: its edges, two-way lanes in a line, are driven in one direction at a time"
    )


@dataclass(frozen=True)
class TrafficZone:
    """A zone on a layout: its `edges`, in both directions where both exist, and its `nodes`, with the ends of edges."""

    name: str
    rule: Rule
    nodes: tuple[str, ...]
    edges: tuple[Edge, ...]

    @property
    def lane_ends(self) -> dict[str, list[str]]:
        """The neighbours of each node along the zone's edges."""
        neighbours: defaultdict[str, list[str]] = defaultdict(list)
        for a, b in self.edges:
            neighbours[a] += [b] * (b not in neighbours[a])
            neighbours[b] += [a] * (a not in neighbours[b])
        return neighbours

    @property
    def line(self) -> list[str]:
        """The nodes along the zone's edges, from one end to the other; empty if the edges do not form a line."""
        near = self.lane_ends
        ends = [node for node, others in near.items() if len(others) == 1]
        if len(ends) != 2 or any(len(others) > 2 for others in near.values()):  # noqa: PLR2004 - a line's two ends
            return []
        line = [ends[0]]
        while len(line) < len(near):
            following = [node for node in near[line[-1]] if node not in line]
            if not following:
                return []
            line += following
        return line


def zones_on(layout: Layout, specs: Mapping[str, ZoneSpec]) -> tuple[TrafficZone, ...]:
    """Return the zones of a model on its layout."""
    zones = []
    for name, spec in specs.items():
        drawn = [member for member in spec.members if not isinstance(member, str)]
        edges = {edge: None for a, b in drawn for edge in ((a, b), (b, a)) if layout.graph.has_edge(*edge)}
        nodes = dict.fromkeys([member for member in spec.members if isinstance(member, str)])
        nodes.update(dict.fromkeys(node for edge in drawn for node in edge))
        zones.append(TrafficZone(name, spec.rule, tuple(nodes), tuple(edges)))
    return tuple(zones)


def closed(zones: Iterable[TrafficZone]) -> frozenset[Edge]:
    """Return the edges of zones for one robot, on which no robot waits."""
    return frozenset(edge for zone in zones if zone.rule == "one-robot" for edge in zone.edges)


def edges_of(layout: Layout, members: Iterable[str | tuple[str, str]]) -> tuple[Edge, ...]:
    """Return the edges of members of a floor, in both directions where both exist, and all edges into member nodes.

    A node of a lift stands for the nodes of all its cabins on that floor; their edges are the lanes to the doors, not
    the rides.
    """
    edges: dict[Edge, None] = {}
    beside, rides = layout.cabins_beside, layout.rides
    for member in members:
        if isinstance(member, str):
            for node in (member, *beside.get(member, ())):
                edges.update(dict.fromkeys(edge for edge in layout.graph.in_edges(node) if edge not in rides))
        else:
            ends = [(end, *beside.get(end, ())) for end in member]
            both = (edge for pair in product(*ends) for edge in (pair, pair[::-1]))
            edges.update(dict.fromkeys(edge for edge in both if layout.graph.has_edge(*edge)))
    return tuple(edges)


def edges_along(layout: Layout, line: Sequence[str]) -> tuple[Edge, ...]:
    """Return the edges along a line of nodes, in both directions where both exist."""
    return edges_of(layout, pairwise(line))


def edges_inside(layout: Layout, contact: float, zones: Iterable[TrafficZone]) -> frozenset[Edge]:
    """Return the edges that lie within one intersection, so that no robot waits on them."""
    zones = tuple(zones)
    joined, kept = intersections(layout, contact, zones), closed(zones)
    return frozenset(
        (a, b)
        for a, b, length in layout.graph.edges(data="length")
        if b in joined[a] and (is_short(length, contact) or (a, b) in kept)
    )


def intersections(layout: Layout, contact: float, zones: Iterable[TrafficZone]) -> dict[str, tuple[str, ...]]:
    """Return for each node the nodes of its intersection, which edges shorter than `contact` and zones join."""
    groups = {name: [name] for name in layout.graph}
    together = [edge for edge, length, _, _ in layout.edges if joins(length, contact)]
    together += [pair for zone in zones if zone.rule == "one-robot" for pair in pairwise(zone.nodes)]
    for source, target in together:
        group, other = groups[source], groups[target]
        if group is not other:
            group += other
            groups.update(dict.fromkeys(other, group))
    return {name: tuple(group) for name, group in groups.items()}


def examine(layout: Layout, specs: Mapping[str, ZoneSpec], contact: float, gridlock: str) -> Iterator[Finding]:
    """Find zones that name missing nodes or edges, zones that could stall all work, and nodes in two zones."""
    zones = zones_on(layout, specs)
    for zone in zones:
        place = f"traffic.zones.{zone.name}"
        for member in specs[zone.name].members:
            if not isinstance(member, str) and not ({member, member[::-1]} & set(zone.edges)):
                yield Finding("ZONE", place, f"there is no edge between {member[0]} and {member[1]}", "name others")
        if zone.rule == "one-direction":
            yield from _one_direction(layout, zone, contact, gridlock)
    for rank, zone in enumerate(zones):
        for other in zones[:rank]:
            shared = [node for node in zone.nodes if node in other.nodes]
            if not shared:
                continue
            place, both = f"traffic.zones.{zone.name}", f"shares node {shared[0]} with zone {other.name}"
            if zone.rule == other.rule == "one-robot":
                text = f"{both}: one robot at a time is in the two together"
                yield Finding(
                    "ZONES_JOINED", place, text, "leave the node, and edges at it, out of one where it is not so"
                )
            else:
                text = f"{both}, so a robot could hold the one while it waits for the other"
                yield Finding("ZONE", place, text, "leave it out of one, or make one zone of one-robot of both")


def _one_direction(layout: Layout, zone: TrafficZone, contact: float, gridlock: str) -> Iterator[Finding]:
    """Find the reasons why a zone cannot be kept to one direction at a time without robots getting stuck."""
    place = f"traffic.zones.{zone.name}"
    if gridlock not in {"auto", "avoid"}:
        text = f"robots that wait for a direction could get stuck under traffic.gridlock: {gridlock}"
        yield Finding("ZONE", place, text, "say auto or avoid")
    line = zone.line
    if not line:
        yield Finding("ZONE", place, "its edges are no line, so they have no two directions", "name edges in a line")
        return
    for node in zone.nodes:
        if node not in line:
            yield Finding("ZONE", place, f"node {node} is on none of its edges", "leave it out")
    for a, b in zone.edges:
        data = layout.graph.edges[a, b]
        if not data.get("two_way"):
            text = f"{a}>{b} is not two-way, so its direction is given" + (
                " or two lanes lie there side by side" if layout.graph.has_edge(b, a) else ""
            )
            yield Finding("ZONE", place, text, "leave it out, or say two_way: true")
        elif a < b and is_short(data["length"], contact):
            text = f"{a}-{b} is shorter than {2 * contact:g} (2 D), so robots wait at its ends and not on it"
            yield Finding("ZONE", place, text, "leave it out, or make a zone of one-robot of it")
