"""Tipping points, for `desim plan --uncertain`: the value of an input up to which a fleet meets the target.

Probes are simulated at both ends of the input's range, and then by bisection where the verdict changes. They share
their days, so that only the input differs. Bisection continues while runs show on which side of the target a probe
lies; the last three probes give the interval (`statistics.thresholds`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.model import Model, Source, as_model
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.possible import refused
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.intervals import t_quantile
from desim_warehouse.study.statistics.procedure import Procedure, request
from desim_warehouse.study.statistics.thresholds import crossing
from desim_warehouse.study.study import searched
from desim_warehouse.study.target import read_target
from desim_warehouse.values.arrays import Floats

DAYS, EXACT_DAYS = 10, 2
"""Numbers of runs at each probe, with and without randomness."""
HALVINGS = 4
"""Largest number of bisections, so that the last two probes around a threshold are a sixteenth of the range apart."""
MOST_RUNS = (2 + HALVINGS) * DAYS
"""Largest number of runs of an input."""
_LEVEL = 0.995
"""Confidence of each end of an interval, which allows for repeated looks: of 300 synthetic plants 95 % hold."""


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
    ends = [(input_.key, end) for input_ in inputs for end in (input_.below, input_.above)]
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
    """An input, the probes around its threshold, and the target's indicator at each probe day by day."""

    def __init__(self, key: str, low: float, high: float, goal: Target) -> None:
        self.key, self.low, self.high, self.goal = key, low, high, goal
        self.below, self.above, self.middle = low, high, (low + high) / 2
        self.days: dict[float, Floats] = {}

    def is_enough(self, probe: float) -> bool:
        """Whether the mean at a probe meets the target."""
        return self.goal.met_by(float(self.days[probe].mean()))

    @property
    def turns(self) -> bool:
        """Whether the input has a tipping point: the fleet is enough at one end of the range only."""
        return self.is_enough(self.low) != self.is_enough(self.high)

    def is_decided(self, probe: float) -> bool:
        """Whether the runs of a probe are enough to show on which side of the target it lies."""
        days = self.days[probe]
        error = t_quantile(len(days) - 1, _LEVEL) * float(days.std(ddof=1)) / math.sqrt(len(days))
        return abs(float(days.mean()) - self.goal.value) > error

    def narrow(self) -> None:
        """Halve the range (bisection): move one end to the middle, and take another middle."""
        if self.is_enough(self.middle) == self.is_enough(self.below):
            self.below = self.middle
        else:
            self.above = self.middle
        self.middle = (self.below + self.above) / 2

    def threshold(self) -> InputThreshold:
        """Return the tipping point that follows from the runs."""
        enough = self.is_enough(self.low), self.is_enough(self.high)
        if not self.turns:
            are_decided = self.is_decided(self.low) and self.is_decided(self.high)
            return InputThreshold(self.key, self.low, self.high, enough, None, None, are_decided)
        probes = [self.below, self.middle, self.above]
        turn = crossing(probes, np.array([self.days[probe] for probe in probes]).T, self.goal.value, _LEVEL)
        assert turn is not None  # the ends lie on different sides of the target
        within = max(turn.low, self.low), min(turn.high, self.high)
        confirmed = math.isfinite(turn.low) and math.isfinite(turn.high)
        return InputThreshold(self.key, self.low, self.high, enough, turn.at, within, confirmed)


def threshold_steps(inputs: Sequence[_Input], number: Callable[[str, float], int], days: int) -> Procedure[int]:
    """Request the runs of all inputs at once; `number` gives the design of a probe. Returns how many runs."""
    yield from _measured([(input_, end) for input_ in inputs for end in (input_.low, input_.high)], number, days)
    halved = [input_ for input_ in inputs if input_.turns]
    for left in reversed(range(HALVINGS)):
        yield from _measured([(input_, input_.middle) for input_ in halved], number, days)
        halved = [input_ for input_ in halved if left and input_.is_decided(input_.middle)]
        for input_ in halved:
            input_.narrow()
    return days * sum(len(input_.days) for input_ in inputs)


def _measured(
    probes: Sequence[tuple[_Input, float]], number: Callable[[str, float], int], days: int
) -> Procedure[None]:
    """Do the runs of some probes, on the same days."""
    values = yield from request([(number(input_.key, probe), day) for input_, probe in probes for day in range(days)])
    for (input_, probe), measured in zip(
        probes, np.reshape(np.asarray(values, float), (len(probes), days)), strict=True
    ):
        input_.days[probe] = measured
