"""The settled state of a fleet, at a random time of its long run: battery levels, and which robots charge where.

The state depends on the work as much as on the charging policy: robots with little to do charge between tasks, others
only when they must. So it is not computed but observed, in an uncounted run of the same model (`SettlingRun`).

With `four-thresholds` levels stay at 69 % on a ring with little to do, at 58 % with twice as much, and at 40 % in a
busy draft, so no formula by policy holds: levels drawn between two thresholds rose by 5 to 17 % of capacity an hour on
a ring of eight. The run lasts until the robots of each kind have drawn the energy between charged and to be charged. It
is then observed 48 times; where hours or rates differ, at the end of a whole day. Each counted run draws one
observation for the whole fleet, as robots that take turns are never all low. Work that ends has no long run, so its
levels are drawn between where charging begins and ends. Rejected: simulating the hours before each run, which costs one
to three runs of six hours every time rather than once per model.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping, Sequence
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
"""The number of observations of the fleet."""
MOST = 12
"""The most hours in which a fleet may settle and be observed."""
A_CHECK = 1 / 60
"""Hours between two checks whether the fleet has settled."""
ROUNDS = 12
"""Battery discharges to observe, summed over robots: many robots are observed for a shorter time."""
LEAST_SEEN, MOST_SEEN = 0.5, 2.0
"""The least and the most discharges of one battery during which the fleet is observed."""
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
    """The uncounted run of a model: once its fleet has settled, it is observed, and a SettledError ends the run."""

    def __init__(self, model: Model) -> None:
        self._hour, self._every = model.units.hour, repeats_after(model)
        self._most = MOST * self._hour
        self._between = {
            kind: high - low for kind, alone in by_kind(model).items() for low, high in [cycle_levels(alone)]
        }
        self._rounds = min(max(ROUNDS / model.fleet.size, LEAST_SEEN), MOST_SEEN)
        length = 2 * self._most + self._every + self._hour
        self.model = model.replace({"run.length": length, "run.warm_up": 0, "log": "tasks"})
        self.fleets: list[Fleet] = []

    def watch(self, env: Clock, robots: Sequence[Robot]) -> None:
        """Record the fleet at the times of observation."""
        kinds = {kind: [robot for robot in robots if robot.kind == kind] for kind in self._between}

        def look(_: object) -> None:
            self.fleets.append(tuple(map(_standing, robots)))
            if len(self.fleets) == (1 if self._every else LOOKS):
                raise SettledError

        def check(_: object) -> None:
            now = env.now
            if now < self._most and not self._has_settled(kinds, now):
                Timeout(env, A_CHECK * self._hour).callbacks.append(check)
            elif self._every:
                Timeout(env, self._every * math.ceil(now / self._every - 1e-9) - now).callbacks.append(look)
            else:
                seen = min(self._rounds * now, self._most)
                for number in range(1, LOOKS + 1):
                    Timeout(env, seen * number / LOOKS).callbacks.append(look)

        Timeout(env, A_CHECK * self._hour).callbacks.append(check)

    def _has_settled(self, kinds: Mapping[str, Sequence[Robot]], now: float) -> bool:
        """Whether the robots of each kind have drawn the energy that lies between charged and to be charged."""
        return all(
            math.fsum(robot.battery.drawn(now) for robot in robots) >= len(robots) * self._between[kind]
            for kind, robots in kinds.items()
        )


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
