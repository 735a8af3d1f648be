"""Models whose lanes are driven in other ways, such as two-way lanes one way: in a file, or as a model."""

from __future__ import annotations

import copy
import io
from collections import ChainMap
from collections.abc import Container, Mapping, MutableMapping, MutableSequence, Sequence
from pathlib import Path
from typing import Any

import networkx as nx

from desim_warehouse.errors import ModelError
from desim_warehouse.layout import Edge, Layout
from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.layout.orient import Orientation, orient_lanes
from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.layout.turnable import AGAINST, Way, mirrored
from desim_warehouse.model import layout_file
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.model.schema import Model


def orientation(model: Model) -> Orientation:
    """Find which way to drive every two-way lane of a model so that trips between goods and stations are short.

    Only the part of the floor matters that robots can reach and leave.
    Raises ModelError where no lane is two-way, or goods or stations lie in parts that cannot reach each other.
    """
    layout = model.floor
    main = max(nx.strongly_connected_components(layout.graph), key=len)
    lanes = [lane for lane in layout.two_way if main.issuperset(lane)]
    if lanes and model.layout.blocks is not None:
        text = "the aisles of blocks lead one way from end to end, expected a search (--indicator), or lists"
        raise ModelError([f"layout.blocks.directions: {text}"])
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


def oriented(model: Model, chosen: Orientation, against: float | None = None) -> Model:
    """Copy a model with its two-way lanes made one-way as chosen, or counting `against` times the other way.

    Bridges stay two-way.
    """
    return model.replace(changes(model, _ways(chosen, against), against or AGAINST))


def oriented_files(
    path: Path, model: Model, chosen: Orientation, out: Path, against: float | None = None
) -> dict[Path, str]:
    """Write a model file with its lanes oriented as by `oriented`, for `out` (see `turned_files`)."""
    return turned_files(path, model, _ways(chosen, against), out, against or AGAINST)


def _ways(chosen: Orientation, against: float | None) -> dict[Edge, Way]:
    return dict.fromkeys(chosen.kept, "along" if against is None else "rather along")


def changes(model: Model, ways: Mapping[Edge, Way], against: float = AGAINST) -> dict[str, Any]:
    """Return the overrides by which a model's lanes are driven in other ways.

    `against`: as many times as long a lane counts that is driven against its preferred direction.
    """
    section = model.content()["layout"]
    before = copy.deepcopy(section)
    _turn(section, model.floor, ways, against)
    return {f"layout.{key}": value for key, value in section.items() if value != before.get(key)}


def turned_files(
    path: Path, model: Model, ways: Mapping[Edge, Way], out: Path, against: float = AGAINST
) -> dict[Path, str]:
    """Write a model file whose lanes are driven in other ways, for `out`: comments, order and the rest stay.

    `against` as for `changes`. A layout file that it names becomes another one, beside `out`: the last of the files.
    """
    from ruamel.yaml import YAML

    yaml = YAML()
    yaml.indent(sequence=4, offset=2)
    yaml.width = 4096  # an edge is one line
    content = yaml.load(path.read_text(encoding="utf-8-sig"))
    section = content["layout"]
    beside = layout_file.read(path.parent / section["file"]) if "file" in section else {}
    _turn(ChainMap(section, beside), model.floor, ways, against)
    files: dict[Path, str] = {}
    if beside:
        files[layout_file.beside(out)] = layout_file.text(beside)
        section["file"] = layout_file.beside(out).name
    text = io.StringIO()
    yaml.dump(content, text)
    return {out: text.getvalue(), **files}


def _turn(section: MutableMapping[str, Any], layout: Layout, ways: Mapping[Edge, Way], against: float) -> None:
    """Change a layout section in place, so that lanes are driven in other ways; goods lie along what is left."""
    if section.get("blocks") is not None:
        _turn_blocks(section["blocks"], ways)
        return
    edges: MutableSequence[Any] = section.get("edges", [])
    listed = {_ends(item) for item in edges}
    closed: set[Edge] = set()  # directions that lanes had and have no more
    for rank in range(len(edges) - 1, -1, -1):
        item = edges[rank]
        edge = _ends(item)
        way = ways.get(edge) or mirrored(ways.get(edge[::-1], "both"))
        has_twin = edge[::-1] in listed
        if way == "both" or (way == "along" and not has_twin and not _is_two_way(item)):
            continue
        is_back, is_one_way = way.endswith("back"), not way.startswith("rather")
        if is_one_way:
            closed.add(edge if is_back else edge[::-1])
        if is_back and has_twin and is_one_way:
            del edges[rank]
        elif is_back and has_twin:
            _drop(item, "against")  # its twin has the preferred direction
        elif isinstance(item, dict) or not is_one_way:
            edges[rank] = item if isinstance(item, dict) else _as_section(edge)
            _drive(edges[rank], None if is_one_way else against, is_back=is_back)
        elif is_back:
            item[0], item[1] = edge[::-1]
    _turn_storage(section, layout, closed)


def _drive(item: MutableMapping[str, Any], against: float | None, *, is_back: bool) -> None:
    """Turn an edge round (`is_back`), and make it one-way, or with `against` lead both ways, preferring one."""
    _drop(item, "against")
    if is_back:
        item["from"], item["to"] = item["to"], item["from"]
        if "speed_back" in item:
            item["speed"], item["speed_back"] = item["speed_back"], item.pop("speed", None)
    if against is None:
        _drop(item, "two_way", "speed_back")
    else:
        item["against"] = against


def _drop(item: Any, *keys: str) -> None:
    for key in keys if isinstance(item, dict) else ():
        item.pop(key, None)


def _as_section(edge: Edge) -> MutableMapping[str, Any]:
    from ruamel.yaml.comments import CommentedMap

    item = CommentedMap({"from": edge[0], "to": edge[1]})
    item.fa.set_flow_style()
    return item


def _turn_storage(section: MutableMapping[str, Any], layout: Layout, closed: Container[Edge]) -> None:
    """Move goods beside a direction that is closed to the other direction."""
    storage = section.get("storage", ())
    if isinstance(storage, dict):  # a file: its places are few words each, and other models may read it
        storage = section["storage"] = [
            ({"node": a} if a == b else {"edge": [a, b], "offset": place.offset}) | {"popularity": place.popularity}
            for place in layout.storage
            for a, b in [place.edge]
        ]
    for item in storage:
        edge = tuple(item.get("edge", ()))
        if edge in closed:
            item["edge"] = list(edge[::-1])
            item["offset"] = layout.graph.edges[edge]["length"] - item["offset"]


def _turn_blocks(section: MutableMapping[str, Any], ways: Mapping[Edge, Way]) -> None:
    """Set the directions of blocks, one for each row and column, which every lane of it has."""
    names = block_nodes(section["columns"], section["rows"])

    def led(line: Sequence[str], onward: str, backward: str) -> str:
        first, second = line[0], line[1]
        way = ways[first, second] if (first, second) in ways else mirrored(ways[second, first])
        return {"along": onward, "back": backward}.get(way, "two-way")

    section["directions"] = {
        "rows": [led(row, "east", "west") for row in names],
        "columns": [led(column, "south", "north") for column in zip(*names, strict=True)],
    }


def _is_two_way(item: Any) -> bool:
    return isinstance(item, dict) and bool(item.get("two_way"))


def _ends(item: Any) -> Edge:
    """Return the nodes of an edge as a model file has it."""
    return (item["from"], item["to"]) if isinstance(item, dict) else (item[0], item[1])
