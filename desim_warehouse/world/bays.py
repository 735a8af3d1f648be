"""Bays and stations beside the nodes: where robots park, charge and unload without standing in anybody's way.

A place is reserved before a robot sets out for it. A robot that is in a bay, or has a place reserved, may take
a second one only if every robot without a place would still find one; so a robot that leaves its work always
has somewhere to go.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simpy import Event, Resource

if TYPE_CHECKING:
    from collections.abc import Iterable

    from simpy import Environment

    from desim_warehouse.world.powered import Powered


class Chargers(Resource):
    """The chargers of a bay, a SimPy resource: a robot requests one when it is in the bay."""


class Servers(Resource):
    """The servers of a station, a SimPy resource: a robot requests one when it is inside."""


class Bay:
    """Parking places beside a node; `taken` are those occupied or reserved."""

    def __init__(self, env: Environment, node: str, places: int, chargers: int) -> None:
        self.node = node
        self.places = places
        self.taken = 0
        self.chargers = Chargers(env, chargers) if chargers else None

    @property
    def free(self) -> int:
        """Places that nobody is in or on the way to."""
        return self.places - self.taken


class Station:
    """An unloading station: `places` robots may be inside or on the way, `servers` of them are served at a time."""

    def __init__(self, env: Environment, node: str, places: int, servers: int) -> None:
        self.node = node
        self.places = places
        self.taken = 0
        self.servers = Servers(env, servers)

    @property
    def free(self) -> int:
        """Places that nobody is in or on the way to."""
        return self.places - self.taken


class Parking:
    """All bays, and who has which place."""

    def __init__(self, bays: Iterable[Bay]) -> None:
        self.bays = {bay.node: bay for bay in bays}
        self.free = sum(bay.free for bay in self.bays.values())
        self.placeless = 0
        self.seeking: Event | None = None
        self.left: Event | None = None
        self.seekers = 0
        self.making_room: set[int] = set()

    def settle(self, robot: Powered, bay: Bay) -> None:
        """A robot starts in a bay."""
        bay.taken += 1
        self.free -= 1
        robot.bay = bay

    def may_take(self, robot: Powered, bay: Bay) -> bool:
        """Whether a robot may reserve a place in a bay."""
        if bay is robot.bay:
            return True
        if bay.free <= 0:
            return False
        return robot.bay is None or self.free - 1 >= self.placeless

    def take(self, robot: Powered, bay: Bay) -> None:
        """Reserve a place; a robot that stands in a bay keeps that one until it leaves."""
        if robot.bay is bay:
            return
        assert self.may_take(robot, bay)
        if robot.bay is None:
            self.placeless -= 1
        else:
            robot.leaving = robot.bay
        bay.taken += 1
        self.free -= 1
        robot.bay = bay

    def leave(self, robot: Powered) -> None:
        """A robot is out of the bay it stood in; with none reserved elsewhere it has no place now."""
        bay = robot.leaving or robot.bay
        assert bay is not None
        if robot.leaving is None:
            robot.bay = None
            self.placeless += 1
        robot.leaving = None
        bay.taken -= 1
        self.free += 1
        self.making_room.discard(robot.number)
        if self.left is not None:
            self.left.succeed()
            self.left = None

    # Where there are fewer places at chargers than robots

    def scarce(self, robots: int) -> bool:
        """Whether there are fewer places at chargers than robots."""
        return sum(bay.places for bay in self.bays.values() if bay.chargers is not None) < robots

    def charger_for(self, robot: Powered) -> bool:
        """Whether a robot may reserve a place at a charger now."""
        return any(bay.chargers is not None and self.may_take(robot, bay) for bay in self.bays.values())

    def wanted_from(self, robot: Powered) -> bool:
        """Whether a robot that rests at a charger should make room for one that seeks it, and can."""
        return self.seekers > len(self.making_room) and any(
            bay.chargers is None and self.may_take(robot, bay) for bay in self.bays.values()
        )

    def seek(self, env: Environment) -> Event:
        """A robot wants a charger and finds none: those idle at one are told; the event is due when a place is left."""
        if self.seeking is not None:
            self.seeking.succeed()
            self.seeking = None
        if self.left is None:
            self.left = Event(env)
        return self.left

    def sought_after(self, env: Environment) -> Event:
        """Due when a robot wants a charger and finds none."""
        if self.seeking is None:
            self.seeking = Event(env)
        return self.seeking
