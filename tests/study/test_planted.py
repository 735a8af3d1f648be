"""Planted bottlenecks of two dozen kinds are named first, and decisions and times of the model have reliefs."""

import json

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.why import worded
from desim_warehouse.study.held_up import HeldUp
from desim_warehouse.study.statistics.effects import Gain, Gains
from desim_warehouse.study.suspects import Suspect, suspects
from tests.docs import pages
from tests.study.planted import CASES, named
from tests.world.test_flows import RING
from tests.world.test_hours import SQUARE

BY_TITLE = {case.title: case for case in CASES}


def reliefs(over, name):
    """What relieves a suspect in the square, by its relief in words."""
    model = dw.load(SQUARE, {"tasks.goods": {"saturated": 4}, "run.length": 4000, "log": "all", **over})
    run = dw.simulate(model)
    by_relief = {one.relief: one for one in suspects(run) if one.name == name}
    for one in by_relief.values():
        dw.simulate(model.replace(one.overrides))
    return {relief: dict(one.overrides) for relief, one in by_relief.items()}


# Reliefs


def test_a_node_at_which_robots_are_long_is_relieved_of_that_though_nobody_waits():
    """One robot waits for nobody: it is 25 s at C, and 2 s at others."""
    over = {"traffic.node_time": 2, "traffic.nodes.C.time": 25}
    relief = "nobody waits at C or is longer there than elsewhere"
    assert reliefs(over, "intersection C") == {relief: {"traffic.nodes.C.free": True, "traffic.nodes.C.time": None}}
    assert reliefs({"traffic.node_time": 2, "traffic.nodes.C.time": 2}, "intersection C") == {}
    assert reliefs({"traffic.node_time": 25}, "intersection C") == {}  # as everywhere: the work itself


@pytest.mark.parametrize(
    ("over", "name", "relief", "overrides"),
    [
        (
            {"fleet.robot.capacity": 2, "policies.batching": "fixed-size"},
            "batching",
            "every task by itself",
            {"policies.batching": "single"},
        ),
        ({"policies.interval": 90}, "the interval of decisions", "decisions at once", {"policies.interval": 0}),
        (
            {"traffic.most_out": 1},
            "the cap on robots under way",
            "no cap on robots under way",
            {"traffic.most_out": None},
        ),
        (
            {"traffic.zones": {"lift": {"members": [["A", "B"]], "rule": "one-robot"}}},
            "zones with a rule",
            "no rule in any zone",
            {"traffic.zones": {}},
        ),
        ({"fleet.exit_time": 30}, "the way out of bays", "leaving bays at once", {"fleet.exit_time": 0}),
        ({"layout.edges.1.speed": 0.1}, "limits of speed", "no speed limits on lanes", {"layout.edges.1.speed": None}),
        (
            {"fleet.kinds": {"old": {"count": 1}}, "layout.bays.home.places": 2},
            "robots of kind old",
            "one robot of kind old more",
            {"fleet.size": 2, "fleet.kinds.old.count": 2},
        ),
        (
            {"fleet.size": 2, "fleet.kinds": {"old": {"count": 1}}, "layout.bays.home.places": 3},
            "robots of no kind",
            "one more robot of no kind",
            {"fleet.size": 3},
        ),
    ],
)
def test_limits_and_decisions_of_the_model_have_a_relief(over, name, relief, overrides):
    if "layout.edges.1.speed" in over:
        edges = [["A", "B"], {"from": "B", "to": "C", "speed": 0.1}, ["C", "E"], ["E", "A"]]
        over = {"layout.edges": edges}
    assert reliefs(over, name) == {relief: overrides}
    assert reliefs({}, name) == {}


def test_slots_where_tasks_end_are_relieved_though_those_where_they_begin_are_enough():
    """Two robots at a time have a slot at pack, and the others wait for one, not for the four slots at the dock."""
    flows = {"out": {"from": "dock", "to": "pack", "arrivals": {"saturated": 9}}}
    over = {"fleet.size": 4, "layout.stations.dock.places": 4, "tasks.flows": flows, "run.length": 1000, "log": "all"}
    [slots] = (one for one in suspects(dw.simulate(dw.load(RING, over))) if one.name == "places at the stations")
    assert (slots.overrides, slots.dose) == ({"layout.stations.pack.places": 3}, 0.5)


BATTERY = {"capacity": 100, "consumption": 0.2, "charge_rate": 0.4}


def test_other_charging_policies_are_tried_where_tasks_wait_for_robots_that_charge():
    own = {"name": "opportunity", "minimum": 0.9}
    others = {f"charging by {name}": name for name in ("reach-aware", "opportunity", "four-thresholds")}
    tried = reliefs({"battery": BATTERY, "policies.charging": own}, "the charging policy")
    assert tried == {relief: {"policies.charging": name} for relief, name in others.items()}
    # its own as it is by default is no other, and threshold has a default where the battery has a threshold
    over = {"battery": {**BATTERY, "threshold": 30}, "policies.charging": "four-thresholds"}
    assert reliefs(over, "the charging policy").keys() == {
        *(f"charging by {name}" for name in ("threshold", "reach-aware", "opportunity"))
    }
    lasting = {**BATTERY, "consumption": 0.001}
    assert reliefs({"battery": lasting, "policies.charging": "four-thresholds"}, "the charging policy") == {}


# In words


def found(*reliefs):
    """An answer by reliefs: name, relief, dose, and the bounds of its gain; those below the first one's are beaten."""
    least = reliefs[0][3] if reliefs else 0
    pairs = []
    for rank, (name, relief, dose, low, high) in enumerate(reliefs, start=1):
        suspect = Suspect(name, relief, {}, dose=dose)
        pairs.append((suspect, Gain(rank, (low + high) / 2, low, high, 20, suspect.scale, beaten=high < least)))
    gains = Gains(tuple(gain for _, gain in pairs), 600, 6, 0.95, 80)
    return worded(HeldUp(dw.load(SQUARE), "cycle_time_mean", tuple(pairs), gains))


def test_the_whole_gain_of_a_change_stands_beside_its_size_and_the_gain_per_10_percent():
    """The third robot saves 60 s; it is half of two robots, so 10 % more robots save a fifth of that."""
    robot = ("the number of robots", "one robot more", 0.5, 50, 70)
    assert found(robot, ("chargers", "one charger more", 0.1, 5, 8)).answer.answer[0] == (
        "The number of robots is the main bottleneck. "
        "One robot more (+50 %): mean cycle time falls by 60 s (50 to 70), or 12.0 s (10.0 to 14.0) per 10 %; "
        "no other ranked change gains more than 8.0 s per 10 %."
    )
    assert "One robot more (+10 %): mean cycle time falls by 60 s (50 to 70)." in str(found((*robot[:2], 0.1, 50, 70)))


def test_a_suspect_is_named_though_it_is_open_which_of_its_reliefs_is_best():
    policies = [("the charging policy", f"charging by {name}", None, 50 - n, 90 - n) for n, name in enumerate("ab")]
    clear = found(*policies, ("chargers", "one charger more", 0.1, 5, 20))
    assert clear.is_clear
    assert not clear.gains.clear
    assert clear.answer.answer[0] == (
        "The charging policy is the main bottleneck. Charging by a: mean cycle time falls by 70 s (50 to 90); "
        "no other ranked change gains more than 20 s per 10 %."
    )
    assert not found(*policies, ("chargers", "one charger more", 0.1, 5, 51)).is_clear
    assert not found(("the charging policy", "charging by a", None, -1, 90)).is_clear
    assert not found().is_clear


# Planted


@pytest.mark.long
def test_most_of_two_dozen_planted_bottlenecks_are_named():
    """Some ten minutes of one processor."""
    answers = [named(case) for case in CASES]
    assert len(answers) == 24
    assert sum(answer.right for answer in answers) >= 22, [str(answer) for answer in answers if not answer.right]


@pytest.mark.long
def test_the_advice_gains_on_other_days_what_was_said():
    for title in ("batches of six", "a crossing that takes 25 s"):
        answer = named(BY_TITLE[title], days=14)
        assert answer.bounds[0] <= answer.gain <= answer.bounds[1], str(answer)


def test_the_time_in_which_tasks_wait_for_a_batch_is_said_of_one_run(tmp_path, monkeypatch):
    model = BY_TITLE["batches of six"].model()
    part = dw.simulate(model, 77).account("task").sum()
    share = part["waiting_for_batch"] / part.sum()
    assert share > 0.4
    (tmp_path / "w.yaml").write_text(json.dumps(model.content()), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    output = pages.run_desim("desim why w.yaml --quiet --cap 10 --seed 77")[1]
    assert f"In the run looked at, tasks spent {100 * share:.3g} % of their time waiting for a batch." in output
    assert "Batching is the main bottleneck." in output
