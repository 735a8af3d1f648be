"""From a model to a plant, for export: what other programs can hold of it, and what is lost."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from desim_warehouse.plants.plant import Area, Link, Location, Plant, Vehicle, Waypoint, claim, unique

if TYPE_CHECKING:
    from collections.abc import Iterable

    from desim_warehouse.layout.layout import Edge, Layout
    from desim_warehouse.model import Model
    from desim_warehouse.values.fields import Part

_AT_THE_END = 0.01
"""A storage place so near the end of a lane, in metres, is at the node there."""


def drawn(model: Model) -> Plant:
    """The plant of a model, in metres and seconds, with remarks on what is lost.

    A storage place beside a lane becomes a point of the lane. Links are called `A>B`, a two-way lane by its first edge.

    Raises:
        LayoutError: where two things claim one node.
    """
    plant = Plant(model.name, f"model '{model.name}'")
    metre = model.units.metre
    if metre is None:
        plant.note("changed", "unit", [model.units.length], "of unknown size, so taken for a metre")
        metre = 1.0
    return _Drawing(model, plant, model.floor, metre).plant


class _Drawing:
    """Fills a plant; `pieces` has the links and points that a lane became."""

    def __init__(self, model: Model, plant: Plant, layout: Layout, metre: float) -> None:
        self.model = model
        self.plant = plant
        self.layout = layout
        self.metre = metre
        self.pieces: dict[frozenset[str], list[str]] = {}
        self.loads: dict[str, int] = {}
        self.points()
        self.lanes()
        self.locations()
        self.fleet()
        self.zones()
        self.losses()

    def points(self) -> None:
        parking = {bay.node for bay in self.layout.bays.values() if bay.chargers == 0}
        for name, at in self.layout.graph.nodes(data=True):
            self.plant.points[name] = Waypoint(name, at["x"] * self.metre, at["y"] * self.metre, name in parking)

    def lanes(self) -> None:
        """Every lane as a link, or as several with a point wherever robots load."""
        stops: dict[Edge, dict[float, int]] = {edge: {} for edge in self.layout.lanes}
        for place in self.layout.storage:
            if place.edge[0] == place.edge[1]:
                self.loads[place.edge[0]] = self.loads.get(place.edge[0], 0) + 1
                continue
            edge, offset = place.edge, place.offset
            if edge not in stops:
                edge, offset = edge[::-1], self.layout.length(edge) - offset
            at = round(offset * self.metre, 3)
            stops[edge][at] = stops[edge].get(at, 0) + 1
        for edge, there in stops.items():
            self.lane(edge, there)
        added = [name for names in self.pieces.values() for name in names if name not in self.layout.graph]
        added = [name for name in added if name in self.plant.points]
        self.plant.note("changed", "point", added, "where robots load beside a lane, which is two links there")

    def lane(self, edge: Edge, stops: dict[float, int]) -> None:
        (a, b), data = edge, self.layout.graph.edges[edge]
        seconds = self.model.units.seconds
        length, speed = data["length"] * self.metre, data["speed"] * self.metre / seconds
        back = self.layout.graph.edges[b, a]["speed"] * self.metre / seconds if data.get("two_way") else 0.0
        beside = not data.get("two_way") and (b, a) in self.layout.graph.edges
        chain, names = [(a, 0.0)], []
        for at, count in sorted(stops.items()):
            if not _AT_THE_END < at < length - _AT_THE_END:
                end = a if at <= _AT_THE_END else b
                self.loads[end] = self.loads.get(end, 0) + count
                continue
            name = unique(f"{a}-{b} {at:g}", self.plant.points)
            x, y = self.layout.position(edge, at / self.metre)
            self.plant.points[name] = Waypoint(name, x * self.metre, y * self.metre)
            self.loads[name] = count
            chain.append((name, at))
        chain.append((b, length))
        for (source, begin), (target, stop) in itertools.pairwise(chain):
            self.plant.links.append(
                Link(f"{source}>{target}", source, target, stop - begin, speed, back, side_by_side=beside)
            )
            names += [f"{source}>{target}", target]
        self.pieces[frozenset(edge)] = self.pieces.get(frozenset(edge), []) + names[:-1]

    def locations(self) -> None:
        stations: dict[str, dict[str, tuple[str, ...]]] = {}
        chargers: dict[str, dict[str, tuple[str, ...]]] = {}
        for node, station in self.layout.stations.items():
            stations.setdefault(station.zone, {})[node] = ("unload",)
        for node, bay in self.layout.bays.items():
            if bay.chargers != 0:
                chargers.setdefault(bay.zone, {})[node] = ("charge",)
        goods: dict[str, dict[str, tuple[str, ...]]] = {f"goods at {one}": {one: ("load",)} for one in self.loads}
        taken: set[str] = set()
        for wanted, operations in (*stations.items(), *chargers.items(), *goods.items()):
            self.plant.locations.append(Location(claim(wanted, taken), operations))

    def fleet(self) -> None:
        battery, fleet, seconds = self.model.battery, self.model.fleet, self.model.units.seconds
        critical = battery.threshold / battery.capacity if battery else None
        counts: dict[str, int] = {}
        for robot, kind in zip(fleet.robots(), fleet.kinds_of_robots(), strict=True):
            kind = kind or "robot"  # noqa: PLW2901 - ordinary ones have no kind
            counts[kind] = counts.get(kind, 0) + 1
            size, speed = 2 * robot.radius * self.metre, robot.speed * self.metre / seconds
            self.plant.vehicles.append(Vehicle(f"{kind} {counts[kind]}", size, speed, critical=critical))

    def zones(self) -> None:
        for name, zone in self.model.traffic.zones.items():
            members: list[str] = []
            for member in zone.members:
                members += [member] if isinstance(member, str) else self.pieces[frozenset(member)]
            self.plant.areas.append(Area(name, tuple(members), zone.rule))

    # What a plant does not have

    def losses(self) -> None:
        note, layout = self.plant.note, self.layout
        several = [point for point, count in self.loads.items() if count > 1]
        note("changed", "place", several, "several storage places, one when it is read again")
        popular = [str(place.number) for place in layout.storage if place.popularity != 1]
        note("left out", "popularity", popular, "of storage places: how often they are asked for")
        names = list(dict.fromkeys(station.zone for station in layout.stations.values()))
        note("left out", "station", names, "only where it is: places, servers, workers, hours and times are lost")
        names = list(dict.fromkeys(bay.zone for bay in layout.bays.values()))
        note("left out", "bay", names, "only where it is: how many slots and chargers it has is lost")
        names = [bay.node for bay in layout.bays.values() if bay.in_lane]
        note("left out", "bay in the lane", names, "that robots park on the node itself, and no route leads through it")
        counted = [">".join(edge) for *edge, times in layout.graph.edges(data="counts") if times]
        note("left out", "preferred direction", counted, "routes lead either way")
        note("left out", "section", list(self.sections()), "a layout has no work, policies or energy")

    def sections(self) -> Iterable[str]:
        """Parts of the model about other things than the layout."""
        model = self.model
        for key in ("calendars", "tasks", "battery", "people", "policies", "run", "cost", "prices", "accept"):
            if key == "tasks" or getattr(model, key) != type(model).model_fields[key].default:
                yield key
        if _unusual(model.traffic, {"zones"}):
            yield "traffic (but zones)"
        robots = any(_unusual(robot, {"radius", "speed"}) for robot in model.fleet.distinct())
        if robots or _unusual(model.fleet, {"size", "robot", "kinds"}):
            yield "fleet (but size, radius and speed of robots)"


def _unusual(part: Part, carried: set[str]) -> bool:
    """Whether a section differs from its defaults in anything that a plant does not hold."""
    keys = type(part).model_fields
    return any(getattr(part, key) != one.default for key, one in keys.items() if key not in carried)
