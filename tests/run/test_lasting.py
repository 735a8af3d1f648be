"""Whether a run keeps up: proved by what is asked of each resource and by what is left open, or not said."""

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.run import words
from desim_warehouse.questions.run.lasting import lasting
from tests.run.halls import RING

pytestmark = pytest.mark.usefixtures("brief_probes")

CHARGED = {
    "battery": {"capacity": 720_000, "consumption": 1, "charge_rate": 0.3},
    "layout.bays": {"parking": {"at": ["D"], "places": 10, "chargers": 1}},
    "tasks.unload_time": 10,
    "policies.charging": "four-thresholds",
}
"""Six robots that draw 1 each, and a charger that gives 0.3."""


def hall(**changes):
    return dw.load(RING, {key.replace("__", "."): value for key, value in changes.items()})


def said(model, seed=1):
    return next(line for line in words.sentences(dw.simulate(model, seed)) if "keep" in line)


@pytest.mark.parametrize("rate", [31, 32, 33])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_queue_that_grows_without_bound_by_the_check_does_not_keep_up(rate, seed):
    """The growth of 8 hours, 1 to 3 tasks an hour, stays below three standard errors of 250 arrivals."""
    line = said(hall(tasks__goods={"poisson": rate}), seed)
    assert line.startswith("8 h do not show whether the warehouse keeps up: ")
    assert f"({100 * rate / 30:.1f} % of the capacity of the packers)" in line


def test_nothing_is_shown_by_a_packer_who_is_always_busy():
    """29.5 of 30: the queue of such a packer is long before it is stationary, which takes days."""
    line = said(hall(tasks__goods={"poisson": 29.5}))
    assert line.endswith(", and demand is 98.7 % of the capacity of the packers.")


@pytest.mark.parametrize("rate", [15, 21, 24])
def test_what_has_time_to_spare_keeps_up(rate):
    assert said(hall(tasks__goods={"poisson": rate})).startswith("The warehouse keeps up: ")


def test_workers_behind_a_station_count():
    """Put down in 10 s, worked on for 2 minutes: 30 an hour, too."""
    line = said(hall(tasks__unload_time=10, layout__stations__packing__work_time=120, tasks__goods={"poisson": 29.5}))
    assert line.endswith(", and demand is 98.6 % of the capacity of the packers.")


def test_robots_count():
    """A round of 60 m takes one robot 40 s, loading and unloading 20 s: 60 an hour, of which 58 are asked for."""
    one = {"fleet__size": 1, "tasks__unload_time": 10}
    assert "of the capacity of the robots" in said(hall(tasks__goods={"poisson": 58}, **one))
    assert said(hall(tasks__goods={"poisson": 30}, **one)).startswith("The warehouse keeps up: ")


def test_chargers_count_before_batteries_are_low():
    """Full batteries of 200 hours of work hide in a run of half an hour that they are not filled again."""
    model = dw.load(RING, {**CHARGED, "tasks.goods": {"poisson": 60}, "run.length": 1800})
    assert "by the check demand exceeds capacity" in said(model)


def test_a_backlog_that_grew_by_more_than_the_root_of_the_arrivals_is_no_proof():
    """Half of the load, and a run that ends with its peak: 52 an hour in the last of four, where 30 are done."""
    profile = {"profile": {"per_hour": [6, 6, 6, 52]}}
    flows = {"orders": {"from": "storage", "to": "packing", "arrivals": profile}}
    tasks = {"flows": flows, "load_time": 10, "unload_time": 120}
    run = dw.simulate(dw.load(RING, {"tasks": tasks, "run.length": "4 h"}), 1)
    judged = lasting(run)
    assert judged.grown > judged.allowed
    assert not judged.keeps_up
    assert any("more are waiting for a robot than when counting began" in line for line in words.sentences(run))


def test_a_day_that_keeps_up_by_its_end_says_so_of_its_peak():
    """75 an hour in the second of six hours, where one robot does 60."""
    profile = {"profile": {"per_hour": [6, 75, 6, 6, 6, 6]}}
    flows = {"orders": {"from": "storage", "to": "packing", "arrivals": profile}}
    tasks = {"flows": flows, "load_time": 10, "unload_time": 10}
    line = said(dw.load(RING, {"tasks": tasks, "run.length": "6 h", "fleet.size": 1}))
    assert line.startswith("The warehouse keeps up by the end, but not in the busiest hour: ")


def test_tasks_that_robots_have_in_hand_are_no_backlog():
    """Six robots with a task each after ten minutes, from none at the start: no queue."""
    run = dw.simulate(hall(tasks__goods={"poisson": 24}, run__length=1200), 3)
    assert lasting(run).grown == 0


def test_work_that_is_given_is_not_judged():
    run = dw.simulate(hall(tasks__goods={"random": 5}, run__length=None), 0)
    assert lasting(run) is None
    assert not any("keep" in line for line in words.sentences(run))


def test_a_saved_run_says_the_same(tmp_path):
    model = hall(tasks__goods={"poisson": 32})
    run = dw.simulate(model, 1)
    assert words.sentences(dw.load_run(run.save(tmp_path / "run"))) == words.sentences(run)


def test_where_the_model_cannot_be_checked_nothing_is_claimed(monkeypatch):
    """As of a saved run whose file of orders is no longer there."""

    def gone(_):
        raise dw.ModelError(["orders.csv: cannot be read (no such file)"])

    run = dw.simulate(hall(tasks__goods={"poisson": 15}), 1)
    monkeypatch.setattr("desim_warehouse.questions.run.lasting.examined", gone)
    (line,) = [line for line in words.sentences(run) if "keep" in line]
    assert line.endswith(", and its model cannot be checked: orders.csv: cannot be read (no such file).")
