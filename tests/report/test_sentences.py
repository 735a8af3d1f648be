"""Conclusions: said where the statistics say it, silent where they do not, with the table's numbers."""

import math

import pandas as pd
import pytest

from desim_warehouse.answer import numbers, words
from desim_warehouse.questions.sentences import knee_of_throughput
from desim_warehouse.questions.study import Results, Study
from desim_warehouse.study.execution.work import Outcome
from desim_warehouse.study.factors import Factor, Level
from desim_warehouse.study.plan import StudyPlan
from desim_warehouse.study.statistics.intervals import estimate
from desim_warehouse.study.table import Row
from desim_warehouse.study.target import read_target
from desim_warehouse.values.units import UnitNames


def facts(model, table, *, deterministic=False, goods=None):
    """The results of a study of fleet sizes whose runs had these indicators; `goods` to fetch by fleet size."""
    sizes = sorted(table["fleet.size"].unique().tolist())
    levels = tuple(
        Level(
            size, {"fleet.size": size} | ({"tasks.goods": goods[size]} if goods else {}), ("factors", "fleet.size", n)
        )
        for n, size in enumerate(sizes)
    )
    indicators = tuple(name for name in table if name not in ("fleet.size", "replication"))
    base = model if deterministic else model.replace({"tasks.goods": {"random": 4}})
    plan = StudyPlan(base, (Factor("fleet.size", levels),), "grid", indicators=indicators)
    points = plan.points()
    rows = [
        Row(
            points[sizes.index(run["fleet.size"])],
            int(run["replication"]),
            0,
            Outcome(
                {name: run[name] for name in indicators if run[name] == run[name]}, 0.1, deterministic=deterministic
            ),
        )
        for run in table.to_dict("records")
    ]
    return Results(plan, tuple(points), tuple(rows))


def runs(**columns):
    """A row per run: `columns` hold a list of values by replication for each fleet size."""
    rows = [
        {"fleet.size": size, "replication": r} | {name: by_size[size][r] for name, by_size in columns.items()}
        for size in next(iter(columns.values()))
        for r in range(len(next(iter(columns.values()))[size]))
    ]
    return pd.DataFrame(rows)


def test_the_knee_is_said_only_where_throughput_surely_rises_to_it(model):
    rates = {1: 100, 2: 200, 3: 300, 4: 310, 5: 315, 6: 318}
    rising = {size: [rate + noise * (1 + (size - 3) / 50) for noise in (-2, 0, 1, 2)] for size, rate in rates.items()}
    lines = knee_of_throughput(facts(model, runs(throughput_per_hour=rising)))
    assert lines[-1].startswith("Throughput has its knee at 3 robots, with 300 tasks an hour")
    wild = {size: [rate + noise for noise in (-900, 0, 300, 600)] for size, rate in rates.items()}
    opposed = {size: values if size > 1 else values[::-1] for size, values in wild.items()}
    assert knee_of_throughput(facts(model, runs(throughput_per_hour=opposed))) == []


@pytest.mark.parametrize(("thresholds", "message"), [([2, 5], " on average over charging threshold:"), ([2], ":")])
def test_a_knee_says_what_it_is_averaged_over(model, thresholds, message):
    base = model.replace({"tasks.goods": list(range(0, 80, 4))})
    study = Study(base, {"fleet.size": [1, 6, 12, 24, 48], "battery.threshold": thresholds})
    (line,) = knee_of_throughput(study.run().results)
    assert f"tasks an hour{message} beyond it" in line


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (1234567.0, "1,234,567"),
        (3.5, "3.5"),
        (0.0512345, "0.05123"),
        (-12.0, "−12"),
        (1167.5394, "1,168"),
        (0.0, "0"),
        (float("nan"), "–"),
    ],
)
def test_numbers_as_people_read_them(value, shown):
    assert numbers.number(value) == shown


@pytest.mark.parametrize(
    ("values", "options", "text"),
    [
        ([1044.4, 4651.9, 2848.0], {}, "2,800 (−1,600 to 7,300)"),
        ([135.2, 140.1, 147.1], {}, "141 (126 to 156)"),
        ([0.0, 0.0, 0.0], {"within": (0, math.inf), "counts": True}, "0 (0 to 1.2), 3 runs"),
        ([0.0, 0.0, 0.0], {"within": (0, math.inf)}, "0 (the same in all 3 runs)"),
        ([0.0, 0.0, 0.0], {"within": (0, math.inf), "deterministic": True}, "0 (exact)"),
        ([1168.25], {"deterministic": True}, "1,168 (exact)"),
        ([5.0], {}, "5 (one run)"),
    ],
)
def test_a_mean_has_the_digits_that_its_interval_deserves(values, options, text):
    assert numbers.Scale().estimate(estimate(values, **options)) == text


def test_shares_are_per_cent_from_0_to_100():
    assert numbers.PERCENT.estimate(estimate([1.0, 1.0], within=(0, 1))) == "100 % (16 to 100), 2 runs"
    assert numbers.PERCENT.estimate(estimate([0.972, 0.976, 0.974], within=(0, 1))) == "97.4 % (96.9 to 97.9)"
    assert (numbers.PERCENT.value(0.006604), numbers.PERCENT.value(1.0), numbers.PERCENT.value(0.9997)) == (
        "0.7 %", "100 %", "over 99.9 %",
    )  # fmt: skip


def test_what_is_not_zero_does_not_look_like_zero_nor_like_all():
    assert [numbers.PERCENT.value(share) for share in (0.0, 0.0004, 0.0005, 0.9994, 0.9996)] == [
        "0 %", "under 0.1 %", "0.1 %", "99.9 %", "over 99.9 %",
    ]  # fmt: skip
    assert [numbers.least(queue, 2) for queue in (0.0, 0.004, 0.17, 3.0)] == ["0", "under 0.01", "0.17", "3.00"]


@pytest.mark.parametrize(
    ("time", "unit", "text"),
    [
        (14_400, "s", "4 h"), (222.6, "s", "3.7 min"), (8.13, "s", "8.1 s"), (0.38, "s", "0.38 s"), (1.5, "h", "1.5 h"),
        (0.25, "min", "15 s"), (200_000, "s", "2.3 d"), (1, "step", "1 step"), (2633, "step", "2,633 steps"),
        (4.5e-13, "s", "under 0.01 s"),
    ],
)  # fmt: skip
def test_times_are_said_in_a_unit_that_fits(time, unit, text):
    assert numbers.duration(time, unit) == text


def test_p_values_have_three_decimals():
    assert [numbers.p_value(p) for p in (1.17e-17, 0.0123, 1.0, None)] == ["< 0.001", "0.012", "1", "–"]


@pytest.mark.parametrize(
    ("written", "text"),
    [
        ("on_time >= 90 %", "at least 90 % on time"),
        ("throughput_per_hour > 220", "more than 220 tasks an hour"),
        ("cycle_time_p95 <= 5 min", "cycle time, 95 % quantile at most 5 min"),
        ("on_time:inbound >= 0.95", "at least 95 % on time, inbound"),
        ("S < 4", "waits for another robot less than 4"),
    ],
)
def test_targets_are_said_as_people_say_them(written, text):
    assert words.target(read_target(written, UnitNames("m", "s", 1.0))) == text


def test_policies_are_said_in_words_beside_their_name():
    assert words.design_spoken({"fleet.size": 3, "policies.allocation": "nearest"}) == (
        "3 robots, dispatching: nearest"
    )
    assert words.design_spoken({"policies.batching": "time-window(window=60)"}) == ("batching: time-window, window 60")
    assert words.design_spoken({"policies.allocation": "mine.py:Mine"}) == "dispatching: mine.py:Mine"
