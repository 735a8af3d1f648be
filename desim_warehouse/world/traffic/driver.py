"""Drivers: what traffic asks of a robot, and tells it, about the body that it drives."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from simpy.events import Event

    from desim_warehouse.world.traffic.drive import Drive
    from desim_warehouse.world.traffic.lane import Lane

    Steps = Generator[Event, object, None]


class Driver(Protocol):
    """A robot, as its body knows it: it decides, and learns what happens to the body."""

    def left_bay(self) -> None:
        """Note that it has just left the bay it stood in."""

    def take_detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Return another route if held up before `route[index]`, or None to wait. Asked while `detours` are left."""

    def stood_aside(self) -> None:
        """Note that the body stands beside its lane, in a wide aisle, and comes back onto it later."""

    def give_way(self) -> None:
        """End its rest, if it rests where it unloaded: others wait for the place, and it goes on to a bay."""

    def notice_wait(self, waiting: bool) -> None:
        """Note that it begins, or ends, to wait in traffic."""

    def notice_delay(self, begin: float, end: float) -> None:
        """Note that it will wait in traffic from `begin` to `end`."""

    def halt(self, drive: Drive) -> Steps:
        """Stand until a due breakdown is repaired, on the lanes or, once cleared, beside them. Never in a bay."""


class NoDriver:
    """A driver of bodies that only follow routes."""

    def left_bay(self) -> None:
        """Do nothing."""

    def take_detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:  # noqa: ARG002
        """Return None: it waits."""
        return None

    def stood_aside(self) -> None:
        """Nothing to do."""

    def give_way(self) -> None:
        """Nothing to do."""

    def notice_wait(self, waiting: bool) -> None:
        """Do nothing."""

    def notice_delay(self, begin: float, end: float) -> None:
        """Do nothing."""

    def halt(self, drive: Drive) -> Steps:  # noqa: ARG002
        """Do nothing: it never breaks down."""
        yield from ()
