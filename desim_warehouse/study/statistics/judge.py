"""Sequential test of whether designs meet a target, with repeated looks (interim analyses) as runs come in.

For every verdict on a target: of `desim plan`, `size`, `best`, `what-if`, `study` and `serve`.

All verdicts share one schedule of looks (`looks`), one error budget (alpha spending) and one cap on replications. A
design that further runs up to the cap would probably not decide stays undecided (stopping for futility).
Searches, such as for the cheapest design (`cheapest`), choose the designs and the target.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from typing import Generic, Literal, TypeVar

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.statistics.checks import check_confidence
from desim_warehouse.study.statistics.intervals import ANYTHING, Interval, bounds_of, does_not_vary, with_width
from desim_warehouse.study.statistics.limits import CAP, COMMON_DAYS, FIRST, FIRST_OF_MEANS, DaysNeeded
from desim_warehouse.study.statistics.procedure import Procedure, request

V = TypeVar("V")
Verdict = Literal["meets", "fails", "undecided"]
GLANCE = 3
"""Runs of a design before its first look, which may show that it is hopeless or that it equals another."""
MOST_TO_TELL = 1000
"""The largest number of runs that is named as probably enough to decide on a design."""
_SPARE = 1.5
"""Distance from mean to target over the half-width at which five of six designs are decided, if the mean is true."""
FEWEST_BESIDE = 5  # fewest runs of which one may be called an outlier
_FUTILE = 1.28  # quantile of the normal distribution: a design is left undecided below a predictive power of 10 %
_APART = 1.25  # least ratio of the runs of a look to those of the look before


def looks(first: int = FIRST, cap: int = CAP) -> list[tuple[int, float]]:
    """Return the replications at each look (interim analysis) and the look's share of alpha (alpha spending).

    Each look has half as many replications again as the one before, up to a cap.

    Source: alpha is split evenly over looks that are fixed in advance (Bonferroni).
    """
    return _shared([*_growing_to(first, cap - 1), cap])


def looks_of_days(first: int = FIRST, days: DaysNeeded = COMMON_DAYS) -> list[tuple[int, float]]:
    """Return the looks of a judge, including one at `days.least`, the fewest days for a verdict of "meets"."""
    if first >= days.least:
        return looks(first, days.cap)
    counts = [first]
    for stop in (days.least, days.cap):
        counts += [n for n in _growing_to(counts[-1], stop / _APART) if n > counts[-1]]
        counts += [stop] if stop > counts[-1] else []
    return _shared(counts)


def _growing_to(first: int, last: float) -> list[int]:
    """Return numbers of replications that grow by half each, from a first look up to a last number."""
    return [*takewhile(lambda n: n <= last, _growing(first))]


def _shared(counts: Sequence[int]) -> list[tuple[int, float]]:
    return [(n, 1 / len(counts)) for n in counts]


def schedule(first: int, cap: int, *, exact: bool) -> list[tuple[int, float]]:
    """Return the looks of a procedure; a single look at one run of each design if runs are `exact`.

    Raises:
        StudyError: not 2 <= first <= cap.
    """
    if exact:
        return [(1, 1.0)]
    _check(first, cap)
    return looks(first, cap)


def _check(first: int, cap: int) -> None:
    if not 2 <= first <= cap:  # noqa: PLR2004
        raise StudyError(f"first look {first}, cap {cap}: expected 2 <= first <= cap")


def looks_by(replications: int) -> list[tuple[int, float]]:
    """Return the looks (interim analyses) up to a number of replications; the i-th spends 1 / (i (i + 1)) of alpha.

    The first look is at ten replications, as waiting costs nothing where runs go on by themselves.

    Source: alpha spending with shares that add up to 1 over any number of looks, mostly spent early: Lan & DeMets
    (1983), Discrete sequential boundaries for clinical trials, Biometrika 70(3), 659-663.
    """
    return [(n, 1 / (i * (i + 1))) for i, n in enumerate(_growing_to(FIRST_OF_MEANS, replications), 1)]


def _growing(n: int) -> Iterator[int]:
    while True:
        yield n
        n += max((n + 1) // 2, 2)


@dataclass(frozen=True)
class DesignVerdict(Generic[V]):
    """The verdict on one design.

    `low` and `high` are the bounds behind the verdict, each right with probability `level`; both are None if the values
    are `deterministic` and the mean is exact, or if a measurement is 0 in all runs. `outlier`: the replication without
    which an undecided design would be decided, or None. `within_zone`: the mean is known to be within the indifference
    zone of the target, so that more runs would not change anything that matters. `least`: the fewest runs for a verdict
    of "meets". `each`: the verdict on each of several targets; the design meets if it meets all, and fails if it misses
    one. Its other attributes are those of the first target.
    """

    value: V
    verdict: Verdict
    n: int
    mean: float
    low: float | None
    high: float | None
    level: float
    deterministic: bool
    within_zone: bool = False
    outlier: int | None = None
    least: int = 0
    each: tuple[DesignVerdict[V], ...] = ()

    @property
    def closed(self) -> bool:
        """Whether further runs would not change the verdict in any way that matters."""
        return self.verdict != "undecided" or self.within_zone

    @property
    def agrees(self) -> bool:
        """Whether the mean has no bounds only because several random runs agree."""
        return self.low is None and self.n > 1


def judged(
    value: V,
    data: list[float],
    target: Target,
    level: float,
    deterministic: bool,
    within: Interval,
    zone: float = 0.0,
    least: int = 0,
) -> DesignVerdict[V]:
    """Judge whether a design meets the target, from its values (`data`).

    The design meets the target if its worse bound does, after at least `least` runs. It fails if its mean misses the
    target and its better bound misses a target that is harder by `zone` (indifference zone, in the indicator's unit).
    So a better run never makes a design fail that met the target before. The design counts as about at the target if
    both the distance from mean to target and that from mean to either bound are at most the zone.
    """
    mean = float(np.mean(data))
    if deterministic:
        return DesignVerdict(
            value, "meets" if target.met_by(mean) else "fails", len(data), mean, None, None, level, True, least=least
        )
    verdict, ends, within_zone = _verdict(data, mean, target, level, within, zone, least)
    low, high = with_width(ends) or (None, None)
    outlier = None
    if verdict == "undecided" and not within_zone and len(data) >= FEWEST_BESIDE:
        farthest = int(np.argmax(np.abs(np.array(data) - mean)))
        others = [*data[:farthest], *data[farthest + 1 :]]
        if _verdict(others, float(np.mean(others)), target, level, within, zone, least)[0] != "undecided":
            outlier = farthest
    return DesignVerdict(value, verdict, len(data), mean, low, high, level, False, within_zone, outlier, least)


def on_all(each: Sequence[DesignVerdict[V]]) -> DesignVerdict[V]:
    """Combine the verdicts on each of several targets, at one look, into one; all of them hold simultaneously."""
    left = [verdict for verdict in each if verdict.verdict == "undecided"]
    verdict = _of_all([target.verdict for target in each])
    return replace(
        each[0],
        verdict=verdict,
        within_zone=bool(left) and all(target.within_zone for target in left),
        outlier=left[0].outlier if len(left) == 1 and verdict == "undecided" else None,
        each=tuple(each),
    )


def _of_all(verdicts: Collection[Verdict]) -> Verdict:
    """Combine the verdicts on several targets: one missed target is enough to fail."""
    return next((verdict for verdict in ("fails", "undecided") if verdict in verdicts), "meets")


def _verdict(
    data: Sequence[float], mean: float, target: Target, level: float, within: Interval, zone: float, least: int
) -> tuple[Verdict, Interval, bool]:
    """Return the verdict, its bounds, and whether the design is known to be about at the target."""
    low, high = bounds_of(data, level, within, target.measure.is_count)
    if low == high == target.value:
        return "undecided", (low, high), False  # all runs agree, and nothing tells on which side others would lie
    worse, better = (low, high) if target.sign > 0 else (high, low)
    if target.met_by(worse):
        return ("meets" if len(data) >= least else "undecided"), (low, high), False
    short = not target.met_by(better - target.sign * zone)
    if short and not target.met_by(mean):
        return "fails", (low, high), False
    is_close = max(high - mean, mean - low, abs(mean - target.value)) <= zone
    return "undecided", (low, high), short or (is_close and zone > 0)


def looked_at(
    values: Sequence[float],
    target: Target,
    confidence: float,
    *,
    deterministic: bool = False,
    within: Interval,
    least: int = COMMON_DAYS.least,
    agree: bool = False,
) -> DesignVerdict[None] | None:
    """Return the verdict of the first decisive look, or else of the last look; None before the first look.

    A verdict of "meets" or "fails" is final: it does not change as further runs come in.

    Args:
        values: values of the indicator by replication.
        target: target for the mean.
        confidence: probability that a verdict of "meets" is never wrong, however many runs follow; likewise for
            "fails". It holds for all targets on the indicator at once.
        deterministic: the runs use no random numbers, so that a single run is exact.
        within: range of the indicator, such as (0, 1) for a share.
        least: fewest replications for a verdict of "meets".
        agree: whether runs that agree show that the indicator does not vary (`does_not_vary`).

    Source: `looks_by`.
    Assumes: as the bounds of one look (`intervals.bounds`), whose coverage is only approximate for skewed output. Of
    12,000 streams of a gamma with skewness 1.4 whose mean is the target, at a confidence of 95 %, 5.8 % are ever called
    not met, four in five of these at the look of ten values, and 0.2 % met.
    """
    if deterministic and values:
        return judged(None, list(values[:1]), target, confidence, True, within)
    latest = None
    for n, part in looks_by(len(values)):
        data = list(values[:n])
        fixed = agree and does_not_vary(data, within)
        latest = judged(None, data, target, 1.0 - (1.0 - confidence) * part, fixed, within, least=least)
        if latest.verdict != "undecided":
            break
    return latest


def runs_to_tell(values: Sequence[float], target: Target, level: float, within: Interval, least: int = 0) -> int | None:
    """Return the total number of runs that would probably decide on a design; None if more than `MOST_TO_TELL`.

    Further runs are assumed to repeat those so far (at least two). The number suffices when the distance from mean to
    target is 1.5 times the half-width: if the mean is the true one, five of six such designs are then decided.
    `level`: see `judged`.
    """
    mean = float(np.mean(values))
    wider = math.sqrt(len(values) / (len(values) - 1))  # repeated values vary less than new ones
    nearer = replace(target, value=mean + (target.value - mean) / (_SPARE * wider))

    def decides(runs: int) -> bool:
        further = _repeated(values, runs)
        return _verdict(further, float(np.mean(further)), nearer, level, within, 0.0, least)[0] != "undecided"

    counts = range(len(values) + 1, MOST_TO_TELL + 1)
    place = bisect_left(counts, True, key=decides)
    return counts[place] if place < len(counts) else None


def _repeated(values: Sequence[float], runs: int) -> list[float]:
    """Return the values of a number of runs that repeat those so far."""
    return [values[run % len(values)] for run in range(runs)]


class RunsEndedError(StudyError):
    """Raised when the budget of runs is exhausted before there is an answer."""


@dataclass
class Budget:
    """The number of runs that may still be done (`left`), and the number done (`spent`)."""

    left: int
    spent: int = 0

    def allows(self, runs: int) -> bool:
        """Whether a number of further runs may be done."""
        return runs <= self.left

    def take(self, runs: int) -> None:
        """Spend a number of runs; raise RunsEndedError if they exceed the budget."""
        if not self.allows(runs):
            raise RunsEndedError("the runs allowed ended before there was an answer")
        self.left -= runs
        self.spent += runs


@dataclass
class _Case:
    """A design under judgement: remaining looks, fewest runs for "meets", values, and share of alpha (`error`).

    A design takes its share of alpha at its first look; designs ruled out before then leave theirs to others.
    """

    looks: list[tuple[int, float]]
    least: int
    data: list[float] = field(default_factory=list)
    error: float | None = None
    level: float = math.nan


@dataclass(frozen=True)
class Beside:
    """A further target that designs have to meet, and its indifference zone.

    `values`: function that returns the target's indicator in the first runs of a design, from the design's number and
    the number of runs.
    """

    target: Target
    zone: float
    values: Callable[[int, int], list[float]]


@dataclass
class Judge:
    """A judge of designs, look by look (interim analyses), at levels such that all verdicts hold simultaneously.

    `verdicts`: the verdict on each design, by number. `vetoed`: reasons why designs fail regardless of the target.
    `drained`: the vetoed designs whose batteries run down.

    Args:
        target: target for the mean, such as "on_time >= 0.95".
        confidence: probability that no design that misses the target is judged to meet it; likewise for "fails".
        zone: indifference zone in the indicator's unit: a design that is better than the target by less may be
            judged to fail.
        first: replications at the first look at a design.
        days: function of a design's number that returns the fewest replications for a verdict of "meets", and the
            most. A design still "undecided" then, or earlier if further runs would probably decide nothing, is treated
            as not meeting the target.
        agree: whether runs that agree show that the indicator does not vary (`does_not_vary`).
        deterministic: the models use no random numbers, so that one run of a design is exact.
        within: range of the indicator.
        budget: runs that may be done (default: practically unlimited).
        veto: function called after each look that returns why a design fails regardless of the target, or None.
        drains: whether the batteries of a vetoed design run down, so that its chargers may suffice for fewer robots.
        hopeless: like `veto`, but called after the first `GLANCE` runs, for failures beyond doubt.
        tell: function called after each look, when `in_words` may have changed.
        beside: further targets; a design has to meet all of them.

    Source: one-sided bounds (`intervals.bounds`); the j-th design that is looked at is judged at
    1 - α / (j (j + 1) · looks · targets), which adds up to at most α (Bonferroni) for any number of designs.
    Assumes: as `bounds`.
    """

    target: Target
    confidence: float = 0.95
    zone: float = 0.0
    first: int = FIRST
    days: Callable[[int], DaysNeeded] = lambda _: COMMON_DAYS
    agree: bool = False
    deterministic: bool = False
    within: Interval = ANYTHING
    budget: Budget = field(default_factory=lambda: Budget(10**9))
    veto: Callable[[int], str | None] = lambda _: None
    hopeless: Callable[[int], str | None] = lambda _: None
    drains: Callable[[int], bool] = lambda _: False
    tell: Callable[[Judge], None] = lambda _: None
    beside: Sequence[Beside] = ()
    verdicts: dict[int, DesignVerdict[int]] = field(default_factory=dict, init=False)
    vetoed: dict[int, str] = field(default_factory=dict, init=False)
    drained: set[int] = field(default_factory=set, init=False)
    _cases: dict[int, _Case] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        check_confidence(self.confidence)
        if self.zone < 0:
            raise StudyError(f"zone {self.zone:g}: expected one from 0")

    def verdict(self, number: int) -> Procedure[str]:
        """Look at a design until it is decided or its last look is over; return its verdict."""
        while not self.closed(number):
            yield from self.look(number)
        return self.verdicts[number].verdict

    @property
    def targets(self) -> tuple[Target, ...]:
        """All targets that a design has to meet."""
        return self.target, *(further.target for further in self.beside)

    def forecast(self, number: int, luck: float = 0.0) -> Verdict:
        """Return the verdict on a design at its last look if its further runs repeat those so far.

        `luck`: how much better its final mean is, in standard deviations of the final mean as predicted by these runs.
        """
        case, cap = self._cases[number], self.days(number).cap
        relative_sd = math.sqrt(max(0.0, 1 / len(case.data) - 1 / cap))
        each = []
        for goal, zone, within, values in self._by_target(number):
            better = luck * relative_sd * float(np.std(values, ddof=1)) if luck else 0.0
            easier = replace(goal, value=goal.value - goal.sign * better)
            further = _repeated(values, cap)
            mean = float(np.mean(further))
            each.append(_verdict(further, mean, easier, case.level, within, zone, case.least)[0])
        return _of_all(each)

    def _is_futile(self, number: int) -> bool:
        """Whether further runs would probably decide nothing: the predictive power for both verdicts is below 10 %."""
        return self.forecast(number, _FUTILE) != "meets" and self.forecast(number, -_FUTILE) != "fails"

    def missed(self, number: int) -> list[Target]:
        """Return the targets that a design was shown to miss."""
        verdict = self.verdicts[number]
        each = zip(self.targets, verdict.each or (verdict,), strict=True)
        return [goal for goal, each_verdict in each if each_verdict.verdict == "fails"]

    def runs(self, number: int) -> int:
        """Return how many runs a design has."""
        return len(self._cases[number].data) if number in self._cases else 0

    def closed(self, number: int) -> bool:
        """Whether a design has no further look to come."""
        return number in self.verdicts and not self._cases[number].looks

    def glance(self, number: int) -> Procedure[None]:
        """Do the first few runs of a design, which can only show that it is hopeless."""
        if number in self._cases or self.deterministic:
            return
        yield from self._run(number, min(GLANCE, self.first))
        self._veto(number, self.hopeless(number))

    def look(self, number: int) -> Procedure[None]:
        """Do the runs up to the next look (interim analysis) at a design, and judge it."""
        yield from self.glance(number)
        if self.closed(number):
            return
        case = self._case(number)
        runs, part = case.looks.pop(0)
        if number in self.verdicts and not self.budget.allows(runs - len(case.data)):
            case.looks.clear()
            return
        yield from self._run(number, runs)
        if case.error is None:
            case.error = self._next_error()
        case.level = 1.0 - case.error * part / len(self.targets)
        self.verdicts[number] = self._judged(number)
        self._veto(number, self.veto(number))
        if self.verdicts[number].closed or self._is_futile(number):
            case.looks.clear()
        self.tell(self)

    def in_words(self, name: Callable[[int], str]) -> str:
        """Return the verdicts so far in words: `10 robots: met; 9 robots: not met; 8 robots: open`."""
        words = {"meets": "met", "fails": "not met", "undecided": "open"}
        return "; ".join(f"{name(number)}: {words[verdict.verdict]}" for number, verdict in self.verdicts.items())

    def _case(self, number: int) -> _Case:
        if number not in self._cases:
            days = self.days(number)
            if not self.deterministic:
                _check(self.first, days.cap)
            stops = [(1, 1.0)] if self.deterministic else looks_of_days(self.first, days)
            self._cases[number] = _Case(stops, days.least, level=1.0 - self._next_error() * stops[0][1])
        return self._cases[number]

    def _next_error(self) -> float:
        """Return the share of alpha for the next design that is looked at."""
        j = 1 + sum(case.error is not None for case in self._cases.values())
        return (1.0 - self.confidence) / (j * (j + 1))

    def _run(self, number: int, runs: int) -> Procedure[None]:
        """Do the runs of a design up to a total number."""
        done = self.runs(number)
        self.budget.take(runs - done)
        self._case(number).data += yield from request([(number, r) for r in range(done, runs)])

    def _by_target(self, number: int) -> list[tuple[Target, float, Interval, list[float]]]:
        """Return each target with its zone, the range of its indicator, and the values of a design so far."""
        data = self._cases[number].data
        beside = [
            (goal.target, goal.zone, goal.target.measure.within, goal.values(number, len(data))) for goal in self.beside
        ]
        return [(self.target, self.zone, self.within, data), *beside]

    def _judged(self, number: int) -> DesignVerdict[int]:
        """Judge a design on all targets, by its runs so far."""
        case, each = self._cases[number], []
        for goal, zone, within, values in self._by_target(number):
            exact = self.deterministic or (self.agree and does_not_vary(values, within))
            each.append(judged(number, values, goal, case.level, exact, within, zone, case.least))
        return on_all(each) if self.beside else each[0]

    def _veto(self, number: int, why: str | None) -> None:
        """Make a design fail regardless of the target, unless the reason `why` is None."""
        if why is not None:
            self.vetoed[number] = why
            self.drained |= {number} if self.drains(number) else set()
            self.verdicts[number] = replace(self._judged(number), verdict="fails", each=())
            self._cases[number].looks.clear()


def verdict_steps(
    numbers: Sequence[int], judge: Judge, skip: Callable[[int], bool] = lambda _: False
) -> Procedure[Judge]:
    """Judge designs as far as the budget allows, with simultaneous verdicts; return the judge that holds them.

    A design for which `skip` is true after its first few runs is not judged.
    """
    try:
        for number in numbers:
            yield from judge.glance(number)
            if not skip(number):
                yield from judge.verdict(number)
    except RunsEndedError:
        pass  # the other designs stay without a verdict
    return judge
