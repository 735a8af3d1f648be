"""Import of plants drawn in other programs, from which `desim import` makes models.

A reader turns a file into a `Plant`; `imported` makes a model of it, with remarks on what could not be carried over.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.model import Model
from desim_warehouse.plants.formats import add_tasks, read_plant
from desim_warehouse.plants.graph import from_networkx
from desim_warehouse.plants.model import Imported, imported, read_robot
from desim_warehouse.plants.plant import Plant, Remark

if TYPE_CHECKING:
    import networkx as nx


__all__ = ["Imported", "Plant", "Remark", "import_layout", "imported", "read_layout", "read_plant"]


def import_layout(
    path: str | Path | nx.Graph,
    *,
    operations: Mapping[str, str] | None = None,
    robots: int | None = None,
    robot: str | Path | None = None,
    tasks: str | Path | None = None,
    **options: Any,
) -> Imported:
    """Make a model of a foreign file, with remarks on losses and assumptions; see `read_layout`."""
    plant = read_plant(path, **options) if isinstance(path, str | Path) else from_networkx(path, **options)
    if tasks is not None:
        add_tasks(plant, tasks)
    return imported(plant, operations, robots, read_robot(robot) if robot is not None else None)


def read_layout(
    path: str | Path | nx.Graph,
    *,
    operations: Mapping[str, str] | None = None,
    robots: int | None = None,
    robot: str | Path | None = None,
    tasks: str | Path | None = None,
    layout: str | None = None,
    vehicle_type: str | None = None,
    strict: bool | None = None,
    graph: int | None = None,
    lanes: str | tuple[str, ...] | None = None,
    two_way: bool | None = None,
    cell: float | None = None,
) -> Model:
    """Convert a layout from another program into a model; whatever the file does not specify is assumed.

    Args:
        path: a layout in LIF (JSON), a map of Open-RMF (YAML) or RMF site (JSON), a plant model of openTCS (XML,
            versions 0.0.2 to 7.0.0), a grid of planners (MovingAI, LoRR, GGO, kiva, RHCR), GraphML, node-link JSON of
            networkx, GeoJSON, DXF, a workbook with sheets nodes and edges (Excel), or a table of nodes with one of
            edges beside it (nodes.csv, edges.csv; or their folder). Or a graph of networkx: nodes with x and y in
            metres, y downwards, and perhaps role (such as load) and station; edges perhaps with length (or weight),
            speed and side_by_side; the edges of an undirected graph are two-way lanes.
        operations: what robots do at locations that allow an operation, such as `{"Pack": "unload"}`: load, unload,
            charge, park or none; by default as the names of operations suggest.
        robots: size of the fleet; default: the number of vehicles drawn.
        robot: a YAML file with the sections `robot` (as below fleet) and `battery` of a model, or one of them.
        tasks: a file with the tasks: transport orders of openTCS (XML), or tasks of LoRR or MAPD.
        layout: for LIF the layout, for Open-RMF maps and sites the level to read.
        vehicle_type: for LIF, the vehicle type whose edges are lanes.
        strict: for LIF, whether violations of the standard are errors.
        graph: for Open-RMF maps and sites, the graph_idx of the lanes to read.
        lanes: for DXF and GeoJSON, the layers whose lines are lanes.
        two_way: for LIF, CSV and Excel, whether edges without a stated direction lead both ways.
        cell: for grids, the side of a cell in metres.

    Returns:
        The model, in metres and seconds. `desim_warehouse.plants.import_layout` also returns the remarks.

    Raises:
        ModelError: the file cannot be read, or robots could do nothing there.
    """
    settings: dict[str, Any] = {"operations": operations, "robots": robots, "robot": robot, "tasks": tasks}
    chosen: dict[str, Any] = {
        "layout": layout,
        "vehicle_type": vehicle_type,
        "strict": strict,
        "graph": graph,
        "lanes": lanes,
        "two_way": two_way,
        "cell": cell,
    }
    options = {name: value for name, value in chosen.items() if value is not None}
    return import_layout(path, **settings, **options).model
