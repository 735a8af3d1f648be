"""How often what commands say is so: many studies of synthetic days whose truth is known, by the code of the commands.

`docs/make_validation.py` makes a table of it; seeds are fixed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.outcome.targets import parse_target
from desim_warehouse.study.statistics.comparison import compare
from desim_warehouse.study.statistics.effects import gains_steps
from desim_warehouse.study.statistics.intervals import TaskShare, estimate
from desim_warehouse.study.statistics.judge import Judge, looked_at, verdict_steps
from desim_warehouse.study.statistics.limits import CAP, COMMON_DAYS, FIRST, FIRST_OF_MEANS, RARE_DAYS, days_for
from desim_warehouse.study.statistics.procedure import follow
from tests.study.statistics.searches import kn, smallest

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.random import Generator


STUDIES = 400


@dataclass(frozen=True)
class Coverage:
    """A kind of study: the command, what its days are like, and one study, which says whether it was right.

    A study that gives no answer, such as a run too short for one, is None, and is not counted.
    """

    command: str
    days: str
    promised: float
    one: Callable[[Generator], bool | None]

    def covered(self, studies=STUDIES):
        """The part of the studies that are right, of those that give an answer."""
        return float(np.mean([right for right in self.all(studies) if right is not None]))

    def all(self, studies=STUDIES):
        """Whether each study is right."""
        rng = np.random.default_rng(sum(map(ord, self.command + self.days)))
        return [self.one(rng) for _ in range(studies)]

    def __str__(self):
        return f"{self.command}: {self.days}"


def day_shares(rng, true, tasks, alike, days):
    """Beta-binomial: each day has a chance of its own that a task is on time; tasks of a day correlate by `alike`."""
    both = 1 / alike - 1
    return np.asarray(rng.binomial(tasks, rng.beta(true * both, (1 - true) * both, days)) / tasks)


def _holds(interval, truth):
    assert interval is not None
    low, high = interval
    assert low is not None
    assert high is not None
    return low <= truth <= high


def _shares(values, tasks):
    return [TaskShare(value, tasks) for value in values]


def mean_of_days(draw, truth):
    """`desim what-if`: the interval of a mean."""
    return lambda rng: _holds(estimate(draw(rng), within=(0.0, np.inf)).interval, truth)


def share_of_days(true, tasks, alike, days):
    """The same of a share of tasks."""
    return mean_of_days(lambda rng: _shares(day_shares(rng, true, tasks, alike, days), tasks), true)


def plan(true, alike, tasks=100):
    """`desim plan`: the range printed with the verdict on a fleet, where runs stop as soon as it is clear."""

    def one(rng):
        days = _shares(day_shares(rng, true, tasks, alike, CAP), tasks)
        judge = Judge(parse_target("on_time >= 0.95"), zone=0.01, within=(0.0, 1.0))
        follow(verdict_steps([0], judge), lambda _, replication: days[replication])
        return _holds((judge.verdicts[0].low, judge.verdicts[0].high), true)

    return one


def size(rng):
    """`desim size`: every range of a search over six fleets."""
    values = rng.lognormal(0.0, 0.5, (6, CAP)) / np.exp(0.125)
    sizing = smallest(
        lambda fleet, replication: fleet * values[fleet - 1, replication], range(1, 7), "throughput_per_hour >= 3.3"
    )
    return all(_holds((one.low, one.high), one.value) for one in sizing.decisions)


def best(rng):
    """`desim best`: the design named is within delta of the best, of six in steps of delta."""
    values = rng.lognormal(0.0, 0.5, (6, 1000)) / np.exp(0.125) + 0.2 * np.arange(6)[:, None]
    selection = kn(lambda design, replication: values[design, replication], 6, 0.2, maximise=True)
    return selection.best >= 4  # the fifth is as good but for delta


def why(rng):
    """`desim why`: all ranges of what six suspects cost hold at once; one costs something."""
    days = rng.normal(100, 10, 160)
    truth = [0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    values = days + np.array(truth)[:, None] + rng.gamma(1, 3, (7, 160)) - 3
    ranking = follow(gains_steps([1.0] * 6, 1.0), lambda design, replication: float(values[design, replication]))
    return all(_holds((gain.low, gain.high), truth[gain.change]) for gain in ranking.gains)


def compared(rng):
    """`desim compare`: all differences of five designs to today's hold at once."""
    common = rng.normal(0, 10, 12)
    table = {design: common + design + rng.gamma(2, 2, 12) - 4 for design in range(6)}
    return all(_holds(one.estimate.interval, float(str(one.design))) for one in compare(table, 0).differences)


def wrongly_met(target, tasks, alike, studies):
    """How often `desim plan` says of a fleet that misses a share by 0.05 points that it meets it."""
    return _said("meets", target - 0.0005, target, tasks, alike, studies)


def wrongly_missed(target, tasks, alike, studies):
    """How often it says of a fleet that is better than a share by the indifference zone that it misses it."""
    return _said("fails", target + _zone(target), target, tasks, alike, studies)


def _said(wrong, true, target, tasks, alike, studies):
    rng = np.random.default_rng(int(1000 * target) + tasks)
    return float(np.mean([verdict(rng, true, target, tasks, alike) == wrong for _ in range(studies)]))


def _zone(target):
    return (1 - target) / 4


@dataclass(frozen=True)
class TwoKinds:
    """Days of which one in `every` is bad: `depth` of its tasks less are on time, and times are `longer` times as long.

    Times vary by 5 % besides. The fleet misses its target by a hair.
    """

    every: int
    depth: float
    longer: float

    @property
    def days(self):
        """The days that a plan takes where it knows how rare they are."""
        return COMMON_DAYS if days_for(1 / self.every) <= COMMON_DAYS.least else RARE_DAYS

    def wrongly_met(self, target, tasks, studies):
        """How often `desim plan` says of a fleet that misses a share by 0.05 points that it meets it."""
        rng, true = np.random.default_rng(int(1000 * target) + tasks + self.every), target - 0.0005
        good = true + self.depth / self.every

        def draw():
            bad = rng.random(self.days.cap) < 1 / self.every
            return _shares(rng.binomial(tasks, np.where(bad, good - self.depth, good)) / tasks, tasks)

        return self._met(draw, Judged(f"on_time >= {target}", 0.01, (0.0, 1.0), FIRST), studies)

    def wrongly_met_in_time(self, studies):
        """The same of a mean of at most 200, which the fleet misses by 0.1 %."""
        rng, mean = np.random.default_rng(self.every), 1 + (self.longer - 1) / self.every

        def draw():
            bad = rng.random(self.days.cap) < 1 / self.every
            days = np.where(bad, self.longer, 1.0) * rng.normal(1, 0.05, self.days.cap)
            return (200.2 * days / mean).tolist()

        return self._met(draw, Judged("cycle_time_p95 <= 200", 2.0, (0.0, np.inf), FIRST_OF_MEANS), studies)

    def _met(self, draw, judged, studies):
        return float(np.mean([judged.verdict(draw(), self.days) == "meets" for _ in range(studies)]))


@dataclass(frozen=True)
class Judged:
    """How `desim plan` judges an indicator."""

    target: str
    zone: float
    within: tuple[float, float]
    first: int

    def verdict(self, values, days):
        """What it says of a fleet with one value a day."""
        judge = Judge(
            parse_target(self.target), zone=self.zone, within=self.within, first=self.first, days=lambda _: days
        )
        follow(verdict_steps([0], judge), lambda _, replication: values[replication])
        return judge.verdicts[0].verdict


TWO_KINDS = (TwoKinds(5, 0.1, 2.0), TwoKinds(10, 0.3, 3.0), TwoKinds(20, 0.4, 5.0), TwoKinds(50, 0.6, 5.0))
"""From often to so rare that the days of a plan do not cover it."""


def verdict(rng, true, target, tasks, alike):
    """What `desim plan` says of a fleet, with its looks from 5 to 80 days."""
    days = _shares(day_shares(rng, true, tasks, alike, CAP), tasks)
    judge = Judge(parse_target(f"on_time >= {target}"), zone=_zone(target), within=(0.0, 1.0))
    follow(verdict_steps([0], judge), lambda _, replication: days[replication])
    return judge.verdicts[0].verdict


def ever_met(draw, target, within, studies):
    """How often the live page ever says of a design exactly at its target that it meets it, in `LOOKED_AT` days."""
    rng, goal = np.random.default_rng(424242), parse_target(target)
    verdicts = [looked_at(draw(rng), goal, 0.95, within=within) for _ in range(studies)]
    return float(np.mean([one is not None and one.verdict == "meets" for one in verdicts]))


def bad_days(rng):
    """Nine of ten days 99 % on time, the tenth 59 %: 95 % in all."""
    days = np.where(rng.random(LOOKED_AT) < 0.1, 0.59, 0.99)
    return _shares(rng.binomial(60, days) / 60, 60)


LOOKED_AT = 120
"""Days of a design on the live page."""
_ANY, _SHARE = (-np.inf, np.inf), (0.0, 1.0)
AT_THE_TARGET = (
    ("normal days, mean at most 200", "T <= 200", _ANY, lambda rng: rng.normal(200, 10, LOOKED_AT)),
    ("exponential days, mean at most 200", "T <= 200", _ANY, lambda rng: 190 + rng.exponential(10, LOOKED_AT)),
    ("exponential days, mean at least 200", "T >= 200", _ANY, lambda rng: 190 + rng.exponential(10, LOOKED_AT)),
    (
        "lognormal days (σ = 1), mean at most 200",
        "T <= 200",
        _ANY,
        lambda rng: 200 - 10 * np.exp(0.5) + 10 * rng.lognormal(0, 1, LOOKED_AT),
    ),
    *(
        (
            f"95 % on time, {tasks} tasks a day, correlation {alike}",
            "on_time >= 0.95",
            _SHARE,
            lambda rng, tasks=tasks, alike=alike: _shares(day_shares(rng, 0.95, tasks, alike, LOOKED_AT), tasks),
        )
        for tasks, alike in ((50, 0.02), (200, 0.1), (200, 0.3))
    ),
    ("nine of ten days 99 % on time, the tenth 59 %, 60 tasks a day", "on_time >= 0.95", _SHARE, bad_days),
)
"""Designs exactly at a target: what their days are like, the target, the range of the indicator, and days."""


ON_TIME = (
    Coverage("what-if", "on time 95 %, 10 days of 50 tasks, correlation 0.02", 0.95, share_of_days(0.95, 50, 0.02, 10)),
    Coverage("what-if", "97 %, 20 days of 400, correlation 0.05", 0.95, share_of_days(0.97, 400, 0.05, 20)),
    Coverage("what-if", "90 %, 20 days of 1,000, correlation 0.1", 0.95, share_of_days(0.9, 1000, 0.1, 20)),
)
CASES = (
    Coverage("what-if", "10 normal days", 0.95, mean_of_days(lambda rng: rng.normal(50, 8, 10), 50)),
    Coverage(
        "what-if", "20 lognormal days", 0.95, mean_of_days(lambda rng: rng.lognormal(0, 0.5, 20), float(np.exp(0.125)))
    ),
    *ON_TIME,
    *(
        Coverage("plan", f"{100 * true:g} %, target 95 %, correlation {alike}", 0.95, plan(true, alike))
        for true in (0.93, 0.955, 0.97)
        for alike in (0.024, 0.077)
    ),
    Coverage("size", "six fleets, lognormal days", 0.95, size),
    Coverage("best", "six designs in steps of delta, lognormal days", 0.95, best),
    Coverage("why", "six suspects, gamma differences", 0.95, why),
    Coverage("compare", "five designs and today's, gamma differences", 0.95, compared),
)


ALIKE = (0.01, 0.05, 0.1, 0.2)
"""Correlations of the tasks of a day."""
