"""Wide aisles, in which a robot that loads stands beside its lane, so that others drive past."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import inf

from desim_warehouse.errors import first_of
from desim_warehouse.findings import Finding
from desim_warehouse.layout.layout import Edge, Layout
from desim_warehouse.layout.short import EPS, is_short
from desim_warehouse.layout.zones import TrafficZone, closed

SHOWN = 6
"""Number of edges that a finding names."""


def needed_width(contact: float) -> float:
    """Return the width of an aisle in which a robot can drive past another: 2 D, as each takes up D across."""
    return 2 * contact


def wide_edges(layout: Layout, contact: float, zones: Iterable[TrafficZone] = ()) -> frozenset[Edge]:
    """Return the edges with storage places beside which a robot stands off the lane while it loads or unloads.

    The aisle of such an edge is wide enough for two robots that keep D (`contact`) apart, and the edge is long enough
    for a robot to stand clear of both ends.
    """
    widths, least = layout.widths, needed_width(contact) - EPS
    wide = [edge for edge in (_with_places(layout) if widths else ()) if widths.get(edge, 0.0) >= least]
    return frozenset(edge for edge in wide if not _is_short(layout, edge, contact)) - closed(zones)


def examine(layout: Layout, contact: float) -> Iterator[Finding]:
    """Find aisles that are too narrow to pass in, or too short for robots to leave the lane."""
    widths, need = layout.widths, needed_width(contact)
    beside = sorted(_with_places(layout)) if widths else []
    if widths and not beside and layout.storage:
        text = "no storage place lies beside a lane: robots load standing on nodes, and those behind wait"
        yield Finding("CHANGES_NOTHING", "layout.aisles", text, "give storage places an edge and offset")
    tight = [edge for edge in beside if 0 < widths.get(edge, 0.0) < need - EPS]
    if tight:
        width = max(widths[edge] for edge in tight)
        text = (
            f"{width:g} is too narrow for two robots side by side, which need {need:g} (2 D), so those that load stand "
        )
        yield Finding(
            "AISLES_TIGHT", "layout.aisles", f"{text}in their lanes: {_named(tight)}", "smaller robots or margins"
        )
    short = [edge for edge in beside if widths.get(edge, 0.0) >= need - EPS and _is_short(layout, edge, contact)]
    if short:
        text = (
            f"edges in wide aisles are shorter than {2 * contact:g} (2 D), so robots load in the lane: {_named(short)}"
        )
        yield Finding("AISLES_SHORT", "layout.aisles", text)


def _with_places(layout: Layout) -> set[Edge]:
    """Return the edges from which robots load at storage places beside them."""
    places = (place for place in layout.storage if place.edge[0] != place.edge[1])
    return {edge for place in places for edge, _ in layout.approaches(place.edge, place.offset)}


def _is_short(layout: Layout, edge: Edge, contact: float) -> bool:
    """Whether no robot can stand on an edge clear of both its ends."""
    return is_short(layout.length(edge), contact)


def _named(edges: list[Edge]) -> str:
    return first_of([">".join(edge) for edge in edges], SHOWN)


def width_of(width: str | float) -> float:
    """Return the width of an aisle as a number: inf for `wide`, 0 for `narrow`, otherwise the given length."""
    return {"wide": inf, "narrow": 0.0}[width] if isinstance(width, str) else width
