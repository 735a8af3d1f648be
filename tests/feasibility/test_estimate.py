"""The quick estimate: by hand on a ring of four nodes, and against runs in which nobody is in the way."""

import dataclasses
from types import SimpleNamespace

import pytest

import desim_warehouse as dw
from desim_warehouse.model import load
from desim_warehouse.questions.check.details import of_estimate
from desim_warehouse.run import probe
from desim_warehouse.run.quick import estimate

# A > B > C > D > A, 20 apart, speed 1. The good is on B > C, 5 from B; unloading at C; a charger at A.
RING = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20], "D": [0, 20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["B", "C"], "offset": 5}],
        "bays": {"home": {"at": ["A"], "places": 4, "chargers": 4}},
        "stations": {"pack": {"at": ["C"], "places": 4, "servers": 1}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"goods": {"saturated": 1}, "unload_at": ["C"], "load_time": 5, "unload_time": 10, "clear_time": 2},
    "run": {"length": 36000},
}
BATTERY = {
    "capacity": 10000,
    "threshold": 1000,
    "consumption": {"standing": 0.5, "empty": 1, "loaded": 2, "handling": 0.25},
    "charge_rate": 9,
}


def by_hand(changes=None, base=RING):
    model = load(base, changes or {})
    return estimate(model)


def test_two_visits_to_a_charger_with_no_task_in_between_are_no_round():
    """Charged at 5 and 9, before the first task is done: all tasks up to the last that was taken count."""
    times = {"assigned": [10, 100, 200], "delivered": [90, 190, 290], probe.CHARGING[0]: [5, 9]}
    rows = [SimpleNamespace(kind=kind, time=time) for kind, of_kind in times.items() for time in of_kind]
    log = SimpleNamespace(of=lambda *kinds: (row for row in rows if row.kind in kinds))
    assert probe._counted(log, 1, 290) == (10, 200, 0)
    rows.append(SimpleNamespace(kind=probe.CHARGING[0], time=195))
    assert probe._counted(log, 1, 290) == (5, 195, 2)


def test_a_task_on_the_ring():
    # from C over D and A to B is 60, 5 on to the good; 15 to C
    cycle = by_hand().cycle
    # with the 2 in which it clears C
    assert dataclasses.astuple(cycle)[:5] == pytest.approx((67, 5, 15, 10, 0))
    assert cycle.time == pytest.approx(97)
    # with 1.5 at every node: D, A and B on the way to the good, C on the way to the station
    cycle = by_hand({"traffic.node_time": 1.5}).cycle
    assert (cycle.empty, cycle.loaded) == pytest.approx((67 + 3 * 1.5, 15 + 1.5))


def test_a_task_s_energy_and_the_chargers_it_takes():
    calculation = by_hand({"battery": BATTERY, "fleet.size": 4})
    power = calculation.power
    # 67 empty at 1, 15 loaded at 2, 15 of handling at 0.25
    assert power.task == pytest.approx(67 + 30 + 3.75)
    assert power.share == pytest.approx(100.75 / 10000)
    assert power.lasts == pytest.approx(10000 / (100.75 / 97))
    assert (power.chargers, power.gives) == (4, pytest.approx(36, rel=0.002))
    # always work: f robots charge at 9 what 4 - f draw at 100.75 / 97
    drawn = 100.75 / 97
    assert power.needed == 1
    assert power.draws == pytest.approx((4 - 4 * drawn / (9 + drawn)) * drawn, rel=0.002)
    assert calculation.charging == pytest.approx(100.75 / 9, rel=0.002)
    assert calculation.fleet_capacity == pytest.approx(4 / (97 + 100.75 / 9), rel=0.002)


def test_a_robot_that_finds_no_task_drives_home_and_back():
    """With next to no demand it begins in its bay and ends there, on the ring a round more than from task to task."""
    calculation = by_hand({"battery": BATTERY, "fleet.size": 4, "tasks.goods": {"poisson": 0.1}})
    assert calculation.cycle.calm_time > calculation.cycle.time
    assert calculation.cycle.calm_energy > calculation.cycle.energy
    quiet = calculation.rate * calculation.cycle.calm_energy
    # all bays have chargers, where robots draw nothing
    assert calculation.power.draws == pytest.approx(quiet, rel=0.01)


def test_demand_stations_and_knee_are_as_worked_by_hand():
    room = {"layout.stations.pack.places": 80, "fleet.size": 3}
    calculation = by_hand({"tasks.goods": {"poisson": 72}, **room})
    assert calculation.rate == pytest.approx(0.02)
    assert calculation.robots_busy == pytest.approx(0.02 * 97)
    # two robots: 10 s of service, and 10/97 of the time another is served: 97 + 10 * 10 / 97 for two tasks
    two, one = 2 / (97 + 100 / 97), 1 / 97
    assert calculation.throughput(2) == pytest.approx(two)
    assert calculation.robots_needed == pytest.approx(1 + (0.02 - one) / (two - one))
    [station] = calculation.stations
    assert (station.share, station.capacity, station.busy) == pytest.approx((1, 0.1, 0.2))
    assert calculation.station_capacity == pytest.approx(0.1)
    # the station serves 0.1 a second, 9.7 robots' work; C is passed once loaded and never else
    robots, limit = calculation.knee
    assert limit == "unloading at C"
    assert calculation.throughput(2 * robots) < 1.1 * calculation.throughput(robots)
    assert calculation.throughput(2 * (robots - 1)) >= 1.1 * calculation.throughput(robots - 1)
    # with quick unloading the lanes of 60 / 1 - 4 places are the limit before the intersection
    quick = by_hand({"tasks.unload_time": 0, **room})
    assert quick.knee == (quick.lanes_hold, "the room in the lanes") == (4 * 19, "the room in the lanes")


def test_a_fleet_of_two_speeds_does_most_tasks_with_the_fast_ones():
    kinds = {"fleet.size": 2, "fleet.kinds": {"fast": {"count": 1, "speed": 2}}}
    calculation = by_hand(kinds)
    # 97 and 17 + 80 / 2 = 57: 1/97 + 1/57 tasks a second
    assert calculation.fleet_capacity == pytest.approx(1 / 97 + 1 / 57)


def test_the_floor_is_also_given_in_metres():
    in_mm = {"units": {"length": "mm"}}
    calculation = by_hand(in_mm)
    assert (calculation.width, calculation.height, calculation.metre) == (20, 20, 0.001)
    assert "floor: 20 x 20 mm (0.02 x 0.02 m)" in of_estimate(calculation, load(RING, in_mm).units)[0]
    assert by_hand({"units": {"length": "px"}}).metre is None


def test_the_most_that_a_robot_waiting_for_a_server_cannot_change():
    """More robots than station places: only as many work as have one."""
    calculation = by_hand({"fleet.size": 4, "layout.stations.pack.places": 2})
    assert (calculation.at_work, calculation.robots) == (2, 4)
    assert (calculation.fleet_capacity, calculation.most) == pytest.approx((4 / 97, 2 / 97))
    assert calculation.bottleneck == "the number of slots at the stations"


ALONE = {
    "fleet.size": 1,
    "fleet.start": [],
    "tasks.goods": {"saturated": 3},
    "battery": {**BATTERY, "capacity": 1e9},
    "run": {"length": 200_000},
    "log": "tasks",
    "policies": {},
}
SHORT = {"run.length": 100_000}
CASES = {
    "ring": (RING, {}),
    "ring, nodes take time": (RING, {"traffic.node_time": 2}),
    "tutorial": ("models/tutorial.yaml", {}),
    "nearest station": ("models/mir250.yaml", {"tasks.station_choice": "nearest"}),
    "any station": (
        "models/mir250.yaml",
        {"tasks.station_choice": "random", "tasks.popularity": "uniform", "policies.routing": "fastest"},
    ),
    "the paper's, hops": ("models/multibots.yaml", {"tasks.unload_at": ["M"]}),
}


@pytest.mark.parametrize(
    ("name", "length"),
    [
        *((name, SHORT) for name in list(CASES)[::2]),
        *(pytest.param(name, {}, marks=pytest.mark.long) for name in CASES),
    ],
)
def test_a_robot_alone_takes_the_time_and_the_energy_of_the_estimate(name, length):
    base, changes = CASES[name]
    model = load(base, {**ALONE, **changes, **length})
    calculation = estimate(model)
    run = dw.simulate(model, seed=5)
    busy = sum(run.robots[state].sum() for state in ("empty", "loading", "loaded", "unloading"))
    assert run.kpis["tasks"] > 200
    assert busy / run.kpis["tasks"] == pytest.approx(calculation.cycle.time, rel=0.02)
    assert run.robots[["returning", "idle", "queueing"]].sum(axis=1).iloc[0] < 0.01 * busy
    assert run.kpis["energy"] / run.kpis["tasks"] == pytest.approx(calculation.power.task, rel=0.02)


LENGTHS = {"models/tutorial.yaml": (20_000, 60_000), "models/multibots.yaml": (60_000, 200_000)}


@pytest.mark.parametrize(
    ("base", "length", "robots"),
    [
        *((base, short, robots) for base, (short, _) in LENGTHS.items() for robots in (1, 6)),
        *(
            pytest.param(base, whole, robots, marks=pytest.mark.long)
            for base, (_, whole) in LENGTHS.items()
            for robots in (1, 3, 6, 12, 20)
        ),
    ],
)
def test_no_run_does_more_than_the_bounds_allow(base, length, robots):
    """Asymptotic bounds: at most robots / cycle, at most what stations and intersections let through."""
    changes = {**ALONE, "battery": None, "fleet.size": robots, "run": {"length": length, "warm_up": 2000}}
    stations = {"layout.stations.packing.places": 30} if "tutorial" in base else {"tasks.unload_at": ["M"]}
    model = load(base, {**changes, **stations})
    calculation = estimate(model)
    done = dw.simulate(model, seed=2).kpis["throughput_per_hour"] / model.units.hour
    assert done <= 1.05 * min(calculation.most, calculation.crossing_capacity)
    if robots == 1:
        assert done >= 0.97 * calculation.capacity


@pytest.mark.long
def test_a_station_is_as_busy_as_rate_times_unloading():
    model = load("models/mir250.yaml", {"battery": None, "run": {"length": 200000, "warm_up": 7200}})
    calculation = estimate(model)
    run = dw.simulate(model, seed=3)
    servers = sum(item.servers for item in calculation.stations)
    counted = 200000 - 7200
    busy = run.robots["unloading"].sum() / (servers * counted)
    mean = sum(item.busy * item.servers for item in calculation.stations) / servers
    assert busy == pytest.approx(mean, rel=0.02)


def test_a_place_is_named_by_what_is_done_there():
    """Of a loop with a loading point L, an unloading point U, and a yard Y for both."""
    nodes = {"L": [0, 0], "a": [50, 0], "U": [50, 50], "b": [0, 50], "Y": [0, 25]}
    edges = [["L", "a"], ["a", "U"], ["U", "b"], ["b", "Y"], ["Y", "L"]]
    flows = {
        "out": {"from": ["L"], "to": ["U"], "arrivals": {"poisson": 10}},
        "in": {"from": ["Y"], "to": ["U"], "arrivals": {"poisson": 2}},
        "back": {"from": ["L"], "to": ["Y"], "arrivals": {"poisson": 2}},
    }
    model = dw.load(
        {
            "name": "loop",
            "layout": {
                "nodes": nodes,
                "edges": edges,
                "storage": [{"node": "L"}],
                "bays": {"p": {"at": ["a"], "places": 4}},
            },
            "fleet": {"size": 2, "robot": {"radius": 0.5, "speed": 1}},
            "tasks": {"load_time": 45, "unload_time": 30, "flows": flows},
            "run": {"length": "4 h"},
        }
    )
    work = {one.node: one.doing for one in estimate(model).stations}
    assert work == {"L": "loading at L", "U": "unloading at U", "Y": "loading and unloading at Y"}
