"""Stops of a replay with a sentence each: a standstill, the busiest group, the longest wait, a jam, and totals."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.busiest import was
from desim_warehouse.answer.course import stood_still
from desim_warehouse.answer.root_words import root as in_words
from desim_warehouse.errors import number_of
from desim_warehouse.model.facts.workers import busiest
from desim_warehouse.outcome import chains
from desim_warehouse.outcome.halts import halts
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.indicators import kpis
from desim_warehouse.outcome.loads import loads
from desim_warehouse.outcome.resources import Resource, Steps, steps
from desim_warehouse.outcome.verdicts import is_no_answer, judge
from desim_warehouse.replay.people import busiest_picker
from desim_warehouse.replay.scale import MapScale

_TOLD: dict[str, tuple[bool, Callable[[float, str], str]]] = {
    "on_time": (True, lambda value, _: f"{numbers.PERCENT.value(value)} on time"),
    "T": (False, lambda value, unit: f"done after {numbers.duration(value, unit)}"),
    "cycle_time_mean": (False, lambda value, unit: f"mean cycle time {numbers.duration(value, unit)}"),
    "throughput_per_hour": (True, lambda value, _: f"{numbers.measured(value)} tasks an hour"),
}
"""Indicators that compare two runs, in order of priority: whether more is better, and a phrase for value and unit."""


def stops(
    history: History, places: Sequence[Resource], scale: MapScale, at_end: Mapping[str, float]
) -> list[dict[str, Any]]:
    """List the moments worth seeing.

    Each has a sentence (`said`), a `time` (None for the end), and the `robots` or the number of the `place` to show.
    Numbers of pickers follow those of robots. `at_end`: indicators at the end of the window (`tiles.figures`).
    """
    moments = (
        _standstill(history, scale),
        _busiest(history, places, scale),
        busiest_picker(history, scale),
        _longest_wait(history, scale),
        worst_jam(history, scale),
    )
    return [*(moment for moment in moments if moment is not None), {"said": _totals(history, at_end), "time": None}]


def _standstill(history: History, scale: MapScale) -> dict[str, Any] | None:
    """Return the stop at the longest standstill of deliveries; None without a standstill in the window."""
    inside = [halt for halt in halts(history) if scale.start <= (halt.start + halt.end) / 2 <= scale.end]
    if not inside:
        return None
    halt = max(inside, key=lambda halt: halt.end - halt.start)
    return {"said": stood_still(halt, history.model, history.chargers), "time": (halt.start + halt.end) / 2}


def worst_jam(history: History, scale: MapScale) -> dict[str, Any] | None:
    """Return the stop at which most robots wait for a common root; None if no two robots ever do."""
    behind = defaultdict(list)
    for wait in chains.lost(history):
        if wait.end > scale.start and wait.start < scale.end:
            behind[wait.root].append(wait)
    best: tuple[int, float, float, Any] = (1, 0.0, 0.0, None)
    for root, waits in behind.items():
        if len({wait.robot for wait in waits}) > best[0]:
            changes = [change for wait in waits for change in ((wait.start, 1), (wait.end, -1))]
            robots, time, lasts = _most(steps(changes), scale)
            if (robots, lasts) > (best[0], best[2]):
                best = robots, time, lasts, root
    robots, time, _, root = best
    if root is None:
        return None
    jammed = sorted({wait.robot for wait in behind[root] if wait.start <= time < wait.end})
    text = f"The worst jam: {robots} robots wait, in the end {in_words(root, history.model)}."
    return {"said": text, "time": time, "robots": jammed}


def _busiest(history: History, places: Sequence[Resource], scale: MapScale) -> dict[str, Any] | None:
    """Return the stop on the busiest group of the run; None if no group worked.

    For stations and chargers, it shows the place with the highest utilisation when its queue is longest.
    """
    measured = loads(history, kpis(history))
    sentence = was(measured)
    if not sentence:
        return None
    begin, group = max(history.begin, scale.start), busiest(measured)[0].group
    text = sentence if scale.end >= history.end else f"Of the whole run: {sentence}"
    among = {
        number: place.utilisation(history.begin, history.end)
        for number, place in enumerate(places)
        if (group.kind == "chargers" == place.kind)
        or (place.kind == "station" and place.zone == group.zone and group.nodes)
    }
    if not among:
        return {"said": text, "time": begin}
    number = max(among, key=among.__getitem__)
    _, time, _ = _most(places[number].queue, scale)
    return {"said": text, "time": time or begin, "place": number}


def _longest_wait(history: History, scale: MapScale) -> dict[str, Any] | None:
    """Return the stop at the longest wait in traffic; the page adds the chain of robots waited for."""
    inside = [wait for wait in history.waits if scale.start <= (wait.start + wait.end) / 2 <= scale.end]
    if not inside:
        return None
    wait = max(inside, key=lambda wait: wait.end - wait.start)
    lasts = numbers.duration(wait.end - wait.start, history.model.units.time)
    text = f"The longest wait in traffic: robot {wait.robot}, {lasts} in all."
    return {"said": text, "time": (wait.start + wait.end) / 2, "robots": [wait.robot]}


def _most(queue: Steps, scale: MapScale) -> tuple[int, float, float]:
    """Return the maximum of a queue in the window, and the middle and length of the longest time at this maximum."""
    times, counts = queue
    best = (0, 0.0, 0.0)
    for i, count in enumerate(counts):
        begin, end = max(times[i], scale.start), min(times[i + 1] if i + 1 < len(times) else scale.end, scale.end)
        if begin < end and (count, end - begin) > (best[0], best[2]):
            best = (count, (begin + end) / 2, end - begin)
    return best


def _totals(history: History, at_end: Mapping[str, float]) -> str:
    parts = [f"{number_of(int(at_end['tasks']), words.load(history.model))} delivered"]
    if "on_time" in at_end and not _falls_behind(history):
        parts.append(f"{numbers.PERCENT.value(at_end['on_time'])} on time")
    if "share_waiting" in at_end:
        parts.append(f"robots wait in traffic {numbers.PERCENT.value(at_end['share_waiting'])} of the time")
    return f"In all: {', '.join(parts)}."


def _falls_behind(history: History) -> bool:
    """Whether the share on time of a run is meaningless, as its backlog grows."""
    return is_no_answer("on_time", judge(kpis(history), history.model))


def better(runs: Sequence[History], at_end: Sequence[Mapping[str, float]]) -> str:
    """Return a sentence on the better of two runs, by the first indicator that differs at the end of their windows."""
    behind = [_falls_behind(run) for run in runs]
    if behind[0] != behind[1]:
        return f"{'AB'[behind.index(True)]} cannot keep up, {'AB'[behind.index(False)]} can."
    unit = runs[0].model.units.time
    for name, (more, phrase) in _TOLD.items():
        first, second = (figures.get(name, math.nan) for figures in at_end)
        if first != second and math.isfinite(first + second) and not (behind[0] and name == "on_time"):
            best = int((second > first) == more)
            texts = [phrase(value, unit) for value in (first, second)]
            return f"{'AB'[best]} does better in this run: {texts[best]}, {'AB'[1 - best]}: {texts[1 - best]}."
    return "Both do the same."
