"""The one list of indicators, and the one list of states that it takes shares from."""

import math
from types import SimpleNamespace

import pytest

import desim_warehouse as dw
from desim_warehouse.answer import words
from desim_warehouse.outcome.indicators import INDICATORS, chosen, find, no_run_has
from desim_warehouse.outcome.log import COLUMNS, KINDS, STATES, LogRow
from desim_warehouse.outcome.measures import quantile
from desim_warehouse.questions.study import Study
from desim_warehouse.states import APART, TIMES, absent
from desim_warehouse.study.procedures import race
from tests import little
from tests.run.ring import RATES, ring
from tests.world.test_flows import RING

BATTERY = {"capacity": 1000, "threshold": 10, "consumption": RATES, "charge_rate": 10}


def test_the_indicators_of_a_run_that_can_be_worked_out_by_hand():
    """The good is loaded from 10 to 13, at its station at 63, delivered at 68 and was due at 60; home at 128.

    The other is released at 200, the end. Counted from 50 on: 150 of time, 13 loaded, 5 unloading, 60 returning, and
    in the bay 72; 18.2 of those it takes to charge 182. The battery holds 1000 - 10 - 4.5 - 74 = 911.5 at 50, 818 when
    the robot is home, and 1000 at the end.
    """
    model = ring(BATTERY, 200)
    model["tasks"]["goods"][0] = {"good": 0, "due": 60}
    model["run"]["warm_up"] = 50
    model["cost"] = {"distance": 2, "time": 3, "collisions": 5}
    got = dw.simulate(dw.load(model)).kpis
    assert {name: value for name, value in got.items() if not name.startswith("share_")} == pytest.approx(
        {
            "T": math.nan,  # the other is not delivered
            "S": 0,
            "C": 0,
            "tasks": 1,
            "moves": 2,
            "distance": 73,
            "energy": 13 * 2 + 5 * 1.5 + 60 * 1,
            "waiting": 0,
            "cost": 73 * 2 + 150 * 3,
            "rear_ends": 0,
            "crossings": 0,
            "rotations": 0,
            "throughput_per_hour": 1 / (150 / 3600),
            "cycle_time_mean": 68,
            "cycle_time_median": 68,
            "cycle_time_p95": 68,
            "backlog": 1,
            "tardiness_mean": 8,
            "on_time": 0,
            "tasks_due": 1,
            "energy_lowest": 0.818,
            "energy_drift_per_hour": (1 - 0.9115) / (150 / 3600),
            "charger_utilisation": 18.2 / 150,
            "robots_busy": (73 + 5 + 18.2) / 150,  # drives, handles and is charged
            "charger_wait": 0,
        },
        nan_ok=True,
    )
    shares = {"loaded": 13, "unloading": 5, "returning": 60, "charging": 18.2, "idle": 53.8}
    for state in TIMES.keys() - absent(dw.load(model)):
        assert got[f"share_{state}"] == pytest.approx(shares.get(state, 0) / 150)


def test_a_run_that_is_cut_off_says_that_its_work_is_not_done():
    run = dw.simulate("models/tutorial.yaml", seed=1, until=100)
    assert math.isnan(run.T)
    assert "The run ends before its work is done: 15 loads open at the end." in str(run)


def test_a_run_that_is_cut_off_before_all_its_work_has_come_has_no_task_time(tmp_path):
    """One good at 0, another after two hours: after one hour nothing is open, and still the work is not done."""
    model = dw.load("models/tutorial.yaml", {"tasks.goods": [{"good": 0}, {"good": 1, "release": 7200}]})
    run = dw.simulate(model, until=3600)
    assert "The run ends before its work is done: more was to come, or to return." in str(run)
    assert math.isnan(dw.load_run(run.save(tmp_path / "run")).T)
    assert 7200 < dw.simulate(model).T < math.inf


def test_a_run_that_is_cut_off_while_robots_return_has_no_task_time():
    whole = dw.simulate("models/tutorial.yaml", seed=1)
    delivered = max(task.delivered for task in whole.history.tasks.values())
    assert delivered < whole.T
    assert math.isnan(dw.simulate("models/tutorial.yaml", seed=1, until=(delivered + whole.T) / 2).T)


def test_a_run_that_is_cut_off_in_its_warm_up_says_so():
    model = dw.load("models/tutorial.yaml", {"run.warm_up": 600})
    assert [verdict.code for verdict in dw.simulate(model, until=60).verdicts] == ["ENDS_IN_WARM_UP"]


def two_in_turn(**changes):
    """Two robots of a battery of 1000 that start with 400 of it, in a bay with one charger, which gives 10 a second.

    The first is charged from 0 to 60 while the other queues and draws 30 standing, then that from 60 to 123. Both draw
    0.5 a second at rest after that, and the first drives for the last second. So they end with 954.5 and 986.5.
    """
    model = ring(BATTERY, 150, log="tasks")
    model["layout"]["bays"]["home"] |= {"places": 2, "chargers": 1}
    model["fleet"] |= {"size": 2, "start_energy": 0.4}
    model["tasks"]["goods"] = [{"good": 0, "release": 149}]
    return dw.load(model, changes)


def test_the_second_robot_waits_for_the_charger_while_the_first_is_charged():
    got = dw.simulate(two_in_turn()).kpis
    assert got["charger_wait"] == pytest.approx(60)
    assert got["charger_utilisation"] == pytest.approx(123 / 150)
    assert got["robots_busy"] == pytest.approx((123 + 60 + 1) / 300)  # charging, a queue for it, and a drive from 149
    assert got["energy_lowest"] == pytest.approx(0.37)
    assert got["energy_drift_per_hour"] == pytest.approx((554.5 + 586.5) / 2000 / (150 / 3600))
    assert "station_wait" not in got


def test_only_what_happens_after_the_warm_up_counts():
    """From 30 on: the first has 700 then, the other has waited, has 385, and waits for 30 more."""
    got = dw.simulate(two_in_turn(**{"run.warm_up": 30})).kpis
    assert got["charger_wait"] == pytest.approx(30)
    assert got["charger_utilisation"] == pytest.approx(93 / 120)
    assert got["energy_lowest"] == pytest.approx(0.37)
    assert got["energy_drift_per_hour"] == pytest.approx((254.5 + 601.5) / 2000 / (120 / 3600))


def test_the_second_robot_waits_for_the_server_while_the_first_is_unloaded():
    """Both take a good, the second 3 s after the first; it comes 3 s later to the server, which takes 30 s."""
    model = ring(BATTERY, 400, log="tasks")
    del model["battery"]
    model["layout"]["stations"] = {"desk": {"at": ["C"], "places": 2, "servers": 1}}
    model["fleet"]["size"] = 2
    model["tasks"] |= {"goods": [0, 0, {"good": 0, "release": 400}], "unload_time": 30}
    run = dw.simulate(dw.load(model))
    docked, served = ([row[0] for row in run.record.rows if row[1] == kind] for kind in ("docked", "unloading"))
    assert served[1] - served[0] == pytest.approx(30)
    assert run.kpis["station_wait"] == pytest.approx(served[1] - docked[1]) == pytest.approx(27, abs=1)
    assert not {"energy_lowest", "energy_drift_per_hour", "charger_wait", "charger_utilisation"} & run.kpis.keys()


def test_a_backlog_grows_by_what_arrives_and_is_not_delivered():
    run = dw.simulate(dw.load("models/tutorial.yaml", {"tasks.goods": {"poisson": 900}, "run": {"length": 3600}}))
    assert run.kpis["backlog_growth_per_hour"] == run.kpis["backlog"] > 0
    later = dw.simulate(dw.load(run.model.content(), {"run.warm_up": 1800}))
    at_half = sum(task.released < 1800 for task in later.history.tasks.values()) - sum(
        task.delivered < 1800 for task in later.history.delivered
    )
    assert later.kpis["backlog_growth_per_hour"] == 2 * (later.kpis["backlog"] - at_half)
    assert "backlog_growth_per_hour" not in dw.simulate(dw.load("models/tutorial.yaml")).kpis


def test_quantiles_lie_between_the_values_as_numpy_has_them():
    assert quantile([1, 2, 3, 4], 0.5) == 2.5
    assert quantile([10, 20], 0.95) == pytest.approx(19.5)
    assert math.isnan(quantile([], 0.5))


def test_every_state_has_its_row_its_share_and_its_words():
    assert list(STATES) == [name for name in TIMES if name not in {"waiting", *APART}]
    assert sorted(state.stacked for state in TIMES.values()) == list(range(len(TIMES)))
    for name, state in TIMES.items():
        assert INDICATORS[f"share_{name}"].title == f"Fleet {state.doing}"
        assert (name in KINDS) == (name != "waiting")


def test_every_column_of_the_log_is_described():
    assert tuple(COLUMNS) == LogRow._fields


def test_an_unknown_indicator_is_refused_with_the_nearest():
    with pytest.raises(dw.StudyError, match="there is none, did you mean 'cycle_time_mean'"):
        find("cycletime_mean")


@pytest.mark.parametrize(
    ("name", "condition"),
    [
        ("annual_cost", "only with `prices`"),
        ("on_time@11:30-13:00", "only where tasks have due times (`due`, `due_within` or `due_at`)"),
        ("distance_per_task", "only with `pods`"),
        ("waiting_closed", "only with `traffic.closures`"),
        ("worker_wait", "only where a station has `work_time`"),
    ],
)
def test_an_indicator_that_the_model_cannot_have_is_refused_with_what_it_takes(name, condition):
    with pytest.raises(dw.StudyError) as refused:
        chosen([name], ["T", "S", "C"])
    cure = "in the model file or by --set"
    assert str(refused.value) == f"indicator '{name}': no run has it; it is there {condition}, {cure}"


def test_what_an_indicator_takes_is_named_by_the_key_to_add():
    messages = [no_run_has(name, ["T"]) for name in INDICATORS]
    conditions = [condition for message in messages if (condition := message.partition("; it is there ")[2])]
    assert len(conditions) > 30
    assert [condition for condition in conditions if "`" not in condition] == []


def test_a_column_that_is_no_indicator_is_given_no_unit():
    assert words.indicator_label("T_hours", None) == "T_hours"
    assert words.indicator_label("run_time", None) == "Computing time of a run (s)"


def vary(sizes):
    return Study(dw.load("models/multibots.yaml"), {"fleet.size": sizes}, seed=1)


def test_the_best_share_of_waiting_is_the_smallest():
    assert not race(vary([1, 6]), "share_waiting", 0.01).maximise


def test_the_best_of_an_indicator_that_is_neither_good_nor_bad_needs_a_direction():
    with pytest.raises(dw.StudyError, match=r"'share_loaded': neither less nor more of it is better.* --minimise or"):
        race(vary([1, 6]), "share_loaded", 0.01)
    assert race(vary([1, 6]), "share_loaded", 0.01, maximise=True).maximise


def test_littles_law_on_a_case_worked_by_hand():
    """Open tasks over 100: one from 0 to 40, two to 60, one to 90: 40 + 40 + 30 = 110; cycle times 60 and 50: 110."""
    rows = [(0.0, "released", -1, 0), (40.0, "released", -1, 1), (60.0, "delivered", 0, 0), (90.0, "delivered", 0, 1)]

    def run(begin, end, kpis):
        record = SimpleNamespace(rows=[row for row in rows if row[0] <= end], begin=begin, end=end, flows={})
        flows = SimpleNamespace(tasks=SimpleNamespace(done_when="delivered", flows={}))
        return SimpleNamespace(record=record, kpis=kpis, model=flows, T=end)

    assert little.areas(run(0.0, 100.0, {"cycle_time_mean": 55.0})) == (110.0, 110.0)
    # counted from 50 to 80: 20 + 20 = 40; the first task took 60, of which 50 before, and the second is open for 30
    assert little.areas(run(50.0, 80.0, {"cycle_time_mean": 60.0})) == (40.0, 60.0 - 50.0 + 30.0)
    lost = run(0.0, 100.0, {"cycle_time_mean": 30.0})
    assert little.faults(lost) == ["tasks : L x time is 110.0, lambda x W x time 60.0"]


def test_batteries_that_end_as_they_began_have_no_drift():
    """What was drawn on the way was charged again before the end, but for rounding."""
    flow = {"from": "dock", "to": "pack", "arrivals": {"poisson": 30}}
    battery = {"capacity": 100, "threshold": 20, "consumption": 0.02, "charge_rate": 1}
    changes = {"battery": battery, "fleet.size": 2, "run.length": 3600}
    run = dw.simulate(dw.load(RING, {"tasks.flows": {"w": flow}, **changes}))
    assert run.record.energy == [100, 100]
    assert run.kpis["energy_drift_per_hour"] == 0
