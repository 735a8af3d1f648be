"""The Layout: the Highways as a networkx digraph, and what stands beside them."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise, permutations
from operator import attrgetter
from typing import TYPE_CHECKING

from desim_warehouse.values.disturbances import OutageSpec

if TYPE_CHECKING:
    import networkx as nx

    from desim_warehouse.layout.riders import RidersSpec


Edge = tuple[str, str]


@dataclass(frozen=True, slots=True)
class StoragePlace:
    """A place where a good is picked, `offset` length units from the start of an edge; (x, y) is the good's centre.

    A place that is picked from a node has this node as both ends of its edge, and offset 0.
    """

    number: int
    edge: Edge
    offset: float
    x: float
    y: float
    popularity: float = 1.0


@dataclass(frozen=True, slots=True)
class BayPlaces:
    """Parking slots beside a node: `places` slots, `chargers` of them with a charger.

    `places` and `chargers`: None means as many as robots start there. `in_lane`: the only slot is the node itself, so
    no route leads through it. `outages`: failures of each charger. `shared`: the chargers are this node's share of a
    total. `grows`: the bay has at least a slot for each robot that starts there and for each charger, and one more if
    it has no chargers. `kinds`: kinds of robots that may use the chargers; empty means all.
    """

    zone: str
    node: str
    places: int | None
    chargers: int | None
    in_lane: bool = False
    outages: OutageSpec | None = None
    shared: bool = False
    grows: bool = False
    kinds: tuple[str, ...] = ()

    def is_for(self, kind: str) -> bool:
        """Return whether robots of a kind (`""` for ordinary robots) may use chargers of the bay."""
        return not self.kinds or kind in self.kinds

    def charges(self, kind: str) -> bool:
        """Return whether the bay has chargers for robots of a kind (`""` for ordinary robots)."""
        return self.chargers != 0 and self.is_for(kind)

    def slots(self, homes: int) -> int:
        """Return the number of slots if `homes` robots start there.

        By default there are as many slots as robots or, if these are more, as shared chargers.
        """
        if self.places is not None:
            spare = self.chargers == 0  # room to park for a robot that leaves its slot at a charger to another
            return max(self.places, homes + spare, self.chargers or 0) if self.grows else self.places
        return max(homes, (self.chargers or 0) if self.shared else 0)


@dataclass(frozen=True, slots=True)
class StationPlaces:
    """A station beside a node: `places` robots fit in, and `servers` of them are served at a time."""

    zone: str
    node: str
    places: int
    servers: int


@dataclass(frozen=True, slots=True)
class Lift:
    """A lift for one robot at a time: its node on each floor, from the lowest up, and its times in seconds.

    `ride`: from one floor to the next. `doors`: time to open, and again to close. `rests`: the node to which the empty
    cabin returns; None if it stays where it is. `people`: people who also ride in the lift. `model_name`: name in the
    model, where a lift may have several cabins, each of which is a `Lift` here.
    """

    name: str
    nodes: tuple[str, ...]
    ride: float
    doors: float
    rests: str | None = None
    people: RidersSpec | None = None
    outages: OutageSpec | None = None
    model_name: str = ""

    def moving_time(self, node: str, other: str) -> float:
        """Return the time in which the cabin moves from one of its nodes to another."""
        return abs(self.nodes.index(node) - self.nodes.index(other)) * self.ride

    def carrying(self, node: str, other: str) -> float:
        """Return the time of a ride, from the doors' closing behind a robot until they are open on its floor."""
        return self.doors + self.moving_time(node, other) + self.doors

    def mean_call(self, node: str) -> float:
        """Return the mean time until the free cabin is at a node with open doors.

        The cabin comes from the node where it rests or, if it rests anywhere, from each of its nodes with equal
        probability.
        """
        stands = self.nodes if self.rests is None else (self.rests,)
        return math.fsum(self.moving_time(stand, node) for stand in stands) / len(stands) + self.doors


@dataclass(frozen=True, eq=False)
class Layout:
    """A warehouse floor, or several floors joined by lifts.

    `graph` is the Highways. Its nodes have x and y, and `in_lane` where robots park on them. Its edges have `length`,
    `speed` (a limit; inf if there is none) and perhaps `two_way`: the edge and its opposite are one lane, used in one
    direction at a time. An edge against a preferred direction `counts` as that many times its length in the choice of
    routes. A ride in a lift is an edge without length that `takes` its time, including the mean time until the cabin
    comes. Algorithm 1 tries the successors of a node in their order.

    `place_names`: numbers of storage places by their names. `widths`: widths of aisles by edge, inf if wide; an edge
    without an entry is in a narrow aisle. `floor_nodes`: nodes of each named floor, by the name of the floor.
    """

    graph: nx.DiGraph
    storage: tuple[StoragePlace, ...]
    bays: dict[str, BayPlaces]
    stations: dict[str, StationPlaces]
    goods_size: float = 0.0
    place_names: Mapping[str, int] = field(default_factory=dict)
    lifts: tuple[Lift, ...] = ()
    widths: Mapping[Edge, float] = field(default_factory=dict)
    floor_nodes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @cached_property
    def called(self) -> dict[int, str]:
        """The first name of each storage place by its number; empty if places have no names."""
        names: dict[int, str] = {}
        for name, number in self.place_names.items():
            names.setdefault(number, name)
        return names

    @cached_property
    def names_at(self) -> dict[str, tuple[str, ...]]:
        """The names of storage places at a node, beside an edge (`A>B`) or along a lane (`A-B`), sorted by offset."""
        names_by_position: defaultdict[str, list[str]] = defaultdict(list)
        for place in sorted(self.storage, key=attrgetter("offset")) if self.called else ():
            a, b = place.edge
            edges = {">".join(edge) for edge, _ in self.approaches(place.edge, place.offset)}
            for position in {a} if a == b else {*edges, "-".join(sorted(place.edge))}:
                names_by_position[position] += [self.called[place.number]] if place.number in self.called else []
        return {position: tuple(names) for position, names in names_by_position.items()}

    @property
    def two_way(self) -> list[Edge]:
        """The two-way lanes, each as one of its edges."""
        return [(a, b) for a, b, two_way in self.graph.edges(data="two_way") if two_way and a < b]

    @cached_property
    def lanes(self) -> list[Edge]:
        """The lanes in the order of the edges, each once; a two-way lane is given by the first of its two edges."""
        firsts: dict[frozenset[str], Edge] = {}
        return [
            (a, b)
            for a, b, two_way in self.graph.edges(data="two_way")
            if not two_way or firsts.setdefault(frozenset((a, b)), (a, b)) == (a, b)
        ]

    @cached_property
    def edges(self) -> tuple[tuple[Edge, float, float, bool], ...]:
        """The edges with their length, their speed limit, and whether they belong to a two-way lane."""
        edges = self.graph.edges(data=True)
        return tuple(((a, b), data["length"], data["speed"], bool(data.get("two_way"))) for a, b, data in edges)

    @property
    def labels(self) -> list[tuple[str, Edge]]:
        """The edges that a log may name, each with its label `A>B` there; goods at a node are at its edge to itself."""
        at_nodes = dict.fromkeys(place.edge for place in self.storage if place.edge[0] == place.edge[1])
        return [(">".join(edge), edge) for edge in (*self.graph.edges, *at_nodes)]

    @cached_property
    def has_limits(self) -> bool:
        """Whether any edge has a finite speed limit."""
        return any(math.isfinite(limit) for _, _, limit, _ in self.edges)

    @cached_property
    def in_lane(self) -> frozenset[str]:
        """The nodes on which robots park, so that no route leads through them."""
        return frozenset(node for node, bay in self.bays.items() if bay.in_lane)

    @cached_property
    def points(self) -> dict[str, complex]:
        """The positions of nodes as complex numbers x + iy."""
        return {node: complex(place["x"], place["y"]) for node, place in self.graph.nodes.items()}

    def length(self, edge: Edge) -> float:
        """Return the length of an edge; 0 for a node given as both ends."""
        return 0.0 if edge[0] == edge[1] else float(self.graph.edges[edge]["length"])

    def approaches(self, edge: Edge, offset: float) -> list[tuple[Edge, float]]:
        """Return the edges by which robots come to a place, each with the place's offset; two for a two-way lane."""
        length = self._two_way_lengths.get(edge)
        return [(edge, offset)] if length is None else [(edge, offset), ((edge[1], edge[0]), length - offset)]

    @cached_property
    def _two_way_lengths(self) -> dict[Edge, float]:
        return {edge: length for edge, length, _, two_way in self.edges if two_way}

    def nodes_of(self, name: str) -> tuple[str, ...]:
        """Return the nodes of the station of this name, or the node of this name alone."""
        if name in self.graph:
            return (name,)
        return tuple(node for node, station in self.stations.items() if station.zone == name)

    def position(self, edge: Edge, offset: float) -> tuple[float, float]:
        """Return the point `offset` length units along an edge drawn straight, or the point of a node as both ends."""
        source, target = self.graph.nodes[edge[0]], self.graph.nodes[edge[1]]
        if source is target:
            return source["x"], source["y"]
        part = offset / self.graph.edges[edge]["length"] if offset else 0.0
        return (
            source["x"] + part * (target["x"] - source["x"]),
            source["y"] + part * (target["y"] - source["y"]),
        )

    @cached_property
    def headings(self) -> dict[Edge, float]:
        """The directions of edges in radians: 0 along x, growing towards y.

        A ride has the direction of the way out of the cabin on arrival, as a robot turns in the cabin before the ride,
        however floors are drawn.
        """
        ways = {(a, b): self.points[b] - self.points[a] for a, b in self.graph.edges}
        for ride in self.rides:
            for node in self.graph[ride[1]]:
                if (ride[1], node) not in self.rides:
                    ways[ride] = ways[ride[1], node]
        return {edge: math.atan2(way.imag, way.real) for edge, way in ways.items()}

    @cached_property
    def floors(self) -> dict[str, int]:
        """The number of each node's floor, from 0 for the lowest; on one floor robots get about without a lift."""
        import networkx as nx

        lanes = nx.Graph(edge for edge in self.graph.edges if edge not in self.rides)
        lanes.add_nodes_from(self.graph)
        parts = list(nx.connected_components(lanes))
        part_of = {node: number for number, part in enumerate(parts) for node in part}
        above = nx.DiGraph()
        above.add_nodes_from(range(len(parts)))
        above.add_edges_from((part_of[a], part_of[b]) for lift in self.lifts for a, b in pairwise(lift.nodes))
        rank: dict[int, int] = {}
        together = nx.condensation(above)  # floors that lifts put above each other, and below
        for number in nx.lexicographical_topological_sort(
            together, key=lambda number: min(together.nodes[number]["members"])
        ):
            rank.update({part: len(rank) + more for more, part in enumerate(sorted(together.nodes[number]["members"]))})
        return {node: rank[part] for node, part in part_of.items()}

    @cached_property
    def floor_names(self) -> dict[int, str]:
        """The names of floors by their numbers, from the lowest up; the name of an unnamed floor is its number."""
        names = {self.floors[node]: name for name, nodes in self.floor_nodes.items() for node in nodes}
        return {number: names.get(number, str(number)) for number in sorted({*self.floors.values()})}

    @cached_property
    def floor_titles(self) -> dict[int, str]:
        """The titles of floors in drawings: their names, or `floor 1` if the name is only a number."""
        return {
            number: f"floor {name}" if name.lstrip("-").isdecimal() else name
            for number, name in self.floor_names.items()
        }

    @cached_property
    def cabins_beside(self) -> dict[str, list[str]]:
        """For each node of a lift's first cabin, the nodes of its other cabins on the floor."""
        first, beside = {lift.name: lift for lift in self.lifts}, defaultdict[str, list[str]](list)
        for lift in self.lifts:
            if lift.model_name != lift.name:
                for node, another in zip(first[lift.model_name].nodes, lift.nodes, strict=True):
                    beside[node].append(another)
        return dict(beside)

    @cached_property
    def rides(self) -> dict[Edge, Lift]:
        """The edges between floors, each with the lift that carries robots along it."""
        return {ride: lift for lift in self.lifts for ride in permutations(lift.nodes, 2)}
