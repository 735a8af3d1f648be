"""One station beside a node, where load units are handed over: its slots, its servers, and the work done there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simpy import Resource

if TYPE_CHECKING:
    from simpy import Environment

    from desim_warehouse.values.calendars import Hours
    from desim_warehouse.world.places.workplace import Workplace


class Servers(Resource):
    """The servers of a station, a SimPy resource: a robot requests one when it is inside."""


class Station:
    """An unloading station: `places` slots for robots inside or on the way, `servers` of them are served at a time.

    Outside its `hours` nothing begins there (None: it is always open). What has begun is finished, or `pauses`. `work`
    is done on what is put down there, if anything is. Where no slot is free its node is among those that are `full`.
    """

    def __init__(
        self,
        env: Environment,
        node: str,
        places: int,
        servers: int,
        full: set[str],
        *,
        hours: Hours | None,
        pauses: bool,
        work: Workplace | None,
    ) -> None:
        self.node = node
        self.places = places
        self.taken = 0
        self.inside: set[int] = set()
        self.servers = Servers(env, servers)
        self.full = full
        self.hours = hours
        self.pauses = pauses
        self.work = work

    @property
    def free(self) -> int:
        """Slots that no robot is in or on its way to."""
        return self.places - self.taken

    def take(self) -> None:
        """A slot is reserved."""
        self.taken += 1
        if self.free <= 0:
            self.full.add(self.node)

    def give_up(self) -> None:
        """A slot is free again."""
        self.taken -= 1
        if self.free > 0:
            self.full.discard(self.node)

    def dock(self, robot: int) -> None:
        """A robot that has a slot reserved comes in."""
        self.inside.add(robot)

    def leave(self, robot: int, *, keep: bool = False) -> None:
        """A robot is out again, and its slot is free unless it is to `keep` it, as it comes back."""
        self.inside.remove(robot)
        if not keep:
            self.give_up()
