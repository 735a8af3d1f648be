"""The answer of a run in sentences and tables, and its page with drawings and figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse import plot
from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.page import page as page_of
from desim_warehouse.answer.parts import Folded, Rows
from desim_warehouse.answer.root_words import root as root_in_words
from desim_warehouse.errors import WarehouseError, number_of
from desim_warehouse.look.web import StillPage
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import kind_in_words
from desim_warehouse.outcome.chains import lost_to
from desim_warehouse.outcome.resources import one_of
from desim_warehouse.outcome.resources import resources as of_stations_and_chargers
from desim_warehouse.questions.run import words as run_words
from desim_warehouse.questions.run.drawings import account, course, drawings, robots, rows_of_floor
from desim_warehouse.questions.run.warehouse import facts, work
from desim_warehouse.run import RunData

if TYPE_CHECKING:
    from collections.abc import Sequence

    from markupsafe import Markup
    from matplotlib.axes import Axes

_ROOTS = 10
"""Most causes of waiting in a table."""
_LEAST_LOST = 0.001
"""Share of the fleet's time from which on a cause is in the table."""
_PLACES = 24
"""Most stations and chargers in a table."""
_UNLOGGED = "This needs a run with log: all."


def read(source: str | Path | RunData) -> RunData:
    """Return a run, or load it from its folder, with a full log: a run without one is simulated again if possible."""
    run = source if isinstance(source, RunData) else RunData.load(source)
    if run.record.level == "all":
        return run
    again = in_full(run.model, run.seed)
    same = again is not None and again.record.end == run.record.end and again.record.robots == run.record.robots
    return again if again is not None and same else run


def in_full(model: Model, seed: int) -> RunData | None:
    """Simulate a run with a full log; None if it fails, or would execute the user's code: reports are safe to open."""
    if model.policies.own():
        return None
    try:
        return RunData.simulated(model.replace({"log": "all"}), seed)
    except WarehouseError:
        return None


def page(run: RunData, folder: Path | None = None, replay: str = "") -> str:
    """Compose the page of a run with all its figures.

    `folder`: the folder that keeps the run. `replay`: as in `answer.page`.
    """
    figures: dict[str, Sequence[Rows | Markup | Axes]] = {
        "": [*_some(account(run)), *drawings(run)],
        "What robots waited for": _some(rows_of_floor(run)),
        "Robots": _some(robots(run)),
        "Warm-up": warm_up_figures(run),
    }
    return page_of(answer(run, folder), figures, replay=replay)


def page_with(answer: Answer, run: RunData, worst: RunData | None = None, replay: str = "") -> str:
    """Compose the page of another question's answer, which shows a run of the design that the answer is about.

    Args:
        answer: the answer.
        run: the day that all drawings and tables show.
        worst: the worst day of the design, of which only the course is drawn.
        replay: as in `answer.page`.
    """
    warehouse = Folded(title="The warehouse", rows=tuple(facts(run.model)))
    where = Folded(title="Where the time goes")
    lost = lost_time(run)
    day = "" if answer.about is None else answer.about.day
    shown = drawings(run, day, None if worst is None else worst_course(worst, answer))
    figures: dict[str, list[Rows | Markup]] = {"": shown, where.title: [*_some(account(run))]}
    figures[lost.title] = [*_some(rows_of_floor(run))]
    parts = (where, resources(run), lost)
    of_run = [_of_one_run(part, answer) if part.rows or figures.get(part.title) else part for part in parts]
    return page_of(answer, figures, (*of_run, warehouse), replay)


def _of_one_run(part: Folded, answer: Answer) -> Folded:
    """Return a table with a note on which run it is of, if the numbers of the answer are means over several."""
    day = "" if answer.about is None else answer.about.day
    means = "; means over all runs differ" if answer.runs > 1 else ""
    note = f"Of one run{f', {day}' if day else ''}{means}."
    return part.model_copy(update={"note": f"{part.note} {note}".strip()})


def worst_course(run: RunData, answer: Answer) -> Markup | None:
    """Draw the course of the worst day of an answer's design; None if the answer has none."""
    about = answer.about
    return None if about is None or about.worst is None else course(run, about.worst.words, in_short=True)


def in_short(run: RunData) -> StillPage:
    """Compose the page of a run for Jupyter: its answer and drawings, and only the table of indicators."""
    short = answer(run).model_copy(update={"tables": (indicators(run),)})
    return StillPage(run.model.name, page_of(short, {"": [*_some(account(run)), *drawings(run)]}))


def _some(drawing: Rows | Markup | None) -> list[Rows | Markup]:
    return [] if drawing is None else [drawing]


def answer(run: RunData, folder: Path | None = None) -> Answer:
    """Return the answer of a run; `folder`: the folder that keeps the run."""
    model = run.model
    again = (
        {}
        if folder is None
        else {"To repeat it in Python": f"dw.simulate(dw.load_run({str(folder)!r}).model, seed={run.seed})"}
    )
    sure = "every seed gives the same numbers" if run.deterministic else "another seed gives other numbers"
    return Answer(
        kind="run",
        name=model.name,
        description=model.description or f"Work: {work(model)}.",
        question=question(run),
        answer=(*run_words.sentences(run), *run_words.waited(run)),
        tiles=tuple(run_words.numbers_of(run)),
        tables=(
            resources(run),
            lost_time(run),
            kinds_of_robots(run),
            _warm_up(run),
            indicators(run),
            Folded(title="The warehouse", rows=tuple(facts(model))),
        ),
        promise=numbers.sentence(sure),
        runs=1,
        confidence=None,
        made={
            **again,
            "Seed": str(run.seed),
            "Model": f"{model.name}, SHA-256 {model.digest()}",
            "desim-warehouse": run.version,
        },
    )


def question(run: RunData) -> str:
    """Return the question that a run answers: what its design achieves in the evaluation period."""
    model = run.model
    fleet: dict[str, Any] = {"fleet.size": model.fleet.size}
    if model.battery is not None:
        fleet["chargers"] = run.history.chargers
    return f"What do {words.design_spoken(fleet)} achieve in {run_words.counted_time(run)}?"


def indicators(run: RunData) -> Folded:
    """Return the table of all indicators with their units."""
    rows = [(words.indicator_name(key), words.value(key, value, run.model), key) for key, value in run.kpis.items()]
    return Folded(title="All indicators", head=("indicator", "value", "name"), rows=tuple(rows))


def resources(run: RunData) -> Folded:
    """Return the table of the utilisation and the mean queue at each station and each bay's chargers."""
    table = Folded(title="Stations and chargers", numbers=True)
    if run.record.level != "all":
        return table.model_copy(update={"note": _UNLOGGED})
    begin, end = run.history.begin, run.history.end
    every = sorted(of_stations_and_chargers(run.history), key=lambda place: -place.utilisation(begin, end))
    rows = [
        (
            f"{place.zone} ({place.node})",
            number_of(place.number, one_of(run.model, place)),
            numbers.PERCENT.value(place.utilisation(begin, end)),
            numbers.least(place.mean_queue(begin, end), 2),
        )
        for place in every[:_PLACES]
    ]
    if not rows or not run.history.counted:
        return table
    note = f"Of {len(every)} the {_PLACES} that are most in use." if len(every) > _PLACES else ""
    head = ("where", "how many", "in use", "robots in the queue")
    return table.model_copy(update={"head": head, "rows": tuple(rows), "note": note})


def lost_time(run: RunData) -> Folded:
    """Return the table of root causes that robots waited for, with the time lost to each."""
    table = Folded(title="What robots waited for", numbers=True)
    if run.record.level != "all":
        return table.model_copy(update={"note": _UNLOGGED})
    whole, unit = run.history.counted * run.model.fleet.size, run.model.units.time
    rows = [
        (
            root_in_words(root, run.model),
            numbers.duration(time, unit),
            numbers.PERCENT.value(time / whole),
            str(waiting),
        )
        for root, (time, waiting) in list(lost_to(run.history).items())[:_ROOTS]
        if time >= _LEAST_LOST * whole
    ]
    head = ("robots waited", "time, all together", "of the fleet's time", "robots")
    return table.model_copy(update={"head": head, "rows": tuple(rows)})


def kinds_of_robots(run: RunData) -> Folded:
    """Return the table of the work and the lowest battery level of each kind of robots; empty without kinds."""
    history, counted = run.history, run.history.counted
    kinds = run.model.fleet.kinds_of_robots()
    rows = []
    for kind in dict.fromkeys(kinds) if run.model.fleet.kinds and counted else ():
        robots = [number for number, other in enumerate(kinds) if other == kind]
        did = [run.record.robots[number] for number in robots]
        charged = sum(history.within(stay.start, stay.end) for stay in history.chargings if stay.robot in robots)
        lowest = min((history.lowest_levels[number] for number in robots if history.batteries), default=None)
        rows.append(
            (
                kind_in_words(kind),
                numbers.number(len(robots)),
                numbers.number(sum(robot["delivered"] for robot in did)),
                numbers.PERCENT.value(charged / (counted * len(robots))),
                "" if lowest is None else numbers.PERCENT.value(lowest),
            )
        )
    head = ("robots", "number", "delivered", "of their time at chargers", "lowest battery")
    return Folded(title="Robots", head=head, rows=tuple(rows), numbers=True)


def warm_up_figures(run: RunData) -> list[Axes]:
    """Draw the end of the warm-up, for a lifelong run that has one and is long enough."""
    if not run.model.tasks.never_end or not run.record.begin:
        return []
    try:
        return [plot.warm_up(run)]
    except WarehouseError:
        return []


def _warm_up(run: RunData) -> Folded:
    """Return the section of the page on the start of the evaluation period, below the figure of the warm-up."""
    begin = run.record.begin
    counted = f"Counted from {numbers.duration(begin, run.model.units.time)} on." if begin else ""
    return Folded(title="Warm-up", note=counted)
