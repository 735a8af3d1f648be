"""The cheapest design that meets a target, of designs with some counts, such as robots, chargers and people.

For `desim plan`, and for `desim size`, whose designs have one count.

A scout (pilot runs) looks for the design with a single run of each probe. A proof then judges, with fresh runs, the
design that the scout names and the designs that rule out all cheaper ones. So runs are spent near the answer.

A design close to the target takes tens of runs, and with too few robots the design is close for each number of
chargers. So a design is judged only while it is forecast to meet the target, which takes a look of five runs, where a
verdict that it meets takes at least 33. Bisection with a look at each probe finds the cheapest design with that
forecast, among those with the first count of a candidate and later among all that are still open. A design that rules
out many others is judged to its end only if it is not forecast to meet the target. On 250 random surfaces of 80 to
1,600 designs with three counts a search takes 195 runs on average, on 250 with two counts 123.

Rejected: comparing the answer with one more of each count. It took 9 % of all runs and changed none of 750 answers, 250
of them on surfaces where more robots do worse from some number on: where a smaller design fails and the answer meets
the target, the verdicts themselves show that more does better there. One robot more is compared nevertheless, since
planners buy a spare one, which may jam the floor or take the others' chargers.

A design is vetoed after three runs if even half of its backlog growth, or half of its battery decline, is too much.
Where the backlog grows by exactly the allowance for chance (3 √n for n arrivals), and departures vary as arrivals do,
the mean of three runs has a standard deviation of √(2n/3). Twice the threshold is then 3.7 standard deviations away: an
error of 1 in 8,000, where a plan's first verdict may be wrong once in 240, its fourth once in 2,400.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.statistics.comparison import paired
from desim_warehouse.study.statistics.intervals import Estimate
from desim_warehouse.study.statistics.judge import Budget, DesignVerdict, Judge, RunsEndedError, looks
from desim_warehouse.study.statistics.procedure import Procedure, request, together
from desim_warehouse.values.arrays import Ints

Counts: TypeAlias = tuple[int, ...]
"""The counts of a design, such as robots and chargers; all designs of a search have equally many."""
Cost: TypeAlias = "Callable[[Counts], tuple[float, ...]]"
"""Function that returns the cost of a design as a sort key, which must not fall as a count grows."""


@dataclass(frozen=True)
class Earlier:
    """Results of an earlier search, as numbers of designs.

    `failing`: designs that fail. `drained`: the failing designs whose batteries run down. `doubted`: designs that
    probably fail. `enough`: a design that probably suffices. `compare`: whether to compare the answer with larger
    designs.
    """

    failing: frozenset[int] = frozenset()
    doubted: frozenset[int] = frozenset()
    enough: int | None = None
    compare: bool = True
    drained: frozenset[int] = frozenset()


NOTHING = Earlier()


@dataclass(frozen=True)
class Larger:
    """The comparison of a larger design (`number`) with a smaller one (`base`) in the indicator of a target.

    The larger design is `worse` if the difference is significant and its mean is at least the indifference zone.
    """

    base: int
    number: int
    difference: Estimate
    worse: bool
    target: Target


@dataclass(frozen=True)
class Cheapest:
    """The cheapest design shown to meet the target, and the verdicts that show it.

    `design` is None if no design was shown to meet the target. `verdicts`: the verdict on each design judged to its
    end, by number, in the order of judging. `below`: judged designs that rule out all cheaper ones; `close`: the
    undecided among these. `vetoed`: reasons why designs fail regardless of the target. `drained`: designs whose
    batteries run down, here or in an earlier search. `open`: designs without a result because the budget of runs
    was exhausted; `design` is then the cheapest shown so far to meet the target. `larger`: comparisons with larger
    designs: of the answer with one more of its first count; of a smaller fleet with the design that rules it out, where
    that has more of the counts after the first; or, where the largest design fails, of the largest with the design of
    half its first count. If any larger design does worse, no design was ruled out by another.
    `against`: the largest and the smallest design contradict the assumed direction, so that cheaper designs were
    judged one by one.
    """

    design: int | None
    below: tuple[int, ...]
    verdicts: Mapping[int, DesignVerdict[int]]
    vetoed: Mapping[int, str]
    runs: int
    open: tuple[int, ...] = ()
    larger: tuple[Larger, ...] = ()
    against: bool = False
    drained: frozenset[int] = frozenset()

    @property
    def close(self) -> tuple[int, ...]:
        """Undecided designs that rule out cheaper ones by default: too close to the target for the runs allowed."""
        return tuple(number for number in self.below if self.verdicts[number].verdict == "undecided")


def scout_steps(
    designs: Sequence[Counts],
    cost: Cost,
    target: Target,
    budget: Budget,
    earlier: Earlier = NOTHING,
    hopeless: Callable[[int], bool] = lambda _: False,
) -> Procedure[set[int]]:
    """Search for the cheapest design with a single run of each probe; return the numbers of the designs that failed.

    Probes bisect the designs: each leaves the fewest, whichever way it turns out. A single run proves nothing. A design
    that is `hopeless` by its run fails even if the run meets the target.

    Raises:
        RunsEndedError: if the budget is exhausted before the search ends.
    """
    order = sorted(range(len(designs)), key=lambda number: cost(designs[number]))
    if earlier.enough is not None:
        order = order[: order.index(earlier.enough)]
    failed = {*earlier.failing, *earlier.doubted}
    order = [n for n in order if not covered(designs, n, failed, earlier.drained)]
    while order:
        rank = _halving([designs[number] for number in order])
        probe = order[rank]
        budget.take(1)
        (value,) = yield from request([(probe, 0)])
        if target.met_by(value) and not hopeless(probe):
            order = order[:rank]
        else:
            failed.add(probe)
            order = [number for number in order if not within_counts(designs[number], designs[probe])]
    return failed


def within_counts(design: Counts, other: Counts) -> bool:
    """Whether no count of a design exceeds the same count of another."""
    return all(map(int.__le__, design, other))


def rules_out(failing: Counts, design: Counts, *, drained: bool) -> bool:
    """Whether a failing design rules out another because it is at least as large in every count.

    A `drained` design, whose batteries run down, rules out only designs with equally many robots, because its chargers
    may suffice for fewer robots.
    """
    return within_counts(design, failing) and (not drained or failing[0] == design[0])


def covered(designs: Sequence[Counts], number: int, by: Collection[int], drained: Collection[int] = ()) -> bool:
    """Whether any failing design in `by` rules out a design; the batteries of `drained` designs run down."""
    return any(rules_out(designs[other], designs[number], drained=other in drained) for other in by)


def ruling_out(
    designs: Sequence[Counts], failing: set[int], shown: set[int], drained: Collection[int] = ()
) -> set[int]:
    """Return the failing designs that no other failing design rules out.

    A design that was `shown` to fail is ruled out only by another shown to fail. `drained`: see `rules_out`.
    """
    return {n for n in failing if not covered(designs, n, (shown if n in shown else failing) - {n}, drained)}


def _halving(designs: Sequence[Counts]) -> int:
    """Return the design to judge next by bisection: the one that leaves the fewest designs, whatever its verdict.

    `designs`: in order of cost.
    """
    return int(np.argmax(np.minimum(_smaller(designs), np.arange(len(designs), 0, -1))))


def _smaller(designs: Sequence[Counts]) -> Ints:
    """Return for each design how many of the designs, itself included, exceed it in no count, shape (designs,)."""
    places = tuple(np.unique(side, return_inverse=True)[1] for side in zip(*designs, strict=True))
    smaller = np.zeros([place.max() + 1 for place in places], int)
    smaller[places] = 1
    for axis in range(smaller.ndim):
        smaller = smaller.cumsum(axis)
    return smaller[places]


def cheapest_meeting_steps(
    designs: Sequence[Counts],
    cost: Cost,
    judge: Judge,
    doubted: Iterable[int] = (),
    *,
    scan: bool = False,
    fewer: bool = False,
    earlier: Earlier = NOTHING,
) -> Procedure[Cheapest]:
    """Find the cheapest design whose mean meets the target; no cheaper design meets it by more than the zone.

    Args:
        designs: counts of all designs that could be built.
        cost: sort key of a design by cost.
        judge: judge with the target, which has not judged any design yet.
        doubted: numbers of designs that failed in a search with other runs: judged only to rule out cheaper designs.
        scan: judge designs one by one, the cheapest first, until one meets the target; none rules out another.
        fewer: whether more of a count is assumed to do worse, not better, for at least one target.
        earlier: results for other demands; designs that fail by them are not judged.

    Source: see `Judge`.
    Assumes: as `Judge`; that a design does no worse than one that is smaller in all counts (no better where `fewer`).
    If a comparison (`Cheapest.larger`) or the smallest and the largest design (`Cheapest.against`) contradict this,
    cheaper designs are judged one by one, the cheapest first.
    """
    if not designs or any(a == b for i, a in enumerate(designs) for b in designs[:i]):
        raise StudyError(f"designs {list(designs)[:6]!r}: expected at least one, none twice")
    before = judge.budget.spent
    proof = _Proof(designs, cost, judge, set(doubted), earlier)
    try:
        yield from proof.scan(proof.order) if scan else proof.fewest() if fewer else proof.steps()
    except RunsEndedError:
        proof.end_early()
    return Cheapest(
        proof.best,
        proof.needed(),
        {number: verdict for number, verdict in judge.verdicts.items() if judge.closed(number)},
        judge.vetoed,
        judge.budget.spent - before,
        tuple(proof.open),
        proof.larger,
        proof.against,
        proof.drained,
    )


class _Proof:
    """The state of `cheapest_meeting_steps`: the best design so far, and the designs known to fail."""

    def __init__(self, designs: Sequence[Counts], cost: Cost, judge: Judge, doubts: set[int], earlier: Earlier) -> None:
        self.designs = designs
        self.judge = judge
        self.doubts = doubts
        self.earlier = earlier
        self.order = sorted(range(len(designs)), key=lambda n: cost(designs[n]))
        self.failing = set(earlier.failing)
        self.best: int | None = None
        self.open: list[int] = []
        self.larger: tuple[Larger, ...] = ()
        self.top = max(self.order, key=lambda n: designs[n])
        self.monotone = True
        self.fewer = False
        self.against = False

    @property
    def drained(self) -> frozenset[int]:
        """The failing designs whose batteries run down."""
        return self.earlier.drained.union(self.judge.drained)

    def steps(self) -> Procedure[None]:
        """Judge candidates until a design meets the target and every cheaper design is ruled out."""
        top = self.top
        while self.best is None and top not in self.failing:
            yield from self._try(next((n for n in self.order if not self._ruled_out(n, self.doubts)), top))
        yield from self._rule_out()
        while self.best is not None and (under := self._under_open()) is not None:
            if (yield from self._meets(under)):
                yield from self._rule_out()
        if self.best is None:
            yield from self._largest(top)
        else:
            yield from self._compare(self.best)
        if any(comparison.worse for comparison in self.larger):
            yield from self.scan(self._before_best())
        elif self.best is None and (yield from self._meets(self.order[0])):
            self.monotone, self.against = False, True

    def fewest(self) -> Procedure[None]:
        """Judge designs, the cheapest first, until one meets the target, where more is assumed to do worse.

        Skip designs that are at least as large in all counts as one that misses the target, or no larger than one that
        was vetoed. If no design meets the target, judge the largest; if that one does, judge all cheaper designs one by
        one.
        """
        self.monotone, self.fewer = False, True
        for number in self.order:
            if not self._worse_than_failing(number) and (yield from self._meets(number)):
                return
        if self.top not in self.failing and (yield from self._meets(self.top)):
            self.against = True
            yield from self.scan(self._before_best())

    def _worse_than_failing(self, number: int) -> bool:
        """Whether a smaller design that misses the target, or a larger vetoed design, rules a design out."""
        vetoed, counts = set(self.judge.vetoed), self.designs[number]
        missed = (n for n in self.failing - vetoed if any(not goal.more_helps for goal in self.judge.missed(n)))
        return self._covers(number, vetoed) or any(within_counts(self.designs[n], counts) for n in missed)

    def _rule_out(self) -> Procedure[None]:
        """Judge designs until all that are cheaper than the best are ruled out."""
        self.open = self._cheaper()
        while self.open:
            yield from self._meets((yield from self._next()))
            self.open = self._cheaper()

    def _under_open(self) -> int | None:
        """Return the largest design with less of the first count than an undecided one, unless that design fails.

        An undecided design shows nothing about smaller designs, which are ruled out only by default.
        """
        for number in self.needed():
            less = [n for n in self.order if self.designs[n][0] < self.designs[number][0]]
            if less and not self._fails(number):
                under = max(less, key=lambda n: self.designs[n])
                if under in self.judge.verdicts and self.judge.verdicts[under].verdict == "meets":
                    continue  # dearer than the best, so it is no answer, and rules nothing out
                if under not in self.failing and not self._covers(under, set(filter(self._fails, self.failing))):
                    return under
        return None

    def _fails(self, number: int) -> bool:
        """Whether a design was shown to fail."""
        return number in self.earlier.failing or self.judge.verdicts[number].verdict == "fails"

    def scan(self, numbers: Sequence[int]) -> Procedure[None]:
        """Judge designs one by one until one meets the target; none rules out another."""
        self.monotone = False
        for number in numbers:
            if (yield from self._meets(number)):
                break

    def _try(self, number: int) -> Procedure[None]:
        """Judge a candidate while it promises to meet the target, then the cheapest with its first count that does.

        The first count is usually the number of robots. If even the largest design with this count does not promise to
        meet the target, that design is judged: if it fails, all designs with the count fail without runs of their own.
        """
        judge, designs = self.judge, self.designs
        row = [n for n in self.order if designs[n][0] == designs[number][0]]
        largest = max(row, key=lambda n: designs[n])
        while number != largest:
            while (yield from self._promises(number)) and not judge.closed(number):
                yield from judge.look(number)
            if judge.closed(number) and (yield from self._meets(number)):
                return
            left = [n for n in row if not self._ruled_out(n)]
            likely = (yield from self._cheapest_promising(left)) if (yield from self._promises(largest)) else None
            number = largest if likely is None else likely
        yield from self._meets(largest)

    def _next(self) -> Procedure[int]:
        """Choose the next cheaper design to judge: the one that would rule out most open designs if it failed.

        If that design promises to meet the target, choose the cheapest open design that does.
        """
        most = self.open[int(np.argmax(_smaller([self.designs[n] for n in self.open])))]
        likely = (yield from self._cheapest_promising(self.open)) if (yield from self._promises(most)) else None
        return most if likely is None else likely

    def _cheapest_promising(self, numbers: Sequence[int]) -> Procedure[int | None]:
        """Return the cheapest of some designs that promises to meet the target; bisect them with a look at each probe.

        `numbers`: in order of cost.
        """
        cheapest, left = None, list(numbers)
        while left:
            rank = _halving([self.designs[n] for n in left])
            if (yield from self._promises(left[rank])):
                cheapest, left = left[rank], left[:rank]
            else:
                left = [n for n in left if not within_counts(self.designs[n], self.designs[left[rank]])]
        return cheapest

    def _promises(self, number: int) -> Procedure[bool]:
        """Return whether a design meets the target or is forecast to; look at it if it was never looked at."""
        judge = self.judge
        if number not in judge.verdicts:
            yield from judge.look(number)
        if judge.closed(number):
            return judge.verdicts[number].verdict == "meets"
        return judge.forecast(number) == "meets"

    def _compare(self, best: int) -> Procedure[None]:
        """Compare designs with larger ones, day by day, because larger designs are assumed to do no worse.

        The best is compared with the design that has one more of its first count. Each design that rules out fewer of
        the first count, with more of the other counts, is compared with the design that has as many of these as the
        best.
        """
        if not self.earlier.compare:
            return
        first, *others = self.designs[best]
        pairs = [((first, *others), (first + 1, *others))]
        for more in (self.designs[number] for number in self.needed()):
            less = (more[0], *others)
            pairs += [(less, more)] if more[0] < first and less != more and within_counts(less, more) else []
        numbers = {design: number for number, design in enumerate(self.designs)}
        numbered = [(numbers[less], numbers[more]) for less, more in pairs if less in numbers and more in numbers]
        larger = yield from together([self._larger(*pair) for pair in numbered])
        self.larger = tuple(filter(None, larger))

    def _largest(self, top: int) -> Procedure[None]:
        """Compare the largest design, where it fails, with the design of half its first count."""
        firsts = sorted({design[0] for design in self.designs})
        middle = (firsts[(len(firsts) - 1) // 2], *self.designs[top][1:])
        half = next((n for n, design in enumerate(self.designs) if design == middle and n != top), None)
        larger = None if half is None else (yield from self._larger(half, top))
        self.larger = (larger,) if larger is not None and larger.worse else ()

    def _larger(self, base: int, number: int) -> Procedure[Larger | None]:
        """Compare a design (`number`) with a smaller one (`base`) on the same days, at half of alpha.

        Return None if no runs are left. While the mean of the larger design is worse by more than half the
        indifference zone, replicate both further, until both have as many runs as the one with more. With
        several targets, return the comparison for the first target on which the larger design is shown to be
        worse, or else for the first target.
        """
        judge = self.judge
        most = max(judge.runs(base), judge.runs(number))
        pairs, result = list[tuple[float, float]](), None
        for n, part in looks(min(judge.first, most), most):
            fresh = sum(max(0, n - max(len(pairs), judge.runs(design))) for design in (base, number))
            if not judge.budget.allows(fresh):
                break
            judge.budget.take(fresh)
            asked = [(design, r) for r in range(len(pairs), n) for design in (base, number)]
            values = yield from request(asked)
            pairs += zip(values[::2], values[1::2], strict=True)
            held = [self._held((base, number), judge.target, judge.zone, pairs, part)]
            for further in judge.beside:
                both = list(zip(further.values(base, n), further.values(number, n), strict=True))
                held.append(self._held((base, number), further.target, further.zone, both, part))
            result = next((comparison for comparison in held if comparison.worse), held[0])
            zones = [judge.zone, *(further.zone for further in judge.beside)]
            if result.worse or all(
                comparison.target.sign * comparison.difference.mean >= -zone / 2
                for zone, comparison in zip(zones, held, strict=True)
            ):
                break
        return result

    def _held(
        self, pair: tuple[int, int], goal: Target, zone: float, values: Sequence[tuple[float, float]], part: float
    ) -> Larger:
        """Compare a design with a smaller one for one target, from the values of both on some days."""
        judge = self.judge
        less, more = zip(*values, strict=True)
        level = 1 - (1 - judge.confidence) / 2 * part / len(judge.targets)
        difference = paired(more, less, level, deterministic=judge.deterministic)
        low, high = difference.interval or (difference.mean, difference.mean)
        shown = (high if goal.sign > 0 else -low) < 0
        return Larger(*pair, difference, shown and abs(difference.mean) >= zone, goal)

    def end_early(self) -> None:
        """Keep only results that are certain once the budget of runs is exhausted."""
        self.failing = set(filter(self._fails, self.failing))
        self.open = [number for number in self._before_best() if not self._ruled_out(number)]

    def needed(self) -> tuple[int, ...]:
        """Return the largest failing designs that together rule out all designs cheaper than the best."""
        among = self.failing & set(self._before_best())
        if self.fewer:
            return tuple(sorted(among, key=self.order.index))
        kept = ruling_out(self.designs, among, set(filter(self._fails, among)), self.drained) - self.earlier.failing
        return tuple(sorted(kept, key=self.order.index))

    def _meets(self, number: int) -> Procedure[bool]:
        """Judge a design: make it the best if it meets the target and is cheaper; add it to `failing` if it fails."""
        meets = (yield from self.judge.verdict(number)) == "meets"
        if meets and number in self._before_best():
            self.best = number
        elif not meets:
            self.failing.add(number)
        return meets

    def _before_best(self) -> list[int]:
        """Return the designs cheaper than the best, or all designs if there is no best."""
        return self.order if self.best is None else self.order[: self.order.index(self.best)]

    def _cheaper(self) -> list[int]:
        """Return designs cheaper than the best that no failing design rules out yet."""
        return [] if self.best is None else [n for n in self._before_best() if not self._ruled_out(n)]

    def _ruled_out(self, number: int, doubts: Iterable[int] = ()) -> bool:
        """Whether a design at least as large in all counts fails, or is doubted."""
        return self._covers(number, self.failing.union(doubts)) if self.monotone else number in self.failing

    def _covers(self, number: int, by: set[int]) -> bool:
        return covered(self.designs, number, by, self.drained)
