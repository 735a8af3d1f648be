"""A model whose two-way lanes are made one-way, or prefer a direction: in its file, comments and all, or as a model."""

from __future__ import annotations

import io
from collections import ChainMap
from typing import TYPE_CHECKING, Any

import networkx as nx

from desim_warehouse.errors import ModelError
from desim_warehouse.layout.orient import Orientation, orient_lanes
from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.model import layout_file
from desim_warehouse.model.facts.destinations import destinations
from desim_warehouse.model.read import load

if TYPE_CHECKING:
    from collections.abc import Iterable, MutableMapping, MutableSequence
    from pathlib import Path

    from desim_warehouse.layout import Edge, Layout
    from desim_warehouse.model.schema import Model


def orientation(model: Model) -> Orientation:
    """Which way every two-way lane of a model is to be driven so that trips between goods and stations are short.

    Only the part of the floor matters that robots can reach and leave.
    Raises ModelError where no lane is two-way, or goods or stations lie in parts that cannot reach each other.
    """
    layout = model.floor
    main = max(nx.strongly_connected_components(layout.graph), key=len)
    lanes = [lane for lane in layout.two_way if main.issuperset(lane)]
    if not lanes:
        raise ModelError([f"{model.name}: no two-way lane, expected some to make one-way"])
    ends: dict[str, float] = {}
    for place in layout.storage:
        for node in place.edge:
            ends[node] = ends.get(node, 0.0) + place.popularity
    hubs = sorted({*destinations(model, layout)})
    outside = sorted({*ends, *hubs} - main)
    if outside:
        where = f"node {outside[0]} cannot be reached or left"
        raise ModelError([f"{model.name}: {where}, but goods or stations are there; desim check says more"])
    traffic, speed = model.traffic, model.fleet.fastest_empty
    travel = FreeTravel(layout.graph, speed, traffic.node_time, node_times=dict(traffic.node_times))

    def seconds(edge: Edge) -> float:
        return travel.along(edge, 0.0)[1]

    return orient_lanes(layout.graph.subgraph(main), lanes, ends, hubs, seconds)


def orient(model: Model) -> Model:
    """A copy of a model with its two-way lanes made one-way. Bridges stay two-way."""
    return oriented(model, orientation(model))


def oriented(model: Model, found: Orientation, against: float | None = None) -> Model:
    """A copy of a model with its two-way lanes made one-way as found, or counting `against` times the other way."""
    content = model.content()
    _orient(content["layout"], model.floor, found.kept, against)
    return load(content)


def oriented_files(
    path: Path, model: Model, found: Orientation, out: Path, against: float | None = None
) -> dict[Path, str]:
    """A model file with its lanes oriented, to be written to `out`: comments, order and all else stay as they are.

    `against` as for `oriented`. A layout file that it names is another one then, beside `out`: the last of the files.
    """
    from ruamel.yaml import YAML

    yaml = YAML()
    yaml.indent(sequence=4, offset=2)
    yaml.width = 4096  # an edge is one line
    content = yaml.load(path.read_text(encoding="utf-8-sig"))
    section = content["layout"]
    beside = layout_file.read(path.parent / section["file"]) if "file" in section else {}
    _orient(ChainMap(section, beside), model.floor, found.kept, against)
    files: dict[Path, str] = {}
    if beside:
        files[layout_file.beside(out)] = layout_file.text(beside)
        section["file"] = layout_file.beside(out).name
    text = io.StringIO()
    yaml.dump(content, text)
    return {out: text.getvalue(), **files}


def _orient(section: MutableMapping[str, Any], layout: Layout, kept: Iterable[Edge], against: float | None) -> None:
    if against is None:
        _turn(section, layout, kept)
    else:
        _prefer(section, kept, against)


def _prefer(section: MutableMapping[str, Any], kept: Iterable[Edge], against: float) -> None:
    """Change a layout section in place: lanes count `against` times where they are not driven as `kept`."""
    from ruamel.yaml.comments import CommentedMap

    ways = set(kept)
    edges: MutableSequence[Any] = section.get("edges", [])
    for rank, item in enumerate(edges):
        edge = _ends(item)
        if isinstance(item, dict):
            if edge in ways or edge[::-1] in ways:
                item.pop("against", None)
            if edge[::-1] in ways and item.get("two_way"):
                item["from"], item["to"] = edge = edge[::-1]
                if "speed_back" in item:
                    item["speed"], item["speed_back"] = item["speed_back"], item.pop("speed", None)
        elif edge in ways:
            item = edges[rank] = CommentedMap({"from": edge[0], "to": edge[1]})  # noqa: PLW2901
            item.fa.set_flow_style()
        if edge in ways:
            item["against"] = against


def _turn(section: MutableMapping[str, Any], layout: Layout, kept: Iterable[Edge]) -> None:
    """Change a layout section in place: of each lane only the direction `kept` is left, and goods lie along it."""
    turned = {(head, tail) for tail, head in kept}  # the directions that go
    both = turned | {edge[::-1] for edge in turned}
    edges: MutableSequence[Any] = section.get("edges", [])
    for rank in range(len(edges) - 1, -1, -1):
        item = edges[rank]
        edge = _ends(item)
        if edge not in both:
            continue
        is_two_way = isinstance(item, dict) and item.pop("two_way", False)
        if isinstance(item, dict):
            item.pop("against", None)  # it is not driven that way any more
            back = item.pop("speed_back", None)
            if back is not None and edge in turned:
                item["speed"] = back
        if edge in turned:
            if not is_two_way:
                del edges[rank]  # its twin stays
            elif isinstance(item, dict):
                item["from"], item["to"] = edge[::-1]
    storage = section.get("storage", ())
    if isinstance(storage, dict):  # a file: its places are few words each, and other models may read it
        storage = section["storage"] = [
            {"edge": list(place.edge), "offset": place.offset, "popularity": place.popularity}
            for place in layout.storage
        ]
    for item in storage:
        edge = tuple(item.get("edge", ()))
        if edge in turned:
            item["edge"] = list(edge[::-1])
            item["offset"] = layout.graph.edges[edge]["length"] - item["offset"]


def _ends(item: Any) -> Edge:
    """The nodes of an edge as a model file has it."""
    return (item["from"], item["to"]) if isinstance(item, dict) else (item[0], item[1])
