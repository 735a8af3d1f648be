"""Times that vary: distributions as a model file has them, checked, drawn and said in words.

numpy draws, and nothing here is random by itself. Estimates before a run take the mean. No distribution has negative
times, and each has a finite mean.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cached_property, partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field, field_validator, model_validator

from desim_warehouse.errors import did_you_mean, got, spoken
from desim_warehouse.findings import amount
from desim_warehouse.values.fields import (
    LIMITS,
    NUMBER,
    Duration,
    Forms,
    Name,
    Part,
    Positive,
    Time,
    Weights,
    form,
    wrong,
)
from desim_warehouse.values.streams import Streams

if TYPE_CHECKING:
    from numpy.random import Generator

_PURE = {"cv", "shape", "alpha", "beta", "weights"}
"""Parameters that are no times."""


class Distribution(Part, ABC):
    """A distribution of times in the model's time unit, none of them negative. Each kind is a section of its own."""

    @property
    @abstractmethod
    def mean(self) -> float:
        """The mean time."""

    @property
    @abstractmethod
    def variance(self) -> float:
        """The mean squared distance from the mean."""

    @abstractmethod
    def draw(self, generator: Generator) -> float:
        """Draw one time."""

    @property
    def kind(self) -> str:
        """The name of the distribution, which is its key in a model file."""
        return next(iter(type(self).model_fields))

    @property
    def cv(self) -> float:
        """Coefficient of variation: standard deviation / mean."""
        return math.sqrt(max(self.variance, 0.0)) / self.mean if self.mean else 0.0

    @property
    def range(self) -> str:
        """The least and the largest time in words, without unit: `from 4 to 12`; empty where mean and cv say all."""
        return ""

    @cached_property
    def has_spread(self) -> bool:
        """Whether the times differ at all; else every one is the mean, and none need be drawn."""
        return self.variance > 0

    def is_random(self, _model: Any) -> bool:
        """Whether the times differ."""
        return self.has_spread

    def words(self, unit: str) -> str:
        """Return the distribution in words, such as `lognormal, mean 8 s, cv 0.4`."""
        between = f" {self.range} {unit}" if self.range else ""
        return f"{self.kind}{between}, mean {amount(self.mean)} {unit}, cv {amount(self.cv)}"

    @model_validator(mode="after")
    def _finite(self) -> Distribution:
        try:
            mean, cv = self.mean, self.cv
        except (OverflowError, ZeroDivisionError):
            mean = cv = math.inf
        if not (mean <= LIMITS["number"][0] and math.isfinite(cv)):
            raise wrong(f"a mean or a spread beyond all bounds, expected a mean of at most {LIMITS['number'][0]:,}")
        return self


class UniformTime(Distribution):
    """`uniform: [4, 12]`: all times between two bounds are equally likely."""

    uniform: tuple[Time, Time] = Field(description="the least and the largest time")

    @field_validator("uniform")
    @classmethod
    def _in_order(cls, ends: tuple[float, float]) -> tuple[float, float]:
        if ends[0] > ends[1]:
            raise wrong(f"turned round (got {got(ends)}), expected the least time first, then the largest")
        return ends

    @property
    def mean(self) -> float:
        return sum(self.uniform) / 2

    @property
    def variance(self) -> float:
        return (self.uniform[1] - self.uniform[0]) ** 2 / 12

    @property
    def range(self) -> str:
        return "from {:g} to {:g}".format(*self.uniform)

    def draw(self, generator: Generator) -> float:
        return float(generator.uniform(*self.uniform))


class TriangularTime(Distribution):
    """`triangular: [4, 6, 12]`: from the least, the usual and the largest time, as people estimate them."""

    triangular: tuple[Time, Time, Time] = Field(description="the least, the most likely and the largest time")

    @field_validator("triangular")
    @classmethod
    def _in_order(cls, times: tuple[float, float, float]) -> tuple[float, float, float]:
        if not times[0] <= times[1] <= times[2] or times[0] == times[2]:
            raise wrong(f"not in order (got {got(times)}), expected the least, the most likely and the largest time")
        return times

    @property
    def mean(self) -> float:
        return sum(self.triangular) / 3

    @property
    def variance(self) -> float:
        a, b, c = self.triangular
        return (a * a + b * b + c * c - a * b - a * c - b * c) / 18

    @property
    def range(self) -> str:
        return f"from {self.triangular[0]:g} to {self.triangular[2]:g}"

    def draw(self, generator: Generator) -> float:
        return float(generator.triangular(*self.triangular))


class ExponentialTime(Distribution):
    """`exponential: 8`: memoryless, given by its mean; cv 1."""

    exponential: Duration = Field(title="mean", description="the mean")

    @property
    def mean(self) -> float:
        return self.exponential

    @property
    def variance(self) -> float:
        return self.exponential**2

    def draw(self, generator: Generator) -> float:
        return float(generator.exponential(self.exponential))


class MeanAndCv(Part):
    """A distribution by its mean and its coefficient of variation."""

    mean: Duration = Field(description="the mean")
    cv: Positive = Field(description="coefficient of variation: standard deviation / mean")


class GammaTime(Distribution):
    """`gamma: {mean: 8, cv: 0.5}`: the sum of several stages; for cv 1 / sqrt(k), Erlang's of k stages."""

    gamma: MeanAndCv = Field(description="mean and cv")

    @property
    def mean(self) -> float:
        return self.gamma.mean

    @property
    def variance(self) -> float:
        return (self.gamma.mean * self.gamma.cv) ** 2

    def draw(self, generator: Generator) -> float:
        shape = self.gamma.cv**-2
        return float(generator.gamma(shape, self.gamma.mean / shape))


class LognormalTime(Distribution):
    """`lognormal: {mean: 8, cv: 0.4}`: mostly near the median, now and then much longer, like people's times."""

    lognormal: MeanAndCv = Field(description="mean and cv, of the times, not of their logarithms")

    @property
    def mean(self) -> float:
        return self.lognormal.mean

    @property
    def variance(self) -> float:
        return (self.lognormal.mean * self.lognormal.cv) ** 2

    def draw(self, generator: Generator) -> float:
        square = math.log1p(self.lognormal.cv**2)
        return float(generator.lognormal(math.log(self.lognormal.mean) - square / 2, math.sqrt(square)))


class ShapeAndScale(Part):
    """A Weibull distribution by its usual parameters."""

    shape: Positive = Field(description="1: exponential; above 1: the longer it lasted, the sooner it ends")
    scale: Duration = Field(description="63.2 % of the times are below it")


class WeibullTime(Distribution):
    """`weibull: {shape: 2, scale: 9}`: lifetimes and repairs, as data sheets give them."""

    weibull: ShapeAndScale = Field(description="shape and scale")

    @property
    def mean(self) -> float:
        return self.weibull.scale * math.gamma(1 + 1 / self.weibull.shape)

    @property
    def variance(self) -> float:
        shape, scale = self.weibull.shape, self.weibull.scale
        return scale**2 * (math.gamma(1 + 2 / shape) - math.gamma(1 + 1 / shape) ** 2)

    def draw(self, generator: Generator) -> float:
        return float(self.weibull.scale * generator.weibull(self.weibull.shape))


class BetaShape(Part):
    """A beta distribution stretched from `least` to `most`."""

    alpha: Positive = Field(description="first shape parameter; with alpha = beta it is symmetric")
    beta: Positive = Field(description="second shape parameter")
    least: Time = Field(0.0, description="the least time")
    most: Duration = Field(description="the largest time")

    @model_validator(mode="after")
    def _in_order(self) -> BetaShape:
        if self.least >= self.most:
            raise wrong(f"not above least (got {got(self.most)}), expected a time above {got(self.least)}", "most")
        return self


class BetaTime(Distribution):
    """`beta: {alpha: 2, beta: 5, least: 4, most: 30}`: nearly any shape between two times."""

    beta: BetaShape = Field(description="alpha, beta, least and most")

    @property
    def mean(self) -> float:
        it = self.beta
        return it.least + (it.most - it.least) * it.alpha / (it.alpha + it.beta)

    @property
    def variance(self) -> float:
        it = self.beta
        both = it.alpha + it.beta
        return (it.most - it.least) ** 2 * it.alpha * it.beta / (both**2 * (both + 1))

    @property
    def range(self) -> str:
        return f"from {self.beta.least:g} to {self.beta.most:g}"

    def draw(self, generator: Generator) -> float:
        it = self.beta
        return it.least + (it.most - it.least) * float(generator.beta(it.alpha, it.beta))


class ValuesAndWeights(Part):
    """Some times, and how often each comes in comparison with the others."""

    values: tuple[Time, ...] = Field(min_length=1, description="the times")
    weights: Weights = Field((), description="one for each value; default: all equal")


class DiscreteTime(Distribution):
    """`discrete: {values: [6, 20], weights: [9, 1]}`: one of a few times."""

    discrete: ValuesAndWeights = Field(description="values and weights")

    @property
    def shares(self) -> list[float]:
        """The probability of each value."""
        it = self.discrete
        weights = it.weights or (1.0,) * len(it.values)
        return [weight / math.fsum(weights) for weight in weights]

    @property
    def mean(self) -> float:
        return math.fsum(p * value for p, value in zip(self.shares, self.discrete.values, strict=True))

    @property
    def variance(self) -> float:
        mean = self.mean
        return math.fsum(p * (value - mean) ** 2 for p, value in zip(self.shares, self.discrete.values, strict=True))

    def draw(self, generator: Generator) -> float:
        return float(generator.choice(self.discrete.values, p=self.shares))


class Observed(Part):
    """Measured times. Reading puts the column of `{file: x.csv, column: load_s}` here."""

    values: tuple[Time, ...] = Field(min_length=1, description="the times that were measured")


class ObservedFile(Part):
    """Measured times from a column of a CSV file."""

    file: Name = Field(description="CSV file, relative to the model file")
    column: Name = Field(description="the column with the times")
    unit: Literal["ms", "s", "min", "h", "d"] | None = Field(
        None, description="of times without one; by default the unit of the model"
    )


class EmpiricalTime(Distribution):
    """`empirical: {file: x.csv, column: load_s}`: one of the measured times, all equally likely."""

    empirical: Annotated[Observed, Forms("a section with file and column, or with values", ObservedFile)] = Field(
        description="file and column, or values"
    )

    @property
    def mean(self) -> float:
        return math.fsum(self.empirical.values) / len(self.empirical.values)

    @property
    def variance(self) -> float:
        mean = self.mean
        return math.fsum((value - mean) ** 2 for value in self.empirical.values) / len(self.empirical.values)

    @property
    def range(self) -> str:
        values = self.empirical.values
        return f"of {len(values)} times from {min(values):g} to {max(values):g}"

    def draw(self, generator: Generator) -> float:
        values = self.empirical.values
        return values[int(generator.integers(len(values)))]


def _known(value: Any) -> Any:
    """Refuse an unknown kind. `{constant: 8}` is 8."""
    if not isinstance(value, Mapping):
        return value
    if list(value) == ["constant"]:
        return value["constant"]
    if not any(key in KINDS for key in value):
        names = ("constant", *KINDS)
        hint = did_you_mean(str(next(iter(value), "")), names)
        raise wrong(f"no such distribution (got {got(value)}), expected {spoken(names, 'or')}{hint}")
    return value


def _form_of(value: Any) -> str | None:
    if isinstance(value, (*NUMBER, str)):
        return "\0number"
    keys = [value.kind] if isinstance(value, Distribution) else value if isinstance(value, Mapping) else ()
    return next((f"\0{key}" for key in keys if key in KINDS), None)


KINDS: dict[str, type[Distribution]] = {
    next(iter(kind.model_fields)): kind
    for kind in (
        UniformTime,
        TriangularTime,
        ExponentialTime,
        GammaTime,
        LognormalTime,
        WeibullTime,
        BetaTime,
        DiscreteTime,
        EmpiricalTime,
    )
}
"""The distributions, by their key in a model file."""

Varying = Annotated[
    Annotated[Time, form("number")]
    | Annotated[UniformTime, form("uniform")]
    | Annotated[TriangularTime, form("triangular")]
    | Annotated[ExponentialTime, form("exponential")]
    | Annotated[GammaTime, form("gamma")]
    | Annotated[LognormalTime, form("lognormal")]
    | Annotated[WeibullTime, form("weibull")]
    | Annotated[BetaTime, form("beta")]
    | Annotated[DiscreteTime, form("discrete")]
    | Annotated[EmpiricalTime, form("empirical")],
    Forms(
        "a time, or a distribution such as {lognormal: {mean: 8, cv: 0.4}}",
        {
            "type": "object",
            "properties": {"constant": {"type": "number", "description": "the time, always the same"}},
            "required": ["constant"],
        },
        pick=_form_of,
    ),
    BeforeValidator(_known),
]
"""A time that is always the same, or a distribution."""


def scaled(time: float | Distribution, factor: float) -> float | Distribution:
    """Return a time that may vary, made `factor` times as long."""
    if not isinstance(time, Distribution):
        return time * factor
    return type(time).model_validate({time.kind: _times(time.content()[time.kind], lambda part: part * factor)})


def in_unit(distribution: Distribution, unit: str) -> dict[str, Any]:
    """Return a distribution as a model file has it, each of its times with a unit: `{uniform: [4 s, 12 s]}`."""
    kind = distribution.kind
    return {kind: _times(distribution.content()[kind], lambda part: f"{part:.15g} {unit}")}


def _times(value: Any, change: Callable[[float], Any]) -> Any:
    """Return the parameters of a distribution with its times changed."""
    if isinstance(value, Mapping):
        return {key: item if key in _PURE else _times(item, change) for key, item in value.items()}
    return [_times(item, change) for item in value] if isinstance(value, list) else change(value)


def mean_of(time: float | Distribution) -> float:
    """Return the mean of a time that may vary."""
    return time.mean if isinstance(time, Distribution) else time


def mean_left(time: float | Distribution) -> float:
    """Return the mean rest of a time that is under way, seen at any instant, with unknown begin: E[S²] / (2 E[S]).

    It is the mean residual time of renewal theory.
    """
    mean, variance = (time.mean, time.variance) if isinstance(time, Distribution) else (time, 0.0)
    return (mean + variance / mean) / 2 if mean else 0.0


def draws(time: float | Distribution, streams: Streams, purpose: str, entity: int) -> Callable[[], float]:
    """Draw a time that may vary again and again, from a stream of its own; a constant time needs none."""
    if not isinstance(time, Distribution) or not time.has_spread:
        return lambda: mean_of(time)
    return partial(time.draw, streams.stream(purpose, entity))


def drawn(time: float | Distribution, stream: Callable[[], Generator]) -> float:
    """Draw a time that may vary once; `stream` is not called for a constant time."""
    if not isinstance(time, Distribution) or not time.has_spread:
        return mean_of(time)
    return time.draw(stream())
