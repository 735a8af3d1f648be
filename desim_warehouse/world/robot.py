"""A robot's life: wait for a good, fetch it, deliver it, go home, charge. Read this first.

Each robot is a SimPy process. It decides nothing itself: which task, which way, when and where to charge are
asked of the policies through the world; how it gets along the lanes is traffic's business.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from simpy.events import Event, Timeout

from desim_warehouse.log import STATES
from desim_warehouse.world.powered import Powered

if TYPE_CHECKING:
    from collections.abc import Generator

    from desim_warehouse.world.world import World

    Steps = Generator[Event, object, None]


class Robot(Powered):
    """A robot with a home, a battery and at most one task at hand."""

    def __init__(self, world: World, number: int, home: str, speed: float) -> None:
        super().__init__(world, number, home, speed)
        self.offer: Event | None = None
        self.recharged = self.delivered = 0
        self.state = "idle"
        self.since_state = 0.0
        self.waited_before = 0.0
        self.time_in = dict.fromkeys(STATES, 0.0)

    # The story

    def life(self) -> Steps:
        """Work as long as there is any; rest and charge in a bay in between."""
        exit_time = self.world.model.fleet.first_exit_time
        while True:
            if (yield from self.rest()):
                yield from self.go_out(exit_time)
                while self.job is not None and (yield from self.fetch()):
                    yield from self.deliver()
                    yield from self.ask_for_more()
                self.reserve_bay()
            elif self.short and self.at_charger:
                yield from self.charge()
                continue
            elif not self.at_charger and not self.world.parking.charger_for(self):
                continue
            else:
                self.reserve_bay(away=self.at_charger)
                yield from self.go_out(exit_time)
            exit_time = self.world.model.fleet.exit_time
            yield from self.go_to_bay()
            yield from self.charge()

    def rest(self) -> Generator[Event, object, bool]:
        """In a bay, until a task is given (True), or until it must leave for the sake of a battery (False)."""
        self.enter("idle")
        if self.number in self.world.parking.making_room:
            return False
        offer = self.offer or self.world.dispatcher.wait(self)
        self.offer = None
        if self.battery.spec is None or (self.at_charger and not self.world.scarce):
            if self.job is None:
                yield offer
            return self.job is not None
        return (yield from self.rest_uneasily(offer))

    def go_out(self, exit_time: float) -> Steps:
        """From the bay to standing at its node."""
        if self.charged and self.job is not None:
            self.world.record("recharged", self)
            self.charged = False
            self.recharged += 1
        self.world.out += 1
        self.enter("empty" if self.job is not None else "returning")
        yield Timeout(self.env, exit_time)

    def fetch(self) -> Generator[Event, object, bool]:
        """Drive to the good and load it; False if the battery sent the robot home before it got there."""
        job, world = self.job, self.world
        assert job is not None
        way = [*world.decisions.way(self.node, job.edge[0]), world.traffic.lanes[job.edge]]
        self.detours = world.decisions.detours
        if not (yield from world.traffic.drive(self, way, job.offset)):
            if self.job is not None:  # it got to the node at the very instant of the alarm
                world.dispatcher.give_back(self)
            return False
        self.recall_at = math.inf
        self.enter("loading")
        yield Timeout(self.env, world.model.tasks.load_time)
        self.enter("loaded")
        return True

    def deliver(self) -> Steps:
        """Drive to the station and unload, in its bay if it has one, else in the lane."""
        world = self.world
        assert self.job is not None
        node = world.dispatcher.unload_at[self.job.number]
        self.detours = world.decisions.detours
        yield from world.traffic.drive(self, world.decisions.way(self.node, node))
        if self.station is None:
            self.enter("unloading")
            yield Timeout(self.env, world.model.tasks.unload_time)
        else:
            self.enter_bay(node)
            self.docked, self.station = self.station, None
            world.record("docked", self)
            with self.docked.servers.request() as turn:
                if not turn.triggered:
                    self.enter("queueing")
                yield turn
                self.enter("unloading")
                yield Timeout(self.env, world.model.tasks.unload_time)
        world.dispatcher.delivered(self)

    def ask_for_more(self) -> Steps:
        """The next task is given out before the robot clears the place where it unloaded."""
        yield self.world.dispatcher.ask(self)
        self.enter("empty" if self.job is not None else "returning")
        yield Timeout(self.env, self.world.model.tasks.clear_time)

    def reserve_bay(self, *, away: bool = False) -> None:
        """A place to go to, its own before it sets out; `away`: one without a charger."""
        self.recall_at = math.inf
        if self.is_out:
            self.enter("returning")
            self.short = self.battery.spec is not None and self.world.dispatcher.short(self)
        self.world.parking.take(self, self.world.decisions.choose_bay(self, away=away))

    def go_to_bay(self) -> Steps:
        """Home, or wherever the policies say."""
        world = self.world
        assert self.bay is not None
        if self.is_out or self.bay.node != self.parked_at:
            self.detours = world.decisions.detours
            yield from world.traffic.drive(self, world.decisions.way(self.node, self.bay.node))
            self.enter_bay(self.bay.node)
        self.last_bay = self.bay.node
        world.record("parked", self)
        world.came_home()

    def charge(self) -> Steps:
        """At one of the bay's chargers, if its battery wants it; free for a task once there is enough for one."""
        battery, bay = self.battery, self.bay
        assert bay is not None
        if battery.spec is None or bay.chargers is None:
            return
        self.enter("idle")
        levels, level = self.world.decisions.levels(self.view()), battery.level(self.env.now)
        if level < levels.full and (levels.top_up or self.short or level <= levels.good):
            ready = level >= levels.sufficient
            self.offer = yield from self.charge_at(bay, self.world.dispatcher.wait(self) if ready else None)

    # Where it is and what it is doing

    @property
    def is_out(self) -> bool:
        """Whether it is in no bay: on a lane, in a station, or on the node by which it has just come out."""
        return self.lane is not None or self.held is not None or self.docked is not None

    def enter_bay(self, node: str) -> None:
        """From the node it stands on into the bay or station beside it."""
        self.world.traffic.into_bay(self)
        self.parked_at = node

    def left_bay(self) -> None:
        """Out of the bay or station: its place there is free."""
        if self.docked is not None:
            self.docked.taken -= 1
            self.docked = None
            self.world.dispatcher.call()
        else:
            self.world.parking.leave(self)
            if self.world.scarce:
                self.world.dispatcher.call()

    def enter(self, state: str) -> None:
        """Begin something else: the time goes to the old state, the battery draws the new rate."""
        now = self.env.now
        waited_by_now = self.waited_by(now)
        waited = waited_by_now - self.waited_before
        self.time_in[self.state] += now - self.since_state - waited
        self.waited_before = waited_by_now
        self.since_state = now
        if state != self.state:
            self.state = state
            self.world.record(state, self)
        self.draw(state)

    def tally(self, now: float) -> dict[str, float]:
        """What it has done so far, in plain numbers; times in all states and `waiting` add up to `now`."""
        return {
            **self.time_in,
            "waiting": self.waited_by(now),
            "distance": self.distance(now),
            "energy": self.battery.drawn(now),
            "moves": self.moves,
            "rear_ends": self.rear_ends,
            "crossings": self.crossings,
            "delivered": self.delivered,
            "recharged": self.recharged,
        }
