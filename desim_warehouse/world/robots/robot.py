"""A robot's life: wait for a good, fetch it, deliver it, go home, charge. Read this first.

Each robot is a SimPy process. Decisions are left to policies: the task, the route, and when and where to charge.
Movement along the lanes is left to traffic, by means of the robot's `body`.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from enum import Enum

from simpy.events import Event, Timeout

from desim_warehouse.model.facts.charging import rates
from desim_warehouse.model.sections.fleet import RobotSpec, Start
from desim_warehouse.policies import RobotView, Task
from desim_warehouse.states import (
    AT_START,
    BROKEN,
    CHARGED,
    CHARGER,
    OPERATING,
    RESTING,
    SERVED,
    STATES,
    WAITING,
    Phase,
)
from desim_warehouse.world.places.bays import Bay
from desim_warehouse.world.places.station import Station
from desim_warehouse.world.places.stops import Stop
from desim_warehouse.world.robots.battery import Alarms, Battery
from desim_warehouse.world.robots.breakdowns import Breakdowns
from desim_warehouse.world.robots.charging import ChargingStop
from desim_warehouse.world.robots.closings import Closings
from desim_warehouse.world.robots.dwelling import Dwelling
from desim_warehouse.world.robots.forecast import time_to_node
from desim_warehouse.world.robots.itinerary import Itinerary, Place
from desim_warehouse.world.robots.surroundings import Surroundings
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.drive import Drive
from desim_warehouse.world.traffic.events import AFTER_DECISIONS, Arrival, Steps, end_of_instant
from desim_warehouse.world.traffic.lane import Lane
from desim_warehouse.world.traffic.motion import Motion, NodeDelays
from desim_warehouse.world.traffic.rules import EPS

FAR = 1e15
"""A time that never comes. It is not scheduled, as waiting for it would keep a stalled run going."""


class Rest(Enum):
    """The ways in which a rest in a bay ends."""

    TASK = "it was given a task"
    CHARGE_HERE = "it charges, where it stands"
    SEEK_CHARGER = "it must charge, and leaves for a charger elsewhere"
    MAKE_ROOM = "it leaves its slot at a charger to a robot that must charge"
    REST_ON = "it must charge, but the charger that was free is taken again"


class Robot:
    """A robot with a home, a battery and at most one task or tour in hand (`job`), which its `tour` carries out.

    `bay` is the one where the robot stands or has a slot reserved, `leaving` the one where it stands while its slot is
    elsewhere, `docked` the station that it is in. `doing` is its state, or its state before the breakdown.
    """

    # The parts of a robot, in order of their dependencies.
    def __init__(
        self,
        around: Surroundings,
        number: int,
        home: str,
        shape: RobotSpec,
        kind: str,
        motion: Motion | None,
        node: str,
    ) -> None:
        self.env = env = around.env
        self.log = around.log
        self.fleet = around.model.fleet
        self.clear_time = around.handling.times.clear_time
        self.waits_apart = around.model.waits_apart
        self.meets_people = bool(around.model.people)
        self.traffic = around.traffic
        self.bays = bays = around.bays
        self.bay_choice = around.bay_choice
        self.reach = reach = around.reaches[kind]
        self.departures = around.departures
        self.dispatcher = dispatcher = around.dispatcher
        self.number = number
        self.kind = kind
        self.speed, self.loaded_speed = shape.speed, shape.loaded_speed
        self.loads = shape.capacity
        self.carries = shape.carries
        self.home = home
        self.parked_at = self.last_bay = node
        delays = None if shape.delays is None else NodeDelays(shape.delays, number, around.streams)
        self.body = Body(number, shape.speed, around.traffic.nodes[node], self, motion, delays)
        if shape.keeps == "braking":
            self.body.keep_braking_distance(self.env)
        self.itinerary = Itinerary(
            self.body,
            lanes=around.traffic.lanes,
            routes=around.routes,
            free=reach.travel(shape.speed).ways,
            guard=around.traffic.rules.guard,
        )
        battery = reach.battery
        self.battery = Battery(battery, rates(battery))
        self.breakdowns: Breakdowns | None = None
        if shape.breakdowns is not None:
            self.breakdowns = Breakdowns(shape.breakdowns, number, around.streams)
            self.body.break_down_at(self.breakdowns.least_until_due(0.0))
        self.alarms = Alarms(env, self, reach, dispatcher.give_back)
        self.bay: Bay | None = None
        self.leaving: Bay | None = None
        self.docked: Station | None = None
        self.job: Task | None = None
        cut_off = reach.openings.cut_off
        self.closings = Closings(env, self, cut_off, dispatcher.take_back) if cut_off.closures else None
        self.tour = around.tours(
            self,
            env,
            dispatcher=dispatcher,
            stations=around.stations,
            handling=around.handling,
            departures=around.departures,
            closings=self.closings,
            pods=around.pods,
            pickers=around.pickers,
        )
        self.charging = ChargingStop(self, env, dispatcher=dispatcher, reach=reach, bays=bays)
        self.dwelling = Dwelling(
            self,
            env,
            is_allowed=around.bay_choice.lets_dwell,
            dispatcher=dispatcher,
            departures=around.departures,
            bays=bays,
            reach=reach,
            traffic=around.traffic,
        )
        self.ways_round = around.ways_round
        self.driving: Drive | None = None
        self.offer: Event | None = None
        self.charges_first = False
        self.recharged = self.delivered = 0
        self.state = self.doing = AT_START
        self.since_state = 0.0
        self.waited_before = 0.0
        self.time_in = dict.fromkeys(around.states, 0.0)

    def stand(self, start: Start) -> None:
        """Put the robot onto the lanes at the start of a run. It keeps a slot in its bay, or may have one again."""
        self.traffic.stand(self.body, start)
        if start.edge is None:
            self.parked_at = start.node
        self.bays.leave(self)
        self.departures.under_way.add(self.number)

    # The life of a robot

    def life(self) -> Steps:
        """Run the robot's whole life: work as long as there is any, and rest and charge in a bay in between."""
        exit_time = self.fleet.first_exit_time
        if self.body.is_on_lanes:
            yield from self.begin_on_lanes()
            exit_time = self.fleet.exit_time
        elif self.charges_first:
            self.offer = yield from self.charging.charge(again=self.fleet.start_energy == "settled")
        while True:
            end = yield from self.rest()
            if end is Rest.REST_ON:
                continue
            if end is Rest.CHARGE_HERE:
                self.offer = yield from self.charging.charge(again=True)
                continue
            if end is Rest.TASK:
                yield from self.go_out(exit_time)
                yield from self.work()
                self.reserve_bay()
            else:
                self.reserve_bay(away=end is Rest.MAKE_ROOM)
                yield from self.go_out(exit_time)
            exit_time = self.fleet.exit_time
            yield from self.go_to_bay()
            self.offer = yield from self.charging.charge()

    def begin_on_lanes(self) -> Steps:
        """Begin the run on the lanes: drive to the first good, or to a bay, from where it stands."""
        yield self.dispatcher.ask(self)
        self.enter("empty" if self.job is not None else "returning")
        yield from self.work()
        self.reserve_bay()
        yield from self.go_to_bay()
        self.offer = yield from self.charging.charge()

    def work(self) -> Steps:
        """Do task after task, or tour after tour, until there is none or the battery calls the robot back."""
        while self.job is not None and (yield from self.tour.begin()):
            yield from self.tour.finish()
            yield from self.ask_for_more()

    def ask_for_more(self) -> Steps:
        """Ask for the next task, which is given before the robot leaves the slot or node where it unloaded."""
        decided = self.dispatcher.ask(self)
        if self.dispatcher.decides_later:
            self.enter("awaiting")
        yield decided
        self.set_out()
        yield Timeout(self.env, self.clear_time)
        if self.job is None and self.dwelling.may_begin:
            if self.state != self.at_rest:  # the place became free while it cleared it
                self.enter(self.at_rest)
            yield from self.dwelling.rest()
            if self.job is not None:
                self.set_out()

    def set_out(self) -> None:
        """Set out for its task, or without a task for a bay, unless the robot may rest where it is."""
        if self.job is None:
            rests = not self.clear_time and self.dwelling.may_begin
            self.enter(self.at_rest if rests else "returning")
            return
        self.enter("empty")
        if self.bay is not None:  # its slot is kept
            self.free_charger()

    # Parking

    def reserve_bay(self, *, away: bool = False) -> None:
        """Reserve a slot for the robot to go to before it sets out; with `away` a slot without a charger."""
        charging, is_out = self.charging, self.is_out
        self.body.recall_from(math.inf)
        if is_out:
            self.enter("returning")
        view = self.view()
        if is_out and self.battery.spec is not None and not charging.must_charge and self.reach.must_charge(view):
            charging.require()
        if away:
            bay = self.bay_choice.parking(view, self.bays.away_from(self))
        else:
            may_go = self.bays.may_take if is_out else self.bays.may_go
            bays = [bay for bay in self.bays.by_node.values() if may_go(self, bay)]
            bay = self.bay_choice.choose(view, bays, must_charge=charging.must_charge)
        if is_out or self.bays.may_take(self, bay):
            self._take_slot(bay)
        else:
            self.bays.promise(self, bay)

    def _take_slot(self, bay: Bay) -> None:
        """Reserve a slot in a bay, unless the declared route ends in another and cannot be changed safely."""
        elsewhere = self.bay is not None and bay is not self.bay
        if self.body.is_on_lanes and elsewhere and not self.itinerary.go(self.node, bay.node):
            return  # from the bay where its route ends it can go on
        self.bays.take(self, bay)

    def free_charger(self) -> None:
        """Release a slot at a charger that another robot needs, in exchange for a slot elsewhere, while at work.

        This applies only if robots that are out keep their slots: one that never rests would hold a charger for ever.
        """
        if self.bays.wants_room(self):
            self._take_slot(self.bay_choice.parking(self.view(), self.bays.away_from(self)))

    def go_to_bay(self) -> Steps:
        """Drive home, or to the bay that the policies choose."""
        goal = self.bays.goal_of(self)
        if self.is_out or goal.node != self.parked_at:
            yield from self.drive(self.itinerary.leg(self.node, goal.node))
            assert self.bay is not None
            if self.bay is not goal:  # another robot has taken the slot that it set out for
                yield from self.drive(self.itinerary.leg(self.node, self.bay.node))
            self.enter_bay(self.bay.node)
        assert self.bay is not None
        self.last_bay = self.bay.node
        self.record("parked")
        self.dispatcher.came_home(self)

    def go_out(self, exit_time: float) -> Steps:
        """Drive out of the bay, and stand at its node."""
        if self.charging.has_charged and self.job is not None:
            self.record("recharged")
            self.charging.has_charged = False
            self.recharged += 1
        self.departures.under_way.add(self.number)
        if self.job is None:
            self.departures.changing_bay.add(self.number)
        self.enter("empty" if self.job is not None else "returning")
        yield Timeout(self.env, exit_time)

    def start_with(self, energy: float, *, at_charger: bool) -> None:
        """Begin the run with so much energy; in a settled fleet the robot charges where it did in the settling run."""
        self.battery.start(energy)
        self.charges_first = at_charger or (self.fleet.start_energy != "settled" and not self.battery.is_full(0.0))

    # Resting

    def rest(self) -> Generator[Event, object, Rest]:
        """Rest in a bay until the robot is given a task, or must leave or charge for the sake of a battery."""
        self.enter(self.at_rest)
        if self.number in self.bays.making_room:  # decided while it charged
            return Rest.MAKE_ROOM
        offer = self.offer or self.dispatcher.wait(self)
        self.offer = None
        if self.battery.spec is None or (self.rests_at_own_charger and not self.reach.scarce):
            if self.job is None:
                yield offer
        elif self.at_charger:
            yield from self._rest_at_shared_chargers(offer)
        else:
            yield from self._rest_without_charger(offer)
        if self.job is not None:
            return Rest.TASK
        if self.at_charger:
            makes_no_room = self.charging.must_charge or self.number not in self.bays.making_room
            return Rest.CHARGE_HERE if makes_no_room else Rest.MAKE_ROOM
        if self.number in self.bays.making_room:
            return Rest.MAKE_ROOM
        return Rest.SEEK_CHARGER if self.bays.charger_for(self) else Rest.REST_ON

    def _rest_at_shared_chargers(self, offer: Event) -> Steps:
        """Rest until there is a task, the battery is so low that it charges again, or another robot seeks the slot.

        Such a robot must charge and finds no slot but this.
        """
        env, bays = self.env, self.bays
        while not offer.triggered:
            if self.reach.scarce:
                yield offer | end_of_instant(env, AFTER_DECISIONS)  # robots that seek a charger now are known then
                if not offer.triggered and bays.wants_room(self):
                    self.make_room()
                    return
            low = self.battery.lasts_until(env.now, self.charging.begins_again_at())
            if not offer.triggered and low <= env.now + EPS:
                self.dispatcher.withdraw(self)
                return
            if not offer.triggered:
                due = offer | (Timeout(env, low - env.now) if low < FAR else Event(env))
                yield due | bays.charger_sought() if self.reach.scarce else due

    def _rest_without_charger(self, offer: Event) -> Steps:
        """Rest until there is a task, or the battery is so low that the robot must go to a charger and one is free.

        Where there are chargers for other kinds the robot makes room for robots that must charge.
        """
        bays, charging = self.bays, self.charging
        assert self.bay is not None
        among_others = bool(self.bay.charges)
        while not offer.triggered:
            if among_others and bays.wants_room(self):
                self.make_room()
                return
            view = self.view()
            level = self.reach.rests_until(view, self.reach.levels(view))
            low = self.battery.lasts_until(self.env.now, level)
            if low > self.env.now + EPS and not charging.must_charge:
                due = offer | (Timeout(self.env, low - self.env.now) if low < FAR else Event(self.env))
                yield due | bays.charger_sought() if among_others else due
            elif bays.charger_for(self):
                charging.require()
                self.dispatcher.withdraw(self)
                return
            else:
                self.enter("too_low")
                bays.seekers.append(self)
                left = bays.seek_charger()
                while not (offer.triggered or left.triggered or (among_others and bays.wants_room(self))):
                    yield offer | left | bays.charger_sought() if among_others else offer | left
                bays.seekers.remove(self)

    def lack_charge(self) -> None:
        """Rest with too little energy for the open work, while no charger is free."""
        if self.is_out:
            self.dwelling.end()  # in a bay it seeks a charger
        elif self.phase is Phase.REST and self.departures.duty.has(self.number):
            self.enter("too_low")

    def have_charge(self) -> None:
        """Rest with enough energy for the open work, or without work; if need be, continue to seek a charger."""
        if STATES[self.state].queue == CHARGER and self not in self.bays.seekers:
            self.enter(self.at_rest)

    def make_room(self) -> None:
        """Leave the robot's slot to another that needs the chargers there."""
        self.dispatcher.withdraw(self)
        assert self.bay is not None
        self.bays.making_room[self.number] = self.bay

    # Position and state

    @property
    def node(self) -> str:
        """The node that the robot is at, or comes to next."""
        lane = self.body.lane
        return self.parked_at if lane is None else lane.edge[1]

    @property
    def is_out(self) -> bool:
        """Whether the robot is in no bay: on a lane, in a station, on the node beside its bay, or cleared away."""
        return self.body.is_on_lanes or self.body.cleared or self.docked is not None

    @property
    def waits_to_come_out(self) -> bool:
        """Whether the robot waits beside the lanes, in a bay or station, to be let out."""
        return self.body.claim is not None and not self.body.is_on_lanes

    @property
    def phase(self) -> Phase | None:
        """The part of its round that the robot is in."""
        return STATES[self.state].phase

    @property
    def at_rest(self) -> str:
        """The state of the robot in a bay with nothing to do: outside its hours it is on a break."""
        return "idle" if self.departures.duty.has(self.number) else "on_break"

    def hours_change(self) -> None:
        """Note that the robot's hours begin or end: if it rests, its resting state changes."""
        if self.is_out:
            self.dwelling.end()
        elif self.phase is Phase.REST:
            self.enter(self.at_rest)

    def charge_left(self) -> float:
        """Return the share of the battery's capacity that is left."""
        return self.battery.level(self.env.now) / self.battery.capacity

    def need_of_charger(self) -> tuple[float, float]:
        """Return when the robot will need a charger more than a robot at one, and the required lead of the other.

        The lead is a share of the robot's capacity.
        """
        view = self.view()
        level, ahead = self.reach.in_need(view, self.reach.levels(view))
        return self.battery.lasts_until(self.env.now, level), ahead / self.battery.capacity

    def comes_in(self, node: str) -> float:
        """Return the time in which the robot drives from the bay that it rests in to the bay at a node, freely."""
        return self.reach.out_to(self.view(), node)

    @property
    def at_charger(self) -> bool:
        """Whether the robot stands in a bay with chargers for its kind."""
        return self.bay is not None and self.kind in self.bay.charges and not self.is_out

    @property
    def rests_at_own_charger(self) -> bool:
        """Whether the robot is in a bay with a charger for each slot: elsewhere robots take turns at chargers."""
        return self.at_charger and self.bay is not None and self.bay.charges_every_slot

    @property
    def is_at_good_edge(self) -> bool:
        """Whether the robot is on the edge of its task's good, or stands at the node where that edge begins.

        On a two-way lane it counts, too, if it drives past the good first, as in a dead end that is faster in than out.
        For a good at a node: whether the robot stands there, or comes there next.
        """
        body, job = self.body, self.job
        assert job is not None
        edge = self.itinerary.edge_of(job)
        if edge[0] == edge[1]:
            return self.node == edge[0]
        past = edge[::-1]
        if body.lane is not None and body.lane.edge in {edge, past}:
            return True
        standing = body.lane is None or (body.held is not None and body.pos >= body.lane.length)
        if not standing or self.node == edge[0]:
            return standing
        rest = () if self.driving is None else self.driving.rest
        return bool(rest) and rest[0].edge == past

    def view(self, *, node: str | None = None, free: bool = True, free_in: float | None = None) -> RobotView:
        """Return the robot as policies see it, by default free at its present place."""
        spec = self.battery.spec
        if free_in is None and self.phase is Phase.REST and self.is_out:  # at the start, or where it unloaded
            free_in = time_to_node(self, self.env.now)
        elif free_in is None:
            free_in = self.fleet.exit_time if self.docked is None and self.body.lane is None else self.clear_time
            if self.job is None and self.body.lane is not None and self.body.held is None:  # it unloaded on an edge
                free_in += time_to_node(self, self.env.now)
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
            self.dispatcher.queue_of(self.number),
            self.kind,
            self.loads,
            self.carries,
        )

    # Work

    def take_up(self, task: Task, stops: list[Stop], slots: list[Station]) -> None:
        """Take up a task or tour, with a slot in every station where it stops."""
        self.job = task
        self.tour.stops, self.tour.slots = stops, slots
        self.charging.waive()

    def lay_down(self) -> None:
        """Drop the task or tour in hand, which is done or given back."""
        self.job = self.itinerary.place = None
        self.tour.stops, self.tour.slots = [], []
        if self.tour.pickers is not None:
            self.tour.pickers.forget(self.number)
        self.body.work_on(-1)

    def record_delivery(self, stop: Stop) -> None:
        """Record that the robot has unloaded a task."""
        place = self.itinerary.place
        at_node = None if stop.task.drop is None else stop.edge
        self.record("delivered", at_node if place is None else place[0].edge)
        self.delivered += 1

    def count_delivery(self) -> None:
        """Count a line that has been picked from the pod that the robot brought."""
        self.delivered += 1

    # Driving

    def drive(self, route: Sequence[Lane], place: Place | None = None) -> Drive:
        """Drive a route to a stop on its last lane (`yield from`), and return False if it is recalled on the way."""
        self.body.allow_detours(self.itinerary.routes.detours)
        self.driving = drive = self.traffic.drive(self.body, route, None if place is None else place[1])
        if self.ways_round is not None:
            self.ways_round.watch(self)
        return drive

    def enter_bay(self, node: str) -> None:
        """Drive from the node under the robot into the bay or station beside it."""
        self.traffic.into_bay(self.body)
        self.parked_at = node

    def dock(self, station: Station) -> None:
        """Drive from the node under the robot into the station beside it."""
        self.enter_bay(station.node)
        self.docked = station

    # States

    def enter(self, state: str) -> None:
        """Change the robot's state: attribute the time so far to the old state, and draw energy at the new rate."""
        now = self.env.now
        waited = self.body.waited_by(now)
        self.time_in[self.state] += now - self.since_state - (waited - self.waited_before)
        if self.docked is not None:
            self.docked.busy += self.served_for(now)
        self.waited_before = waited
        self.since_state = now
        if state != self.state:
            self.state = state
            if state not in BROKEN:
                self.doing = state
            self.record(state)
        self._draw(state)

    def served_for(self, now: float) -> float:
        """Return how long the robot has kept a server of its station busy in its present state."""
        return now - self.since_state if self.state in SERVED else 0.0

    def _draw(self, state: str) -> None:
        """Draw energy for the present state from now on, or none while the robot is connected to a charger.

        It is connected when it is charged, or at rest in a bay with a charger for each slot.
        """
        is_connected = state in CHARGED or (state in RESTING and self.rests_at_own_charger)
        self.battery.draw(self.env.now, 0.0 if is_connected else self.battery.rates[state])
        self.alarms.watch()

    def record(self, kind: str, edge: tuple[str, str] | None = None) -> None:
        """Write a row of the log with the robot's state and energy."""
        self.log.event(self.env.now, kind, self.number, self.body.task, self.node, self.energy, edge=edge)

    @property
    def energy(self) -> float | None:
        """The energy that the robot's battery holds now; None without a battery."""
        return None if self.battery.spec is None else self.battery.level(self.env.now)

    def tally(self, now: float) -> dict[str, float]:
        """Return the robot's counts and times so far. Times in all states and `waiting` add up to `now`."""
        body = self.body
        waited = body.waited_by(now)
        worked = now - self.since_state - (waited - self.waited_before)
        waits = self.waits_apart
        apart: dict[str, float] = {wait: body.waited_for(wait, now) for wait in waits}
        return {
            **self.time_in,
            self.state: self.time_in[self.state] + worked,
            "waiting": waited - math.fsum(apart.values()) if apart else waited,
            **apart,
            "distance": body.distance(now),
            "energy": self.battery.drawn(now),
            "moves": body.moves_by(now),
            "rear_ends": body.rear_ends_by(now),
            "crossings": body.crossings,
            "delivered": self.delivered,
            "recharged": self.recharged,
            **({"encounters": body.encounters} if self.meets_people else {}),
            **({"breakdowns": self.breakdowns.count if self.breakdowns else 0} if self.fleet.breaks_down else {}),
        }

    # As the driver of its body

    def left_bay(self) -> None:
        """Free the robot's slot in the bay or station it has left; or come back on the lanes after a repair."""
        if self.body.cleared:
            self.body.come_back()
        elif self.docked is not None:
            self.tour.leaves(self.docked)
            self.docked = None
            self.dispatcher.call()
        else:
            goal = self.bays.leave(self)
            if goal is not None and goal.free:
                self.bays.take(self, goal)
            elif goal is not None:
                self.reserve_bay()
            if self.reach.scarce:
                self.dispatcher.call()
        if self.closings is not None:
            self.closings.look()

    def take_detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Return another route if the robot is held up before `route[index]` and the routing policy knows one."""
        other = self.itinerary.detour(self.node, route, index, stop)
        if other is not None:
            self.body.count_detour()
        return other

    @property
    def is_under_way(self) -> bool:
        """Whether a part of the robot's route is still to come."""
        return self.driving is not None and bool(self.driving.rest)

    def look_for_way_round(self) -> None:
        """Take another route if that is quicker than waiting, after something has closed or opened."""
        body, drive, itinerary = self.body, self.driving, self.itinerary
        in_bay = body.lane is None and body.held is None
        if drive is None or not body.detours or not drive.may_go_round or (in_bay and itinerary.is_declared):
            return
        if drive.rest[0].edge[0] != self.node:  # at this instant it is let in onto a short lane
            return
        other = itinerary.way_past(self.node, drive.rest, drive.stop)
        if other is not None:
            body.count_detour()
            drive.go_round(other)

    def halt(self, drive: Drive) -> Steps:
        """Stand broken down until the robot is repaired, or cleared off the lanes and repaired. Never in a bay.

        Afterwards the robot resumes what it was `doing`.
        """
        breakdowns = self.breakdowns
        assert breakdowns is not None
        while self.is_out and breakdowns.is_due(self.operated()):
            yield Arrival(self.env, self.body.brake_to_stand(self.env.now))
            repair, clear = breakdowns.begin()
            self.enter("broken")
            self.body.break_down()
            if self.body.is_on_lanes:
                self.itinerary.routes.block(self.body, breakdowns.mean_left)
                self._lanes_change()
            if clear < repair and self.body.is_on_lanes and drive.may_be_cleared:
                yield Timeout(self.env, clear)
                self._clear(drive)
                repair -= clear
            yield Timeout(self.env, repair)
            self.body.be_repaired()
            self.itinerary.routes.unblock(self.body)
            self._lanes_change()
            self.enter(self.doing)
        self.body.break_down_at(self.env.now + breakdowns.least_until_due(self.operated()))

    def _clear(self, drive: Drive) -> None:
        """Take the robot off the lanes: it returns at the node ahead, or before the lane on which it must stop."""
        again = drive.clear()
        self.parked_at = self.node if again is None else again.edge[0]
        self.traffic.clear(self.body, self.parked_at)
        self.itinerary.resume(() if self.body.is_turned_off else drive.rest)
        self.itinerary.routes.unblock(self.body)
        self._lanes_change()
        self.record("cleared")

    def _lanes_change(self) -> None:
        """Hold back tasks behind lanes that the robot blocks, or release them, if robots detour."""
        if self.itinerary.routes.goes_round:
            self.reach.openings.look_again()
            self.dispatcher.call()

    def operated(self) -> float:
        """Return the time in operation so far: driving and handling, without waits."""
        now = self.env.now
        waited = self.body.waited_by(now) - self.waited_before
        present = now - self.since_state - waited if self.state in OPERATING else 0.0
        return math.fsum(time for state, time in self.time_in.items() if state in OPERATING) + present

    def stood_aside(self) -> None:
        """Declare, where lanes are two-way, the robot's route from beside its lane."""
        self.itinerary.stand_aside()

    def give_way(self) -> None:
        """Drive on to a bay, if the robot rests on the lanes, because others wait for it."""
        self.dwelling.end()

    def notice_wait(self, waiting: bool) -> None:
        """Note that the robot begins or ends a wait in traffic, where standing may draw less than driving."""
        if self.battery.varies:
            self._draw(WAITING.name if waiting else self.state)
        elif self.alarms.looks_ahead:
            self.alarms.watch()

    def notice_delay(self, begin: float, end: float) -> None:
        """Note a wait known in advance, where standing may draw less than driving."""
        if self.battery.varies:
            Arrival(self.env, begin).callbacks.append(lambda _: self._draw("waiting"))
            Arrival(self.env, end).callbacks.append(lambda _: self._draw(self.state))
