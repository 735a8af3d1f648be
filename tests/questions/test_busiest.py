"""Who is busiest and what is scarce: small halls with one planted bottleneck, of which all answers name the same."""

import math
import re
from dataclasses import replace

import pytest

import desim_warehouse as dw
from desim_warehouse.answer.busiest import are, was
from desim_warehouse.feasibility.loads import loads as foreseen
from desim_warehouse.folders import gallery
from desim_warehouse.model.facts.workers import LANES, Group, Load, busiest, ranked, scarce
from desim_warehouse.outcome.loads import loads, of_robots
from desim_warehouse.questions.check import check
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.questions.run import words
from desim_warehouse.questions.why import why
from desim_warehouse.replay.payload import payload
from desim_warehouse.run.quick import estimate
from desim_warehouse.study.suspects import suspects
from tests.daily import some

pytestmark = pytest.mark.usefixtures("brief_probes")

HALL = {
    "name": "hall",
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [20, 0], "D": [20, 10], "E": [10, 10], "F": [0, 10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "E"], ["E", "F"], ["F", "A"], ["B", "E"]],
        "storage": [{"node": "C"}],
        "bays": {"parking": {"at": ["F"], "places": 8}},
        "stations": {"packing": {"at": ["E"], "places": 8, "servers": 4}},
    },
    "fleet": {"size": 4, "robot": {"radius": 0.3, "speed": 1.0}},
    "tasks": {"goods": {"poisson": 60}, "unload_at": ["packing"], "load_time": 2, "unload_time": 2},
    "run": {"length": "5 h", "warm_up": "1 h"},
    "log": "all",
}
"""A task takes a robot 60 m and 4 s, 64 s: 56 an hour with one, 225 with four."""
DESK = {"layout.stations": {"desk": {"at": ["E"], "places": 8, "servers": 4}}, "tasks.unload_at": ["desk"]}
PROFILE = {"from": "storage", "to": "packing", "arrivals": {"profile": {"per_hour": [30, 30, 30, 80, 30]}}}
LAST = {"fleet.size": 8, "tasks.unload_time": 50}
"""Sixty loads of 50 s each are 83 % of an hour."""
CASES = {
    "robots": ({"fleet.size": 1, "tasks.goods": {"poisson": 48}}, {"robots": 48 * 64 / 3600}),
    "chargers": (
        {
            "battery": {"capacity": 3600, "consumption": 1, "charge_rate": 4.5, "threshold": 1800},
            "layout.bays.parking.total_chargers": 1,
        },
        {"chargers": 0.73},
    ),
    "servers": ({**DESK, **LAST, "layout.stations.desk.servers": 1}, {"places of desk": 5 / 6}),
    "packers": ({**LAST, "layout.stations.packing.servers": 1}, {"packers": 5 / 6}),
    "people who pack": ({"layout.stations.packing.work_time": 54}, {"packers": 0.9}),
    "people": ({**DESK, "layout.stations.desk.work_time": 54}, {"workers of desk": 0.9}),
    "two": (
        {"fleet.size": 1, "tasks.goods": {"poisson": 48}, "layout.stations.packing.work_time": 64},
        {"robots": 48 * 64 / 3600, "packers": 48 * 64 / 3600},
    ),
    "nothing": ({"fleet.size": 8}, {"robots": 60 * 64 / 3600 / 8}),
    "the peak alone": (
        {
            "tasks": {"flows": {"orders": PROFILE}, "load_time": 2, "unload_time": 2},
            "layout.stations.packing.work_time": 54,
        },
        {"packers": 0.6},
    ),
}
"""What is planted, and who is busiest, with the mean load."""


def hall(case):
    return dw.load(HALL, CASES[case][0])


def named(sentences):
    """Who is said to be busiest, in one of some sentences."""
    (line,) = [line for line in sentences if "busiest" in line.replace("busiest hour", "")]
    before, _, after = (
        line.partition(" the busiest, ") if " were the busiest, " in line else line.partition(" are busi")
    )
    who = re.findall(r"(?:^|[Tt]he |and )(robots|chargers|packers|\w+ of \w+)\b", before)
    return {*who, *re.findall(r"and the (robots|chargers|packers|\w+ of \w+), (?:at work|in use|with)", after)}


@pytest.mark.parametrize("case", CASES)
def test_check_run_and_replay_name_the_planted_bottleneck(case):
    model, planted = hall(case), CASES[case][1]
    expected = {load.group.name: load.mean for load in busiest(foreseen(model, estimate(model)))}
    assert expected == pytest.approx(planted, rel=0.02)
    run = dw.simulate(model, 1)
    header, _ = payload(run.history, 0.0, run.history.end)
    sentences, told = words.sentences(run), [stop["said"] for stop in header["stops"]]
    assert named(check(model).sentences) == named(sentences) == named(told) == set(planted)
    lines = [line for line in (*check(model).sentences, *sentences) if "busiest" in line.replace("busiest hour", "")]
    assert all(("othing is scarce" in line or "othing was scarce" in line) == (case == "nothing") for line in lines)
    assert all(("busiest hour" in line) == (case == "the peak alone") for line in lines)


@pytest.mark.slow
@pytest.mark.parametrize("case", some(CASES, 6))
def test_plan_names_the_planted_bottleneck(case):
    model, planted = hall(case).replace({"log": "tasks", "run.length": "2 h"}), CASES[case][1]
    robots = [model.fleet.size]
    plan = plan_fleet(model, "throughput_per_hour >= 5", robots=robots, strategies={}, search=dw.Search(runs=60))
    assert named(plan.answer.answer) == set(planted)


@pytest.mark.parametrize("case", [pytest.param(case, marks=pytest.mark.long) for case in CASES])
def test_why_names_the_planted_bottleneck(case):
    assert named(why(hall(case), search=dw.Search(first=2, runs=60)).answer.answer) == set(CASES[case][1])


def test_why_names_who_the_run_it_looked_at_names():
    run = dw.simulate(hall("people who pack").replace({"run.length": 3600, "run.warm_up": 0}), 1)
    held = why(run, search=dw.Search(first=2, runs=20))
    assert named(held.answer.answer) == named(words.sentences(run)) == {"packers"}


def test_those_who_pack_are_called_packers_in_all_of_why():
    """With `work_time` the people at the bench pack; who takes loads off robots is a loading point."""
    run = dw.simulate(hall("people who pack").replace({"run.length": 3600, "run.warm_up": 0}), 1)
    reliefs = {suspect.name: suspect.relief for suspect in suspects(run)}
    assert reliefs["packers"] == "one packer more at each station"
    assert reliefs["places of packing"] == "another loading point at each station"
    by_robots = dw.simulate(hall("packers").replace({"run.length": 3600, "run.warm_up": 0}), 1)
    assert {s.name: s.relief for s in suspects(by_robots)}["packers"] == "a second packer at each station"


def test_pickers_of_pods_are_busiest_where_lines_take_them_long():
    """Each of two pickers has 110 lines an hour of 30 s: 92 % of the time."""
    model = dw.load(gallery()["goods-to-person"])
    (name,) = model.tasks.flows
    lines = {f"tasks.flows.{name}.lines": 1, f"tasks.flows.{name}.stop_time": 30}
    rate = {f"tasks.flows.{name}.arrivals": {"poisson": 55 * sum(s.servers for s in model.floor.stations.values())}}
    slow = model.replace({**lines, **rate})
    (zone,) = slow.layout.stations
    load = next(load for load in foreseen(slow, estimate(slow)) if load.group.zone)
    assert (load.group.name, load.group.kind) == (f"pickers of {zone}", "pickers")
    assert load.mean == pytest.approx(55 * 30 / 3600)


def test_more_is_asked_for_than_can_be_done():
    """One packer who takes 65 s for each of 60 loads an hour: 108 %, where a run is long enough to show it."""
    changes = {"layout.stations.packing.work_time": 65, "run.length": "40 h", "log": "tasks"}
    model = dw.load(HALL, changes)
    (line,) = [line for line in check(model).sentences if "busiest" in line]
    assert line.startswith("The packers are busiest: demand is 108 % of their capacity; ")
    run = dw.simulate(model, 1)
    (load,) = busiest(loads(run.history, run.kpis))
    came = sum(task.released >= 3600 for task in run.history.tasks.values())
    assert load.mean == pytest.approx(came * 65 / run.history.counted, rel=0.01)
    (line,) = [line for line in words.sentences(run) if "busiest" in line]
    assert re.match(r"The packers were the busiest, with demand at 1[01]\d(\.\d)? % of their capacity\. ", line)
    plan = plan_fleet(model.replace({"run.length": "3 h"}), "backlog <= 1", robots=[4], search=dw.Search(runs=30))
    assert "The packers are busiest: demand is 108 % of their capacity" in plan.answer.answer[0]


def test_the_drive_back_to_parking_is_no_work():
    """A task every 100 s: 20 m empty to C, 2 s, 20 m to E, 2 s; 10 m back to F are apart."""
    flow = {"from": "storage", "to": "packing", "arrivals": {"schedule": [{"at": 100 * n} for n in range(36)]}}
    tasks = {"flows": {"orders": flow}, "load_time": 2, "unload_time": 2}
    run = dw.simulate(dw.load(HALL, {"tasks": tasks, "fleet.size": 1, "run.length": 3600, "run.warm_up": 0}))
    time = of_robots(run.kpis, run.model)
    assert run.T == 3500 + 64
    assert time.work == pytest.approx(36 * (30 + 2 + 20 + 2) / run.T)
    assert time.back == pytest.approx(36 * 10 / run.T)
    assert math.isclose(time.held, 0, abs_tol=1e-9)
    assert ", at work 54.5 % of the time, plus 10.1 % driving back to parking. " in " ".join(words.sentences(run))


def test_robots_of_kinds_that_share_no_flow_are_busy_each_for_themselves():
    """One robot has 90 totes an hour of 64 s, 160 % of its time; three have 9 pallets, 5 %; the last has nothing."""
    flows = {
        "totes": {"from": "storage", "to": "packing", "kinds": ["small"], "arrivals": {"poisson": 90}},
        "pallets": {"from": "storage", "to": "packing", "kinds": ["big"], "arrivals": {"poisson": 9}},
    }
    kinds = {"fleet.size": 5, "fleet.kinds": {"small": {"count": 1}, "big": {"count": 3}}}
    model = dw.load(HALL, {"tasks": {"flows": flows, "load_time": 2, "unload_time": 2}, **kinds})
    robots = {load.group.name: load.mean for load in foreseen(model, estimate(model)) if load.group.kind == "robots"}
    expected = {"robots of kind small": 90 * 64 / 3600, "robots of kind big": 9 * 64 / 3600 / 3, "robots of no kind": 0}
    assert robots == pytest.approx(expected, rel=0.02)
    report = check(model)
    sentences = " ".join(report.sentences)
    assert "Robots of no kind have nothing to do: no flow is for them." in sentences
    assert "Robots: 2 of kind small are needed (you have 1) and 1 of kind big is enough (you have 3)." in sentences
    assert "The robots of kind small are busiest: demand is 160 % of their capacity" in sentences
    (short,) = [one for one in report.findings if one.code == "DEMAND_ABOVE_FLEET"]
    assert short.cure == "at least 2 of kind small are needed, each with a place at a station"
    run = dw.simulate(model, 1)
    (load,) = busiest(loads(run.history, run.kpis))
    came = sum(task.released >= 3600 and task.flow == "totes" for task in run.history.tasks.values())
    assert (load.group.name, load.piles_up) == ("robots of kind small", True)
    assert load.mean == pytest.approx(came * 64 / run.history.counted, rel=0.02)
    assert "The robots of kind small were the busiest, with demand at 1" in " ".join(words.sentences(run))


def test_a_robot_that_rides_in_a_lift_is_at_work():
    """A robot always on its way: of 108 s a load, 24 up and 24 down go into doors and rides, and it is at work in all.

    Each drive is 20 m, a metre of it into the cabin. Orders that are always open leave it no other time.
    """
    nodes = {"home": [0, 0], "hall": [10, 0], "lift0": [20, 0], "lift1": [20, 30], "ward": [10, 30], "far": [0, 30]}
    lanes = [["home", "hall"], ["hall", "lift0"], ["lift1", "ward"], ["ward", "far"]]
    layout = {
        "nodes": nodes,
        "edges": [{"from": a, "to": b, "two_way": True} for a, b in lanes],
        "lifts": {"main": {"nodes": ["lift0", "lift1"], "ride": 12, "doors": 4}},
        "bays": {"parking": {"at": ["home"]}},
        "stations": {"kitchen": {"at": ["hall"]}, "wards": {"at": ["ward"]}},
    }
    tasks = {
        "flows": {"meals": {"from": "kitchen", "to": "wards", "arrivals": {"saturated": 2}}},
        "load_time": 10,
        "unload_time": 10,
    }
    fleet = {"size": 1, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1}}
    hospital = dw.load({"layout": layout, "fleet": fleet, "tasks": tasks, "run": {"length": 10_800, "warm_up": 1080}})
    run = dw.simulate(hospital)
    assert run.kpis["share_in_lift"] == pytest.approx(48 / 108, rel=0.01)
    assert of_robots(run.kpis, run.model).work == pytest.approx(1)
    assert "Nothing was scarce" not in " ".join(words.sentences(run))


def test_loads_that_differ_by_five_points_are_both_the_largest():
    robots, packers = Group("robots"), Group("people", "packing", packs=True)
    near = [Load(robots, 0.72), Load(packers, 0.76)]
    assert [load.group.name for load in busiest(near)] == ["packers", "robots"]
    assert [load.group.name for load in busiest([Load(robots, 0.70), Load(packers, 0.76)])] == ["packers"]
    assert [load.group for load in busiest([Load(robots, 0.5, 1.2), Load(packers, 0.76)])] == [robots]
    assert [load.group for load in scarce([Load(robots, 0.5, 1.2), Load(packers, 0.69)])] == [robots]
    assert busiest([]) == busiest([Load(robots, 0.0)]) == []


def test_lanes_are_the_largest_where_robots_wait_in_them_longer_than_they_work():
    order = [Load(LANES, 0.5), Load(Group("robots"), 0.4), Load(Group("chargers"), 0.8)]
    assert [load.group.name for load in ranked(order)] == ["lanes", "chargers", "robots"]
    assert [load.group.name for load in busiest(order)] == ["lanes"]


@pytest.mark.parametrize("work_time", [None, 20])
def test_a_design_costs_the_same_a_year_whatever_is_asked(work_time):
    """Two robots of 6,000, and a packer of 30 an hour for 4,000 hours: 132,000; the place for robots earns nothing."""
    prices = {"hours": 4000, "robot": 6000, "station_hour": 30}
    station = {"at": ["E"], "places": 8, "servers": 1, "work_time": work_time}
    changes = {"prices": prices, "fleet.size": 2, "layout.stations": {"packing": station}, "log": "tasks"}
    model = dw.load(HALL, {**changes, "run.length": 1200, "run.warm_up": 0})
    goal, search = "throughput_per_hour >= 5", dw.Search(runs=60)
    plans = [
        plan_fleet(model, goal, robots=[2], strategies={}, search=search),
        plan_fleet(model, goal, robots=[2], packers="packing=1", strategies={}, search=search),
    ]
    study = dw.Study(model, {"fleet.size": [2]}, replications=2)
    study.run(workers=1)
    costs = {plan.today.best.cost for plan in plans} | {row.value("annual_cost") for row in study.rows}
    assert costs | {dw.simulate(model, 1).kpis["annual_cost"]} == {132_000}


def test_what_a_plan_says_a_year_costs_is_what_its_runs_cost():
    """With energy and late orders a year depends on the runs."""
    prices = {"hours": 4000, "robot": 6000, "late_order": 2}
    goods, short = {"poisson": 60, "due_within": 50}, {"run.length": 3600, "run.warm_up": 900}
    model = dw.load(HALL, {"prices": prices, "tasks.goods": goods, "log": "tasks", **short})
    plan = plan_fleet(model, "throughput_per_hour >= 5", robots=[4], strategies={}, search=dw.Search(runs=60))
    assert plan.today.best.cost == pytest.approx(4 * 6000 + 2 * 60 * 4000, rel=0.2)  # no task is done in 50 s


@pytest.mark.parametrize(
    ("mean", "peak", "words"),
    [
        (0.66, 0.98, "66 % of the time (98 % in the busiest hour)"),
        (0.66, 1.01, "66 % of the time (in the busiest hour demand is 101 % of their capacity)"),
        (1.2, 1.9, "demand is 120 % of their capacity (190 % in the busiest hour)"),
    ],
)
def test_more_than_robots_can_do_is_no_share_of_their_time(mean, peak, words):
    assert words in are([Load(Group("robots", number=6), mean, peak)])


def test_waits_of_the_busiest_hour_take_time_of_robots_too():
    """Half of their time is work and a tenth waits: 1.5 times as much work is 75 %, and 90 % with the waits."""
    load = Load(Group("robots", number=6), 0.5, 0.75, held=0.1)
    assert load.peak_with_waits == pytest.approx(0.9)
    assert "50 % of the time (75 % in the busiest hour, 90 % with waits)" in are([load])
    assert "(demand in the busiest hour was 75.0 % of their capacity, 90.0 % with waits)" in was([load])
    assert "with waits" not in was([replace(load, held=0.0)])
