"""The file formats of other programs that can be read, and how to recognise them.

For `desim import`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from desim_warehouse.errors import ModelError, shown, spoken
from desim_warehouse.plants import (
    dxf,
    geojson,
    graph,
    grid_ggo,
    grid_kiva,
    grid_lorr,
    grid_movingai,
    grid_rhcr,
    lif,
    opentcs,
    orders,
    rmf,
    rmf_site,
    tables,
    xml,
)
from desim_warehouse.plants.file import content_of
from desim_warehouse.plants.plant import Plant
from desim_warehouse.values.arguments import is_finite, is_whole
from desim_warehouse.values.fields import LIMITS

_START = 4096  # bytes that show what a file is
_OTHERS: dict[str, tuple[str, ...]] = {
    "RAWSim-O": (".xinst", ".xlayo", ".xsett", ".xconf"),
    "SUMO": (".net.xml", ".rou.xml"),
    "AnyLogic": (".alp",),
    "FlexSim": (".fsm", ".fsx"),
    "Plant Simulation": (".spp",),
    "Visio": (".vsd", ".vsdx"),
    "SketchUp": (".skp",),
    "Revit": (".rvt",),
    "SEER": (".smap",),
}
"""Programs whose files are recognised by their endings, but cannot be read."""
_WORDY = 64_000_000  # bytes: formats with many words for an edge, of which some plants have 100,000


@dataclass(frozen=True, slots=True)
class Format:
    """A file format of another program.

    Attributes:
        name: the name of the format, for help.
        title: what a file of the format is, for messages and help.
        looks: whether a file may be in the format, by its path and its first 4,096 bytes without leading blanks. The
            first format for which this is true reads the file, and reports its errors.
        read: reads the file; raises ModelError with the position.
        options: options of such files, as keyword arguments of `read`.
        most: largest size of a file, in bytes.
    """

    name: str
    title: str
    looks: Callable[[Path, bytes], bool]
    read: Callable[..., Any]
    options: tuple[str, ...] = ()
    most: int = LIMITS["bytes"][0]


CELLS = 0.01, 1000
"""The smallest and the largest side of a cell of a grid, in metres."""
FORMATS = (
    Format("CSV", "tables of nodes and edges (CSV)", tables.looks, tables.read, ("two_way",)),
    Format(
        "Excel",
        "sheets of nodes and edges (Excel)",
        tables.looks_like_book,
        tables.read_book,
        ("two_way",),
    ),
    Format("GraphML", "a graph (GraphML)", graph.looks, graph.read, most=_WORDY),
    Format("node-link", graph.LINKS, graph.looks_like_links, graph.read_links, most=_WORDY),
    Format("GeoJSON", "lines (GeoJSON)", geojson.looks, geojson.read, ("lanes",), _WORDY),
    Format("DXF", "a drawing (DXF)", dxf.looks, dxf.read, ("lanes",)),
    Format("openTCS", "a plant model of openTCS (XML, versions 0.0.2 to 7.0.0)", xml.looks, opentcs.read, most=_WORDY),
    Format("LoRR", "a problem of the League of Robot Runners (JSON)", grid_lorr.looks, grid_lorr.read, ("cell",)),
    Format("GGO", "a grid of GGO (JSON)", grid_ggo.looks, grid_ggo.read, ("cell",)),
    Format("RHCR", "a road network of RHCR (.grid)", grid_rhcr.looks, grid_rhcr.read, ("cell",)),
    Format("kiva", "a kiva map (MAPD, RHCR)", grid_kiva.looks, grid_kiva.read, ("cell",)),
    Format("MovingAI", "a MovingAI map (.map)", grid_movingai.looks, grid_movingai.read, ("cell",)),
    Format("LIF", "a layout in VDMA LIF (JSON, versions 1.0 and 2.0)", lif.looks, lif.read, lif.OPTIONS, _WORDY),
    Format("RMF site", "a site of Open-RMF (.site.json)", rmf_site.looks, rmf_site.read, rmf.OPTIONS, _WORDY),
    Format(
        "Open-RMF",
        "a building map or navigation graph of Open-RMF (YAML)",
        rmf.looks,
        rmf.read,
        rmf.OPTIONS,
        rmf.LARGEST,
    ),
)


TASK_FILES = (
    Format("openTCS", "transport orders of openTCS (XML)", xml.looks, orders.read),
    Format("LoRR", "tasks of the League of Robot Runners", grid_lorr.looks_like_tasks, grid_lorr.read_tasks),
    Format("MAPD", "tasks of MAPD", grid_kiva.looks_like_tasks, grid_kiva.read_tasks),
)
"""Formats of files that list the tasks of a plant: their `read` also gets the plant, and adds the tasks to it."""


def titles(formats: tuple[Format, ...]) -> str:
    """Return the titles of formats in words: one, another, or a third."""
    return spoken([form.title for form in formats], "or")


def names_with(option: str) -> str:
    """Return the names of the formats that have an option."""
    return ", ".join(form.name for form in FORMATS if option in form.options)


def read_plant(path: str | Path, **options: Any) -> Plant:
    """Read a foreign file as a plant: points, links, locations, vehicles.

    Args:
        path: a file in one of `FORMATS`; for two tables, the table of nodes or their folder.
        options: options of the file; which ones exist depends on the format.

    Raises:
        ModelError: the file cannot be read (with the place), or has no such option.
    """
    path = Path(path)
    if (path / tables.NODES_FILE).is_file():
        path /= tables.NODES_FILE
    form, content = _format(path, FORMATS, "a layout")
    for option in sorted(options.keys() - set(form.options)):
        has = f"one of {', '.join(form.options)}" if form.options else "no option"
        raise ModelError([f"{path}: option {option!r}: there is none for {form.title}, expected {has}"])
    cell, graph = options.get("cell", 1.0), options.get("graph", 0)
    if not (is_finite(cell) and CELLS[0] <= cell <= CELLS[1]):
        raise ModelError([f"{path}: cell {shown(cell):.60}: expected metres from {CELLS[0]:g} to {CELLS[1]:g}"])
    if not is_whole(graph, 0):
        raise ModelError([f"{path}: graph {shown(graph):.60}: expected a whole number from 0 on"])
    plant: Plant = form.read(path, content, **options)
    plant.note_unknown()
    plant.options = form.options
    return plant


def add_tasks(plant: Plant, path: str | Path) -> None:
    """Add the transports that a foreign file lists to a plant.

    Raises:
        ModelError: the file cannot be read.
    """
    form, content = _format(Path(path), TASK_FILES, "tasks")
    form.read(Path(path), content, plant)


def _format(path: Path, formats: tuple[Format, ...], what: str) -> tuple[Format, bytes]:
    content = content_of(path, what, max(form.most for form in formats))
    name = path.name.lower()
    if program := next((program for program, ends in _OTHERS.items() if name.endswith(ends)), None):
        raise ModelError([f"{path}: a file of {program}, which cannot be read, expected {titles(formats)}"])
    start = content[:_START].removeprefix(b"\xef\xbb\xbf").lstrip()
    for form in formats:
        if form.looks(path, start):
            if len(content) > form.most:
                raise ModelError([f"{path}: too large, expected {form.title} of at most {form.most:,} bytes"])
            return form, content
    text = f"of a program that is not known: not {what} that can be read, expected {titles(formats)}"
    raise ModelError([f"{path}: {text}"])
