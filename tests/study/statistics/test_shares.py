"""Shares of tasks: bounds worked by hand, the law of better days, and how often verdicts and intervals are right."""

import math
import statistics
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import beta

from desim_warehouse.outcome.indicators import counted_in
from desim_warehouse.outcome.targets import parse_target
from desim_warehouse.study.statistics.intervals import TaskShare, estimate, share_bounds, tasks_of
from desim_warehouse.study.statistics.judge import judged
from tests.daily import some
from tests.study.statistics.coverage import ON_TIME, verdict, wrongly_met, wrongly_missed

HALVES = (10, 20, 40, 80)
SURE = 1 - 0.05 / 12  # what `Judge` asks of the first design and six looks


def of(shares, tasks=60):
    return [TaskShare(share, tasks) for share in shares]


def test_days_without_a_late_task_count_tasks_and_not_days():
    """Ten days of 60 tasks: 600 over 1 + 59 x 0.04 = 3.36 are 178.6 tasks, of which none was late: 0.025^(1/178.6)."""
    low, high = share_bounds(np.ones(10), np.full(10, 60.0), 0.975)
    assert low == pytest.approx(0.025 ** (3.36 / 600))
    assert high == 1.0
    assert low > 0.97  # the day as a coin: 1 - 0.31


def test_many_days_show_themselves_how_much_tasks_depend_on_each_other():
    """80 days of 60 tasks: 4,800 over 1 + 59 x 0.04 x 18 / 80 = 1.531 are 3,135, not the 1,429 of eight times ten."""
    low, _ = share_bounds(np.ones(80), np.full(80, 60.0), 0.975)
    assert low == pytest.approx(0.025 ** (1.531 / 4800))
    reach = [0.96 - share_bounds(np.array([0.95, 0.97] * half), np.full(2 * half, 800.0), 0.99)[0] for half in HALVES]
    assert [round(100 * one, 2) for one in reach] == [0.71, 0.41, 0.28, 0.19]


def test_from_18_days_on_they_may_show_that_they_differ_little():
    """80 days of 0.95, 0.97: s² / 80 = 1.266e-6, times (2.374 / 2.326)²: 0.0384 / 1.318e-6 are 29,130 tasks."""
    days = np.array([0.95, 0.97] * 40)
    low, _ = share_bounds(days, np.full(80, 7000.0), 0.99)
    assert low == pytest.approx(beta.ppf(0.01, 0.96 * 29_130, 0.04 * 29_130 + 1), abs=3e-4)
    eighteen, _ = share_bounds(days[:18], np.full(18, 7000.0), 0.99)
    sixteen, _ = share_bounds(days[:16], np.full(16, 7000.0), 0.99)  # at most 25 tasks a day
    assert sixteen == pytest.approx(beta.ppf(0.01, 0.96 * 400, 0.04 * 400 + 1), abs=2e-3)
    assert eighteen > sixteen + 0.01


def test_where_nearly_all_is_on_time_days_do_not_show_how_they_differ():
    """Eighteen of 0.997 to 0.999 count for 450 tasks still, of which 0.9 are missed: fewer than five."""
    low, _ = share_bounds(np.array([0.997, 0.999] * 9), np.full(18, 7000.0), 0.99)
    assert low == pytest.approx(beta.ppf(0.01, 449.1, 1.9), abs=2e-4)


def test_the_upper_bound_of_days_that_vary_less_than_tasks_is_that_of_tasks():
    """Five days of 0.9 and five of 0.94, of 60 tasks: they vary less than 600 tasks would that depend on nothing."""
    shares = np.array([0.9, 0.94] * 5)
    _, high = share_bounds(shares, np.full(10, 60.0), 0.975)
    assert high == pytest.approx(beta.ppf(0.975, 0.92 * 600 + 1, 0.08 * 600), abs=1e-6)


def test_days_that_vary_more_are_worth_fewer_tasks():
    """Half at 0.7, half at 1: s² / 10 = 0.0025, times (2.262 / 1.960)²: 0.1275 / 0.00333 = 38.3 tasks, not 179."""
    low, _ = share_bounds(np.array([0.7, 1.0] * 5), np.full(10, 60.0), 0.975)
    assert low == pytest.approx(beta.ppf(0.025, 0.85 * 38.3, 0.15 * 38.3 + 1), abs=1e-3)


def test_each_day_counts_alike_however_many_tasks_it_has():
    assert estimate([TaskShare(1.0, 50), TaskShare(0.9, 150)]).mean == pytest.approx(0.95)


def test_no_interval_of_a_share_leaves_what_is_possible():
    low, high = estimate(of([1.0, 1.0])).interval
    assert 0.8 < low < high == 1.0


def test_what_was_done_or_came_due_is_what_is_counted():
    run = {"tasks", "tasks:out", "tasks_due", "tasks_due:out", "loads_due", "orders_due", "on_time:out"}
    assert counted_in("on_time", run) == ["tasks_due"]
    assert counted_in("on_time:out", run) == ["tasks_due:out"]
    assert counted_in("worked_on_time", run) == ["loads_due"]
    assert counted_in("orders_on_time", run) == ["orders_due"]


def test_in_runs_before_0_4_the_tasks_of_flows_with_due_times_are_counted():
    run = {"tasks", "tasks:in", "tasks:out", "on_time", "on_time:out", "orders_on_time", "share_waiting"}
    assert counted_in("on_time", run) == ["tasks:out"]
    assert counted_in("on_time:out", run) == ["tasks:out"]
    assert counted_in("on_time", {"tasks", "on_time"}) == ["tasks"]
    assert counted_in("orders_on_time", run) == ["orders"]
    assert counted_in("share_waiting", run) == []


DAYS = st.one_of(
    *(
        st.lists(st.tuples(st.floats(0, 1), st.integers(1, 400)), min_size=few, max_size=many)
        for few, many in ((2, 12), (18, 20))
    )
)
LEVELS = st.sampled_from([0.9, 0.975, SURE])


@given(DAYS, st.data(), LEVELS)
def test_no_bound_falls_where_a_day_gets_better(days, data, level):
    shares, tasks = np.array([share for share, _ in days]), np.array([float(count) for _, count in days])
    better = shares.copy()
    day = data.draw(st.integers(0, len(days) - 1))
    better[day] = data.draw(st.floats(float(shares[day]), 1))
    for before, after in zip(share_bounds(shares, tasks, level), share_bounds(better, tasks, level), strict=True):
        assert after >= before - 1e-9


@given(
    st.lists(st.integers(80, 100), min_size=2, max_size=12),
    st.data(),
    st.sampled_from([0.85, 0.9, 0.95, 0.99]),
    st.sampled_from([0.0, 0.005, 0.01, 0.05]),
)
def test_a_better_day_never_turns_meets_into_anything_else_nor_open_into_fails(late, data, value, zone):
    target = parse_target(f"on_time >= {value}")
    better = list(late)
    day = data.draw(st.integers(0, len(late) - 1))
    better[day] = data.draw(st.integers(late[day], 100))
    before, after = (
        judged("", of([share / 100 for share in shares], 100), target, 0.9, False, (0, 1), zone).verdict
        for shares in (late, better)
    )
    order = ["fails", "undecided", "meets"]
    assert order.index(after) >= order.index(before)


@given(
    st.lists(st.integers(0, 60), min_size=2, max_size=14),
    st.data(),
    st.integers(10, 50),
    st.sampled_from([0.0, 1.0, 5.0]),
)
def test_of_other_indicators_a_better_day_never_turns_meets_into_fails(values, data, value, zone):
    target = parse_target(f"throughput_per_hour >= {value}")
    better = list(values)
    day = data.draw(st.integers(0, len(values) - 1))
    better[day] = data.draw(st.integers(values[day], 500))
    before, after = (
        judged("", list(map(float, days)), target, 0.9, False, (0, np.inf), zone).verdict for days in (values, better)
    )
    assert (before, after) != ("meets", "fails")


def test_a_run_that_alone_leaves_a_verdict_open_is_named():
    target = parse_target("throughput_per_hour >= 100")
    calm = [101.0, 102.0, 101.5, 102.5, 101.2, 102.2, 101.8, 102.1, 101.4]
    assert judged("", calm, target, 0.975, False, (0, np.inf)).verdict == "meets"
    judgement = judged("", [*calm[:4], 260.0, *calm[4:]], target, 0.975, False, (0, np.inf))
    assert (judgement.verdict, judgement.outlier) == ("undecided", 4)
    assert judged("", [90.0, 110.0] * 4, target, 0.975, False, (0, np.inf)).outlier is None
    four = [101.0, 101.1, 101.2, 101.1]
    # of five one may be named, of four none
    assert [judged("", [*four[:n], 260.0], target, 0.975, False, (0, np.inf)).outlier for n in (4, 3)] == [4, None]


HOW_OFTEN = pytest.mark.parametrize(
    ("tasks", "target", "alike", "studies"),
    [
        (50, 0.95, 0.1, 60),
        (50, 0.99, 0.01, 60),
        *(pytest.param(*one, 100, marks=pytest.mark.long) for one in product((50, 1000), (0.95, 0.99), (0.01, 0.1))),
    ],
)


@HOW_OFTEN
def test_a_design_that_just_misses_is_said_to_meet_in_at_most_5_per_cent_of_studies(tasks, target, alike, studies):
    # 5 %, and a standard error
    assert wrongly_met(target, tasks, alike, studies) <= 0.05 + math.sqrt(0.05 * 0.95 / studies)


@HOW_OFTEN
def test_a_design_that_is_better_by_the_zone_is_said_to_miss_in_at_most_5_per_cent_of_studies(
    tasks, target, alike, studies
):
    assert wrongly_missed(target, tasks, alike, studies) <= 0.05


def test_days_of_many_tasks_tell_of_a_miss_by_one_point_in_few_runs():
    """The days of a hall with 7,000 orders differ by 0.65 points: five tell, and not twenty if each counted as 25."""
    shares = np.array([0.8986, 0.8824, 0.8877, 0.8951, 0.8929])
    assert judged("", of(shares, 7000), parse_target("on_time >= 0.9"), SURE, False, (0, 1), 0.01).verdict == "fails"


@pytest.mark.parametrize(
    ("tasks", "alike", "studies"),
    [(50, 0.1, 40), *(pytest.param(*one, 100, marks=pytest.mark.long) for one in product((50, 1000), (0.01, 0.1)))],
)
def test_a_design_beyond_the_zone_fails_in_at_most_5_per_cent_of_studies_and_a_bad_one_never_meets(
    tasks, alike, studies
):
    rng = np.random.default_rng(tasks)
    assert [verdict(rng, 0.9775, 0.97, tasks, alike) for _ in range(studies)].count("fails") <= 0.05 * studies
    bad = [verdict(rng, 0.9, 0.95, tasks, alike) for _ in range(40)]
    assert "meets" not in bad
    assert bad.count("fails") >= 36


@pytest.mark.parametrize("case", some(ON_TIME, 3), ids=str)
def test_95_per_cent_intervals_of_shares_cover(case):
    assert case.covered(400) >= 0.93


def test_a_share_of_tasks_is_a_number_for_all_who_reckon_with_it():
    days = [TaskShare(0.9, 100), TaskShare(0.8, 300)]
    assert statistics.mean(days) == pytest.approx(0.85)
    assert tasks_of([statistics.mean(days)]) is None
    assert tasks_of(days).tolist() == [100, 300]
