"""Queues by mean value analysis: by hand for two robots, its limits, and against runs of saturated fleets."""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.feasibility.estimate import Network, Place
from desim_warehouse.feasibility.loads import loads
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.questions.check import check
from desim_warehouse.run.quick import estimate, measured

pytestmark = pytest.mark.usefixtures("brief_probes")


def test_two_robots_at_one_server():
    # 10 s at the desk, 40 s elsewhere: the second finds the other there for 10/50 of its time, and waits 10 s for it
    network = Network(50, [Place("the desk", 10, 1)])
    assert network.throughput(1) == 1 / 50
    assert network.throughput(2) == pytest.approx(2 / (50 + 10 * 10 / 50))
    assert network.longest == "the desk"


def test_two_servers_are_one_twice_as_fast_and_a_time_without_queues():
    both = Network(50, [Place("desks", 10, 2)])
    assert both.throughput(1) == 1 / 50
    assert both.throughput(2) == pytest.approx(2 / (50 + 5 * 5 / 50))
    assert both.most == 0.2


def test_many_robots_keep_the_slowest_place_busy_and_none_does_more():
    network = Network(100, [Place("desk", 10, 1), Place("charger", 20, 1)])
    assert 0.95 / 20 < network.throughput(20) < 1 / 20
    assert network.robots_for(1 / 20) == math.inf
    assert network.robots_for(1 / 100) == pytest.approx(1)
    assert network.longest == "charger"


def test_with_no_place_to_queue_robots_add_up():
    network = Network(50, [Place("desk", 0, 1)])
    assert network.throughput(7) == 7 / 50
    assert network.robots_for(7 / 50) == pytest.approx(7)


ALWAYS_AT_WORK = {"uniform": [0.3, 0.5]}
"""Levels between which they settle where work always waits, as it breaks off charging at `sufficient`.

A robot that begins above takes its energy from its battery, not from a charger: fleets did 4 % more than lasts.
"""
MORE = [pytest.param(*counts, "settled", marks=pytest.mark.long) for counts in ((4, 1), (8, 2), (14, 1))]


@pytest.mark.parametrize(("robots", "chargers", "start"), [(4, 1, ALWAYS_AT_WORK), *MORE])
@pytest.mark.usefixtures("whole_probes")
def test_a_saturated_fleet_does_what_is_said(robots, chargers, start):
    """Charging takes long, and robots queue for it: without queues up to half more would be told."""
    words = Draft(size=(40, 30), orders=100, robots=robots, chargers=chargers, stations=2)
    changes = {
        "battery.charge_rate": 0.008 if robots < 14 else 0.02,
        "tasks.goods": {"saturated": 3 * robots},
        "policies.allocation": "in-order",
        "fleet.start_energy": start,
        "run": {"length": 10 * 3600, "warm_up": 3600},
        "log": "tasks",
    }
    model = dw.Model.model_validate(read_yaml(draft(words), "draft").data).replace(changes)
    calculation = estimate(model)
    done = dw.simulate(model, 3).kpis["throughput_per_hour"]
    assert calculation.capacity * 3600 == pytest.approx(done, rel=0.15)


HALL = Draft(size=(30, 24), orders=200, robots=8, chargers=3, stations=1, packers=2)
LONG = {"run": {"length": "4 h", "warm_up": "1 h"}, "log": "tasks", "fleet.start_energy": {"uniform": [0.3, 0.95]}}
"""Levels are those between which batteries settle, without a run in which they do."""


def hall(changes):
    return dw.Model.model_validate(read_yaml(draft(HALL), "draft").data).replace({**LONG, **changes})


@pytest.mark.parametrize(
    ("lanes", "asked"),
    [("two-way", 200), *(pytest.param(*each, marks=pytest.mark.long) for each in (("ring", 280), ("two-way", 200)))],
)
def test_check_says_between_what_an_overloaded_fleet_does_with_its_traffic(lanes, asked):
    """By a short probe every day, by a whole one in the long run."""
    overloaded = {"tasks.goods": {"poisson": asked}, "fleet.start_energy": ALWAYS_AT_WORK}
    model = hall({"layout.blocks.directions": lanes, **overloaded})
    least, most = check(model).calculation.range
    assert most < 1.25 * least
    assert 0.98 * least <= dw.simulate(model, 2).kpis["throughput_per_hour"] / 3600 <= 1.02 * most


@pytest.mark.parametrize(
    ("length", "below", "above"), [("150 min", 0.05, 0.05), pytest.param("4 h", 0.0, 0.02, marks=pytest.mark.long)]
)
def test_slots_of_stations_count_with_flows(length, below, above):
    """One slot for eight robots: they come to it one by one."""
    flows = {"orders": {"from": "storage", "to": "packing", "arrivals": {"poisson": 38}}}
    tasks = {"load_time": 10, "unload_time": 20, "station_choice": "least-loaded", "flows": flows}
    one = {"layout.stations.packing.places": 1, "layout.stations.packing.servers": 1}
    model = hall({"tasks": tasks, **one, "run.length": length})
    calculation = check(model).calculation
    least, most = calculation.range
    assert calculation.bottleneck == "the number of slots at the stations"
    done = dw.simulate(model, 2).kpis["throughput_per_hour"] / 3600
    assert (1 - below) * least <= done <= (1 + above) * most


ROUND = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 10], "D": [0, 10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["A", "B"], "offset": 5}, {"edge": ["A", "B"], "offset": 15}],
        "bays": {"home": {"at": ["D"], "places": 20}},
        "stations": {"packing": {"at": ["C"], "places": 20}},
    },
    "fleet": {"size": 6, "robot": {"radius": 0.4, "speed": 1, "margin": 0.2}},
    "tasks": {
        "load_time": 10,
        "unload_time": 10,
        "flows": {"orders": {"from": "storage", "to": "packing", "arrivals": {"poisson": 150}}},
    },
    "run": {"length": "4 h", "warm_up": "30 min"},
}
"""A way round of 60 s, 10 to load and 10 to unload: a robot does 45 tasks an hour, and 150 need 3.3 robots."""


@pytest.mark.parametrize("changes", [{}, {"tasks.load_time": 20, "tasks.unload_time": 1}])
def test_how_many_robots_are_needed_does_not_depend_on_how_many_there_are(changes):
    """Of 20 robots most wait: for the server, which does 360 tasks an hour, or behind those that load in the lane."""
    for size in (6, 20):
        assert 3.3 < measured(dw.load(ROUND, {**changes, "fleet.size": size})).robots_needed < 4


@pytest.mark.parametrize("by_flows", [True, False])
def test_slots_that_let_too_few_robots_work_are_the_limit_of_any_fleet(by_flows):
    """Each robot needs one of 3 slots from the start of a task to its end: 3 x 45 = 135 tasks an hour, not 150."""
    drawn = {"load_time": 10, "unload_time": 10, "goods": {"poisson": 150}, "unload_at": ["packing"]}
    tasks = ROUND["tasks"] if by_flows else drawn
    report = check(dw.load({**ROUND, "tasks": tasks}, {"fleet.size": 10, "layout.stations.packing.places": 3}))
    assert report.calculation.range[1] * 3600 == pytest.approx(135)
    assert report.calculation.robots_needed == math.inf
    assert "\nWith the number of slots at the stations as the limit, 10 robots can do about " in str(report)
    assert "Robots: no number is enough for 150 loads an hour.\n" in str(report)  # the limit is named once
    enough = dw.load({**ROUND, "tasks": tasks}, {"fleet.size": 10, "layout.stations.packing.places": 4})
    assert measured(enough).robots_needed == pytest.approx(3.35, abs=0.1)


def test_chargers_that_just_give_what_is_drawn_are_no_shortage():
    """Five robots that always draw 0.005 where one stands at its charger take the 0.02 that this one gives."""
    model = hall({"fleet.size": 5, "battery.consumption": 0.005, "layout.bays.charging.total_chargers": 1})
    report = check(model.replace({"tasks.goods": {"poisson": 90}}))
    assert "CHARGERS_SHORT" not in {item.code for item in report.findings}
    assert report.calculation.capacity * 3600 > 60


def test_a_need_beyond_the_fleet_is_a_warning():
    model = hall({"fleet.size": 3})
    estimate = check(model).calculation
    asked = (estimate.range[1] + estimate.capacity) / 2 * 3600
    over = check(model.replace({"tasks.goods": {"poisson": asked}}))
    assert over.calculation.robots_needed > 3
    [warning] = [item for item in over.findings if item.code == "DEMAND_ABOVE_FLEET"]
    assert f"3 robots can do {over.calculation.can_do(3600)}" in warning.text


def test_breakdowns_count_in_the_robots_needed_in_the_busiest_hour():
    rates = {"profile": {"every": "12 h", "per_hour": [20, 60]}}
    tasks = {"load_time": 10, "unload_time": 20}
    tasks["flows"] = {"orders": {"from": "storage", "to": "packing", "arrivals": rates}}
    sound = hall({"tasks": tasks, "run": {"length": "24 h"}})
    broken = sound.replace({"fleet.robot.breakdowns": {"every": "9 h", "repair": "1 h"}})
    usual, more = (check(model).calculation for model in (sound, broken))
    assert more.peak == usual.peak
    need = [one.busiest_hour.robots_needed for one in (usual, more)]
    assert need[1] == pytest.approx(need[0] / 0.9, rel=0.03)


def test_slots_are_named_as_the_busiest_by_a_check_and_by_a_run():
    """10 robots with 3 slots are asked for 150 of the 3 x 45 = 135 that these let through: 111 %; robots work a third.

    Of the 150 an hour that come, a run delivers some 133.
    """
    model = dw.load(ROUND, {"fleet.size": 10, "layout.stations.packing.places": 3})
    assert "The slots of the stations are busiest: demand is 111 % of their capacity" in str(check(model))
    assert "The slots of the stations were the busiest, with demand at 11" in str(dw.simulate(model, 0))


def test_slots_limit_nobody_where_tasks_end_elsewhere():
    """Loads that are moved from shelf to shelf need no station, whatever slots there are."""
    tidy = {"from": "storage", "to": "storage", "arrivals": {"poisson": 20}}
    places = {"layout.stations.packing.places": 3}
    for flows in ({"tidy": tidy}, {**ROUND["tasks"]["flows"], "tidy": tidy}):
        report = check(dw.load({**ROUND, "tasks": {**ROUND["tasks"], "flows": flows}}, places))
        assert report.calculation.slots is None
        assert "STATION_PLACES" not in {item.code for item in report.findings}


def test_a_fleet_is_not_said_to_be_at_its_limit_where_one_robot_more_adds_a_third():
    """A robot does 48 tasks an hour, and four draw just what the charger gives; six would run flat."""
    stations = {name: {"at": [node], "places": 6, "servers": 6} for name, node in (("src", "B"), ("dst", "C"))}
    model = dw.load(
        {
            "layout": {
                "nodes": {"A": [0, 0], "B": [10, 0], "C": [10, 10], "D": [0, 10]},
                "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
                "bays": {"home": {"at": ["A"], "places": 6, "chargers": 1}},
                "stations": stations,
            },
            "fleet": {"size": 3, "robot": {"radius": 0.3, "margin": 0.1, "speed": 1}, "start_energy": "settled"},
            "battery": {"capacity": 1000, "threshold": 200, "consumption": 0.25, "charge_rate": 1},
            "tasks": {
                "load_time": 10,
                "unload_time": 10,
                "flows": {"flow": {"from": "src", "to": "dst", "arrivals": {"poisson": 170}}},
            },
            "run": {"length": "20 h", "warm_up": "4 h"},
        }
    )
    robots, _ = measured(model).knee
    assert robots in {4, 5}
    [warning] = [finding for finding in dw.check(model).findings if finding.code == "DEMAND_ABOVE_FLEET"]
    assert "at least 4 robots are needed" in warning.cure
    assert "hardly do more" not in warning.text


def test_robots_are_loaded_relative_to_what_they_do_where_they_can_choose_among_tasks():
    """Five robots, each of which takes whatever comes next, would do 144 an hour; those that choose do 155 to 174."""
    words = Draft((40, 30), orders=150, robots=5, chargers=3, stations=2)
    model = dw.Model.model_validate(read_yaml(draft(words), "draft").data)
    calculation, hour = measured(model), 3600
    least, likely, _ = calculation.measured
    assert calculation.fleet_capacity * hour < 150 < least * hour
    (robots,) = [load for load in loads(model, calculation) if load.group.kind == "robots"]
    assert robots.mean == pytest.approx(150 / hour / likely)
    kpis = dw.simulate(model.replace({"run": {"length": "4 h", "warm_up": "1 h"}}), seed=1).kpis
    assert kpis["backlog"] < 15
    assert kpis["throughput_per_hour"] == pytest.approx(150, rel=0.08)
