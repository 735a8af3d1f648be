"""A robot's life: wait for a good, fetch it, deliver it, go home, charge. Read this first.

Each robot is a SimPy process. It decides nothing itself: which task, which way, when and where to charge are
asked of the policies through the world; how it gets along the lanes is traffic's business.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from simpy.events import Event, Timeout

from desim_warehouse.errors import BatteryError
from desim_warehouse.policies import RobotView
from desim_warehouse.world.battery import Battery
from desim_warehouse.world.body import Body
from desim_warehouse.world.lanes import EPS

if TYPE_CHECKING:
    from collections.abc import Generator

    from desim_warehouse.policies import Task
    from desim_warehouse.world.bays import Bay, Station
    from desim_warehouse.world.world import World

    Steps = Generator[Event, object, None]

STATES = ("idle", "empty", "loading", "loaded", "unloading", "returning", "charging")
"""What a robot is doing; the time it waits in traffic meanwhile is kept apart."""


class Robot(Body):
    """A robot with a home, a battery and at most one task at hand."""

    def __init__(self, world: World, number: int, home: str, radius: float, speed: float) -> None:
        gap = radius + world.model.fleet.robot.margin / 2
        super().__init__(number, speed, gap, world.traffic.nodes[home])
        self.world = world
        self.env = world.env
        self.home = self.parked_at = home
        self.battery = Battery(world.model.battery)
        self.bay: Bay | None = None
        self.leaving: Bay | None = None
        self.station: Station | None = None
        self.job: Task | None = None
        self.alarm = self.flat_alarm = math.inf
        self.charged = False
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
            yield from self.rest()
            yield from self.go_out(exit_time)
            exit_time = self.world.model.fleet.exit_time
            while self.job is not None and (yield from self.fetch()):
                yield from self.deliver()
                yield from self.ask_for_more()
            yield from self.go_to_bay()
            yield from self.charge()

    def rest(self) -> Steps:
        """In a bay, until a task is given."""
        self.enter("idle")
        yield self.world.dispatcher.wait(self)

    def go_out(self, exit_time: float) -> Steps:
        """From the bay to standing at its node."""
        if self.charged:
            self.world.record("recharged", self)
            self.charged = False
            self.recharged += 1
        self.world.out += 1
        self.enter("empty")
        yield Timeout(self.env, exit_time)

    def fetch(self) -> Generator[Event, object, bool]:
        """Drive to the good and load it; False if the battery sent the robot home before it got there."""
        job, world = self.job, self.world
        assert job is not None
        way = [*world.way(self, self.node, job.edge[0]), world.traffic.lanes[job.edge]]
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
        yield from world.traffic.drive(self, world.way(self, self.node, node))
        if self.station is None:
            self.enter("unloading")
            yield Timeout(self.env, world.model.tasks.unload_time)
        else:
            self.enter_bay(node)
            world.record("docked", self)
            self.enter("idle")
            with self.station.servers.request() as turn:
                yield turn
                self.enter("unloading")
                yield Timeout(self.env, world.model.tasks.unload_time)
        world.dispatcher.delivered(self)

    def ask_for_more(self) -> Steps:
        """The next task is given out before the robot clears the place where it unloaded."""
        yield self.world.dispatcher.ask(self)
        self.enter("empty" if self.job is not None else "returning")
        yield Timeout(self.env, self.world.model.tasks.clear_time)

    def go_to_bay(self) -> Steps:
        """Home, or wherever the policies say; a place there is its own before it sets out."""
        world = self.world
        self.recall_at = math.inf
        self.enter("returning")
        world.reserve_bay(self)
        assert self.bay is not None
        yield from world.traffic.drive(self, world.way(self, self.node, self.bay.node))
        self.enter_bay(self.bay.node)
        world.record("parked", self)
        world.came_home()

    def charge(self) -> Steps:
        """At one of the bay's chargers, up to the level at which the charging policy calls it ready."""
        battery, bay = self.battery, self.bay
        assert bay is not None
        if battery.spec is None or bay.chargers is None:
            return
        self.enter("idle")
        with bay.chargers.request() as turn:
            yield turn
            self.enter("charging")
            level = battery.level(self.env.now)
            ready = self.world.charging.ready_level(self.view())
            yield Timeout(self.env, battery.charge_time(level, ready))
            battery.charge(self.env.now, ready - level)
            self.charged = True

    # Where it is and what it is doing

    @property
    def node(self) -> str:
        """The node it is at, or comes to next."""
        return self.parked_at if self.lane is None else self.lane.edge[1]

    def view(self) -> RobotView:
        """What policies see of it."""
        spec = self.battery.spec
        return RobotView(
            self.number,
            self.node,
            self.home,
            self.battery.level(self.env.now),
            self.battery.capacity,
            0.0 if spec is None else spec.threshold,
        )

    def enter_bay(self, node: str) -> None:
        """From the node it stands on into the bay or station beside it."""
        self.world.traffic.into_bay(self)
        self.parked_at = node

    def left_bay(self) -> None:
        """Out of the bay or station: its place there is free."""
        if self.station is not None and self.parked_at == self.station.node:
            self.station.taken -= 1
            self.station = None
        else:
            self.world.parking.leave(self)

    def enter(self, state: str) -> None:
        """Begin something else: the time goes to the old state, the battery draws the new rate."""
        now = self.env.now
        waited = self.waited - self.waited_before
        self.time_in[self.state] += now - self.since_state - waited
        self.waited_before = self.waited
        self.since_state = now
        if state != self.state:
            self.state = state
            self.world.record(state, self)
        self._draw(state)

    def _draw(self, state: str) -> None:
        at_charger = self.lane is None and self.bay is not None and self.bay.chargers is not None
        resting = state in ("idle", "charging") and at_charger
        self.battery.draw(self.env.now, 0.0 if resting or state == "charging" else self.battery.rates[state])
        self.watch()

    def stands(self, waiting: bool) -> None:
        """It begins or ends waiting in traffic: where standing draws less than driving, the battery is told."""
        if self.battery.varies:
            self._draw("waiting" if waiting else self.state)

    def tally(self, now: float) -> dict[str, float]:
        """What it has done so far, in plain numbers; times in all states and `waiting` add up to `now`."""
        return {
            **self.time_in,
            "waiting": self.waited,
            "distance": self.distance(now),
            "energy": self.battery.drawn(now),
            "moves": self.moves,
            "rear_ends": self.rear_ends,
            "crossings": self.crossings,
            "delivered": self.delivered,
            "recharged": self.recharged,
        }

    # The battery's alarm

    def watch(self) -> None:
        """Know the instants at which the battery will be flat and, on the way to a good, send the robot home."""
        now, battery = self.env.now, self.battery
        if battery.spec is None:
            return
        flat_at = battery.lasts_until(now, -battery.spec.reserve)
        if flat_at < self.flat_alarm:
            self.flat_alarm = flat_at
            Timeout(self.env, flat_at - now).callbacks.append(self._flat)
        if self.job is None or self.state != "empty":
            return
        level = self.world.charging.recall_level(self.view())
        self.recall_at = math.inf if level is None else battery.lasts_until(now, level)
        if self.recall_at < self.alarm:
            self.alarm = self.recall_at
            Timeout(self.env, self.alarm - now).callbacks.append(self._low)

    def _flat(self, _: Event) -> None:
        self.flat_alarm = math.inf
        spec = self.battery.spec
        if spec is None or self.battery.level(self.env.now) > 1e-9 * spec.capacity - spec.reserve:
            self.watch()
            return
        charging = self.world.model.policies.charging.name
        raise BatteryError(
            f"robot {self.number} ran flat at time {self.env.now:g}, {self.place()}, {self.state}: "
            f"policies.charging ({charging}) let it go on with too little energy"
        )

    def _low(self, _: Event) -> None:
        self.alarm = math.inf
        if self.job is None or self.state != "empty":
            return
        if self.recall_at > self.env.now + EPS:
            self.watch()
        elif self.at_edge_of(self.job):
            self.recall_at = math.inf
        else:
            self.world.dispatcher.give_back(self)

    def at_edge_of(self, job: Task) -> bool:
        """Whether it is on its good's edge, or stands at the node where that begins."""
        if self.lane is not None and self.lane.edge == job.edge:
            return True
        standing = self.lane is None or (self.held is not None and self.pos >= self.lane.length)
        return standing and self.node == job.edge[0]
