"""The layout section of a model file: blocks to generate, or nodes and edges, and what stands there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)

from desim_warehouse.errors import did_you_mean, got, spoken
from desim_warehouse.layout import naming
from desim_warehouse.layout.blocks import Blocks, highways
from desim_warehouse.layout.riders import RidersSpec
from desim_warehouse.values.calendars import CalendarName
from desim_warehouse.values.distributions import Varying
from desim_warehouse.values.disturbances import OutageSpec
from desim_warehouse.values.fields import (
    SECTION,
    By,
    Coordinate,
    Count,
    Duration,
    Flag,
    Forms,
    FrozenMap,
    Length,
    Name,
    Named,
    NotNegative,
    Part,
    Speed,
    Time,
    Usual,
    Whole,
    at_most,
    form,
    known,
    limited,
    wrong,
)

Side = Literal["north", "south", "east", "west"]

_SHOWN = 12  # node names in a message
_EDGE = "an edge: [A, B] or a section with from and to"
_PAIR = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}

Positions = Mapping[str, tuple[float, float]]


def _node(name: str, info: ValidationInfo) -> str:
    """Return the name of a node; refuse a name that the layout does not have."""
    _known_node(name, info)
    return name


def _node_or(zones: str) -> AfterValidator:
    """Return a validator that refuses a name of neither a node nor a bay or station."""

    def check(name: str, info: ValidationInfo) -> str:
        _known_node(name, info, zones)
        return name

    return AfterValidator(check)


def _nodes(zones: str) -> AfterValidator:
    """Return a validator that replaces the name of a bay or station by its nodes.

    A bay or station that is itself wrong has no nodes: its name stays, so that the list does not count as empty.
    """

    def nodes(names: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
        here, zones_by_name = known(info).nodes or {}, known(info).zones.get(zones, {})
        return tuple(
            node for name in names for node in ((name,) if name in here else zones_by_name.get(name) or (name,))
        )

    return AfterValidator(nodes)


def _of_the_layout(edge: tuple[str, str], info: ValidationInfo) -> tuple[str, str]:
    edges = known(info).edges
    if edges and edge not in edges:
        turned = ", such as the opposite one" if edge[::-1] in edges else ""
        raise wrong(f"no such edge (got {got(edge)}), expected an edge of the layout{turned}")
    return edge


def _on_the_edge(offset: float, info: ValidationInfo) -> float:
    length = known(info).edges.get(info.data.get("edge", ("", "")))
    if length is not None and offset >= length:
        expected = f"an offset below the edge's length, {got(length)}"
        raise wrong(f"beyond the end of its edge (got {got(offset)}), expected {expected}")
    return offset


def _known_node(name: str, info: ValidationInfo, zones: str = "") -> None:
    nodes, zones_by_name = known(info).nodes, known(info).zones.get(zones, {})
    if not nodes or name in nodes or name in zones_by_name:
        return
    names, kind = list(nodes), f"node or {zones[:-1]}" if zones_by_name else "node"
    expected = f"one of {spoken(names, 'or')}"
    if len(names) > _SHOWN:
        expected = f"one of the {len(names)} nodes, {names[0]} to {names[-1]}"
    if zones_by_name:
        expected += f", or {zones[:-1]} {spoken(list(zones_by_name)[:_SHOWN], 'or')}"
    hint = did_you_mean(name, [*zones_by_name, *names])
    if all(end in nodes for end in name.split(">")):
        hint = f"; an edge is written [{', '.join(name.split('>'))}]"
    raise wrong(f"no such {kind} (got {got(name)}), expected {expected}{hint}")


NodeName = Annotated[Name, AfterValidator(_node)]

NodeOrStation = Annotated[Name, _node_or("stations")]
NodesOfBays = Annotated[tuple[Annotated[Name, _node_or("bays")], ...], _nodes("bays")]
NodesOfStations = Annotated[tuple[Annotated[Name, _node_or("stations")], ...], _nodes("stations")]

EdgeName = Annotated[tuple[Name, Name], AfterValidator(_of_the_layout)]
Offset = Annotated[Length, AfterValidator(_on_the_edge)]


def _line(nodes: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
    edges = known(info).edges
    if len(nodes) == 1:
        raise wrong(f"one node (got {got(nodes[0])}), expected two or more along an aisle, such as [A, B]")
    for a, b in pairwise(nodes):
        if edges and (a, b) not in edges and (b, a) not in edges:
            raise wrong(f"no edge from one to the next (got {got([a, b])}), expected nodes along edges")
    return nodes


Aisle = Annotated[tuple[NodeName, ...], Field(min_length=1), AfterValidator(_line)]


def see_node(name: str, info: ValidationInfo, *keys: str) -> None:
    """Refuse the name of a node that the layout does not have, naming its `keys` below the value that is checked."""
    nodes = known(info).nodes
    if nodes and name not in nodes:
        hint = did_you_mean(name, nodes)
        raise wrong(f"no such node, expected one of the {len(nodes)} nodes of the layout{hint}", *keys)


def _short_edge(value: Any) -> Any:
    """Accept `[A, B]` for `{from: A, to: B}`."""
    if isinstance(value, list | tuple) and len(value) == 2:  # noqa: PLR2004 - a pair
        return {"from": value[0], "to": value[1]}
    if not isinstance(value, SECTION):
        raise wrong(f"not an edge (got {got(value)}), expected {_EDGE}")
    return value


class Edge(Part):
    """An edge of the Highways, one-way by default; `[A, B]` for short.

    Two opposite edges between two nodes are one two-way lane, unless they are side by side.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, defer_build=True)

    source: NodeName = Field(alias="from", description="the node it leaves")
    target: NodeName = Field(alias="to", description="the node it leads to")
    length: Length | None = Field(None, description="default: the straight distance")
    speed: Speed | None = Field(None, title="speed limit", description="speed limit; default: none")
    speed_back: Speed | None = Field(
        None, title="speed limit back", description="with two_way, the speed limit from `to` to `from`; default: speed"
    )
    two_way: Flag = Field(False, description="one lane for both directions, used in one at a time")
    side_by_side: Flag = Field(False, description="with an edge back: two lanes side by side, not one for both")
    against: Annotated[float, Field(strict=True, ge=1), limited()] = Field(
        1.0,
        description="factor by which its length counts in the choice of routes when it is driven the other way, from "
        "`to` to `from`",
    )

    @model_validator(mode="after")
    def _only_once(self, info: ValidationInfo) -> Edge:
        edge, edges = (self.source, self.target), known(info).edges
        if self.source == self.target:
            raise wrong(f"from a node to itself (got {got(edge)}), expected two nodes")
        if edge in edges:
            raise wrong(f"the same edge as one before (got {got(edge)}), expected every edge once")
        length = self.length or _straight(*((known(info).nodes or {}).get(node) for node in edge))
        edges.update(dict.fromkeys((edge, edge[::-1]) if self.two_way else (edge,), length))
        return self


def _straight(*ends: Any) -> float | None:
    """Return the distance between two nodes; None if either has no coordinates."""
    try:
        return math.dist(*ends)
    except (TypeError, ValueError, OverflowError):  # reported where the coordinates are checked
        return None


class Storage(Part):
    """A storage place beside an edge, `offset` from the edge's start; its number is its position in the list."""

    edge: EdgeName = Field(description="[from, to]: the edge it is picked from")
    offset: Offset = Field(description="distance from the edge's start")
    popularity: NotNegative = Field(1.0, description="relative demand")


class NodeStorage(Part):
    """A storage place at a node, picked by a robot that stands on the node, whichever edge it came by."""

    node: NodeName = Field(description="the node it is picked from")
    popularity: NotNegative = Field(1.0, description="relative demand")

    @model_validator(mode="before")
    @classmethod
    def _no_edge(cls, value: Any) -> Any:
        beside = [key for key in ("edge", "offset") if isinstance(value, Mapping) and key in value]
        if beside:
            raise wrong(f"{spoken(beside)} beside node, expected edge and offset, or node alone", beside[0])
        return value


def edge_or_node(value: Any) -> str | None:
    """Return the form of a storage place: on an edge or at a node."""
    at_node = "node" in value if isinstance(value, Mapping) else hasattr(value, "node")
    return ("\0node" if at_node else "\0edge") if isinstance(value, SECTION) else None


class StorageFile(Part):
    """Storage places from a CSV file with the columns from, to, offset, or node, and optionally popularity.

    If the file has both kinds of columns, each row fills only one kind.
    """

    file: Name = Field(description="CSV file, relative to the model file")


class NamesFile(Part):
    """Names of storage places from a CSV file with the columns name and place (a number); a place may have several."""

    file: Name = Field(description="CSV file, relative to the model file")


class PlaceNames(Part):
    """Names of storage places: by a pattern of aisle, bay and level, or one by one."""

    pattern: Name | None = Field(
        None,
        description="such as '{aisle:02}-{bay:03}-{level}', with aisle (edges with places, as listed), bay (along "
        "it), level, number, aisle_letter and level_letter; all but number are counted from 1",
    )
    levels: Count = Field(1, description="with pattern: levels of a place, each with its own name")
    places: Annotated[Mapping[Name, Whole], AfterValidator(FrozenMap)] = Field(
        FrozenMap(), description="instead of pattern: numbers of places by their names"
    )

    @field_validator("pattern")
    @classmethod
    def _simple(cls, pattern: str | None) -> str | None:
        if pattern is not None and (wrong_part := naming.wrong_part(pattern)):
            raise wrong(f"not a pattern ({wrong_part}), expected fields {spoken(naming.FIELDS)}, such as {{bay:03}}")
        return pattern

    @model_validator(mode="after")
    def _one_way(self) -> PlaceNames:
        if (self.pattern is None) == (not self.places):
            raise wrong("expected a pattern, or names one by one, and not both")
        return self


class PlacesSpec(Part):
    """Nodes by name (`at`), or every n-th node along a side of the layout (`along`, `every`)."""

    at: tuple[NodeName, ...] = Field((), title="nodes", description="nodes by name")
    along: Side | None = Field(None, title="side", description="all nodes along this side")
    every: Count = Field(1, description="with along: every n-th node")

    def nodes(self, positions: Positions) -> list[str]:
        """Return the nodes listed by name, then every n-th along the side (west to east, or north to south)."""
        nodes = list(self.at)
        if self.along is not None:
            axis, pick = {"north": (1, min), "south": (1, max), "west": (0, min), "east": (0, max)}[self.along]
            outermost = pick(point[axis] for point in positions.values())
            side = [name for name, point in positions.items() if point[axis] == outermost]
            nodes += sorted(side, key=lambda name: positions[name][1 - axis])[:: self.every]
        return nodes

    @field_validator("every")
    @classmethod
    def _of_a_side(cls, every: int, info: ValidationInfo) -> int:
        if every > 1 and info.data.get("along", "wrong") is None:
            raise wrong(f"every n-th node of no side (got {every}), expected along (a side) beside it")
        return every

    @model_validator(mode="after")
    def _somewhere(self) -> PlacesSpec:
        if not self.at and self.along is None:
            raise wrong("at no node, expected at (a list of nodes) or along (a side)")
        return self


def _one_a_place(count: int | None, info: ValidationInfo) -> int | None:
    places = info.data.get("places")
    if count is not None and places is not None and count > places and not info.data.get("grows"):
        raise wrong(f"too many (got {count}), expected at most one for each of the {places} places")
    return count


class BaySpec(PlacesSpec):
    """Parking slots beside a node, entered and left through the node; `chargers` of them have a charger.

    If its chargers are for some kinds only, robots of these kinds start there, and leave chargers for all kinds to
    other robots while their own are free. Other robots park there only if no other slot is free, and make room. Making
    room takes a free slot, so have more slots than robots.
    """

    places: Annotated[Count, limited("robots")] | None = Field(
        None,
        title="slots",
        description="slots at each node; default: one for each robot that starts there and for each of total_chargers",
    )
    grows: Flag = Field(
        False,
        description="with places: if more robots start at a node, it gets a slot for each of them and for each "
        "charger; a node without chargers gets one more, so that a robot can leave its slot at a charger to another",
    )
    chargers: Annotated[Annotated[Whole, limited("robots")] | None, AfterValidator(_one_a_place)] = Field(
        None, description="at each node; default: one for each slot"
    )
    total_chargers: Whole | None = Field(
        None,
        description="instead of chargers: in total, assigned to its nodes round-robin",
    )
    in_lane: Flag = Field(
        False,
        description="its nodes are the slots, one each: no route leads through them, as a robot may be parked there",
    )

    outages: OutageSpec | None = Field(None, description="failures of each of its chargers; none: they never fail")
    kinds: tuple[Name, ...] = Field(
        (),
        title="whose chargers",
        description="kinds of robots (fleet.kinds) that may use its chargers; default: all",
    )

    @property
    def lacks_chargers(self) -> bool:
        """Whether a robot may stand in the bay without a charger for it."""
        if self.kinds or self.total_chargers is not None:
            return True
        return self.chargers is not None and (self.grows or self.places is None or self.chargers < self.places)

    @model_validator(mode="after")
    def _one_in_the_lane(self) -> BaySpec:
        if self.in_lane and self.places not in {None, 1}:
            raise wrong(f"too many for a bay in the lane (got {self.places}), expected 1: the node itself", "places")
        if self.grows and self.in_lane:
            raise wrong("a bay in the lane has one slot, the node itself, expected grows only off the lane", "grows")
        return self

    @model_validator(mode="after")
    def _of_chargers(self) -> BaySpec:
        if self.outages is not None and 0 in (self.chargers, self.total_chargers):
            raise wrong("outages of no charger, expected chargers above 0, or none of this", "outages")
        return self

    @model_validator(mode="after")
    def _each_or_total(self) -> BaySpec:
        if self.chargers is not None and self.total_chargers is not None:
            text = f"given together with chargers (got {self.total_chargers}), expected one (chargers: at each node)"
            raise wrong(text, "total_chargers")
        return self


class StationSpec(PlacesSpec):
    """Stations beside nodes: `places` robots fit in, `servers` of them are served at a time.

    Robots inside that are not yet served when the station closes wait in the state `closed`. Tasks are held back at the
    source until a robot driving freely would find the station open; a task that may go to several stations goes to an
    open one. If load units are worked on at the station, a task is done when the work on its load unit is done
    (`tasks.done_when`), and workers keep the hours of the station.
    """

    places: Annotated[Count, limited("robots")] = Field(4, description="robots that fit inside at each node")
    servers: Annotated[Count, AfterValidator(_one_a_place)] = Field(
        1, description="robots served at a time at each node"
    )
    hours: CalendarName | None = Field(
        None,
        description="opening hours (a calendar), outside which nothing begins there; default: always open",
    )
    at_close: Literal["finish", "pause"] = Field(
        "finish",
        description="whether work in hand is finished at closing time, or pauses until the station opens again",
    )
    load_time: Annotated[Varying | None, Usual("1 s", "1 h")] = Field(
        None, description="loading time there; default: that of the flow or of tasks"
    )
    unload_time: Annotated[Varying | None, Usual("1 s", "1 h")] = Field(
        None, description="unloading time there; default: that of the flow or of tasks"
    )
    # one piece into a tote takes 3 s or more; a pallet is repacked in hours
    work_time: Annotated[Varying | None, Usual("3 s", "8 h")] = Field(
        None, description="time to work on each load unit that is put down there; default: none"
    )
    workers: Count = Field(1, description="with work_time: load units worked on at a time, at each node")
    buffer: Count | None = Field(
        None,
        description="with work_time: places at each node for load units that wait or are worked on; when it is full, "
        "robots wait at the server; default: unlimited",
    )

    def is_random(self, model: Any) -> bool:
        """Whether a time there varies that runs draw: no run draws `load_time` where no flow begins."""
        if self.load_time is None or self._begins_a_flow(model):
            return super().is_random(model)
        return self.model_copy(update={"load_time": None}).is_random(model)

    def _begins_a_flow(self, model: Any) -> bool:
        """Whether loads may be picked up there; a file of orders may name any station."""
        named = [name for name, spec in model.layout.stations.items() if spec is self]
        return bool(model.tasks.may_begin_at({node for name in named for node in model.floor.nodes_of(name)}))

    @model_validator(mode="after")
    def _something_to_do(self) -> StationSpec:
        if self.work_time is None:
            for key in ("buffer", "workers"):
                if getattr(self, key) != type(self).model_fields[key].default:
                    raise wrong(f"without work (got {got(getattr(self, key))}), expected work_time beside it", key)
        if self.buffer is not None and self.workers > self.buffer:
            text = f"too many (got {self.workers}), expected at most one for each place of the buffer, {self.buffer}"
            raise wrong(text, "workers")
        if self.at_close != "finish" and self.hours is None:
            raise wrong(f"it never closes (got {got(self.at_close)}), expected hours beside it", "at_close")
        return self


class LiftSpec(Part):
    """A lift, whose cabin carries one robot at a time between floors, which are joined only by lifts.

    A robot calls the cabin once there is room for it beyond the doors on the other floor. The doors open when the cabin
    has come, close behind the robot, open on its floor, and close behind it again.
    """

    nodes: tuple[NodeName, ...] = Field(
        (),
        title="stops of a lift",
        description="its node on each floor, from the lowest up; the lane to each begins in front of the doors there",
    )
    fronts: tuple[NodeName, ...] = Field(
        (),
        alias="at",
        title="nodes in front of a lift",
        description="instead of nodes: the node in front of its doors on each floor, from the lowest up; its own "
        "node is drawn beside each, where there is most room, with a lane in and a lane out",
    )
    lane: Annotated[Length | None, Usual("1 m", "20 m")] = Field(
        None, title="lanes of a lift", description="with at: length of these lanes, 2 D or more"
    )
    ride: Annotated[Duration, Usual("2 s", "2 min")] = Field(
        title="ride of a lift", description="time of its cabin from one floor to the next"
    )
    doors: Annotated[Time, Usual("1 s", "20 s")] = Field(
        0.0, title="doors of a lift", description="time its doors take to open, and the same to close"
    )
    rests: NodeName | None = Field(
        None,
        title="where a lift rests",
        description="the node (of nodes or at) to which the empty cabin returns; default: it stays where it was left",
    )
    cabins: Annotated[Count, Usual(1, 8)] = Field(
        1,
        title="cabins",
        description="number of such lifts side by side, each with its own doors and lanes from the same nodes; "
        "`fastest` routes without `spread` take only one of them",
    )
    people: RidersSpec | None = Field(None, description="people who also ride in it; default: only robots do")
    outages: OutageSpec | None = Field(None, description="failures of each of its cabins; none: they never fail")

    @model_validator(mode="after")
    def _stops(self) -> LiftSpec:
        key, stops = ("at", self.fronts) if self.fronts else ("nodes", self.nodes)
        if self.fronts and self.nodes:
            raise wrong(f"given together with nodes (got {got(list(self.fronts))}), expected one of the two", "at")
        if len(stops) < 2:  # noqa: PLR2004 - from one floor to another
            raise wrong(f"too few floors (got {got(list(stops))}), expected a node on each of two or more", key)
        double = next((node for rank, node in enumerate(stops) if node in stops[:rank]), None)
        if double is not None:
            raise wrong(f"a node twice (got {got(double)}), expected another on each floor", key)
        if self.rests is not None and self.rests not in stops:
            raise wrong(f"no stop of the lift (got {got(self.rests)}), expected {spoken(stops, 'or')}", "rests")
        if bool(self.fronts) != (self.lane is not None):
            text = "without at, which it belongs to, expected nodes alone, or at and lane"
            if self.fronts:
                text = "not said, expected the length of the lanes into and out of the cabin, 2 D or more"
            raise wrong(text, "lane")
        return self

    def stops(self, name: str) -> tuple[str, ...]:
        """Return the nodes of the cabin of a lift with this name, from the lowest floor up."""
        return self.nodes or tuple(f"{name} at {front}" for front in self.fronts)


_WIDTH = "'wide', 'narrow', or a width"


def _form_of_width(value: Any) -> str | None:
    """Return the form of a value of `aisles` or `width`: a word, a length, or sections by name."""
    if isinstance(value, SECTION):
        return "\0lines"
    if isinstance(value, str) and value.strip()[:1].isalpha():
        return "\0word"
    return "\0length" if isinstance(value, str | int | float) else None


def _lines(aisles: Any) -> Any:
    """Refuse the nodes of a single line where a list of lines is expected."""
    if isinstance(aisles, list | tuple) and len(aisles) > 1 and all(isinstance(name, str) for name in aisles):
        raise wrong(f"nodes of one line (got {got(aisles)}), expected a list of lines: write {got([aisles])}")
    return aisles


class AisleSpec(Part):
    """Aisles of one width, by the nodes along each of them. All other aisles are narrow.

    In an aisle that is wide, or at least twice as wide as the distance D that robots keep, a robot that loads or
    unloads at a storage place stands beside its lane if the lane is long enough, and others drive past.
    """

    along: Annotated[tuple[Aisle, ...], BeforeValidator(_lines)] = Field(
        title="lines of nodes",
        min_length=1,
        description="nodes along each aisle, such as [A, B] for an edge or [A, B, C] for two in a line, in both "
        "directions where there are two",
    )
    width: Annotated[
        Annotated[Literal["wide", "narrow"], form("word")]
        | Annotated[Annotated[Length, Usual("50 cm", "20 m")], form("length")],
        Forms(_WIDTH, pick=_form_of_width),
    ] = Field("wide", title="width of an aisle", description="wide, narrow, or the width of its free floor")


class LayoutSpec(Part):
    """The layout section: `blocks`, or `nodes` with `edges` and `storage`; then bays, stations and lifts at nodes."""

    file: Name | None = Field(
        None,
        description="JSON file with keys of this section, relative to the model file: for large layouts",
    )
    blocks: Blocks | None = Field(None, description="a layout to generate")
    nodes: Named[tuple[Coordinate, Coordinate]] = Field(FrozenMap(), description="name: [x, y], y downwards")
    edges: tuple[Annotated[Edge, BeforeValidator(_short_edge), Forms(_EDGE, _PAIR)], ...] = Field(
        (), description="edges between the nodes; with blocks, only those that their aisles lack"
    )
    storage: Annotated[
        tuple[
            Annotated[
                Annotated[Storage, form("edge")] | Annotated[NodeStorage, form("node")],
                Forms("a section with edge and offset, or with node", pick=edge_or_node),
            ],
            ...,
        ],
        Forms("a list of storage places (edge, offset; or node), or {file: storage.csv}", StorageFile),
    ] = Field(
        (),
        description="storage places, numbered from 0 as listed; none needed if all flows run between stations or nodes",
    )
    storage_names: Annotated[PlaceNames | None, Forms("a pattern with fields, or {file: names.csv}", NamesFile)] = (
        Field(None, description="names of storage places, for orders and drawings; default: numbers")
    )
    bays: Annotated[Named[BaySpec], By("in")] = Field(
        FrozenMap(), description="departure, parking and charging zones by name"
    )
    stations: Annotated[Named[StationSpec], By("at")] = Field(FrozenMap(), description="stations beside nodes by name")
    lifts: Annotated[Named[LiftSpec], By("of")] = Field(
        FrozenMap(), title="lifts", description="lifts between floors by name"
    )
    floors: Named[Annotated[tuple[NodeName, ...], Field(min_length=1)]] = Field(
        FrozenMap(),
        title="names of floors",
        description="with lifts: a node of each floor, by the name of the floor, or a node of each part if only "
        "lifts join its parts; default: numbers from 0, the lowest",
    )
    aisles: Annotated[
        Annotated[Literal["wide", "narrow"], form("word")]
        | Annotated[Annotated[Length, Usual("50 cm", "20 m")], form("length")]
        | Annotated[Named[AisleSpec], form("lines")],
        Forms(f"{_WIDTH}, for all aisles, or sections with along and width, by name", pick=_form_of_width),
    ] = Field(
        "narrow",
        title="width of aisles",
        description="narrow: a robot that loads or unloads at a storage place stands in its lane; wide, or a width "
        "of at least twice the distance D that robots keep: it stands beside the lane, and others drive past; for "
        "all aisles, or by name",
    )

    @property
    def may_be_wide(self) -> bool:
        """Whether any aisle is other than `narrow`."""
        if isinstance(self.aisles, Mapping):
            return any(aisles.width != "narrow" for aisles in self.aisles.values())
        return self.aisles != "narrow"

    @property
    def storage_places(self) -> int:
        """The number of storage places."""
        return len(self.storage) if self.blocks is None else self.blocks.places

    @property
    def two_way(self) -> bool:
        """Whether any lane is two-way: an edge, two opposite edges together, or an aisle of blocks."""
        if self.blocks is not None and (self.blocks.two_way or self._meets_blocks):
            return True
        drawn = {(edge.source, edge.target) for edge in self.edges}
        beside = {frozenset((edge.source, edge.target)) for edge in self.edges if edge.side_by_side}
        return any(
            (edge.two_way or (edge.target, edge.source) in drawn)
            and frozenset((edge.source, edge.target)) not in beside
            for edge in self.edges
        )

    @property
    def _meets_blocks(self) -> bool:
        """Whether an edge beside blocks leads back along an aisle of the blocks, so that the two edges are one lane."""
        aisles = () if self.blocks is None or not self.edges else highways(self.blocks).edges
        return any((edge.target, edge.source) in aisles and not edge.side_by_side for edge in self.edges)

    @property
    def has_hours(self) -> bool:
        """Whether any station has a calendar."""
        return any(station.hours is not None for station in self.stations.values())

    @property
    def has_slots_without_charger(self) -> bool:
        """Whether robots may rest in a bay that does not have a charger for each of them."""
        return any(bay.lacks_chargers for bay in self.bays.values())

    @field_validator("blocks", mode="before")
    @classmethod
    def _generated(cls, blocks: Any, info: ValidationInfo) -> Any:
        known(info).blocks = blocks is not None
        return blocks

    @field_validator("nodes", "edges", "storage", mode="before")
    @classmethod
    def _not_beside_blocks(cls, value: Any, info: ValidationInfo) -> Any:
        if known(info).blocks and value and info.field_name != "edges":
            raise wrong(f"blocks make their own {info.field_name}, expected blocks, or nodes, edges and storage")
        if info.field_name == "edges" and value and (blocks := info.data.get("blocks")) is not None:
            known(info).edges.update({(a, b): length for a, b, length in highways(blocks).edges(data="length")})
        limit = "places" if info.field_name == "storage" else str(info.field_name)
        at_most(limit, len(value) if isinstance(value, list | Mapping) else 0)
        if info.field_name == "nodes" and isinstance(value, Mapping) and value:
            known(info).nodes = value
        return value

    @field_validator("nodes")
    @classmethod
    def _apart(
        cls, nodes: Mapping[str, tuple[float, float]], info: ValidationInfo
    ) -> Mapping[str, tuple[float, float]]:
        first: dict[tuple[float, float], str] = {}
        for name, point in nodes.items():
            if first.setdefault(point, name) != name:
                raise wrong(f"at the same place as node '{first[point]}' (got {got(point)}), expected another", name)
        known(info).nodes = nodes or known(info).nodes
        return nodes

    @field_validator("bays", "stations", mode="before")
    @classmethod
    def _named(cls, zones: Any, info: ValidationInfo) -> Any:
        known(info).zones[str(info.field_name)] = dict.fromkeys(zones, ()) if isinstance(zones, Mapping) else {}
        return zones

    @field_validator("bays", "stations")
    @classmethod
    def _placed(cls, zones: Mapping[str, PlacesSpec], info: ValidationInfo) -> Mapping[str, PlacesSpec]:
        nodes = known(info).nodes
        if nodes:
            known(info).zones[str(info.field_name)] = {name: tuple(zone.nodes(nodes)) for name, zone in zones.items()}
        return zones

    @field_validator("lifts")
    @classmethod
    def _drawn_beside(cls, lifts: Mapping[str, LiftSpec], info: ValidationInfo) -> Mapping[str, LiftSpec]:
        """Let other sections name the nodes and lanes that lifts add."""
        nodes = known(info).nodes
        for name, lift in lifts.items() if nodes else ():
            for node, front in zip(lift.stops(name), lift.fronts, strict=False):
                known(info).nodes = {**(known(info).nodes or {}), node: None}
                known(info).edges.update(dict.fromkeys(((front, node), (node, front)), lift.lane))
        return lifts

    @field_validator("floors")
    @classmethod
    def _beside_lifts(cls, floors: Mapping[str, Any], info: ValidationInfo) -> Mapping[str, Any]:
        if floors and not info.data.get("lifts", True):
            raise wrong(f"one floor alone (got {got(list(floors))}), expected layout.lifts, which lead to others")
        return floors

    @field_validator("storage")
    @classmethod
    def _count(
        cls, storage: tuple[Storage | NodeStorage, ...], info: ValidationInfo
    ) -> tuple[Storage | NodeStorage, ...]:
        if storage:
            known(info).places = len(storage)
        return storage
