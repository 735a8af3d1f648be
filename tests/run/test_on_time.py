"""Which due times count, and as what: those in the counted time, its end included, once each.

In the square of `ring.py` a good is delivered 68 after the robot sets out, and the robot is home 60 later.
"""

import pytest

import desim_warehouse as dw
from desim_warehouse.answer.numbers import measured
from desim_warehouse.answer.text import table
from desim_warehouse.outcome.records import Deadline
from desim_warehouse.questions.run import words as run_words
from tests.run.ring import ring
from tests.run.test_work import GOODS, SLOW
from tests.world.test_flows import RING
from tests.world.test_hours import simulated

SHARES = "tasks_due", "on_time", "tardiness_mean"


def with_goods(*goods, length=None, warm_up=0.0, **changes):
    """The square with these goods, each a release and a due time; without a length up to the end of its work."""
    model = ring({}, 1000)
    del model["battery"], model["run"]
    model["tasks"]["goods"] = [
        {"good": 0, "release": release, **({} if due is None else {"due": due})} for release, due in goods
    ]
    run = {"run.length": length, "run.warm_up": warm_up} if length else {}
    return dw.simulate(dw.load(model, {**run, **changes}))


def counted(run):
    return tuple(run.kpis.get(name) for name in SHARES)


@pytest.mark.parametrize(
    ("due", "length", "warm_up", "expected"),
    [
        (80, 200, 50, (1, 1, 0)),  # done before it is due
        (68, 200, 50, (1, 1, 0)),  # done at the instant at which it is due
        (80, 200, 70, (1, 1, 0)),  # done in the warm-up, due after it
        (60, 200, 50, (1, 0, 8)),  # due and then done
        (50, 200, 50, (1, 0, 18)),  # due as the warm-up ends
        (49, 200, 50, (None, None, None)),  # due in the warm-up, done after it
        (60, 65, 0, (1, 0, 5)),  # due and not done: late up to the end
        (65, 65, 0, (1, 0, 0)),  # due at the very end and not done
        (68, 68, 0, (1, 1, 0)),  # due and done at the very end
        (69, 68, 0, (None, None, None)),  # done, and due after the end
        (66, 65, 0, (None, None, None)),  # not due yet
        (None, 200, 0, (None, None, None)),
    ],
)
def test_a_due_time_counts_where_it_falls_in_the_counted_time(due, length, warm_up, expected):
    run = with_goods((0, due), (1000, None), length=length, warm_up=warm_up)
    assert counted(run) == expected


def test_each_of_two_halves_of_a_run_has_its_own():
    """Nothing counts twice or is left out, wherever the warm-up ends."""
    goods = [(0, 60), (0, 500), (0, 130), (300, 380), (300, 340), (300, 2000), (400, 420), (500, 560)]
    for cut in range(1, 700, 21):
        first = with_goods(*goods, (1000, None), length=cut).history.deadlines
        second = with_goods(*goods, (1000, None), length=700, warm_up=cut).history.deadlines
        whole = with_goods(*goods, (1000, None), length=700).history.deadlines
        assert len(first) + len(second) == len(whole)
        assert sum(one.missed for one in (*first, *second)) == sum(one.missed for one in whole)


def test_a_run_that_ends_when_all_is_done_counts_all():
    """Two goods, delivered at 68 and, from the station on round the ring, 60 + 3 + 5 and 10 + 60 later."""
    run = with_goods((0, 60), (0, 10_000))
    assert counted(run) == (2, 0.5, 4)
    assert run.kpis["backlog"] == 0


def test_orders_that_are_overdue_and_not_done_are_late():
    """Ten at once, all due at 200, in a run of 400: those not done by its end are late by 200 so far."""
    run = with_goods(*[(0, 200)] * 10, length=400)
    done = [task.delivered for task in run.history.delivered]
    assert len(done) < 10
    in_time = sum(time <= 200 for time in done)
    assert counted(run)[:2] == (10, in_time / 10)
    late = [time - 200 for time in done if time > 200] + [200] * (10 - len(done))
    assert run.kpis["tardiness_mean"] == pytest.approx(sum(late) / 10)


def test_due_at_the_next_departure_counts_from_then_on():
    """Four tasks at 0 for the lorry at 150; one robot does one after the other, and not all by the end."""
    flow = {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 4}]}, "due_at": [150, 1000]}
    run = dw.simulate(dw.load(RING, {"tasks.flows": {"out": flow}, "run.length": 200}))
    done = [task.done for task in run.history.done]
    assert run.kpis["tasks_due:out"] == run.kpis["tasks_due"] == 4
    assert run.kpis["on_time:out"] == run.kpis["on_time"] == sum(time <= 150 for time in done) / 4
    assert len(done) < 4


def test_the_lorry_that_leaves_as_the_run_ends_is_missed_by_what_is_not_loaded():
    """Four tasks at 0, done one after the other: at the end at 200 as many stand on the floor as a moment before."""
    flow = {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 4}]}}
    for due, length in ((200, 200), (199.9, 200), (200, 200.1)):
        run = dw.simulate(dw.load(RING, {"tasks.flows": {"out": {**flow, "due_at": [due]}}, "run.length": length}))
        in_time = sum(task.done <= due for task in run.history.done)
        assert 0 < in_time < 4
        assert (run.kpis["tasks_due"], run.kpis["on_time"]) == (4, in_time / 4)
    late = dw.simulate(dw.load(RING, {"tasks.flows": {"out": {**flow, "due_at": [200.1]}}, "run.length": 200}))
    assert "on_time" not in late.kpis  # neither those done count, nor those that may be done until then


def test_what_is_due_soon_is_not_judged_by_what_was_quick():
    """Due within 120 of releases at 0 to 300, in a run of 300: those released after 180 count in no way."""
    flow = {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 20 * n, "tasks": 1} for n in range(15)]}}
    model = dw.load(RING, {"tasks.flows": {"out": {**flow, "due_within": 120}}, "run.length": 300})
    run = dw.simulate(model)
    counted = [task for task in run.history.tasks.values() if task.released <= 180]
    assert run.kpis["tasks_due"] == len(counted) == 10
    assert run.kpis["on_time"] == sum(task.done <= task.due for task in counted) / 10


def test_work_is_due_too():
    """Delivered at 65, 140 and 215, worked on until 165, 265 and beyond the end; due at 170, 170 and 220."""
    goods = [*GOODS[:2], {"good": 0, "due": 220}]
    for done_when, on_time in (("worked", 1 / 3), ("delivered", 1)):
        kpis = simulated({**SLOW, "tasks.goods": goods, "tasks.done_when": done_when}).kpis
        assert (kpis["loads_due"], kpis["worked_on_time"]) == (3, 1 / 3)
        assert (kpis["tasks_due"], kpis["on_time"]) == (3, on_time)


def test_what_is_due_before_it_is_put_down_is_late_for_the_workers_too():
    """At the end at 130 the second is on its way; the desk is the only place to which it can go."""
    kpis = simulated(
        {**SLOW, "tasks.goods": [{"good": 0, "due": 500}, {"good": 0, "due": 100}], "run.length": 130}
    ).kpis
    assert (kpis["loads_due"], kpis["worked_on_time"]) == (1, 0)
    assert (kpis["tasks_due"], kpis["on_time"]) == (1, 0)


def test_what_is_late_costs_as_often_as_it_is_late():
    prices = {"prices": {"hours": 1000, "late_order": 7}}
    run = with_goods(*[(0, 200)] * 10, length=400, **prices)
    late = run.kpis["tasks_due"] * (1 - run.kpis["on_time"])
    assert run.kpis["annual_cost"] == pytest.approx(1000 * 7 * late / (400 / 3600))
    warmed = with_goods((0, 49), (1000, None), length=200, warm_up=50, **prices)
    assert warmed.kpis["annual_cost"] == 0  # it came due in the warm-up


def test_an_order_is_late_from_the_first_of_its_tasks_that_is(tmp_path):
    """Task 1 of `a` is due at 10 and done after it, task 2 at 5000; nothing of `b` is due, and `c` is not done."""
    rows = "release,due,order\n0,10,a\n0,5000,a\n0,,b\n0,5000,c\n"
    (tmp_path / "orders.csv").write_text(rows, encoding="utf-8")
    flow = {"from": "dock", "to": "pack", "arrivals": {"orders": {"file": str(tmp_path / "orders.csv")}}}
    model = dw.load(RING, {"tasks.flows": {"day": flow}})
    whole = dw.simulate(model)
    assert (whole.kpis["orders_due"], whole.kpis["orders_on_time"]) == (2, 0.5)
    assert whole.history.order_deadlines[0] == Deadline(10, max(task.done for task in whole.history.orders[0].tasks))
    short = dw.simulate(model.replace({"run.length": 100}))
    assert (short.kpis["orders_due"], short.kpis["orders_on_time"]) == (1, 0)


def test_a_run_that_cannot_keep_up_does_not_begin_with_its_share_on_time():
    model = dw.load(RING, {"tasks.flows": {"out": flow(120)}, "run.length": 7200})
    run = dw.simulate(model, 1)
    first, *rest = run_words.sentences(run)
    assert "on time" not in first
    assert any(line.startswith("Cannot keep up") for line in rest)
    open_now = int(run.kpis["backlog"])
    assert f"Cycle times are those of finished loads: the {open_now} loads still open are not included." in rest
    assert not any("on time" in tile.what for tile in run_words.numbers_of(run))
    fine = dw.simulate(model.replace({"tasks.flows": {"out": flow(20)}}), 1)
    assert "on time" in run_words.sentences(fine)[0]
    assert not any("Cycle times" in line for line in run_words.sentences(fine))


def flow(rate):
    return {"from": "dock", "to": "pack", "arrivals": {"poisson": rate}, "due_within": 300}


def test_an_answer_says_what_a_design_delivers_that_cannot_keep_up_and_not_its_share_on_time():
    model = dw.load(RING, {"tasks.flows": {"out": flow(60)}, "run.length": 7200})
    study = dw.Study(model, {"fleet.size": [1, 3]}, replications=2, target="on_time >= 90 %").run(workers=1)
    option = study.results.answer.options[0]
    assert (option.standing, option.number) == ("overloaded", None)
    done, grown = study.results.table[["throughput_per_hour", "backlog_growth_per_hour"]][:2].mean()
    assert option.instead == f"only {measured(done)} of {measured(done + grown)} loads an hour delivered"
    assert not any(one.of.startswith(("on_time", "cycle_time")) for one in option.numbers)
    head, rows = table(study.results.answer.measures, study.results.answer.options)
    assert rows[0][head.index("done on time")] == option.instead
    alone = dw.Study(model, {"fleet.size": [1]}, replications=2, target="on_time >= 90 %").run(workers=1)
    assert "% (" not in alone.results.answer.answer[0]
    assert alone.results.answer.answer[0].endswith(f"{option.instead}.")


def test_only_indicators_that_depend_on_the_run_length_are_left_blank_for_a_design_that_cannot_keep_up():
    model = dw.load(RING, {"tasks.flows": {"out": flow(60)}, "run.length": 7200})
    names = ["share_idle", "throughput_per_hour", "cycle_time_mean", "on_time"]
    results = dw.Study(model, {"fleet.size": [1, 3]}, indicators=names).run(workers=1).results
    head, rows = table(results.answer.measures, results.answer.options)
    one, three = (dict(zip(head, row, strict=True)) for row in rows)
    assert "" not in (three[name] for name in results.answer.measures.values())
    assert [one[name] for name in ("fleet idle", "throughput")] == ["1.1 %", "39.5 tasks/h"]
    assert one["mean cycle time"] == one["done on time"] == ""
    assert results.answer.options[0].instead in rows[0]
    why = "Left blank where an option cannot keep up, as they depend on the length of the run: "
    assert f"{why}mean cycle time; done on time." in results.answer.notes
    measures = {"throughput_per_hour": "throughput", "share_idle": "fleet idle"}
    head, rows = table(measures, results.answer.options)  # deliveries are the throughput: they need no other column
    assert rows[0][: len(head)][1:3] == [results.answer.options[0].instead, "1.1 %"]
    text = str(results)
    assert text.count(results.answer.options[0].instead) == 1
