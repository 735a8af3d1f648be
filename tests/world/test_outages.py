"""Outages of chargers: by the calendar, each charger at times of its own; a robot at one that fails waits for the next.

A battery of 1000 that starts at 400 and gets 10 a second takes 60 to charge.
"""

import pytest
from simpy import Environment

import desim_warehouse as dw
from desim_warehouse import ModelError
from desim_warehouse.values.disturbances import OutageSpec
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.places.chargers import FailingChargers

near = pytest.approx


def bay(outages=None, size=1, chargers=1, **changes):
    model = {
        "layout": {
            "nodes": {"A": [0, 0], "B": [30, 0], "C": [30, 30], "D": [0, 30]},
            "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 10}],
            "bays": {"home": {"at": ["A"], "places": size, "chargers": chargers}},
        },
        "fleet": {"size": size, "robot": {"radius": 0.5, "speed": 1}, "start_energy": 0.4},
        "tasks": {"goods": [{"good": 0, "release": 190}], "unload_at": ["C"], "load_time": 3, "unload_time": 5},
        "battery": {"capacity": 1000, "threshold": 100, "consumption": 1, "charge_rate": 10},
        "run": {"length": 200},
    }
    if outages:
        model["layout"]["bays"]["home"]["outages"] = outages
    return dw.load(model, changes)


def states(run, robot=0):
    return [(near(span.start), span.state) for span in run.history.states[robot]]


def test_a_robot_waits_at_a_charger_that_fails_and_goes_on_when_it_is_repaired():
    """In order from 0 to 20, 25 to 45, 50 to 70, from 75 on. It draws 1 while it waits: 600 + 15 are full at 76.5."""
    run = dw.simulate(bay({"every": 20, "repair": 5}))
    assert states(run)[:8] == [
        (0, "charging"),
        (20, "queueing"),
        (25, "charging"),
        (45, "queueing"),
        (50, "charging"),
        (70, "queueing"),
        (75, "charging"),
        (76.5, "idle"),
    ]
    assert near(15) == run.kpis["charger_wait"]
    assert run.deterministic


def test_who_was_interrupted_is_first_in_the_queue():
    """The second begins when the first is full, at 76.5, up to 95, and waits for three more repairs of 5."""
    run = dw.simulate(bay({"every": 20, "repair": 5}, size=2))
    assert states(run, 1)[:3] == [(0, "queueing"), (76.5, "charging"), (95, "queueing")]
    assert near(15 + 76.5 + 15) == run.kpis["charger_wait"]


def test_a_charger_that_nobody_uses_fails_as_well():
    """The robot is in its bay again at 128 + 61 and draws 1 a time unit: the charger is in repair from 140 to 200."""
    later = {"fleet.start_energy": 1, "tasks.goods": [0], "tasks.load_time": 64, "run.length": None}
    run = dw.simulate(bay({"every": 140, "repair": 60}, **later))
    assert near(189) == run.T
    goods = [0, {"good": 0, "release": 229}]
    held = dw.simulate(bay({"every": 140, "repair": 60}, **{**later, "tasks.goods": goods, "run.length": 230}))
    assert states(held)[-4:-1] == [(189, "queueing"), (200, "charging"), (220, "idle")]


def test_outages_of_idle_chargers_keep_no_run_going():
    """All is done at 128, and nobody is to be charged: the run ends."""
    run = dw.simulate(bay({"every": 20, "repair": 5}, **{"tasks.goods": [0], "run.length": None}))
    assert run.kpis["tasks"] == 1


def test_a_free_robot_at_a_charger_that_fails_still_takes_tasks():
    """By opportunity it is free from 400 on; the charger fails at 20 for good, the task comes at 190."""
    free = {"policies.charging": {"name": "opportunity", "minimum": 0.2}}
    run = dw.simulate(bay({"every": 20, "repair": 1000}, **free))
    assert states(run) == [(0, "charging"), (20, "idle"), (190, "empty")]
    assert run.kpis["charger_wait"] == 0


def test_a_swap_goes_on_after_an_outage():
    """50 for a swap: 20 up to the outage, 20 from 25 to 45, 10 from 50 on."""
    swap = {"name": "swap", "time": 50, "level": 0.5}
    run = dw.simulate(bay({"every": 20, "repair": 5}, **{"policies.charging": swap}))
    assert states(run)[4:6] == [(50, "charging"), (60, "idle")]
    assert run.history.chargings[-1].after == 1000


class Scripted(FailingChargers):
    """Two chargers with outages by hand."""

    def __init__(self, env, *outages):
        super().__init__(env, "A", len(outages), OutageSpec(every=1e9, repair=1), Streams(0))
        for charger, (begin, end) in zip(self._chargers, outages, strict=True):
            charger.fails_at, charger.repaired_at = begin, end


def test_another_charger_of_the_bay_is_as_good():
    """The first fails from 10 to 100: its robot goes on at the second, and the one that came after it waits."""
    env, seen = Environment(), []
    chargers = Scripted(env, (10, 100), (500, 501))

    def robot(name, begins, needs):
        yield env.timeout(begins)
        first = False
        while needs > 0:
            with chargers.turn(first=first) as turn:
                yield turn
                begun = env.now
                seen.append((begun, name))
                done = env.timeout(needs)
                yield done | chargers.outage_of(turn)
                needs, first = needs - (env.now - begun), True

    for each in (("first", 0, 50), ("second", 1, 30), ("third", 2, 10)):
        env.process(robot(*each))
    env.run()
    assert seen == [(0, "first"), (1, "second"), (31, "first"), (71, "third")]


def test_outages_want_a_charger_and_time():
    with pytest.raises(ModelError, match=r"layout.bays.home.outages: outages of no charger"):
        bay({"every": 20, "repair": 5}, chargers=0)
    with pytest.raises(ModelError, match=r"outages.every.*no time at all \(got 0\), expected a mean above 0"):
        bay({"every": 0, "repair": 5})
