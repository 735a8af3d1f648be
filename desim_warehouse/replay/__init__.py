"""The replay: a run as an HTML page that plays in any browser, without a network."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ReportError, shown
from desim_warehouse.look.palette import PALETTES
from desim_warehouse.look.web import WebPage
from desim_warehouse.values.arguments import is_finite

if TYPE_CHECKING:
    from desim_warehouse.outcome.history import History


class Replay(WebPage):
    """A replay page: `save` writes it to a file, and Jupyter displays it."""

    sandbox = "allow-scripts allow-downloads"  # the page can save a picture of itself


def replay(
    history: History,
    path: str | Path | None = None,
    *,
    start: float | None = None,
    end: float | None = None,
    palette: str = "safe",
    beside: History | None = None,
) -> Replay:
    """Make the replay page of a run, or of a window of it; with `beside`, of two runs side by side on a common clock.

    Indicators count from the end of the warm-up, or from the start of the window if that is later. In a window within
    the warm-up they count from its start.

    Args:
        history: history of a run with `log: all`.
        path: file to which the page is written; None for no file.
        start: first moment shown, in the model's time unit; by default the start of the run.
        end: last moment shown; by default the end of the run.
        palette: `safe` for colour-blind people, or `paper`, the paper's blue, red and green.
        beside: history of another run with `log: all`, shown at equal times since the start of each run.

    Raises:
        ReportError: a run without `log: all`, an empty window, an unknown palette, or a file that cannot be written.
    """
    from desim_warehouse.replay.page import page

    runs = [history] if beside is None else [history, beside]
    for run in runs:
        run.need_all("a replay")
    if palette not in PALETTES:
        raise ReportError(f"palette: {palette!r} is not known; expected one of {', '.join(PALETTES)}")
    windows = [window(history, start, end)]
    if beside is not None:
        part = history.model.units.seconds / beside.model.units.seconds
        windows.append(window(beside, *(None if time is None else time * part for time in (start, end))))
    runs = [run.since(_counted_from(run, *times)) for run, times in zip(runs, windows, strict=True)]
    result = Replay(f"{history.model.name}: replay", page(runs, windows, palette))
    if path is not None:
        result.save(path)
    return result


def part(history: History, seconds: float) -> dict[str, Any]:
    """Return the header and packed columns of a replay of the first `seconds` after the warm-up, for the live page."""
    from desim_warehouse.replay.columns import pack
    from desim_warehouse.replay.payload import payload

    if not is_finite(seconds):
        raise ReportError(f"a replay of {shown(seconds):.60} seconds: expected a number above 0")
    start = history.begin if history.begin < history.log.end else 0.0
    header, columns = payload(history, *window(history, start, start + seconds / history.model.units.seconds))
    index, text = pack(columns)
    return {"header": {**header, "columns": index}, "columns": text}


def _counted_from(history: History, start: float, end: float) -> float:
    """Return the time from which a window of a run counts."""
    return max(start, history.begin) if history.begin < end else start


def window(history: History, start: float | None, end: float | None) -> tuple[float, float]:
    """Return start and end of the part of a run between two times; raise ReportError if it is empty."""
    last = float(history.log.end)
    begin = 0.0 if start is None else start
    finish = last if end is None else end
    if not (is_finite(begin) and is_finite(finish) and 0 <= begin < min(finish, last)):
        raise ReportError(
            f"a replay from {shown(begin):.60} to {shown(finish):.60} shows nothing: the run lasts from 0 to {last:g} "
            f"{history.model.units.time}"
        )
    return float(begin), min(float(finish), last)
