"""The judge of designs: whether each meets a target, from runs that are looked at again and again.

For every verdict on a target: of `desim plan`, `size`, `best`, `what-if`, `study` and `serve`.

One schedule of looks (interim analyses, `looks`), one error budget (alpha spending), one cap. Searches say which
designs and which target: the cheapest that meets it (`cheapest`), the smallest, the best, and the live page.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from typing import Generic, Literal, TypeVar

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.statistics.checks import check_confidence
from desim_warehouse.study.statistics.intervals import ANYTHING, Interval, bounds_of, does_not_vary
from desim_warehouse.study.statistics.limits import CAP, COMMON_DAYS, FIRST, FIRST_OF_MEANS, DaysNeeded
from desim_warehouse.study.statistics.procedure import Procedure, RunNumber, request

V = TypeVar("V")
Verdict = Literal["meets", "fails", "undecided"]
GLANCE = 3
"""Runs of a design that may show that it is hopeless, or that it equals another."""
MOST_TO_TELL = 1000
"""The most runs of a design that are named as probably enough to decide."""
_SPARE = 1.5
"""Distance of the mean from the target over the reach of its bounds: if the mean is true, five of six are decided."""
FEWEST_BESIDE = 5  # fewest runs of which one may be called an outlier
_APART = 1.25  # least ratio of the runs of a look to those of the look before


def looks(first: int = FIRST, cap: int = CAP) -> list[tuple[int, float]]:
    """Return the replications at each look (interim analysis), with its share of alpha (alpha spending).

    Each look has half as many again as the one before, up to a cap.

    Source: error split evenly over looks that are fixed beforehand (Bonferroni).
    """
    return _shared([*_growing_to(first, cap - 1), cap])


def looks_of_days(first: int = FIRST, days: DaysNeeded = COMMON_DAYS) -> list[tuple[int, float]]:
    """Return the `looks` of a judge, with one at the fewest days after which a design may be said to meet a target."""
    if first >= days.least:
        return looks(first, days.cap)
    counts = [first]
    for stop in (days.least, days.cap):
        counts += [n for n in _growing_to(counts[-1], stop / _APART) if n > counts[-1]]
        counts += [stop] if stop > counts[-1] else []
    return _shared(counts)


def _growing_to(first: int, last: float) -> list[int]:
    """Replications that grow by half from a first look on, up to a last number."""
    return [*takewhile(lambda n: n <= last, _growing(first))]


def _shared(counts: Sequence[int]) -> list[tuple[int, float]]:
    return [(n, 1 / len(counts)) for n in counts]


def schedule(first: int, cap: int, *, exact: bool) -> list[tuple[int, float]]:
    """Return the `looks` of a procedure; where its runs are `exact`, a single look at one run of each design.

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
    """Return the looks (interim analyses) that so many replications allow: the i-th may spend 1 / (i (i + 1)) of alpha.

    The first is at ten, as waiting costs nothing where runs go on by themselves.

    Source: parts that add up to 1 however long it goes on, most of it used at first, as of Lan & DeMets (1983),
    Discrete sequential boundaries for clinical trials, Biometrika 70(3), 659-663.
    """
    return [(n, 1 / (i * (i + 1))) for i, n in enumerate(_growing_to(FIRST_OF_MEANS, replications), 1)]


def _growing(n: int) -> Iterator[int]:
    while True:
        yield n
        n += max((n + 1) // 2, 2)


@dataclass(frozen=True)
class DesignVerdict(Generic[V]):
    """The verdict on one design.

    `low` and `high` are the bounds the verdict rests on, each valid with `level`; both None where the values
    are `deterministic` and the mean is exact. `outlier`: the replication without which an undecided design would be
    clear; None: there is no such one. `within_zone`: it is known to be about at the target, so that more runs would
    tell nothing that matters. `least`: runs without which it would not have been said to meet the target. `each`: with
    several targets the verdict on each; the design meets if all are met, and fails if one is missed, and its numbers
    are those of the first.
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
        """Whether more runs would decide nothing."""
        return self.verdict != "undecided" or self.within_zone


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
    """Judge a design: it meets the target if even its worse bound does, after at least so many runs.

    It fails if its mean does not, and its better bound does not meet a target that is harder by `zone`, in the
    indicator's unit. So no run that turns out better makes a design fail that met the target before. One whose mean
    is known to within the zone, and lies within it of the target, is about at the target.
    """
    mean = float(np.mean(data))
    if deterministic:
        return DesignVerdict(
            value, "meets" if target.met_by(mean) else "fails", len(data), mean, None, None, level, True, least=least
        )
    verdict, (low, high), within_zone = _verdict(data, mean, target, level, within, zone, least)
    outlier = None
    if verdict == "undecided" and not within_zone and len(data) >= FEWEST_BESIDE:
        farthest = int(np.argmax(np.abs(np.array(data) - mean)))
        others = [*data[:farthest], *data[farthest + 1 :]]
        if _verdict(others, float(np.mean(others)), target, level, within, zone, least)[0] != "undecided":
            outlier = farthest
    return DesignVerdict(value, verdict, len(data), mean, low, high, level, False, within_zone, outlier, least)


def on_all(each: Sequence[DesignVerdict[V]]) -> DesignVerdict[V]:
    """Return the verdict on several targets from the verdicts on each, at one look; all of them hold at once."""
    left = [verdict for verdict in each if verdict.verdict == "undecided"]
    fails = any(verdict.verdict == "fails" for verdict in each)
    return replace(
        each[0],
        verdict="fails" if fails else "undecided" if left else "meets",
        within_zone=bool(left) and all(verdict.within_zone for verdict in left),
        outlier=left[0].outlier if len(left) == 1 and not fails else None,
        each=tuple(each),
    )


def _verdict(
    data: Sequence[float], mean: float, target: Target, level: float, within: Interval, zone: float, least: int
) -> tuple[Verdict, Interval, bool]:
    """Return the verdict, its bounds, and whether the design is known to be close to the target."""
    low, high = bounds_of(data, level, within)
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
    """Return the verdict of the first look that decided, else of the last look; None before the first look.

    A verdict that has fallen stands, so it does not change as further runs come in.

    Args:
        values: of the indicator, replication by replication.
        target: that the mean should meet.
        confidence: that no verdict of `meets` is ever wrong, however many runs there will be; the same of `fails`.
            It holds for all targets on the indicator at once.
        deterministic: the runs use no random numbers, so one is exact.
        within: the range of the indicator, such as (0, 1) for a share.
        least: replications without which no design meets the target.
        agree: runs that agree show that it does not vary: see `does_not_vary`.

    Source: `looks_by`.
    Assumes: what the bounds of one look assume (`intervals.bounds`), whose coverage for skewed output is near the level
    and no more. Of 12,000 streams of a gamma with skewness 1.4, at the target and with a confidence of 95 %, 5.8 % are
    ever called not met, four in five of these at the look of ten values, and 0.2 % met.
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
    """Return how many runs in all would probably decide a design; None if more than `MOST_TO_TELL`.

    Further runs are taken to be like the runs so far, whose mean lies 1.5 times as far from the target as the bounds
    reach: if it were the true mean, five of six such designs would be decided. At least two runs; `level`: see
    `judged`.
    """
    mean = float(np.mean(values))
    wider = math.sqrt(len(values) / (len(values) - 1))  # repeated values vary less than new ones
    nearer = replace(target, value=mean + (target.value - mean) / (_SPARE * wider))

    def told(runs: int) -> bool:
        further = [values[run % len(values)] for run in range(runs)]
        return _verdict(further, float(np.mean(further)), nearer, level, within, 0.0, least)[0] != "undecided"

    counts = range(len(values) + 1, MOST_TO_TELL + 1)
    place = bisect_left(counts, True, key=told)
    return counts[place] if place < len(counts) else None


class RunsEndedError(StudyError):
    """Raised when the runs allowed end before there is an answer."""


@dataclass
class Budget:
    """The number of runs that may still be done."""

    left: int
    spent: int = 0

    def allows(self, runs: int) -> bool:
        """Whether so many more runs may be done."""
        return runs <= self.left

    def take(self, runs: int) -> None:
        """Spend so many runs; raises RunsEndedError where they exceed the budget."""
        if not self.allows(runs):
            raise RunsEndedError("the runs allowed ended before there was an answer")
        self.left -= runs
        self.spent += runs


@dataclass
class _Case:
    """A design that is being judged: looks to come, fewest runs to meet the target, values, share of alpha.

    The share of alpha is its own from its first look on; designs ruled out by their first few runs leave theirs to
    others.
    """

    looks: list[tuple[int, float]]
    least: int
    data: list[float] = field(default_factory=list)
    error: float | None = None
    level: float = math.nan


@dataclass(frozen=True)
class Beside:
    """A further target that designs have to meet, and its indifference zone.

    `values`: of its indicator in the first runs of a design, by the design's number and how many.
    """

    target: Target
    zone: float
    values: Callable[[int, int], list[float]]


@dataclass
class Judge:
    """Judges designs, one look after the other, at levels such that all verdicts hold at once.

    `verdicts` are by number; `vetoed`: why designs fail whatever the target says, `drained`: those
    that fail by their batteries.

    Args:
        target: as "on_time >= 0.95".
        confidence: that no design that misses the target is said to meet it; the same of "fails".
        zone: indifference zone in the indicator's unit: a design that is better than the target by less may be
            taken for one that fails.
        first: replications at the first look at a design.
        days: replications without which a design, by its number, is not said to meet the target, and the most of it;
            one not clear by then is "undecided" and taken as not meeting.
        agree: runs that agree show that it does not vary: see `does_not_vary`.
        deterministic: the models use no random numbers: one run of a design is exact.
        within: what the indicator can be at all.
        budget: runs that may be done (default: as many as it takes).
        veto: why a design fails besides the target, asked after its runs; None: nothing.
        drains: whether a vetoed design fails by its batteries, so that fewer robots on as many chargers may last.
        hopeless: the same, asked after its first `GLANCE` runs, where that is beyond doubt.
        tell: called after each look, when `known` may have changed.
        beside: further targets; a design meets them all, or fails.

    Source: one-sided bounds (`intervals.bounds`); the j-th design that is looked at is judged at
    1 - α / (j (j + 1) · looks · targets), which adds up to α (Bonferroni), however many are.
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

    def verdict(self, number: int) -> Generator[list[RunNumber], Sequence[float], str]:
        """Judge a design by as many runs as it takes, or as there may be, and return its verdict."""
        while not self.closed(number):
            yield from self.look(number)
        return self.verdicts[number].verdict

    @property
    def targets(self) -> tuple[Target, ...]:
        """All targets that a design has to meet."""
        return self.target, *(further.target for further in self.beside)

    def leans(self, number: int) -> bool:
        """Whether the means of a design so far meet all targets."""
        verdict = self.verdicts[number]
        return all(goal.met_by(each.mean) for goal, each in zip(self.targets, verdict.each or (verdict,), strict=True))

    def missed(self, number: int) -> list[Target]:
        """Return the targets that a design was shown to miss."""
        verdict = self.verdicts[number]
        each = zip(self.targets, verdict.each or (verdict,), strict=True)
        return [goal for goal, each_verdict in each if each_verdict.verdict == "fails"]

    def runs(self, number: int) -> int:
        """Return how many runs a design has."""
        return len(self._cases[number].data) if number in self._cases else 0

    def closed(self, number: int) -> bool:
        """Whether no further look at a design is wanted, or possible."""
        return number in self.verdicts and not self._cases[number].looks

    def glance(self, number: int) -> Procedure[None]:
        """Do the first few runs of a design, which decide nothing, but may show that it is hopeless."""
        if number in self._cases or self.deterministic:
            return
        yield from self._run(number, min(GLANCE, self.first))
        self._veto(number, self.hopeless(number))

    def look(self, number: int) -> Procedure[None]:
        """Look at a design once more (interim analysis), after as many further runs as that takes."""
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
        self.verdicts[number] = self._on_all(number)
        self._veto(number, self.veto(number))
        if self.verdicts[number].closed:
            case.looks.clear()
        self.tell(self)

    def known(self, name: Callable[[int], str]) -> str:
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
        """Return the share of alpha of the next design that is looked at."""
        j = 1 + sum(case.error is not None for case in self._cases.values())
        return (1.0 - self.confidence) / (j * (j + 1))

    def _run(self, number: int, runs: int) -> Procedure[None]:
        """Run a design up to so many runs in all."""
        done = self.runs(number)
        self.budget.take(runs - done)
        self._case(number).data += yield from request([(number, r) for r in range(done, runs)])

    def _judged(self, number: int) -> DesignVerdict[int]:
        case = self._cases[number]
        exact = self.deterministic or (self.agree and does_not_vary(case.data, self.within))
        return judged(number, case.data, self.target, case.level, exact, self.within, self.zone, case.least)

    def _on_all(self, number: int) -> DesignVerdict[int]:
        first = self._judged(number)
        others = [self._judged_beside(number, first, further) for further in self.beside]
        return on_all((first, *others)) if others else first

    def _judged_beside(self, number: int, first: DesignVerdict[int], further: Beside) -> DesignVerdict[int]:
        """Judge a design by a further target, on the runs of its verdict on the first target."""
        values, within = further.values(number, first.n), further.target.measure.within
        exact = self.deterministic or (self.agree and does_not_vary(values, within))
        return judged(number, values, further.target, first.level, exact, within, further.zone, first.least)

    def _veto(self, number: int, why: str | None) -> None:
        """Make a design fail whatever its runs say of the target, if there is a reason `why`."""
        if why is not None:
            self.vetoed[number] = why
            self.drained |= {number} if self.drains(number) else set()
            self.verdicts[number] = replace(self._judged(number), verdict="fails")
            self._cases[number].looks.clear()


def verdict_steps(
    numbers: Sequence[int], judge: Judge, skip: Callable[[int], bool] = lambda _: False
) -> Procedure[Judge]:
    """Judge each of these designs as far as the runs go, all verdicts right at once; returns the judge with them.

    A design that `skip` accepts after its first few runs is not judged.
    """
    try:
        for number in numbers:
            yield from judge.glance(number)
            if not skip(number):
                yield from judge.verdict(number)
    except RunsEndedError:
        pass  # the other designs stay without a verdict
    return judge
