"""The cheapest of designs with two counts, such as robots and chargers, that meets a target.

A scout looks for it with a few runs of each probe. A proof then judges, with fresh runs, the design that the scout
names and those that rule out every cheaper one. So runs are spent where the answer is, not on the way there.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence
from desim_warehouse.study.statistics.intervals import ANYTHING
from desim_warehouse.study.statistics.procedure import Procedure, request
from desim_warehouse.study.statistics.sizes.larger import Larger, larger_steps
from desim_warehouse.study.statistics.sizes.sizing import judged, looks_at

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Mapping, Sequence

    from desim_warehouse.study.statistics.intervals import Interval
    from desim_warehouse.study.statistics.procedure import RunNumber
    from desim_warehouse.study.statistics.sizes.sizing import DesignVerdict
    from desim_warehouse.study.statistics.targets import Target

Counts: TypeAlias = tuple[int, int]
"""The two counts of a design."""
Cost: TypeAlias = "Callable[[Counts], tuple[float, ...]]"
"""What a design costs: a key to sort by, which no count may lower."""
GLANCE = 3
"""Runs of a design that may show that it is hopeless, or that nothing is new about it."""


@dataclass(frozen=True)
class Cheapest:
    """The cheapest design shown to meet the target, and what shows it.

    `design` is None if none was shown to. `verdicts` are those judged, by number, in their order; `below` are the
    designs that rule out all cheaper ones, each of them judged. `close` are those of them that could not be told
    from the target. `vetoed`: why designs fail whatever the target says. `open`: designs of which nothing is known, as
    the runs allowed ended before an answer; then `design` is the cheapest known to meet the target so far. `larger`:
    designs with one more of a count; where one of them does worse, no design was ruled out by another.
    """

    design: int | None
    below: tuple[int, ...]
    verdicts: Mapping[int, DesignVerdict[int]]
    vetoed: Mapping[int, str]
    runs: int
    confidence: float
    zone: float
    open: tuple[int, ...] = ()
    larger: tuple[Larger, ...] = ()

    @property
    def close(self) -> tuple[int, ...]:
        """Designs that rule out cheaper ones by default only: too close to tell within the runs allowed."""
        return tuple(number for number in self.below if self.verdicts[number].verdict == "undecided")


class RunsEndedError(StudyError):
    """There may be no more runs, and there is no answer yet."""


@dataclass
class Budget:
    """How many runs may still be done."""

    left: int
    spent: int = 0

    def allows(self, runs: int) -> bool:
        """Whether this number more may be done."""
        return runs <= self.left

    def take(self, runs: int) -> None:
        """This number is done."""
        self.left -= runs
        self.spent += runs


def scout_steps(
    designs: Sequence[Counts], cost: Cost, target: Target, replications: int, budget: Budget
) -> Procedure[set[int]]:
    """Look for the cheapest design with a few runs of each probe; returns the numbers of those that failed.

    It bisects the first count with the most of the second, then the second count. Where a larger first count may cost
    less than what it saves of the second, it looks there, too. The means of so few runs are no proof.

    Raises:
        RunsEndedError: a budget that ends before the search does.
    """
    number = {design: rank for rank, design in enumerate(designs)}
    firsts, seconds = sorted({first for first, _ in designs}), sorted({second for _, second in designs})
    found: dict[Counts, bool] = {}

    def meets(first: int, second: int) -> Generator[list[RunNumber], Sequence[float], bool]:
        design = firsts[first], seconds[second]
        if design not in found:
            if not budget.allows(replications):
                raise RunsEndedError("the runs allowed do not even suffice for a first search")
            budget.take(replications)
            values = yield from request([(number[design], r) for r in range(replications)])
            found[design] = target.met_by(sum(values) / replications)
        return found[design]

    low, first = -1, len(firsts)
    while first - low > 1:
        probe = (low + first) // 2
        if (yield from meets(probe, len(seconds) - 1)):
            first = probe
        else:
            low = probe
    second = len(seconds) - 1
    best = None
    while first < len(firsts):
        low = -1
        while second - low > 1:
            probe = (low + second) // 2
            if (yield from meets(first, probe)):
                second = probe
            else:
                low = probe
        best = firsts[first], seconds[second]
        # A larger first count is worth a look where the cheapest design that saves a second one is cheaper.
        first += 1
        while first < len(firsts) and second and cost((firsts[first], seconds[0])) < cost(best):
            affordable = [j for j in range(second) if cost((firsts[first], seconds[j])) < cost(best)]
            if (yield from meets(first, affordable[-1])):
                second = affordable[-1]
                break
            first += 1
        else:
            break
    return {number[design] for design, met in found.items() if not met}


@dataclass
class _Case:
    """A design that is being judged: the level of its bounds, the looks still to come, and its values so far."""

    level: float
    looks: list[int]
    data: list[float] = field(default_factory=list)


@dataclass
class Judge:
    """Judges designs, one look after the other; the j-th at a level such that all verdicts hold at once.

    `verdicts` are those given, by number; `vetoed`: why designs fail whatever the target says.

    Args:
        target: as "on_time >= 0.95".
        confidence: that all verdicts are right.
        zone: indifference zone in the indicator's unit: a design that is better than the target by less may be
            taken for one that fails.
        n0: replications at the first look at a design. Every further look doubles them.
        cap: most replications of a design; one not clear by then is "undecided" and taken as not meeting.
        deterministic: the models use no random numbers: one run of a design is exact.
        within: what the indicator can be at all.
        budget: runs that may be done (default: as many as it takes).
        veto: why a design fails besides the target, asked after its runs; None: nothing.
        hopeless: the same, asked after its first `GLANCE` runs, where that is beyond doubt.

    Source: one-sided bounds (`intervals.bounds`); the j-th design is judged at 1 - α / (j (j + 1) · looks), which
    adds up to α (Bonferroni), however many are judged.
    Assumes: as `bounds`.
    """

    target: Target
    confidence: float = 0.95
    zone: float = 0.0
    n0: int = 10
    cap: int = 320
    deterministic: bool = False
    within: Interval = ANYTHING
    budget: Budget = field(default_factory=lambda: Budget(10**9))
    veto: Callable[[int], str | None] = lambda _: None
    hopeless: Callable[[int], str | None] = lambda _: None
    verdicts: dict[int, DesignVerdict[int]] = field(default_factory=dict, init=False)
    vetoed: dict[int, str] = field(default_factory=dict, init=False)
    _cases: dict[int, _Case] = field(default_factory=dict, init=False)

    def verdict(self, number: int) -> Generator[list[RunNumber], Sequence[float], str]:
        """Of a design, from as many runs as it takes, or as there may be."""
        while not self.closed(number):
            yield from self.look(number)
        return self.verdicts[number].verdict

    def closed(self, number: int) -> bool:
        """Whether no further look at a design is wanted, or possible."""
        return number in self.verdicts and not self._cases[number].looks

    def glance(self, number: int) -> Procedure[None]:
        """Do the first few runs of a design. They say nothing of the target, but may show that it is hopeless."""
        if number in self._cases or self.deterministic:
            return
        yield from self._run(number, min(GLANCE, self.n0))
        self._veto(number, self.hopeless(number))

    def look(self, number: int) -> Procedure[None]:
        """Look at a design once more, after as many further runs as that takes."""
        yield from self.glance(number)
        if self.closed(number):
            return
        case = self._case(number)
        runs = case.looks.pop(0)
        if number in self.verdicts and not self.budget.allows(runs - len(case.data)):
            case.looks.clear()
            return
        yield from self._run(number, runs)
        found = self._judged(number)
        self.verdicts[number] = found
        self._veto(number, self.veto(number))
        if found.verdict != "undecided" or found.within_zone:
            case.looks.clear()

    def _case(self, number: int) -> _Case:
        if number not in self._cases:
            j = len(self._cases) + 1
            looks = [1] if self.deterministic else looks_at(self.n0, self.cap)
            self._cases[number] = _Case(1.0 - (1.0 - self.confidence) / (j * (j + 1) * len(looks)), looks)
        return self._cases[number]

    def _run(self, number: int, runs: int) -> Procedure[None]:
        """Have a design run so many times in all."""
        done = len(self._cases[number].data) if number in self._cases else 0
        if not self.budget.allows(runs - done):
            raise RunsEndedError("the runs allowed ended before there was an answer")
        self.budget.take(runs - done)
        self._case(number).data += yield from request([(number, r) for r in range(done, runs)])

    def _judged(self, number: int) -> DesignVerdict[int]:
        case = self._cases[number]
        return judged(number, case.data, self.target, case.level, self.deterministic, self.within, self.zone)

    def _veto(self, number: int, why: str | None) -> None:
        """A design fails whatever the target says, if there is a reason."""
        if why is not None:
            self.vetoed[number] = why
            self.verdicts[number] = replace(self._judged(number), verdict="fails")
            self._cases[number].looks.clear()


def verdict_steps(
    numbers: Sequence[int], judge: Judge, known: Callable[[int], bool] = lambda _: False
) -> Procedure[Judge]:
    """The verdict on each of these designs, as far as the runs go, all right at once; returns the judge, who knows.

    A design that is `known` by its first few runs is not judged.
    """
    try:
        for number in numbers:
            yield from judge.glance(number)
            if not known(number):
                yield from judge.verdict(number)
    except RunsEndedError:
        pass  # of the others nothing is known
    return judge


def cheapest_meeting_steps(
    designs: Sequence[Counts], cost: Cost, judge: Judge, doubted: Iterable[int] = ()
) -> Procedure[Cheapest]:
    """The cheapest design whose mean indicator meets the target, and that no cheaper one does by more than its zone.

    Args:
        designs: every pair of counts that could be built.
        cost: what one costs.
        judge: knows the target, and has judged nothing yet.
        doubted: numbers of designs that a search with other runs found to fail: looked at only to rule out.

    Source: see `Judge`.
    Assumes: as `Judge`; that no design does worse than one with less of both counts. Where one with one more of a count
    than the answer does, the cheaper ones are judged one after the other, the cheapest first.
    """
    check_confidence(judge.confidence)
    if not designs or len(set(designs)) < len(designs) or judge.zone < 0:
        given = f"designs {list(designs)[:6]!r}, zone {judge.zone:g}"
        raise StudyError(f"{given}: expected some, none twice, and a zone from 0")
    before = judge.budget.spent
    proof = _Proof(designs, cost, judge, set(doubted))
    try:
        yield from proof.steps()
    except RunsEndedError:
        proof.end_early()
    return Cheapest(
        proof.best,
        proof.needed(),
        judge.verdicts,
        judge.vetoed,
        judge.budget.spent - before,
        judge.confidence,
        judge.zone,
        tuple(proof.open),
        proof.larger,
    )


class _Proof:
    """The state of `cheapest_meeting_steps`: the best design so far, and those known to fail."""

    def __init__(self, designs: Sequence[Counts], cost: Cost, judge: Judge, doubts: set[int]) -> None:
        self.designs = designs
        self.judge = judge
        self.doubts = doubts
        self.order = sorted(range(len(designs)), key=lambda n: cost(designs[n]))
        self.failing: set[int] = set()
        self.best: int | None = None
        self.open: list[int] = []
        self.larger: tuple[Larger, ...] = ()

    def steps(self) -> Procedure[None]:
        """Judge candidates until a design meets the target and no cheaper one is left that might."""
        designs, judge = self.designs, self.judge
        top = max(self.order, key=lambda n: designs[n])
        while self.best is None and top not in self.failing:
            yield from self._try(next((n for n in self.order if not self._ruled_out(n, self.doubts)), top))
        self.open = self._cheaper()
        while self.best is not None and self.open:
            yield from self._meets(self._next(self.best))
            self.open = self._cheaper()
        if self.best is None:
            return
        self.larger = yield from larger_steps(
            self.best,
            designs,
            judge.target,
            judge.verdicts[self.best].n,
            judge.confidence,
            judge.budget,
            deterministic=judge.deterministic,
        )
        if any(one.worse for one in self.larger):
            for number in self.order[: self.order.index(self.best)]:
                if (yield from self._meets(number)):
                    break

    def _try(self, number: int) -> Procedure[None]:
        """Judge a candidate, unless its looks lean to a failure that is not clear.

        Then the design with as much of the first count and most of the second is judged: if it fails, all of them do.
        """
        judge, first = self.judge, self.designs[number][0]
        most = max((n for n in self.order if self.designs[n][0] == first), key=lambda n: self.designs[n])
        while most != number and not judge.closed(number):
            yield from judge.look(number)
            if not judge.closed(number) and not judge.target.met_by(judge.verdicts[number].mean):
                number = most
        yield from self._meets(number)

    def _next(self, best: int) -> int:
        """Of the cheaper designs that nothing rules out yet, the one to judge next."""
        first = self.designs[best][0]
        beside = [n for n in self.open if self.designs[n][0] == first and not self._covers(n, self.doubts)]
        if beside:  # halve them: the best is one that was judged for them all
            return sorted(beside, key=lambda n: self.designs[n])[len(beside) // 2]
        return max(self.open, key=lambda n: self.designs[n])  # no other of them has more of both

    def end_early(self) -> None:
        """Keep what is certain, as the runs allowed have ended."""
        self.failing = {number for number in self.failing if self.judge.verdicts[number].verdict == "fails"}
        self.open = [number for number in self._before_best() if not self._ruled_out(number)]

    def needed(self) -> tuple[int, ...]:
        """The failing designs that rule out designs cheaper than the best and are not ruled out by another."""
        among = self.failing & set(self._before_best())
        return tuple(sorted((n for n in among if not self._covers(n, among - {n})), key=self.order.index))

    def _meets(self, number: int) -> Generator[list[RunNumber], Sequence[float], bool]:
        """Judge a design. It becomes the best if it meets the target, else it is known to fail."""
        meets = (yield from self.judge.verdict(number)) == "meets"
        if meets:
            self.best = number
        else:
            self.failing.add(number)
        return meets

    def _before_best(self) -> list[int]:
        """The designs cheaper than the best, or all where there is none."""
        return self.order if self.best is None else self.order[: self.order.index(self.best)]

    def _cheaper(self) -> list[int]:
        """Designs cheaper than the best that nothing rules out yet."""
        return [] if self.best is None else [n for n in self._before_best() if not self._ruled_out(n)]

    def _ruled_out(self, number: int, doubts: Iterable[int] = ()) -> bool:
        """Whether a design with as much of both counts fails, or is doubted."""
        return self._covers(number, self.failing.union(doubts))

    def _covers(self, number: int, by: set[int]) -> bool:
        first, second = self.designs[number]
        return any(first <= self.designs[other][0] and second <= self.designs[other][1] for other in by)
