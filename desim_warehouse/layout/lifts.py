"""What is wrong with lifts before a run: where robots would wait or work in a cabin, or drive through one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from desim_warehouse.errors import first_of
from desim_warehouse.findings import Finding
from desim_warehouse.layout.zones import ZoneSpec, zones_on

if TYPE_CHECKING:
    from desim_warehouse.layout.layout import Edge, Layout

EPS = 1e-6


def examine(
    layout: Layout, used: Mapping[str, str], zones: Mapping[str, ZoneSpec], contact: float
) -> Iterator[Finding]:
    """Find errors of lifts; `used` says what robots do at nodes, and robots keep the distance `contact`."""
    at = {**used, **{node: f"zone {zone.name}" for zone in zones_on(layout, zones) for node in zone.nodes}}
    for good in layout.storage:
        at |= dict.fromkeys(good.edge, f"good {good.number}, or the lane beside which it lies,")
    at |= {node: f"station {station.zone}" for node, station in layout.stations.items()}
    at |= {node: f"bay {bay.zone}" for node, bay in layout.bays.items()}
    for lift in layout.lifts:
        place = f"layout.lifts.{lift.name}"
        for node in lift.nodes:
            lanes = [edge for edge in _edges_at(layout, node) if edge not in layout.rides]
            beside = {other for edge in lanes for other in edge if other != node}
            if len(beside) != 1:
                text = f"{node} has no lane on its floor"
                if beside:
                    text = f"{node} has lanes to {first_of(sorted(beside), 3)}, so robots could drive through the cabin"
                yield Finding("LIFT", place, text, "join it to one node on its floor, in front of the doors")
            for edge in lanes:
                if layout.length(edge) < 2 * contact - EPS:
                    text = f"{'>'.join(edge)} is shorter than {2 * contact:g} (2 D), so robots would wait in the cabin"
                    yield Finding("LIFT", place, text, "make it longer, up to the next node")
                    break
            if node in at:
                text = f"{at[node]} is at {node}, where robots would be in the cabin"
                yield Finding("LIFT", place, text, "move it to the node in front of the doors")


def _edges_at(layout: Layout, node: str) -> list[Edge]:
    return [*layout.graph.in_edges(node), *layout.graph.out_edges(node)]
