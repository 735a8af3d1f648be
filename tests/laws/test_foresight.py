"""The law of foresight: a key that changes the time of a task changes every prediction of it by an equal amount.

There are three predictions: the views of policies, `reach` before a battery is trusted with a task, and `forecast`
while a robot is at work. The keys are those of the law of the quick estimate, which must list every key. Floors are
empty otherwise.
"""

import re
from itertools import pairwise
from pathlib import Path
from statistics import fmean

import pytest
from simpy.events import Timeout

from desim_warehouse.policies import Handling
from desim_warehouse.policies.allocation import InOrder
from desim_warehouse.world import World
from desim_warehouse.world.places.handling import HandlingTimes
from desim_warehouse.world.robots.forecast import busy_view
from tests.daily import some
from tests.laws import test_quick_estimate as quick_estimate
from tests.laws.test_quick_estimate import MOVED, PLACES, TO_FOLLOW, TO_LIST, _places, flows, goods

AHEAD = {
    "views": "what policies see, policies/situation.py with model/facts/ahead.py",
    "reach": "world/robots/reach.py",
    "forecast": "world/robots/forecast.py",
}
"""The predictions of the time of a task, and where each is made."""
CLOSE = 0.01
EVEN = {
    "fleet.start_energy": 1,
    "battery": {"capacity": 1e9, "consumption": 1.0, "charge_rate": 1.0},
    "fleet.robot.acceleration": None,
    "fleet.robot.deceleration": None,
    "traffic.turn_time": 0,
    "run": {"length": 20_000, "warm_up": 0.0},
}
"""Robots that stop and turn in no time, and draw energy equal to their time from a battery that is never low."""
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
"""Keys whose effect is not predicted, or only roughly, or that change no task; with the reason."""
NARROW = {"tasks.load_time, varied": {"tasks.load_time": {"lognormal": {"mean": 30, "cv": 0.1}}}}
"""Changes in place of those that vary so much that 200 tasks do not tell the mean."""
APART = {
    "tasks.clear_time": ["forecast"],  # it ends with the delivery
    "fleet.robot.speed_loaded": ["views"],  # they assume one speed
    "traffic.slow.*.speed": ["views", "forecast"],  # without the slow edge of the good itself, or the node at its end
    "traffic.node_time": ["views", "forecast"],
    "traffic.nodes.*.time": ["views", "forecast"],
}
"""Predictions that leave out a key, by key."""
TO_FORESEE = """predictions that do not change with {key} as the time of a task does: {apart}; in APART: {listed}.
Let them do so ({where});
or list what they leave out in tests/laws/test_foresight.py: in APART, or in UNFORESEEN if it is the same for all."""


def looked_ahead(model, monkeypatch):
    """Return the mean time of a task in the run, and as policies, reach and forecast predict it on assignment."""
    world = World(model.replace(EVEN), 1)
    reach, assign, predicted, begun = world.reach, InOrder.assign, {who: [] for who in AHEAD}, []

    def watched(policy, situation):
        for number, which in assign(policy, situation):
            (robot,) = situation.robots
            task = next(one for one in situation.tasks if one.number == which)
            station = situation.station(robot, task)
            begun.append(situation.time)
            predicted["views"].append(situation.approach([robot], [task])[0][0] + situation.delivery(robot, [task])[0])
            need = reach.need(robot, task, station, "nearest")
            predicted["reach"].append(need - reach.to_charger(station, robot, "nearest"))
            Timeout(world.env, 0.01).callbacks.append(foresee)
            yield number, which

    def foresee(_):
        predicted["forecast"].append(busy_view(world.robots[0], reach, world.env.now).free_in)

    with monkeypatch.context() as patch:
        patch.setattr(InOrder, "assign", watched)
        world.run()
    cleared = model.tasks.clear_time  # of this task, after the next task is assigned
    run = cleared + fmean(b - a for a, b in pairwise(begun))
    return {"run": run, **{who: fmean(times) for who, times in predicted.items()}}


@pytest.mark.slow
@pytest.mark.parametrize("name", some(sorted({*MOVED, *PLACES} - UNFORESEEN.keys()), 4))
def test_a_key_that_changes_a_task_changes_its_predictions(name, monkeypatch):
    plain, changes = MOVED[name] if name in MOVED else (goods, _places()[name])
    base = flows() if "tasks" in changes else plain()
    after = looked_ahead(plain().replace(NARROW.get(name, changes)), monkeypatch)
    apart, listed = left_out(looked_ahead(base, monkeypatch), after), APART.get(name, [])
    assert apart == listed, to_foresee(name, apart, listed)


def to_foresee(key, apart, listed):
    """Return what to do about a key that predictions leave out."""
    where = "; ".join(AHEAD[who] for who in apart)
    return TO_FORESEE.format(key=key, apart=apart, listed=listed, where=where)


def left_out(before, after):
    """Return the predictions that do not follow the change of the run."""
    moved = after["run"] - before["run"]
    return [who for who in AHEAD if abs(after[who] - before[who] - moved) > CLOSE * before["run"]]


def test_a_time_that_only_runs_include_is_detected(monkeypatch):
    before, time = looked_ahead(goods(), monkeypatch), HandlingTimes.time
    monkeypatch.setattr(HandlingTimes, "time", lambda self, stop: time(self, stop) + 20 * (stop.act == "unload"))
    assert left_out(before, looked_ahead(goods(), monkeypatch)) == list(AHEAD)


def test_a_time_added_to_stops_is_in_all_predictions(monkeypatch):
    before, at_stop = looked_ahead(goods(), monkeypatch), Handling.at_stop
    monkeypatch.setattr(
        Handling, "at_stop", lambda self, act, *where: at_stop(self, act, *where) + 20 * (act == "unload")
    )
    after = looked_ahead(goods(), monkeypatch)
    assert after["run"] - before["run"] == pytest.approx(20, abs=0.5)
    assert left_out(before, after) == []


def test_a_law_that_fails_says_in_which_file_to_follow_or_list_a_key():
    """The files that it names are there."""
    text = to_foresee("tasks.pause", ["views", "reach", "forecast"], []) + TO_FOLLOW + TO_LIST
    files = set(re.findall(r"\w+(?:/\w+)+\.py", text))
    assert {"model/facts/ahead.py", "world/robots/reach.py", "run/quick.py"} < files
    assert [file for file in files if not (Path("desim_warehouse", file).exists() or Path(file).exists())] == []
    assert [
        name for name in re.findall(r"\b[A-Z_]{2,}\b", text) if name not in {*globals(), *vars(quick_estimate)}
    ] == []
