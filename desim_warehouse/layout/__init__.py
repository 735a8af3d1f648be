"""The warehouse floor: one-way Highways, storage places, stations, bays and chargers."""

from desim_warehouse.layout.build import build
from desim_warehouse.layout.layout import BayPlaces, Edge, Layout, StationPlaces, StoragePlace

__all__ = ["BayPlaces", "Edge", "Layout", "StationPlaces", "StoragePlace", "build"]
