"""The design of a study: which models are simulated. Points come from factors by a rule.

A study file, such as studies/fleet_size.yaml; only `model` must be there:

    name: Fleet size                       # for tables and figures
    description: one or two sentences
    model: ../models/multibots.yaml        # a model file, relative to the study file; or a whole model
    set:                                   # changes to the model, for all runs, as `--set` makes them
      tasks.goods: {random: 20}
    factors:                               # what is varied: any key of a model, and its values
      fleet.size: 1..6                     # whole numbers, both ends; 1..12..2 in steps of 2
      battery.threshold: [2, 3.5, 5]       # a list; ranges such as 1..3 may stand in it
      battery.capacity: {linspace: [5, 20, 4]}    # 4 values from 5 to 20
      policies.charging:                   # whole policies, with parameters
        - threshold
        - {name: opportunity, margin: 1}
      tasks.goods:                         # values with names: tables and figures show the names
        named: {group 1: [11, 8, 39], group 2: [74, 50, 62]}
      demand:                              # several keys changed together; the factor has a name of its own
        cases:
          today: {tasks.goods: {poisson: 200}}
          plus 30 %: {tasks.goods: {poisson: 260}, fleet.size: 6}
    design: grid                           # all combinations (default); or
                                           # paired: first values of all factors, then second values, ...
                                           # {latin-hypercube: 50}, {sobol: 64}: so many points; then a factor may
                                           #   also be {between: [2, 5]} (whole numbers if both ends are whole;
                                           #   {between: [2.0, 5.0]} is continuous)
                                           # {saltelli: 64}: for Sobol indices, 64 x (factors + 2) points
    replications: 20                       # a number; or until the mean is known well enough:
    # replications: {indicator: T, half_width: 2 %, confidence: 0.95, minimum: 30, cap: 200}
    seed: 0                                # replication r has the same run seed at every point
    indicators: [T, S, C]                  # columns of the table; default: all
    baseline: {fleet.size: 3}              # the design that others are compared with; default: the first
    confidence: 0.95
    timeout: 60                            # seconds that a run may take; default: no limit
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from desim_warehouse.study.factors import Factor, Keys, Label, Level

RULES = ("grid", "paired")
SAMPLED = ("latin-hypercube", "sobol", "saltelli")


@dataclass(frozen=True)
class Rule:
    """How points come from factors: `grid`, `paired`, or one of the sampled rules with a number of points."""

    name: str = "grid"
    size: int = 0


GRID = Rule()


@dataclass(frozen=True)
class Point:
    """One design point: what tables show for each factor, and the changes it makes to the model."""

    number: int
    labels: Mapping[str, Label]
    overrides: Mapping[str, Any]
    places: Mapping[str, Keys]  # where each change stands in the study file

    def __str__(self) -> str:
        """The design as people say it: fleet.size=3, battery.threshold=2."""
        return ", ".join(f"{key}={value}" for key, value in self.labels.items()) or "the model as it is"


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


def _point(number: int, factors: Sequence[Factor], levels: Sequence[Level]) -> Point:
    labels = {factor.key: level.label for factor, level in zip(factors, levels, strict=True)}
    overrides = {key: value for level in levels for key, value in level.overrides.items()}
    places = {key: level.keys for level in levels for key in level.overrides}
    return Point(number, labels, overrides, places)


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
    low, high, whole = factor.between.low, factor.between.high, factor.between.whole
    value = int(low) + int(share * (high - low + 1)) if whole else low + share * (high - low)
    return factor.level(value, ("factors", factor.key, "between"))


def _saltelli(factors: Sequence[Factor], size: int, seed: int) -> list[Point]:
    """The points of `statistics.saltelli_design`, in its order, which its indices need."""
    design = saltelli(factors, size, seed)
    by_label = {factor.key: {level.label: level for level in factor.levels} for factor in factors}
    return [
        _point(
            number,
            factors,
            [
                by_label[factor.key].get(values[factor.key])
                or factor.level(values[factor.key], ("factors", factor.key, "between"))
                for factor in factors
            ],
        )
        for number, values in enumerate(design.points)
    ]


def saltelli(factors: Sequence[Factor], size: int, seed: int) -> Any:
    """The `SaltelliDesign` over these factors."""
    from desim_warehouse.study import statistics

    given: dict[str, Any] = {
        factor.key: [level.label for level in factor.levels]
        if factor.between is None
        else statistics.Between(factor.between.low, factor.between.high, factor.between.whole)
        for factor in factors
    }
    return statistics.saltelli_design(given, size, seed)
