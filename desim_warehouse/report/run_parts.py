"""The page of a single run: what it achieved, where the time of a task went, the floor, and all else folded away."""

from __future__ import annotations

import platform
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse._version import __version__
from desim_warehouse.errors import WarehouseError, number_of
from desim_warehouse.model.facts.charging import said
from desim_warehouse.outcome.chains import lost_to
from desim_warehouse.outcome.resources import resources as of_stations_and_chargers
from desim_warehouse.report import html, plot
from desim_warehouse.report import page as pages
from desim_warehouse.report.html import Html
from desim_warehouse.report.model_parts import model_facts, work
from desim_warehouse.report.page import ReportPage
from desim_warehouse.report.svg import account, floor
from desim_warehouse.report.text import numbers, run_words, words
from desim_warehouse.report.text.root_words import root as root_in_words
from desim_warehouse.run import Run
from desim_warehouse.states import staff

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_ROOTS = 10
"""Roots of waiting in a table."""
_PLACES = 24
"""Stations and chargers in a table, and in a figure."""
_GANTT = 24
"""Robots in the Gantt chart."""
_SPANS = 400
"""The most states in the Gantt chart; of longer runs a part is shown."""


def read(folder: str | Path | Run) -> Run:
    """A run, or that of a folder, with everything logged: again if it was not."""
    from desim_warehouse.run import Run as Done
    from desim_warehouse.run.folder import load_run

    run = folder if isinstance(folder, Done) else load_run(folder)
    if run.record.level == "all":
        return run
    again = pages.in_full(run.model, run.seed)
    same = again is not None and again.record.end == run.record.end and again.record.robots == run.record.robots
    return again if again is not None and same else run


def page(folder: str | Path | Run, replay: str | None = None) -> ReportPage:
    """The report of a run, or of that of a folder; `replay` is the file for its replay, which the first page links."""
    run = read(folder)
    return pages.ReportPage(
        title=run.model.name,
        first=[first_page(run, replay), account(run), floor(run)],
        folded={
            "Stations and chargers": [resources(run)],
            "What robots waited for": [lost_time(run)],
            "Robots": [*robot_figures(run), kinds_of_robots(run)],
            "Warm-up": [*warm_up_figures(run), warm_up(run)],
            "All indicators": [indicators(run)],
            "The warehouse": [model_facts(run.model)],
            "See it again": [method(run, None if run is folder else str(folder))],
        },
    )


def first_page(run: Run, replay: str | None = None) -> Html:
    """The question, the answer, and what a year like the run costs."""
    about = run.model.description or f"Work: {work(run.model)}."
    said = [*run_words.sentences(run), *run_words.waited(run)]
    return pages.first_page(run.model.name, about, question(run), run_words.numbers_of(run), said, run, replay)


def question(run: Run) -> str:
    """What was simulated."""
    model = run.model
    fleet: dict[str, Any] = {"fleet.size": model.fleet.size}
    if model.battery is not None:
        fleet["chargers"] = run.history.chargers
    return f"What do {words.design_spoken(fleet)} achieve in {run_words.counted_time(run)}?"


def indicators(run: Run) -> Html:
    """All indicators with their units."""
    rows = [[words.indicator_name(key), words.value(key, value, run.model), key] for key, value in run.kpis.items()]
    return html.table(["indicator", "value", "name"], rows, words=3, name="indicators")


def resources(run: Run) -> Html | None:
    """How busy the servers of each station and the chargers of each bay are, and how many robots queue there."""
    if run.record.level != "all":
        return html.paragraph("How busy stations and chargers are needs a run with log: all.", "note")
    begin, end = run.history.begin, run.history.end
    every = list(of_stations_and_chargers(run.history))
    few = len(every) <= _PLACES
    shown = every if few else sorted(every, key=lambda one: -one.utilisation(begin, end))[:_PLACES]
    rows = [
        [
            f"{one.zone} ({one.node})",
            number_of(one.number, "charger" if one.kind == "chargers" else staff(one.zone)),
            numbers.PERCENT.value(one.utilisation(begin, end)),
            numbers.least(one.mean_queue(begin, end), 2),
        ]
        for one in shown
    ]
    if not rows or not run.history.counted:
        return None
    table = html.table(["where", "how many", "in use", "robots in the queue"], rows, name="resources")
    return table if few else table + html.paragraph(f"Of {len(every)} the {_PLACES} that are most in use.", "note")


def robot_figures(run: Run) -> list[Axes]:
    """Shares of time, states over time, and batteries where there are any."""
    fleet = range(run.model.fleet.size)
    figures = [plot.utilisation(run)]
    shown = list(fleet[:_GANTT])
    states = sum(len(robot) for robot in run.history.states[:_GANTT])
    end = run.history.begin + run.history.counted * min(1.0, _SPANS / max(states, 1))
    if end > run.history.begin:
        figures.append(plot.gantt(run, robots=shown, start=run.history.begin, end=end))
    if run.model.battery is not None:
        figures.append(plot.battery(run))
    return figures


def kinds_of_robots(run: Run) -> Html | None:
    """What the robots of each kind did, and how low their batteries came, where there are kinds."""
    history, counted = run.history, run.history.counted
    kinds = run.model.fleet.kinds_of_robots()
    if not run.model.fleet.kinds or not counted:
        return None
    rows = []
    for kind in dict.fromkeys(kinds):
        robots = [number for number, other in enumerate(kinds) if other == kind]
        did = [run.record.robots[number] for number in robots]
        charged = sum(history.within(one.start, one.end) for one in history.chargings if one.robot in robots)
        lowest = min((history.lowest_levels[number] for number in robots if history.batteries), default=None)
        rows.append(
            [
                said(kind),
                numbers.number(len(robots)),
                numbers.number(sum(one["delivered"] for one in did)),
                numbers.PERCENT.value(charged / (counted * len(robots))),
                "" if lowest is None else numbers.PERCENT.value(lowest),
            ]
        )
    heads = ["robots", "number", "delivered", "of their time at chargers", "lowest battery"]
    return html.table(heads, rows, name="kinds")


def lost_time(run: Run) -> Html | None:
    """What robots waited for in the end, and how much time was lost to it."""
    if run.record.level != "all":
        return html.paragraph("What robots waited for needs a run with log: all.", "note")
    found = list(lost_to(run.history).items())[:_ROOTS]
    if not found:
        return None
    whole, unit = run.history.counted * run.model.fleet.size, run.model.units.time
    rows = [
        [root_in_words(root, run.model), numbers.duration(time, unit), numbers.PERCENT.value(time / whole), str(robots)]
        for root, (time, robots) in found
    ]
    return html.table(["robots waited", "time, all together", "of the fleet's time", "robots"], rows, name="lost")


def warm_up_figures(run: Run) -> list[Axes]:
    """Where the warm-up ends, for a lifelong run long enough to tell."""
    if not run.model.tasks.never_end:
        return []
    try:
        return [plot.warm_up(run)]
    except WarehouseError:
        return []


def warm_up(run: Run) -> Html | None:
    """How to read the figure of the warm-up."""
    if not warm_up_figures(run):
        return None  # it ends with its work, or is too short: there is no steady state
    return html.paragraph(f"Counted from {numbers.duration(run.record.begin, run.model.units.time)} on.", "note")


def made_with() -> tuple[str, str]:
    """What makes the report; its runs may be older."""
    return "Report made with", f"desim-warehouse {__version__}, Python {platform.python_version()}"


def method(run: Run, folder: str | None) -> Html:
    """How to get the same run again."""
    rows = [
        *(
            [("To repeat it in Python", f"dw.simulate(dw.load_run({folder!r}).model, seed={run.seed})")]
            if folder
            else []
        ),
        ("Seed", str(run.seed)),
        ("Model", f"{run.model.name}, SHA-256 {run.model.digest()}"),
        ("desim-warehouse", run.version),
        made_with(),
    ]
    return html.facts(rows, "method")
