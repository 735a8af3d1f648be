"""Checks of lifts before a run: places in a cabin, lanes through a cabin, and cabins that robots would never get."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

from desim_warehouse.errors import first_of
from desim_warehouse.findings import Finding
from desim_warehouse.layout.layout import Edge, Layout, Lift
from desim_warehouse.layout.short import is_short
from desim_warehouse.layout.zones import ZoneSpec, zones_on


class LiftUse(Protocol):
    """How a model uses a layout, as far as lifts are concerned."""

    @property
    def contact(self) -> float:
        """The distance D that robots keep."""

    @property
    def at(self) -> dict[str, str]:
        """The use of nodes by robots, in words."""

    @property
    def zones(self) -> Mapping[str, ZoneSpec]:
        """The traffic zones by name."""

    @property
    def free(self) -> frozenset[str]:
        """The nodes that are open to all robots at once."""

    @property
    def timed(self) -> frozenset[str]:
        """The nodes with a node time of their own."""

    @property
    def people(self) -> Mapping[str, float]:
        """The share of the time for which people have each lift, by its name."""


def examine(layout: Layout, use: LiftUse) -> Iterator[Finding]:
    """Find errors in the drawing and use of lifts."""
    for lift in layout.lifts:
        yield from _shared(lift, use)
    for node in sorted(use.timed.intersection(layout.cabins_beside)):
        text = "the time would be spent in one of several cabins"
        yield Finding("LIFT", f"traffic.nodes.{node}.time", text, "leave it out, and give the doors more time")
    zones, contact = zones_on(layout, use.zones), use.contact
    taken = {**use.at, **{node: f"zone {zone.name}" for zone in zones for node in zone.nodes}}
    for good in layout.storage:
        taken |= dict.fromkeys(good.edge, f"good {good.number}, or the lane beside which it lies,")
    taken |= {node: f"station {station.zone}" for node, station in layout.stations.items()}
    taken |= {node: f"bay {bay.zone}" for node, bay in layout.bays.items()}
    for lift in layout.lifts:
        place = f"layout.lifts.{lift.model_name}"
        for node in lift.nodes:
            lanes = [edge for edge in _edges_at(layout, node) if edge not in layout.rides]
            beside = {other for edge in lanes for other in edge if other != node}
            if len(beside) != 1:
                text = f"{node} has no lane on its floor"
                if beside:
                    text = f"{node} has lanes to {first_of(sorted(beside), 3)}, so robots could drive through the cabin"
                yield Finding("LIFT", place, text, "join it to one node on its floor, in front of the doors")
            for edge in lanes:
                if is_short(layout.length(edge), contact):
                    text = f"{'>'.join(edge)} is shorter than {2 * contact:g} (2 D), so robots would wait in the cabin"
                    yield Finding("LIFT", place, text, "make it longer, up to the next node")
                    break
            if node in taken:
                text = f"{taken[node]} is at {node}, where robots would be in the cabin"
                yield Finding("LIFT", place, text, "move it to the node in front of the doors")


def _shared(lift: Lift, use: LiftUse) -> Iterator[Finding]:
    """Find lifts that would carry any number of robots at once, or that people never leave to robots."""
    for node in sorted(use.free.intersection(lift.nodes)):
        text = "a lift carries one robot at a time, and cannot be open to all"
        yield Finding("LIFT", f"traffic.nodes.{node}.free", text, "leave it out; a shorter ride makes a lift faster")
    if (share := use.people.get(lift.name, 0.0)) >= 1:
        text = f"people would have it for {100 * share:.3g} % of the time, so robots would wait for ever longer"
        yield Finding(
            "LIFT", f"layout.lifts.{lift.model_name}.people", text, "fewer rides, a faster lift, or one cabin more"
        )


def _edges_at(layout: Layout, node: str) -> list[Edge]:
    return [*layout.graph.in_edges(node), *layout.graph.out_edges(node)]
