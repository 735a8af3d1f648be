"""What traffic asks of a robot, and tells it, about the body that it drives."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from simpy.events import Event

    from desim_warehouse.world.traffic.drive import Drive
    from desim_warehouse.world.traffic.lane import Lane

    Steps = Generator[Event, object, None]


class Driver(Protocol):
    """Who decides for a body and learns what happens to it: a robot."""

    def left_bay(self) -> None:
        """It has just left the bay it stood in."""

    def take_detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Another route for a robot held up before `route[index]`, or None to wait. Asked while `detours` are left."""

    def give_way(self) -> None:
        """Others wait for it while it rests where it is: it goes on to a bay."""

    def notice_wait(self, waiting: bool) -> None:
        """It begins, or ends, to wait in traffic."""

    def notice_delay(self, begin: float, end: float) -> None:
        """It is known that it will wait in traffic from `begin` to `end`."""

    def halt(self, drive: Drive) -> Steps:
        """A breakdown is due: the robot stands until it is repaired, or cleared off the lanes. Never in a bay."""


class NoDriver:
    """For bodies that only follow routes."""

    def left_bay(self) -> None:
        """Nothing to do."""

    def take_detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:  # noqa: ARG002
        """None: it waits."""
        return None

    def give_way(self) -> None:
        """Nothing to do."""

    def notice_wait(self, waiting: bool) -> None:
        """Nothing to do."""

    def notice_delay(self, begin: float, end: float) -> None:
        """Nothing to do."""

    def halt(self, drive: Drive) -> Steps:  # noqa: ARG002
        """It never breaks down."""
        yield from ()
