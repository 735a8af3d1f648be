"""Tours: several loads at once and stops on the way, worked out by hand; what goes together, and who has which slot."""

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import BatteryError, ModelError, PolicyError, StallError
from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.world.places.stops import Stop, between
from tests.accounting import faults
from tests.auditor import audit
from tests.world.test_flows import RING, states


def ring(flow, *batches, **changes):
    """One way round, A B C D, 20 to a side; a robot of speed 1 from A that carries 2 and takes them together.

    Loading takes 4, unloading 6; `batches`: pairs of a time and how many tasks there are then.
    """
    arrivals = {"schedule": [{"at": at, "tasks": tasks} for at, tasks in batches or [(0, 2)]]}
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    base = {"fleet.robot.capacity": 2, "policies.batching": "fixed-size", "tasks.flows": {"flow": flow}}
    flow.setdefault("arrivals", arrivals)
    run = dw.simulate(dw.load(RING, {**base, **changes}))
    assert audit(run) == []
    assert faults(run) == []
    return run


def listed(*goods, **changes):
    """The same with goods one by one: 0 lies 5 along C>D, 1 lies 10 along B>C."""
    tasks = {"goods": list(goods), "unload_at": ["pack"], "load_time": 4, "unload_time": 6}
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    model = dw.load({**RING, "tasks": tasks}, {"fleet.robot.capacity": 2, "policies.batching": "fixed-size", **changes})
    run = dw.simulate(model)
    assert audit(run) == []
    assert faults(run) == []
    return run


def rows(run, *kinds):
    return [(row.kind, row.task, row.time) for row in run.history.rows(*kinds)]


# Waiting for a batch


def of_tasks(run):
    """The parts of each task's time before a robot has it."""
    return run.account("task")[["waiting_for_batch", "waiting_for_robot"]].to_numpy().tolist()


def test_tasks_wait_for_their_batch_and_only_then_for_a_robot():
    """At 30 the first two go together, the robot is back at 130, and the third goes alone, as no other is to come."""
    run = ring({"from": "dock", "to": "pack"}, (0, 1), (30, 1), (50, 1))
    assert rows(run, "batched") == [("batched", 0, 30), ("batched", 1, 30), ("batched", 2, 50)]
    taken = [one.start for one in run.history.assignments]
    assert taken[:2] == [30, 30]
    assert of_tasks(run) == [[30, 0], [0, 0], [0, taken[2] - 50]]
    assert taken[2] > 50


def test_a_window_is_waited_for_to_its_end():
    run = ring(
        {"from": "dock", "to": "pack"}, (0, 1), (200, 1), policies__batching={"name": "time-window", "window": 60}
    )
    assert of_tasks(run) == [[60, 0], [0, 0]]


def test_what_is_in_no_batch_at_the_end_waited_for_one_all_the_time():
    arrivals = {"schedule": [{"at": 10, "tasks": 1}, {"at": 500, "tasks": 1}]}
    tasks = {"tasks.flows": {"flow": {"from": "dock", "to": "pack", "arrivals": arrivals}}}
    changes = {**tasks, "fleet.robot.capacity": 2, "policies.batching": "fixed-size", "run.length": 90}
    run = dw.simulate(dw.load(RING, changes))
    assert of_tasks(run) == [[80, 0]]


def test_without_batching_nothing_waits_for_a_batch():
    run = ring({"from": "dock", "to": "pack"}, (0, 1), (30, 1), policies__batching="single")
    assert "waiting_for_batch" not in run.account("task")
    assert rows(run, "batched") == []


def test_a_log_of_before_batches_were_written_is_read_as_then(tmp_path):
    run = ring({"from": "dock", "to": "pack"}, (0, 1), (30, 1))
    run.history.log.rows[:] = [row for row in run.history.log.rows if row[1] != "batched"]
    again = dw.load_run(run.save(tmp_path / "run"))
    assert "waiting_for_batch" not in again.account("task")
    assert again.account("task")["waiting_for_robot"].tolist() == [30, 0]


# Several loads


def test_two_loads_from_a_station_are_brought_on_one_trip():
    run = ring({"from": "dock", "to": "pack"})
    # A to B 20; loads in the dock to 24 and to 28; 40 to D: 68, unloads there to 74 and to 80; 20 to A
    assert rows(run, "loading", "unloading", "delivered", "docked") == [
        ("docked", 0, 20),
        ("loading", 0, 20),
        ("loading", 1, 24),
        ("docked", 0, 68),
        ("unloading", 0, 68),
        ("delivered", 0, 74),
        ("unloading", 1, 74),
        ("delivered", 1, 80),
    ]
    assert run.T == 100
    assert [span for span in states(run) if span[1] >= 24] == [
        ("loading", 24),
        ("loaded", 28),
        ("unloading", 68),
        ("unloading", 74),
        ("returning", 80),
    ]
    assert [(task.loaded, task.delivered) for task in run.history.tasks.values()] == [(24, 74), (28, 80)]


def test_one_by_one_they_are_two_rounds():
    # 70 at D for the first; round to B 110, 114; D 154, 160; A
    assert ring({"from": "dock", "to": "pack"}, policies__batching="single").T == 180


def test_goods_are_picked_one_after_the_other_where_they_lie():
    # B 20, good 1 at 30, to 34; C 44, good 0 at 49, to 53; D 68: to 74, to 80; A
    assert rows(listed(1, 0), "loading", "unloading") == [
        ("loading", 0, 30),
        ("loading", 1, 49),
        ("unloading", 0, 68),
        ("unloading", 1, 74),
    ]


def test_the_first_good_known_is_picked_first():
    # good 0: C 40, 45, to 49; D 64, A 84, B 104, good 1 at 114, to 118; C 128, D 148: to 154, to 160; A
    run = listed(0, 1)
    assert rows(run, "loading", "unloading") == [
        ("loading", 0, 45),
        ("loading", 1, 114),
        ("unloading", 0, 148),
        ("unloading", 1, 154),
    ]
    assert run.T == 180


SHELVES = [{"edge": ["B", "C"], "offset": offset} for offset in (5, 12, 12)]


def test_goods_on_one_lane_are_picked_without_going_round():
    # 5 along B>C: 25, to 29; 12 along it: 36, to 40; the third at the same place: to 44; C 52, D 72: to 78, 84, 90
    run = listed(0, 1, 2, layout__storage=SHELVES, fleet__robot__capacity=3)
    assert [time for _, _, time in rows(run, "loading", "unloading")] == [25, 36, 40, 72, 78, 84]
    assert run.T == 110


def test_between_two_goods_on_a_lane_is_the_way_and_one_stop():
    """7 apart at speed 2; a stop takes 1.5 for each unit of speed."""
    floor = dw.load({**RING, "tasks": {**RING["tasks"], "goods": [0], "unload_at": ["pack"]}}).floor
    travel = FreeTravel(floor.graph, 2.0, 0.0, "time", slowness=1.5)
    first, second = (Stop(None, "load", "C", ("B", "C"), offset, None) for offset in (5.0, 12.0))
    assert between(travel, first, second) == 7 / 2 + 1.5 * 2


@pytest.mark.parametrize(("length", "times"), [(1.5, [21, 25]), (1.0, [21, 25]), (0.7, [20.2, 24.6])])
def test_on_a_lane_too_short_to_stand_on_too(length, times):
    """D is 1: on a lane shorter than 2 D robots stand D from its start, on one inside a crossing anywhere."""
    lane = {"from": "B", "to": "C", "length": length}
    edges = [["A", "B"], lane, ["C", "D"], ["D", "A"]]
    shelves = [{"edge": ["B", "C"], "offset": offset} for offset in (0.2, 0.6)]
    run = listed(0, 1, layout__edges=edges, layout__storage=shelves, layout__nodes__C=[20, 0.5])
    assert [time for _, _, time in rows(run, "loading")] == pytest.approx(times)


def test_into_storage_it_is_unloaded_place_by_place():
    flow = {"from": "dock", "to": {"popularity": {"weights": [1, 1]}}}
    run = ring(flow, (0, 2), layout__storage=SHELVES[:2])
    # loads to 28; 5 along B>C: 33, to 39; 12 along: 46, to 52; 8 to C, 20, 20
    assert [time for _, _, time in rows(run, "unloading")] in ([33, 46], [33, 39], [40, 46])  # as they are drawn
    edges = {row.edge for row in run.history.rows("delivered")}
    assert edges == {("B", "C")}


def test_loads_for_several_stations_are_brought_to_the_nearest_first():
    stations = {name: {"at": [node], "places": 1} for name, node in (("dock", "B"), ("pack", "D"), ("near", "C"))}
    flows = {
        "far": {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0}]}},
        "near": {"from": "dock", "to": "near", "arrivals": {"schedule": [{"at": 0}]}},
    }
    run = ring({}, layout__stations=stations, tasks__flows=flows)
    # loads to 28; C 48: the second, to 54; D 74: the first, to 80
    assert rows(run, "delivered") == [("delivered", 1, 54), ("delivered", 0, 80)]


def test_loads_are_carried_by_kinds_that_can():
    kinds = {
        "cart": {"count": 1, "capacity": 3, "carries": ["tote"]},
        "truck": {"count": 1, "capacity": 1, "carries": ["pallet"]},
    }
    pallets = {"from": "dock", "to": "pack", "load_type": "pallet", "arrivals": {"schedule": [{"at": 0, "tasks": 2}]}}
    totes = {**pallets, "load_type": "tote", "arrivals": {"schedule": [{"at": 0, "tasks": 3}]}}
    flows = {"pallets": pallets, "totes": totes}
    run = ring({}, fleet__size=2, fleet__kinds=kinds, tasks__flows=flows)
    of = {(row.robot, run.record.flows[row.task]) for row in run.history.rows("delivered")}
    assert of == {(0, "totes"), (1, "pallets")}
    assert [len({row.time for row in run.history.rows("assigned") if row.robot == robot}) for robot in (0, 1)] == [1, 2]


def test_tasks_of_different_load_types_never_go_together():
    flow = {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0}]}}
    run = ring({}, tasks__flows={"a": {**flow, "load_type": "a"}, "b": {**flow, "load_type": "b"}})
    assert run.T == 180


# Stops on the way


def test_a_load_stops_on_its_way():
    run = ring({"from": "dock", "via": ["C"], "to": "pack", "stop_time": 3}, (0, 1))
    # dock 20, 24; C 44, to 47; D 67, to 73; A 93
    assert states(run) == [
        ("empty", 0),
        ("loading", 20),
        ("loaded", 24),
        ("unloading", 44),
        ("loaded", 47),
        ("unloading", 67),
        ("returning", 73),
    ]
    assert rows(run, "delivered") == [("delivered", 0, 73)]
    assert run.T == 93
    (task,) = run.history.tasks.values()
    assert (task.loaded, task.delivered, task.station) == (24, 73, "D")


def test_at_a_station_on_the_way_it_is_served():
    stations = {name: {"at": [node], "places": 1} for name, node in (("dock", "B"), ("pack", "D"), ("check", "C"))}
    flow = {"from": "dock", "via": ["check"], "to": "pack", "stop_time": 30}
    run = ring(flow, (0, 2), fleet__size=2, layout__stations=stations, policies__batching="single")
    assert rows(run, "docked")[:3] == [("docked", 0, 20), ("docked", 0, 44), ("docked", 0, 94)]
    # the second waits for all the slots that it needs: at D the robot that is there has the only one until it is done
    assert [(row.robot, row.time) for row in run.history.rows("assigned")] == [(0, 0), (0, 100)]


def test_there_and_back_it_keeps_its_slot():
    flow = {"from": "dock", "via": ["pack", "dock"], "to": "C", "stop_time": 1}
    run = ring(flow, (0, 1), layout__stations__dock__places=1)
    # dock 20, 24; D 64, 65; A 85, B 105: dock 106; C 126, unloads in the lane to 132; D 152, A 172
    assert rows(run, "docked") == [("docked", 0, 20), ("docked", 0, 64), ("docked", 0, 105)]
    assert run.T == 172


def test_a_chain_of_places_from_a_file(tmp_path):
    path = tmp_path / "orders.csv"
    path.write_text("release,from,via,to\n0,dock,C > 0 > A,pack\n", encoding="utf-8")
    run = ring({"from": "storage", "to": "pack", "stop_time": 2, "arrivals": {"orders": {"file": str(path)}}})
    # dock 20, 24; C 44, 46; 5 along C>D 51, 53; D 68, A 88, 90; D 150, 156; A
    assert [time for _, _, time in rows(run, "unloading")] == [44, 51, 88, 150]
    assert run.T == 176


def test_a_place_that_is_not_there_is_named(tmp_path):
    path = tmp_path / "orders.csv"
    path.write_text("release,from,via,to\n0,dock,C > pak,pack\n", encoding="utf-8")
    with pytest.raises(ModelError, match=r"row 1, via: no such place, 'pak' .*did you mean 'pack'"):
        ring({"from": "storage", "to": "pack", "arrivals": {"orders": {"file": str(path)}}})


# What goes together


def trips(run):
    """The tasks of each tour, by the time at which a robot is given it."""
    tours = {}
    for row in run.history.rows("assigned"):
        tours.setdefault((row.time, row.robot), []).append(row.task)
    return list(tours.values())


DOCK = {"from": "dock", "to": "pack"}


def test_a_batch_of_a_fixed_size_waits_until_it_is_full_and_the_last_one_may_be_smaller():
    run = ring(DOCK | {}, (0, 1), (30, 1), (500, 1))
    assert trips(run) == [[0, 1], [2]]
    assert [row.time for row in run.history.rows("assigned")] == [30, 30, 500]


def test_a_window_begins_with_the_first_task_that_waits():
    window = {"name": "time-window", "window": 25}
    run = ring(DOCK | {}, (0, 1), (20, 1), (40, 1), (90, 1), policies__batching=window, fleet__robot__capacity=5)
    # 0 and 20 go at 25, when the window of the first is over; 40 alone at 65; 90 at once, as nothing else is to come
    assert trips(run) == [[0, 1], [2], [3]]
    first_two = [row.time for row in run.history.rows("assigned")][:2]
    assert first_two == [25, 25]


def test_a_full_batch_does_not_wait_for_its_window():
    run = ring(DOCK | {}, (0, 3), (300, 1), policies__batching={"name": "time-window", "window": 100})
    assert trips(run) == [[0, 1], [2], [3]]
    # the second goes when its window is over, at 100: the robot is at D, done at 80, and back in its bay since 100
    assert [row.time for row in run.history.rows("assigned")] == [0, 0, 100, 300]


def test_an_order_goes_on_a_tour_of_its_own(tmp_path):
    path = tmp_path / "orders.csv"
    lines = ["0,dock,pack,1,A", "0,dock,pack,2,B", "0,dock,pack,1,A", "0,dock,pack,1,C", "50,dock,pack,1,"]
    path.write_text("release,from,to,quantity,order\n" + "\n".join(lines), encoding="utf-8")
    flow = {"from": "storage", "to": "pack", "arrivals": {"orders": {"file": str(path)}}}
    run = ring(flow, policies__batching="by-order", fleet__robot__capacity=2)
    assert trips(run) == [[0, 3], [1, 2], [4], [5]]


def test_tasks_that_are_always_open_are_put_together_among_themselves():
    flow = {**DOCK, "arrivals": {"saturated": 5}}
    run = ring(flow, fleet__robot__capacity=3, run__length=1000)
    assert trips(run)[:2] == [[0, 1, 2], [3, 4]]
    open_tasks, most = 0, 0
    for row in run.history.rows("released", "assigned"):
        open_tasks += 1 if row.kind == "released" else -1
        most = max(most, open_tasks)
    assert most == 5


def test_no_batch_is_larger_than_a_robot_carries():
    run = ring(DOCK | {}, (0, 5), policies__batching={"name": "fixed-size", "size": 9}, fleet__robot__capacity=2)
    assert [len(trip) for trip in trips(run)] == [2, 2, 1]


# What batteries allow

BATTERY = {"capacity": 200, "threshold": 10, "consumption": 1, "charge_rate": 10}


def test_a_tour_for_which_the_battery_does_not_last_is_not_taken_on():
    """Reach-aware, a robot takes a tour only with the energy for all of it: 100 for two loads, and 10 to spare."""
    flow = {**DOCK}
    run = ring(flow, (0, 2), (101, 2), battery=BATTERY, policies__charging={"name": "reach-aware", "margin": 0.05})
    energies = [row.value for row in run.history.rows("assigned")]
    assert len(energies) == 4
    assert min(energies) >= 100 + 10
    assert run.kpis["energy_lowest"] >= 0


def test_without_looking_ahead_it_may_run_flat_and_says_so():
    with pytest.raises(BatteryError, match="ran flat"):
        ring(DOCK | {}, (0, 6), battery={**BATTERY, "capacity": 105}, fleet__robot__capacity=6)


# Answers that cannot be


POLICY = """
from desim_warehouse.policies import TaskBatch

class Mine:
    def batches(self, waiting):
        return {answer}
"""


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        ("[TaskBatch((0, 1, 2))]", "3 tasks in a batch, expected 1 to 2, as a robot carries"),
        ("[TaskBatch((9,))]", "task 9 does not wait"),
        ("[TaskBatch((0,)), TaskBatch((0,))]", "task 0 is in two batches"),
        ("[(0, 1)]", "is no TaskBatch"),
        ("[TaskBatch(())]", "0 tasks in a batch"),
        ("1 / 0", "raised"),
    ],
)
def test_an_answer_that_cannot_be_is_named(answer, message, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(POLICY.format(answer=answer), encoding="utf-8")
    with pytest.raises(PolicyError, match=f"policies.batching .Mine. at time 0: .*{message}"):
        ring(DOCK | {}, (0, 3), policies__batching=f"{path}:Mine")


def test_a_policy_that_leaves_tasks_out_is_named(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(POLICY.format(answer="[]"), encoding="utf-8")
    with pytest.raises(StallError, match=r"3 tasks are in no batch \(.*mine.py:Mine\)"):
        ring(DOCK | {}, (0, 3), policies__batching=f"{path}:Mine")


def test_a_load_that_no_robot_carries_is_refused():
    with pytest.raises(ModelError, match=r"load_type: no robot carries it .got 'totes'., robots carry tote; did you"):
        ring({**DOCK, "load_type": "totes"}, fleet__robot__carries=["tote"])


# With all policies


@pytest.mark.parametrize("allocation", ["nearest", "earliest-due", "hungarian", "regret", "auction", "cost-aware"])
def test_every_allocation_policy_gives_tours_out(allocation):
    flows = {
        "out": {"from": "storage", "to": "pack", "arrivals": {"poisson": 200}, "due_within": 300},
        "in": {"from": "dock", "via": ["C"], "to": "storage", "arrivals": {"poisson": 60}, "stop_time": 2},
    }
    changes = {
        "fleet__size": 4,
        "fleet__robot__capacity": 3,
        "run__length": 3000,
        "battery": {"capacity": 2000, "threshold": 500, "consumption": 1, "charge_rate": 10},
        "policies__batching": {"name": "time-window", "window": 60},
        "policies__charging": "reach-aware",
    }
    run = ring({}, tasks__flows=flows, policies__allocation=allocation, **changes)
    assert run.kpis["tasks"] > 100
    assert max(len(trip) for trip in trips(run)) == 3


@pytest.mark.parametrize(
    ("by", "tours"), [({}, [["a", "b"], ["a", "b"]]), ({"by": "flow"}, [["a", "a"], ["b", "b"]])], ids=["all", "flow"]
)
def test_tours_of_one_flow_or_of_all(by, tours):
    """Of two flows that ask in turn, each robot takes loads of both, or of one; the last of a flow waits for nobody."""
    times = {"a": [{"at": 0}, {"at": 2}], "b": [{"at": 1}, {"at": 3}]}
    flows = {name: {"from": "dock", "to": "pack", "arrivals": {"schedule": at}} for name, at in times.items()}
    changes = {"fleet.robot.capacity": 2, "tasks.flows": flows, "policies.batching": {"name": "fixed-size", **by}}
    run = dw.simulate(dw.load(RING, changes))
    assert audit(run) == []
    flow_of = {number: run.history.tasks[number].flow for number in run.history.tasks}
    loaded = [flow_of[task] for _, task, _ in rows(run, "loading")]
    assert [loaded[:2], loaded[2:]] == tours


def test_what_tours_go_by_is_flow_or_nothing():
    with pytest.raises(ModelError, match="by is 'colour', expected flow, or nothing"):
        listed(0, policies__batching={"name": "fixed-size", "by": "colour"})
