"""Checks of a layout before it is simulated.

A fault that would void the liveness guarantee is an error; other facts that a planner should know are warnings or
notes. docs/why.md, "Never stalled", states the conditions. Each finding names its place and a remedy.

`Near` finds edges that cross or run side by side, drawn as straight lines between their nodes. It numbers edges in the
layout's order, and holds only one edge of each two-way pair.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence, Sized
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import first_of, number_of
from desim_warehouse.findings import Finding
from desim_warehouse.layout import aisles, lifts, way_home, zones
from desim_warehouse.layout.layout import Edge, Layout
from desim_warehouse.layout.short import EPS, joins, waited_for
from desim_warehouse.layout.zones import ZoneSpec

if TYPE_CHECKING:
    import networkx as nx

PARALLEL = math.sin(math.radians(5))
BENT = 1.05
"""An edge longer than this multiple of the straight line between its nodes is not drawn true to shape."""

SHOWN = 8
SHARPEST_MERGE = math.radians(60)
"""Smallest angle between edges into a node at which two robots, each D before the node, still stand D apart."""


@dataclass(frozen=True, slots=True)
class Use:
    """How a model uses a layout: D (`contact`), the number of robots, and the nodes where they start, live and unload.

    `ends`: nodes of the stations where tasks end; empty where any task ends elsewhere. `free`: nodes that are open to
    all robots at once. `timed`: nodes with a node time of their own. `people`: the share of the time for which people
    have each lift, by the name of the lift.
    """

    contact: float
    robots: int
    start: tuple[str, ...]
    homes: tuple[str, ...]
    unload_at: tuple[str, ...]
    ends: tuple[str, ...] = ()
    gridlock: str = "auto"
    zones: Mapping[str, ZoneSpec] = field(default_factory=dict)
    free: frozenset[str] = frozenset()
    people: Mapping[str, float] = field(default_factory=dict)
    timed: frozenset[str] = frozenset()

    @property
    def at(self) -> dict[str, str]:
        """The use of nodes for handling or as starts of robots, in words, whatever else is at the nodes."""
        return {**dict.fromkeys(self.unload_at, "handling"), **dict.fromkeys(self.start, "the start of a robot")}


def examine(layout: Layout, use: Use) -> list[Finding]:
    """Return all findings, errors first."""
    near = Near(layout, use.contact)
    findings = [
        *unreachable(layout, use),
        *_bays(layout, use),
        *_in_lane(layout, use),
        *_two_way(layout, use),
        *lifts.examine(layout, use),
        *zones.examine(layout, use.zones, use.contact, use.gridlock),
        *_stops(layout, use),
        *_queues(layout, use),
        *_shared_names(layout),
        *_short(layout, use),
        *aisles.examine(layout, use.contact),
        *_merges(layout),
        *_bridges(near),
        *_side_by_side(use, near),
    ]
    return worst_first(findings)


def worst_first(findings: Iterable[Finding]) -> list[Finding]:
    """Sort findings by severity, and otherwise keep their order."""
    order = {"error": 0, "warning": 1, "note": 2}
    return sorted(findings, key=lambda finding: order[finding.level])


def errors(layout: Layout, use: Use) -> list[Finding]:
    """Return only the errors of the layout, for `simulate`: the quick part of `examine`."""
    findings = (
        *unreachable(layout, use),
        *_bays(layout, use),
        *_in_lane(layout, use),
        *_two_way(layout, use),
        *lifts.examine(layout, use),
        *zones.examine(layout, use.zones, use.contact, use.gridlock),
    )
    return [item for item in findings if item.level == "error"]


def some(names: Iterable[str]) -> str:
    """Return the first few of many names, and how many more there are."""
    return first_of(list(names), SHOWN)


def unreachable(layout: Layout, use: Use) -> Iterator[Finding]:
    """Find nodes outside the largest strongly connected part: condition 1 of docs/why.md, "Never stalled".

    Such a node is an error if a bay, a station, a good or unloading is there, and otherwise a remark.
    """
    import networkx as nx

    graph = layout.graph
    if nx.is_strongly_connected(graph):
        return
    main: set[str] = max(nx.strongly_connected_components(graph), key=lambda part: (len(part), sorted(part)))
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
    advice = "add or turn edges so that every node can be reached from every other"
    unused: dict[str, list[str]] = {}
    for name in graph:
        if name in main:
            continue
        cannot = " and ".join(word for word, ok in (("reached", name in reached), ("left", name in leaving)) if not ok)
        if name in used:
            text = f"cannot be {cannot}, but {used[name]} is there"
            yield Finding("UNREACHABLE", f"layout: node {name}", text, advice)
        else:
            unused.setdefault(cannot, []).append(name)
    for cannot, names in unused.items():
        where = f"layout: node{'s' if len(names) > 1 else ''} {some(names)}"
        yield Finding("UNREACHABLE_UNUSED", where, f"cannot be {cannot}; nothing is there, so no robot will go", advice)


def _bays(layout: Layout, use: Use) -> Iterator[Finding]:
    """Find starts without a bay, and bays with too few slots: a robot that leaves its work needs a slot to go to.

    This is condition 2 of docs/why.md, "Never stalled".
    """
    start = use.start or tuple(layout.bays)
    if not start:
        yield Finding("NO_BAYS", "layout.bays", "there are none", "robots start from bays and go home to them")
        return
    homes = Counter(use.homes)
    crowded: dict[str, list[str]] = {}
    for node in dict.fromkeys(start):
        bay = layout.bays.get(node)
        if bay is None:
            yield Finding(
                "START_WITHOUT_BAY", f"fleet.start: {node}", "there is no bay at this node", "name nodes with bays"
            )
        elif bay.places is not None and homes[node] > bay.slots(homes[node]):
            crowded.setdefault(bay.zone, []).append(node)
    for zone, nodes in crowded.items():
        places = layout.bays[nodes[0]].places
        yield Finding(
            "BAY_CROWDED",
            f"layout.bays.{zone}.places",
            f"{homes[nodes[0]]} robots start at {nodes[0]} but its bay {zone} has {number_of(places or 0, 'slot')}",
            f"give it more, or spread fleet.start over more nodes{f' (as at {some(nodes[1:])})' if nodes[1:] else ''}",
        )
    if all(bay.places is not None for bay in layout.bays.values()):
        places = sum(bay.slots(homes[node]) for node, bay in layout.bays.items())
        if places < use.robots:
            yield Finding(
                "TOO_FEW_PLACES",
                "layout.bays",
                f"{use.robots} robots but only {number_of(places, 'bay slot')}",
                "every robot needs one",
            )


def _in_lane(layout: Layout, use: Use) -> Iterator[Finding]:
    """Find bays in the lane that cut off other places, or at which other robots would have to stop.

    A robot parked there would hold up others for as long as there is no task for it ("well-formed infrastructure": Cap,
    Vokrinek and Kleiner, ICAPS 2015).
    """
    import networkx as nx

    closed = {node: bay for node, bay in layout.bays.items() if bay.in_lane}
    if not closed:
        return
    graph = layout.graph
    used: dict[str, str] = {node: f"goods are unloaded at {node}" for node in (*use.unload_at, *layout.stations)}
    for place in layout.storage:
        used.update(dict.fromkeys(place.edge, f"good {place.number} is picked there, or on an edge beside it"))
    for a, b, length in graph.edges(data="length"):
        if joins(length, use.contact):
            used |= dict.fromkeys((a, b), f"edge {a}>{b} is shorter than {use.contact:g} (D)")
    rest = graph.subgraph(node for node in graph if node not in closed)
    main: set[str] = max(nx.strongly_connected_components(rest), key=len, default=set())
    lost = dict.fromkeys(node for node in (*used, *layout.bays) if node not in main and node not in closed)
    for node, bay in closed.items():
        where = f"layout.bays.{bay.zone}: {node}"
        cure = "a bay beside the node (without in_lane), or another node"
        before, after = set(graph.predecessors(node)), set(graph.successors(node))
        if node in used:
            yield Finding("BAY_IN_LANE", where, f"robots park on the node, but {used[node]}", cure)
        elif lost and (before | after) - main - closed.keys():
            yield Finding("BAY_IN_LANE", where, f"a robot parked on the node cuts off {some(lost)}", cure)
        elif not (main & before and main & after):
            text = "it cannot be reached and left again without passing another such bay"
            yield Finding("BAY_IN_LANE", where, text, cure)


def _two_way(layout: Layout, use: Use) -> Iterator[Finding]:
    """Report which lanes are two-way, and which rule keeps robots from getting stuck there."""
    lanes = layout.two_way
    if not lanes:
        return
    names = some(f"{a}-{b}" for a, b in lanes)
    if use.gridlock == "rotate":
        yield Finding(
            "ROTATE_TWO_WAY",
            "traffic.gridlock",
            f"rotate cannot free robots that meet head-on, and these lanes are two-way: {names}",
            "use auto or avoid, or side_by_side: true where there are two lanes",
        )
    else:
        refuges = sum(not both and way_home.room(length, use.contact) > 0 for _, length, _, both in layout.edges)
        make_way = f"; robots make way for others on {number_of(refuges, 'one-way lane')}" if refuges else ""
        yield Finding(
            "TWO_WAY",
            "layout: edges",
            f"{number_of(len(lanes), 'lane')} {_are(lanes)} two-way, used in one direction at a time: {names}; a "
            f"robot takes a step only if nobody can be stuck afterwards (traffic.gridlock: avoid){make_way}",
        )


def _are(things: Sized) -> str:
    """Return the verb for one or several things."""
    return "is" if len(things) == 1 else "are"


def _stops(layout: Layout, use: Use) -> Iterator[Finding]:
    """Find stops in a lane that keep other robots from passing: they cost throughput, but never close a ring."""
    graph = layout.graph
    for node in dict.fromkeys(use.unload_at):
        if node not in layout.stations and graph.in_degree(node) > 1:
            ways = some(f"{source}>{node}" for source in graph.predecessors(node))
            yield Finding(
                "UNLOAD_IN_LANE",
                f"tasks.unload_at: {node}",
                f"robots unload standing on a node where {ways} meet, and hold all of them up",
                "a station beside the node would not (layout.stations)",
            )
    at_nodes = [place for place in layout.storage if place.edge[0] == place.edge[1]]
    crossed = [place for place in at_nodes if graph.in_degree(place.edge[0]) > 1]
    if crossed:
        where = dict.fromkeys(place.edge[0] for place in crossed)
        yield Finding(
            "LOAD_ON_NODE",
            "layout: storage",
            f"{number_of(len(crossed), 'place')} {_are(crossed)} at nodes where edges meet; a robot that loads there "
            f"holds all others up: {some(where)}",
            "nodes at the ends of spurs would not",
        )
    near = [
        f"good {place.number}"
        for place in layout.storage
        if place.edge[0] != place.edge[1]
        and min(place.offset, graph.edges[place.edge]["length"] - place.offset) < use.contact - EPS
    ]
    if near:
        yield Finding(
            "LOAD_NEAR_NODE",
            "layout: storage",
            f"{number_of(len(near), 'place')} {_are(near)} nearer than {use.contact:g} (D) to a node; robots stop D "
            f"clear of it to load there: {some(near)}",
        )


def _queues(layout: Layout, use: Use) -> Iterator[Finding]:
    """Find stations whose slots limit the number of robots on tasks, as robots wait in bays until a slot is free."""
    if use.ends:
        places = sum(layout.stations[node].places for node in use.ends)
        if places == 1 < use.robots:
            return  # ONE_AT_WORK, with what it costs
        if places < use.robots:
            yield Finding(
                "STATION_PLACES",
                "layout.stations",
                f"{number_of(places, 'slot')} for {number_of(use.robots, 'robot')}: a robot takes a task only when "
                "its station has a slot for it, so the others stay in their bays",
                "more slots let more of them work",
            )
            return
        stations = {node: layout.stations[node] for node in use.ends}
        full = [node for node, item in stations.items() if item.places <= item.servers and item.places < use.robots]
        if full and places < 2 * use.robots:
            zones = dict.fromkeys(stations[node].zone for node in full)
            yield Finding(
                "STATION_PLACES",
                f"layout.stations: {some(zones)}",
                f"no more slots than servers at {number_of(len(full), 'node')}: while all servers are at work there, "
                f"no other robot sets off for it, and robots wait in bays (slots for {places}, {use.robots} robots)",
                "more slots (places) let more of them work",
            )


def _shared_names(layout: Layout) -> Iterator[Finding]:
    """Report levels that share a position: they are one storage place, shown in logs and reports by its first name."""
    others = {number: name for name, number in layout.place_names.items() if name != layout.called[number]}
    if others:
        number, name = next(iter(others.items()))
        yield Finding(
            "SHARED_NAMES",
            "layout.storage_names",
            f"{number_of(len(others), 'place')} {'has' if len(others) == 1 else 'have'} several names, one for each "
            "good at the same stand: orders may use all of them, logs, replays and reports show the first, such as "
            f"{layout.called[number]} for {name}",
        )


def _short(layout: Layout, use: Use) -> Iterator[Finding]:
    """Report edges too short for a robot to stand on clear of both ends (docs/why.md, "Never stalled", condition 3)."""
    lanes = [edge for edge in layout.graph.edges if edge not in layout.rides]
    lengths = {">".join(edge): layout.length(edge) for edge in lanes}
    joined = [name for name, length in lengths.items() if joins(length, use.contact)]
    short = [name for name, length in lengths.items() if waited_for(length, use.contact)]
    if joined:
        yield Finding(
            "SHORT_EDGES",
            "layout: edges",
            f"{len(joined)} are shorter than {use.contact:g} (D), so the nodes at their ends are used by one "
            f"robot at a time: {some(joined)}",
            "smaller robots or longer edges avoid it",
        )
    if short:
        yield Finding(
            "EDGES_BELOW_2D",
            "layout: edges",
            f"{len(short)} are shorter than {2 * use.contact:g} (2 D), so robots wait on the nodes before them: "
            f"{some(short)}",
        )


def _merges(layout: Layout) -> Iterator[Finding]:
    """Find edges that meet at so sharp an angle that robots waiting side by side would touch."""
    graph = layout.graph
    sharp = []
    for node in graph:
        lanes = [edge for edge in graph.in_edges(node) if edge not in layout.rides]
        headings = sorted((layout.headings[edge], edge[0]) for edge in lanes)
        around = [*headings, *headings[: len(headings) > 2]]  # noqa: PLR2004 - two make one pair, three a circle
        for (angle, first), (next_angle, second) in pairwise(around):
            between = abs((angle - next_angle + math.pi) % (2 * math.pi) - math.pi)
            if first != second and between < SHARPEST_MERGE - EPS:
                sharp.append(f"{first}>{node} and {second}>{node}")
    if sharp:
        yield Finding(
            "SHARP_MERGE",
            "layout: edges",
            f"meet at less than 60 degrees, where robots waiting on both would come closer than D: {some(sharp)}",
        )


def _bridges(near: Near) -> Iterator[Finding]:
    """Find edges that, drawn straight, cross where there is no node."""
    crossing = near.named(near.cross())
    if crossing:
        yield Finding(
            "CROSSING_EDGES",
            "layout: edges",
            f"cross where there is no node, so robots there do not give way to each other: {some(crossing)}",
            "a node where they cross makes it an intersection",
        )


def _side_by_side(use: Use, near: Near) -> Iterator[Finding]:
    """Find edges that, drawn straight, run side by side so closely that robots on both would touch."""
    along = near.named(near.are_along(use.contact))
    if along:
        yield Finding(
            "LANES_OVERLAP",
            "layout: edges",
            f"run along each other less than {use.contact:g} (D) apart, so robots on both would touch, unseen by the "
            f"simulation: {some(along)}",
            "one lane there, nodes that divide it, or lanes D apart",
        )


def capacity(layout: Layout, contact: float, closed: Container[Edge] = ()) -> int:
    """Return the number of robots that fit in the lanes at once, clear of the nodes, without `closed` lanes."""
    return sum(
        max(way_home.room(layout.length(lane), contact), 0)  # the first stands at the stop line
        for lane in layout.lanes
        if lane not in closed
    )


def room(layout: Layout, contact: float, closed: Container[Edge] = ()) -> int:
    """Return the number of robots that fit in the lanes at once, counting one on each node before a short edge."""
    short = [lane for lane in layout.lanes if lane not in closed and waited_for(layout.length(lane), contact)]
    on_nodes = {node for lane in short for node in (lane if layout.graph.edges[lane].get("two_way") else lane[:1])}
    return capacity(layout, contact, closed) + len(on_nodes)


def shortest_rings(highways: nx.DiGraph, most: int = 5, searched: int = 400) -> list[Sequence[str]]:
    """Return the nodes of the `most` shortest rings, where gridlock would form first, the shortest ring first.

    Only rings through one of the first `searched` edges are considered. The first node is repeated at the end.
    """
    import networkx as nx

    rings: dict[frozenset[str], tuple[float, list[str]]] = {}
    lanes = [lane for lane in highways.edges(data="length") if lane[2]]  # rides have no length
    for source, target, length in lanes[:searched]:
        try:
            back, way = nx.single_source_dijkstra(highways, target, source, weight="length")
        except nx.NetworkXNoPath:
            continue
        if highways.edges[source, target].get("two_way") and len(way) == 2:  # noqa: PLR2004 - there and back
            continue
        rings.setdefault(frozenset(way), (back + length, [*way, target]))
    return [way for _, way in sorted(rings.values())[:most]]


class Near:
    """Pairs of edges that may come closer to each other than `apart`, as arrays with one entry for each pair."""

    def __init__(self, layout: Layout, apart: float) -> None:
        import numpy as np

        self.edges = list({frozenset(edge): edge for edge in layout.graph.edges if edge not in layout.rides}.values())
        ends = np.array([[layout.points[node] for node in edge] for edge in self.edges], dtype=complex).reshape(-1, 2)
        drawn = np.abs(ends[:, 1] - ends[:, 0])
        self._straight = np.array([layout.length(edge) for edge in self.edges]) < BENT * drawn
        self.first, self.second = _pairs(ends, apart, float(drawn.mean()) + apart if len(drawn) else 1.0)
        self._a, self._b = ends[self.first].T
        self._c, self._d = ends[self.second].T

    def named(self, pairs: Any) -> list[str]:
        """Return the names of the pairs for which the boolean array `pairs` is true, sorted."""
        return sorted(
            f"{'>'.join(self.edges[i])} and {'>'.join(self.edges[j])}"
            for i, j in zip(self.first[pairs].tolist(), self.second[pairs].tolist(), strict=True)
        )

    def cross(self) -> Any:
        """Return for each pair whether its edges cross away from their ends and share no node."""
        import numpy as np

        def apart(start: Any, end: Any, point_1: Any, point_2: Any) -> Any:
            """Return whether two points lie on different sides of the line from `start` to `end`."""
            way = end - start
            sides = [
                (way.conj() * (point - start)).imag / np.where(way == 0, 1.0, np.abs(way))
                for point in (point_1, point_2)
            ]
            return (np.minimum(*sides) < -EPS) & (np.maximum(*sides) > EPS)

        crosses = apart(self._a, self._b, self._c, self._d) & apart(self._c, self._d, self._a, self._b)
        for pair in np.flatnonzero(crosses):
            crosses[pair] = not {*self.edges[self.first[pair]]} & {*self.edges[self.second[pair]]}
        return crosses

    def are_along(self, apart: float) -> Any:
        """Return for each pair whether its edges run side by side, less than `apart` from each other.

        The stretch that they share must be longer than `apart`.
        """
        import numpy as np

        first, second = self._b - self._a, self._d - self._c
        long = np.abs(first)
        unit = first / np.where(long == 0, 1.0, long)
        ends = [unit.conj() * (point - self._a) for point in (self._c, self._d)]
        beside = np.minimum(long, np.maximum(ends[0].real, ends[1].real)) - np.maximum(
            0.0, np.minimum(ends[0].real, ends[1].real)
        )
        return (
            (self._straight[self.first] & self._straight[self.second])
            & ((first != 0) & (second != 0))
            & (np.abs((unit.conj() * second).imag) <= PARALLEL * np.abs(second))
            & (np.maximum(np.abs(ends[0].imag), np.abs(ends[1].imag)) < apart - EPS)
            & (beside > apart)
        )


def _pairs(ends: Any, apart: float, size: float) -> tuple[Any, Any]:
    """Return the pairs of edges whose surroundings share a square of a grid, each once, as two arrays of numbers."""
    import numpy as np

    corners = np.stack([ends.real, ends.imag])
    low, high = (
        np.floor(side / size).astype(int).T.tolist() for side in (corners.min(2) - apart, corners.max(2) + apart)
    )
    squares = defaultdict(list)
    for edge, ((left, lower), (right, upper)) in enumerate(zip(low, high, strict=True)):
        for x in range(left, right + 1):
            for y in range(lower, upper + 1):
                squares[x, y].append(edge)
    by_count = defaultdict(list)
    for inside in squares.values():
        by_count[len(inside)].append(inside)
    pairs = [np.empty(0, dtype=int)]
    for count, alike in by_count.items():
        numbers, (edge_1, edge_2) = np.array(alike), np.triu_indices(count, 1)
        pairs.append((numbers[:, edge_1] * len(ends) + numbers[:, edge_2]).ravel())
    every = np.sort(np.concatenate(pairs))  # np.unique would import masked arrays
    return np.divmod(every[np.diff(every, prepend=-1) != 0], max(len(ends), 1))
