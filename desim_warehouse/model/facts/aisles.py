"""Aisles of a model that could be wide: where robots would stand beside their lanes while they load."""

from __future__ import annotations

from desim_warehouse.layout import Edge
from desim_warehouse.layout.aisles import wide_edges
from desim_warehouse.model.schema import Model


def widened(model: Model) -> tuple[Model, frozenset[Edge]]:
    """Return the model with wide aisles, and the edges beside which robots load only then; not for pods."""
    wide = model.replace({"layout.aisles": "wide"})
    contact = model.fleet.contact
    return wide, wide_edges(wide.floor, contact) - wide_edges(model.floor, contact)
