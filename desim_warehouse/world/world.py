"""The World: all parts of one run, built from a model and a seed."""

from __future__ import annotations

import math
from collections import Counter, OrderedDict, defaultdict
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from simpy import Event
from simpy.core import StopSimulation
from simpy.events import URGENT, Timeout

from desim_warehouse.errors import BatteryError, CheckError, StallError, first_of, spoken
from desim_warehouse.feasibility import refuse
from desim_warehouse.layout import Layout
from desim_warehouse.layout.aisles import wide_edges
from desim_warehouse.layout.zones import TrafficZone, edges_inside, zones_on
from desim_warehouse.model import Model
from desim_warehouse.model.facts.ahead import free_travel, handling_of
from desim_warehouse.model.facts.charging import (
    by_kind,
    charge_alike,
    settling_levels,
    spare_batteries,
    start_levels,
    swapped_at,
)
from desim_warehouse.model.facts.places import specs
from desim_warehouse.model.sections.flows import StorageEnd
from desim_warehouse.model.sections.policy import PolicySpec
from desim_warehouse.outcome.log import Log
from desim_warehouse.policies import Task, create
from desim_warehouse.states import AT_START, OPENING, STATES, absent
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.encounters import count_encounters, record_closures, record_visits
from desim_warehouse.world.orders.batches import Batcher
from desim_warehouse.world.orders.demand import Demand, Orders
from desim_warehouse.world.orders.dispatch import Dispatcher
from desim_warehouse.world.orders.flows import Flows
from desim_warehouse.world.orders.pods import PodPolicies, Pods, Shelves
from desim_warehouse.world.orders.situations import Situations
from desim_warehouse.world.places.bays import Bay, Bays
from desim_warehouse.world.places.chargers import Chargers, FailingChargers, Spares
from desim_warehouse.world.places.cut_off import CutOff
from desim_warehouse.world.places.handling import HandlingTimes
from desim_warehouse.world.places.pickers import Pickers
from desim_warehouse.world.places.stations import stations_of
from desim_warehouse.world.robots.aside import TourAside
from desim_warehouse.world.robots.bay_choice import BayChoice
from desim_warehouse.world.robots.closings import WaysRound
from desim_warehouse.world.robots.duty import Departures, duty_of
from desim_warehouse.world.robots.levels import ChargingLevels
from desim_warehouse.world.robots.mixed_reach import MixedReach
from desim_warehouse.world.robots.reach import Reach, may_do
from desim_warehouse.world.robots.robot import Robot
from desim_warehouse.world.robots.settled import (
    OF_THIS_PROCESS,
    SEED,
    Fleet,
    SettledError,
    SettledFleets,
    SettlingRun,
    Standing,
    any_of,
    has_long_run,
    nodes_at_start,
)
from desim_warehouse.world.robots.surroundings import Surroundings
from desim_warehouse.world.robots.tallies import Rows, less, tallies
from desim_warehouse.world.robots.tour import Tour
from desim_warehouse.world.traffic.closures import Restrictions, hours_closed
from desim_warehouse.world.traffic.events import Clock, happened
from desim_warehouse.world.traffic.gridlock import Rule
from desim_warehouse.world.traffic.lift_users import LiftUsers
from desim_warehouse.world.traffic.motion import Motion
from desim_warehouse.world.traffic.people import PeopleSource, sources
from desim_warehouse.world.traffic.routes import Routes
from desim_warehouse.world.traffic.traffic import Traffic

PATIENCE = 300.0
"""Seconds that a robot may wait on two-way lanes before others stay in their bays for it. Otherwise they might set out
into its way for ever.
"""


FEW = 10
"""The most open tasks per robot in the settling run."""


class World:
    """One run: `World(model, seed).run()`; its results are in `log`, `robots` and `traffic`.

    With `ask` the run stops at every allocation decision: `begin()`, then `go_on()` until it returns False, and
    `dispatcher.decide(pairs)` in between.

    `heed` is called with the clock of every run that this one needs, before it begins. `settles`: this is the uncounted
    run in which batteries settle. `demand` replaces the orders of the model, which must have been checked with it.
    `fleets`: the cache of settled fleets.

    Each part is given its dependencies, and none knows the world.
    """

    def __init__(
        self,
        model: Model,
        seed: int = 0,
        *,
        ask: bool = False,
        demand: Callable[..., Orders] | None = None,
        heed: Callable[[Clock], object] | None = None,
        settles: bool = False,
        fleets: SettledFleets = OF_THIS_PROCESS,
    ) -> None:
        self.model = model
        self.layout = model.floor
        self.settles = settles
        if demand is None:
            refuse(model, self.layout)
        self.streams = Streams(seed)
        start = _settled(model, self.streams, fleets, heed) if demand is None and not settles else None
        self.env = Clock()
        if heed is not None:
            heed(self.env)
        self._before: tuple[Rows, Rows, Rows, Rows] | None = None
        zones = zones_on(self.layout, model.traffic.zones)
        # People before the log and the lanes: their aisles close, and the log must say who is in one when they come.
        self.people = self._people(zones)
        self.log = Log(model.log, knows_moves=bool(self.people))
        # Lanes before routes and robots, which use them, and before bays: on guarded lanes slots are kept.
        restrictions = Restrictions.of(model, self.layout, self.people)
        self.traffic = _traffic(self.env, model, self.layout, self.log, zones, restrictions)
        if self.layout.lifts:
            self.traffic.share_lifts(self._users_of_lifts())
        self._find_ways(restrictions)
        homes = model.fleet.homes(self.layout.bays)
        self._open_places(homes)
        # The list of open tasks is shared: the dispatcher keeps it, parts that look ahead read it.
        open_tasks: OrderedDict[int, Task] = OrderedDict()
        self._look_ahead(open_tasks)
        # So is the list of robots: the dispatcher gets it while it is empty, as robots need the dispatcher.
        self.robots: list[Robot] = []
        self._take_orders(open_tasks, ask=ask, demand=demand or (Flows if model.tasks.flows else Demand))
        self._put_into_bays(homes, start)
        # Last, when every robot has a slot in its bay: a robot that starts on the lanes may leave its slot to another.
        self._stand_on_lanes()

    def _users_of_lifts(self) -> dict[str, LiftUsers]:
        """Return the people and repairs that use each lift beside robots, by the name of the lift."""
        model = self.model
        return {
            lift.name: LiftUsers(
                lift, self.streams, model.hours(lift.people.hours if lift.people else None), model.units.hour
            )
            for lift in self.layout.lifts
            if lift.people or lift.outages
        }

    def _people(self, zones: Sequence[TrafficZone]) -> Sequence[PeopleSource]:
        """Return the sources of people; visits are drawn as far as needed."""
        model, layout = self.model, self.layout
        people = sources(model, layout, edges_inside(layout, model.fleet.contact, zones)) if model.people else ()
        for source in people:
            source.start(self.streams, model.hours(source.spec.hours), model.units.hour)
        return people

    def _find_ways(self, restrictions: Restrictions) -> None:
        """Make routes and free driving times, before all parts that read them."""
        model, layout = self.model, self.layout
        routing = _policy("routing", model.policies.routing)
        self.travel = free_travel(model, layout)
        lanes, contact = self.traffic.lanes, model.fleet.contact
        break_down = model.fleet.breaks_down
        ways = self.env, routing, layout, self.travel, lanes, contact, restrictions
        self.routes = Routes(*ways, break_down=break_down)

    def _open_places(self, homes: list[str]) -> None:
        """Make stations, to which tasks go by free driving times; and bays, with a slot for each robot at home."""
        env, model, layout, streams = self.env, self.model, self.layout, self.streams
        self.handling = HandlingTimes(handling_of(model, layout), specs(model, layout), streams)
        self.stations = stations_of(env, model, layout, self.travel, self.handling, self.log, streams, self._worked)
        keep = self.traffic.rules.guard is not None
        kinds, batteries = frozenset(model.fleet.kinds_of_robots()), spare_batteries(model)
        self.bays = _bays(env, layout, homes, kinds, batteries, streams, keep=keep)

    def _look_ahead(self, open_tasks: Mapping[int, Task]) -> None:
        """Make the parts that decide which work energy and hours allow, and where robots go after work."""
        env, model, policies = self.env, self.model, self.model.policies
        handling = self.handling.times.means()
        routes = self.routes
        blocked = routes.blocked if routes.goes_round else ()
        round_it = routes.goes_round or routes.passes_closures
        cut_off = CutOff(model, self.layout, self.travel.ways, goes_round=round_it, blocked=blocked)

        def reach_of(kind: str, alone: Model) -> Reach:
            return Reach(
                env,
                alone,
                self.layout,
                self.travel,
                ChargingLevels(env, _policy("charging", alone.policies.charging)),
                kind,
                stations=self.stations,
                bays=self.bays,
                open_tasks=open_tasks.values(),
                handling=handling,
                cut_off=cut_off,
            )

        self.reaches: Mapping[str, Reach]
        self.reach: Reach | MixedReach
        if charge_alike(model):
            kinds = model.fleet.kinds_of_robots()
            self.reach = reach_of(kinds[0], model)
            self.reaches = dict.fromkeys(kinds, self.reach)
        else:
            self.reaches = {kind: reach_of(kind, alone) for kind, alone in by_kind(model).items()}
            self.reach = MixedReach(self.reaches)
        self.bay_choice = BayChoice(env, _policy("parking", policies.parking), self.travel, self.reaches)
        self.departures = Departures(model.traffic.most_out, duty_of(env, model))

    def _take_orders(self, open_tasks: OrderedDict[int, Task], *, ask: bool, demand: Callable[..., Orders]) -> None:
        """Make the source of tasks, and the dispatcher, which reports to it the tasks that robots have in hand."""
        env, model, policies = self.env, self.model, self.model.policies
        self.demand = demand(env, model, self.layout, self.streams)
        self.finished = Event(env)
        allocation = _policy("allocation", policies.allocation)  # also where it is not asked: it may be refused
        self.dispatcher = Dispatcher(
            env,
            self.log,
            policies,
            None if ask else allocation,
            open_tasks=open_tasks,
            robots=self.robots,
            stations=self.stations,
            bays=self.bays,
            departures=self.departures,
            reach=self.reach,
            situations=Situations(
                env,
                self.layout,
                self.travel,
                routes=self.routes,
                reach=self.reach,
                open_tasks=open_tasks,
                streams=self.streams,
            ),
            demand=self.demand,
            finished=self.finished,
        )
        self.pods = self._pods()
        self.batcher: Batcher | None = None
        if policies.batching.name != "single":
            batching, to_come = _policy("batching", policies.batching), self.demand.to_come
            self.batcher = Batcher(env, batching, model.fleet, self.travel, to_come=to_come, dispatcher=self.dispatcher)

    def _pods(self) -> Pods | None:
        """Make the pods between the orders and the dispatcher, whose tasks are then visits of pods."""
        model, spec = self.model, self.model.pods
        if spec is None:
            return None
        choices = PodPolicies(*(_policy(kind, model.policies.of_pods(kind)) for kind in PodPolicies._fields))
        keep = getattr(choices.storage, "keeps", False)
        pods = Pods(
            self.env,
            spec,
            Shelves(spec, self.layout.storage, self.streams, keep=keep),
            choices,
            puts={name for name, flow in model.tasks.flows.items() if isinstance(flow.target, StorageEnd)},
            travel=self.travel,
            stations=self.stations,
            handling=self.handling,
            streams=self.streams,
            dispatcher=self.dispatcher,
            log=self.log,
        )
        self.dispatcher.carry(pods)
        return pods

    def _put_into_bays(self, homes: list[str], start: Fleet | None) -> None:
        """Make the robots, each in the bay beside its home, or at a charger if it charges at the start."""
        model = self.model
        no = absent(model)
        self.pickers = self._pickers()
        around = Surroundings(
            self.env,
            model,
            self.streams,
            self.log,
            [name for name in STATES if name not in no],
            self.traffic,
            self.routes,
            self.stations,
            self.handling,
            self.bays,
            self.bay_choice,
            self.reaches,
            self.departures,
            self.dispatcher,
            WaysRound(self.env, hours_closed(model)) if self.routes.passes_closures else None,
            self.pods,
            TourAside if self.traffic.wide else Tour,
            self.pickers,
        )
        fleet = model.fleet
        if start is None:
            levels = settling_levels if self.settles else start_levels
            start = tuple(map(Standing, levels(model, self.streams)))
        on_lanes = [number for number, item in enumerate(fleet.starts(self.layout.bays)) if item.on_lanes]
        nodes = nodes_at_start(start, homes, self.bays.by_node, on_lanes)
        slow = fleet.slowness > 0  # otherwise robots accelerate and brake in no time
        shapes = zip(fleet.robots(), fleet.kinds_of_robots(), homes, nodes, start, strict=True)
        for number, (shape, kind, home, node, standing) in enumerate(shapes):
            robot = Robot(around, number, home, shape, kind, Motion(*shape.motion) if slow else None, node)
            robot.start_with(standing.energy, at_charger=standing.charges_at == node)
            self.bays.settle(robot, self.bays.by_node[node])
            self.robots.append(robot)

    def _pickers(self) -> Pickers | None:
        """Make the people who pick into robots at storage places."""
        spec = self.model.pickers
        if spec is None:
            return None
        return Pickers(self.env, spec, self.model.hours(spec.hours), self.layout, self.log)

    def _stand_on_lanes(self) -> None:
        """Put robots on the lanes where they start, from the front; each is bound for home until it has a task."""
        starts = [item for item in enumerate(self.model.fleet.starts(self.layout.bays)) if item[1].on_lanes]
        for number, start in sorted(starts, key=lambda item: -item[1].offset):
            robot = self.robots[number]
            robot.stand(start)
            robot.itinerary.start(self.travel.way(start.node, robot.home))

    # The run

    def run(self, until: float | None = None) -> World:
        """Simulate until all goods are delivered and all robots back in a bay, or for the length of the run.

        The run ends at `until` at the latest.
        """
        self.begin(until)
        self.go_on()
        return self

    def begin(self, until: float | None = None) -> None:
        """Schedule the start of all parts at time 0; the run ends at `until` if it would last longer."""
        env, length = self.env, min((end for end in (self.model.run.length, until) if end is not None), default=None)
        release = (self.pods or self.batcher or self.dispatcher).release
        self.demand.start(self._while_few_are_open(release) if self.settles else release)
        for robot in self.robots:
            if self.model.fleet.start_energy == "settled":  # known from no model file
                robot.record(AT_START)
            env.process(robot.life())
        self.departures.duty.watch(self._hours_change)
        if self.model.run.warm_up:
            Timeout(env, self.model.run.warm_up).callbacks.append(lambda _: self._count_from_here())
        if self.demand.total is None:
            assert length is not None
            self.over = happened(env)
            env.schedule(self.over, URGENT, length)
        else:
            self.over = self.finished if length is None else self.finished | Timeout(env, length)

    def _while_few_are_open(self, release: Callable[[Task], None]) -> Callable[[Task], None]:
        """Keep the list to tasks that are done soon: a fleet that cannot keep up is as busy without the others."""
        most = FEW * len(self.robots)

        def take(task: Task) -> None:
            if len(self.dispatcher.open) < most:
                release(task)

        return take

    def go_on(self) -> bool:
        """Simulate up to the next decision that is asked for (True), or to the end of the run (False)."""
        try:
            if not self.env.run_to(self.over):
                raise StallError(self._stalled())
        except StopSimulation:  # by the dispatcher
            return True
        self.close()
        return False

    def close(self) -> None:
        """Log the waits under way, and tally what has happened since the warm-up ended."""
        log, now = self.log, self.env.now
        for robot in self.robots:
            robot.body.end_waits(now)
        log.robots, log.edges, log.nodes, log.stations = self._tallies_since_warm_up()
        if self.model.battery is not None:
            log.energy = [robot.battery.level(now) for robot in self.robots]
        record_closures(log, self.model, self.layout, now)
        record_visits(log, self.people, now)
        log.close(now)
        log.finished = self.finished.triggered
        if self.people:
            count_encounters(log, self.people, self.model.fleet.starts(self.layout.bays))
            log.forget_moves()

    def _hours_change(self, robots: Sequence[int]) -> bool:
        """Note that hours of some robots begin or end. Returns False if this can no longer lead to work."""
        goes_on = not self.env.only_ticks
        for number in robots:
            self.robots[number].hours_change()
        return self.dispatcher.hours_change(robots) or goes_on

    def _count_from_here(self) -> None:
        self.log.begin = self.env.now
        self._before = self._tallies()

    def _tallies(self) -> tuple[Rows, Rows, Rows, Rows]:
        return tallies(self.robots, self.traffic, self.stations.by_node, self.env.now)

    def _tallies_since_warm_up(self) -> tuple[Rows, Rows, Rows, Rows]:
        robots, edges, nodes, stations = self._tallies()
        if self._before is None:
            return robots, edges, nodes, stations
        before = self._before
        return less(robots, before[0]), less(edges, before[1]), less(nodes, before[2]), less(stations, before[3])

    def _worked(self) -> None:
        """Note that a load unit in a station has been worked on, which may complete the run."""
        self.dispatcher.end_if_done()

    def _stalled(self) -> str:
        blocked = "; ".join(
            f"robot {robot.number} {robot.body.place(self.env.now)}"
            for robot in self.robots
            if robot.body.lane is not None
        )
        reasons = f"{self._in_no_batch()}{self._hours()}{self._unable()}{self._closed()}{self._out_of_stock()}"
        return (
            f"stalled at time {self.env.now:g}: {self.dispatcher.done} of {self.demand.total} tasks are done and "
            f"nothing is scheduled; on the lanes: {blocked or 'nobody'}; "
            f"open tasks: {list(self.dispatcher.open)[:10]}{reasons or self._doing()}"
        )

    def _out_of_stock(self) -> str:
        """Return the words on items that lines wait for and that no pod has now; empty where there are none."""
        gone = [] if self.pods is None else list(map(self.pods.spec.name_of, self.pods.out_of_stock()))
        return f"; lines wait for items of which no pod has any left (pods.stock): {first_of(gone, 10)}" if gone else ""

    def _doing(self) -> str:
        """Return the explanation of a stall by default: that no task was requested, or what the robots do."""
        if not self.demand.total:
            return "; no task was ever asked for: the goods, schedules and files of this model ask for none"
        doing = Counter(robot.state for robot in self.robots)
        return f"; robots: {', '.join(f'{count} {words}' for words, count in doing.items())}"

    def _hours(self) -> str:
        """Return the words on tasks and robots that wait for hours that do not come again, or do not meet."""
        shut = [robot for robot in self.robots if STATES[robot.state].queue == OPENING]
        waiting = [f"robot {robot.number} at {robot.node}" for robot in shut]
        text = f"; in stations that do not open again: {', '.join(waiting)}" if waiting else ""
        if self.pickers is not None and (uncalled := self.pickers.left_alone()):
            text += f"; robots that wait for a picker, whose hours are over for good: {', '.join(map(str, uncalled))}"
        if left := self.stations.unfinished:
            text += f"; load units that are not worked on: in {', '.join(left)}"
        if gone := self.departures.duty.gone():
            text += f"; robots whose hours are over for good: {', '.join(map(str, gone))}"
        if self.dispatcher.open and self.dispatcher.attempts.are_in_vain and not self._unable():
            text += f"; {self._never_open_together()} do not meet, so that nobody can be given these tasks"
        return text

    def _never_open_together(self) -> str:
        """Name the calendars that keep tasks back."""
        model = self.model
        closures = [name for name, spec in model.traffic.closures.items() if spec.tasks == "hold"]
        parties = [
            *(["robots"] if model.fleet.has_hours else []),
            *(["stations"] if model.layout.has_hours else []),
            *([f"open ways (traffic.closures: {', '.join(closures)})"] if closures else []),
        ]
        return f"the hours of {spoken(parties)}"

    def _closed(self) -> str:
        """Return the words on edges that will not open again, before which robots wait."""
        shut = {}
        for robot in self.robots:
            claim = robot.body.claim
            if claim is not None and claim.shut_by is not None:
                shut.update(dict.fromkeys(lane.edge for lane in (claim.lane, claim.over) if lane is not None))
        edges = ", ".join(">".join(edge) for edge in shut)
        return f"; closed, and never open again: {edges} (traffic.closures)" if edges else ""

    def _in_no_batch(self) -> str:
        """Return the words on how many tasks the batching policy has put into no batch; empty where there are none."""
        count = 0 if self.batcher is None else sum(map(len, self.batcher.waiting))
        return f"; {count} tasks are in no batch ({self.model.policies.batching.name})" if count else ""

    def _unable(self) -> str:
        """Return why no robot takes the first open task, if batteries are the reason; else an empty text."""
        task = next(iter(self.dispatcher.open.values()), None)
        views = [robot.view() for robot in self.robots]
        if task is None or not any(may_do(robot, task) for robot in views):
            return ""
        if any(self.reach.lasts(robot, task) for robot in views if may_do(robot, task)):
            return ""
        return f"; no robot's battery lasts for task {task.number}: {self.reach.why_none_lasts(views, task)}"


def _settled(
    model: Model, streams: Streams, fleets: SettledFleets, heed: Callable[[Clock], object] | None
) -> Fleet | None:
    """Return the state of a settled fleet at the start; None if batteries are not settled, or work ends."""
    if model.fleet.start_energy != "settled" or not has_long_run(model):
        return None

    def settle(settling: SettlingRun) -> Sequence[Fleet]:
        try:
            world = World(settling.model, SEED, heed=heed, settles=True)
            settling.watch(world.env, world.robots)
            world.run()
        except SettledError:
            return settling.fleets
        except (CheckError, BatteryError, StallError):  # in a day; the run itself, if as long, says how that ends
            pass
        return ()

    def waiting() -> None:
        if heed is not None:
            heed(Clock())

    seen = fleets.of(model, settle, waiting)
    return any_of(seen, streams) if seen else None


def _policy(kind: str, spec: PolicySpec) -> Any:
    """Make the policy that a model names for a kind of decision."""
    return create(kind, spec.name, spec.params)


def _traffic(
    env: Clock, model: Model, layout: Layout, log: Log, zones: Sequence[TrafficZone], restrictions: Restrictions
) -> Traffic:
    """Make the Highways in use, from the model's traffic section and robots."""
    fleet, spec = model.fleet, model.traffic
    speeds = {speed for robot in fleet.distinct() for speed in (robot.speed, robot.loaded_speed)}
    return Traffic(
        env,
        layout,
        log,
        contact=fleet.contact,
        theta=math.radians(spec.collision_angle),
        node_time=spec.node_time,
        turn_time=spec.turn_time,
        mixed=len(speeds) > 1 or layout.has_limits or fleet.slowness > 0,
        rule=_rule(model, layout),
        patience=PATIENCE / model.units.seconds,
        zones=zones,
        node_times=dict(spec.node_times),
        free=spec.free_nodes,
        restrictions=restrictions,
        wide=wide_edges(layout, fleet.contact, zones),
        looks=all(robot.keeps == "distance" for robot in fleet.distinct()),
    )


def _rule(model: Model, layout: Layout) -> Rule:
    """Return the rule that keeps robots from being stuck: traffic.gridlock, or the rule that fits the lanes."""
    rule = model.traffic.gridlock
    if rule == "auto":
        return "avoid" if layout.two_way else "rotate"
    return rule


def _bays(
    env: Clock,
    layout: Layout,
    homes: list[str],
    kinds: frozenset[str],
    batteries: Mapping[str, int],
    streams: Streams,
    *,
    keep: bool,
) -> Bays:
    """Make the layout's bays. By default a bay has a slot and a charger for each robot at home there.

    Chargers are for robots of all `kinds`, unless the bay names some. `batteries`: spare ones of each kind, shared out
    among the bays with chargers round-robin.
    """
    bays, at_home = [], Counter(homes)
    spares: defaultdict[str, dict[str, Spares]] = defaultdict(dict)
    for kind, count in batteries.items():
        swapped = swapped_at(layout, kind)
        for rank, node in enumerate(swapped):
            spares[node][kind] = Spares(env, count // len(swapped) + (rank < count % len(swapped)))
    for node, item in layout.bays.items():
        places = item.slots(at_home[node])
        number = places if item.chargers is None else item.chargers
        chargers: Chargers | FailingChargers | None = None
        if number and item.outages is not None:
            chargers = FailingChargers(env, node, number, item.outages, streams)
        elif number:
            chargers = Chargers(env, number)
        charges = frozenset(item.kinds) or kinds if number else frozenset[str]()
        bays.append(Bay(node, places, chargers, charges, spares.get(node)))
    return Bays(env, bays, keep=keep)
