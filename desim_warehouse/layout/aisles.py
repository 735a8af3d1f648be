"""Wide aisles: lanes beside which a robot stands while it loads, so that others drive past."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf

from desim_warehouse.layout.layout import Edge, Layout
from desim_warehouse.layout.zones import TrafficZone, closed

EPS = 1e-6


def needed_width(contact: float) -> float:
    """Return how wide an aisle must be for a robot to drive past another: each takes its width and the margin, D."""
    return 2 * contact


def wide_edges(layout: Layout, contact: float, zones: Iterable[TrafficZone] = ()) -> frozenset[Edge]:
    """Return the edges with storage places beside which a robot stands off the lane while it loads or unloads.

    Their aisle is wide enough for two robots that keep D (`contact`) apart, and they are long enough to stand on.
    """
    return frozenset(_wide(layout, contact)) - too_short(layout, contact) - closed(zones)


def too_short(layout: Layout, contact: float) -> frozenset[Edge]:
    """Return the edges of wide aisles on which no robot stands clear of both ends, so that it loads in the lane."""
    return frozenset(edge for edge in _wide(layout, contact) if layout.length(edge) < 2 * contact - EPS)


def _wide(layout: Layout, contact: float) -> list[Edge]:
    if not layout.widths:
        return []
    beside = {edge for place in layout.storage for edge, _ in layout.approaches(place.edge, place.offset)}
    return [edge for edge in beside if layout.widths.get(edge, 0.0) >= needed_width(contact) - EPS]


def width_of(width: str | float) -> float:
    """Return the width of an aisle that is said to be `wide` (inf), `narrow` (0), or so many length units wide."""
    return {"wide": inf, "narrow": 0.0}[width] if isinstance(width, str) else width
