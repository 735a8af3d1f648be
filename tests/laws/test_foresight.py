"""The law of foresight: what moves the time that a task takes a robot moves what is known of it ahead alike.

Three look ahead: policies in their views, `reach` before a battery is trusted with a task, and `forecast` while a robot
is at work. The keys are those of the law of the quick estimate, in which a new one must be listed. Floors are free.
"""

from itertools import pairwise
from statistics import fmean

import pytest
from simpy.events import Timeout

from desim_warehouse.policies import Handling
from desim_warehouse.policies.allocation import InOrder
from desim_warehouse.world import World
from desim_warehouse.world.places.handling import HandlingTimes
from desim_warehouse.world.robots.forecast import busy_view
from tests.daily import some
from tests.laws.test_quick_estimate import MOVED, PLACES, _places, flows, goods

AHEAD = ["views", "reach", "forecast"]
CLOSE = 0.01
EVEN = {
    "fleet.start_energy": 1,
    "battery": {"capacity": 1e9, "consumption": 1.0, "charge_rate": 1.0},
    "fleet.robot.acceleration": None,
    "fleet.robot.deceleration": None,
    "traffic.turn_time": 0,
    "run": {"length": 60_000, "warm_up": 0.0},
}
"""Robots that stop and turn in no time, and draw the time that they take from a battery that is never low."""
UNFORESEEN = {
    **dict.fromkeys(
        (
            "fleet.robot.breakdowns.every",
            "fleet.robot.delays.time",
            "people.*.stay",
            "policies.interval",
            "pickers.speed",
        ),
        "waits",
    ),
    **dict.fromkeys(("fleet.hours", "layout.stations.*.hours", "layout.bays.*.outages.every"), "waits for hours"),
    "layout.lifts.*.outages.every": "waits for repairs",
    "layout.lifts.*.people.transfer": "waits for people",
    **dict.fromkeys(("fleet.robot.acceleration", "fleet.robot.deceleration", "traffic.turn_time"), "stops, in full"),
    **dict.fromkeys(("policies.batching", "policies.batching of flows", "tasks.flows.*.arrivals"), "other tasks"),
    "policies.allocation": "other tasks",
    **{name: "of batteries" for name in MOVED if "battery" in name or name.startswith("policies.charging")},
}
"""What nobody knows ahead, or only roughly, and what moves no task."""
APART = {
    "tasks.clear_time": ["forecast"],  # it ends with the delivery
    "fleet.robot.speed_loaded": ["views"],  # which drive at one speed
    "traffic.slow.*.speed": ["views", "forecast"],  # without the slow edge of the good itself, or the node at its end
    "traffic.node_time": ["views", "forecast"],
    "traffic.nodes.*.time": ["views", "forecast"],
}
"""Who leaves out what."""


def looked_ahead(model, monkeypatch):
    """Mean times of a task: in the run, and as policies, reach and forecast know them when it is given out."""
    world = World(model.replace(EVEN), 1)
    reach, assign, known, begun = world.reach, InOrder.assign, {who: [] for who in AHEAD}, []

    def watched(policy, situation):
        for number, which in assign(policy, situation):
            (robot,) = situation.robots
            task = next(one for one in situation.tasks if one.number == which)
            station = situation.station(robot, task)
            begun.append(situation.time)
            known["views"].append(situation.approach([robot], [task])[0][0] + situation.delivery(robot, [task])[0])
            need = reach.need(robot, task, station, "nearest")
            known["reach"].append(need - reach.to_charger(station, robot, "nearest"))
            Timeout(world.env, 0.01).callbacks.append(foresee)
            yield number, which

    def foresee(_):
        known["forecast"].append(busy_view(world.robots[0], reach, world.env.now).free_in)

    with monkeypatch.context() as patch:
        patch.setattr(InOrder, "assign", watched)
        world.run()
    cleared = model.tasks.clear_time  # of this task, before the next one's
    run = cleared + fmean(b - a for a, b in pairwise(begun))
    return {"run": run, **{who: fmean(times) for who, times in known.items()}}


@pytest.mark.slow
@pytest.mark.parametrize("name", some(sorted({*MOVED, *PLACES} - UNFORESEEN.keys()), 4))
def test_what_moves_a_task_moves_what_is_known_ahead(name, monkeypatch):
    of, changes = MOVED[name] if name in MOVED else (goods, _places()[name])
    base = flows() if "tasks" in changes else of()
    after = looked_ahead(of().replace(changes), monkeypatch)
    assert left_out(looked_ahead(base, monkeypatch), after) == APART.get(name, [])


def left_out(before, after):
    """Who does not see what moved the run."""
    moved = after["run"] - before["run"]
    return [who for who in AHEAD if abs(after[who] - before[who] - moved) > CLOSE * before["run"]]


def test_a_time_that_only_runs_know_is_found_out(monkeypatch):
    before, time = looked_ahead(goods(), monkeypatch), HandlingTimes.time
    monkeypatch.setattr(HandlingTimes, "time", lambda self, stop: time(self, stop) + 20 * (stop.act == "unload"))
    assert left_out(before, looked_ahead(goods(), monkeypatch)) == AHEAD


def test_a_time_told_where_stops_are_told_is_known_to_all(monkeypatch):
    before, at_stop = looked_ahead(goods(), monkeypatch), Handling.at_stop
    monkeypatch.setattr(
        Handling, "at_stop", lambda self, act, *where: at_stop(self, act, *where) + 20 * (act == "unload")
    )
    after = looked_ahead(goods(), monkeypatch)
    assert after["run"] - before["run"] == pytest.approx(20, abs=0.5)
    assert left_out(before, after) == []
