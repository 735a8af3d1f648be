"""Search space of `desim best`, too large to race: values of keys, nodes for chargers, directions of aisles."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from random import Random
from typing import Any, Protocol, TypeAlias

from desim_warehouse.errors import StudyError, shown
from desim_warehouse.layout.turnable import Way
from desim_warehouse.model import Model
from desim_warehouse.study.designs.directions import Floor
from desim_warehouse.study.designs.local_search import Space
from desim_warehouse.study.factors import Factor, Label
from desim_warehouse.study.fleet.designs import Designs
from desim_warehouse.study.possible import refused
from desim_warehouse.values.arguments import is_whole

Combined: TypeAlias = "tuple[Any, ...]"
"""A choice of each part of a design."""

_NEAREST = 6
"""Free nodes to which a charger may move in one step."""
_LEAP = 4
"""Number of leaps in the range of a factor; other moves change a number by one step."""
_DRAWS = 50
"""Largest number of draws until a design can be simulated."""


class DesignPart(Space[Any], Protocol):
    """A part of a design that is chosen independently of the other parts, such as one key or the charger nodes."""

    key: str
    """The name of the part in tables: a key of the model, or words."""

    @property
    def many(self) -> float:
        """The number of possible choices, at most."""
        ...

    def changes(self, choice: Any) -> Mapping[str, Any]:
        """Return the overrides of the model that a choice stands for."""
        ...

    def label(self, choice: Any) -> Label:
        """Return the label of a choice in tables."""
        ...


class FactorLevels:
    """The values of a factor: numbers in order, whose neighbours are near, or categories."""

    def __init__(self, model: Model, factor: Factor) -> None:
        self.key = factor.key
        self.levels = factor.levels
        labels = [level.label for level in factor.levels]
        self.is_ordered = all(isinstance(label, int | float) and not isinstance(label, bool) for label in labels)
        middle = len(labels) // 2 if self.is_ordered else 0
        now = (rank for rank, level in enumerate(factor.levels) if model.replace(level.overrides) == model)
        self.now = next(now, middle)

    @property
    def many(self) -> float:
        """The number of values."""
        return len(self.levels)

    def first(self) -> Iterator[int]:
        """Yield the model's own value if listed, or else the middle number, or the first of other values."""
        yield self.now

    def sample(self, random: Random) -> int:
        """Draw any value at random."""
        return random.randrange(len(self.levels))

    def neighbours(self, choice: int) -> Iterator[int]:
        """Yield the numbers one step and one leap away, up and down; for categories all other values."""
        leap = max(2, len(self.levels) // _LEAP)
        near = (choice + by for by in (-1, 1, -leap, leap)) if self.is_ordered else range(len(self.levels))
        return (rank for rank in near if rank != choice and 0 <= rank < len(self.levels))

    def allows(self, choice: int) -> bool:
        """Allow every value, since factors were checked before."""
        return 0 <= choice < len(self.levels)

    def effort(self, choice: int) -> int:
        """Return 1 if the value differs from the value in the model, else 0."""
        return int(choice != self.now)

    def changes(self, choice: int) -> Mapping[str, Any]:
        """Return the changes of a value to the model."""
        return self.levels[choice].overrides

    def label(self, choice: int) -> Label:
        """Return the value as its label."""
        return self.levels[choice].label


class ChargerNodes:
    """The choice of nodes for chargers, one at each; robots that parked there park at nodes that lost a charger."""

    key = "chargers at"

    def __init__(self, model: Model, count: int) -> None:
        """Find the nodes of a floor that may have chargers; raise StudyError if there are too few."""
        zone = Designs(model).zone
        if zone is None:
            raise StudyError("--place-chargers: this model has no chargers, expected bays with chargers and a battery")
        floor, bays = model.floor, model.layout.bays
        nodes_of = {name: tuple(node for node, bay in floor.bays.items() if bay.zone == name) for name in bays}
        self.zone, self.bays = zone, bays
        self.now = nodes_of[zone]
        self.parking = {
            name: nodes
            for name, nodes in nodes_of.items()
            if not bays[name].in_lane and 0 in (bays[name].chargers, bays[name].total_chargers)
        }
        taken = {*floor.stations, *floor.bays}.difference(self.now, *self.parking.values())
        self.nodes = tuple(node for node in floor.graph if node not in taken)
        if not is_whole(count, 1, len(self.nodes)):
            most = f"expected 1 to {len(self.nodes)}, as many as nodes without stations"
            raise StudyError(f"--place-chargers {shown(count):.60}: no such number of nodes, {most}")
        self.count = count
        self.points = floor.points

    @property
    def many(self) -> float:
        """The number of ways to choose the nodes."""
        return math.comb(len(self.nodes), self.count)

    def first(self) -> Iterator[tuple[str, ...]]:
        """Yield today's charger nodes, reduced or extended by nearest neighbours to the wanted number."""
        others = sorted((node for node in self.nodes if node not in self.now), key=self._from_now)
        yield self._in_order([*self.now, *others][: self.count])

    def sample(self, random: Random) -> tuple[str, ...]:
        """Draw nodes at random."""
        return self._in_order(random.sample(self.nodes, self.count))

    def neighbours(self, choice: Sequence[str]) -> Iterator[tuple[str, ...]]:
        """Yield the choices in which one charger is moved to a free node nearby."""
        for node in choice:
            free = [other for other in self.nodes if other not in choice]
            for other in sorted(free, key=lambda free_node: abs(self.points[free_node] - self.points[node]))[:_NEAREST]:
                yield self._in_order([other if old == node else old for old in choice])

    def allows(self, choice: Sequence[str]) -> bool:
        """Allow every choice, since any of the nodes may have a charger."""
        return len(choice) == self.count

    def effort(self, choice: Sequence[str]) -> int:
        """Return the number of chargers at nodes that have none in the model."""
        return len({*choice}.difference(self.now))

    def changes(self, choice: Sequence[str]) -> Mapping[str, Any]:
        """Return the overrides that put the chargers at these nodes.

        Parking nodes that get a charger are removed from parking, and nodes that lose their charger become parking.
        """
        changes = self._stand(self.zone, choice) | {f"layout.bays.{self.zone}.total_chargers": len(choice)}
        if self.bays[self.zone].chargers is not None:
            changes[f"layout.bays.{self.zone}.chargers"] = None
        left = [node for node in self.now if node not in choice]
        for name, nodes in self.parking.items():
            stay = [node for node in nodes if node not in choice]
            if left or len(stay) < len(nodes):
                changes |= self._stand(name, [*stay, *left])
            left = []
        return changes

    def label(self, choice: Sequence[str]) -> Label:
        """Return the nodes."""
        return ", ".join(choice)

    def _stand(self, name: str, nodes: Sequence[str]) -> dict[str, Any]:
        key, changes = f"layout.bays.{name}", dict[str, Any]()
        changes[f"{key}.at"] = list(nodes)
        if self.bays[name].along is not None:
            changes |= {f"{key}.along": None, f"{key}.every": 1}
        return changes

    def _in_order(self, nodes: Iterable[str]) -> tuple[str, ...]:
        return tuple(sorted(nodes, key=self.nodes.index))

    def _from_now(self, node: str) -> float:
        return min((abs(self.points[node] - self.points[other]) for other in self.now), default=0.0)


class AisleWays(Floor):
    """The choice of directions for aisles: the floor of `desim orient` as a part of a design."""

    key, drawn_label = "directions", "as drawn"

    @property
    def many(self) -> float:
        """The largest possible number of designs, including designs that would cut off a part of the floor."""
        return math.prod(map(len, self.turnable.ways))

    def label(self, design: tuple[Way, ...]) -> Label:
        """Return in words the aisles whose direction differs from the model's."""
        return "; ".join(self.turnable.turned(design)) or self.drawn_label


class DesignSpace:
    """All combinations of the choices of several parts that can be simulated."""

    def __init__(self, model: Model, parts: Sequence[DesignPart]) -> None:
        """Combine parts; raise StudyError if two change the same key, or no design can be simulated."""
        self.model, self.parts = model, parts
        self._refused: dict[Combined, str | None] = {}
        keys = [key for part in parts for key in part.changes(next(iter(part.first())))]
        twice = next((key for key in keys if keys.count(key) > 1), None)
        if twice is not None:
            raise StudyError(f"{twice}: changed twice, expected it to be varied, or to follow from what is placed")
        self.now: Combined = tuple(next(iter(part.first())) for part in parts)
        if (why := self._why_not(self.now)) is not None:
            self.now = self.sample(Random(0))  # noqa: S311 - a search, no secret
            if not self.allows(self.now):
                raise StudyError(f"no design found that can be simulated; of the first: {why}")

    @property
    def many(self) -> float:
        """The largest possible number of designs."""
        return math.prod(part.many for part in self.parts)

    def first(self) -> Iterator[Combined]:
        """Yield the design nearest to the model, then designs with the other first choices of one part."""
        yield self.now
        for rank, part in enumerate(self.parts):
            for choice in part.first():
                design = (*self.now[:rank], choice, *self.now[rank + 1 :])
                if self.allows(design):
                    yield design

    def sample(self, random: Random) -> Combined:
        """Draw each part at random, independently, until the design can be simulated."""
        for _ in range(_DRAWS):
            design = tuple(part.sample(random) for part in self.parts)
            if self.allows(design):
                return design
        return self.now

    def neighbours(self, design: Combined) -> Iterator[Combined]:
        """Yield the designs that differ in one part, by a neighbouring choice."""
        for rank, part in enumerate(self.parts):
            for choice in part.neighbours(design[rank]):
                yield (*design[:rank], choice, *design[rank + 1 :])

    def allows(self, design: Combined) -> bool:
        """Whether each part allows its choice, and the whole can be simulated."""
        return self._why_not(design) is None

    def effort(self, design: Combined) -> float:
        """Return the sum of the efforts of all parts: how much of the model is changed."""
        return sum(part.effort(choice) for part, choice in zip(self.parts, design, strict=True))

    def changes(self, design: Combined) -> dict[str, Any]:
        """Return the changes of a design to the model."""
        chosen = zip(self.parts, design, strict=True)
        return {key: value for part, choice in chosen for key, value in part.changes(choice).items()}

    def labels(self, design: Combined) -> dict[str, Label]:
        """Return the label of each part of a design in tables."""
        return {part.key: part.label(choice) for part, choice in zip(self.parts, design, strict=True)}

    def _why_not(self, design: Combined) -> str | None:
        if design not in self._refused:
            is_allowed = all(part.allows(choice) for part, choice in zip(self.parts, design, strict=True))
            self._refused[design] = refused(self.model, self.changes(design)) if is_allowed else "not connected"
        return self._refused[design]
