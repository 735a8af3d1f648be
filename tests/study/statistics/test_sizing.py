"""The smallest design that meets a target, and how a target is read."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.errors import StudyError
from desim_warehouse.outcome.indicators import INDICATORS
from desim_warehouse.outcome.targets import Target, parse_target
from desim_warehouse.study.statistics.cheapest import cheapest_meeting_steps
from desim_warehouse.study.statistics.intervals import TaskShare
from desim_warehouse.study.statistics.judge import Judge, judged, runs_to_tell
from tests.study.statistics.searches import sizing_steps, smallest, up_to


def noisy(mean):
    """Replications that lie 1 above and 1 below the mean in turn: sd of ten is 1.054."""
    return lambda value, r: mean(value) + (1.0 if r % 2 else -1.0)


@pytest.mark.parametrize(
    ("text", "target"),
    [
        ("throughput_per_hour >= 220", Target(INDICATORS["throughput_per_hour"], ">=", 220.0)),
        ("T<95.5", Target(INDICATORS["T"], "<", 95.5)),
        ("  charger_utilisation ≤ .8 ", Target(INDICATORS["charger_utilisation"], "<=", 0.8)),
        ("C > -1e-3", Target(INDICATORS["C"], ">", -0.001)),
        ("on_time:express >= 95%", Target(INDICATORS["on_time"].of(":", "express"), ">=", 0.95)),
    ],
)
def test_targets_are_read(text, target):
    assert parse_target(text) == target


@pytest.mark.parametrize("text", ["", "T", "T >=", ">= 3", "T = 3", "T >= three", "2T >= 3", "T >= nan"])
def test_a_target_that_cannot_be_read_says_what_was_expected(text):
    with pytest.raises(StudyError, match="as in 'throughput_per_hour >= 220'"):
        parse_target(text)


def test_an_unknown_indicator_is_answered_by_the_nearest_one():
    with pytest.raises(StudyError, match="did you mean 'throughput_per_hour'"):
        parse_target("thruput_per_hour >= 1")
    with pytest.raises(StudyError, match=r"unknown indicator 'qqqq', expected one of T, S, C, tasks"):
        parse_target("qqqq >= 1")


def test_a_mean_on_the_bound_meets_it_only_if_the_bound_is_included():
    assert parse_target("T >= 3").met_by(3.0)
    assert parse_target("T <= 3").met_by(3.0)
    assert not parse_target("T > 3").met_by(3.0)
    assert not parse_target("T < 3").met_by(3.0)


@given(st.sampled_from([">=", "<=", ">", "<"]), st.integers(-(10**6), 10**6))
def test_a_target_reads_back_what_it_prints(sense, value):
    target = Target(INDICATORS["throughput_per_hour"], sense, value / 64)
    assert parse_target(str(target)) == target


def test_a_search_followed_by_hand():
    # 10 per robot, target 45 from 1..8: a single run of 4, 6 and 5 says that 5 is the first; 4 is its neighbour
    result = smallest(noisy(lambda v: 10.0 * v), range(1, 9), "throughput_per_hour >= 45")
    assert result.smallest == 5
    assert [(d.value, d.verdict) for d in result.decisions] == [(5, "meets"), (4, "fails")]
    assert (result.below.value, result.below.verdict) == (4, "fails")
    # 33 runs of the one that is named, five of the other, and five of 6 robots, which might do worse
    assert result.runs == 43
    # the first design has half of the error of seven looks (5 8 12 18 33 50 80): its bounds are at 1 - 0.05/14
    assert result.decisions[0].level == pytest.approx(1 - 0.05 / 14)
    # t(32 df, 0.996429) = 2.874; of 33 values -1, 1, ... -1 the mean is -1/33 and sd 1.0150: 49.970 - 2.874 * 1.0150 /
    # sqrt(33), and their skewness of 0.06, over sqrt(33), moves it by 0.005
    assert result.decisions[0].low == pytest.approx(49.9697 - 2.8741 * 0.17669 + 0.0053, abs=1e-3)
    assert result.falls == ()


def test_a_design_that_meets_it_only_as_counted_is_passed_over():
    result = smallest(
        noisy(lambda v: 10.0 * v),
        range(1, 9),
        "throughput_per_hour >= 45",
        veto=lambda number: "batteries fall" if number == 4 else None,
    )
    assert result.smallest == 6
    assert [(d.value, d.verdict) for d in result.decisions] == [(5, "fails"), (6, "meets")]
    assert result.vetoed == ((5, "batteries fall"),)


def test_a_mean_near_the_target_is_looked_at_again():
    # margin of five values 2.4 (above): 0.5 from the target needs more of them
    result = smallest(noisy(lambda v: 10.0 * v + 0.5), range(1, 9), "throughput_per_hour >= 50", cap=320)
    decided = {d.value: d for d in result.decisions}
    assert result.smallest == 5
    assert decided[5].n > 5
    assert decided[5].low > 50


@pytest.mark.parametrize(("above", "runs"), [(0.0, 8), (0.2, 18), (0.5, 40)])
def test_a_mean_on_the_target_stays_undecided_for_as_long_as_further_runs_may_tell(above, runs):
    """At level 1 - 0.05/36 the half-width of 40 values is 3.2 * 1.01 / sqrt(40) = 0.51.

    After eight values, with a standard deviation of 1.07, the mean of 40 lies with 90 % probability below their mean by
    1.28 * 1.07 * sqrt(1/8 - 1/40) = 0.43 more: too little for a mean on the target, enough for one 0.2 above it.
    """
    result = smallest(noisy(lambda v: 10.0 * v + above), range(1, 9), "throughput_per_hour >= 50", cap=40)
    assert result.smallest == 6
    assert (result.below.value, result.below.verdict, result.below.n) == (5, "undecided", runs)


def test_less_can_be_better():
    result = smallest(noisy(lambda v: 100.0 / v), range(1, 40), "cycle_time_mean <= 13.4")
    assert result.smallest == 8


def test_no_design_may_be_enough():
    result = smallest(noisy(lambda v: 10.0 * v), range(1, 9), "throughput_per_hour >= 1000")
    assert result.smallest is None
    assert (result.below.value, result.below.verdict) == (8, "fails")


def test_the_very_first_design_may_be_enough():
    result = smallest(noisy(lambda v: 10.0 * v), range(1, 9), "throughput_per_hour >= 1")
    assert (result.smallest, result.below) == (1, None)


def test_where_more_does_worse_every_value_is_judged_and_that_is_said():
    # best at 20 robots, then they block one another: of 30, 45, 53, ... a single run fails, and the largest, too
    def response(v):
        return 200.0 - abs(v - 20)

    for scan in (False, True):
        sizing = smallest(
            lambda v, r: response(v) + ((7 * r + 5 * v) % 11 - 5) / 5,
            range(1, 61),
            "throughput_per_hour >= 195.1",
            scan=scan,
            cap=320,
        )
        assert sizing.smallest == 16
        assert [one.value for one in sizing.decisions if one.value < 17] == list(range(1, 17))
        assert sizing.falls == (() if scan else ((30, 60),))


def test_a_fall_within_the_noise_is_no_fall():
    # ten replications are the digits 0..9, in another order for each design; the means fall by 0.01 each
    sizing = smallest(lambda v, r: (7 * v + 3 * r) % 10 - 0.01 * v, range(1, 9), "throughput_per_hour >= 19")
    assert (sizing.smallest, sizing.falls) == (None, ())


def test_the_last_look_is_at_the_cap():
    result = smallest(noisy(lambda v: 50.0), [1], "throughput_per_hour >= 49.6", first=10, cap=26)
    assert (result.decisions[0].verdict, result.runs) == ("undecided", 26)


def test_one_run_of_a_deterministic_model_is_exact():
    result = smallest(lambda v, r: 10.0 * v, range(1, 9), "T >= 50", deterministic=True)
    assert (result.smallest, result.runs) == (5, 3)  # 5, 4, and 6, which might do worse
    assert all(d.deterministic and d.n == 1 and d.low is None and d.high is None for d in result.decisions)


def test_equal_replications_are_not_taken_as_exact():
    # level 1 - 0.05/22, 11 looks: of 50 equal runs 11 %, of 75 7.8 % may differ, by as much as the value
    result = smallest(lambda v, r: 10.0 * v, range(1, 9), "T >= 45", cap=320)
    assert [(d.value, d.n) for d in result.decisions] == [(5, 75), (4, 75)]
    assert result.smallest == 5
    assert not any(d.deterministic for d in result.decisions)


def test_a_rare_event_that_was_not_seen_yet_does_not_meet_a_bound_on_it():
    # 1 - 0.0023^(1/n) may happen: 70 % after 5 runs, 2.4 % after 255, 1.9 % after 320 (11 looks, half of the error)
    result = smallest(lambda v, r: 0.0, [1], "rotations <= 0.02", within=(0.0, math.inf), cap=320)
    assert (result.smallest, result.runs) == (1, 320)
    assert result.decisions[0].low == 0.0
    assert smallest(lambda v, r: 0.0, [1], "rotations <= 0").decisions[0].verdict == "undecided"


def test_the_steps_ask_for_a_glance_then_for_whole_looks():
    steps = sizing_steps([5, 6, 7], Judge(parse_target("T >= 1"), first=4, days=up_to(6)), {0})
    assert next(steps) == [(1, 0), (1, 1), (1, 2)]
    assert steps.send([3.0, 4.0, 5.0]) == [(1, 3)]
    assert steps.send([4.0]) == [(1, 4), (1, 5)]


@pytest.mark.parametrize(
    ("values", "options", "message"),
    [
        ([], {}, "at least one"),
        ([1, 2], {"first": 1}, "2 <= first <= cap"),
        ([1, 2], {"first": 20, "cap": 10}, "2 <= first <= cap"),
        ([1, 2], {"zone": -1}, "zone -1: expected one from 0"),
        ([1, 2], {"confidence": 95}, "did you mean 0.95"),
    ],
)
def test_searches_that_make_no_sense_are_refused(values, options, message):
    with pytest.raises(StudyError, match=message):
        smallest(lambda v, r: 0.0, values, "T >= 1", **options)


def test_no_design_is_there_twice():
    with pytest.raises(StudyError, match="none twice"):
        next(cheapest_meeting_steps([(1,), (2,), (1,)], tuple, Judge(parse_target("T >= 1"))))


def test_a_run_without_a_value_is_named():
    with pytest.raises(StudyError, match="design 1, replication 0: nan"):
        smallest(lambda v, r: math.nan, [1, 2, 3], "T >= 1")


@given(st.lists(st.integers(0, 9), min_size=1, max_size=40), st.integers(0, 200), st.sampled_from([">=", ">"]))
def test_halving_finds_what_trying_all_finds(steps, bound, sense):
    response = np.cumsum(steps).astype(float).tolist()
    values = range(len(response))
    target = Target(INDICATORS["T"], sense, float(bound))
    result = smallest(lambda v, r: response[v], values, target, deterministic=True)
    assert result.smallest == next((v for v in values if target.met_by(response[v])), None)
    assert result.runs <= 4  # the answer, its neighbours, or the largest and one of half its size
    assert result.falls == ()
    if result.smallest:
        assert (result.below.value, result.below.verdict) == (result.smallest - 1, "fails")


def test_so_many_runs_as_are_said_to_tell_do_in_five_of_six_studies():
    """Six runs of mean 100 and sd 10 leave 97 open. If 100 and 10 are true, the runs that it names mostly tell."""
    six = [90.0, 110.0, 95.0, 105.0, 100 - 125**0.5, 100 + 125**0.5]
    assert np.std(six, ddof=1) == pytest.approx(10)
    target = parse_target("T >= 97")
    assert judged("", six, target, 0.975, False, (0, math.inf)).verdict == "undecided"
    runs = runs_to_tell(six, target, 0.975, (0, math.inf))
    assert runs == 100  # where the half-width of t, 1.98 * 10 / 10, is two thirds of the distance of 3
    studies = np.random.default_rng(1).normal(100, 10, (300, runs))
    told = [judged("", study.tolist(), target, 0.975, False, (0, math.inf)).verdict == "meets" for study in studies]
    assert 0.78 < np.mean(told) < 0.89


def test_a_target_at_the_mean_itself_is_told_by_no_number_of_runs():
    assert runs_to_tell([9.0, 10.0, 11.0], parse_target("T >= 10"), 0.975, (0, math.inf)) is None
    assert runs_to_tell([9.0, 10.0, 11.0], parse_target("T < 10.01"), 0.975, (0, math.inf)) is None


def test_days_that_are_never_late_need_fewer_runs_the_more_tasks_they_have():
    days = [[TaskShare(1.0, tasks)] * 3 for tasks in (5, 100)]
    needed = [runs_to_tell(one, parse_target("T >= 0.95"), 0.975, (0, 1)) for one in days]
    assert needed == [30, 7]
    assert judged("", days[1] * 3, parse_target("T >= 0.95"), 0.975, False, (0, 1)).verdict == "meets"
