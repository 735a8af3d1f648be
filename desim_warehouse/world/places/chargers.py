"""The chargers of a bay, which robots in it request, and which may fail and be repaired.

A charger fails by the calendar, in use or not, at times drawn from a stream of its own. These are drawn only as far as
robots request charging, so that outages alone keep no run going. A robot at a charger that fails is first in the queue
for the next working one, this or another of the bay.

Where batteries are swapped, the spare batteries of a bay may run short: each battery taken out charges by itself.

It charges as long as in a robot, and there is a place to charge for each of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, Self

from simpy import Container, Event, Resource
from simpy.events import Timeout

from desim_warehouse.values.distributions import draws
from desim_warehouse.values.disturbances import OutageSpec
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.traffic.events import Arrival, Clock

if TYPE_CHECKING:
    from simpy.resources.resource import Request


class Chargers(Resource):
    """Chargers that never fail, a SimPy resource."""

    def turn(self, *, first: bool = False) -> Request:  # noqa: ARG002 - no robot loses a charger
        """Return a robot's request for a charger, an event. It is given back at the end of the `with` block."""
        return self.request()

    def outage_of(self, turn: Any) -> Event | None:  # noqa: ARG002
        """Return the event of a breakdown of the charger that a robot holds; None, as these never fail."""
        return None


class Turn(Event):
    """A robot's request for a charger that may fail: due when it is granted; `lost` is due when the charger fails."""

    def __init__(self, chargers: FailingChargers) -> None:
        super().__init__(chargers.env)
        self.chargers = chargers
        self.lost = Event(chargers.env)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.chargers.give_back(self)


class FailingCharger:
    """One charger: under repair from `fails_at` on, working again from `repaired_at` on, and so on."""

    def __init__(self, every: Callable[[], float], repair: Callable[[], float]) -> None:
        self.user: Turn | None = None
        self._every, self._repair = every, repair
        self.fails_at = every()
        self.repaired_at = self.fails_at + repair()

    def draw_outages(self, now: float) -> None:
        """Draw the outages of the charger from its random stream, up to the first that ends after now."""
        while self.repaired_at <= now:
            self.fails_at = self.repaired_at + self._every()
            self.repaired_at = self.fails_at + self._repair()


class FailingChargers:
    """The chargers of a bay, each with outages of its own, and the `queue` of waiting requests."""

    def __init__(self, env: Clock, node: str, number: int, spec: OutageSpec, streams: Streams) -> None:
        self.env = env
        self.capacity = number
        self.queue: list[Turn] = []
        self._chargers = [
            FailingCharger(
                draws(spec.every, streams, f"charger-failure:{node}", rank),
                draws(spec.repair, streams, f"charger-repair:{node}", rank),
            )
            for rank in range(number)
        ]

    def turn(self, *, first: bool = False) -> Turn:
        """Return a robot's request for a charger, an event. A robot whose charger has failed comes `first`."""
        turn = Turn(self)
        self.queue.insert(0 if first else len(self.queue), turn)
        self._serve()
        return turn

    def outage_of(self, turn: Any) -> Event | None:
        """Return the event of a breakdown of the charger that a robot holds.

        `turn` is the robot's request for a charger.
        """
        lost: Event = turn.lost
        return lost

    def give_back(self, turn: Turn) -> None:
        """Take a charger back: it has failed, or the robot no longer needs it."""
        if turn in self.queue:
            self.queue.remove(turn)
        for charger in self._chargers:
            if charger.user is turn:
                charger.user = None
        self._serve()

    def _serve(self, _: Event | None = None) -> None:
        """Grant working chargers to waiting robots, and serve them again when the next charger is repaired."""
        now = self.env.now
        free = [charger for charger in self._chargers if charger.user is None]
        for charger in free:
            charger.draw_outages(now)
        for charger in [idle for idle in free if now < idle.fails_at][: len(self.queue)]:
            charger.user = turn = self.queue.pop(0)
            turn.succeed()
            Arrival(self.env, charger.fails_at).callbacks.append(partial(self._fails, charger, turn))
        in_repair = [charger.repaired_at for charger in free if charger.user is None]
        if self.queue and in_repair:
            Arrival(self.env, min(in_repair)).callbacks.append(self._serve)

    def _fails(self, charger: FailingCharger, turn: Turn, _: Event) -> None:
        if charger.user is turn:
            charger.user = None
            turn.lost.succeed()


class Spares:
    """The spare batteries of a bay: full ones are in a SimPy container, which serves robots in turn."""

    def __init__(self, env: Clock, number: int) -> None:
        self.env = env
        self._full = Container(env, init=number)

    def exchange(self, charge_time: float) -> Event:
        """Take in an empty battery, full after `charge_time`; the event is due when the robot has a full one for it."""
        Timeout(self.env, charge_time).callbacks.append(self._is_full)
        return self._full.get(1)

    def _is_full(self, _: Event) -> None:
        self._full.put(1)


class NewBattery:
    """The swap of a robot's battery, which takes `left` once a full one is available, from `spares` or at once."""

    def __init__(self, time: float, spares: Spares | None) -> None:
        self.left = time
        self.spares = spares
        self.full: Event | None = None
        self._begun: float | None = None

    def waits(self, env: Clock, charge_time: float) -> Iterator[Event]:
        """Yield the events that the robot waits for; its own battery is full after `charge_time`."""
        if self.spares is not None:
            self.full = self.full or self.spares.exchange(charge_time)
            yield self.full
        self._begun = env.now
        yield Timeout(env, self.left)

    def interrupt(self, now: float) -> None:
        """Note that the robot loses its place: the part of the swap that is done remains done."""
        if self._begun is not None:
            self.left -= now - self._begun
            self._begun = None
