"""Tipping points, for `desim plan --uncertain`: the value of an input up to which a fleet meets the target.

Probes are simulated at both ends of the input's range, and then by bisection where the verdict changes. They share
their days, so that only the input differs. The interval reaches from the last probe that runs show to lie on one side
of the target to the first on the other. It assumes only that the verdict changes once. A curve through the probes
would give narrower intervals, but times that rise steeply towards full load, and steps, are not on it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.model import Model, Source, as_model
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.possible import refused
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.judge import judged
from desim_warehouse.study.statistics.procedure import Procedure, request
from desim_warehouse.study.study import searched
from desim_warehouse.study.target import read_target

DAYS, EXACT_DAYS = 10, 1
"""Numbers of runs at each probe, with and without randomness."""
HALVINGS = 4
"""Number of bisections: if runs decide on all probes, the last two are a sixteenth of the range apart."""
MOST_RUNS = (2 + HALVINGS) * DAYS
"""Largest number of runs of an input."""
_LEVEL = 0.975
"""Confidence of each verdict on a probe. Intervals hold more often, as only probes near the threshold are in doubt."""


@dataclass(frozen=True)
class InputThreshold:
    """The tipping point of an input: the value at which it makes the fleet too small, all else as in the model.

    `enough`: whether the fleet suffices at the lowest and at the highest value. `at`: the value at which this changes,
    with its interval `within`; both None if it does not change. `confirmed`: whether runs are conclusive on both sides
    of the threshold or, without a threshold, at both ends of the range; otherwise the interval extends to the end of
    the range.
    """

    key: str
    low: float
    high: float
    enough: tuple[bool, bool]
    at: float | None
    within: tuple[float, float] | None
    confirmed: bool


@dataclass(frozen=True)
class Thresholds:
    """The tipping points of inputs, in the order in which they were named, for the fleet of the model."""

    target: Target
    inputs: tuple[InputThreshold, ...]
    runs: int
    model: Model = field(repr=False, compare=False)
    seed: int


def thresholds(
    model: Source, target: str, uncertain: Mapping[str, tuple[float, float]], *, search: Search = USUAL
) -> Thresholds:
    """Find the tipping point of each input for the fleet of a model, the other inputs as the model has them.

    The tipping point is the value up to which the fleet is enough.

    The arguments, and what is raised, are those of `questions.tipping.tipping_points`.
    """
    goal = read_target(target, (model := as_model(model)).units.names)
    most = MOST_RUNS * len(uncertain)
    if search.runs is not None and search.runs < most:
        raise StudyError(f"{search.runs} runs: too few for {len(uncertain)} inputs, expected at least {most}")
    inputs = [_Input(key, *_range(model, key, ends), goal) for key, ends in uncertain.items()]
    if not inputs:
        raise StudyError("uncertain: nothing, expected keys with their lowest and highest value")
    ends = [(input_.key, end) for input_ in inputs for end in (input_.low, input_.high)]
    cases = {f"{key}={end!r}": {key: end} for key, end in ends}
    study = searched(model, {"design": {"cases": cases}}, search, name="uncertain", target=goal.text)
    numbers = {probe: number for number, probe in enumerate(ends)}
    with study.session(search) as runner:

        def number(key: str, value: float) -> int:
            if (key, value) not in numbers:
                numbers[key, value] = study.grow(runner, f"{key}={value!r}", {key: value})
            return numbers[key, value]

        def steps(exact: bool) -> Procedure[int]:
            return threshold_steps(inputs, number, EXACT_DAYS if exact else DAYS)

        runs = study.carry_out(runner, steps, goal.indicator, failed=goal.missed)
    return Thresholds(goal, tuple(input_.threshold() for input_ in inputs), runs, model, search.seed)


def _range(model: Model, key: str, ends: tuple[float, float]) -> tuple[float, float]:
    low, high = ends
    if not low < high:
        raise StudyError(f"uncertain {key}: {low:g}..{high:g} is no range, expected the lower value first")
    for end in ends:
        if (why := refused(model, {key: end})) is not None:
            raise StudyError(f"uncertain {key}: {end:g} cannot be simulated: {why}")
    return float(low), float(high)


class _Input:
    """An input, and the target's indicator at each of its probes, day by day; one day if there is no randomness."""

    def __init__(self, key: str, low: float, high: float, goal: Target) -> None:
        self.key, self.low, self.high, self.goal = key, low, high, goal
        self.days: dict[float, list[float]] = {}

    def is_enough(self, probe: float) -> bool:
        """Whether the mean at a probe meets the target."""
        return self.goal.met_by(float(np.mean(self.days[probe])))

    @property
    def turns(self) -> bool:
        """Whether the input has a tipping point: the fleet is enough at one end of the range only."""
        return self.is_enough(self.low) != self.is_enough(self.high)

    def is_decided(self, probe: float) -> bool:
        """Whether the runs of a probe show on which side of the target it lies."""
        days, within = self.days[probe], self.goal.measure.within
        return judged(probe, days, self.goal, _LEVEL, len(days) == EXACT_DAYS, within).verdict != "undecided"

    def bracket(self) -> list[float]:
        """Return the probes around the tipping point: one on each side of the target, and undecided ones between.

        At an end of the range, a probe stands for its side even if it is undecided.
        """
        probes, at_low = sorted(self.days), self.is_enough(self.low)
        sure = [probe for probe in probes if probe in (self.low, self.high) or self.is_decided(probe)]
        above = next(probe for probe in sure if self.is_enough(probe) != at_low)
        below = max(probe for probe in sure if probe < above)
        return [probe for probe in probes if below <= probe <= above]

    def next_probe(self) -> float:
        """Return the middle of the wider of the two outer gaps between the probes around the tipping point."""
        probes = self.bracket()
        gaps = (probes[0], probes[1]), (probes[-2], probes[-1])
        begin, end = max(gaps, key=lambda gap: gap[1] - gap[0])
        return (begin + end) / 2

    def threshold(self) -> InputThreshold:
        """Return the tipping point that follows from the runs; between two probes, means are interpolated."""
        enough = self.is_enough(self.low), self.is_enough(self.high)
        if not self.turns:
            are_decided = self.is_decided(self.low) and self.is_decided(self.high)
            return InputThreshold(self.key, self.low, self.high, enough, None, None, are_decided)
        probes = self.bracket()
        first, last = probes[0], probes[-1]
        are_decided = self.is_decided(first) and self.is_decided(last)
        below, above = next(pair for pair in pairwise(probes) if self.is_enough(pair[1]) != enough[0])
        off_below, off_above = (abs(float(np.mean(self.days[probe])) - self.goal.value) for probe in (below, above))
        crossing = below + (above - below) * (off_below / (off_below + off_above))
        return InputThreshold(self.key, self.low, self.high, enough, crossing, (first, last), are_decided)


def threshold_steps(inputs: Sequence[_Input], number: Callable[[str, float], int], days: int) -> Procedure[int]:
    """Request the runs of all inputs at once; `number` gives the design of a probe. Returns how many runs."""
    for input_ in inputs:
        input_.days.clear()  # where runs turn out to be random after all, this starts anew
    yield from _measured([(input_, end) for input_ in inputs for end in (input_.low, input_.high)], number, days)
    turning = [input_ for input_ in inputs if input_.turns]
    for _ in range(HALVINGS):
        yield from _measured([(input_, input_.next_probe()) for input_ in turning], number, days)
    return days * sum(len(input_.days) for input_ in inputs)


def _measured(
    probes: Sequence[tuple[_Input, float]], number: Callable[[str, float], int], days: int
) -> Procedure[None]:
    """Do the runs of some probes, on the same days."""
    values = yield from request([(number(input_.key, probe), day) for input_, probe in probes for day in range(days)])
    for place, (input_, probe) in enumerate(probes):
        input_.days[probe] = list(values[place * days : (place + 1) * days])
