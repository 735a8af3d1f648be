"""The settled state of a fleet, at a random time of its long run: battery levels, and which robots charge where.

The state depends on the work as much as on the charging policy: robots with little to do charge between tasks, others
only when they must. So it is not computed but observed, in an uncounted run of the same model (`SettlingRun`).

With `four-thresholds` levels stay at 69 % on a ring with little to do, at 58 % with twice as much, and at 40 % in a
busy draft, so no formula by policy holds: levels drawn between two thresholds rose by 5 to 17 % of capacity an hour on
a ring of eight. The robots begin at levels of fleets at work (`settling_levels`), within about 3 points of the long run
in drafts of 6 to 10 robots; drawn up to full, levels took half a discharge to fall from 10 points above it. They are
observed from the start, at intervals that double as the run gets longer. The run ends once the batteries have been
discharged ten times in all, and half a time each, and the mean level differs between its halves by less than 0.75 % of
the capacity an hour: most drafts end after one discharge, slow fleets after four. What was observed in the second
half are the settled states; where hours or rates differ, only the one at the end of a whole day. Each counted run draws
one observation for the whole fleet, as robots that take turns are never all low. Work that ends has no long run, so its
levels are drawn between where charging begins and ends.

Rejected: simulating the hours before each run, which costs one to three runs of six hours every time rather than once
per model. A fraction of the battery: the levels of most policies stay a fixed energy below full or good, so of a
quarter of the battery they are 8 to 14 points lower in 5 of 11 models, of half of it 4 to 6.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import fmean
from typing import NamedTuple

from simpy.events import Timeout

from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import by_kind, chargers_at, cycle_levels
from desim_warehouse.model.facts.hours import repeats_after
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.places.bays import Bay
from desim_warehouse.world.robots.robot import Robot
from desim_warehouse.world.traffic.events import Clock

SEED = 39_916_801
"""The seed of the settling run; no counted run has it."""
LOOKS = 48
"""The least number of observations of the fleet; there are up to twice as many."""
MOST = 24
"""The most hours in which a fleet may settle and be observed."""
A_LOOK = 1 / 240
"""Hours between two observations at first; the interval doubles as the run gets longer."""
ROUNDS = 10
"""Battery discharges in the run, summed over robots: many robots are observed for a shorter time."""
LEAST_ROUNDS = 0.5
"""The least discharges of each battery, on average over the robots of a kind."""
DRIFT = 0.0075
"""The most by which the mean level of a settled fleet changes an hour, as a share of the capacity.

It is below the 0.01 that verdicts report, and that the law allows.
"""
_KNOWN = 64
"""The number of models whose settled fleets a process remembers."""


class Standing(NamedTuple):
    """A robot at an instant of the settling run: its energy, and the bay node at which it charges or must, if any."""

    energy: float
    charges_at: str | None = None


Fleet = tuple[Standing, ...]


class SettledError(Exception):
    """Raised to end the settling run after all observations of the fleet."""


class SettlingRun:
    """The uncounted run of a model, in which its fleet is observed; a SettledError ends it once the fleet has settled.

    `fleets`: the observations at equal intervals, after the run those of its second half; where hours or rates differ,
    the one at the end of a whole day.
    """

    def __init__(self, model: Model) -> None:
        self._hour, self._every = model.units.hour, repeats_after(model)
        self._between = {
            kind: high - low for kind, alone in by_kind(model).items() for low, high in [cycle_levels(alone)]
        }
        self._rounds = max(ROUNDS / model.fleet.size, LEAST_ROUNDS)
        length = MOST * self._hour + self._every + self._hour
        self.model = model.replace({"run.length": length, "run.warm_up": 0, "log": "tasks"})
        self.fleets: list[Fleet] = []
        self._levels: list[float] = []

    def watch(self, env: Clock, robots: Sequence[Robot]) -> None:
        """Observe the fleet from now on."""
        kinds = {kind: [robot for robot in robots if robot.kind == kind] for kind in self._between}
        interval, most = A_LOOK * self._hour, MOST * self._hour

        def look(_: object) -> None:
            nonlocal interval
            self.fleets.append(tuple(map(_standing, robots)))
            self._levels.append(fmean(robot.battery.level(env.now) / robot.battery.capacity for robot in robots))
            if env.now > most - interval / 2 or (self._have_worked(kinds, env.now) and self._is_steady(env.now)):
                self._end(env, robots)
                return
            if len(self.fleets) == 4 * LOOKS:
                del self.fleets[::2], self._levels[::2]
                interval *= 2
            Timeout(env, interval).callbacks.append(look)

        Timeout(env, interval).callbacks.append(look)

    def _have_worked(self, kinds: Mapping[str, Sequence[Robot]], now: float) -> bool:
        """Whether the robots of each kind have drawn as much energy as the run needs."""
        return all(
            math.fsum(robot.battery.drawn(now) for robot in robots) >= self._rounds * self._between[kind] * len(robots)
            for kind, robots in kinds.items()
        )

    def _is_steady(self, now: float) -> bool:
        """Whether the mean level in both halves of the run, whose middles lie half the run apart, is about the same."""
        half = len(self._levels) // 2
        change = fmean(self._levels[half:]) - fmean(self._levels[:half])
        return len(self._levels) >= 2 * LOOKS and abs(change) <= DRIFT * now / 2 / self._hour

    def _end(self, env: Clock, robots: Sequence[Robot]) -> None:
        """End the run; where hours or rates differ, at the end of a whole day, with an observation of that time."""
        if not self._every:
            del self.fleets[: len(self.fleets) // 2]
            raise SettledError

        def look(_: object) -> None:
            self.fleets = [tuple(map(_standing, robots))]
            raise SettledError

        Timeout(env, self._every * math.ceil(env.now / self._every - 1e-9) - env.now).callbacks.append(look)


class SettledFleets:
    """The settled fleets of models, computed once per model and cached in this process for the latest models."""

    def __init__(self) -> None:
        self._known: OrderedDict[Model, Sequence[Fleet]] = OrderedDict()

    def of(
        self, model: Model, settle: Callable[[SettlingRun], Sequence[Fleet]], waiting: Callable[[], object]
    ) -> Sequence[Fleet]:
        """Return the settled fleets of a model, none where it has no long run.

        Args:
            model: its batteries begin settled.
            settle: simulates a settling run.
            waiting: called now and then while another process settles the same fleet; may raise to end the wait.
        """
        if model not in self._known:
            settling = SettlingRun(model)
            if settling.model not in self._known:  # runs of another length share it
                self._known[settling.model] = self.once(settling.model, lambda: settle(settling), waiting)
            self._known[model] = self._known[settling.model]
            while len(self._known) > _KNOWN:
                self._known.popitem(last=False)
        return self._known[model]

    def once(
        self, model: Model, settle: Callable[[], Sequence[Fleet]], waiting: Callable[[], object]
    ) -> Sequence[Fleet]:
        """Return the fleets observed in a model's settling run, which is simulated; subclasses look it up first."""
        del model, waiting
        return settle()


class Unsettled(SettledFleets):
    """No settled fleets: each run draws levels between where charging begins and ends, as for work that ends."""

    def of(
        self, model: Model, settle: Callable[[SettlingRun], Sequence[Fleet]], waiting: Callable[[], object]
    ) -> Sequence[Fleet]:
        """Return none, for any model."""
        del model, settle, waiting
        return ()


UNSETTLED = Unsettled()
"""For exploratory runs: with robots fuller by ten points on_time moves by 0.001, and settling costs runs."""
OF_THIS_PROCESS = SettledFleets()
"""The fleets of this process, shared with no other."""


def has_long_run(model: Model) -> bool:
    """Whether batteries settle: the model has chargers, and endless work that draws from batteries."""
    return model.battery is not None and model.tasks.never_end and bool(chargers_at(model, model.floor))


def any_of(fleets: Sequence[Fleet], streams: Streams) -> Fleet:
    """Draw one of several fleets at random."""
    return fleets[int(streams.stream("start-energy").integers(len(fleets)))]


def nodes_at_start(fleet: Fleet, homes: Sequence[str], bays: Mapping[str, Bay], on_lanes: Iterable[int]) -> list[str]:
    """Return the bay node where each robot begins: where it charges, its home, or the first with a slot.

    Robots `on_lanes` are given their slots first.
    """
    nodes, free = list(homes), {node: bay.places for node, bay in bays.items()}
    stays = set(on_lanes)
    order = sorted(range(len(homes)), key=lambda robot: (robot not in stays, fleet[robot].charges_at is None, robot))
    for robot in order:
        node = homes[robot] if robot in stays else fleet[robot].charges_at or homes[robot]
        if not free[node]:
            node = next(other for other, slots in free.items() if slots)
        free[node] -= 1
        nodes[robot] = node
    return nodes


def _standing(robot: Robot) -> Standing:
    charging, bay = robot.charging, robot.bay
    node = bay.node if bay is not None and bay.charges and (charging.is_charging or charging.must_charge) else None
    return Standing(robot.battery.level(robot.env.now), node)
