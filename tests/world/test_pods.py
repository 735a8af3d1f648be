"""Goods to person, worked out by hand: a ring of one-way lanes, 1 m/s, no time at nodes, one picker.

A (0,0) > B (20,0) > C (20,-10) > D (0,-10) > A, 60 m round; places on A>B at 5, 10 and 15 m (0, 1, 2); the station
at C, the bay at A. A pod is lifted in 3 s and put down in 2 s, a line is picked in 10 s.
"""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ModelError, PolicyError
from desim_warehouse.questions.run.words import sentences
from tests.audit_pods import audit_pods

pytestmark = pytest.mark.usefixtures("brief_probes")

RING = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, -10], "D": [0, -10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["A", "B"], "offset": offset} for offset in (5, 10, 15)],
        "bays": {"bay": {"at": ["A"], "chargers": 0, "places": 5}},
        "stations": {"pick": {"at": ["C"], "places": 5}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1}},
    "tasks": {
        "load_time": 3,
        "unload_time": 2,
        "flows": {"picks": {"from": "storage", "to": "pick", "arrivals": {"schedule": [{"at": 0}]}, "stop_time": 10}},
    },
    "pods": {"count": 1, "items": 1, "per_pod": 1, "orders": 0, "change_time": 0},
    "policies": {"allocation": "nearest", "parking": "nearest", "storage": "own"},
}
THREE = {"pods__count": 3, "pods__items": 3}


def at(*times):
    return {"schedule": [{"at": time, "tasks": tasks} for time, tasks in times]}


def played(arrivals, seed=0, **changes):
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    run = dw.simulate(dw.load(RING, {"tasks.flows.picks.arrivals": at(*arrivals), **changes}), seed=seed)
    assert audit_pods(run) == []
    return run


def rows(run, *kinds):
    return [(row.time, row.robot, row.other) for row in run.history.rows(*kinds)]


def times(run, *kinds):
    return [row.time for row in run.history.rows(*kinds)]


def with_pods_at(places, arrivals, lines=None, **changes):
    """A run in which the pods at these places are lifted, in this order, for so many lines each: the seed has it so."""
    for seed in range(400):
        run = played(arrivals, seed, **changes)
        lifted = [(row.other, int(row.value)) for row in run.history.rows("lifted")]
        done = [sum(row.other == pod for row in run.history.rows("delivered")) for _, pod in lifted]
        if list(dict.fromkeys(place for place, _ in lifted)) == places and lines in (None, done):
            return run
    raise AssertionError("no seed has it so")


def test_one_line_from_one_pod():
    run = with_pods_at([0], [(0, 1)])
    # 5 m, lifted 3; 15 + 10 m to C; picked 10; 20 + 10 round and 5 + ... to its place 35 m; 2; 15 + 40 home
    assert rows(run, "lifted") == [(8, 0, 0)]
    assert times(run, "docked") == [33]
    assert rows(run, "delivered") == [(43, 0, 0)]
    assert rows(run, "stored") == [(80, 0, 0)]
    assert run.T == 135
    assert run.kpis["distance"] == run.kpis["distance_per_task"] == 120
    assert (run.kpis["pod_visits"], run.kpis["pile_on"]) == (1, 1)
    assert run.kpis["station_idle"] == pytest.approx(1 - 10 / 135)
    assert [(task.loaded, task.delivered, task.station) for task in run.history.tasks.values()] == [(8, 43, "C")]


def test_two_lines_from_one_pod_are_one_visit():
    run = with_pods_at([0], [(0, 2)])
    assert times(run, "delivered") == [43, 53]
    assert times(run, "stored") == [90]
    assert run.T == 145
    assert (run.kpis["pod_visits"], run.kpis["pile_on"]) == (1, 2)


def test_a_line_joins_a_pod_that_is_at_its_station():
    run = with_pods_at([0], [(0, 1), (35, 1)])
    assert [(row.time, row.task) for row in run.history.rows("assigned")] == [(0, 0), (35, 1)]
    assert times(run, "delivered") == [43, 53]
    assert run.T == 145


def test_a_line_joins_for_the_last_unit_and_no_further():
    run = dw.simulate(dw.load(RING, {"tasks.flows.picks.arrivals": at((0, 1), (35, 2)), "pods.stock": 2}), until=300)
    assert [(row.time, row.task) for row in run.history.rows("assigned")] == [(0, 0), (35, 1)]
    assert audit_pods(run) == []


def test_a_line_does_not_join_a_pod_on_its_way_back():
    run = with_pods_at([0], [(0, 1), (50, 1)], fleet__size=2)
    # the robot that has put it down stands right at it, and would drive 60 m: that in the bay is nearer
    assert [(row.time, row.robot, row.task) for row in run.history.rows("assigned")] == [(0, 0, 0), (80, 1, 1)]
    assert rows(run, "lifted") == [(8, 0, 0), (88, 1, 0)]
    assert times(run, "docked") == [33, 113]
    assert times(run, "delivered") == [43, 123]
    assert times(run, "stored") == [80, 160]
    assert run.T == 215
    assert run.kpis["pile_on"] == 1


@pytest.mark.parametrize(("storage", "stored", "place"), [("nearest", 80, 0), ("own", 90, 2)])
def test_where_a_pod_goes_back(storage, stored, place):
    run = with_pods_at([2], [(0, 1)], policies__storage=storage)
    assert times(run, "lifted") == [18]
    assert times(run, "docked") == [33]
    assert rows(run, "stored") == [(stored, 0, place)]
    assert run.T == 135


def test_pods_queue_at_the_station():
    run = with_pods_at([0, 2], [(0, 6)], [2, 4], fleet__size=2, **THREE)
    assert times(run, "lifted") == [8, 18 + 4]  # the second robot, right behind the first, is held up while that lifts
    assert times(run, "docked") == [33, 37]
    assert times(run, "delivered") == [43, 53, 63, 73, 83, 93]
    assert times(run, "stored") == [90, 140]
    assert run.T == 185
    assert run.kpis["station_idle"] == pytest.approx(1 - 60 / 185)


def test_the_time_of_a_line_is_accounted_for():
    run = with_pods_at([0, 2], [(0, 6)], [2, 4], fleet__size=2, **THREE)
    parts = run.account("task").loc[[row.task for row in run.history.rows("delivered")]]
    # lifted at 8 and 22; the second pod queues from 37 to 53, and its last line is picked after three others
    assert parts["waiting_for_lines"].tolist() == [0, 10, 0, 10, 20, 30]
    assert parts["unloading"].tolist() == [10] * 6
    assert parts["queueing_server"].tolist() == [0, 0, 16, 16, 16, 16]
    assert parts["waiting_for_pod"].tolist() == [0] * 6
    assert parts.sum(axis=1).tolist() == [43, 53, 63, 73, 83, 93]


def test_of_lines_that_are_open_at_the_end_one_is_picked():
    run = played([(0, 4)], run__length=58)  # picked at 43 and 53; 5 s of the third
    parts = run.account("task")
    assert parts["unloading"].tolist() == [10, 10, 5, 0]
    assert parts["waiting_for_lines"].tolist() == [0, 10, 20, 25]


def test_a_run_says_how_many_lines_a_visit_served():
    run = with_pods_at([0], [(0, 2)])
    sentence = "A pod served 2 lines a visit; pickers had nothing to pick 86.2 % of the time."  # 20 of 145 s
    assert sentences(run)[-1] == sentence
    assert sentences(with_pods_at([0], [(0, 1)]))[-1].startswith("A pod served 1 line a visit; ")
    nothing = dw.simulate(dw.load(RING, {"run.length": 20}))  # no pod was put down
    assert "A pod served" not in " ".join(sentences(nothing))


def test_a_line_waits_for_a_pod_that_stands_again():
    run = with_pods_at([0], [(0, 1), (50, 1)], fleet__size=2)
    assert run.account("task")["waiting_for_pod"].tolist() == [0, 30]


@pytest.mark.slow
def test_one_place_in_the_station_holds_the_second_back():
    run = with_pods_at([0, 2], [(0, 6)], [2, 4], fleet__size=2, layout__stations__pick__places=1, **THREE)
    assert set(times(run, "assigned")) == {0, 53}
    assert times(run, "lifted") == [8, 71]
    assert times(run, "docked") == [33, 86]
    assert times(run, "delivered") == [43, 53, 96, 106, 116, 126]
    assert times(run, "stored") == [90, 173]
    assert run.T == 218


def test_the_next_of_a_queue_comes_after_the_change():
    run = with_pods_at([0, 2], [(0, 6)], [2, 4], fleet__size=2, **{**THREE, "pods__change_time": 4})
    assert times(run, "delivered") == [43, 53, 67, 77, 87, 97]
    alone = with_pods_at([0], [(0, 2)], pods__change_time=4)
    assert times(alone, "delivered") == [43, 53]


def test_a_bundle_is_put_onto_a_pod_and_then_picked():
    flows = {
        "picks": {"from": "storage", "to": "pick", "arrivals": at((0, 3)), "stop_time": 10},
        "bundles": {"from": "pick", "to": "storage", "arrivals": at((500, 1)), "stop_time": 20},
    }
    run = dw.simulate(dw.load(RING, {"tasks.flows": flows, "pods.stock": 1, "pods.bundle": 2}), seed=1)
    # one unit is there: two lines wait until the bundle of two has come, and join the pod at the station
    assert audit_pods(run) == []
    assert [run.history.log.flows[task.number] for task in run.history.delivered] == [
        "picks",
        "bundles",
        "picks",
        "picks",
    ]


def test_orders_wait_for_room_at_a_station():
    run = played([(0, 4)], pods__orders=1, tasks__flows__picks__lines=2)
    orders = [order.tasks for order in run.history.orders]
    done = [max(task.delivered for task in tasks) for tasks in orders]
    assigned = {row.task: row.time for row in run.history.rows("assigned")}
    begun = [min(assigned[task.number] for task in tasks) for tasks in orders]
    assert all(begin >= end for begin, end in zip(begun[1:], done, strict=False))


def test_without_pods_the_same_flows_are_single_loads():
    with_pods = dw.load(RING, {"tasks.flows.picks.arrivals": at((0, 3)), **THREE_OF})
    run = dw.simulate(with_pods.replace({"pods": None}), seed=1)
    assert not list(run.history.rows("lifted", "stored"))
    assert "pile_on" not in run.kpis
    assert run.kpis["tasks"] == 3


THREE_OF = {key.replace("__", "."): value for key, value in THREE.items()}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"pods.count": 4}, "4 pods for 3 storage places, expected at most 3"),
        ({"pods.per_pod": 2}, "2 items on a pod of 1 in all, expected at most those"),
        ({"pods.items": 2}, "2 items, 1 pod holds 1, expected at most as many"),
        ({"pods.popularity": "layout"}, "should be 'uniform'"),
        ({"pods.popularity": {"weights": [1, 2]}}, "2 weights for 1 item, expected one for each"),
        ({"tasks.flows.picks.to": "B"}, "pods are brought to stations beside nodes, and 'B' is in the lane"),
        ({"tasks.flows.picks.from": "D"}, "with pods a flow goes from storage to stations or from stations to storage"),
        ({"tasks.flows.picks.via": ["D"]}, "pods go from storage to a station and back"),
        ({"policies.batching": "by-order"}, "a robot carries one pod (got 'by-order'), expected single"),
        (
            {"tasks.flows.picks.arrivals": {"saturated": 5}, "tasks.flows.picks.stop_time": 0, "run.length": 60},
            "always open and picked in no time",
        ),
    ],
)
def test_what_cannot_be_is_refused(changes, message):
    with pytest.raises(ModelError) as error:
        dw.load(RING, changes)
    assert message in str(error.value)


WRONG = "class Wrong:\n    keeps = False\n\n    def choose(self, call):\n        return 'nowhere'\n"


@pytest.mark.parametrize("kind", ["pod", "storage", "order_station", "put"])
def test_an_answer_that_is_none_of_those_given_is_refused(tmp_path, kind):
    path = tmp_path / "wrong.py"
    path.write_text(WRONG)
    stations = {"pick": {"at": ["C"], "places": 5}, "other": {"at": ["D"], "places": 5}}
    flows = {
        "picks": {"from": "storage", "to": ["pick", "other"], "arrivals": at((0, 2)), "stop_time": 10},
        "bundles": {"from": "pick", "to": "storage", "arrivals": at((0, 1)), "stop_time": 5},
    }
    model = dw.load(RING, {"layout.stations": stations, "tasks.flows": flows, f"policies.{kind}": f"{path}:Wrong"})
    with pytest.raises(PolicyError, match=rf"policies\.{kind} \(Wrong\) at time .*none of those given"):
        dw.simulate(model)


@pytest.mark.slow
@pytest.mark.parametrize(("hours", "near"), [(9, 0.11), pytest.param(60, 0.04, marks=pytest.mark.long)])
def test_pile_on_of_one_slot_is_what_joins(hours, near):
    """One order of one line at a time, and a share p of pods that have an item: 1 / (1 - p), whatever the policy."""
    storage = [{"edge": ["A", "B"], "offset": 1 + 18 * n / 19} for n in range(20)]
    changes = {
        "layout.storage": storage,
        "pods": {"count": 20, "items": 10, "per_pod": 2, "orders": 1, "change_time": 0},
        "tasks.flows.picks.arrivals": {"saturated": 5},
        "run": {"length": f"{hours} h", "warm_up": "1 h"},
        "log": "tasks",
    }
    for pod in ("nearest", "most-lines", "random"):
        run = dw.simulate(dw.load(RING, {**changes, "policies.pod": pod}), seed=3)
        assert audit_pods(run) == []
        assert math.isclose(run.kpis["pile_on"], 1 / (1 - 0.2), rel_tol=near), pod


HALL = {
    "layout": {
        "blocks": {
            "columns": 5,
            "rows": 5,
            "block_width": 2,
            "block_depth": 4,
            "goods_size": 1,
            "aisle_width": 1,
            "directions": "ring",
        },
        "bays": {"parking": {"along": "north", "chargers": 0, "places": 20}},
        "stations": {"picking": {"at": ["r5c1", "r5c3"], "places": 9}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.35, "margin": 0.2, "speed": 1.5}},
    "tasks": {
        "load_time": 2.2,
        "unload_time": 2.2,
        "flows": {"picks": {"from": "storage", "to": "picking", "arrivals": {"saturated": 200}, "stop_time": 10}},
    },
    "pods": {"count": 170, "items": 100, "per_pod": 15, "orders": 12, "change_time": 0},
    "policies": {"parking": "nearest", "routing": "fastest", "storage": "own"},
    "run": {"length": "24 h", "warm_up": "1 h"},
    "log": "tasks",
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("runs", "length", "near"), [(1, "10 h", 0.085), pytest.param(10, "24 h", 0.02, marks=pytest.mark.long)]
)
@pytest.mark.parametrize(("pod", "lines"), [("random", 2.469), ("most-lines", 6.649)])
def test_pile_on_with_one_robot_is_that_of_the_closed_form(pod, lines, runs, length, near):
    """Of 1,000 items, so that open lines are of different ones. Those left after a visit are on fewer pods: 1.4 %."""
    model = dw.load(HALL, {"policies.pod": pod, "pods.items": 1000, "pods.per_pod": 150, "run.length": length})
    of_runs = [dw.simulate(model, seed).kpis["pile_on"] for seed in range(runs)]
    assert sum(of_runs) / runs == pytest.approx(lines, rel=near)


def test_a_pod_is_called_as_soon_as_its_station_opens():
    """The instant is met exactly: 30.747... and the wait from then on add up to a moment before it."""
    opens = 125.44290764140025
    hours = {"calendars.late": {"every": 1000, "lasts": 500, "first": opens}, "layout.stations.pick.hours": "late"}
    run = played([(30.747021393516384, 1)], **{key.replace(".", "__"): value for key, value in hours.items()})
    assert times(run, "assigned") == [opens]
