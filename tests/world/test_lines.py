"""Lines of orders: each a task, known together, of one order; how many is drawn, and every hand figure counts them."""

from collections import Counter

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ModelError
from desim_warehouse.model.facts.demand import arrival_rate
from desim_warehouse.model.facts.peak import peak_rate
from desim_warehouse.model.sections.flows import in_words
from desim_warehouse.model.sections.lines import DiscreteLines, mean_lines
from desim_warehouse.world.world import World
from tests.world.test_flows import RING, first

pytestmark = pytest.mark.usefixtures("brief_probes")

ONE_TO_FIVE = {"discrete": {"values": [1, 2, 5], "weights": [6, 3, 1]}}


def model(lines, arrivals, **more):
    flow = {"from": "storage", "to": "pack", "arrivals": arrivals, "lines": lines, **more.pop("flow", {})}
    return dw.load(RING, {"tasks.flows": {"flow": flow}, **{key.replace("__", "."): it for key, it in more.items()}})


def test_an_order_of_two_lines_is_done_as_two_tasks():
    run = dw.simulate(model(2, {"schedule": [{"at": 10}]}, flow={"from": first(1), "due_within": 200}))
    released = list(run.history.rows("released"))
    assert [(row.time, row.task) for row in released] == [(10, 0), (10, 1)]
    # 20 to B, 10 along: 40, 44; 30 to D: 74, 80; A 100, B>C 130, 134; D 164, 170
    (order,) = run.history.orders
    assert [task.delivered for task in order.tasks] == [80, 170]
    assert order.done == 170
    assert run.kpis["orders"] == 1
    assert run.kpis["orders_due"] == 1
    assert run.kpis["orders_on_time"] == 1
    assert run.kpis["tasks"] == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lines", "mean"), [(3, 3), ([1, 4], 2.5), ([2, 2], 2), (ONE_TO_FIVE, 1.7), ({"discrete": {"values": [1, 3]}}, 2)]
)
@pytest.mark.parametrize(("count", "near"), [(1000, 0.06), pytest.param(4000, 0.03, marks=pytest.mark.long)])
def test_lines_are_drawn_for_each_order_as_often_as_they_should_be(lines, mean, count, near):
    one = model(lines, {"schedule": [{"at": 0, "tasks": count}]}, fleet__size=1, run__length=1)
    assert one.tasks.flows["flow"].mean_lines == pytest.approx(mean)
    orders = Counter(task.order for task in dw.simulate(one, seed=1).history.tasks.values())
    assert len(orders) == count
    assert sum(orders.values()) / count == pytest.approx(mean, rel=near)


def test_a_zero_weight_is_never_drawn():
    lines = DiscreteLines(discrete={"values": [1, 7], "weights": [1, 0]})
    assert mean_lines(lines) == 1


def test_a_run_of_drawn_lines_ends_when_all_are_done():
    run = dw.simulate(model([1, 4], {"schedule": [{"at": 0, "tasks": 5}, {"at": 50, "tasks": 5}]}), seed=2)
    assert len(run.history.orders) == 10
    assert len(run.history.delivered) == len(run.history.tasks)
    assert run.kpis["backlog"] == 0
    assert not run.model.is_deterministic
    assert model(3, {"schedule": [{"at": 0}]}, flow={"from": first(0)}).is_deterministic


def test_orders_are_released_until_so_many_tasks_are_open():
    run = dw.simulate(model(3, {"saturated": 4}, run__length=1), seed=1)
    assert len(run.history.tasks) == 6


def test_lines_of_an_order_have_one_priority():
    priority = [{"priority": 0, "share": 0.5}, {"priority": 9, "share": 0.5}]
    world = World(model(3, {"schedule": [{"at": 5, "tasks": 30}]}, flow={"priority": priority}), seed=4)
    world.run(until=6)
    of = {}
    for task in [*world.dispatcher.open.values(), *(robot.job for robot in world.robots if robot.job)]:
        of.setdefault(task.order, set()).add(task.priority)
    assert len(of) == 30
    assert all(len(priorities) == 1 for priorities in of.values())
    assert set.union(*of.values()) == {0, 9}


@pytest.mark.slow
def test_tours_by_order_take_the_lines_of_an_order():
    changes = {"fleet__robot__capacity": 3, "policies__batching": "by-order"}
    run = dw.simulate(model(3, {"schedule": [{"at": 0, "tasks": 4}]}, **changes), seed=1)
    trips = [{run.history.tasks[number].order for number in trip.tasks} for trip in run.history.trips]
    assert [len(orders) for orders in trips] == [1, 1, 1, 1]
    assert "CHANGES_NOTHING" not in {item.code for item in dw.check(run.model).findings}


def test_rates_count_orders_and_hand_figures_their_lines():
    profile = {"profile": {"per_hour": [20, 40], "every": 3600}}
    for arrivals, an_hour in (({"poisson": 30}, 75), (profile, 75), ({"schedule": [{"at": 5, "tasks": 60}]}, 75)):
        one = model([1, 4], arrivals, run__length=7200)
        assert arrival_rate(one) * 3600 == pytest.approx(an_hour)
    assert peak_rate(model([1, 4], profile, run__length=7200)) == pytest.approx(100)


@pytest.mark.slow
@pytest.mark.parametrize(("hours", "near"), [(20, 0.135), pytest.param(400, 0.03, marks=pytest.mark.long)])
def test_a_rate_of_orders_brings_as_many_lines_as_the_hand_figures_say(hours, near):
    """Three standard errors: an hour brings 75 lines, and their variance is 225."""
    run = dw.simulate(model([1, 4], {"poisson": 30}, run__length=hours * 3600, fleet__size=4), seed=1)
    assert len(run.history.tasks) / hours == pytest.approx(75, rel=near)


@pytest.mark.slow
def test_check_says_orders_lines_and_trips():
    facts = dw.check(model([1, 4], {"poisson": 40}, run__length=7200)).facts
    opening = "flow flow: 40 orders an hour of 2.5 lines on average: 100 lines, each a task, in "
    assert f"{opening}100 trips" in facts
    tours = {"fleet__robot__capacity": 2, "run__length": 7200}
    # 1, 2, 3 or 4 lines are 1, 1, 2 or 2 trips of two
    facts = dw.check(model([1, 4], {"poisson": 40}, **tours, policies__batching="by-order")).facts
    assert f"{opening}60 trips" in facts
    facts = dw.check(model([1, 4], {"poisson": 40}, **tours, policies__batching="fixed-size")).facts
    assert f"{opening}at least 50 trips" in facts
    assert in_words(model(2, {"poisson": 40}, run__length=60).tasks.flows["flow"], 1) == (
        "storage to D, 40 orders an hour, 2 lines each"
    )


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (0, "lines"),
        (True, "lines"),
        (1.5, "lines"),
        ([4, 1], "the least is above the most (got [4, 1]), expected [least, most]"),
        ({"discrete": {"values": [1, 2], "weights": [1]}}, "1 weights for 2 values, expected one for each"),
        ({"discrete": {"values": [1, 2], "weights": [0, 0]}}, "all weights are 0, expected one above 0"),
        ("many", "should be a whole number, [least, most], or {discrete: {values: [1, 2], weights: [3, 1]}}"),
    ],
)
def test_wrong_lines_are_refused_at_their_place(lines, message):
    with pytest.raises(ModelError, match=r"tasks\.flows\.flow\.lines") as error:
        model(lines, {"poisson": 40}, run__length=60)
    assert message in str(error.value)


def test_lines_beside_what_counts_tasks_are_refused(tmp_path):
    path = tmp_path / "orders.csv"
    path.write_text("release\n0\n")
    with pytest.raises(ModelError, match=r"lines of an order beside arrivals, which counts rows, each a line already"):
        model(2, {"orders": {"file": str(path)}})
    pairs = [{"from": "dock", "to": "pack", "per_hour": 5}]
    flow = {"from_to": pairs, "lines": 2}
    with pytest.raises(ModelError, match="lines of an order beside from_to, which counts tasks, not orders"):
        dw.load(RING, {"tasks.flows": {"flow": flow}, "run.length": 60})
