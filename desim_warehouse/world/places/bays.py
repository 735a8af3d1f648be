"""Bays beside the nodes, where robots park and charge off the lanes, and the reservation of their slots.

A slot is reserved before a robot sets out for it. A robot that has a slot may reserve a second one only if every robot
without a slot would still find one. So a robot that leaves its work always has somewhere to go, and none queues in a
lane. If slots do not outnumber robots, no second slot is ever left: a robot that goes to a charger then gets its slot
there on leaving the bay where it rests, unless a robot from work is faster. Until then other robots at rest leave it
that slot.

On two-way lanes a robot at work always keeps a slot. If the slot has a charger that another robot seeks, it keeps a
slot elsewhere from its next task on: otherwise the other ran flat on a plant with two robots and one charger. That
needs one more slot than robots, which parking bays that grow have.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Protocol

from simpy import Event

from desim_warehouse.world.places.chargers import Chargers, FailingChargers, Spares
from desim_warehouse.world.traffic.events import Clock


class Bay:
    """Slots for robots beside a node; `taken` of them are occupied or reserved.

    `charges`: the kinds whose robots use its chargers; empty without chargers. `spares`: batteries to swap, by kind;
    none where a full one is always available. `charges_every_slot`: each slot has a charger. `waiting`: robots in the
    bay that wait for a charger, because chargers are fewer than slots or some have failed.
    """

    def __init__(
        self,
        node: str,
        places: int,
        chargers: Chargers | FailingChargers | None,
        charges: frozenset[str] = frozenset(),
        spares: Mapping[str, Spares] | None = None,
    ) -> None:
        self.node = node
        self.places = places
        self.taken = 0
        self.chargers = chargers
        self.charges = charges
        self.spares = spares or {}
        self.charges_every_slot = chargers is not None and chargers.capacity >= places
        self.waiting: list[Guest] = []

    @property
    def free(self) -> int:
        """Slots that no robot is in or on its way to."""
        return self.places - self.taken


class Guest(Protocol):
    """A robot as its bays see it: the slot it has (in `bay`, or on the way there) and the one it is `leaving`."""

    number: int
    kind: str
    bay: Bay | None
    leaving: Bay | None

    @property
    def is_out(self) -> bool:
        """Whether the robot is in no bay."""

    def charge_left(self) -> float:
        """Return the share of its battery's capacity that is left."""

    def need_of_charger(self) -> tuple[float, float]:
        """Return when the robot will need a charger more than a robot at one, and the required lead of the other.

        The lead is a share of the robot's capacity.
        """

    def comes_in(self, node: str) -> float:
        """Return the time in which the robot drives from the bay that it rests in to the bay at a node."""


class Bays:
    """All bays, and the slots that robots occupy or reserve.

    `slotless` robots are out without a slot reserved. `seekers` must charge but rest where there is no charger for
    them. Each robot in `making_room` leaves a slot of its bay to the seeker listed there, and those in `_promised` set
    out for a slot that they reserve once they are out. `keep`: robots that are out keep a slot, because their declared
    routes end there (see `avoidance`).
    """

    def __init__(self, env: Clock, bays: Iterable[Bay], *, keep: bool = False) -> None:
        self.env = env
        self.keep = keep
        self.by_node = {bay.node: bay for bay in bays}
        self.free = sum(bay.free for bay in self.by_node.values())
        self.slotless = 0
        self._sought: Event | None = None
        self._left: Event | None = None
        self.seekers: list[Guest] = []
        self.making_room: dict[int, Bay] = {}
        self._promised: dict[int, Bay] = {}

    def settle(self, robot: Guest, bay: Bay) -> None:
        """Put a robot in the bay where it starts."""
        bay.taken += 1
        self.free -= 1
        robot.bay = bay

    def may_take(self, robot: Guest, bay: Bay) -> bool:
        """Whether a robot may reserve a slot in a bay while every other robot still has a slot to go to."""
        if bay is robot.bay:
            return True
        if bay.free <= 0:
            return False
        # A second slot only if every robot without one would still find one: so a robot that leaves its work always has
        # somewhere to go, and none queues in a lane.
        return robot.bay is None or self.free - 1 >= self.slotless

    def may_go(self, robot: Guest, bay: Bay) -> bool:
        """Whether a robot may set out for a slot in a bay, to be reserved now or on leaving its own bay."""
        return self.may_take(robot, bay) or bay.free > sum(other is bay for other in self._promised.values())

    def promise(self, robot: Guest, bay: Bay) -> None:
        """Send a robot that may take no second slot on its way to a slot in a bay."""
        self._promised[robot.number] = bay

    def goal_of(self, robot: Guest) -> Bay:
        """Return the bay for which a robot sets out."""
        bay = self._promised.get(robot.number, robot.bay) if self._promised else robot.bay
        assert bay is not None
        return bay

    def take(self, robot: Guest, bay: Bay) -> None:
        """Reserve a slot before setting out for it. A robot in a bay also keeps the slot there until it leaves."""
        if robot.bay is bay:
            return
        assert self.may_take(robot, bay)
        if robot.bay is None:
            self.slotless -= 1
        elif robot.is_out:
            self._free(robot.bay)
        else:
            robot.leaving = robot.bay
        bay.taken += 1
        self.free -= 1
        robot.bay = bay

    def leave(self, robot: Guest) -> Bay | None:
        """Note that a robot has left its bay. Without a slot elsewhere it now has none, or keeps this one.

        Returns the bay for which it has set out, if it has no slot yet.
        """
        self.making_room.pop(robot.number, None)
        goal = self._promised.pop(robot.number, None) if self._promised else None
        bay = robot.leaving or robot.bay
        assert bay is not None
        if robot.leaving is None:
            if self.keep:
                return None
            robot.bay = None
            self.slotless += 1
        robot.leaving = None
        self._free(bay)
        return goal

    def _free(self, bay: Bay) -> None:
        bay.taken -= 1
        self.free += 1
        if self._left is not None:
            self._left.succeed()
            self._left = None

    # Where there are fewer slots at chargers than robots

    def chargers_are_scarce(self, kind: str, robots: Mapping[str, int]) -> bool:
        """Whether a kind has fewer slots at its chargers than there are robots, of all kinds, that use them.

        `robots`: how many there are of each kind. Where chargers are scarce robots must make room for each other.
        """
        bays = [bay for bay in self.by_node.values() if kind in bay.charges]
        users = frozenset({kind}).union(*(bay.charges for bay in bays))
        return sum(bay.places for bay in bays) < sum(robots[user] for user in users)

    def charger_for(self, robot: Guest) -> bool:
        """Whether a robot may reserve a slot at a charger now: seekers with less energy come first."""
        bays = [bay for bay in self.by_node.values() if robot.kind in bay.charges and self.may_go(robot, bay)]
        if not bays or not self.seekers:
            return bool(bays)
        left = robot.charge_left()
        ahead = [seeker for seeker in self._seekers_of(bays) if seeker is not robot and seeker.charge_left() < left]
        return sum(bay.free for bay in bays) > len(ahead)

    def neediest(self, robot: Guest) -> Guest | None:
        """Return the robot with the least energy that seeks the chargers of a robot's bay or waits there, or None."""
        assert robot.bay is not None
        in_need = [*robot.bay.waiting, *self._seekers_of([robot.bay])]
        return min(in_need, key=lambda guest: guest.charge_left(), default=None)

    def _seekers_of(self, bays: Iterable[Bay]) -> list[Guest]:
        kinds = frozenset().union(*(bay.charges for bay in bays))
        return [seeker for seeker in self.seekers if seeker.kind in kinds]

    def wants_room(self, robot: Guest) -> bool:
        """Whether a robot that rests at chargers should, and can, leave its slot to a seeker."""
        assert robot.bay is not None
        here = robot.bay.charges
        sought = len(self._seekers_of([robot.bay]))
        leaving = sum(not here.isdisjoint(bay.charges) for bay in self.making_room.values())
        return sought > leaving and bool(self.away_from(robot))

    def away_from(self, robot: Guest) -> list[Bay]:
        """Return the bays to which a robot can go to make room: bays without chargers sought by others at its place."""
        assert robot.bay is not None
        sought = robot.bay.charges.intersection(seeker.kind for seeker in self.seekers)
        return [bay for bay in self.by_node.values() if sought.isdisjoint(bay.charges) and self.may_go(robot, bay)]

    def tell_sought(self) -> None:
        """Notify robots at chargers that another must charge and finds no slot, or no charger in its bay."""
        if self._sought is not None:
            self._sought.succeed()
            self._sought = None

    def seek_charger(self) -> Event:
        """Ask robots at chargers for a free slot; the returned event is due when one leaves."""
        self.tell_sought()
        if self._left is None:
            self._left = Event(self.env)
        return self._left

    def charger_sought(self) -> Event:
        """Return an event that is due when a robot must charge and finds no slot, or no charger in its bay."""
        if self._sought is None:
            self._sought = Event(self.env)
        return self._sought
