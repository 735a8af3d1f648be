"""The designs that could be built: robots, chargers and people, what they change in the model, what they cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from desim_warehouse.errors import StudyError, number_of
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.costs import year_of
from desim_warehouse.run.quick import estimate
from desim_warehouse.study.fleet.people import People
from desim_warehouse.study.possible import NotTried, possible
from desim_warehouse.study.procedures import FLEET
from desim_warehouse.study.statistics.cheapest import Counts
from desim_warehouse.study.study import StudyEngine

ROOM = 2.5
"""Largest number of robots to search by default, as a multiple of the quick estimate's need."""


class Designs:
    """The designs that could be built from a model, by their counts: robots, chargers and, on request, people.

    Chargers are all chargers of the hall; 0 if there are none, or no batteries. Only robots without a kind are added or
    removed, and only chargers in the bays `zone`, which have most chargers for all kinds or, without such chargers,
    most for some kinds; the other bays keep theirs (`elsewhere`). `people`: the people that are counted, and where.
    """

    scan = False
    """Whether each design is judged by itself, the first one first."""

    def __init__(
        self,
        model: Model,
        robots: Sequence[int] | None = None,
        chargers: Sequence[int] | None = None,
        people: Sequence[People] = (),
    ) -> None:
        self.model, self.people = model, tuple(people)
        chargers_by_zone = _chargers(model) if model.battery is not None else {}
        for_all = [zone for zone in chargers_by_zone if not model.layout.bays[zone].kinds]
        self.zone = max(for_all or chargers_by_zone, key=chargers_by_zone.__getitem__, default=None)
        self.today = sum(chargers_by_zone.values())
        self.elsewhere = self.today - chargers_by_zone.get(self.zone or "", 0)
        if chargers is not None and self.zone is None:
            raise StudyError("--chargers: this model has no chargers, expected bays with chargers and a battery")
        self._robots, self._chargers = robots, chargers

    def value(self, design: Counts) -> Any:
        """Return how many robots a design has."""
        return design[0]

    def overrides(self, design: Counts) -> dict[str, Any]:
        """The changes that make the model into a design."""
        robots, chargers, *people = design
        return {"fleet.size": robots, **self.of_chargers(chargers), **self.of_people(people)}

    def of_people(self, numbers: Sequence[int]) -> dict[str, Any]:
        """Return the changes that set the numbers of people, in the order of `people`."""
        return {kind.key: number for kind, number in zip(self.people, numbers, strict=True)}

    def totals(self, design: Counts) -> dict[str, int]:
        """Return the counts of a design by factor name; people are the total over the nodes of their station."""
        robots, chargers, *people = design
        each = zip(self.people, people, strict=True)
        return {"fleet.size": robots, "chargers": chargers, **{kind.name: kind.nodes * number for kind, number in each}}

    def factors(self, counts: Sequence[Sequence[int]]) -> dict[str, Any]:
        """Return the factors of a study of all designs with these counts; people are the total of their station."""
        robots, chargers, *people = counts
        factors: dict[str, Any] = {"fleet.size": robots}
        if self.zone is not None:
            factors["chargers"] = {"cases": {f"{number}": self.of_chargers(number) for number in chargers}}
        for kind, numbers in zip(self.people, people, strict=True):
            factors[kind.name] = {"cases": {f"{number * kind.nodes}": {kind.key: number} for number in numbers}}
        return factors

    def of_chargers(self, chargers: int) -> dict[str, Any]:
        """Return the changes that give the hall a number of chargers, adding slots only where there are too few.

        Robots also rest in slots, so removing slots along with chargers would confound two changes. If the model has as
        many slots as chargers, each node keeps the slots that all nodes have.
        """
        if self.zone is None:
            return {}
        bay = self.model.layout.bays[self.zone]
        nodes = sum(item.zone == self.zone for item in self.model.floor.bays.values())
        key = f"layout.bays.{self.zone}"
        here = chargers - self.elsewhere
        changes: dict[str, Any] = {f"{key}.total_chargers": here}
        if bay.chargers is not None:
            changes[f"{key}.chargers"] = None
        slots = max((self.today - self.elsewhere) // nodes, 1) if bay.places is None else bay.places
        if not bay.in_lane and (bay.places is None or here > slots * nodes):
            changes |= {f"{key}.places": slots, f"{key}.grows": True}
        return changes

    def cost(self, design: Counts) -> float | None:
        """Return the yearly cost of a design before any run, or None if nothing that is sized has a price."""
        prices = self.model.prices
        if prices is None or not (prices.of_fleet or any(getattr(prices, kind.wage) for kind in self.people)):
            return None
        robots, chargers, *people = design
        special = [kind for kind in self.model.fleet.kinds_of_robots() if kind]
        kinds = [*special, *[""] * (robots - len(special))]
        paid = {kind.place: number * kind.nodes for kind, number in zip(self.people, people, strict=True)}
        return year_of(self.model, kinds, None if self.zone is None else chargers, paid)

    def key(self, design: Counts) -> tuple[float, ...]:
        """Return the sort key of a design: cost, then robots, chargers and people."""
        return (self.cost(design) or 0.0, *map(float, design))

    def ranges(self, growth: float) -> tuple[list[list[int]], tuple[NotTried, ...]]:
        """Return the numbers of robots, chargers and people to search, and those that cannot be simulated.

        The default is from the quick estimate.

        Raises:
            StudyError: no fleet can be simulated.
        """
        model = self.model.replace(more_demand(self.model, growth))
        quick = estimate(model)
        people = [kind.searched(quick, model) for kind in self.people]
        if people:
            model = model.replace(self.of_people([numbers[-1] for numbers in people]))
            quick = estimate(model)
        needed = quick.robots_busy
        if quick.robots_needed is not None and math.isfinite(quick.robots_needed):
            needed = quick.robots_needed  # else chargers are too few, and searched as well
        if self._robots is not None:
            robots = list(self._robots)
        elif needed is None:
            robots = list(range(1, max(2 * model.fleet.size, 10) + 1))
        else:
            robots = list(
                range(max(math.floor(needed / 2), 1), max(math.ceil(ROOM * needed) + 2, model.fleet.size) + 1)
            )
        robots, not_tried = possible(model, robots, lambda size: {FLEET: size}, lambda size: {FLEET: size})
        if self.zone is None:
            return [robots, [0], *people], not_tried
        if self._chargers is not None:
            chargers = [number for number in self._chargers if number > self.elsewhere]
            if fewer := [number for number in self._chargers if number <= self.elsewhere]:
                not_tried += (self._too_few(fewer),)
            if not chargers:
                raise StudyError(f"--chargers {fewer[-1]}: {not_tried[-1].reason}")
            return [robots, chargers, *people], not_tried
        least = self.elsewhere + 1
        short = 0 if quick.power is None or quick.power.needed is None else quick.power.needed * robots[-1]
        most = max(math.ceil(1.5 * short / max(model.fleet.size, 1)), self.today, 2) + 1
        return [robots, list(range(least, max(min(most, robots[-1]), least) + 1)), *people], not_tried

    def _too_few(self, numbers: Sequence[int]) -> NotTried:
        """Return numbers of chargers that leave none to size, as the other bays keep theirs."""
        others = number_of(self.elsewhere, "charger")
        reason = f"bays other than {self.zone} keep {others}"
        return NotTried(tuple({"chargers": number} for number in numbers), reason, larger=False)

    @property
    def is_fleet(self) -> bool:
        """Whether robots are counted."""
        return True


class OneKey(Designs):
    """The values of a study's only factor as designs, smallest first; the count of a design is its position.

    `scan`: whether designs are judged one by one, the first one first, because more need not be better. `not_tried`:
    further values, which cannot be simulated.
    """

    def __init__(self, study: StudyEngine, *, scan: bool = False, not_tried: tuple[NotTried, ...] = ()) -> None:
        if len(study.plan.factors) != 1:
            raise StudyError(f"size: {len(study.plan.factors)} factors, expected one whose values are searched")
        [self.of] = (factor.key for factor in study.plan.factors)
        self.model, self.study, self.scan, self.not_tried = study.plan.base, study, scan, not_tried
        self.zone, self.people = None, ()

    @property
    def is_fleet(self) -> bool:
        """Whether robots are counted."""
        return self.of == FLEET

    def value(self, design: Counts) -> Any:
        """Return the value of the key."""
        return self.study.points[design[0]].labels[self.of]

    def overrides(self, design: Counts) -> dict[str, Any]:
        """Return the changes that make the model into a design."""
        return dict(self.study.points[design[0]].overrides)

    def cost(self, design: Counts) -> float | None:
        """Return the yearly cost of a design before any run, or None without prices."""
        return None if self.model.prices is None else year_of(self.model.replace(self.overrides(design)))

    def key(self, design: Counts) -> tuple[float, ...]:
        """Return the position of a value as its sort key: the smallest is sought, not the cheapest."""
        return tuple(map(float, design))

    def ranges(self, growth: float) -> tuple[list[list[int]], tuple[NotTried, ...]]:  # noqa: ARG002 - values are given
        """Return the positions of all values, and the values that cannot be simulated."""
        return [list(range(len(self.study.points)))], self.not_tried


def _chargers(model: Model) -> dict[str, int]:
    """Return the number of chargers of each zone of bays."""
    layout = model.floor
    by_zone: dict[str, int] = {}
    for node, chargers in chargers_at(model, layout).items():
        zone = layout.bays[node].zone
        by_zone[zone] = by_zone.get(zone, 0) + chargers
    return by_zone


def more_demand(model: Model, growth: float) -> dict[str, Any]:
    """Return the changes that multiply demand by a factor."""
    if growth == 1:
        return {}
    if not model.tasks.grow:
        raise StudyError(
            "--growth: this model's demand is no rate that could grow, expected tasks.goods: {poisson: orders an "
            "hour}, or flows that arrive at a rate"
        )
    return {"tasks.demand": round(model.tasks.demand * growth, 9)}
