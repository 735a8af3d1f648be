"""Checks of a layout before robots are let onto it.

What would void the guarantee that work never stops is an error; what a planner should know, a warning or a note.
The conditions are those of docs/why.md, "Never stalled". A finding says where and what to do about it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    import networkx as nx

    from desim_warehouse.layout.layout import Layout

EPS = 1e-6
SHOWN = 8
SHARPEST_MERGE = math.radians(60)


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing to know about a layout: `error`s are refused by `simulate`, the others are not."""

    level: Literal["error", "warning", "note"]
    place: str
    text: str

    def __str__(self) -> str:
        """One line: level, place, what is wrong and what to do."""
        return f"{self.level}: {self.place}: {self.text}"


@dataclass(frozen=True, slots=True)
class Use:
    """What a model does with a layout: D, the number of robots, where they start and unload."""

    contact: float
    robots: int
    start: tuple[str, ...]
    unload_at: tuple[str, ...]
    gridlock: str = "auto"


def examine(layout: Layout, use: Use) -> list[Finding]:
    """All findings, errors first."""
    found = [
        *_reach(layout, use),
        *_bays(layout, use),
        *_two_way(layout, use),
        *_stops(layout, use),
        *_queues(layout, use),
        *_short(layout, use),
        *_merges(layout),
        *_bridges(layout),
    ]
    order = {"error": 0, "warning": 1, "note": 2}
    return sorted(found, key=lambda finding: order[finding.level])


def faults(layout: Layout, use: Use) -> list[str]:
    """The errors alone, for `simulate`; the cheap part of `examine`."""
    return [
        f"{item.place}: {item.text}"
        for item in (*_reach(layout, use), *_bays(layout, use), *_two_way(layout, use))
        if item.level == "error"
    ]


def _some(names: Iterable[str]) -> str:
    names = list(names)
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more


def _reach(layout: Layout, use: Use) -> Iterator[Finding]:
    """Strong connectivity of everything that is used."""
    import networkx as nx

    graph = layout.graph
    if nx.is_strongly_connected(graph):
        return
    main = max(nx.strongly_connected_components(graph), key=lambda part: (len(part), sorted(part)))
    anchor = next(name for name in graph if name in main)
    reached = nx.descendants(graph, anchor) | {anchor}
    leaving = nx.ancestors(graph, anchor) | {anchor}
    used = {
        **{place.edge[0]: f"good {place.number}" for place in layout.storage},
        **{place.edge[1]: f"good {place.number}" for place in layout.storage},
        **dict.fromkeys(use.unload_at, "unloading"),
        **{node: f"bay {bay.zone}" for node, bay in layout.bays.items()},
        **{node: f"station {station.zone}" for node, station in layout.stations.items()},
    }
    for name in graph:
        if name in main:
            continue
        cannot = " and ".join(word for word, ok in (("reached", name in reached), ("left", name in leaving)) if not ok)
        where = f"layout: node {name}"
        advice = "add or turn edges so that every node can be reached from every other"
        if name in used:
            yield Finding("error", where, f"cannot be {cannot}, but {used[name]} is there; {advice}")
        else:
            yield Finding("warning", where, f"cannot be {cannot}; nothing is there, so no robot will go; {advice}")


def _bays(layout: Layout, use: Use) -> Iterator[Finding]:
    """A bay place for every robot."""
    start = use.start or tuple(layout.bays)
    if not start:
        yield Finding("error", "layout.bays", "there are none; robots start from bays and go home to them")
        return
    homes = [start[number % len(start)] for number in range(use.robots)]
    crowded: dict[str, list[str]] = {}
    for node in dict.fromkeys(start):
        bay = layout.bays.get(node)
        if bay is None:
            yield Finding("error", f"fleet.start: {node}", "there is no bay at this node; name nodes with bays")
        elif bay.places is not None and homes.count(node) > bay.places:
            crowded.setdefault(bay.zone, []).append(node)
    for zone, nodes in crowded.items():
        places = layout.bays[nodes[0]].places
        yield Finding(
            "error",
            f"layout.bays.{zone}.places",
            f"{homes.count(nodes[0])} robots start at {nodes[0]} but its bay has {places} places; "
            f"give it more, or spread fleet.start over more nodes{f' (as at {_some(nodes[1:])})' if nodes[1:] else ''}",
        )
    if all(bay.places is not None for bay in layout.bays.values()):
        places = sum(bay.places or 0 for bay in layout.bays.values())
        if places < use.robots:
            yield Finding(
                "error", "layout.bays", f"{use.robots} robots but only {places} bay places; every robot needs one"
            )


def _two_way(layout: Layout, use: Use) -> Iterator[Finding]:
    """Which lanes are two-way, and which rule keeps robots from being stuck there."""
    lanes = layout.two_way
    if not lanes:
        return
    names = _some(f"{a}-{b}" for a, b in lanes)
    if use.gridlock == "rotate":
        yield Finding(
            "error",
            "traffic.gridlock",
            f"rotate cannot free robots that meet head-on, and these lanes are two-way: {names}; "
            "say auto or avoid, or side_by_side: true where there are two lanes",
        )
    else:
        yield Finding(
            "note",
            "layout: edges",
            f"{len(lanes)} lanes are two-way, used in one direction at a time: {names}; a robot takes a step only if "
            "nobody can be stuck afterwards (traffic.gridlock: avoid)",
        )


def _stops(layout: Layout, use: Use) -> Iterator[Finding]:
    """Stops in a lane that keep others from passing (condition 2)."""
    graph = layout.graph
    for node in dict.fromkeys(use.unload_at):
        if node not in layout.stations and graph.in_degree(node) > 1:
            ways = _some(f"{source}>{node}" for source in graph.predecessors(node))
            yield Finding(
                "warning",
                f"tasks.unload_at: {node}",
                f"robots unload standing on a node where {ways} meet, and hold all of them up; "
                "a station beside the node would not (layout.stations)",
            )
    near = [
        f"good {place.number}"
        for place in layout.storage
        if min(place.offset, graph.edges[place.edge]["length"] - place.offset) < use.contact - EPS
    ]
    if near:
        yield Finding(
            "note",
            "layout: storage",
            f"{len(near)} places are nearer than {use.contact:g} (D) to a node; robots stop D clear of it to load "
            f"there: {_some(near)}",
        )


def _queues(layout: Layout, use: Use) -> Iterator[Finding]:
    """Station places bound the robots that can be on a task."""
    used = dict.fromkeys(use.unload_at)
    if all(node in layout.stations for node in used):
        places = sum(layout.stations[node].places for node in used)
        if places < use.robots:
            yield Finding(
                "note",
                "layout.stations",
                f"{places} places for {use.robots} robots: a robot takes a task only when its station has a place "
                "for it, so the others stay in their bays; more places let more of them work",
            )


def _short(layout: Layout, use: Use) -> Iterator[Finding]:
    """Edges too short for a robot to stand on clear of both ends (condition 4)."""
    lengths = {f"{a}>{b}": length for a, b, length in layout.graph.edges(data="length")}
    joined = [name for name, length in lengths.items() if length < use.contact - EPS]
    short = [name for name, length in lengths.items() if use.contact - EPS <= length < 2 * use.contact - EPS]
    if joined:
        yield Finding(
            "warning",
            "layout: edges",
            f"{len(joined)} are shorter than {use.contact:g} (D), so the nodes at their ends are used by one "
            f"robot at a time: {_some(joined)}; smaller robots or longer edges avoid it",
        )
    if short:
        yield Finding(
            "note",
            "layout: edges",
            f"{len(short)} are shorter than {2 * use.contact:g} (2 D), so robots wait on the nodes before them: "
            f"{_some(short)}",
        )


def _merges(layout: Layout) -> Iterator[Finding]:
    """Edges that meet at so sharp an angle that robots waiting side by side would touch."""
    graph = layout.graph
    sharp = []
    for node in graph:
        headings = sorted((layout.heading((source, node)), source) for source in graph.predecessors(node))
        around = [*headings, *headings[: len(headings) > 2]]  # noqa: PLR2004 - two make one pair, three a circle
        for (one, first), (other, second) in pairwise(around):
            between = abs((one - other + math.pi) % (2 * math.pi) - math.pi)
            if first != second and between < SHARPEST_MERGE - EPS:
                sharp.append(f"{first}>{node} and {second}>{node}")
    if sharp:
        yield Finding(
            "warning",
            "layout: edges",
            f"meet at less than 60 degrees, where robots waiting on both would come closer than D: {_some(sharp)}",
        )


def _bridges(layout: Layout) -> Iterator[Finding]:
    """Edges that cross, drawn straight, where there is no node."""
    places = {name: layout.point(name) for name in layout.graph}
    edges = list({frozenset(edge): edge for edge in layout.graph.edges}.values())
    longest = max((abs(places[b] - places[a]) for a, b in edges), default=0.0) or 1.0
    squares = defaultdict(list)  # of the longest edge's length: edges that cross have one in common
    for a, b in edges:
        (left, right), (low, high) = (
            sorted((math.floor(one / longest), math.floor(other / longest)))
            for one, other in ((places[a].real, places[b].real), (places[a].imag, places[b].imag))
        )
        for square in ((x, y) for x in range(left, right + 1) for y in range(low, high + 1)):
            squares[square].append((a, b))
    pairs = {pair for near in squares.values() for pair in combinations(near, 2)}
    crossing = sorted(
        f"{'>'.join(one)} and {'>'.join(other)}"
        for one, other in pairs
        if not {*one} & {*other} and _cross([places[name] for name in (*one, *other)])
    )
    if crossing:
        yield Finding(
            "warning",
            "layout: edges",
            "cross where there is no node, so robots there do not give way to each other: "
            f"{_some(crossing)}; a node where they cross makes it an intersection",
        )


def _cross(ends: list[complex]) -> bool:
    """Whether the line from the first to the second point crosses that from the third to the fourth."""
    a, b, c, d = ends

    def beside(start: complex, end: complex, point: complex) -> float:
        """How far a point lies to the right of the way from one to another."""
        way = end - start
        return (way.conjugate() * (point - start)).imag / (abs(way) or 1.0)

    return all(
        min(sides) < -EPS and max(sides) > EPS
        for sides in ((beside(a, b, c), beside(a, b, d)), (beside(c, d, a), beside(c, d, b)))
    )


def capacity(layout: Layout, contact: float) -> int:
    """Robots that can stand in the lanes at once, clear of the nodes."""
    return sum(max(math.floor((length + EPS) / contact) - 1, 0) for *_, length in layout.graph.edges(data="length"))


def shortest_rings(highways: nx.DiGraph, most: int = 5, searched: int = 400) -> list[Sequence[str]]:
    """The shortest closed ways, by length, where gridlock would form first; found from the first `searched` edges."""
    import networkx as nx

    rings: dict[frozenset[str], tuple[float, list[str]]] = {}
    for source, target, length in list(highways.edges(data="length"))[:searched]:
        try:
            back, way = nx.single_source_dijkstra(highways, target, source, weight="length")
        except nx.NetworkXNoPath:
            continue
        rings.setdefault(frozenset(way), (back + length, [*way, target]))
    return [way for _, way in sorted(rings.values())[:most]]
