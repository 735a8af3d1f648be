"""People whose number is part of a design: their kinds, the model key of their number, and the numbers to search.

Each kind of people has a row in `model.facts.people` and a class here.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from desim_warehouse.errors import StudyError
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.model import Model
from desim_warehouse.model.facts.people import PACKERS, PEOPLE, PICKERS
from desim_warehouse.model.facts.workers import groups, peak_factor
from desim_warehouse.study.fleet.given import counts_of

ROOM = 1.5
"""Largest number of packers to search by default, as a multiple of the quick estimate's need in a peak."""
_STAFF = {"servers", "pickers", "people"}
"""Kinds of groups that are people whose number is sized."""
AUTO = "auto"
"""The input that stands for all numbers that the quick estimate finds possible."""


@dataclass(frozen=True)
class People(ABC):
    """People of one kind whose number is sized: the value of the model's `key` at each of `nodes` nodes.

    `place`: their station, empty if they have none. `values`: the numbers to search (None: chosen by the quick
    estimate, from `least` to `most`).
    """

    name: ClassVar[str]
    key: str
    place: str = ""
    nodes: int = 1
    least: int = 1
    most: float = math.inf
    values: tuple[int, ...] | None = None

    @property
    def noun(self) -> str:
        """The singular noun for people of this kind."""
        return PEOPLE[self.name].noun

    @property
    def wage(self) -> str:
        """The key of `prices` with the hourly wage."""
        return PEOPLE[self.name].wage

    def searched(self, quick: QuickEstimate, model: Model) -> list[int]:
        """Return the numbers to search, by default from the least without backlog growth to more than a peak needs.

        Args:
            quick: the quick estimate of the model.
            model: the warehouse, with the demand planned for.
        """
        if self.values is not None:
            return list(self.values)
        needed, enough = self.span(quick, model)
        most = int(min(max(math.ceil(enough), self.least) + 1, self.most))
        return list(range(min(max(math.ceil(needed), self.least), most), most + 1))

    @abstractmethod
    def span(self, quick: QuickEstimate, model: Model) -> tuple[float, float]:
        """Return the least number, busy all the time, and a number that surely suffices, both as fractions."""


class SizedPackers(People):
    """The people of a station: its workers where loads are worked on there, else its servers."""

    name = PACKERS

    @classmethod
    def of(cls, model: Model, numbers: Any) -> SizedPackers:
        """Read a station and its possible numbers of packers, `packing=1..4`; `packing`: by the quick estimate.

        Raises:
            StudyError: no such numbers, no such station, or no room in it for so many.
        """
        station, _, written = (part.strip() for part in str(numbers).partition("="))
        values = counts_of(written or None, f"{cls.name} {station}")
        spec = model.layout.stations.get(station)
        if spec is None:
            stations = ", ".join(model.layout.stations) or "none"
            raise StudyError(f"--packers {station}: no station of this model, expected one of its stations: {stations}")
        of_work = spec.work_time is not None
        most = spec.places if not of_work else spec.buffer or math.inf
        if values is not None and values[-1] > most:
            room = "buffer" if of_work else "places"
            raise StudyError(f"--packers {station}={values[-1]}: more than its {room}, expected at most {most}")
        return cls(
            f"layout.stations.{station}.{'workers' if of_work else 'servers'}",
            station,
            sum(item.zone == station for item in model.floor.stations.values()),
            most=most,
            values=None if values is None else tuple(values),
        )

    def span(self, quick: QuickEstimate, model: Model) -> tuple[float, float]:
        """Return the packers that loads occupy on average, and half as many again as they occupy in a peak."""
        loads = [load for load in quick.stations if model.floor.stations[load.node].zone == self.place]
        of_work = self.key.endswith("workers")
        busy = [
            (load.work_busy or 0) * load.workers if of_work else (load.serve_busy or 0) * load.servers for load in loads
        ]
        needed = math.fsum(busy) / self.nodes
        return needed, ROOM * _peak(model, self.place) * needed


class SizedPickers(People):
    """The people who walk to robots at storage places, in all zones."""

    name = PICKERS

    @classmethod
    def of(cls, model: Model, numbers: Any) -> SizedPickers:
        """Read possible numbers of pickers, such as `3..9` or `auto`: by the quick estimate.

        Raises:
            StudyError: no such numbers, a model without pickers, or fewer of them than zones.
        """
        if model.pickers is None:
            raise StudyError("--pickers: this model has no pickers, expected a section pickers")
        values = None if numbers == AUTO else counts_of(numbers, cls.name)
        zones = model.pickers.zones
        if values is not None and values[0] < zones:
            raise StudyError(f"--pickers {values[0]}: fewer than their {zones} zones, expected at least {zones}")
        return cls("pickers.count", least=zones, values=None if values is None else tuple(values))

    def span(self, quick: QuickEstimate, model: Model) -> tuple[float, float]:
        """Return the pickers needed if they never walked, and those needed in a peak if each robot is a long walk away.

        Pickers who stay with a robot also walk beside it. Without a rate of orders, the upper number is twice the
        model's own.
        """
        load, spec = quick.pickers, model.pickers
        assert load is not None and spec is not None  # noqa: PT018 - by `of`
        if quick.rate is None:
            return 0.0, 2.0 * spec.count - 1
        stops = quick.rate * load.share / load.open if load.open else 0.0
        each = load.pick + load.walks[0]
        if spec.stay == "order" and load.share:
            each = max(each, (quick.cycle.empty + quick.cycle.load) / load.share)
        return stops * load.pick, _peak(model) * stops * each


SIZED: Mapping[str, type[SizedPackers | SizedPickers]] = {kind.name: kind for kind in (SizedPackers, SizedPickers)}
"""The people that a plan can count, by name."""


def people_of(model: Model, wanted: Mapping[str, Sequence[int] | str | None]) -> tuple[People, ...]:
    """Read the people to size beside robots and chargers, by name, with their possible numbers; None: not sized.

    Raises:
        StudyError: impossible numbers; see `SizedPackers.of` and `SizedPickers.of`.
    """
    return tuple(SIZED[name].of(model, values) for name, values in wanted.items() if values is not None)


def _peak(model: Model, place: str = "") -> float:
    """Return the work of the people of a place in their busiest hour, as a multiple of the hourly mean.

    The people of a place are its workers, and its servers if it has none.
    """
    factors = [peak_factor(model, group) for group in groups(model) if group.zone == place and group.kind in _STAFF]
    return factors[-1] or 1.0 if factors else 1.0
