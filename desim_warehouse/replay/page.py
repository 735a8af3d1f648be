"""The replay page: template, style and scripts of this package joined with the data of runs into one HTML text."""

from __future__ import annotations

import html
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from desim_warehouse._version import simulated_with
from desim_warehouse.answer.course import figure
from desim_warehouse.errors import number_of
from desim_warehouse.look.html import course_style
from desim_warehouse.look.palette import GROUND, HEAT, PAGE, PALETTES, WAITED_STEPS
from desim_warehouse.look.web import joined, safe_json
from desim_warehouse.model.facts.keys import about
from desim_warehouse.outcome.day import day
from desim_warehouse.outcome.history import History
from desim_warehouse.replay.columns import pack
from desim_warehouse.replay.payload import payload
from desim_warehouse.replay.stops import better

if TYPE_CHECKING:
    from markupsafe import Markup

_SAID = {"name", "description"}
"""Keys that do not distinguish runs in labels."""
_KEYS = 3
"""Largest number of keys in the label of a run."""
_LONGEST = 40
"""Longest value in a label, in characters; longer values are cut."""


def page(runs: Sequence[History], windows: Sequence[tuple[float, float]], palette: str) -> str:
    """Return the self-contained HTML page that replays a window of one run, or of each of two runs."""
    headers, texts = [], []
    first = (runs[0].model.content()["tasks"], runs[0].seed)
    for history, (start, end), label in zip(runs, windows, labels(runs), strict=True):
        header, columns = payload(history, start, end)
        index, text = pack(columns)
        work = (history.model.content()["tasks"], history.seed)
        headers.append({**header, "label": label, "work": work == first, "columns": index})
        texts.append(f'<script type="text/plain" class="columns">{text}</script>')
    comparison = {"better": better(runs, [header["at_end"] for header in headers])} if len(runs) > 1 else {}
    parts = {
        "title": html.escape(f"{' and '.join(dict.fromkeys(history.model.name for history in runs))}: replay"),
        "header": safe_json({"palette": palette, "colours": colours(), "runs": headers, **comparison}),
        "columns": "\n".join(texts),
        "course": f"<style>{course_style(themes=True)}</style>" + "".join(courses(runs, windows)),
    }
    return joined("desim_warehouse.replay", parts)


def courses(runs: Sequence[History], windows: Sequence[tuple[float, float]]) -> list[Markup]:
    """Draw the course of each run, from the first to the last moment of the player."""
    seconds = [history.model.units.seconds for history in runs]
    first = min(start * unit for (start, _), unit in zip(windows, seconds, strict=True))
    last = max(end * unit for (_, end), unit in zip(windows, seconds, strict=True))
    return [
        figure(day(history), history.model, history.chargers, (first / unit, last / unit))
        for history, unit in zip(runs, seconds, strict=True)
    ]


def labels(runs: Sequence[History]) -> list[str]:
    """Label each run by the keys in which the models differ, else by seed; a single run by its seed.

    Models with little in common are labelled by name. A run that another version simulated is marked as such.
    """
    contents = [dict(_flat(history.model.content())) for history in runs]
    keys = dict.fromkeys(key for content in contents for key in content)
    differ = [key for key in keys if key not in _SAID and len({_text(content.get(key)) for content in contents}) > 1]
    apart = len({content["name"] for content in contents}) == len(contents)
    captions = []
    for history, content in zip(runs, contents, strict=True):
        distinct = [key for key in differ if content.get(key) is not None] or differ
        parts = [_setting(key, content.get(key)) for key in distinct[:_KEYS]]
        if len(distinct) > _KEYS:
            parts = [content["name"]] if apart else [*parts, "..."]
        if not differ or len({history.seed for history in runs}) > 1:
            parts.append(f"seed {history.seed}")
        captions.append(", ".join(filter(None, (*parts, simulated_with(history.log.version)))))
    return captions


def _flat(content: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of a model with their dotted keys; a list is one value."""
    for key, value in content.items():
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value


def _setting(key: str, value: Any) -> str:
    """Return a key with its value in words: `3 robots`, `warm-up 600`."""
    if key == "fleet.size" and isinstance(value, int):
        return number_of(value, "robot")
    factor = about(key)
    return f"{factor.label if factor else key} {_text(value)}"


def _text(value: Any) -> str:
    """Return a value of a model as text, short enough for a label."""
    text = "none" if value is None else value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def colours() -> dict[str, Any]:
    """Return the colours of the page: of its floor, of robots and goods on it, and of waiting."""
    ground = {name: {**GROUND[name], "one": PAGE[name]["one"], "two": PAGE[name]["two"]} for name in GROUND}
    return {"ground": ground, "palettes": PALETTES, "heat": HEAT, "steps": WAITED_STEPS}
