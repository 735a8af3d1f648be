"""The designs that could be built: robots, chargers and packers, what they change in the model, what they cost."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from desim_warehouse.errors import StudyError, WarehouseError
from desim_warehouse.feasibility import errors
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.costs import year_of
from desim_warehouse.run.quick import estimate
from desim_warehouse.study.procedures import FLEET
from desim_warehouse.study.statistics.cheapest import Counts
from desim_warehouse.study.study import StudyEngine

ROOM = 2.5
"""How far robots are searched by default, as a multiple of what the quick estimate needs."""
ROOM_TO_PACK = 1.5
"""The same of packers."""


@dataclass(frozen=True)
class Packers:
    """The packers at each node of a station: `key` of the model has their number, `values` could be (None: any)."""

    station: str
    key: str
    nodes: int
    most: float
    values: tuple[int, ...] | None

    @classmethod
    def of(cls, model: Model, station: str, values: Sequence[int] | None) -> Packers:
        """The packers of a station of a model: its workers where loads are worked on there, else its servers.

        Raises StudyError where the model has no such station, or it has no room for so many.
        """
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
            station,
            f"layout.stations.{station}.{'workers' if of_work else 'servers'}",
            sum(item.zone == station for item in model.floor.stations.values()),
            most,
            None if values is None else tuple(values),
        )

    def searched(self, quick: QuickEstimate, model: Model) -> list[int]:
        """The numbers to search: by default from the least without a growing backlog to more than a peak needs."""
        if self.values is not None:
            return list(self.values)
        loads = [load for load in quick.stations if model.floor.stations[load.node].zone == self.station]
        of_work = self.key.endswith("workers")
        busy = [
            (load.work_busy or 0) * load.workers if of_work else (load.serve_busy or 0) * load.servers for load in loads
        ]
        needed = math.fsum(busy) / self.nodes
        peak = 1.0 if not quick.rate or quick.peak is None else quick.peak / quick.rate
        most = int(min(max(math.ceil(ROOM_TO_PACK * peak * needed) + 1, 2), self.most))
        return list(range(min(max(math.ceil(needed), 1), most), most + 1))


class Designs:
    """The designs that could be built of a model, by their counts: robots, chargers and, where asked for, packers.

    Chargers are counted in the bays that have most of them, 0 where there are none. Robots that are bought are of no
    kind, and so are chargers, where some are for kinds alone. Packers are counted at each node of one station.
    """

    scan = False
    """Whether each design is judged by itself, the first one first."""

    def __init__(
        self,
        model: Model,
        robots: Sequence[int] | None = None,
        chargers: Sequence[int] | None = None,
        packers: tuple[str, Sequence[int] | None] | None = None,
    ) -> None:
        self.model = model
        self.packers = None if packers is None else Packers.of(model, *packers)
        self._now = _chargers(model)
        for_all = [zone for zone in self._now if not model.layout.bays[zone].kinds]
        zones = (for_all or list(self._now)) if model.battery is not None else []
        self.zone = max(zones, key=self._now.__getitem__, default=None)
        if chargers is not None and self.zone is None:
            raise StudyError("--chargers: this model has no chargers, expected bays with chargers and a battery")
        self._robots, self._chargers = robots, chargers

    def value(self, design: Counts) -> Any:
        """Return how many robots a design has."""
        return design[0]

    def overrides(self, design: Counts) -> dict[str, Any]:
        """The changes that make the model into a design."""
        robots, chargers, *packers = design
        return {"fleet.size": robots, **self.of_chargers(chargers), **self.of_packers(*packers)}

    def of_packers(self, packers: int | None = None) -> dict[str, Any]:
        """The change that gives the station so many packers, none where they are not sized."""
        return {} if self.packers is None or packers is None else {self.packers.key: packers}

    def factors(self, counts: Sequence[Sequence[int]]) -> dict[str, Any]:
        """The factors of a study of all designs with these counts; packers are the total of the station."""
        robots, chargers, *packers = counts
        factors: dict[str, Any] = {"fleet.size": robots}
        if self.zone is not None:
            factors["chargers"] = {"cases": {f"{number}": self.of_chargers(number) for number in chargers}}
        if self.packers is not None:
            factors["packers"] = {
                "cases": {f"{number * self.packers.nodes}": self.of_packers(number) for number in packers[0]}
            }
        return factors

    def of_chargers(self, chargers: int) -> dict[str, Any]:
        """The changes that give the model this number of chargers, with more slots only where slots are too few.

        As a slot is also where robots rest, fewer slots with fewer chargers would compare two things at once. Where
        the model's slots are as many as its chargers, each node keeps the slots that all nodes have.
        """
        if self.zone is None:
            return {}
        bay = self.model.layout.bays[self.zone]
        nodes = sum(item.zone == self.zone for item in self.model.floor.bays.values())
        key = f"layout.bays.{self.zone}"
        changes: dict[str, Any] = {f"{key}.total_chargers": chargers}
        if bay.chargers is not None:
            changes[f"{key}.chargers"] = None
        slots = max(self.today // nodes, 1) if bay.places is None else bay.places
        if not bay.in_lane and (bay.places is None or chargers > slots * nodes):
            changes |= {f"{key}.places": slots, f"{key}.grows": True}
        return changes

    def cost(self, design: Counts) -> float | None:
        """The cost of a design a year before it runs, or None where nothing that is sized has a price."""
        prices, who = self.model.prices, self.packers
        if prices is None or not (prices.of_fleet or (who and prices.station_hour)):
            return None
        robots, chargers, *packers = design
        special = [kind for kind in self.model.fleet.kinds_of_robots() if kind]
        kinds, others = [*special, *[""] * (robots - len(special))], sum(self._now.values()) - self.today
        packing = {} if who is None else {who.station: packers[0] * who.nodes}
        return year_of(self.model, kinds, others + chargers, packing)

    def key(self, design: Counts) -> tuple[float, ...]:
        """The sort key of a design: cost, then robots, chargers and packers."""
        return (self.cost(design) or 0.0, *map(float, design))

    def counts(self, growth: float) -> list[list[int]]:
        """The robots, chargers and packers to search, by default from the quick estimate."""
        model = self.model.replace(more_demand(self.model, growth))
        quick = estimate(model)
        packers = [] if self.packers is None else [self.packers.searched(quick, model)]
        if packers:
            model = model.replace(self.of_packers(packers[0][-1]))
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
        robots = [size for size in robots if refused(model, {"fleet.size": size}) is None]
        if not robots:
            raise StudyError("no such fleet can be simulated; `desim check` says why, --robots which are searched")
        if self.zone is None:
            return [robots, [0], *packers]
        if self._chargers is not None:
            return [robots, list(self._chargers), *packers]
        short = 0 if quick.power is None or quick.power.needed is None else quick.power.needed * robots[-1]
        most = max(math.ceil(1.5 * short / max(model.fleet.size, 1)), self.today, 2) + 1
        return [robots, list(range(1, min(most, robots[-1]) + 1)), *packers]

    @property
    def is_fleet(self) -> bool:
        """Whether robots are counted."""
        return True

    @property
    def today(self) -> int:
        """Chargers of the model as it is, in the bays whose chargers are sized."""
        return self._now.get(self.zone or "", 0)


class OneKey(Designs):
    """The values of the one factor of a study as designs, smallest first: the count of each is its position.

    `scan`: each is judged by itself from the first on, where more need not be better.
    """

    def __init__(self, study: StudyEngine, *, scan: bool = False) -> None:
        if len(study.plan.factors) != 1:
            raise StudyError(f"size: {len(study.plan.factors)} factors, expected one whose values are searched")
        [self.of] = (factor.key for factor in study.plan.factors)
        self.model, self.study, self.scan = study.plan.base, study, scan
        self.zone = self.packers = None

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

    def cost(self, design: Counts) -> float | None:  # noqa: ARG002 - of all alike
        """Return None: the smallest value is sought, not the cheapest."""
        return None

    def counts(self, growth: float) -> list[list[int]]:  # noqa: ARG002 - the values are given
        """Return the positions of all values."""
        return [list(range(len(self.study.points)))]


def _chargers(model: Model) -> dict[str, int]:
    """The chargers of each zone of bays."""
    layout = model.floor
    by_zone: dict[str, int] = {}
    for node, chargers in chargers_at(model, layout).items():
        zone = layout.bays[node].zone
        by_zone[zone] = by_zone.get(zone, 0) + chargers
    return by_zone


def refused(model: Model, overrides: Mapping[str, Any]) -> str | None:
    """Why a changed model could not be simulated; None where it could."""
    try:
        changed = model.replace(overrides)
    except WarehouseError as error:
        return str(error).splitlines()[0]
    return next((finding.text for finding in errors(changed) if finding.code not in changed.accept), None)


def more_demand(model: Model, growth: float) -> dict[str, Any]:
    """The changes that multiply demand by a factor."""
    if growth == 1:
        return {}
    if not model.tasks.grow:
        raise StudyError(
            "--growth: this model's demand is no rate that could grow, expected tasks.goods: {poisson: orders an "
            "hour}, or flows that arrive at a rate"
        )
    return {"tasks.demand": round(model.tasks.demand * growth, 9)}
