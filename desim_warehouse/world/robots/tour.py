"""Tours: how a robot does one task or several, from stop to stop, loading and unloading, in stations by a server.

Until the robot has loaded for the first time, its battery may recall it or a closure turn it off. From then on it
completes the tour.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import TYPE_CHECKING

from simpy.events import Event, Timeout

from desim_warehouse.world.places.handling import HandlingTimes
from desim_warehouse.world.places.pickers import Pickers
from desim_warehouse.world.places.service import Service
from desim_warehouse.world.places.station import Station
from desim_warehouse.world.places.stations import Stations
from desim_warehouse.world.places.stops import Stop
from desim_warehouse.world.robots.closings import Closings
from desim_warehouse.world.robots.duty import Departures
from desim_warehouse.world.robots.surroundings import Carried, WorkGiver
from desim_warehouse.world.traffic.events import Clock, Steps

if TYPE_CHECKING:
    from desim_warehouse.world.robots.robot import Robot


class Tour:
    """The work that a robot has in hand: `stops` to come, and `slots` reserved in stations that it has yet to reach.

    Slots are reserved in all stations of a tour at once before the robot sets out, and each is kept until it leaves
    that station for the last time. So no robot with a load waits for a slot, and none waits for another.
    """

    def __init__(
        self,
        robot: Robot,
        env: Clock,
        *,
        dispatcher: WorkGiver,
        stations: Stations,
        handling: HandlingTimes,
        departures: Departures,
        closings: Closings | None,
        pods: Carried | None,
        pickers: Pickers | None,
    ) -> None:
        self.robot = robot
        self.env = env
        self.dispatcher = dispatcher
        self.stations = stations
        self.handling = handling
        self.departures = departures
        self.closings = closings
        self.pods = pods
        self.pickers = pickers
        self.stops: list[Stop] = []
        self.slots: list[Station] = []

    # The course of a tour

    def begin(self) -> Generator[Event, object, bool]:
        """Drive to the first stop and load there. Returns False if the battery sent the robot home before."""
        robot = self.robot
        if self.pickers is not None:
            yield from self.pickers.set_out(robot, self.stops)
            robot.enter("empty")
        if robot.docked is None or robot.docked is not self.stops[0].station:
            if self.closings is not None and not robot.body.is_on_lanes and self.closings.is_cut_off:
                self.closings.turn_back()
                return False
            if not self._declare():
                # Drive to the bay where its declared route ends: from there it can set out again.
                robot.body.recall_from(math.inf)
                robot.enter("returning")
                yield from robot.go_to_bay()
                self.departures.under_way.add(robot.number)
                robot.enter("empty")
                self._declare()
            if self.closings is not None:
                self.closings.watch()
            route, place = robot.itinerary.legs.pop(0)
            drive = robot.drive(route, place)
            while not (yield from drive):
                if self._turns_back():
                    if robot.job is not None:  # it got to the node at the very instant of the alarm
                        self.dispatcher.give_back(robot)
                    return False
                # Go on as declared and ask again at the next node: a recall just after now does not stop it on this
                # one.
                robot.body.recall_from(math.nextafter(self.env.now, math.inf))
                drive = robot.drive(drive.rest, place)
        robot.body.recall_from(math.inf)  # also where it loads in the station in which it stands
        yield from self._handle(self.stops[0])
        return True

    def finish(self) -> Steps:
        """Drive with the load from stop to stop, until all is unloaded."""
        robot = self.robot
        while self.stops:
            stop = self.stops[0]
            if self.pickers is not None:
                self.pickers.expect(robot, stop)
            if robot.docked is None or robot.docked is not stop.station:
                route, place = robot.itinerary.onward(robot.node, self.stops, self._bay_after_it())
                yield from robot.drive(route, place)
            yield from self._handle(stop)

    def _handle(self, stop: Stop) -> Steps:
        """Load or unload at the robot's place, or in a station when it is served."""
        if stop.station is not None:
            yield from self._be_served(stop.station)
            return
        if self.pickers is not None and self.pickers.serve_at(stop):
            yield from self._be_picked(stop, self.pickers)
        else:
            self.robot.enter(_state(stop))
            yield Timeout(self.env, self.handling.time(stop))
        self._go_on_after(stop)

    def _be_picked(self, stop: Stop, pickers: Pickers) -> Steps:
        """Wait for a picker at a storage place, who loads or unloads the robot."""
        robot = self.robot
        yield from pickers.come(robot, stop)
        robot.enter(_state(stop))
        time = self.handling.time(stop)
        pickers.begin(robot, stop, time)
        yield Timeout(self.env, time)
        pickers.end(robot, self.stops[1:])

    def _be_served(self, station: Station) -> Steps:
        """Handle all the robot's loads in a station, one after the other; it keeps the server until all are handled."""
        if self.robot.docked is not station:
            self._dock(station)
        service = Service(self.env, self.robot, station)
        while self.stops and self.stops[0].station is station:
            stop = self.stops[0]
            yield from service.begin(stop)
            if self.pods is not None:
                yield from self.pods.serve(self.robot, stop, service, _state(stop))
            else:
                yield from service.take(_state(stop), self.handling.time(stop))
            self._go_on_after(stop)
            service.end(stop)
        service.leave()

    def _go_on_after(self, stop: Stop) -> None:
        """Set out for the next stop after a completed one."""
        robot = self.robot
        if stop.act == "unload":
            self.dispatcher.delivered(robot, stop)
        elif stop.act == "visit":
            self.stations.release((stop,), ())
        elif self.pods is not None:
            self.pods.lifted(robot, stop)
        del self.stops[:1]
        robot.body.change_speed(robot.loaded_speed if self.stops else robot.speed)
        if self.stops:
            then = self.stops[0].task.number
            if stop.act == "unload":
                robot.body.work_on(then)
            robot.enter("loaded")  # of a load just taken up the row still names its own task
            robot.body.work_on(then)

    # Routes

    def _declare(self) -> bool:
        """Set the robot's route from stop to stop; returns False if the change would not be safe."""
        robot = self.robot
        return robot.itinerary.take(robot.node, self.stops, self._bay_after_it())

    def _bay_after_it(self) -> str | None:
        """Return the bay to which the robot goes from a last stop in the lane, if it gets no further task."""
        bay = self.robot.bay
        return None if bay is None else bay.node

    def _turns_back(self) -> bool:
        """Whether the robot, recalled on its way to the first stop, goes to the bay where it has a slot instead.

        Where routes are declared that is decided at a node: not if others do not let it, nor where its good's lane
        begins, which is so near that it finishes the task, as one does that is called back there.
        """
        robot = self.robot
        if not robot.itinerary.is_declared or robot.job is None:  # turned off, it has declared its way home already
            return True
        assert robot.bay is not None
        return not robot.is_at_good_edge and robot.itinerary.go(robot.node, robot.bay.node)

    # Stations

    def _dock(self, station: Station) -> None:
        """Drive from the node under the robot into the station beside it, where it has a slot."""
        robot = self.robot
        self.slots.remove(station)
        robot.dock(station)
        station.dock(robot.number)
        robot.record("docked")

    def leaves(self, station: Station) -> None:
        """Leave a station, and free the robot's slot there unless it comes back on this tour."""
        comes_back = station not in self.slots and any(stop.station is station for stop in self.stops)
        if comes_back:
            self.slots.append(station)
        station.leave(self.robot.number, keep=comes_back)


def _state(stop: Stop) -> str:
    """Return the state of a robot at a stop."""
    return "loading" if stop.act == "load" else "unloading"
