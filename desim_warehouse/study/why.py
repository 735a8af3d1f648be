"""Why a warehouse does no better: what each suspect costs, by relieving it in the model and simulating that.

Suspects come from the account of time of a run: who waits long is looked at first. A wait at one point need not cost
anything, as a queue elsewhere might grow instead. So every suspect is relieved in the model's own keys, on the same
days. What the warehouse gains is what the suspect costs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import StudyError
from desim_warehouse.model.destinations import destinations
from desim_warehouse.model.goods import PoissonGoods
from desim_warehouse.outcome.indicators import find
from desim_warehouse.run import simulate
from desim_warehouse.states import BROKEN, CHARGER, OPENING, SERVER, SHOWN
from desim_warehouse.study import statistics
from desim_warehouse.study.fleet import Designs, could_run
from desim_warehouse.study.study import Study
from desim_warehouse.values.distributions import scaled

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    import pandas as pd

    from desim_warehouse.model import Model
    from desim_warehouse.run import Run
    from desim_warehouse.states import Queue
    from desim_warehouse.study.statistics import Gain, Gains

MOST_NODES = 5
"""Intersections that are looked at: those with the most waiting before them."""
LEAST_WAITING = 0.002
"""Part of the fleet's time that must be waited before an intersection for it to be looked at."""
SOONER, FEWER = 0.9, 0.95
"""What handling times and demand are multiplied by."""
LEAST = 0.01
"""Part of the indicator's mean that matters."""


@dataclass(frozen=True)
class Suspect:
    """Something that may hold the warehouse up: its name, the relief in words and in keys of the model.

    `waited`: the part of the fleet's time that robots waited there, in the run that was looked at, None where robots do
    not wait for it, such as handling.
    """

    name: str
    relief: str
    overrides: Mapping[str, Any]
    waited: float | None


@dataclass(frozen=True)
class Why:
    """What the suspects cost: each with its gain, the costliest first."""

    indicator: str
    found: tuple[tuple[Suspect, Gain], ...]
    gains: Gains

    @property
    def by_waiting(self) -> Suspect | None:
        """The suspect at which robots wait longest, who would be blamed without a test."""
        waiting = [suspect for suspect, _ in self.found if suspect.waited]
        return max(waiting, key=lambda suspect: suspect.waited or 0.0, default=None)


def suspects(run: Run) -> list[Suspect]:
    """What may hold a warehouse up, by a run with `log: all`: who is waited for longest first.

    Raises:
        ReportError: a run with less in its log.
    """
    model, nodes = run.model, run.account(by="node")
    whole = run.history.counted * model.fleet.size or 1.0
    before = (nodes["before_intersection"] / whole).sort_values(ascending=False, kind="stable")
    at_nodes = [
        Suspect(f"intersection {node}", f"nobody waits at {node}", {f"traffic.nodes.{node}.free": True}, float(share))
        for node, share in zip(map(str, before.index[:MOST_NODES]), before, strict=False)
        if share >= LEAST_WAITING and "." not in node  # a name that cannot stand in a dotted key
    ]
    stations = _stations(run)
    queued = {zone: _queued(nodes, SERVER, at) / whole for zone, at in stations.items()}
    closed = {zone: _queued(nodes, OPENING, at) / whole for zone, at in stations.items()}
    others = [
        *_servers(model, queued),
        *_chargers(model, _queued(nodes, CHARGER, list(nodes.index)) / whole),
        *_workers(model, queued),
        *_hours(model, closed),
        *_on_the_way(run),
        *_failures(run),
    ]
    waiting = sorted((*at_nodes, *others), key=lambda suspect: -(suspect.waited or 0.0))
    return [*waiting, *_plain(model)]


def _queued(nodes: pd.DataFrame, queue: Queue, at: list[str]) -> float:
    """The time for which robots queue for something at some nodes, by the account of time of `nodes`."""
    states = [state.name for state in SHOWN.values() if state.queue == queue and state.name in nodes]
    return sum(float(nodes[state][at].sum()) for state in states)


def _stations(run: Run) -> dict[str, list[str]]:
    """The nodes of each station that is used and whose name can stand in a dotted key."""
    found: dict[str, list[str]] = {}
    for node in destinations(run.model, run.layout):
        if node in run.layout.stations:
            found.setdefault(run.layout.stations[node].zone, []).append(node)
    return {zone: at for zone, at in found.items() if "." not in zone}


def _servers(model: Model, queued: Mapping[str, float]) -> Iterator[Suspect]:
    """One server more at every node of a station, and one slot more where slots keep robots from working."""
    for zone, share in queued.items():
        station = model.layout.stations[zone]
        key = f"layout.stations.{zone}"
        more: dict[str, Any] = {f"{key}.servers": station.servers + 1}
        if station.places <= station.servers:
            more[f"{key}.places"] = station.servers + 1
        yield Suspect(f"station {zone}", f"one server more at each node of {zone}", more, share)
    layout = model.floor
    used = [node for node in destinations(model, layout) if node in layout.stations]
    if queued and sum(layout.stations[node].places for node in used) < model.fleet.size:
        more = {f"layout.stations.{zone}.places": model.layout.stations[zone].places + 1 for zone in queued}
        yield Suspect("places at the stations", "one place more at each node of the stations", more, None)


def _chargers(model: Model, queued: float) -> Iterator[Suspect]:
    designs = Designs(model)
    if designs.zone is not None:
        more = designs.of_chargers(designs.today + 1)
        if could_run(model, more):
            yield Suspect("chargers", "one charger more", more, queued)


def _workers(model: Model, zones: Iterable[str]) -> Iterator[Suspect]:
    """Those who work on what robots put down, with room for what is in work."""
    for zone in zones:
        station, key = model.layout.stations[zone], f"layout.stations.{zone}"
        if station.work_time is not None:
            more = {f"{key}.workers": station.workers + 1}
            if station.buffer is not None:
                more[f"{key}.buffer"] = max(station.buffer, station.workers + 1)
            yield Suspect(f"workers of {zone}", f"one worker more at each node of {zone}", more, None)


def _hours(model: Model, closed: Mapping[str, float]) -> Iterator[Suspect]:
    """Opening hours of stations, and shifts of robots."""
    for zone, share in closed.items():
        key = f"layout.stations.{zone}"
        if model.layout.stations[zone].hours is not None:
            always = {f"{key}.hours": None, f"{key}.at_close": "finish"}
            yield Suspect(f"hours of {zone}", f"{zone} always open", always, share)
    if model.fleet.has_hours:
        always = {"fleet.hours": None, **dict.fromkeys(_of_kinds(model, "hours"))}
        yield Suspect("shifts of robots", "robots always at work", always, None)


def _on_the_way(run: Run) -> Iterator[Suspect]:
    """What is closed or slow, and people in the aisles."""
    traffic = run.model.traffic
    if traffic.closures:
        closed = run.kpis["share_waiting_closed"]
        yield Suspect("closures", "nothing closed", {"traffic.closures": {}}, closed)
    if traffic.slow:
        yield Suspect("zones that are slow", "nothing slow", {"traffic.slow": {}}, None)
    if run.model.people:
        yield Suspect("people in the aisles", "nobody in the aisles", {"people": {}}, run.kpis["share_waiting_person"])


def _failures(run: Run) -> Iterator[Suspect]:
    """Robots and chargers that break down, and robots that lose time at nodes."""
    model = run.model
    if model.fleet.breaks_down:
        never = dict.fromkeys(("fleet.robot.breakdowns", *_of_kinds(model, "breakdowns")))
        broken = sum(run.kpis[f"share_{state}"] for state in BROKEN)
        yield Suspect("breakdowns", "robots never break down", never, broken)
    if any(robot.delays for robot in model.fleet.robots()):
        never = dict.fromkeys(("fleet.robot.delays", *_of_kinds(model, "delays")))
        yield Suspect("delays", "no delays at nodes", never, None)
    fail = [name for name, bay in model.layout.bays.items() if bay.outages is not None and "." not in name]
    if fail and model.battery is not None:
        never = {f"layout.bays.{name}.outages": None for name in fail}
        yield Suspect("outages of chargers", "chargers never fail", never, None)


def _of_kinds(model: Model, key: str) -> list[str]:
    """Where kinds of robots have a key of their own."""
    kinds = model.fleet.kinds.items()
    return [f"fleet.kinds.{name}.{key}" for name, kind in kinds if getattr(kind, key) is not None and "." not in name]


def _plain(model: Model) -> Iterator[Suspect]:
    """Handling, the number of robots, and demand: robots do not wait for them, but they may be the limit."""
    tasks = model.tasks
    sections = {
        "tasks": tasks,
        **{f"tasks.flows.{name}": flow for name, flow in tasks.flows.items() if "." not in name},
        **{f"layout.stations.{name}": part for name, part in model.layout.stations.items() if "." not in name},
    }
    shorter = {
        f"{section}.{key}": scaled(getattr(part, key), SOONER)
        for section, part in sections.items()
        for key in ("load_time", "unload_time")
        if getattr(part, key)
    }
    if shorter:
        yield Suspect("handling", "loading and unloading a tenth shorter", shorter, None)
    more = {"fleet.size": model.fleet.size + 1}
    if could_run(model, more):
        yield Suspect("the number of robots", "one robot more", more, None)
    goods = tasks.goods
    if isinstance(goods, PoissonGoods):
        less = {"tasks.goods": {**goods.content(), "poisson": goods.poisson * FEWER}}
        yield Suspect("demand", "5 % fewer orders", less, None)
    elif tasks.arrive and tasks.has_rates:
        yield Suspect("demand", "5 % fewer orders", {"tasks.demand": tasks.demand * FEWER}, None)


def usual_indicator(run: Run) -> str:
    """What the costs are counted in by default: throughput where work always waits, else time."""
    overloaded = any(verdict.code == "CANNOT_KEEP_UP" for verdict in run.verdicts)
    tasks = run.model.tasks
    if (tasks.never_end and not tasks.arrive) or overloaded:
        return "throughput_per_hour"
    return "cycle_time_mean" if run.model.tasks.never_end else "T"


def why(
    source: Run | Model,
    *,
    indicator: str | None = None,
    confidence: float = 0.95,
    seed: int = 0,
    first: int = 10,
    cap: int = 160,
    timeout: float | None = None,
    **where: Any,
) -> Why:
    """What holds a warehouse up, and what it costs: each suspect is relieved and simulated, the same days for all.

    Args:
        source: a run with `log: all`, or a model, of which one is made.
        indicator: what costs are counted in (default: `usual_indicator`).
        confidence: that all intervals hold.
        seed: of the runs.
        first: replications before anything is decided.
        cap: most replications.
        timeout: seconds that a run may take.
        where: workers, cluster, out, progress, as of `Study.run`.

    Raises:
        StudyError: an indicator of which neither less nor more is better, or a run that failed.

    Source: `statistics.gains_steps`. Relieving one thing at a time is the definition of a bottleneck by its effect
    (sensitivity of throughput to each resource); see docs/how-to/find-the-bottleneck.md.
    """
    from desim_warehouse.model import Model as Described

    run = simulate(source.replace({"log": "all"}), seed) if isinstance(source, Described) else source
    model, name = run.model, indicator or usual_indicator(run)
    better = find(name).better
    if better is None:
        raise StudyError(f"indicator {name!r}: neither less nor more of it is better, so nothing can cost anything")
    looked_at = suspects(run)
    cases: dict[str, Any] = {"as it is": {}, **{suspect.relief: dict(suspect.overrides) for suspect in looked_at}}
    study = Study(model, {"relief": {"cases": cases}}, seed=seed, confidence=confidence, timeout=timeout, name="why")
    study.plan = study.plan.unreplicated()
    base = abs(run.kpis[name]) or 1.0

    def steps(exact: bool) -> statistics.Procedure[Gains]:
        return statistics.gains_steps(
            len(looked_at),
            LEAST * base,
            confidence,
            maximise=better == "more",
            n0=first,
            cap=cap,
            deterministic=exact,
        )

    gains = study.follow(steps, name, **where)
    return Why(name, tuple((looked_at[gain.change - 1], gain) for gain in gains.gains), gains)
