"""Search for better directions of aisles by simulation, for `desim orient --indicator` and `desim best --directions`.

The gain of the chosen directions is measured on fresh days, which the search did not use.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from random import Random
from typing import Any, TypeAlias

from desim_warehouse.errors import LayoutError, ModelError, StudyError
from desim_warehouse.layout import Edge
from desim_warehouse.layout.turnable import Turnable, Way, turnable, turnable_blocks
from desim_warehouse.model import Model
from desim_warehouse.model.oriented import changes, orientation
from desim_warehouse.outcome.indicators import find
from desim_warehouse.run.examined import examined
from desim_warehouse.study.designs.local_search import LocalSearch
from desim_warehouse.study.procedures import more_is_better
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.comparison import paired
from desim_warehouse.study.statistics.limits import SEARCH_RUNS
from desim_warehouse.study.statistics.procedure import Procedure
from desim_warehouse.study.study import StudyEngine, searched

Design: TypeAlias = "tuple[Way, ...]"

FEWEST_RUNS = 50
"""Fewest runs of a search; with fewer, it looks at little more than the floor as drawn."""
LONGEST_WALK = 120
"""Largest number of random steps from the floor as drawn; on floors of hundreds of lanes more only take time."""
_JUDGED = 5
"""One in five runs is done on fresh days, which the search did not use."""
_PAIRS, _PAIRS_ELSEWHERE = 20, 5
"""Largest numbers of pairs of runs that compare both floors on fresh days, and for each other fleet or demand."""
_FLEETS, _DEMANDS = (0.5, 0.75, 1.25, 1.5), (0.8, 1.2)
"""Other fleets and demands for which the gain is measured, as multiples of the model's."""
_DRAWN = "as drawn"


@dataclass(frozen=True)
class DirectionGain:
    """The relative gain of an indicator by other directions of aisles, from pairs of runs on both floors.

    The gain is a share of the indicator on the floor as drawn. `is_better`: whether it is shown to be an improvement
    (True), a loss (False), or neither (None).
    """

    where: str
    mean: float
    low: float
    high: float
    pairs: int
    is_better: bool | None


@dataclass(frozen=True)
class SearchedDirections:
    """The best directions of aisles found: the `model` with them, its `turned` lanes, and the gain.

    `units`: number of lanes or whole aisles that can be turned. `gain` is None if no directions beat the floor as
    drawn. `elsewhere`: the gain with other fleets and demands. `ways`: the direction of every lane that can be turned.
    """

    model: Model
    ways: Mapping[Edge, Way]
    turned: tuple[str, ...]
    units: int
    indicator: str
    gain: DirectionGain | None
    elsewhere: tuple[DirectionGain, ...]
    runs: int
    confidence: float

    @property
    def cost(self) -> float:
        """The cost of turning the aisles of `turned` once, each at `prices.turned_aisle`; 0 without prices."""
        return 0.0 if self.model.prices is None else self.model.prices.turned_aisle * len(self.turned)


class Floor:
    """Designs of a floor: a direction for each of its units, the lanes or whole aisles that can be turned."""

    def __init__(self, model: Model) -> None:
        """Find the units of a floor that can be turned; raise StudyError if there are none."""
        self.model = model
        blocks = model.layout.blocks
        self.turnable: Turnable = turnable(model.floor) if blocks is None else turnable_blocks(blocks)
        if not self.turnable.units:
            raise StudyError(f"{model.name}: no lane can be turned without cutting off a part of the floor")
        self._allowed: dict[Design, bool] = {}

    @cached_property
    def drawn(self) -> Design:
        """The design of the floor as the model has it."""
        return self.turnable.drawn

    def changes(self, design: Design) -> dict[str, Any]:
        """Return the overrides that make the model into a design."""
        return changes(self.model, self.turnable.lanes(design))

    def first(self) -> Iterator[Design]:
        """Yield the floor as it is, and the floor with its two-way lanes made one-way so that trips are short."""
        yield self.drawn
        if self.model.layout.blocks is None and self.model.floor.two_way:
            try:
                kept = set(orientation(self.model).kept)
            except ModelError:  # goods or stations in parts that cannot reach each other
                return
            short = tuple(
                "along" if lanes[0] in kept and "both" in ways else "back" if lanes[0][::-1] in kept else ways[0]
                for lanes, ways in zip(self.turnable.units, self.turnable.ways, strict=True)
            )
            if self.allows(short):
                yield short

    def sample(self, random: Random) -> Design:
        """Return the end of a random walk over designs that begins at the floor as it is."""
        design = self.drawn
        for _ in range(random.randint(1, min(LONGEST_WALK, 3 * len(self.turnable.units)))):
            other = self.turnable.step(design, random)
            design = other if self.turnable.is_connected(other) else design
        return design if self.allows(design) else self.drawn

    def neighbours(self, design: Design) -> Iterator[Design]:
        """Yield the designs with another direction of a whole aisle, or of one unit."""
        return self.turnable.neighbours(design)

    def allows(self, design: Design) -> bool:
        """Whether every node can be reached from every other, and the changed model is valid."""
        if design not in self._allowed:
            self._allowed[design] = self.turnable.is_connected(design) and self._is_model(design)
        return self._allowed[design]

    def effort(self, design: Design) -> int:
        """Return the number of units whose direction differs from the model's."""
        return len(self.turnable.turned(design))

    def _is_model(self, design: Design) -> bool:
        try:
            return self.model.replace(self.changes(design)).floor is not None
        except (ModelError, LayoutError):  # a zone or a closure names a lane that would lead the other way
            return False

    def passes_check(self, design: Design) -> bool:
        """Whether `desim check` finds no error that it does not find in the floor as drawn."""

        def errors(model: Model) -> set[str]:
            return {item.code for item in examined(model)[0] if item.level == "error"}

        return errors(self.model.replace(self.changes(design))) <= errors(self.model)


def search_directions(model: Model, indicator: str, search: Search = USUAL) -> SearchedDirections:
    """Find the directions of aisles that are best for an indicator, with a budget of runs.

    Rows and columns of blocks are turned as a whole, other lanes between junctions one by one or by aisles. Two-way
    lanes may become one-way, or prefer a direction. Every node remains reachable from every other. The search and the
    final comparison use different days, so that selection does not bias the gain.

    Args:
        model: the warehouse.
        indicator: indicator to optimise.
        search: how runs are done, at most 500 by default.

    Raises:
        StudyError: nothing can be turned, too few runs, or an indicator without a better direction.

    Source: `designs.local_search`.
    """
    find(indicator)
    maximise = more_is_better(indicator)
    runs = search.runs or SEARCH_RUNS
    if runs < FEWEST_RUNS:
        raise StudyError(f"{runs} runs: too few to search directions, expected at least {FEWEST_RUNS}")
    with search.together() as together:
        return _found(Floor(model), indicator, runs, together, maximise=maximise)


def _found(floor: Floor, indicator: str, runs: int, search: Search, *, maximise: bool) -> SearchedDirections:
    """Search the directions of a floor, and judge the best directions if they differ from those drawn."""
    model = floor.model
    judged = runs // _JUDGED
    scout = _study(model, {_DRAWN: {}}, "search", search.seed + 1, search)
    ranked = _searched(floor, scout, indicator, replace(search.under("search"), runs=runs - judged), maximise=maximise)
    best = next(design for design in ranked if design == floor.drawn or floor.passes_check(design))
    turned = tuple(floor.turnable.turned(best))
    nothing = SearchedDirections(
        model, {}, (), len(floor.turnable.units), indicator, None, (), len(scout.rows), search.confidence
    )
    return _judged(floor, best, nothing, judged, search) if turned else nothing


def _judged(floor: Floor, best: Design, nothing: SearchedDirections, runs: int, search: Search) -> SearchedDirections:
    """Measure the gain of the best directions on days that the search did not use."""
    model, changed, indicator = floor.model, floor.changes(best), nothing.indicator
    maximise = more_is_better(indicator)
    fresh = _fresh(model, changed, runs, search)
    fresh.run_by(search.under("judged"))
    gain, *elsewhere = (_gain(fresh, number, indicator, maximise=maximise) for number in range(0, len(fresh.points), 2))
    return replace(
        nothing,
        model=model.replace(changed),
        ways=floor.turnable.lanes(best),
        turned=tuple(floor.turnable.turned(best)),
        gain=gain,
        elsewhere=tuple(other for other in elsewhere if other is not None),
        runs=nothing.runs + len(fresh.rows),
    )


def _searched(floor: Floor, scout: StudyEngine, indicator: str, search: Search, *, maximise: bool) -> list[Design]:
    """Search, and return the final designs, the best first; designs that are simulated are added to `scout`."""
    with scout.session(search) as runner:
        numbers = {floor.drawn: 0}

        def number(design: Design) -> int:
            if design not in numbers:
                label = ", ".join(floor.turnable.turned(design))
                numbers[design] = scout.grow(runner, label, floor.changes(design))
            return numbers[design]

        def steps(exact: bool) -> Procedure[list[Design]]:
            random = Random(search.seed)  # noqa: S311 - a search, no secret
            return LocalSearch(floor, number, search.runs or 0, random, maximise=maximise, exact=exact).steps()

        return scout.carry_out(runner, steps, indicator, failed=math.nan)


def _study(model: Model, cases: Mapping[str, Any], name: str, seed: int, search: Search) -> StudyEngine:
    return searched(model, {"directions": {"cases": dict(cases)}}, search, name=name, seed=seed)


def _fresh(model: Model, turned: Mapping[str, Any], runs: int, search: Search) -> StudyEngine:
    """Make the study that compares both floors on fresh days, with the model's fleet and demand and with others."""
    others = list(_elsewhere(model, turned))[: max(0, runs // (2 * _PAIRS_ELSEWHERE) - 2)]
    cases: dict[str, Mapping[str, Any]] = {_DRAWN: {}, "turned": turned}
    for name, more in others:
        cases |= {f"{_DRAWN}, {name}": more, name: {**turned, **more}}
    pairs = min(_PAIRS, runs // 2 - _PAIRS_ELSEWHERE * len(others))
    counts = [pairs, pairs, *[_PAIRS_ELSEWHERE] * (2 * len(others))]
    study = _study(model, cases, "judged", search.seed, search)
    study.plan = replace(study.plan, replications=tuple(counts))
    return study


def _elsewhere(model: Model, turned: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield other fleets and demands for which both floors are valid models, each with its description."""
    size = model.fleet.size
    fleets = sorted({max(1, round(times * size)) for times in _FLEETS} - {size})
    trials: list[tuple[str, dict[str, Any]]] = [(f"{robots} robots", {"fleet.size": robots}) for robots in fleets]
    trials += [(f"{100 * times:g} % of the demand", {"tasks.demand": times}) for times in _DEMANDS]
    for name, more in trials:
        try:
            model.replace(more)
            model.replace({**turned, **more})
        except (ModelError, LayoutError):
            continue
        yield name, more


def _gain(study: StudyEngine, number: int, indicator: str, *, maximise: bool) -> DirectionGain | None:
    """Return the gain of design `number` + 1 over design `number`, from the pairs in which both have a value."""
    rows = {(row.point.number, row.replication): row for row in study.rows if row.outcome.error is None}
    both = [
        (rows[number + 1, r].measured(indicator), rows[number, r].measured(indicator))
        for n, r in rows
        if n == number and (number + 1, r) in rows
    ]
    both = [pair for pair in both if all(map(math.isfinite, pair))]
    if not both:
        return None
    turned, drawn = zip(*both, strict=True)
    exact = all(row.outcome.deterministic for row in rows.values())
    difference = paired(turned, drawn, study.plan.confidence, deterministic=exact)
    whole = abs(sum(drawn)) / len(drawn) or math.nan
    low, high = difference.interval or (difference.mean, difference.mean)
    is_better = None if low <= 0 <= high else (low > 0) == maximise
    label = str(study.points[number + 1].labels["directions"])
    return DirectionGain(
        "" if number == 0 else label, difference.mean / whole, low / whole, high / whole, len(both), is_better
    )
