"""Delays of a robot at the nodes that it passes, drawn from streams of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.values.distributions import draws

if TYPE_CHECKING:
    from desim_warehouse.values.disturbances import DelaySpec
    from desim_warehouse.values.streams import Streams


class NodeDelays:
    """How long a robot is delayed at the end of each lane that it enters."""

    def __init__(self, spec: DelaySpec, robot: int, streams: Streams) -> None:
        self._share = spec.share
        self._chance = streams.stream("delay-share", robot) if 0 < spec.share < 1 else None
        self._time = draws(spec.time if spec.share else 0.0, streams, "delay", robot)
        self._move = -1
        self._delay = 0.0

    def at(self, move: int) -> float:
        """The delay at the end of the lane that it entered as number `move`, from 1; 0: where it starts.

        It is the same however often it is asked for.
        """
        while self._move < move:
            self._move += 1
            hit = self._share > 0 if self._chance is None else self._chance.random() < self._share
            self._delay = self._time() if hit else 0.0
        return self._delay
