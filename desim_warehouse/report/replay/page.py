"""The replay page: template, style and script of this package joined with the data of a run into one HTML text."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any

from desim_warehouse.report.palette import GROUND, HEAT, PALETTES
from desim_warehouse.report.replay.columns import pack
from desim_warehouse.report.replay.payload import payload
from desim_warehouse.report.web import joined, safe_json

if TYPE_CHECKING:
    from desim_warehouse.run import Run


def page(run: Run, start: float, end: float, palette: str) -> str:
    """One self-contained HTML page that replays a window of a run; it needs no network."""
    header, columns = payload(run, start, end)
    index, text = pack(columns)
    parts = {
        "title": html.escape(f"{run.model.name}: replay"),
        "header": safe_json({**header, "palette": palette, "colours": _colours(), "columns": index}),
        "columns": text,
    }
    return joined("desim_warehouse.report.replay", parts)


def _colours() -> dict[str, Any]:
    """The colours of the page: of its floor, of what moves on it, and of waiting."""
    return {"ground": GROUND, "palettes": PALETTES, "heat": HEAT}
