"""The quick estimate of a model: the capacity of its fleet, and the robots and chargers that demand requires.

The time of a task is measured with a single robot of each kind, and the throughput of a whole fleet with work always
waiting (`run/quick.py`). The capacities of robots, chargers and stations are upper bounds, by Little's law and the
asymptotic bounds of closed queueing networks (Denning and Buzen, Computing Surveys 10 (1978) 225-261).

`Network` estimates queues for chargers, and the throughput of other numbers of robots, by mean value analysis of a
closed network (Reiser and Lavenberg, Journal of the ACM 27 (1980) 313-322). Robots circulate: for a part of each task
they are served at resources where others may queue, and for the rest nobody delays them. Several servers are replaced
by one server that is faster in proportion, and a delay without queues (Seidmann, Schweitzer and Shalev-Oren, LSOR
1987). Service times are assumed to be exponential; if they vary less, queues are shorter.

For `desim check`, the figures of `desim new`, and the fleet with which the search of `desim plan` begins.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import itemgetter

from desim_warehouse.feasibility.parts import LiftLoad, MeanTask, PickerLoad, PileOn, StationLoad
from desim_warehouse.feasibility.power import Power
from desim_warehouse.findings import amount
from desim_warehouse.model.facts.lifts import called

CHARGERS, THE_ROBOTS, PICKERS = "the chargers", "the robots", "the pickers"
SLOTS = "the number of slots at the stations"
SPARES = "the spare batteries"
BUSIEST = 0.99
"""Utilisation of a place up to which a number of robots is given; beyond it, queues grow too long for any number."""

_ROUNDING = 1e-9
"""Relative error of a number of robots worked out from times."""
_DIGITS = 9
"""Decimals to which limits of lifts are compared."""
MORE = 1.1
"""Factor of throughput below which twice as many robots do hardly more: the knee."""
LONGEST, STEPS = 2.0, 25
"""Upper bound of the time fitted to a measured throughput, as a multiple of the time of a task, and steps of bisection.
"""
APART = 0.95
"""Share of its bound from which on a fleet's throughput with queues counts as equal to it; below, both are printed."""


@dataclass(frozen=True)
class QuickEstimate:
    """The quick estimate of a model, in the model's own units; the module describes its assumptions.

    Attributes:
        width: width of the floor, from the westernmost to the easternmost node; `height` from north to south.
        metre: the length unit in metres; None if its name does not tell.
        lanes_hold: number of robots that can stand in the lanes at once.
        robots: size of the fleet.
        slots: number of robots that can be on a task at a time, as each needs a slot at its station; None: all.
        most_out: number of robots that may be under way at once (the key `traffic.most_out`); None: all.
        cycle: the mean task, over robots of different kinds.
        sample: number of tasks in the measurement with single robots.
        rate: tasks per time unit demanded; None if the demand is a list, or work always waits (saturated).
        charging: time that a robot charges for each task during the run; None without battery or if the work ends.
        fleet_capacity: tasks per time unit that the robots could do if nothing else limited them.
        stations: load of each node where goods are unloaded.
        crossing: the intersection that most of the tasks pass; None if it was not determined.
        crossing_capacity: tasks per time unit that this intersection lets through.
        power: the energy balance; None without battery.
        peak: tasks per time unit demanded in the busiest hour; None if arrivals do not change with the time of day.
        on_duty: share of the run in which robots are in their hours and a station is open; capacities are means over
            the run.
        pile_on: lines picked at a visit of a pod; with pods `cycle` is the part of a visit that is for one line.
        unbroken: share of its time in which a robot is not broken (availability); `on_duty` contains it already.
        measured: throughput of the fleet by a probe of all its robots, in tasks per time unit: a lower bound, the
            likely value, from which on work piles up, and an upper bound; None if no probe was made.
    """

    width: float
    height: float
    metre: float | None
    lanes_hold: int
    robots: int
    slots: int | None
    cycle: MeanTask
    sample: int
    rate: float | None
    charging: float | None
    fleet_capacity: float
    stations: tuple[StationLoad, ...]
    crossing: str | None
    crossing_capacity: float | None
    power: Power | None
    most_out: int | None = None
    peak: float | None = None
    on_duty: float = 1.0
    pile_on: PileOn | None = None
    unbroken: float = 1.0
    measured: tuple[float, float, float] | None = None
    looked_at: int = 0
    """Number of tasks in the measurement with all robots together."""
    lifts: tuple[LiftLoad, ...] = ()
    """The lifts that tasks use."""
    pickers: PickerLoad | None = None
    """The people who pick into robots; None if robots load by themselves."""
    subfleets: Mapping[str, float] = field(default_factory=dict)
    """Tasks per time unit that the robots of each subfleet could do by themselves, by name; empty where all are one."""
    busiest_hour: QuickEstimate | None = None
    """The estimate of the busiest hour, whose `rate` is `peak`; None if arrivals do not change."""

    @property
    def round(self) -> float:
        """The time that a robot spends on a task, including the time that it charges for it."""
        return self.cycle.time + (self.charging or 0.0)

    @property
    def at_work(self) -> int:
        """The number of robots that can be on a task at a time."""
        return self.robots if self.slots is None else min(self.robots, self.slots)

    @property
    def most_useful(self) -> float:
        """The robots, with fractions, that take all slots of the stations, those that charge meanwhile included."""
        return math.inf if self.slots is None else self.slots * self.round / (self.cycle.time or math.inf)

    @property
    def places(self) -> list[Place]:
        """The servers of stations and the chargers at which robots queue while they are on duty."""
        places = [
            Place(item.doing, item.share * item.servers * item.open / item.serve_capacity, item.servers)
            for item in self.stations
            if item.serve_capacity
        ]
        most = self.cycle.time  # a single robot finds the cabin where it left it
        places += [Place(called([item.name]), min(item.least, most), 1) for item in self.lifts]
        if self.pickers is not None:
            places.append(Place(PICKERS, min(self.pickers.time, most), self.pickers.count))
        if self.charging and self.power is not None and self.power.chargers:
            places.append(Place(CHARGERS, self.charging, self.power.chargers))
        return places

    @cached_property
    def queues(self) -> Network:
        """The queueing network of the fleet with stations, lifts, pickers and chargers, the only places with delays."""
        return Network(self.round, self.places)

    @cached_property
    def network(self) -> Network:
        """The queueing network of the fleet, fitted to the throughput that a probe measured."""
        if self.measured is None or not self.on_duty:
            return self.queues
        limit = min(self.other_limits.values(), default=math.inf)
        return self.queues.doing(self.capacity / self.on_duty, self._of_use(self.robots), limit / self.on_duty)

    @property
    def places_limit(self) -> dict[str, float]:
        """Limits that hold for any number of robots, by names in words: the tasks per time unit of each place."""
        limits = {item.doing: item.capacity / item.share for item in self.stations if item.share}
        lifts: dict[float, list[LiftLoad]] = {}
        for item in self.lifts:
            if item.least:
                lifts.setdefault(round(1 / item.least, _DIGITS), []).append(item)
        limits |= {called([item.name for item in alike]): self.on_duty / alike[0].least for alike in lifts.values()}
        if self.pickers is not None and self.pickers.share:
            limits[PICKERS] = self.pickers.most_tasks(self.on_duty)
        if math.isfinite(charged := self._charged(1)):
            limits[CHARGERS] = charged
        if self.power is not None and self.power.task and math.isfinite(self.power.spares_give):
            stored = 0.0 if self.power.night is None else max(self.power.slack, 0.0)
            limits[SPARES] = (self.power.spares_give + stored) / self.power.task
        if self.slots is not None and self.cycle.time:
            limits[SLOTS] = self.slots * self.on_duty / self.cycle.time
        if self.most_out is not None and self.cycle.time:
            limits["traffic.most_out"] = self.most_out * self.on_duty / self.cycle.time
        return limits

    @property
    def other_limits(self) -> dict[str, float]:
        """Limits of the present fleet beside its robots, by names in words, in tasks per time unit."""
        limits = self.places_limit
        return {**limits, CHARGERS: self._charged(self.robots)} if CHARGERS in limits else limits

    @property
    def limits(self) -> dict[str, float]:
        """The limits of the present fleet, by names in words, in tasks per time unit; the least is the capacity."""
        return {THE_ROBOTS: self.fleet_capacity, **self.other_limits}

    def _charged(self, robots: int) -> float:
        """Return the tasks per time unit for which there is energy; more robots draw more while they wait."""
        power = self.power
        if power is None or not power.chargers or power.draws is None:
            return math.inf
        gains = power.gives - power.standing * max(robots - power.chargers, 0)
        slack = power.most_slack * robots / self.robots
        spare = gains + (slack if power.night is None else min(slack, gains * power.night))
        more = power.task - power.standing * self.cycle.time
        by_energy = max(spare, 0.0) / more if more > 0 else math.inf
        if power.by_chargers < 1 or not power.task:  # nights store more, or a task draws nothing
            return by_energy
        return min(power.gives / power.task, by_energy)

    @property
    def bottleneck(self) -> str:
        """The limit of the fleet, in words: its robots, unless a place lets through hardly more than they do."""
        limits = self.other_limits
        if self.at_work == self.robots:  # all find a slot
            limits = {name: limit for name, limit in limits.items() if name != SLOTS}
        name, limit = min(limits.items(), key=itemgetter(1), default=(THE_ROBOTS, math.inf))
        most = self.range[1]
        is_it = APART * limit <= most and limit < max(self.fleet_capacity, most * (1 + _ROUNDING))
        return name if is_it else THE_ROBOTS

    @property
    def most(self) -> float:
        """Tasks per time unit that the fleet could do without queues."""
        return min(self.limits.values())

    @cached_property
    def capacity(self) -> float:
        """Tasks per time unit that the fleet can do, with the queues at stations and chargers."""
        return self.throughput(self.robots) if self.measured is None else self.measured[1]

    def throughput(self, robots: int) -> float:
        """Return the tasks per time unit that a number of robots can do, with queues at stations and chargers."""
        free = self.network.throughput(self._of_use(robots)) * self.on_duty
        return min(free, self._charged(robots), *self.places_limit.values())

    def _of_use(self, robots: int) -> int:
        """Return how many of some robots find a slot at the stations while the others charge."""
        return min(robots, math.ceil(self.most_useful * (1 - _ROUNDING))) if self.slots is not None else robots

    @property
    def robots_busy(self) -> float | None:
        """The number of robots that the demand keeps busy without any queue; None if the demand has no rate."""
        return None if self.rate is None or not self.on_duty else self.rate * self.round / self.on_duty

    @cached_property
    def robots_needed(self) -> float | None:
        """The number of robots that meet the demand; inf if no number does, None if the demand has no rate."""
        return None if self.rate is None else self.robots_for(self.rate)

    @property
    def is_overloaded(self) -> bool:
        """Whether the demand is above the fleet's capacity, whichever of robots, chargers and stations limits it."""
        return self.rate is not None and self.rate > self.can_do_at_most

    @property
    def can_do_at_most(self) -> float:
        """Tasks per time unit above which demand is more than the fleet can do: as measured, else of robots at work."""
        return self.capacity if self.measured else min(self.fleet_capacity, self.places_limit.get(SLOTS, math.inf))

    def robots_for(self, rate: float) -> float:
        """Return the number of robots, with fractions, that do `rate` tasks per time unit; inf if no number does."""
        if not self.on_duty or rate > min(self.places_limit.values(), default=math.inf):
            return math.inf
        robots = self.network.robots_for(rate / self.on_duty)
        can_work = robots <= self.most_useful * (1 + _ROUNDING)
        return robots if can_work and rate <= self._charged(math.ceil(robots)) else math.inf

    @cached_property
    def knee(self) -> tuple[int, str]:
        """The number of robots from which on up to twice as many do less than a tenth more, and the cause, in words.

        Fewer than twice as many may do more than these, as robots that wait draw energy, too.
        """
        most, why = self.lanes_hold, "the room in the lanes"
        if self._of_use(most) < most:
            most, why = self._of_use(most), SLOTS
        limits = self.ceilings
        if self.crossing is not None and self.crossing_capacity is not None:
            limits[f"the intersection {self.crossing}"] = self.crossing_capacity * self.on_duty
        limit = min(limits, key=limits.__getitem__, default="")
        if limit and limits[limit] <= 0:
            return 1, limit
        if not limit or limits[limit] * self.round >= most * self.on_duty:
            return most, why
        robots, does = 1, self.throughput(1)
        while any(
            min(self.throughput(more), limits[limit]) >= MORE * min(does, limits[limit])
            for more in range(2 * robots, robots, -1)
        ):
            robots += 1
            does = self.throughput(robots)
        return (most, why) if robots >= most else (robots, limit)

    @property
    def station_capacity(self) -> float:
        """Tasks per time unit at which the first station is always busy."""
        first = self.first_full
        return math.inf if first is None else first.capacity / first.share

    @property
    def first_full(self) -> StationLoad | None:
        """The station that is the first to be always busy, the more tasks are done; None where none has any."""
        used = (item for item in self.stations if item.share)
        return min(used, key=lambda item: item.capacity / item.share, default=None)

    @property
    def fullest(self) -> StationLoad | None:
        """The station with the highest utilisation; None without a rate, or if handling takes no time."""
        busy = [item for item in self.stations if item.busy is not None]
        return max(busy, key=lambda item: item.busy or 0.0, default=None)

    @property
    def ceilings(self) -> dict[str, float]:
        """Tasks per time unit that each place lets through, by names in words, if robots queue there at all times."""
        limits = dict(self.places_limit)
        for place in self.network.places if self.on_duty else ():
            most = place.most * self.on_duty / self.unbroken  # while one robot is broken, others come
            limits[place.name] = min(limits.get(place.name, math.inf), most)
        return limits

    @property
    def narrowest(self) -> str:
        """The place that lets the fewest tasks through, for any number of robots, in words."""
        return min(self.ceilings, key=self.ceilings.__getitem__)

    def limit_at(self, rate: float) -> str:
        """Return what keeps any number of robots from a rate of tasks, in words, where `robots_for` it is infinite."""
        if not self.on_duty or rate > BUSIEST * self.ceilings.get(self.narrowest, math.inf):
            return self.narrowest
        robots = self.network.robots_for(rate / self.on_duty)
        return CHARGERS if robots <= self.most_useful * (1 + _ROUNDING) else SLOTS

    @property
    def pickers_walk_less(self) -> bool:
        """Whether pickers are the narrowest place and walk less, the more robots wait: then an estimate is too low.

        Estimates of larger fleets take each walk to be as long as to the nearest robot of few.
        """
        name = self.narrowest if self.ceilings else ""
        return name == PICKERS and self.places_limit.get(PICKERS, math.inf) > MORE * self.ceilings[PICKERS]

    @property
    def throughput_of_queues(self) -> float:
        """Tasks per time unit of the fleet, limited only by its queues."""
        return min(self.queues.throughput(self._of_use(self.robots)) * self.on_duty, self.most)

    @property
    def range(self) -> tuple[float, float]:
        """The least and the most tasks per time unit of the fleet: as measured, else with and without queues."""
        return (self.capacity, self.most) if self.measured is None else self.measured[::2]

    def can_do(self, hour: float) -> str:
        """Return the tasks an hour that the fleet can do, in words: `210`, or `180 to 240` if the range is wide."""
        least, most = self.range
        return amount(least * hour) if least >= APART * most else f"{amount(least * hour)} to {amount(most * hour)}"


def limiting(name: str, staff: str = "") -> str:
    """Return the words that something limits the fleet: `the chargers are the limit`; `staff`: who works there."""
    are = name in {CHARGERS, PICKERS, SPARES} or name.startswith("lifts ")
    return f"{name}{f' ({staff})' if staff else ''} {'are' if are else 'is'} the limit"


@dataclass(frozen=True)
class Place:
    """A place where robots queue: its service time of a task, and its number of servers.

    `name`: the place in words, for sentences on what limits the fleet.
    """

    name: str
    time: float
    servers: int

    @property
    def most(self) -> float:
        """Tasks per time unit that the place lets through when it is always busy."""
        return self.servers / self.time if self.time else math.inf


class Network:
    """A closed queueing network of robots that always have work; `alone`: time of a task without any queue.

    `even`: weight, from 0 to 1, of the bound without queues against the exponential model; robots that arrive evenly do
    not queue until a place is always busy.
    """

    def __init__(self, alone: float, places: Sequence[Place], even: float = 0.0) -> None:
        import numpy as np

        self.alone = alone
        self._all, self._even = places, even
        self.places = [place for place in places if place.time]
        self.most = min((place.most for place in self.places), default=math.inf)
        self._each = np.array([place.time / place.servers for place in self.places])
        self._away = alone - float(self._each.sum())
        self._queues = np.zeros(len(self.places))
        self._done = [0.0]
        self._fewer: tuple[int, Network] | None = None

    def doing(self, rate: float, robots: int, limit: float = math.inf) -> Network:
        """Return the network fitted to a measured throughput of a number of robots, by its queues or by other time.

        `limit`: the most that anything but these robots lets through; at it, the rate tells nothing of their own time.
        """
        most = min(self.most, limit)
        slow, fast = self.throughput(robots), min(robots / self.alone, most)
        if rate >= fast * (1 - _ROUNDING):
            alone = robots / rate if fast < most else self.alone
            return Network(alone, self._all, float(fast > slow))
        if rate >= slow:
            return Network(self.alone, self._all, (rate - slow) / (fast - slow))
        fitted = Network(
            _fitted(lambda time: Network(time, self._all), rate, robots, self.alone, LONGEST * robots / rate), self._all
        )
        fitted._fewer = (robots, self._in_each_other_s_way(rate, robots))
        return fitted

    def _in_each_other_s_way(self, rate: float, robots: int) -> Network:
        """Return the network in which robots queue for one more place, so that a number of them do a measured rate.

        It stands for the lanes: fewer robots are less in each other's way.
        """

        def crowded(time: float) -> Network:
            return Network(self.alone, [*self._all, Place("the lanes", time, 1)])

        return crowded(_fitted(crowded, rate, robots, 0.0, self._away))

    def throughput(self, robots: int) -> float:
        """Return the tasks per time unit that a number of robots do, by mean value analysis."""
        if not self.alone:
            return math.inf
        if self._fewer is not None and robots < self._fewer[0]:
            return min(self._fewer[1].throughput(robots), self.throughput(self._fewer[0]))
        if not self.places:
            return robots / self.alone
        while len(self._done) <= robots:
            waits = self._each * (1 + self._queues)
            rate = len(self._done) / (self._away + float(waits.sum()))
            self._queues = rate * waits
            self._done.append(rate)
        queued = self._done[robots]
        return queued + self._even * (min(robots / self.alone, self.most) - queued)

    @property
    def longest(self) -> str:
        """Return the name of the place with the longest queue, at the largest number of robots computed so far."""
        return self.places[int(self._queues.argmax())].name

    def robots_for(self, rate: float) -> float:
        """Return the number of robots, with fractions, that do `rate` tasks per time unit; inf if no number does."""
        if rate > BUSIEST * self.most:
            return math.inf
        if not self.places and self._fewer is None:
            return rate * self.alone
        robots = 1
        while self.throughput(robots) < rate:
            robots += 1
        below = self.throughput(robots - 1)
        return robots - 1 + (rate - below) / (self.throughput(robots) - below)


def _fitted(network: Callable[[float], Network], rate: float, robots: int, least: float, most: float) -> float:
    """Return the time, between two bounds, with which a number of robots do a rate in a network of this time."""
    for _ in range(STEPS):
        middle = (least + most) / 2
        least, most = (middle, most) if network(middle).throughput(robots) > rate else (least, middle)
    return most
