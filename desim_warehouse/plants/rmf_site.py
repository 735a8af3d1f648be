"""Sites of Open-RMF's site editor (`.site.json`) for `desim import`, read as Open-RMF's navigation graphs.

Coordinates are in metres, y upwards. A lane leads both ways unless its reverse is disabled. It belongs to all graphs,
to some, or to all but some; graphs are numbered from 0 in the order of their ranking.

Source: rmf_site_format of rmf_site.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn

from desim_warehouse.errors import ModelError, got
from desim_warehouse.model.json_text import read_json
from desim_warehouse.model.messages import FilePositions, Keys, Position
from desim_warehouse.model.parse import Document
from desim_warehouse.plants import rmf
from desim_warehouse.plants.plant import Plant

EXPECTED = "a site of Open-RMF (JSON with levels and navigation)"
_TAGS = {"Charger": "is_charger", "ParkingSpot": "is_parking_spot", "HoldingPoint": "is_holding_point"}
_PAIR = 2
_KNOWN = {"name", "anchor", "tags", "graphs"}, {"anchors", "graphs", "forward", "reverse", "marker"}
Item = dict[str, Any]


def looks(path: Path, start: bytes) -> bool:
    """Return whether a file may be a site, by its name, or by its version and anchors."""
    named = path.name.lower().endswith(".site.json")
    return named or (start.startswith(b"{") and b'"format_version"' in start and b'"anchors"' in start)


def read(path: Path, content: bytes, *, layout: str | None = None, graph: int | None = None) -> Plant:
    """Read a level and a graph of a site, with the options of a building map.

    Raises:
        ModelError: a file that cannot be read, with the part that is wrong.
    """
    data = read_json(path, content, EXPECTED)
    site = _Site(path, data)
    plant = rmf.plant_of(path, Document({"name": site.name, "levels": site.levels()}, site.positions), layout, graph)
    for names, item, expected in site.seen:
        plant.see_keys(item, expected, names, names.split()[0])
    return plant


class _Site:
    """A site while it is read; `positions` maps the parts of the graph to the parts of the site."""

    def __init__(self, path: Path, data: Any) -> None:
        self.path = path
        self.data = self.section(data, "the top level")
        self.positions = FilePositions(str(path))
        self.name = str(self.inner(self.data, "properties").get("name") or path.name.partition(".")[0])
        self.seen: list[tuple[str, Item, set[str]]] = []
        self.guided = self.inner(self.inner(self.data, "navigation"), "guided")
        ranking = self.guided.get("ranking")
        ranked = [str(graph) for graph in ranking] if isinstance(ranking, list) else []
        self.graphs = list(dict.fromkeys([*ranked, *self.inner(self.guided, "graphs")])) or ["0"]

    def levels(self) -> Item:
        """Return the levels with their vertices and lanes; anchors of the site itself belong to every level."""
        levels: Item = {}
        shared = self.inner(self.data, "anchors")
        for key, level in self.parts(self.data, "levels"):
            name = str(self.inner(level, "properties").get("name") or key)
            levels[name] = self.level(name, {**self.inner(level, "anchors"), **shared})
        return levels

    def level(self, name: str, anchors: Item) -> Item:
        ranks = {key: rank for rank, key in enumerate(anchors)}
        vertices: list[list[Any]] = []
        for key, anchor in anchors.items():
            self.stand(("levels", name, "vertices", len(vertices)), f"anchor {key}")
            vertices.append([*self.spot(anchor, f"anchor {key}"), {}])
        lanes: list[list[Any]] = []
        for key, lane in self.parts(self.guided, "lanes"):
            ends = lane.get("anchors")
            if not isinstance(ends, list) or len(ends) != _PAIR:
                self.refuse(f"lane {key}", f"not between two anchors (got {got(ends)}), expected two")
            if {str(end) for end in ends} <= ranks.keys():
                self.seen.append((f"lane {key}", lane, _KNOWN[1]))
                for graph in self.graphs_of(lane):
                    self.stand(("levels", name, "lanes", len(lanes)), f"lane {key}")
                    lanes.append([*(ranks[str(end)] for end in ends), {**self.lane(lane), "graph_idx": graph}])
        for key, place in self.parts(self.guided, "locations"):
            if (rank := ranks.get(str(place.get("anchor")))) is not None:
                self.seen.append((f"location {key}", place, _KNOWN[0]))
                vertices[rank][-1].update(self.place(place))
        return {"vertices": vertices, "lanes": lanes}

    def graphs_of(self, lane: Item) -> list[int]:
        """Return the graphs that a lane belongs to, by their ranks."""
        which = lane.get("graphs", "All")
        if not isinstance(which, dict):
            return list(range(len(self.graphs)))
        only, but = ([str(name) for name in which.get(key) or ()] for key in ("Only", "AllExcept"))
        return [rank for rank, graph in enumerate(self.graphs) if (graph in only if only else graph not in but)]

    def lane(self, lane: Item) -> Item:
        """Return the parameters of a lane for a navigation graph, from its motion forward and, if any, back."""
        ahead, back = self.inner(lane, "forward"), lane.get("reverse", "Same")
        limits = [motion.get("speed_limit") for motion in (ahead, *(back.values() if isinstance(back, dict) else ()))]
        parameters: Item = {"bidirectional": back not in ("Disable", "Disabled")}
        if slowest := min((limit for limit in limits if isinstance(limit, int | float)), default=0):
            parameters["speed_limit"] = slowest
        for key, ours in (("orientation_constraint", "orientation"), ("dock", "dock_name")):
            if ahead.get(key):
                parameters[ours] = str(ahead[key])
        return parameters

    def place(self, place: Item) -> Item:
        """Return the parameters of a vertex for a location."""
        tags = place.get("tags")
        parameters: Item = {"name": str(place.get("name") or "")}
        for tag in tags if isinstance(tags, list) else ():
            if isinstance(tag, str) and tag in _TAGS:
                parameters[_TAGS[tag]] = True
            elif isinstance(tag, dict) and "SpawnRobot" in tag:
                parameters["spawn_robot_name"] = f"robot at {parameters['name']}"
        return parameters

    def spot(self, anchor: Any, where: str) -> list[float]:
        """Return the position of an anchor, in metres."""
        place: Any = next(iter(anchor.values()), None) if isinstance(anchor, dict) else None
        if isinstance(place, dict):
            place = place.get("General", place.get("trans"))
        if not isinstance(place, list) or len(place) < _PAIR:
            self.refuse(where, f"not a place (got {got(anchor)}), expected {{Translate2D: [x, y]}}")
        return place[:_PAIR]

    def parts(self, item: Item, key: str) -> Iterator[tuple[str, Item]]:
        """Yield the objects of a section by their keys."""
        for name, part in self.inner(item, key).items():
            yield name, self.section(part, f"{key} {name}")

    def inner(self, item: Item, key: str) -> Item:
        return self.section(item.get(key) or {}, key)

    def section(self, value: Any, where: str) -> Item:
        if not isinstance(value, dict):
            self.refuse(where, f"not an object (got {got(value)}), expected {EXPECTED}")
        return value

    def stand(self, keys: Keys, where: str) -> None:
        position = Position(next(self.positions.ranks), 0, 0, f"{self.path}: {where}")
        self.positions.keys[keys] = self.positions.values[keys] = position

    def refuse(self, where: str, text: str) -> NoReturn:
        raise ModelError([f"{self.path}: {where}: {text}"])
