"""A verdict that is looked for while runs come in is wrong no more often than it says, whenever one stops."""

import math

import numpy as np
import pytest

from desim_warehouse.outcome.targets import parse_target
from desim_warehouse.study.statistics.intervals import TaskShare, bounds
from desim_warehouse.study.statistics.judge import Judge, looked_at, looks_by, looks_of_days
from desim_warehouse.study.statistics.limits import RARE_DAYS, DaysNeeded, days_for, one_in
from desim_warehouse.study.statistics.procedure import follow

AT_LEAST = parse_target("on_time >= 0.95")
NORMAL = parse_target("throughput_per_hour >= 200")
MOST = 60


def normal(rng, mean, n):
    return list(200.0 + 10.0 * (mean + rng.standard_normal(n)))


def skewed(rng, mean, n):
    return list(200.0 + 10.0 * (mean + rng.gamma(2.0, 1 / math.sqrt(2), n) - math.sqrt(2)))


def shares(rng, mean, n):
    """Days of 800 tasks, which correlate within a day by 0.02."""
    chance = 0.95 + 0.02 * mean
    days = rng.beta(chance * 49, (1 - chance) * 49, n)
    return [TaskShare(done / 800, 800) for done in rng.binomial(800, days)]


ANYTHING = (-math.inf, math.inf)
CASES = {
    "normal": (normal, NORMAL, ANYTHING),
    "skewed": (skewed, NORMAL, ANYTHING),
    "shares": (shares, AT_LEAST, (0.0, 1.0)),
}
WRONG = {"normal": 0.05, "skewed": 0.06, "shares": 0.05}
"""The share of verdicts that may be wrong: of skewed output, 6 %, as ten values of it cover in 94 % (`bounds`)."""


def ever(name, mean, streams):
    """Of so many streams whose mean is that far from the target, how many are ever called met, and not met."""
    make, target, within = CASES[name]
    rng = np.random.default_rng(1)
    verdicts = [looked_at(make(rng, mean, MOST), target, 0.95, within=within).verdict for _ in range(streams)]
    return verdicts.count("meets"), verdicts.count("fails")


def test_looks_use_no_more_error_than_there_is_however_long_it_goes_on():
    assert [n for n, _ in looks_by(100)] == [10, 15, 23, 35, 53, 80]
    assert [part for _, part in looks_by(23)] == [1 / 2, 1 / 6, 1 / 12]
    assert math.fsum(part for _, part in looks_by(100_000)) <= 1.0
    assert looks_by(9) == []
    assert [n for n, _ in looks_of_days()] == [5, 8, 12, 18, 33, 50, 80]
    assert [n for n, _ in looks_of_days(10, RARE_DAYS)] == [10, 15, 23, 35, 59, 89, 120]
    assert [n for n, _ in looks_of_days(5, DaysNeeded(12, 12))] == [5, 8, 12]
    assert [n for n, _ in looks_of_days(100, DaysNeeded(100, 300))] == [100, 150, 225, 300]
    assert math.fsum(part for _, part in looks_of_days()) == pytest.approx(1.0)


def test_days_that_come_once_in_ten_or_twenty_are_among_so_many():
    """0.9^28 = 5.2 %, 0.9^29 = 4.7 %; 0.95^58 = 5.1 %, 0.95^59 = 4.8 %."""
    assert (days_for(0.1), days_for(0.05), days_for(0.02)) == (29, 59, 149)
    assert [one_in(days) for days in (5, 12, 33, 59, 80, 149)] == [2, 2, 10, 20, 20, 50]


def test_nothing_is_met_before_as_many_days_as_show_a_bad_one():
    calm = [1.0, 1.1, 0.9, 1.0, 1.05] * 16
    target = parse_target("T >= 0.5")
    assert looked_at(calm[:23], target, 0.95, within=ANYTHING).verdict == "undecided"
    assert looked_at(calm, target, 0.95, within=ANYTHING).n == 35
    assert looked_at(calm, target, 0.95, within=ANYTHING, least=RARE_DAYS.least).n == 80
    assert looked_at(calm[:10], parse_target("T >= 2"), 0.95, within=ANYTHING).verdict == "fails"


def test_a_verdict_that_fell_stands_whatever_comes():
    good = [1.0, 1.1, 0.9, 1.0, 1.05] * 7
    target = parse_target("T >= 0")
    first = looked_at(good, target, 0.95, within=ANYTHING)
    later = looked_at(good + [-50.0] * 25, target, 0.95, within=ANYTHING)
    assert (first.verdict, later.verdict) == ("meets", "meets")
    assert first.n == later.n == 35


def test_nothing_is_said_before_the_first_look_and_one_run_is_enough_without_chance():
    assert looked_at([201.0] * 4, NORMAL, 0.95, within=ANYTHING) is None
    assert looked_at([201.0], NORMAL, 0.95, deterministic=True, within=ANYTHING).verdict == "meets"


@pytest.mark.parametrize("name", ["normal", "skewed"])
def test_no_more_verdicts_are_wrong_than_stated_in_150_streams(name):
    met, not_met = ever(name, 0.0, 150)
    assert max(met, not_met) <= 0.05 * 150 + 3 * math.sqrt(0.05 * 0.95 * 150)


def test_verdicts_do_fall_where_designs_are_far_from_the_target():
    assert ever("normal", 2.0, 30) == (30, 0)
    assert ever("normal", -2.0, 30) == (0, 30)


@pytest.mark.long
@pytest.mark.parametrize("name", list(CASES))
def test_no_more_verdicts_are_wrong_than_stated_in_2000_streams_at_below_and_above_the_target(name):
    at, below, above = (ever(name, mean, 2000) for mean in (0.0, -0.3, 0.3))
    share = WRONG[name]
    assert max(*at, below[0], above[1]) <= share * 2000 + 2 * math.sqrt(share * (1 - share) * 2000)


def test_of_skewed_output_bounds_of_ten_values_miss_on_one_side():
    """Which is why 5.8 % and not 5 % of streams at the target are ever called not met: 269 of 6,000 missed here."""
    rng = np.random.default_rng(11)
    high = [bounds(np.array(skewed(rng, 0.0, 10)), 0.975)[1] for _ in range(2000)]
    assert sum(bound < 200.0 for bound in high) / 2000 == pytest.approx(0.045, abs=0.01)


@pytest.mark.parametrize("designs", [80, pytest.param(400, marks=pytest.mark.long)])
def test_few_designs_are_left_open_that_further_runs_would_decide(monkeypatch, designs):
    """Of designs up to half a standard deviation above the target, 90 % of those decided in 80 runs still are."""
    rng = np.random.default_rng(20)
    streams = [rng.normal(above, 1.0, 80) for above in rng.uniform(0.0, 0.5, designs)]

    def decided():
        judges = [Judge(parse_target("throughput_per_hour >= 0")) for _ in streams]
        for judge, values in zip(judges, streams, strict=True):
            follow(judge.verdict(0), lambda _, run, values=values: values[run])
        decisive = sum(judge.verdicts[0].verdict != "undecided" for judge in judges)
        return decisive, sum(judge.runs(0) for judge in judges)

    stopped, fewer_runs = decided()
    monkeypatch.setattr(Judge, "_is_futile", lambda judge, number: False)
    to_the_end, runs = decided()
    assert 0.9 * to_the_end < stopped < to_the_end
    assert fewer_runs < 0.85 * runs
