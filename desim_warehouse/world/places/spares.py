"""Spare batteries of a bay where batteries are swapped: those taken out of robots charge by themselves, and run short.

A battery that is taken out charges as long as in a robot. There is a place to charge for each of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simpy import Container
from simpy.events import Timeout

if TYPE_CHECKING:
    from collections.abc import Iterator

    from simpy import Environment, Event


class Spares:
    """The spare batteries of a bay: the full ones are a SimPy container, which robots are served from in turn."""

    def __init__(self, env: Environment, number: int) -> None:
        self.env = env
        self._full = Container(env, init=number)

    def exchange(self, charge_time: float) -> Event:
        """Take in a battery that is full after `charge_time`; due when the robot has got a full one for it."""
        Timeout(self.env, charge_time).callbacks.append(self._is_full)
        return self._full.get(1)

    def _is_full(self, _: Event) -> None:
        self._full.put(1)


class NewBattery:
    """A robot's swap, which takes `left`, once there is a full battery: any time, or one of the `spares`."""

    def __init__(self, time: float, spares: Spares | None) -> None:
        self.left = time
        self.spares = spares
        self.full: Event | None = None
        self._begun: float | None = None

    def waits(self, env: Environment, charge_time: float) -> Iterator[Event]:
        """What the robot waits for, one after the other; its own battery is full after `charge_time`."""
        if self.spares is not None:
            self.full = self.full or self.spares.exchange(charge_time)
            yield self.full
        self._begun = env.now
        yield Timeout(env, self.left)

    def interrupt(self, now: float) -> None:
        """The robot loses its place: what has been done of the swap remains done."""
        if self._begun is not None:
            self.left -= now - self._begun
            self._begun = None
