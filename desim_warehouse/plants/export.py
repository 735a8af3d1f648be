"""A model's layout for other programs: the formats that `read_layout` reads, written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

from desim_warehouse.errors import ReportError, got, nearest, reason
from desim_warehouse.folders import make_folder
from desim_warehouse.model import as_model
from desim_warehouse.plants.drawn import drawn
from desim_warehouse.plants.names import plain_names

if TYPE_CHECKING:
    from desim_warehouse.model import Source
    from desim_warehouse.plants.plant import Plant, Remark

LayoutFormat = Literal["lif", "opentcs", "graphml", "csv"]
LAYOUT_FORMATS: tuple[str, ...] = get_args(LayoutFormat)


def write_layout(model: Source, path: str | Path, format: str) -> tuple[Remark, ...]:  # noqa: A002 - as pandas and others
    """Write the layout of a model for other programs, in metres and seconds.

    Args:
        model: the model.
        path: the file; for csv the folder that gets nodes.csv and edges.csv.
        format: lif (Layout Interchange Format of VDMA, 1.0.0), opentcs (a plant model, 7.0.0), graphml or csv.

    Returns:
        What of the model the format cannot hold, and what is changed.

    Raises:
        ReportError: another format, or a path that cannot be written.
        LayoutError: where two things claim one node.
    """
    if format not in LAYOUT_FORMATS:
        near = nearest(format, LAYOUT_FORMATS)
        hint = f"; did you mean {got(near)}?" if near else ""
        raise ReportError(f"format {got(format)}: expected one of {', '.join(LAYOUT_FORMATS)}{hint}")
    path, plant = Path(path), drawn(as_model(model))
    plain_names(plant)
    texts = _texts(plant, format)
    try:
        make_folder(path if format == "csv" else path.parent)
        for name, text in texts.items():
            (path / name if name else path).write_text(text, encoding="utf-8")
    except (OSError, ValueError) as error:
        raise ReportError(f"{path}: cannot be written ({reason(error)})") from None
    return tuple(plant.remarks)


def _texts(plant: Plant, form: str) -> dict[str, str]:
    """The texts to write, by the names of files in a folder. A single file has no name."""
    if form == "csv":
        from desim_warehouse.plants.to_tables import tables

        return tables(plant)
    if form == "graphml":
        from desim_warehouse.plants.to_tables import graphml

        return {"": graphml(plant)}
    if form == "opentcs":
        from desim_warehouse.plants.to_opentcs import opentcs

        return {"": opentcs(plant)}
    from desim_warehouse.plants.to_lif import lif

    return {"": lif(plant)}
