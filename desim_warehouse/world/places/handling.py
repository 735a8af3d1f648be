"""Times of loading, unloading and work in a station, by the model; random times are sampled for each task.

Each task has a stream of its own for each of them, so its times do not depend on the robot. Compared designs thus
differ by their decisions, not by luck at the shelves.
"""

from __future__ import annotations

from collections.abc import Mapping

from desim_warehouse.layout.spec import StationSpec
from desim_warehouse.policies import Handling, Task
from desim_warehouse.values.distributions import Distribution, drawn
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.places.stops import Stop


class HandlingTimes:
    """The handling times of tasks: `times` as the model gives them, random ones drawn for each task.

    `stations`: the specification of each station by node.
    """

    def __init__(
        self, times: Handling[float | Distribution], stations: Mapping[str, StationSpec], streams: Streams
    ) -> None:
        self.times, self._stations, self.streams = times, stations, streams

    def time(self, stop: Stop) -> float:
        """Return the handling time of a stop of a tour."""
        purpose = f"stop{stop.rank}" if stop.act == "visit" else stop.act
        return self._drawn(purpose, stop.of(self.times), stop.task)

    def pick(self, line: Task) -> float:
        """Return the time of picking a line from a pod, or of putting one onto it."""
        return self._drawn("pick", self.times.at_stop("visit", line.flow), line)

    def work(self, node: str, task: Task) -> float:
        """Return the time of work on a load unit put down in the station at a node."""
        time = self._stations[node].work_time
        assert time is not None
        return self._drawn("work", time, task)

    def _drawn(self, purpose: str, time: float | Distribution, task: Task) -> float:
        stream_name, number = (f"{purpose}:{task.flow}", task.nth) if task.flow else (purpose, task.number)
        return drawn(time, lambda: self.streams.stream(stream_name, number))
