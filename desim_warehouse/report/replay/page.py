"""The replay page: template, style and script of this package joined with the data of a run into one HTML text."""

from __future__ import annotations

import html
import json
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from desim_warehouse.report.palette import GROUND, HEAT, PALETTES
from desim_warehouse.report.replay.columns import pack
from desim_warehouse.report.replay.payload import payload

if TYPE_CHECKING:
    from desim_warehouse.run import Run

ESCAPES = {"<": "\\u003c", ">": "\\u003e", "&": "\\u0026", "\u2028": "\\u2028", "\u2029": "\\u2029"}
"""Characters that must be escaped in a script of a page."""


def page(run: Run, start: float, end: float, palette: str) -> str:
    """One self-contained HTML page that replays a window of a run; it needs no network."""
    header, columns = payload(run, start, end)
    index, text = pack(columns)
    home = files("desim_warehouse.report.replay")
    scripts = sorted((item for item in home.joinpath("js").iterdir()), key=lambda item: item.name)
    parts = {
        "title": html.escape(f"{run.model.name}: replay"),
        "style": home.joinpath("page.css").read_text(encoding="utf-8"),
        "script": "\n".join(item.read_text(encoding="utf-8") for item in scripts if item.name.endswith(".js")),
        "header": safe_json({**header, "palette": palette, "colours": _colours(), "columns": index}),
        "columns": text,
    }
    result: list[str] = []
    for piece in home.joinpath("page.html").read_text(encoding="utf-8").split("{{"):
        name, mark, rest = piece.partition("}}")
        result.append(parts[name] + rest if mark else piece)
    return "".join(result)


def _colours() -> dict[str, Any]:
    """The colours of the page: of its floor, of what moves on it, and of waiting."""
    return {"ground": GROUND, "palettes": PALETTES, "heat": HEAT}


def safe_json(value: Any) -> str:
    """JSON that is safe in a script element, whatever names it contains."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for character, escape in ESCAPES.items():
        text = text.replace(character, escape)
    return text
