"""Plants that others drew: files of other programs as models.

A reader turns a file into a `Plant`; `imported` makes a model of it and says what could not be carried over.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.plants.formats import read_plant
from desim_warehouse.plants.model import Imported, imported
from desim_warehouse.plants.plant import Plant, Remark

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from desim_warehouse.model import Model

__all__ = ["Imported", "Plant", "Remark", "import_layout", "imported", "read_layout", "read_plant"]


def import_layout(
    path: str | Path, *, operations: Mapping[str, str] | None = None, robots: int | None = None
) -> Imported:
    """A model of a foreign file, with remarks: what could not be carried over, what is assumed; see `read_layout`."""
    return imported(read_plant(path), operations, robots)


def read_layout(path: str | Path, *, operations: Mapping[str, str] | None = None, robots: int | None = None) -> Model:
    """Read the layout of another program and make a model of it; what the file does not say is assumed.

    Args:
        path: a plant model of openTCS (XML, versions 0.0.2 to 7.0.0).
        operations: what robots do at locations that allow an operation, such as `{"Pack": "unload"}`: load, unload,
            charge, park or none; by default as the names of operations sound.
        robots: size of the fleet; default: as many as vehicles are drawn.

    Returns:
        The model, in metres and seconds. `desim_warehouse.plants.import_layout` has the remarks with it, too.

    Raises:
        ModelError: where it cannot be read, or robots could do nothing there.
    """
    return import_layout(path, operations=operations, robots=robots).model
