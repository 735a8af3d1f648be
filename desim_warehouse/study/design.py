"""The design of a study: which models are simulated. Points come from factors by a rule."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import StudyError
from desim_warehouse.model.messages import Keys
from desim_warehouse.study.factors import Factor, Label, Level
from desim_warehouse.values.labels import readable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


SAMPLED = ("latin-hypercube", "sobol", "saltelli")


@dataclass(frozen=True)
class Rule:
    """How points come from factors: `grid`, `paired`, or one of the sampled rules with a number of points."""

    name: str = "grid"
    size: int = 0

    @property
    def sampled(self) -> bool:
        """Whether points are drawn, so that factors may be ranges."""
        return self.name in SAMPLED


GRID = Rule()


@dataclass(frozen=True)
class Point:
    """One design point: what tables show for each factor, and the changes it makes to the model."""

    number: int
    labels: Mapping[str, Label]
    overrides: Mapping[str, Any]
    positions: Mapping[str, Keys]  # where each change stands in the study file

    def __str__(self) -> str:
        """The design in words: fleet.size=3, battery.threshold=2."""
        return ", ".join(f"{key}={readable(value)}" for key, value in self.labels.items()) or "the model as it is"


def points(factors: Sequence[Factor], rule: Rule, seed: int = 0) -> list[Point]:
    """The design points, in a fixed order: in a grid the last factor changes fastest.

    Source of sampled designs: `scipy.stats.qmc`, scrambled by the study's seed.
    """
    if not factors:
        return [_point(0, [], ())]
    rows: Iterable[Sequence[Level]]
    if rule.name == "grid":
        rows = itertools.product(*(factor.levels for factor in factors))
    elif rule.name == "paired":
        rows = zip(*(factor.levels for factor in factors), strict=True)
    elif rule.name == "saltelli":
        return _saltelli(factors, rule.size, seed)
    else:
        shares = _sample(rule, len(factors), seed).tolist()
        rows = (tuple(_at(factor, u) for factor, u in zip(factors, row, strict=True)) for row in shares)
    return [_point(number, factors, row) for number, row in enumerate(rows)]


def count(factors: Sequence[Factor], rule: Rule) -> int:
    """How many points there are, without making them."""
    if rule.sampled:
        return rule.size * (len(factors) + 2 if rule.name == "saltelli" else 1)
    lengths = [len(factor.levels) for factor in factors]
    return min(lengths, default=1) if rule.name == "paired" else math.prod(lengths)


def baseline_point(among: Sequence[Point], wanted: Mapping[str, Label] | None) -> Point:
    """The point that others are compared with: the first one with these values of factors.

    Raises:
        StudyError: where no point has these values.
    """
    for point in among:
        if all(point.labels.get(key) == value for key, value in (wanted or {}).items()):
            return point
    said = ", ".join(f"{key}={readable(value)}" for key, value in (wanted or {}).items())
    raise StudyError(f"baseline: no design with {said}, expected values of the factors such as {among[0]}")


def _point(number: int, factors: Sequence[Factor], levels: Sequence[Level]) -> Point:
    labels = {factor.key: level.label for factor, level in zip(factors, levels, strict=True)}
    overrides = {key: value for level in levels for key, value in level.overrides.items()}
    positions = {key: level.keys for level in levels for key in level.overrides}
    return Point(number, labels, overrides, positions)


def _sample(rule: Rule, dimensions: int, seed: int) -> NDArray[np.float64]:
    """Points of the unit cube, shape (size, dimensions)."""
    import numpy as np
    from scipy.stats import qmc

    kind = qmc.LatinHypercube if rule.name == "latin-hypercube" else qmc.Sobol
    sampled: NDArray[np.float64] = kind(dimensions, rng=np.random.default_rng(seed)).random(rule.size)
    return sampled


def _at(factor: Factor, share: float) -> Level:
    """The value of a factor at a share of its range, or of its listed values."""
    if factor.between is None:
        return factor.levels[int(share * len(factor.levels))]
    return factor.level(factor.between.at(share))


def _saltelli(factors: Sequence[Factor], size: int, seed: int) -> list[Point]:
    """The points of `statistics.saltelli_design`, in its order, which its indices need."""
    design = saltelli(factors, size, seed)
    by_label = {factor.key: {level.label: level for level in factor.levels} for factor in factors}
    return [
        _point(
            number,
            factors,
            [by_label[factor.key].get(values[factor.key]) or factor.level(values[factor.key]) for factor in factors],
        )
        for number, values in enumerate(design.points)
    ]


def saltelli(factors: Sequence[Factor], size: int, seed: int) -> Any:
    """The `SaltelliDesign` over these factors."""
    from desim_warehouse.study.statistics.screening import saltelli_design

    given: dict[str, Any] = {
        factor.key: factor.between or [level.label for level in factor.levels] for factor in factors
    }
    return saltelli_design(given, size, seed)
