"""The cost of a task, for `run.quick`: measured by simulating one robot of a kind alone, on the model's own floor.

All times and energies come from the simulated world, and are read here from its log. The effects of shared resources
(stations, chargers, lanes), and of causes that keep robots from work part of the time, are calculated from them.
"""

from __future__ import annotations

import gc
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import pairwise
from statistics import fmean, stdev
from typing import Any

from simpy.events import Timeout

from desim_warehouse.errors import PolicyError, SimulationError
from desim_warehouse.layout import Layout
from desim_warehouse.layout.riders import RidersSpec
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import by_kind, chargers_at, cycle_levels
from desim_warehouse.model.facts.demand import flow_rates, open_share
from desim_warehouse.model.facts.subfleets import flows_of
from desim_warehouse.model.sections.fleet import Consumption, Kind
from desim_warehouse.model.sections.goods import PoissonGoods, SaturatedGoods
from desim_warehouse.model.sections.policy import PolicySpec
from desim_warehouse.outcome.log import Log
from desim_warehouse.policies import catalogue
from desim_warehouse.run.backlog import Backlog
from desim_warehouse.states import STATES, Phase
from desim_warehouse.values.fields import FrozenMap
from desim_warehouse.world import World

LOOKS, MOST = (250, 500), 1000
"""The least and the most tasks of a probe: for flows always the most, as pairs of these differ."""
WELL_KNOWN = 0.02
"""Share of the mean time of a task: a probe continues while the standard error is larger."""
TENS = 10
"""The number of tasks that suffice to estimate a mean time."""
CALM = 100
"""The number of tasks of a robot that rests between them."""
SEED = 0
FOREVER = 1e9
"""A run length, in time units, that no probe reaches."""
CHARGING = tuple(state.name for state in STATES.values() if state.phase is Phase.CHARGING)
PATIENCE = 24
"""Hours without a delivery or a charge after which a probe is stopped."""


@dataclass(frozen=True)
class Probe:
    """Measures of a probe: the mean task of one robot that always has a next one.

    Attributes:
        time: time of a task, without charging.
        phases: that time, by the part of a robot's round.
        charging: time at chargers for each task.
        energy: energy drawn from the battery for each task.
        visits: by node, how often the robot was handled there for each task, and how long each time.
        put_down: by node, loads left there for each task.
        passages: by node, how often the robot passed it for each task.
        rides: by edge of a lift, rides for each task.
        tasks: number of tasks that were looked at.
    """

    time: float
    charging: float
    phases: Mapping[Phase, float]
    energy: float
    visits: Mapping[str, tuple[float, float]]
    put_down: Mapping[str, float]
    passages: Mapping[str, float]
    rides: Mapping[str, float]
    tasks: int


def shares_of_flows(model: Model) -> FrozenMap[str, float]:
    """Return the rates of the flows as shares of all tasks, which are equal for every demand."""
    return FrozenMap({name: rate / model.tasks.demand for name, rate in flow_rates(model).items()})


class _StuckError(Exception):
    """Raised if nothing is delivered for too long."""


def probe(model: Model, kind: str = "", waiting: int = 1) -> Probe:
    """Simulate some tasks of one robot of a kind, `waiting` of them always known to the policy that allocates them.

    It begins where its battery wants a charger. What counts is whole rounds from charger to charger, where the tasks
    have some, else all but the first and the last.

    Raises:
        SimulationError: the robot does no task by itself.
    """
    in_turn, battery = model.fleet.size > 1, by_kind(model)[kind].battery
    rates = shares_of_flows(model)
    if battery is not None and not chargers_at(model, model.floor):
        return _probe(_alone(model, kind, endless=True), kind, waiting, in_turn, rates, battery.draws)
    try:
        return _probe(_alone(model, kind), kind, waiting, in_turn, rates)
    except SimulationError:  # its battery may be too small for the work, which is an error of its own
        if battery is None:
            raise
        return _probe(_alone(model, kind, endless=True), kind, waiting, in_turn, rates, battery.draws)


@lru_cache(maxsize=64)
def _probe(
    model: Model,
    kind: str,
    waiting: int,
    in_turn: bool,
    rates: FrozenMap[str, float],
    draws: Consumption | None = None,
) -> Probe:
    """Probe a model with one robot; `draws`: the consumption of a robot whose battery is never empty."""
    log = _run(model, kind, waiting, in_turn, rates)
    begin, end, _ = _counted(log, waiting, log.end)
    return _measured(log, model.floor, begin, end, draws)


def _counted(log: Log, waiting: int, now: float) -> tuple[float, float, int]:
    """Return begin and end of the evaluation period so far, and its number of rounds from charger to charger.

    Tasks chosen from fewer than `waiting` do not count. If there is none between charges, all tasks but the first do.
    """
    done = sorted(row.time for row in log.of("delivered") if row.time <= now)
    if len(done) < 2 * waiting:
        raise SimulationError("a robot by itself does no task, or none after some")
    charged = sorted(row.time for row in log.of(*CHARGING) if row.time < done[-waiting])
    if charged and any(charged[0] < time <= charged[-1] for time in done):
        return charged[0], charged[-1], len(charged) - 1
    return *_without_the_first(log, done[-waiting]), 0


def _without_the_first(log: Log, end: float) -> tuple[float, float]:
    """Return begin and end of the tasks that were taken up to a time, leaving out the first task."""
    begun = sorted({row.time for row in log.of("assigned") if row.time <= end})
    if not begun[1:]:
        raise SimulationError("a robot by itself does no second task")
    return begun[len(begun) // 20], begun[-1]


def _well_known(log: Log, waiting: int, now: float) -> bool:
    """Whether the mean time of a task, without charging, is precise enough: by its standard error, of whole rounds."""
    begin, end, rounds = _counted(log, waiting, now)
    clock, before, done, charging = 0.0, begin, [], False
    for row in sorted(log.of("delivered", *STATES)):
        if begin < row.time <= end:
            clock += 0.0 if charging else row.time - before
            before = row.time
            done += [clock] if row.kind == "delivered" else []
        if row.kind in STATES:
            charging = row.kind in CHARGING
    tens = [b - a for a, b in pairwise(done[::TENS])]
    apart = stdev(tens) / fmean(tens) / math.sqrt(len(tens)) if tens[1:] else 0.0
    return apart < WELL_KNOWN and (rounds > 0 or not any(True for _ in log.of(*CHARGING)))


def calm(model: Model, kind: str, waiting: int, pause: float) -> tuple[float, float]:
    """Measure time and energy of a task that no other follows at once: the robot returns and rests in between.

    Its battery is never empty. `pause`: the time between taking a task and the release of the next, longer than a task.
    """
    battery = by_kind(model)[kind].battery
    assert battery is not None
    return _calm(
        _alone(model, kind, endless=True),
        kind,
        waiting,
        model.fleet.size > 1,
        shares_of_flows(model),
        battery.draws,
        pause,
    )


@lru_cache(maxsize=64)
def _calm(
    model: Model,
    kind: str,
    waiting: int,
    in_turn: bool,
    rates: FrozenMap[str, float],
    draws: Consumption,
    pause: float,
) -> tuple[float, float]:
    log = _run(model, kind, waiting, in_turn, rates, pause)
    sample = _measured(log, model.floor, *_without_the_first(log, math.inf), draws, at_rest=False)
    return sample.time, sample.energy


@contextmanager
def _swept() -> Iterator[None]:
    """Free the memory of a world as soon as it is over: its objects refer to each other, and a large floor has many."""
    gc.freeze()  # all that was there before, which would take longer to look at
    try:
        yield
    finally:
        gc.collect()
        gc.unfreeze()


def _run(model: Model, kind: str, waiting: int, in_turn: bool, rates: FrozenMap[str, float], pause: float = 0.0) -> Log:
    """Simulate a robot with some tasks, and return the log, also of a run that could not go on to its end."""

    def enough(handed_out: int, log: Log, now: float) -> bool:
        is_time = handed_out in LOOKS and handed_out >= 4 * waiting and not model.tasks.flows
        return is_time and _well_known(log, waiting, now)

    demand = partial(
        Backlog,
        flows=tuple(flows_of(model, kind)),
        count=CALM if pause else MOST,
        waiting=waiting,
        in_turn=in_turn,
        rates=rates,
        pause=pause,
    )
    return log_of(model, demand, enough, pause)


@_swept()
def log_of(
    model: Model,
    demand: Callable[..., Backlog],
    enough: Callable[[int, Log, float], bool] | None = None,
    pause: float = 0.0,
) -> Log:
    """Simulate the model with the tasks of a probe, and return the log, also of a run that could not go on to its end.

    `enough`: asked before each task, with how many were given out, the log and the time; no more follow where it says
    so. `pause`: between two tasks, in which nothing is delivered.
    """

    def is_over(handed_out: int) -> bool:
        return enough is not None and enough(handed_out, world.log, world.env.now)

    world = World(model, SEED, demand=partial(demand, enough=is_over))
    patience, done = PATIENCE * model.units.hour + pause, 0
    if model.battery is not None and model.battery.charge_rate:
        patience += model.battery.capacity / model.battery.charge_rate

    def look(_: object) -> None:
        nonlocal done
        if world.dispatcher.done == done:
            raise _StuckError
        done = world.dispatcher.done
        Timeout(world.env, patience).callbacks.append(look)

    Timeout(world.env, patience).callbacks.append(look)
    try:
        world.run()
    except (_StuckError, SimulationError, PolicyError):
        world.close()
    return world.log


def always_there(model: Model) -> Model:
    """Return the model with robots and stations always on duty, never broken, no batteries; its work comes apart.

    People ride in lifts at all hours, as many as on average.
    """
    kinds = {name: kind.model_copy(update={"battery": None}) for name, kind in model.fleet.kinds.items()}
    made = _undisturbed(model, kinds, {"start_energy": 1.0}).model_copy(update={"battery": None})
    lifts = {
        name: lift.model_copy(update={"people": _at_all_hours(model, was.people)})
        for (name, lift), was in zip(made.layout.lifts.items(), model.layout.lifts.values(), strict=True)
    }
    return made.model_copy(update={"layout": made.layout.model_copy(update={"lifts": FrozenMap(lifts)})})


def _at_all_hours(model: Model, people: RidersSpec | None) -> RidersSpec | None:
    """Return people who ride at all hours, as many as on average; None where nobody does."""
    share = 0.0 if people is None else open_share(model, people.hours)
    if people is None or not share:
        return None
    return people.model_copy(update={"per_hour": people.per_hour * share, "hours": None})


def _alone(model: Model, kind: str, *, endless: bool = False) -> Model:
    """Return the model with one robot of a kind, always on duty, never broken; `endless`: its battery never empties."""
    own = by_kind(model)[kind]
    fleet, traffic = own.fleet, own.traffic.model_copy(update={"most_out": None})
    number = fleet.kinds_of_robots().index(kind)
    kinds = {kind: fleet.kinds[kind].model_copy(update={"count": 1})} if kind else {}
    margin = fleet.contact - 2 * fleet.robots()[number].radius
    changed = {
        "size": 1,
        "robot": fleet.robot.model_copy(update={"margin": margin}),
        "start": tuple(fleet.homes(own.floor.bays)[number : number + 1]),
        "start_energy": 1.0 if own.battery is None else cycle_levels(own)[0] / own.battery.capacity,
    }
    alone = _undisturbed(own.model_copy(update={"traffic": traffic}), kinds, changed)
    return alone.model_copy(update={"battery": None}) if endless else alone


def _undisturbed(model: Model, kinds: Mapping[str, Kind], changed: Mapping[str, Any]) -> Model:
    """Return the model of a probe, with `kinds` and changes of its fleet; nothing breaks, closes or is off duty.

    Nobody else rides in lifts.
    """
    fleet, always = model.fleet.model_copy(update=changed), {"breakdowns": None, "hours": None}
    new: dict[str, Any] = {
        "robot": fleet.robot.model_copy(update={"breakdowns": None}),
        "kinds": FrozenMap({name: kind.model_copy(update=always) for name, kind in kinds.items()}),
        "start_on_lanes": (),
        "hours": None,
    }
    stations = {name: item.model_copy(update={"hours": None}) for name, item in model.layout.stations.items()}
    own = {"people": None, "outages": None}
    lifts = {name: lift.model_copy(update=own) for name, lift in model.layout.lifts.items()}
    parts: dict[str, Any] = {
        "fleet": fleet.model_copy(update=new),
        "layout": model.layout.model_copy(update={"stations": FrozenMap(stations), "lifts": FrozenMap(lifts)}),
        "traffic": model.traffic.model_copy(update={"closures": FrozenMap({})}),
        "pickers": None if model.pickers is None else model.pickers.model_copy(update={"hours": None}),
        **_of_a_probe(model),
    }
    return model.model_copy(update=parts)


def _of_a_probe(model: Model) -> dict[str, Any]:
    """Return the overrides that are alike in all probes, and for every rate."""
    tasks: dict[str, Any] = {"demand": 1.0}
    if isinstance(model.tasks.goods, PoissonGoods | SaturatedGoods):
        tasks["goods"] = SaturatedGoods(saturated=1)
    return {
        "policies": model.policies.model_copy(update=_built_in(model)),
        "run": model.run.model_copy(update={"length": FOREVER, "warm_up": 0.0}),
        "log": "tasks",
        "prices": None,
        "accept": (),
        "tasks": model.tasks.model_copy(update=tasks),
    }


def _built_in(model: Model) -> dict[str, PolicySpec]:
    """Replace each of the user's own policies by the first built-in one of its kind: a check runs no foreign code."""
    own = [kind for kind, spec in model.policies.specs().items() if spec.own]
    return {kind: PolicySpec(name=next(iter(catalogue.OURS[kind]))) for kind in own}


def _measured(
    log: Log, layout: Layout, begin: float, end: float, draws: Consumption | None, *, at_rest: bool = True
) -> Probe:
    """Measure the mean task between two times from a log; `at_rest`: time at rest counts."""
    done = [row for row in log.of("delivered") if begin < row.time <= end]
    tasks = len(done)
    phases: dict[Phase, float] = {}
    drawn = 0.0 if draws is not None else _drawn(log, begin, end)
    handled: dict[str, list[float]] = {}
    put_down: dict[str, float] = {}
    stored = {row.task for row in log.of("released") if row.value is not None and row.value >= 0}
    shelved = {row.task for row in log.of("delivered") if row.edge is not None}
    for row, then in pairwise(log.of(*STATES)):
        state = STATES[row.kind]
        if row.time >= end or then.time <= begin or (state.phase is Phase.REST and not at_rest):
            continue
        spent = min(then.time, end) - max(row.time, begin)
        assert state.phase is not None
        phases[state.phase] = phases.get(state.phase, 0.0) + spent / tasks
        drawn += spent * getattr(draws, state.draws or "", 0.0)
        away = stored if state.phase is Phase.LOADING else shelved
        if state.occupies == "station" and row.node is not None and row.task not in away:
            handled.setdefault(row.node, []).append(spent)
    for row in done:
        if row.node is not None and row.edge is None:
            put_down[row.node] = put_down.get(row.node, 0.0) + 1 / tasks
    every = sum(1 for _ in log.of("delivered"))
    charging = phases.pop(Phase.CHARGING, 0.0)
    return Probe(
        time=math.fsum(phases.values()),
        charging=charging,
        phases=FrozenMap(phases),
        energy=drawn / tasks,
        visits=FrozenMap({node: (len(t) / tasks, math.fsum(t) / len(t)) for node, t in handled.items()}),
        put_down=FrozenMap(put_down),
        passages=FrozenMap({row["node"]: row["passages"] / every for row in log.nodes}),
        rides=ridden(log, layout),
        tasks=tasks,
    )


def ridden(log: Log, layout: Layout) -> FrozenMap[str, float]:
    """Return by edge of a lift the rides for each task that was delivered."""
    rides, tasks = {">".join(ride) for ride in layout.rides}, sum(1 for _ in log.of("delivered"))
    return FrozenMap({row["edge"]: row["passages"] / tasks for row in log.edges if row["edge"] in rides})


def _drawn(log: Log, begin: float, end: float) -> float:
    """Return the energy drawn from the battery between two times: by how much the level falls from row to row."""
    levels = [row.value for row in log.of("delivered", *STATES) if begin <= row.time <= end and row.value is not None]
    return math.fsum(max(a - b, 0.0) for a, b in pairwise(levels) if math.isfinite(a))
