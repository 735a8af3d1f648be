"""Where uncertain inputs tip the answer to another number of robots, and which of them is worth measuring.

Short runs at points spread over all ranges say how many robots each point needs. Where straight lines describe that
well, they say where each input, the others in the middle of their ranges, needs one robot more or less. Runs below and
above that point then confirm it, or move it. The points share their days, which makes differences between them clear;
how many robots the middle needs is found on other days.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np

from desim_warehouse.answer.answered import Answered, with_answer
from desim_warehouse.errors import StudyError
from desim_warehouse.model import Model, Source, as_model
from desim_warehouse.outcome.indicators import find
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.fleet.designs import Designs, refused
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.limits import UNCERTAIN_RUNS
from desim_warehouse.study.statistics.procedure import Procedure, RunNumber, request
from desim_warehouse.study.statistics.thresholds import Crossing, LinearNeed, Worth, crossing, linear_need, worth
from desim_warehouse.study.study import searched
from desim_warehouse.study.target import read_target

Inputs: TypeAlias = tuple[float, ...]
"""A value of each input."""

FEWEST_RUNS = 100
"""With fewer runs not even the needs at the points are known."""
GOOD_FIT = 0.8
"""The adjusted R² below which nothing is said of thresholds."""
_POINTS, _PER_INPUT = 4, 2
"""How many points there are, and how many more for each input: few, so that each has many days."""
_FEWEST_KNOWN = 8
"""Points whose need must be known, or some more than inputs."""
_WAVE = 4
"""Points that are begun together, so that where runs end early, only the last of them are left half known."""
_KNOWN = 0.75
"""The part of the points that were begun whose need must be known."""
_FEWEST_DAYS, _MOST_DAYS = 2, 10
"""Runs of each fleet that is looked at, at a point; more than the fewest only of the two around its need."""
_SHARE, _EACH = 0.5, 5
"""The part of the runs that is kept at most for thresholds, and probes of each input for which they are kept."""
_ODD = 0.005
"""Added to a share and its complement, so that all and none have finite odds."""
_CONFIRMING = 6
"""Days on which each of the probes around a threshold is run; they are others than those of the points."""
_WIDEST, _NARROWEST = 0.35, 0.25
"""Distance of the outer probes from the middle one, as a share of the range."""
_LEVEL = 0.99
"""Of each end of an interval, which may be looked at several times: of 100 made-up plants more than 95 % hold."""
_MOVES = 3
"""Times that probes are moved outwards."""


@dataclass(frozen=True)
class TippingPoint:
    """Where an input makes a fleet too small, the others in the middle: `robots` are enough on one side of `at`.

    `above`: whether they are too few above it, or below it. `low` and `high` are the ends of its interval, which
    reaches to the end of the range where runs did not confirm it on a side (`confirmed`).
    """

    robots: int
    above: bool
    at: float
    low: float
    high: float
    confirmed: bool


@dataclass(frozen=True)
class InputEffect:
    """What an input does to the number of robots over its range, and what knowing it better would save a year.

    `error` is the half-width of the 95 % interval of the effect. `open`: thresholds that lines suggest, and for which
    no runs were left. `worth` is in robots' prices for a year, in the currency of the model where it has such a price.
    """

    key: str
    low: float
    high: float
    effect: float
    error: float
    tips: tuple[TippingPoint, ...]
    open: int
    worth: float


@dataclass(frozen=True)
class TippingPoints(Answered):
    """How the answer depends on what is not known: inputs by what it is worth to know them better, the most first.

    `inputs` are empty where `fit` (adjusted R² of straight lines) is too poor to say anything. `cost` is what not
    knowing costs a year, by the price of a robot (`priced`), or else in robots.
    """

    target: Target
    fit: float
    robots: int
    safe: int
    doubt: float
    cost: float
    priced: bool
    inputs: tuple[InputEffect, ...]
    runs: int
    confidence: float
    model: Model = field(repr=False, compare=False, kw_only=True)
    seed: int = field(default=0, kw_only=True)

    @property
    def says_something(self) -> bool:
        """Whether straight lines describe the needs well enough."""
        return self.fit >= GOOD_FIT


def tipping_points(
    model: Source,
    target: str,
    uncertain: Mapping[str, tuple[float, float]],
    *,
    search: Search = USUAL,
) -> TippingPoints:
    """Find where inputs that are not known exactly tip the number of robots that meets a target.

    Args:
        model: the warehouse, with the chargers that it is to have, and about as many robots: they are looked at first.
        target: such as "on_time >= 95 %".
        uncertain: key of the model -> the lowest and the highest value that it may have.
        search: how runs are done, at most 250. Its confidence: that the safe fleet is enough; intervals have 95 %.

    Raises:
        StudyError: no range, a bad target, too few runs, or an end of a range with which nothing can be simulated.

    Source: Sobol points, least squares, `statistics.thresholds`.
    """
    goal = read_target(target, (model := as_model(model)).units.names)
    if (runs := search.runs or UNCERTAIN_RUNS) < FEWEST_RUNS:
        raise StudyError(f"{runs} runs: too few to find where the answer tips, expected at least {FEWEST_RUNS}")
    ranges = {key: _range(key, ends) for key, ends in uncertain.items()}
    fleets = _fleets(model, ranges)
    ends = tuple(ranges.values())
    middle = tuple((low + high) / 2 for low, high in ends)
    factors = {"design": {"cases": {"the middle": _changes(ranges, middle, fleets[0])}}}
    study = searched(model, factors, search, name="uncertain", target=goal.text)
    with study.session(search) as runner:
        numbers = {(middle, fleets[0]): 0}

        def number(values: Inputs, size: int) -> int:
            if (values, size) not in numbers:
                label = ", ".join(f"{key}={value:g}" for key, value in zip(ranges, values, strict=True))
                changes = _changes(ranges, values, size)
                numbers[values, size] = study.grow(runner, f"{label}, fleet.size={size}", changes)
            return numbers[values, size]

        def steps(exact: bool) -> Procedure[TippingSearch]:
            begin = min(int(np.searchsorted(fleets, model.fleet.size)), len(fleets) - 1)
            return TippingSearch(ends, fleets, goal, number, runs, search.seed, begin, exact=exact).steps()

        found = study.carry_out(runner, steps, goal.indicator, failed=goal.missed)
    return with_answer(found.answer(tuple(ranges), model, search.confidence), search.out)


def _fleets(model: Model, ranges: Mapping[str, tuple[float, float]]) -> list[int]:
    """The fleets that may be needed; raises StudyError for no range, or one whose end cannot be simulated."""
    if not ranges:
        raise StudyError("uncertain: nothing, expected keys with their lowest and highest value")
    most = 2 * max(Designs(model).counts(1.0)[0])
    fleets = [size for size in range(1, most + 1) if refused(model, {"fleet.size": size}) is None]
    for key, ends in ranges.items():
        for end in ends:
            if (why := refused(model, {key: end, "fleet.size": fleets[-1]})) is not None:
                raise StudyError(f"uncertain {key}: {end:g} cannot be simulated: {why}")
    return fleets


def _range(key: str, ends: tuple[float, float]) -> tuple[float, float]:
    low, high = ends
    if not low < high:
        raise StudyError(f"uncertain {key}: {low:g}..{high:g} is no range, expected the lower value first")
    return float(low), float(high)


def _changes(keys: Mapping[str, Any], values: Inputs, size: int) -> dict[str, Any]:
    return {**dict(zip(keys, values, strict=True)), "fleet.size": size}


@dataclass
class _Point:
    """A point of the ranges, and what fleets, by their rank, do there day by day."""

    values: Inputs
    runs: dict[int, list[float]] = field(default_factory=dict)

    @property
    def found(self) -> dict[int, float]:
        """Their means."""
        return {rank: sum(values) / len(values) for rank, values in self.runs.items()}


class TippingSearch:
    """One search: `steps` is a procedure that asks for runs and returns the search itself, which has the answer."""

    def __init__(
        self,
        ranges: Sequence[tuple[float, float]],
        fleets: Sequence[int],
        goal: Target,
        number: Callable[[Inputs, int], int],
        runs: int,
        seed: int,
        begin: int,
        *,
        exact: bool = False,
    ) -> None:
        """A search that is yet to begin; `number` gives the number by which runs of a design are asked for.

        `begin` is the rank of the fleet that is looked at first: one that may be about right, as much larger ones may
        run flat at the chargers that there are.
        """
        self.ranges, self.fleets, self.goal, self.number = ranges, fleets, goal, number
        self.runs, self.left, self.seed, self.begin = runs, runs, seed, begin
        self.days = [1] if exact else list(range(_FEWEST_DAYS, _MOST_DAYS + 1))
        self.confirming = 2 if exact else _CONFIRMING
        self.need: LinearNeed | None = None
        self.worth: Worth | None = None
        self.tips: list[list[TippingPoint]] = [[] for _ in ranges]
        self.open = [0] * len(ranges)

    def steps(self) -> Procedure[TippingSearch]:
        """Needs at points, lines through them, and runs around each threshold, those first that are worth most."""
        shares = self._shares()
        points = [_Point(self._at(row)) for row in shares]
        yield from self._needs(shares, points)
        known = [(row, point) for row, point in zip(shares, points, strict=True) if (self._bracket(point) is not None)]
        needs = [self._latent(point) for _, point in known]
        begun = sum(bool(point.runs) for point in points)
        if len(needs) < max(len(self.ranges) + _POINTS, _FEWEST_KNOWN, _KNOWN * begun):
            return self
        self.need = linear_need(np.array([row for row, _ in known]), needs)
        if self.need.fit < GOOD_FIT:
            return self
        middle = yield from self._middle(self.need.middle)
        self.need = replace(self.need, middle=middle)
        self.worth = worth(self.need)
        order = sorted(range(len(self.ranges)), key=lambda rank: -self.worth.inputs[rank] if self.worth else 0.0)
        wanted = [(rank, robots) for rank in order for robots in self._crossed(rank)]
        for rank, robots in sorted(wanted, key=lambda one: abs(one[1] - self.need.middle) if self.need else 0.0):
            tip = yield from self._tip(rank, robots)
            if tip is not None:
                self.tips[rank].append(tip)
        return self

    def answer(self, keys: Sequence[str], model: Model, confidence: float) -> TippingPoints:
        """What came out, in the model's price of a robot a year, or in robots where it has none."""
        price = 0.0 if model.prices is None else model.prices.robot
        about: dict[str, Any] = {"model": model, "seed": self.seed}
        fit = math.nan if self.need is None else self.need.fit
        done = self.runs - self.left
        if self.need is None or self.worth is None:
            return TippingPoints(self.goal, fit, 0, 0, math.nan, math.nan, price > 0, (), done, confidence, **about)
        found = worth(self.need, confidence)
        effects = [
            InputEffect(
                key,
                *self.ranges[rank],
                self.need.effects[rank],
                self.need.errors[rank],
                tuple(sorted(self.tips[rank], key=lambda tip: tip.at)),
                self.open[rank],
                (price or 1.0) * found.inputs[rank],
            )
            for rank, key in enumerate(keys)
        ]
        effects.sort(key=lambda one: (-one.worth, -abs(one.effect)))
        return TippingPoints(
            self.goal,
            fit,
            found.middle,
            found.safe,
            found.doubt,
            (price or 1.0) * found.cost,
            price > 0,
            tuple(effects),
            done,
            confidence,
            **about,
        )

    # Needs at points

    def _shares(self) -> Any:
        from scipy.stats import qmc

        inputs = len(self.ranges)
        sampler = qmc.Sobol(inputs, rng=np.random.default_rng(self.seed))
        count = max(_POINTS + _PER_INPUT * inputs, _FEWEST_KNOWN + _WAVE)
        return sampler.random(1 << (count - 1).bit_length())[:count]

    def _at(self, shares: Sequence[float]) -> Inputs:
        ends = zip(shares, self.ranges, strict=True)
        return tuple(float(f"{low + share * (high - low):.6g}") for share, (low, high) in ends)

    def _needs(self, shares: Any, points: Sequence[_Point]) -> Procedure[None]:
        """See of each point which fleet is the smallest that is enough, as far as the runs for points go.

        Points that come later begin at the need that those before suggest.
        """
        kept = int(min(_SHARE * self.runs, self.confirming * _EACH * (1 + len(self.ranges))))
        begin = [self.begin] * len(points)
        waves = [(upto, self.days[0]) for upto in (1, *range(len(self.ranges) + 3, len(points), _WAVE))]
        waves += [(len(points), days) for days in self.days]
        for upto, days in waves:
            while True:
                asked: dict[tuple[int, int], int] = {}
                left = self.left - kept
                for n in range(upto):
                    for rank in self._wanted(points[n], begin[n], days):
                        more = days - len(points[n].runs.get(rank, ()))
                        if more <= left:
                            asked[n, rank], left = more, left - more
                if not asked:
                    break
                yield from self._on_days(
                    [(points[n].values, points[n].runs.setdefault(rank, []), rank) for n, rank in asked], days
                )
            begin = self._begin(shares, points[:upto])

    def _wanted(self, point: _Point, begin: int, days: int) -> list[int]:
        """The fleet to look at next, or those around the need that are known by too few days."""
        following = self._next(point, begin)
        if following is not None:
            return [following]
        return [rank for rank in self._bracket(point) or () if len(point.runs[rank]) < days]

    def _begin(self, shares: Any, points: Sequence[_Point]) -> list[int]:
        """The rank of the fleet to look at first at each point, by the needs that are known."""
        known = [n for n, point in enumerate(points) if self._bracket(point) is not None]
        needs = [self._latent(points[n]) for n in known]
        if len(needs) >= len(self.ranges) + 2:
            lines = linear_need(shares[known], needs)
            said = lines.middle + (shares - 0.5) @ np.array(lines.effects)
        else:
            said = np.full(len(shares), np.mean(needs) if needs else self.fleets[self.begin])
        return [min(int(np.searchsorted(self.fleets, need)), len(self.fleets) - 1) for need in said]

    def _next(self, point: _Point, begin: int) -> int | None:
        """The fleet to look at next: farther while one side is open, then halfway; None where the need is known."""
        if not point.found:
            return begin
        enough = [rank for rank, mean in point.found.items() if self.goal.met_by(mean)]
        most = min(enough, default=len(self.fleets))
        short = [rank for rank in point.found if rank < most and rank not in enough]  # larger ones may run flat
        least = max(short, default=-1)
        if most - least <= 1:
            return None
        if not short:
            return max(most - 1 if len(enough) == 1 else most - 2 ** (len(enough) - 1), 0)
        if not enough:
            return min(least + 1 if len(short) == 1 else least + 2 ** (len(short) - 1), len(self.fleets) - 1)
        return (least + most) // 2

    def _bracket(self, point: _Point) -> tuple[int, int] | None:
        """Two fleets beside each other of which one is too small; None where no such are known."""
        enough = min((rank for rank, mean in point.found.items() if self.goal.met_by(mean)), default=None)
        if enough is None or enough - 1 not in point.found:
            return None
        return enough - 1, enough

    def _latent(self, point: _Point) -> float:
        """The need between two fleets: the share of a robot by which the smaller one is too small."""
        ranks = self._bracket(point)
        assert ranks is not None
        short, enough = ranks
        low, bound, high = map(self._straight, (point.found[short], self.goal.value, point.found[enough]))
        part = (bound - low) / (high - low)
        return self.fleets[short] + part * (self.fleets[enough] - self.fleets[short])

    def _middle(self, guess: float) -> Generator[list[RunNumber], Sequence[float], float]:
        """The need in the middle of all ranges on other days than those of the points, which may all be hard ones."""
        point = _Point(self._at([0.5] * len(self.ranges)))
        begin = min(int(np.searchsorted(self.fleets, guess)), len(self.fleets) - 1)
        while (rank := self._next(point, begin)) is not None and self.left >= self.confirming:
            point.runs[rank] = yield from self._beside(point.values, self.fleets[rank])
        return guess if self._bracket(point) is None else self._latent(point)

    def _straight(self, mean: float) -> float:
        """A mean on a scale on which it rises evenly with robots: shares do so by their odds, as all is the most."""
        if not find(self.goal.indicator).is_share:
            return mean
        return math.log((mean + _ODD) / (1 - mean + _ODD))

    # Around a threshold

    def _crossed(self, rank: int) -> list[int]:
        """Fleets that are enough at one end of a range and not at the other: the two nearest to that in the middle."""
        assert self.need is not None
        ends = self.need.middle - self.need.effects[rank] / 2, self.need.middle + self.need.effects[rank] / 2
        found = [robots for robots in self.fleets if min(ends) < robots < max(ends)]
        below = [robots for robots in found if robots < self.need.middle]
        return [*below[-1:], *[robots for robots in found if robots >= self.need.middle][:1]]

    def _tip(self, rank: int, robots: int) -> Generator[list[RunNumber], Sequence[float], TippingPoint | None]:
        """Where an input makes a fleet too small, by runs on both sides; None: nowhere in its range."""
        assert self.need is not None
        low, high = self.ranges[rank]
        span, effect = high - low, self.need.effects[rank]
        guess = (low + high) / 2 + (robots - self.need.middle) / effect * span
        apart = min(max(2 * self.need.spread / abs(effect), _NARROWEST), _WIDEST) * span
        middle = min(max(guess, low + _NARROWEST * span / 2), high - _NARROWEST * span / 2)
        probes = [max(middle - apart, low), middle, min(middle + apart, high)]
        values: dict[float, list[float]] = {}
        for _ in range(_MOVES):
            if self.left < self.confirming * sum(probe not in values for probe in probes):
                self.open[rank] += 1
                return None
            for probe in probes:
                if probe not in values:
                    inputs = list(self._at([0.5] * len(self.ranges)))
                    inputs[rank] = probe
                    values[probe] = yield from self._beside(tuple(inputs), robots)
            found = crossing(probes, np.array([values[probe] for probe in probes]).T, self.goal.value, _LEVEL)
            if found is not None and math.isfinite(found.low) and math.isfinite(found.high):
                break
            moved = self._moved(rank, probes, values, found, apart)
            if moved == probes:
                break
            probes = moved
        if found is None:
            return None
        confirmed = math.isfinite(found.low) and math.isfinite(found.high)
        return TippingPoint(robots, effect > 0, found.at, max(found.low, low), min(found.high, high), confirmed)

    def _moved(
        self,
        rank: int,
        probes: list[float],
        values: Mapping[float, Sequence[float]],
        found: Crossing | None,
        apart: float,
    ) -> list[float]:
        """Probes moved towards where the crossing must be, or apart where one of its sides was not told from it."""
        low, high = self.ranges[rank]
        if found is not None:
            first = probes[0] if math.isfinite(found.low) else max(probes[0] - apart, low)
            last = probes[2] if math.isfinite(found.high) else min(probes[2] + apart, high)
            return [first, probes[1], last]
        mean = sum(values[probes[1]]) / len(values[probes[1]])
        enough = self.goal.met_by(mean)
        upwards = enough == (self.need is not None and self.need.effects[rank] > 0)
        if upwards:
            return probes if probes[2] == high else [probes[1], probes[2], min(probes[2] + apart, high)]
        return probes if probes[0] == low else [max(probes[0] - apart, low), probes[0], probes[1]]

    def _beside(self, inputs: Inputs, robots: int) -> Procedure[list[float]]:
        """What a fleet does with some inputs on each of the confirming days."""
        design = self.number(inputs, robots)
        self.left -= self.confirming
        found = yield from request([(design, _MOST_DAYS + day) for day in range(self.confirming)])
        return list(found)

    def _on_days(self, wanted: Sequence[tuple[Inputs, list[float], int]], days: int) -> Procedure[None]:
        """Add to lists of runs, each of inputs and the rank of a fleet, those that are missing of so many days."""
        asked = [
            (known, (self.number(values, self.fleets[rank]), day))
            for values, known, rank in wanted
            for day in range(len(known), days)
        ]
        self.left -= len(asked)
        found = yield from request([run for _, run in asked])
        for (known, _), value in zip(asked, found, strict=True):
            known.append(value)
