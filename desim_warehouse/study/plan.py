"""The plan of a study, checked: designs, replications, and the indicators that count.

For `desim study`, `desim what-if` and all questions that do a study.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from typing import Any, Literal

from desim_warehouse.errors import ModelError, StudyError
from desim_warehouse.model import Model
from desim_warehouse.model.messages import FilePositions, moved
from desim_warehouse.run import RunData
from desim_warehouse.study.design import Point, Rule, points
from desim_warehouse.study.execution.own_indicators import OwnIndicator, own_indicators
from desim_warehouse.study.factors import RESERVED, Factor, Label, hint, holder_of
from desim_warehouse.study.file import Until


@dataclass(frozen=True)
class StudyPlan:
    """A checked study before it is run: base model, factors, replications, indicators."""

    base: Model
    factors: tuple[Factor, ...] = ()
    rule: Rule = "grid"
    replications: int | Until | tuple[int, ...] = 1  # of each point; a tuple: point by point
    seed: int = 0
    indicators: tuple[str, ...] = ()  # empty: all
    baseline: Mapping[str, Label] | None = None
    confidence: float = 0.95
    timeout: float | None = None
    name: str = "study"
    description: str = ""
    warm_up: Literal["auto"] | tuple[float, ...] | None = None  # auto: found by pilot runs; then point by point
    target: str = ""  # to be met by designs; empty: none
    own: tuple[OwnIndicator, ...] = ()  # indicators of the user's own
    scouts: bool = False  # runs of scouts: batteries need not settle before them

    def points(self) -> list[Point]:
        """Return the design points, with the warm-up of each where that is known."""
        designs = points(self.factors, self.rule)
        if not isinstance(self.warm_up, tuple):
            return designs
        return [
            replace(
                point,
                overrides={**point.overrides, "run.warm_up": time},
                positions={**point.positions, "run.warm_up": ("warm_up",)},
            )
            for point, time in zip(designs, self.warm_up, strict=True)
        ]

    def run_name(self, model: Model) -> str:
        """Return the name under which runs of a design are kept: a digest of its model and of own indicators.

        Where they scout they are kept apart from others.
        """
        apart = self.scouts and model.battery is not None and model.fleet.start_energy == "settled"
        own = "".join(f"-{indicator.name}-{indicator.digest}" for indicator in self.own)
        return f"{model.digest()}{f'-own-{sha256(own.encode()).hexdigest()[:12]}' * bool(own)}{'-scout' * apart}"

    def measuring(
        self, functions: Mapping[str, Callable[[Any], float]], as_given: Callable[[RunData], Any] | None
    ) -> StudyPlan:
        """Return this plan with indicators of the user's own.

        Raises:
            StudyError: a name that another column of a table has, or a value that is not a function.
        """
        own = own_indicators(functions, as_given)
        for name in functions:
            if holder := holder_of(name, [factor.key for factor in self.factors], RESERVED):
                raise StudyError(f"indicators, {name}: the name of {holder}, expected another")
        return replace(self, own=own)

    def unreplicated(self) -> StudyPlan:
        """This plan with no runs of its own, for procedures that ask for the runs they need."""
        return replace(self, replications=(0,) * len(self.points()))

    @property
    def most(self) -> int:
        """The most replications that a point can have."""
        rule = self.replications
        return rule.cap if isinstance(rule, Until) else max(rule) if isinstance(rule, tuple) else rule


@cache
def run_seed(seed: int, replication: int) -> int:
    """Return the seed of a run: equal for replication r at every point, and unlike seeds of other study seeds.

    48 bits of NumPy's SeedSequence, so that a table of floats holds it exactly.
    """
    from numpy.random import SeedSequence

    low, high = SeedSequence(seed, spawn_key=(replication,)).generate_state(2)
    return (int(high) & 0xFFFF) << 32 | int(low)


def models(
    plan: StudyPlan, among: Iterable[Point], positions: FilePositions | None = None, *, run_code: bool = False
) -> dict[int, Model]:
    """Make the model of every design point, by the number of the point.

    Args:
        plan: what is varied.
        among: the points to make models of.
        positions: where values stand in the study file.
        run_code: ask the user's own policies about their parameters, too: the runs are about to be done.

    Raises:
        ModelError: every problem of every point, at the position of the value in the study file.
    """
    made: dict[int, Model] = {}
    problems: dict[str, None] = {}
    for point in among:
        try:
            made[point.number] = plan.base.replace(point.overrides, run_code=run_code)
        except ModelError as error:
            problems.update(dict.fromkeys(_at_position(text, point, positions) for text in error.problems))
    if problems:
        raise ModelError(list(problems))
    return made


def _at_position(text: str, point: Point, positions: FilePositions | None) -> str:
    """Report a problem of a changed model at the value of the study that causes it."""
    for key in sorted(point.overrides, key=len, reverse=True):
        place = f"factor {key}" if positions is None else positions.line(point.positions[key])[1]
        if message := moved(text, f"override {key}", place):
            wrong_kind = message.startswith((f"{place}: should be a ", f"{place}: should be the "))  # not out of range
            return message + hint(key, point.overrides[key]) if wrong_kind else message
    source = "" if positions is None else f"{positions.source}: "
    return f"{source}design {point}: {text}"
