"""The surroundings of robots: the floor, the places on it, and the dispatcher of their work."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from desim_warehouse.model import Model
from desim_warehouse.outcome.log import Log
from desim_warehouse.policies import Task
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.places.handling import HandlingTimes
from desim_warehouse.world.places.pickers import Pickers
from desim_warehouse.world.places.stops import Stop
from desim_warehouse.world.robots.bay_choice import BayChoice
from desim_warehouse.world.robots.closings import WaysRound
from desim_warehouse.world.robots.duty import Departures
from desim_warehouse.world.traffic.events import Steps

if TYPE_CHECKING:
    from simpy.events import Event

    from desim_warehouse.world.places.bays import Bays
    from desim_warehouse.world.places.service import Service
    from desim_warehouse.world.places.stations import Stations
    from desim_warehouse.world.robots.reach import Reach
    from desim_warehouse.world.robots.robot import Robot
    from desim_warehouse.world.robots.tour import Tour
    from desim_warehouse.world.traffic.events import Clock
    from desim_warehouse.world.traffic.routes import Routes
    from desim_warehouse.world.traffic.traffic import Traffic


class WorkGiver(Protocol):
    """The dispatcher, as robots know it."""

    def wait(self, robot: Robot) -> Event:
        """Offer a robot in a bay as free: the event is due when it is given a task."""

    def ask(self, robot: Robot) -> Event:
        """Offer a robot that has just unloaded: the event is due at the decision, with or without a task."""

    @property
    def decides_later(self) -> bool:
        """Whether the policy is asked next at a later instant."""

    def withdraw(self, robot: Robot) -> None:
        """Withdraw a robot in a bay: it is no longer free."""

    def give_back(self, robot: Robot) -> None:
        """Take back the task of a robot whose battery does not suffice to fetch its good after all."""

    def take_back(self, robot: Robot) -> None:
        """Take back, as open again, the task of a robot that does not fetch its good."""

    def delivered(self, robot: Robot, stop: Stop) -> None:
        """Note that a robot has unloaded."""

    def came_home(self, robot: Robot) -> None:
        """Note that a robot is back in a bay."""

    def came_to_rest(self) -> None:
        """Note that a robot rests where it has unloaded."""

    def call(self) -> None:
        """Request a decision, as a condition for decisions has changed."""

    def queue_of(self, robot: int) -> tuple[Task, ...]:
        """Return the tasks queued for a robot after its present one."""


class Carried(Protocol):
    """Pods, as robots that carry them know them."""

    def lifted(self, robot: Robot, stop: Stop) -> None:
        """Note that a robot has taken a pod from its place."""

    def serve(self, robot: Robot, stop: Stop, service: Service, state: str) -> Steps:
        """Pick line after line from the pod until none is left for it."""


@dataclass(frozen=True)
class Surroundings:
    """The parts shared by all robots of a run; `states` are those possible in this model, `reaches` are by kind."""

    env: Clock
    model: Model
    streams: Streams
    log: Log
    states: Sequence[str]
    traffic: Traffic
    routes: Routes
    stations: Stations
    handling: HandlingTimes
    bays: Bays
    bay_choice: BayChoice
    reaches: Mapping[str, Reach]
    departures: Departures
    dispatcher: WorkGiver
    ways_round: WaysRound | None
    """The robots that look for ways round closed lanes; None if routes do not change for closures."""
    pods: Carried | None
    """The pods that robots carry; None if they bring single loads."""
    tours: type[Tour]
    """The class of tours: in wide aisles, robots stand beside lanes."""
    pickers: Pickers | None
    """The pickers who load robots; None if robots load by themselves."""
