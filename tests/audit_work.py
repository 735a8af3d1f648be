"""The part of the auditor for work: tasks, places in bays and stations, batteries, tallies."""

from collections import Counter, defaultdict
from itertools import groupby

from desim_warehouse.model.facts.charging import start_levels
from desim_warehouse.values.streams import Streams
from tests.charging import batteries, swaps
from tests.done import done

TOL = 1e-6
WORKING = {"empty", "loading", "loaded", "closed", "unloading", "awaiting", "returning", "broken", "awaiting_picker"}
STATES = WORKING | {"idle", "on_break", "queueing", "charging"}
NO_ENERGY = {
    "drive",
    "aside",
    "back",
    "collision",
    "rotation",
    "enter",
    "released",
    "waiting_closed",
    "waiting_person",
    "in_lift",
    "lifted",
    "stored",
    "walking",
    "picking",
}


class Work:
    """Checks of the work of robots, for `Audit`, which knows where they were."""

    def check_work(self):
        self.rows = self.run.record.rows
        self.check_tasks()
        if self.run.model.pods is None:  # audit_pods checks models with pods
            self.check_loading()
            self.check_loads_on_board()
            self.check_stops()
        self.check_places()
        self.check_energy()
        self.check_shares()
        self.check_tallies()

    def check_tasks(self):
        """Each task is released, assigned, perhaps returned, and delivered once, by the robot that has it.

        A robot without tasks gets all tasks of a tour at once, and no more than it can carry. Lines may join the visit
        of a pod.
        """
        state, hands, assigned_at = {}, defaultdict(set), {}
        most = [robot.capacity for robot in self.run.model.fleet.robots()]
        follows = {
            "released": {None},
            "assigned": {"released", "returned"},
            "returned": {"assigned"},
            "delivered": {"assigned"},
        }
        for time, kind, robot, task, *_ in self.rows:
            if kind not in follows:
                continue
            if state.get(task) not in follows[kind]:
                self.fault(time, f"task {task} was {kind} after being {state.get(task)}")
            state[task] = kind
            if kind == "assigned":
                joins = self.run.model.pods is not None
                if hands[robot] and not joins and (assigned_at[robot] != time or len(hands[robot]) == most[robot]):
                    held = ", ".join(f"task {one}" for one in sorted(hands[robot]))
                    self.fault(time, f"robot {robot} was given task {task} while it had {held}")
                hands[robot].add(task)
                assigned_at[robot] = time
            elif kind != "released":
                if task not in hands[robot]:
                    self.fault(time, f"task {task} was {kind} by robot {robot}, which did not have it")
                hands[robot].discard(task)
                assigned_at[robot] = None
        self.delivered = sum(1 for kind in state.values() if kind == "delivered")
        if len(state) - len(done(self.run)) != self.run.kpis["backlog"]:
            self.fault(self.run.record.end, "tasks were lost or made up")

    def check_loading(self):
        """A robot loads where its good is, and delivers only tasks that it has loaded."""
        good, loaded = {}, set()
        for time, kind, robot, task, _, _, value, *_ in self.rows:
            if kind == "released":
                good[task] = int(value)
            elif kind == "loading":
                loaded.add(task)
                if good.get(task, 0) < 0:
                    if not self.is_docked(time, robot) and not self.stands_on(time, robot):
                        self.fault(time, f"robot {robot} loads task {task}, which is in no storage, on a lane")
                elif task in good:
                    self.check_place_of_good(time, robot, self.run.layout.storage[good[task]])
            elif kind == "returned" and task in loaded:
                self.fault(time, f"task {task} was returned after it was loaded")
            elif kind == "delivered" and task not in loaded:
                self.fault(time, f"task {task} was delivered and never loaded")

    def check_loads_on_board(self):
        """A robot never exceeds its capacity, and carries only its load types and the flows of its kind."""
        model, on_board = self.run.model, defaultdict(set)
        robots, kinds = model.fleet.robots(), model.fleet.kinds_of_robots()
        for time, kind, robot, task, *_ in self.rows:
            if kind == "loading":
                on_board[robot].add(task)
                if len(on_board[robot]) > robots[robot].capacity:
                    self.fault(time, f"robot {robot} carries {sorted(on_board[robot])}, more than it can")
                flow = model.tasks.flows.get(self.run.record.flows.get(task))
                carries = robots[robot].carries
                if flow is not None and flow.load_type and carries and flow.load_type not in carries:
                    self.fault(time, f"robot {robot} carries task {task}, a {flow.load_type}")
                if flow is not None and flow.kinds and kinds[robot] not in flow.kinds:
                    self.fault(time, f"robot {robot} of kind {kinds[robot]!r} does task {task}")
            elif kind == "delivered":
                if task not in on_board[robot]:
                    self.fault(time, f"robot {robot} delivers task {task}, which it does not carry")
                on_board[robot].discard(task)

    def check_stops(self):
        """A task makes the stops of its flow, in order, and is unloaded at a destination of the flow."""
        flows, layout = self.run.model.tasks.flows, self.run.layout
        stops, nodes, states = defaultdict(list), {}, defaultdict(list)
        for time, kind, robot, task, node, edge, *_ in self.rows:
            if kind in STATES:
                paused = states[robot][-2:] == [("unloading", task), ("closed", task)]
                states[robot].append((kind, task))
            if kind == "unloading":
                if not paused:
                    stops[task].append(node)
            elif kind == "delivered":
                flow = flows.get(self.run.record.flows.get(task))
                if flow is None or hasattr(flow.arrivals, "orders"):
                    continue
                for name in flow.via:
                    nodes.setdefault(name, layout.nodes_of(name))
                at = stops[task][:-1]
                if len(at) != len(flow.via) or any(n not in nodes[v] for n, v in zip(at, flow.via, strict=True)):
                    self.fault(time, f"task {task} stopped at {at} on its way, not at {flow.via}")
                ends = [
                    end for route in flow.routes for end in (route.target if isinstance(route.target, tuple) else ())
                ]
                if edge is None and ends and node not in ends:
                    self.fault(time, f"task {task} was brought to {node}, not to {ends}")

    def is_docked(self, time, robot):
        """Whether a robot is in a station at a time."""
        seen = ("docked", "parked", "enter")
        last = [row[1] for row in self.rows if row[2] == robot and row[1] in seen and row[0] <= time + TOL]
        return last[-1:] == ["docked"]

    def check_place_of_good(self, time, robot, place):
        if place.edge[0] == place.edge[1]:
            if place.edge[0] not in self.stands_on(time, robot):
                self.fault(time, f"robot {robot} loads good {place.number}, which is not where it is")
            return
        here = (visit for visit in self.visits[robot] if visit.enter <= time + TOL and visit.leave >= time - TOL)
        ends = [place.edge]
        if self.graph.edges[place.edge].get("two_way"):  # robots load in either direction
            ends.append(place.edge[::-1])
        visit = next((visit for visit in here if visit.edge in ends), None)
        if visit is None:
            self.fault(time, f"robot {robot} loads good {place.number}, which is not where it is")
            return
        length, at = self.graph.edges[place.edge]["length"], visit.at(time)
        offset = place.offset if visit.edge == place.edge else length - place.offset
        clear = self.contact <= offset <= length - self.contact
        short = offset - at
        if abs(short) <= (TOL if clear else self.contact + TOL):
            return
        ahead = [v.at(time) - at for v in self.all_visits() if v.edge == visit.edge and v.enter <= time <= v.leave]
        if 0 < short < self.contact and any(TOL < gap <= self.contact + TOL for gap in ahead):
            return  # in a full ring a robot loads from where it stands, close behind the next robot
        self.fault(time, f"robot {robot} loads good {place.number} at {at:g}, not at {offset:g}")

    def all_visits(self):
        return (visit for visits in self.visits.values() for visit in visits)

    def check_places(self):
        """Robots leave a bay by its node, and no bay or station holds more robots than it has places."""
        fleet, layout = self.run.model.fleet, self.run.layout
        start = fleet.homes(layout.bays)
        homes = Counter(start)
        grown = {
            node: bay.grows * max(homes[node] + (bay.chargers == 0), bay.chargers or 0)
            for node, bay in layout.bays.items()
        }
        room = {
            ("parked", node): homes[node] if bay.places is None else max(bay.places, grown[node])
            for node, bay in layout.bays.items()
        }
        room |= {("docked", node): station.places for node, station in layout.stations.items()}
        begins = self.starts()
        inside = {number: ("parked", begins[number]) for number in range(len(fleet.start_on_lanes), fleet.size)}
        for time, rows in groupby(self.rows, key=lambda row: row[0]):
            for _, kind, robot, _, node, edge, *_ in rows:
                if kind in {"parked", "docked"}:
                    inside[robot] = kind, node
                elif kind == "enter" and robot in inside:
                    _, left = inside.pop(robot)
                    if edge[0] != left:
                        self.fault(time, f"robot {robot} was in a bay at {left} and came out onto {edge}")
                elif kind == "cleared" or (kind == "broken" and inside.get(robot, ("",))[0] == "parked"):
                    inside.pop(robot, None)  # no robot breaks down in a bay: it was on the node, about to enter a lane
            for place, robots in Counter(inside.values()).items():
                if robots > room.get(place, 0):
                    self.fault(time, f"{robots} robots are {place[0]} at {place[1]}, which has {room.get(place, 0)}")

    def check_energy(self):
        """No battery is flat or more than full; it is drawn and charged within its rates, at chargers for its kind."""
        model = self.run.model
        if model.battery is None:
            return
        kinds = model.fleet.kinds_of_robots()
        of_robots, swapping = batteries(model), swaps(model)
        begins = start_levels(model, Streams(self.run.seed))
        for row in self.rows if model.fleet.start_energy == "settled" else ():
            if row[0] == 0 and row[1] == "idle":
                begins[row[2]] = row[6]
        before, state = {}, {}
        for time, kind, robot, _, node, _, energy, *_ in self.rows:
            if robot < 0 or kind in NO_ENERGY or energy is None:
                continue
            battery, swapped = of_robots[robot], swapping[robot]
            spent = battery.consumption
            steady = isinstance(spent, (int, float))
            most = spent if steady else max(spent.standing, spent.empty, spent.loaded, spent.handling)
            tol = TOL * battery.capacity
            reserved = self.run.layout.bays[node].kinds if kind == "charging" else ()
            if reserved and kinds[robot] not in reserved:
                self.fault(time, f"robot {robot} of kind {kinds[robot]!r} charges at {node}, which is for {reserved}")
            if energy < -battery.reserve - tol or energy > battery.capacity + tol:
                self.fault(time, f"robot {robot} has {energy} energy")
            since, had = before.get(robot, (0.0, begins[robot]))
            passed = time - since
            gained = energy - had
            charged = 0 if state.get(robot) in WORKING else battery.charge_rate * passed
            if gained < -most * passed - tol or (gained > charged + tol and not swapped):
                self.fault(time, f"robot {robot} had {had:g} energy and {passed:g} later {energy:g}")
            elif steady and state.get(robot) in WORKING and abs(gained + spent * passed) > tol:
                self.fault(time, f"robot {robot} drew {-gained:g} energy in {passed:g}")
            before[robot] = time, energy
            if kind in STATES:
                state[robot] = kind

    def check_shares(self):
        total = sum(value for key, value in self.run.kpis.items() if key.startswith("share_"))
        if self.run.record.end > 0 and abs(total - 1) > TOL:
            self.fault(self.run.record.end, f"state shares add up to {total}")

    def check_tallies(self):
        """The tallies of each robot are the counts of its rows in the log."""
        count = Counter()
        for time, kind, robot, _, node, *_ in self.rows:
            if time < self.run.record.begin:
                continue
            count[robot, ("rear_ends" if node is None else "crossings") if kind == "collision" else kind] += 1
        names = {"moves": "enter", "delivered": "delivered", "recharged": "recharged"}
        for number, robot in enumerate(self.run.record.robots):
            for key in ("moves", "delivered", "recharged", "rear_ends", "crossings"):
                logged = count[number, names.get(key, key)]
                if robot[key] != logged:
                    self.fault(self.run.record.end, f"robot {number} counts {robot[key]} {key}, {logged} are logged")
