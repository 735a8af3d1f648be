"""Graphs for `desim import`: graphs of networkx, and GraphML and JSON files, which are read safely.

Nodes have x and y (or pos) and optionally role and station; edges optionally have length, speed (or maxspeed in km/h,
as in OpenStreetMap), two_way or one_way, and side_by_side. An edge without direction is a two-way lane. Without a
length, `weight`, as networkx calls it, is the length if every edge has one and none is shorter than the straight line.
JSON graphs are as `networkx.node_link_data` writes them: nodes with id, and links (or edges) with source and target.

Source: GraphML Primer (graphml.graphdrafting.org); yEd's y:Geometry and y:NodeLabel are read if nodes have no x.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ModelError, first_of, got
from desim_warehouse.model.json_text import read_json
from desim_warehouse.plants.plant import Plant
from desim_warehouse.plants.tables import EDGE, NODE, OSM, Columns, TableRecord, fill, of_maps
from desim_warehouse.plants.xml import Element, read_xml

if TYPE_CHECKING:
    import networkx as nx

EXPECTED = "a graph (GraphML)"
_NAME = "node"  # column of a node's id, which is no attribute of it
_TAIL, _HEAD = "from_node", "to_node"
_WEIGHT, _SLACK = "weight", 0.99
_NODE_LINK = re.compile(rb'\{\s*"(directed|multigraph|graph|nodes|links|edges)"\s*:')
_PAIR = re.compile(r"[(\[]?\s*([-+.\deE]+)\s*[,;\s]\s*([-+.\deE]+)(?:\s*[,;\s]\s*[-+.\deE]+)?\s*[)\]]?")
"""A position as text, as `str` makes it for GraphML, which has no lists; a third number is its height."""
LINKS = "a graph (JSON)"
_DIRECTED = {"true": {"two_way": "no"}, "false": {"two_way": "yes"}}

Rows = list[tuple[str, str, dict[str, Any]]]
"""Nodes or edges as triples: place for messages, position in the file, and values by name."""


def looks(path: Path, start: bytes) -> bool:
    """Return whether a file may be GraphML, by its ending or its root element."""
    return path.suffix.lower() == ".graphml" or b"<graphml" in start


def from_networkx(graph: nx.Graph, name: str = "") -> Plant:
    """Return the plant of a graph of networkx; see `desim_warehouse.read_layout`.

    Raises:
        ModelError: an attribute with a wrong value, with its node or edge.
    """
    title = name or str(graph.graph.get("name") or "graph")
    plant = Plant(title, "a graph of networkx")
    if "crs" in graph.graph:
        text = "coordinates on the globe (crs), expected metres; write the edges as GeoJSON, which is projected"
        raise ModelError([f"graph {got(title)}: {text}"])
    nodes = [(f"node {got(str(node))}", "", {**_position(data), _NAME: node}) for node, data in graph.nodes(data=True)]
    edges = [
        (f"edge {got(str(a))} to {got(str(b))}", "", {**data, _TAIL: a, _HEAD: b})
        for a, b, data in graph.edges(data=True)
    ]
    _fill(plant, nodes, edges, not graph.is_directed())
    return plant


def _position(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes of a node, with x and y in place of `pos`."""
    values = {str(key): value for key, value in data.items()}
    position: Any = values.get("pos")
    if isinstance(position, str) and (pair := _PAIR.fullmatch(position.strip())):
        position = pair.groups()
    if "x" in values or isinstance(position, str) or not hasattr(position, "__len__") or len(position) not in {2, 3}:
        return values
    del values["pos"]
    return {"x": position[0], "y": position[1], **values}


def _fill(plant: Plant, nodes: Rows, edges: Rows, two_way: bool) -> None:
    """Fill a plant from rows; ids and ends of the graph have precedence over attributes with these names."""
    node_headings = {**NODE, "name": (_NAME,)}
    edge_headings = {**EDGE, "name": ("name",), "from": (_TAIL,), "to": (_HEAD,)}
    node_columns = Columns.of(_titles(nodes), node_headings, f"{plant.source}: nodes")
    edge_columns = Columns.of(_titles(edges), edge_headings, f"{plant.source}: edges", OSM)
    node_columns.require(f"{plant.source}: nodes", "x", *(() if "north" in node_columns.named else ("y",)))
    fill(
        plant,
        [TableRecord(node_columns, values, where, position) for where, position, values in nodes],
        [TableRecord(edge_columns, values, where, position) for where, position, values in edges],
        two_way=two_way,
    )
    if (title := edge_columns.named.get("speed")) in OSM:
        plant.assume("layout.edges", of_maps(title))
    unread = list(edge_columns.unread)
    if "length" not in edge_columns.named and _WEIGHT in unread:
        unread.remove(_WEIGHT)
        _weigh(plant, [values.get(_WEIGHT) for *_, values in edges])
    for kind, names in (("node", node_columns.unread), ("edge", unread)):
        plant.note("left out", f"attribute of {kind}s", names, "nothing that a layout has")


def _weigh(plant: Plant, weights: list[Any]) -> None:
    """Take weights as lengths (m), unless a weight is missing or shorter than the straight line; noted either way."""
    lengths = []
    for link, weight in zip(plant.links, weights, strict=True):
        a, b = plant.points[link.source], plant.points[link.target]
        try:
            length = float(weight)
        except (TypeError, ValueError, OverflowError):
            length = math.nan
        lengths.append(length if _SLACK * math.dist((a.x, a.y), (b.x, b.y)) <= length < math.inf else math.nan)
    if any(map(math.isnan, lengths)):
        why = "no lengths, as one at least is missing or shorter than the straight line; call lengths 'length'"
        plant.note("left out", "attribute of edges", [_WEIGHT], why)
        return
    plant.links[:] = [replace(link, length=length or None) for link, length in zip(plant.links, lengths, strict=True)]
    plant.assume("layout.edges", f"their '{_WEIGHT}' is the length in metres")


def looks_like_links(path: Path, start: bytes) -> bool:  # noqa: ARG001 - as all formats
    """Return whether a file may be a graph in JSON, by its first key."""
    return _NODE_LINK.match(start) is not None


def read_links(path: Path, content: bytes) -> Plant:
    """Read a graph in JSON, as networkx and D3 write it.

    Raises:
        ModelError: a graph that cannot be read, with the node or link.
    """
    data = read_json(path, content, LINKS)
    about = data.get("graph") if isinstance(data, dict) else None
    plant = Plant(str((about.get("name") if isinstance(about, dict) else None) or path.stem), f"{path.name} (JSON)")
    key = "links" if isinstance(data, dict) and "links" in data else "edges"
    rows: dict[str, Rows] = {}
    for name, ends in (("nodes", {"id": _NAME}), (key, {"source": _TAIL, "target": _HEAD})):
        items = data.get(name) if isinstance(data, dict) else None
        if not isinstance(items, list):
            raise ModelError([f"{path}: {name}: not a list (got {got(items)}), expected {LINKS} with nodes and links"])
        rows[name] = []
        for rank, item in enumerate(items):
            where = f"{name}[{rank}]"
            if not isinstance(item, dict):
                raise ModelError([f"{path}: {where}: not an object (got {got(item)}), expected {LINKS}"])
            if missing := [theirs for theirs in ends if item.get(theirs) is None]:
                has = first_of([got(each) for each in item], 8) or "nothing"
                raise ModelError([f"{path}: {where}: no '{missing[0]}' (it has {has}), expected it, as in networkx"])
            values = {k: v for k, v in _position(item).items() if k not in ends}
            own = {ours: str(item[theirs]) for theirs, ours in ends.items()}
            rows[name].append((f"{path}: {where}", where, {**values, **own}))
    for name, value in data.items():
        if name not in {"directed", "multigraph", "graph", "nodes", key}:
            plant.see_keys([name], (), name)
        elif name == "directed" and not isinstance(value, bool):
            raise ModelError([f"{path}: directed: neither true nor false (got {got(value)}), expected one of the two"])
    _fill(plant, rows["nodes"], rows[key], not data.get("directed", False))
    return plant


def _titles(rows: Rows) -> Iterable[str]:
    return dict.fromkeys(key for *_, values in rows for key in values)


def read(path: Path, content: bytes) -> Plant:
    """Read a GraphML file.

    Raises:
        ModelError: a file that cannot be read, with the line.
    """
    root = read_xml(path, content, EXPECTED)
    if root.tag != "graphml":
        root.refuse(f"not a graph, expected {EXPECTED} with the root element graphml")
    graph = next(root.all("graph"), None)
    if graph is None:
        root.refuse("no graph, expected one")
    keys = _Keys(root)
    plant = Plant(graph.attributes.get("id") or path.stem, f"{path.name} (GraphML)")
    nodes: Rows = []
    edges: Rows = []
    two_way = graph.attributes.get("edgedefault", "directed") == "undirected"
    for item in graph.children:
        if item.tag == "node":
            nodes.append(
                (_where(item, "id"), item.position, {**_position(keys.values(item, "node")), _NAME: item.text("id")})
            )
        elif item.tag == "edge":
            own = _DIRECTED.get(item.attributes.get("directed", ""), {})
            ends = {_TAIL: item.text("source"), _HEAD: item.text("target")}
            edges.append(
                (_where(item, "source", "target"), item.position, {**own, **keys.values(item, "edge"), **ends})
            )
    others = [got(item.tag) for item in graph.children if item.tag not in {"node", "edge", "data", "desc"}]
    _fill(plant, nodes, edges, two_way)
    plant.note("left out", "element", sorted(set(others)), "nothing but nodes and edges is read")
    inner = [item.text("id") for item in graph.all("node") if any(item.all("graph"))]
    plant.note("left out", "graph inside a node", inner, "only the outer graph is read")
    more = [each.attributes.get("id", "without a name") for each in list(root.all("graph"))[1:]]
    plant.note("left out", "graph", more, "only the first one of the file is read")
    return plant


def _where(item: Element, *names: str) -> str:
    ends = " to ".join(got(item.text(name)) for name in names)
    return f"{item.file}:{item.line}: {item.tag} {ends}"


class _Keys:
    """The keys of a GraphML file: their names, and their defaults for nodes and edges."""

    def __init__(self, root: Element) -> None:
        self.names: dict[str, str] = {}
        self.defaults: dict[str, dict[str, str]] = {"node": {}, "edge": {}}
        for key in root.all("key"):
            name = self.names[key.text("id")] = key.attributes.get("attr.name") or key.text("id")
            for default in key.all("default"):
                for kind, its in self.defaults.items():
                    if key.attributes.get("for", "all") in {kind, "all"}:
                        its[name] = default.content

    def values(self, item: Element, kind: str) -> dict[str, str]:
        """Return the attributes of a node or edge by name."""
        attributes = dict(self.defaults[kind])
        for data in item.all("data"):
            key = data.text("key")
            if key not in self.names:
                data.refuse(f"of a key that the file does not have (got {got(key)}), expected the id of a key")
            if data.children:
                attributes.update(_drawn(data))
            else:
                attributes[self.names[key]] = data.content
        return attributes


def _drawn(data: Element) -> Iterator[tuple[str, str]]:
    """Yield the coordinates of a node as yEd draws it: its centre, in yEd's units, y downwards."""
    for shape in data.children:
        for place in shape.all("y:Geometry"):
            for axis, side in (("x", "width"), ("y", "height")):
                yield axis, repr(place.number(axis) + place.number(side, default=0.0) / 2)
