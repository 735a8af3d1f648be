"""A robot's power: what its battery holds and draws, when it runs low, and the charger it turns to."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from simpy.events import Event, EventPriority, Timeout

from desim_warehouse.errors import BatteryError
from desim_warehouse.policies import RobotView
from desim_warehouse.world.battery import Battery
from desim_warehouse.world.body import Body
from desim_warehouse.world.lanes import EPS

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from desim_warehouse.policies import Levels, Task
    from desim_warehouse.world.bays import Bay, Station
    from desim_warehouse.world.lanes import Lane
    from desim_warehouse.world.world import World

    Steps = Generator[Event, object, None]


class Powered(Body, ABC):
    """A body with a battery, a home and perhaps a task; its levels are the charging policy's."""

    state: str
    since_state: float
    delivered: int

    def __init__(self, world: World, number: int, home: str, speed: float) -> None:
        super().__init__(number, speed, world.traffic.nodes[home])
        self.world = world
        self.env = world.env
        self.home = self.parked_at = self.last_bay = home
        self.battery = Battery(world.model.battery)
        self.bay: Bay | None = None
        self.leaving: Bay | None = None
        self.station: Station | None = None
        self.docked: Station | None = None
        self.job: Task | None = None
        self.alarm = self.flat_alarm = math.inf
        self.looks_ahead = False
        self.charged = self.short = self.plugged = False

    # What policies see

    @property
    def node(self) -> str:
        """The node it is at, or comes to next."""
        return self.parked_at if self.lane is None else self.lane.edge[1]

    def view(self, *, node: str | None = None, free: bool = True, free_in: float | None = None) -> RobotView:
        """What policies see of it: by default as a robot that is free where it is."""
        spec = self.battery.spec
        fleet, tasks = self.world.model.fleet, self.world.model.tasks
        if free_in is None:
            free_in = fleet.exit_time if self.docked is None and self.lane is None else tasks.clear_time
        return RobotView(
            self.number,
            self.node if node is None else node,
            self.home,
            self.battery.level(self.env.now),
            self.battery.capacity,
            0.0 if spec is None else spec.threshold,
            self.last_bay,
            self.speed,
            free,
            free_in,
            tuple(self.world.dispatcher.queues.get(self.number, ())),
        )

    def detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Another way for a robot that is held up before `route[index]`, if the routing policy knows one."""
        way = self.world.decisions.detour(self, route, index, stop)
        if way is not None:
            self.detours -= 1
        return way

    @property
    def at_charger(self) -> bool:
        """Whether it stands in a bay with chargers."""
        return self.lane is None and self.bay is not None and self.bay.chargers is not None

    # What the battery draws

    def draw(self, state: str) -> None:
        """From now on the battery draws what the state needs; beside a charger a robot at rest draws nothing."""
        resting = state in ("idle", "queueing", "charging") and self.at_charger
        self.battery.draw(self.env.now, 0.0 if resting or state == "charging" else self.battery.rates[state])
        self.watch()

    def stands(self, waiting: bool) -> None:
        """It begins or ends waiting in traffic: the battery is told where standing draws less than driving."""
        if self.battery.varies:
            self.draw("waiting" if waiting else self.state)
        elif self.looks_ahead:
            self.watch()

    # When it runs low

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
        self.recall_at = self._recall()
        if self.recall_at < self.alarm:
            self.alarm = self.recall_at
            Timeout(self.env, self.alarm - now).callbacks.append(self._low)

    def _recall(self) -> float:
        """When the task must be given back: at the critical level, or when it can no longer be finished in safety.

        What the task still needs falls as fast as the energy while the robot drives, so only waiting eats up
        what it has to spare.
        """
        now, battery = self.env.now, self.battery
        levels = self.world.decisions.levels(self.view())
        recall_at = battery.lasts_until(now, levels.critical)
        self.looks_ahead = levels.margin is not None
        if levels.margin is not None and self.is_waiting:
            assert self.job is not None
            if not self.at_edge_of(self.job):
                need = self.world.shown.energy.need_now(self, levels.charger)
                recall_at = min(recall_at, battery.lasts_until(now, need + levels.margin))
        return recall_at

    def _flat(self, _: Event) -> None:
        self.flat_alarm = math.inf
        spec = self.battery.spec
        if spec is None or self.battery.level(self.env.now) > 1e-9 * spec.capacity - spec.reserve:
            self.watch()
            return
        charging = self.world.model.policies.charging.name
        raise BatteryError(
            f"robot {self.number} ran flat at time {self.env.now:g}, {self.place(self.env.now)}, {self.state}: "
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

    # In a bay

    def rest_uneasily(self, offer: Event) -> Generator[Event, object, bool]:
        """Rest where chargers are scarce or elsewhere; False when it must leave for a charger or make room at one."""
        env, parking = self.env, self.world.parking
        while not offer.triggered:
            assert self.bay is not None
            if self.bay.chargers is not None:
                yield offer | self._end_of_instant()
                if not offer.triggered and parking.wanted_from(self):
                    self.make_room()
                    return False
                if not offer.triggered:
                    yield offer | parking.sought_after(env)
                continue
            view = self.view()
            level = self.world.shown.energy.rests_until(view, self.world.decisions.levels(view))
            low = self.battery.lasts_until(env.now, level)
            if low > env.now + EPS and not self.short:
                yield offer | Timeout(env, min(low - env.now, FAR))
            elif parking.charger_for(self):
                self.short = True
                self.world.dispatcher.withdraw(self)
                return False
            else:
                parking.seekers += 1
                yield offer | parking.seek(env)
                parking.seekers -= 1
        return self.job is not None

    def make_room(self) -> None:
        """Leave the place at a charger to a robot that seeks one."""
        self.world.dispatcher.withdraw(self)
        self.world.parking.making_room.add(self.number)

    def _end_of_instant(self) -> Event:
        """Due when the tasks of this instant have been given out."""
        event = Event(self.env)
        event._ok, event._value = True, None
        self.env.schedule(event, priority=LAST)
        return event

    def charge_at(self, bay: Bay, offer: Event | None) -> Generator[Event, object, Event | None]:
        """Charge, up to `sufficient` whatever comes, from there to `full` only until there is a task.

        `offer` is the event of a robot that is free already. Returns the event of a robot that is free now.
        """
        env, battery = self.env, self.battery
        assert bay.chargers is not None
        levels = self.world.decisions.levels(self.view())
        self.plugged, self.short = True, False
        with bay.chargers.request() as turn:
            if not turn.triggered and offer is None:
                self.enter("queueing")
            yield turn if offer is None else turn | offer
            self.plugged = self.job is None
            if self.job is not None:
                return offer
            self.enter("charging")
            begun = env.now
            if levels.swap_time is not None:
                yield Timeout(env, levels.swap_time)
                battery.unplug(env.now, levels.full)
            else:
                offer = yield from self._fill(levels, offer)
            self.charged = self.charged or env.now > begun
        self.plugged = False
        return offer

    def _fill(self, levels: Levels, offer: Event | None) -> Generator[Event, object, Event | None]:
        env, battery, dispatcher, parking = self.env, self.battery, self.world.dispatcher, self.world.parking
        level = battery.level(env.now)
        battery.plug(env.now)
        if offer is None:
            yield Timeout(env, battery.charge_time(level, levels.sufficient))
            level = max(level, levels.sufficient)
            if level < levels.full:
                offer = dispatcher.wait(self)
        while offer is not None and level < levels.full and self.job is None:
            goal = self.world.shown.energy.enough_for_first(self, levels)
            goal = goal if level < goal < levels.full else levels.full
            done = Timeout(env, battery.charge_time(level, goal))
            yield offer | done | parking.sought_after(env) if self.world.scarce else offer | done
            level = goal if done.processed else battery.level(env.now)
            able = level >= self.world.shown.energy.enough_for_first(self, levels)
            if self.job is None and able and parking.wanted_from(self):
                self.make_room()
                offer = None
            elif done.processed:
                dispatcher.call()
        battery.unplug(env.now, level)
        return offer

    @abstractmethod
    def enter(self, state: str) -> None:
        """Begin something else."""


LAST = EventPriority(3)
"""Priority of what comes after the decisions of an instant."""
FAR = 1e15
"""A time that does not come."""
