"""When deliveries stand still though tasks are open: the run says so, from when to when, and what for."""

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome.chains import lost_to
from desim_warehouse.outcome.halts import halts
from desim_warehouse.outcome.loads import loads
from desim_warehouse.questions.run import words
from desim_warehouse.run.examined import examined
from tests.daily import some
from tests.run.halls import RING
from tests.world.test_pods import RING as PODS

pytestmark = pytest.mark.usefixtures("brief_probes")

POISSON = {"tasks.goods": {"poisson": 60}, "tasks.unload_time": 10, "run.length": "4 h"}
LOW_TOGETHER = {
    **POISSON,
    "tasks.goods": {"saturated": 10},
    "layout.bays": {"parking": {"at": ["D"], "places": 6, "chargers": 0}, "plug": {"at": ["B"], "places": 2}},
    "fleet.start": ["parking"],
    "battery": {"capacity": 3600, "consumption": 0.5, "charge_rate": 2},
    "policies.charging": {"name": "four-thresholds", "critical": 0.3, "good": 0.3, "sufficient": 0.6, "margin": 0.05},
}
"""Batteries of two hours are at 30 % after 84 minutes, all six; two chargers take 9 minutes for two to work again."""
OWN_CHARGERS = {**LOW_TOGETHER, "layout.bays": {"plug": {"at": ["D"], "places": 6}}, "fleet.start": ["plug"]}
STANDS = {
    "batteries": LOW_TOGETHER,
    "batteries, chargers for all": OWN_CHARGERS,
    "batteries, charged for longer": {
        **LOW_TOGETHER,
        "policies.charging": {
            "name": "four-thresholds",
            "critical": 0.3,
            "good": 0.3,
            "sufficient": 0.7,
            "margin": 0.05,
        },
    },
    "closed": {
        **POISSON,
        "calendars": {"breaks": {"between": [[0, 3600], [6000, 14400]]}},
        "layout.stations.packing.hours": "breaks",
    },
    "closed, by the clock": {
        **POISSON,
        "run.start": "06:00",
        "calendars": {"doors": {"open": ["06:00-12:00"], "breaks": ["07:00-07:45"]}},
        "layout.stations.packing.hours": "doors",
    },
    "off duty, by the clock": {
        **POISSON,
        "run.start": "06:00",
        "calendars": {"shift": {"open": ["06:00-12:00"], "breaks": ["08:00-08:30"]}},
        "fleet.hours": "shift",
    },
    "off duty": {
        **POISSON,
        "calendars": {"shift": {"between": [[0, 3600], [6000, 14400]]}},
        "fleet.hours": "shift",
    },
    "lanes": {
        **POISSON,
        "calendars": {"cleaning": {"between": [[3600, 6000]]}},
        "traffic.closures": {"aisle": {"members": [["B", "C"]], "hours": "cleaning"}},
    },
    "lanes, robots on the way": {
        **POISSON,
        "calendars": {"cleaning": {"between": [[3600, 6000]]}},
        "traffic.closures": {"aisle": {"members": [["B", "C"]], "hours": "cleaning", "tasks": "go"}},
    },
    "people, robots on the way": {
        **POISSON,
        "people": {"cleaners": {"aisles": [["B", "C"]], "times": [3600], "stay": 2400}},
    },
    "pickers": {
        **POISSON,
        "fleet.size": 1,
        "tasks.goods": {"poisson": 20},
        "calendars": {"shift": {"between": [[0, 3600], [6000, 14400]]}},
        "pickers": {"count": 3, "speed": 1, "hours": "shift"},
    },
    "pickers, by the clock, who stay": {
        **POISSON,
        "run.start": "06:00",
        "calendars": {"shift": {"open": ["06:00-12:00"], "breaks": ["08:00-08:30"]}},
        "pickers": {"count": 3, "speed": 1, "stay": "order", "hours": "shift"},
    },
    "broken": {
        **POISSON,
        "fleet.size": 1,
        "fleet.robot.breakdowns": {"every": 2000, "repair": 2400},
        "tasks.goods": {"poisson": 20},
    },
    "broken, the others without a task": {
        **POISSON,
        "fleet.size": 3,
        "fleet.robot.breakdowns": {"every": {"exponential": 6000}, "repair": 2400, "clear": 120},
        "tasks.goods": {"poisson": 10},
        "run.length": "12 h",
    },
}
WORKS = {
    "few tasks": {**POISSON, "tasks.goods": {"poisson": 8}},
    "one robot": {**POISSON, "tasks.goods": {"poisson": 40}, "fleet.size": 1},
    "overload": {**POISSON, "tasks.goods": {"poisson": 500}},
    "times that vary": {**POISSON, "tasks.unload_time": {"lognormal": {"mean": 30, "cv": 1.5}}},
    "chargers for all, and levels apart": {**OWN_CHARGERS, "fleet.start_energy": "settled"},
    "two robots": {**POISSON, "fleet.size": 2},
    "energy that lasts the run": {
        **LOW_TOGETHER,
        "battery": {"capacity": 36_000, "consumption": 0.5, "charge_rate": 2},
    },
    "a lane that is closed for half a minute": {
        **POISSON,
        "calendars": {"cleaning": {"between": [[3600, 3630]]}},
        "traffic.closures": {"aisle": {"members": [["B", "C"]], "hours": "cleaning"}},
    },
    "a station that is closed before anything comes": {
        **POISSON,
        "calendars": {"doors": {"between": [[3600, 14400]]}},
        "layout.stations.packing.hours": "doors",
        "tasks.goods": {"poisson": 60, "hours": "doors"},
    },
    "a break in which nothing comes": {
        **POISSON,
        "calendars": {"shift": {"between": [[0, 3600], [6000, 14400]]}},
        "fleet.hours": "shift",
        "tasks.goods": {"poisson": 60, "hours": "shift"},
    },
}


@pytest.mark.parametrize(
    ("level", "name"),
    [("all", name) for name in STANDS]
    + [pytest.param("tasks", case.values[0], marks=case.marks) for case in some(STANDS, 3)],
)
def test_a_fleet_that_stands_still_is_seen_with_its_cause(name, level):
    model = dw.load(RING, {**STANDS[name], "log": level})
    if name.endswith("robots on the way") and level == "tasks":
        pytest.skip("waits in traffic are known with log: all")
    run = dw.simulate(model, 1)
    longest = max(halts(run.history), key=lambda halt: halt.end - halt.start)
    assert longest.cause == name.partition(",")[0]
    assert longest.end - longest.start > 500
    assert longest.open > 0
    assert sum(line.startswith("Deliveries stood still from ") for line in words.sentences(run)) >= 1


def test_people_in_a_lift_hold_up_a_robot_and_no_lane_is_blamed():
    """From 5,000 to 7,000 s 200 people an hour ride, each for longer than it takes until the next one comes."""
    model = {
        "layout": {
            "nodes": {"h": [0, 0], "a": [10, 0], "l0": [20, 0], "l1": [20, 30], "b": [10, 30]},
            "edges": [{"from": one, "to": other, "two_way": True} for one, other in ("ha", ("a", "l0"), ("l1", "b"))],
            "lifts": {
                "main": {
                    "nodes": ["l0", "l1"],
                    "ride": 12,
                    "doors": 4,
                    "people": {"per_hour": 200, "transfer": 3, "hours": "rush"},
                }
            },
            "bays": {"home": {"at": ["h"], "places": 1, "chargers": 0}},
            "stations": {"src": {"at": ["a"], "places": 1}, "dst": {"at": ["b"], "places": 1}},
        },
        "calendars": {"rush": {"between": [[5000, 7000]]}},
        "fleet": {"size": 1, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1}},
        "tasks": {
            "load_time": 5,
            "unload_time": 5,
            "flows": {"f": {"from": "src", "to": "dst", "arrivals": {"saturated": 1}}},
        },
        "run": {"length": 9000},
        "log": "all",
    }
    run = dw.simulate(dw.load(model))
    assert {halt.cause for halt in halts(run.history)} == {"lifts"}
    assert "robots waited for lifts, or for people in them" in str(run)


def test_robots_without_a_task_stand_still_for_the_one_that_broke_down_with_it():
    """It stands from 31,812 to 34,147 s, while the two others wait at first twice as long as it does."""
    name = "broken, the others without a task"
    standstills = halts(dw.simulate(dw.load(RING, {**STANDS[name], "log": "tasks"}), 1).history)
    assert len(standstills) > 3
    assert {halt.cause for halt in standstills} == {"broken"}


def test_pods_that_are_empty_are_the_cause_and_no_robot_is_scarce():
    """A pod holds 40 units, and every minute and a half one is picked: after an hour the picks that come must wait."""
    model = dw.load(PODS, {"tasks.flows.picks.arrivals": {"poisson": 40}, "pods.stock": 40, "run.length": "3 h"})
    run = dw.simulate(model, 1)
    assert run.kpis["tasks"] == 40
    (halt,) = halts(run.history)
    assert (halt.cause, halt.end) == ("no stock", 10_800)
    assert "no pod held any more of what they asked for." in str(run)
    assert "Nothing was scarce" in str(run)
    assert all(load.mean < 0.5 and not load.piles_up for load in loads(run.history, run.kpis))
    assert halts(dw.simulate(model.replace({"pods.stock": None}), 1).history) == []


@pytest.mark.parametrize("name", WORKS)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.long)])
def test_there_is_no_false_alarm(name, seed):
    run = dw.simulate(dw.load(RING, WORKS[name]), seed)
    assert not [halt for halt in halts(run.history) if halt.end - halt.start > 0]


def test_robots_too_low_to_work_are_not_idle():
    """What two of six get in 9 minutes the others wait for in a state of its own, which is lost time."""
    run = dw.simulate(dw.load(RING, LOW_TOGETHER), 1)
    low, idle = run.kpis["share_too_low"], run.kpis["share_idle"]
    assert low > 0.03
    assert idle < 0.02
    assert run.account()["too_low"].sum() == pytest.approx(low * 6 * 14_400)
    root, (time, robots) = next(iter(lost_to(run.history).items()))
    assert (root.cause, root.at) == ("too_low", "")
    assert robots >= 4
    assert time == pytest.approx(low * 6 * 14_400)
    assert any("for a free charger, too low to work" in line for line in words.waited(run))


def test_robots_that_rest_at_chargers_of_their_own_have_no_such_state():
    assert "share_too_low" not in dw.simulate(dw.load(RING, OWN_CHARGERS), 1).kpis


@pytest.mark.parametrize("name", some([*STANDS, *WORKS], 2))
def test_a_fleet_that_will_charge_all_at_once_is_foreseen(name):
    """At half of an hour's draw each, 30 % of the capacity are reached after 5,040 s; nobody else is warned."""
    findings, _ = examined(dw.load(RING, {**STANDS, **WORKS}[name]))
    texts = [item.text for item in findings if item.code == "CHARGE_AT_ONCE"]
    assert bool(texts) == name.startswith("batteries")
    assert all("after about 5,040 s" in text for text in texts)


@pytest.mark.usefixtures("whole_probes")
def test_the_day_of_the_example_is_foreseen_by_the_clock():
    """1,630 Wh less a fifth last robots that are always at work until 18:46, and the run stands still from 18:49 on."""
    (text,) = (item.text for item in examined(dw.load("models/my_own_day.yaml"))[0] if item.code == "CHARGE_AT_ONCE")
    assert text.startswith("at about 18:46, ")
    assert "with 6 chargers for 20 robots, so that 14 wait" in text


GONE = {
    "at once": ([[0, 600]], "Pickers went home for good after 10 min: at the end 2 robots still waited for one."),
    "back after the end": (
        [[0, 600], [8000, 9000]],
        "Pickers went home after 10 min: at the end 2 robots still waited",
    ),
    "there at the end": ([[0, 600], [4000, 9000]], ""),
}


@pytest.mark.parametrize("name", GONE)
def test_run_says_when_pickers_went_home_where_too_little_is_done_for_a_standstill(name):
    """Of three robots one waits behind another."""
    stretches, text = GONE[name]
    pickers = {"count": 1, "speed": 1, "hours": "day"}
    work = {"tasks.goods": {"saturated": 10}, "tasks.unload_time": 10, "fleet.size": 3, "pickers": pickers}
    hours = {"calendars.day": {"between": stretches}, "run.length": 7200, "run.warm_up": 600}
    told = " ".join(words.sentences(dw.simulate(dw.load(RING, {**work, **hours}), 1)))
    assert ("Pickers went home" in told) == bool(text)
    assert text in told
