"""The page of a single run: what it achieved, where the time of a task went, the floor, and all else folded away.

The key figures of its model stand there, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse import plot
from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.page import made_with
from desim_warehouse.answer.root_words import root as root_in_words
from desim_warehouse.errors import WarehouseError, number_of
from desim_warehouse.feasibility import errors
from desim_warehouse.layout import Layout
from desim_warehouse.look import html
from desim_warehouse.look import page as pages
from desim_warehouse.look.html import Html
from desim_warehouse.look.page import ReportPage
from desim_warehouse.look.web import StillPage
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import by_kind, charge_alike, levels, said
from desim_warehouse.model.facts.disturbances import closures, disturbances
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.model.sections.fleet import RobotSpec
from desim_warehouse.model.sections.flows import in_words
from desim_warehouse.model.sections.goods import SaturatedGoods
from desim_warehouse.outcome.chains import lost_to
from desim_warehouse.outcome.resources import resources as of_stations_and_chargers
from desim_warehouse.questions.run import words as run_words
from desim_warehouse.questions.run.drawings import account, course, floor
from desim_warehouse.run import RunData
from desim_warehouse.states import staff
from desim_warehouse.values.units import SECONDS

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def model_facts(model: Model) -> Html:
    """Floor, fleet, work, batteries and policies."""
    floor = model.floor
    units, fleet = model.units, model.fleet
    most = fleet.largest_capacity
    rows = [
        ("Model", model.name),
        ("Floor", _floor(floor)),
        (
            "Robots",
            (
                f"{fleet.size}, radius {numbers.number(fleet.robot.radius)} {units.length}, "
                f"speed {numbers.number(fleet.robot.speed)} {units.length} per {units.time}"
                + _motion(fleet.robot)
                + (f", up to {most} loads each" if most > 1 else "")
            ),
        ),
        ("Work", work(model)),
        ("Unloading", f"at {', '.join(destinations(model, floor))}"),
        ("Battery", _batteries(model)),
        ("Policies", _policies(model)),
        *_hours(model),
        *[("What goes wrong", text) for text in (*disturbances(model, floor), *closures(model))],
    ]
    if units.time not in SECONDS:
        rows.append(("Time unit", f"1 {units.time} = {numbers.number(units.seconds)} s"))
    if model.run.length is not None:
        start = f", begun at {model.run.start}" if model.calendars else ""
        length = f"{numbers.duration(model.run.length, units.time)}{start}"
        warm_up = numbers.duration(model.run.warm_up, units.time)
        rows.append(("Run", f"{length}, counted after a warm-up of {warm_up}" if model.run.warm_up else length))
    accepted = [item.problem for item in errors(model) if item.code in model.accept]
    rows += [("Accepted error", problem) for problem in accepted]
    return html.facts(rows, "model")


def work(model: Model) -> str:
    """The demand in words."""
    goods = model.tasks.goods
    if model.tasks.flows:
        return "; ".join(f"{name}: {in_words(flow, model.tasks.demand)}" for name, flow in model.tasks.flows.items())
    if isinstance(goods, tuple):
        return f"{len(goods)} items, one by one as listed"
    if isinstance(goods, SaturatedGoods):
        return f"{numbers.number(goods.open(model.fleet.size))} tasks always open, without end"
    for name, text in (
        ("random", "{} items drawn at random"),
        ("poisson", "{} tasks an hour on average, without end"),
    ):
        if hasattr(goods, name):
            rate = model.tasks.demand if name == "poisson" else 1
            return text.format(numbers.number(getattr(goods, name) * rate))
    return "as in the model"


def _hours(model: Model) -> Iterator[tuple[str, str]]:
    """The calendars of stations and robots, and their hours."""
    fleet, tasks = model.fleet, model.tasks
    named = {f"station {name}": station.hours for name, station in model.layout.stations.items()}
    pauses = {f"station {name}" for name, station in model.layout.stations.items() if station.at_close == "pause"}
    named |= {"robots": fleet.hours} | {f"robots of kind {name}": kind.hours for name, kind in fleet.kinds.items()}
    named |= {f"flow {name}": flow.hours for name, flow in tasks.flows.items()}
    named |= {"tasks": getattr(tasks.goods, "hours", None)}
    for who, calendar in named.items():
        if calendar is not None:
            hours = model.calendars[calendar].words(model.units.time)
            yield "Hours", f"{who}: {calendar}, {hours}" + ("; what has begun pauses" if who in pauses else "")


def _motion(robot: RobotSpec) -> str:
    """Speed with a load, acceleration, deceleration and the distance kept, where the model has them."""
    said = [
        f"{numbers.number(value)} {what}"
        for value, what in (
            (robot.speed_loaded, "loaded"),
            (robot.acceleration, "acceleration"),
            (robot.deceleration, "deceleration"),
        )
        if value is not None
    ]
    if robot.keeps == "braking":
        said.append("keeps its braking distance")
    return f" ({', '.join(said)})" if said else ""


def _floor(floor: Layout) -> str:
    two_way = len(floor.two_way)
    lanes = number_of(len(floor.lanes) - two_way, "one-way lane")
    lanes += f", {number_of(two_way, 'two-way lane')}" if two_way else ""
    return f"{number_of(len(floor.graph), 'node')}, {lanes}, {number_of(len(floor.storage), 'storage place')}"


def _batteries(model: Model) -> str:
    """The battery of all robots, or of each kind where they differ."""
    if charge_alike(model):
        return _battery(model)
    return "; ".join(f"{said(kind)}: {_battery(alone)}" for kind, alone in by_kind(model).items())


def _battery(model: Model) -> str:
    battery, found = model.battery, levels(model)
    if battery is None:
        return "none: robots never need charging"
    sent = ", when to charge as its policy says"
    if found is not None:
        sent = f", sent to charge at {numbers.number(found.critical or found.good)}"
    return (
        f"capacity {numbers.number(battery.capacity)}{sent}, charging {numbers.number(battery.charge_rate)} "
        f"per {model.units.time}"
    )


def _policies(model: Model) -> str:
    """The policies by kind, with their parameters."""
    from desim_warehouse.model.sections.policy import PolicySpec

    policies = model.policies
    said = []
    for kind in type(policies).model_fields:
        spec = getattr(policies, kind)
        if isinstance(spec, PolicySpec) and spec.name != "single":  # which is no batching at all
            parameters = "".join(f", {key} {words.level(value)}" for key, value in spec.params.items())
            said.append(f"{words.in_words(f'policies.{kind}')}: {words.policy(kind, spec.name)}{parameters}")
    return "; ".join(said)


_ROOTS = 10
"""Roots of waiting in a table."""
_LEAST_LOST = 0.001
"""The part of the fleet's time from which a root is in it."""
_PLACES = 24
"""Stations and chargers in a table, and in a figure."""
_GANTT = 24
"""Robots in the Gantt chart."""
_SPANS = 400
"""The most states in the Gantt chart; of longer runs a part is shown."""


def read(source: str | Path | RunData) -> RunData:
    """Return a run, or load it from its folder, with everything logged: simulated again if it was not."""
    run = source if isinstance(source, RunData) else RunData.load(source)
    if run.record.level == "all":
        return run
    again = in_full(run.model, run.seed)
    same = again is not None and again.record.end == run.record.end and again.record.robots == run.record.robots
    return again if again is not None and same else run


def in_full(model: Model, seed: int) -> RunData | None:
    """Simulate a run with everything logged; None where it fails, or would run code: reports must be safe to open."""
    if model.policies.own():
        return None
    try:
        return RunData.simulated(model.replace({"log": "all"}), seed)
    except WarehouseError:
        return None


def drawings(run: RunData) -> list[Html]:
    """Draw how the run went by the clock, and the floor by waiting, as far as the log tells."""
    return [drawing for drawing in (course(run), floor(run)) if drawing is not None]


def tables(run: RunData) -> list[tuple[str, Html]]:
    """List what the page of an answer folds away of the run that it shows, each table with its title."""
    parts = {
        "Where the time goes": account(run),
        "Stations and chargers": resources(run),
        "What robots waited for": lost_time(run),
    }
    shown = [(title, part) for title, part in parts.items() if part is not None]
    return [*shown, ("The warehouse", model_facts(run.model))]


def in_short(run: RunData) -> StillPage:
    """Compose what Jupyter shows of a run: the first page of its report, and its indicators."""
    first = [first_page(run), account(run), course(run), floor(run)]
    report = ReportPage(title=run.model.name, first=first, folded={"All indicators": [indicators(run)]})
    return StillPage(run.model.name, report.html())


def page(folder: str | Path | RunData, replay: str | None = None) -> ReportPage:
    """The report of a run, given or from a folder; `replay` is the file for its replay, which the first page links."""
    run = read(folder)
    return ReportPage(
        title=run.model.name,
        first=[first_page(run, replay), account(run), course(run), floor(run)],
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


def first_page(run: RunData, replay: str | None = None) -> Html:
    """The question, the answer, and what a year like the run costs."""
    about = run.model.description or f"Work: {work(run.model)}."
    said = [*run_words.sentences(run), *run_words.waited(run)]
    link = None
    if replay is not None:
        run.replay(replay)
        link = html.link("Watch a run", Path(replay).name)
    return pages.first_page(run.model.name, about, question(run), run_words.numbers_of(run), said, link)


def question(run: RunData) -> str:
    """What was simulated."""
    model = run.model
    fleet: dict[str, Any] = {"fleet.size": model.fleet.size}
    if model.battery is not None:
        fleet["chargers"] = run.history.chargers
    return f"What do {words.design_spoken(fleet)} achieve in {run_words.counted_time(run)}?"


def indicators(run: RunData) -> Html:
    """All indicators with their units."""
    rows = [[words.indicator_name(key), words.value(key, value, run.model), key] for key, value in run.kpis.items()]
    return html.table(["indicator", "value", "name"], rows, words=3, name="indicators")


def resources(run: RunData) -> Html | None:
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


def robot_figures(run: RunData) -> list[Axes]:
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


def kinds_of_robots(run: RunData) -> Html | None:
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


def lost_time(run: RunData) -> Html | None:
    """What robots waited for in the end, and how much time was lost to it."""
    if run.record.level != "all":
        return html.paragraph("What robots waited for needs a run with log: all.", "note")
    whole, unit = run.history.counted * run.model.fleet.size, run.model.units.time
    found = [one for one in lost_to(run.history).items() if one[1][0] >= _LEAST_LOST * whole][:_ROOTS]
    if not found:
        return None
    rows = [
        [root_in_words(root, run.model), numbers.duration(time, unit), numbers.PERCENT.value(time / whole), str(robots)]
        for root, (time, robots) in found
    ]
    return html.table(["robots waited", "time, all together", "of the fleet's time", "robots"], rows, name="lost")


def warm_up_figures(run: RunData) -> list[Axes]:
    """Show where the warm-up ends, for a lifelong run that has one and is long enough to tell."""
    if not run.model.tasks.never_end or not run.record.begin:
        return []
    try:
        return [plot.warm_up(run)]
    except WarehouseError:
        return []


def warm_up(run: RunData) -> Html | None:
    """How to read the figure of the warm-up."""
    if not warm_up_figures(run):
        return None
    return html.paragraph(f"Counted from {numbers.duration(run.record.begin, run.model.units.time)} on.", "note")


def method(run: RunData, folder: str | None) -> Html:
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
