"""All indicators and tallies of a run once more, from the rows of its log alone (level `all`).

It shares no code with the simulator. Of the run it takes the rows and when it ended; of the model what a row does not
say: rates of consumption, due times, weights, where chargers are. All is counted from `begin` to `end`, both included:
a row counts if its time lies there, a stretch of time (driving, waiting, being in a state) with its part within.
"""

import math
import statistics
from collections import Counter, defaultdict
from itertools import permutations

import numpy as np

from tests.charging import batteries, swaps
from tests.done import done, for_workers, workplaces

APART = ("waiting_closed", "waiting_person", "in_lift")
WORK = ("empty", "loading", "loaded", "queueing", "closed", "unloading", "awaiting", "returning", "awaiting_picker")
STATES = ("idle", *WORK, "charging", "broken", "on_break", "too_low")
DRAWS = {
    "idle": "standing",
    "queueing": "standing",
    "closed": "standing",
    "awaiting": "standing",
    "awaiting_picker": "standing",
    "on_break": "standing",
    "too_low": "standing",
    "broken": "standing",
    "empty": "empty",
    "returning": "empty",
    "loaded": "loaded",
    "loading": "handling",
    "unloading": "handling",
}


class Recount:
    """What happened between `begin` and `end`, counted from the log."""

    def __init__(self, run):
        self.run = run
        self.model = run.model
        self.layout = run.layout
        self.rows = run.record.rows
        self.at_end = run.record.energy
        self.end = run.record.end
        warm_up = self.model.run.warm_up
        self.begin = warm_up if warm_up <= self.end else 0.0
        self.size = self.model.fleet.size
        self.absent = set() if any(robot.breakdowns for robot in self.model.fleet.robots()) else {"broken"}
        self.robots = [Counter() for _ in range(self.size)]
        self.edges = defaultdict(Counter)
        self.nodes = defaultdict(Counter)
        self.count_rows()
        self.measure_driving()
        self.measure_time()
        if self.model.people:
            self.measure_people()

    def within(self, begin, end):
        """How much of an interval is counted."""
        return max(min(end, self.end) - max(begin, self.begin), 0.0)

    # What is counted

    def count_rows(self):
        self.waits = defaultdict(list)
        self.rotations = 0
        for time, kind, robot, _, node, edge, value, *_ in self.rows:
            counts = self.begin <= time <= self.end
            if kind in APART:
                self.waits[robot].append((time - value, time, kind))
                self.robots[robot]["encounters"] += counts and kind == "waiting_person"
            elif kind == "collision":
                self.waits[robot].append((time - value, time, "waiting"))
                place, name = (self.edges[edge], "rear_ends") if node is None else (self.nodes[node], "crossings")
                place["blocked"] += self.within(time - value, time)
                place["waits"] += counts
                self.robots[robot][name] += counts
            elif kind == "enter":
                self.edges[edge]["passages"] += counts
                self.robots[robot]["moves"] += counts
            elif kind in {"delivered", "recharged"}:
                self.robots[robot][kind] += counts
            elif kind == "broken":
                self.robots[robot]["breakdowns"] += counts
            elif kind == "rotation":
                self.rotations += counts

    # What is measured

    def measure_driving(self):
        """Distance: a robot drives at a steady speed from one position to the next."""
        position = {
            (robot, place.edge): place.offset
            for robot, place in enumerate(self.model.fleet.start_on_lanes)
            if hasattr(place, "edge")
        }
        for time, kind, robot, _, _, edge, value, until, *_ in self.rows:
            if kind == "enter":
                position[robot, edge] = 0.0
            elif kind == "drive":
                driven = value - position[robot, edge]
                if until > time:
                    driven *= self.within(time, until) / (until - time)
                    self.robots[robot]["distance"] += driven
                position[robot, edge] = value

    def measure_time(self):
        """Time in each state less the waits in it, and the energy that it takes; a robot begins idle in its bay."""
        place = dict(enumerate(self.model.fleet.homes(self.layout.bays)))
        stretches = defaultdict(list)
        now = {robot: (0.0, "idle", place[robot]) for robot in range(self.size)}
        waits_for = defaultdict(str)
        self.queued = Counter()
        self.lowest, self.gained = math.inf, 0.0
        self.batteries, self.swaps = batteries(self.model), swaps(self.model)
        for time, kind, robot, task, node, *_ in self.rows:
            if kind in {"parked", "docked", "cleared"}:
                place[robot] = node if kind == "parked" else None
            elif kind == "enter":
                place[robot] = None
            elif kind in STATES:
                if kind == "empty":  # out of its bay, perhaps for a good beside that, to which no lane leads
                    place[robot] = None
                since, state, where = now[robot]
                stretches[robot].append((since, time, state, where))
                now[robot] = time, kind, place[robot]
                self.queue(state, since, time, waits_for[robot])
                waits_for[robot] = "server" if task >= 0 else "charger"
        for robot, (since, state, where) in now.items():
            stretches[robot].append((since, self.end, state, where))
            self.queue(state, since, self.end, waits_for[robot])
        for robot, parts in stretches.items():
            for since, until, state, where in parts:
                self.add_stretch(robot, since, until, state, where)
            if self.model.battery is not None:
                self.follow_battery(robot, parts)

    def add_stretch(self, robot, since, until, state, where):
        tally = self.robots[robot]
        waited = 0.0
        for begin, end, kind in self.waits[robot]:
            if begin < until and end > since:
                part = self.within(max(since, begin), min(until, end))
                tally[kind] += part
                waited += part
        worked = self.within(since, until) - waited
        tally[state] += worked
        tally["energy"] += worked * self.rate(robot, state, where) + waited * self.rate(robot, "idle", None)

    def measure_people(self):
        """Where robots and people are, from row to row: those that a person meets, and for how long."""
        edges = {}
        for robot, place in enumerate(self.model.fleet.start_on_lanes):
            edges[robot] = getattr(place, "edge", None)
        present = defaultdict(set)  # edges by visit
        visits, met = set(), set()
        self.people = Counter()
        last = 0.0
        for time, kind, robot, _, _, edge, value, *_ in [*self.rows, (self.end, "", *[None] * 7)]:
            passed = self.within(last, time)
            for aisle in present.values() if passed else ():
                self.people["time"] += passed
                self.people["shared"] += passed * any(edges[one] in aisle for one in edges)
            last = time
            if kind in {"enter", "parked", "docked", "cleared"}:
                edges[robot] = edge
            elif kind == "person_in":
                present[value].add(edge)
                if time >= self.begin:
                    visits.add(value)
                    met |= {(value, one) for one in edges if edges[one] == edge}
            elif kind == "person_out":
                present.pop(value, None)
        self.people["visits"] = len(visits)
        for _, robot in met:
            self.robots[robot]["encounters"] += 1

    def queue(self, state, since, until, thing):
        if state == "queueing":
            self.queued[thing] += self.within(since, until)

    # Batteries

    def follow_battery(self, robot, parts):
        """The level from stretch to stretch: it is in the rows where a stretch begins, else falls as `rate` says."""
        levels = [row[6] for row in self.rows if row[2] == robot and row[1] in STATES]
        given = self.model.fleet.start_energy
        if isinstance(given, (int, float)):
            first_level = given * self.batteries[robot].capacity
        else:  # drawn at random: nothing but drawing came before the first row, or the end
            then = levels[0] if levels else self.at_end[robot]
            first_level = then + self.drawn(robot, *parts[0], parts[0][1])
        before = None
        for (since, until, state, where), at_start, at_next in zip(
            parts, [first_level, *levels], [*levels, None], strict=True
        ):
            if until < self.begin:
                continue
            level = self.level(robot, at_start, since, until, state, where, max(since, self.begin))
            before = level if before is None else before
            last = self.level(robot, at_start, since, until, state, where, until) if at_next is None else at_next
            self.lowest = min(
                self.lowest, level / self.batteries[robot].capacity, last / self.batteries[robot].capacity
            )
            after = last
        self.gained += after - before

    def drawn(self, robot, since, until, state, where, at):
        """Energy drawn from the start of a stretch to an instant in it."""
        waited = sum(max(min(end, at) - max(begin, since), 0.0) for begin, end, _ in self.waits[robot])
        return (at - since - waited) * self.rate(robot, state, where) + waited * self.rate(robot, "idle", None)

    def level(self, robot, start, since, until, state, where, at):
        if state != "charging":
            return start - self.drawn(robot, since, until, state, where, at)
        if self.swaps[robot]:
            return start
        return self.charged(self.batteries[robot], start, at - since)

    def charged(self, battery, start, time):
        """Straight up to the knee; from there on what is missing to a level beyond full shrinks exponentially."""
        rate, capacity = battery.charge_rate, battery.capacity
        if battery.taper is None:
            return min(start + rate * time, capacity)
        knee = battery.taper.start * capacity
        steady = min(max(knee - start, 0.0) / rate, time)
        level = start + rate * steady
        aim = knee + (capacity - knee) / (1 - battery.taper.end_rate)
        level = aim - (aim - level) * math.exp(-(time - steady) * rate / (aim - knee)) if time > steady else level
        return min(level, capacity)

    def energy(self):
        hours = (self.end - self.begin) / self.model.units.hour
        if self.model.battery is None:
            return {}
        chargers = 0
        for node, bay in self.layout.bays.items():
            room = self.slots(node)
            chargers += room if bay.chargers is None else min(bay.chargers, room)
        indicators = {
            "energy_lowest": self.lowest,
            "energy_drift_per_hour": self.gained / sum(one.capacity for one in self.batteries) / hours
            if hours
            else math.nan,
        }
        if chargers:
            used = sum(robot["charging"] for robot in self.robots)
            time = (self.end - self.begin) * chargers
            indicators["charger_utilisation"] = used / time if time else math.nan
            indicators["charger_wait"] = self.queued["charger"]
        return indicators

    def utilisation(self):
        """Robots that do not stand idle in their hours, and servers in use: stretch by stretch of each robot."""
        on_duty = (self.end - self.begin) * self.size - sum(robot["on_break"] for robot in self.robots)
        idle = sum(robot["idle"] for robot in self.robots)
        indicators = {"robots_busy": 1 - idle / on_duty if on_duty > 1e-9 else math.nan}
        if not self.layout.stations:
            return indicators
        hours = {
            node: self.model.hours(self.model.layout.stations[item.zone].hours)
            for node, item in self.layout.stations.items()
        }
        time = sum(
            item.servers * sum(end - begin for begin, end in hours[node].between(self.begin, self.end))
            for node, item in self.layout.stations.items()
        )
        used, since, docked = 0.0, {}, {}
        stored = {row[3] for row in self.rows if row[1] == "released" and row[6] is not None and row[6] >= 0}
        for at, kind, robot, task, node, *_ in [
            *self.rows,
            *((self.end, "idle", n, 0, None) for n in range(self.size)),
        ]:
            if kind in {"docked", "enter"}:
                docked[robot] = node if kind == "docked" else None
            elif kind in {"lifted", "stored"}:  # no server has a hand in that
                since.pop(robot, None)
            elif kind in STATES:
                start, place = since.pop(robot, (at, None))
                if place is not None:
                    used += sum(b - a for a, b in hours[place].between(max(start, self.begin), min(at, self.end)))
                if self.model.pods is not None and kind in {"loaded", "empty", "returning"}:
                    docked[robot] = None  # with its pod, or without one, it has left the station
                if kind in {"loading", "unloading"}:
                    outside = kind == "loading" and task in stored  # on the node beside a station that it has left
                    since[robot] = at, None if outside else docked.get(robot)
        return indicators | {"server_utilisation": used / time if time else math.nan}

    def rate(self, robot, state, where):
        """Energy drawn in a time unit; nothing while a robot charges, or rests in a slot with a charger of its kind."""
        battery = self.batteries[robot]
        if battery is None or state == "charging" or (state in {"idle", "on_break"} and self.has_charger(robot, where)):
            return 0.0
        spent = battery.consumption
        return spent if isinstance(spent, (int, float)) else getattr(spent, DRAWS[state])

    def slots(self, node):
        return self.layout.bays[node].slots(self.model.fleet.homes(self.layout.bays).count(node))

    def has_charger(self, robot, node):
        bay = self.layout.bays.get(node)
        if bay is None or (bay.chargers is not None and bay.chargers < self.slots(node)):
            return False
        return not bay.kinds or self.model.fleet.kinds_of_robots()[robot] in bay.kinds

    def breakdowns(self):
        """Availability: of the time in operation or broken, waits not counted."""
        if self.absent:
            return {}
        works = sum(robot[name] for robot in self.robots for name in DRAWS if DRAWS[name] != "standing")
        broken = sum(robot["broken"] for robot in self.robots)
        return {
            "breakdowns": sum(robot["breakdowns"] for robot in self.robots),
            "availability": works / (works + broken) if works + broken > 1e-12 * (self.end - self.begin) else math.nan,
        }

    # Tasks

    def trips(self):
        """Tours that ended with the delivery of their last task, by what each robot has in hand."""
        if self.model.policies.batching.name == "single":
            return {}
        hands, loads = defaultdict(list), []
        for time, kind, robot, task, *_ in self.rows:
            if kind == "assigned":
                hands[robot].append(task)
            elif kind == "returned":
                hands.pop(robot, None)
            elif kind == "delivered" and task in hands[robot]:
                left = {row[3] for row in self.rows if row[1] == "delivered" and row[0] <= time}
                if set(hands[robot]) <= left:
                    taken = hands.pop(robot)
                    loads += [len(taken)] * (self.begin <= time <= self.end)
        return {"trips": len(loads), "loads_per_trip": statistics.fmean(loads) if loads else math.nan}

    def due(self):
        """When each task is due, by number: tasks are numbered as they are released."""
        goods = self.model.tasks.goods
        if isinstance(goods, tuple):
            listed = sorted(goods, key=lambda good: getattr(good, "release", 0.0))
            return {
                number: due for number, good in enumerate(listed) if (due := getattr(good, "due", None)) is not None
            }
        if self.model.tasks.flows:
            terms = {row[3]: self.due_of_flow(row[3], row[0]) for row in self.rows if row[1] == "released"}
            return {number: due for number, due in terms.items() if due is not None}
        within = getattr(goods, "due_within", None)
        if within is None:
            return {}
        return {row[3]: row[0] + within for row in self.rows if row[1] == "released"}

    def due_of_flow(self, task, released):
        """When a task of a flow is due: after so long, or at the first of all departures that it comes in time for."""
        spec, unit = self.model.tasks.flows[self.run.record.flows[task]], 1 / self.model.units.seconds
        if spec.due_within is not None:
            return released + spec.due_within
        times, cut_off = getattr(spec.due_at, "times", spec.due_at), getattr(spec.due_at, "cut_off", 0.0)
        hours, minutes = (int(part) for part in self.model.run.start.rpartition("T")[2].split(":")[:2])
        start, departures = 60 * (60 * hours + minutes), []
        for time in times:
            if isinstance(time, str):
                hour, minute = (int(part) for part in time.split(":")[:2])
                clock = 60 * (60 * hour + minute) - start
                departures += [(clock + 86400 * day) * unit for day in range(-1, int(self.end / 86400 / unit) + 3)]
            else:
                departures.append(time)
        return min((time for time in departures if time >= released + cut_off), default=None)

    def lead(self, due, released, delivered):
        """The longest time before its departure at which a task came that missed it."""
        flows = {name for name, flow in self.model.tasks.flows.items() if flow.due_at}
        leads = [
            (due[task] - time) * (delivered.get(task, math.inf) > due[task])
            for task, time in released.items()
            if self.run.record.flows.get(task) in flows and task in due and self.begin <= due[task] <= self.end
        ]
        return {"departure_lead": max(leads)} if leads else {}

    def late(self, due, ends, among):
        """By how much each is late that came due in the counted time, and how many are not.

        Where the run ended as all was done, those done before they come due after it count, too.
        """
        length = math.inf if self.model.run.length is None else self.model.run.length
        released = sum(row[1] == "released" for row in self.rows)
        over = not self.model.tasks.never_end and self.end < length and released == len(done(self.run))
        by, met = [], 0
        for task in due.keys() & among:
            in_time = ends.get(task, math.inf) <= due[task]
            if due[task] >= self.begin and (due[task] <= self.end or (over and in_time)):
                by.append(0.0 if in_time else min(ends.get(task, self.end), self.end) - due[task])
                met += in_time
        return by, met

    def bound_for(self, at):
        """The released tasks that can only go to nodes `at` which work is done, or have been put down there."""
        goods, listed = self.model.tasks.goods, []
        if isinstance(goods, tuple):
            listed = sorted(goods, key=lambda good: getattr(good, "release", 0.0))
        tasks = set()
        for row in self.rows:
            if row[1] == "released":
                own = getattr(listed[row[3]], "to", None) if listed else None
                nodes = self.run.layout.nodes_of(own) if own else self.model.tasks.unload_at
                tasks |= {row[3]} if set(nodes) <= at.keys() else set()
            elif row[1] == "delivered" and for_workers(row, at):
                tasks.add(row[3])
        return tasks

    def work(self):
        """By stepping through the rows: who waits and who is at work at each node, from one row to the next."""
        at = workplaces(self.run)
        waiting, busy = dict.fromkeys(at, 0), dict.fromkeys(at, 0)
        waited = used = worked = put = 0
        ends = {}
        before, due = 0.0, self.due()
        for time, kind, _, task, node, edge, *_ in [*self.rows, (self.end, "end", 0, 0, None, None)]:
            for place, spec in at.items():
                waited += waiting[place] * self.within(before, time)
                stretches = self.model.hours(spec.hours).between(max(before, self.begin), time) if busy[place] else ()
                used += busy[place] * sum(end - start for start, end in stretches)
            before = time
            if node not in at or kind not in {"delivered", "working", "worked"} or edge is not None:
                continue
            put += kind == "delivered"
            waiting[node] += {"delivered": 1, "working": -1, "worked": 0}[kind]
            busy[node] += {"delivered": 0, "working": 1, "worked": -1}[kind]
            if kind == "worked":
                worked += time >= self.begin
                ends[task] = time
        late, met = self.late(due, ends, self.bound_for(at)) if at else ([], 0)
        of_due = {"worked_on_time": met / len(late), "loads_due": len(late)} if late else {}
        if not put:
            return of_due
        open_time = sum(
            spec.workers * self.model.hours(spec.hours).share(self.begin, self.end) * (self.end - self.begin)
            for spec in at.values()
        )
        return {
            "worked": worked,
            **of_due,
            "worker_utilisation": used / open_time if open_time else math.nan,
            "worker_wait": waited,
            "work_backlog": sum(waiting.values()) + sum(busy.values()),
        }

    def ended_with_its_work(self):
        length, asked = self.model.run.length, self.tasks()["backlog"]
        return not asked and (length is None or self.end < length)

    def tasks(self):
        released = {row[3]: row[0] for row in self.rows if row[1] == "released"}
        delivered = done(self.run)
        counted = {task: time for task, time in delivered.items() if time >= self.begin}
        times = [time - released[task] for task, time in counted.items()]
        due = self.due()
        late, met = self.late(due, delivered, released)
        indicators = {
            "cycle_time_mean": statistics.fmean(times) if times else math.nan,
            "cycle_time_median": statistics.median(times) if times else math.nan,
            "cycle_time_p95": float(np.quantile(times, 0.95)) if times else math.nan,
            "backlog": len(released) - len(delivered),
        }
        flows = [getattr(flow, "arrivals", None) for flow in self.model.tasks.flows.values()]
        if any(hasattr(one, key) for one in (self.model.tasks.goods, *flows) for key in ("poisson", "profile")):
            hours = (self.end - self.begin) / self.model.units.hour
            growth = sum(time >= self.begin for time in released.values()) - len(counted)
            indicators["backlog_growth_per_hour"] = growth / hours if hours else math.nan
        if late:
            indicators |= {"tardiness_mean": statistics.fmean(late), "on_time": met / len(late)}
            indicators["tasks_due"] = len(late)
        return indicators | self.lead(due, released, delivered)

    # All of it

    def kpis(self):
        total = {
            name: math.fsum(robot[name] for robot in self.robots)
            for name in (
                *STATES,
                "waiting",
                *APART,
                "encounters",
                "distance",
                "energy",
                "moves",
                "rear_ends",
                "crossings",
                "delivered",
            )
        }
        collisions = total["rear_ends"] + total["crossings"]
        counted = self.end - self.begin
        weights, hours = self.model.cost, counted / self.model.units.hour
        time = counted * self.size
        return {
            "T": self.end if self.model.tasks.never_end or self.ended_with_its_work() else math.nan,
            "S": collisions,
            "C": sum(robot["recharged"] for robot in self.robots),
            "tasks": total["delivered"],
            "moves": total["moves"],
            "distance": total["distance"],
            "energy": total["energy"],
            "waiting": total["waiting"],
            "cost": total["distance"] * weights.distance + counted * weights.time + collisions * weights.collisions,
            "rear_ends": total["rear_ends"],
            "crossings": total["crossings"],
            "rotations": self.rotations,
            "throughput_per_hour": total["delivered"] / hours if hours else math.nan,
            **self.tasks(),
            **self.work(),
            **self.energy(),
            **self.utilisation(),
            **self.trips(),
            **(self.orders() if self.run.record.orders else {}),
            **(self.pods(total) if self.model.pods else {}),
            **(self.pickers() if self.model.pickers else {}),
            **self.breakdowns(),
            **({"station_wait": self.queued["server"]} if self.layout.stations else {}),
            **{
                f"share_{state}": total[state] / time if time else math.nan
                for state in (*STATES, "waiting", *APART)
                if state not in self.absent
            },
            **{name: total[name] for name in APART},
            **({"lift_utilisation": self.lifts(total)} if self.layout.lifts else {}),
            **(self.encounters(total, hours) if self.model.people else {}),
            **(self.spread() if self.model.people else {}),
        }

    def lifts(self, total):
        """Beside the calls and rides of robots a lift is taken while they drive in and out, and the doors close."""
        drive = 2 * self.model.fleet.contact / self.model.fleet.fastest
        own, usual = dict(self.model.traffic.node_times), self.model.traffic.node_time
        taken = total["in_lift"]
        for lift in self.model.layout.lifts.values():
            for number in range(1, lift.cabins + 1):
                nodes = [node if number == 1 else f"{node} {number}" for node in lift.nodes]
                for a, b in permutations(nodes, 2):
                    each = drive + lift.doors + own.get(a, usual) + own.get(b, usual)
                    taken += self.edges[a, b]["passages"] * each
        time = (self.end - self.begin) * sum(lift.cabins for lift in self.model.layout.lifts.values())
        return taken / time if time else math.nan

    def orders(self):
        """Orders without due times: from the release of the first line until the last is done."""
        released = {row[3]: row[0] for row in self.rows if row[1] == "released"}
        ends = done(self.run)
        lines = defaultdict(list)
        for task, order in self.run.record.orders.items():
            lines[self.run.record.flows[task], order].append(task)
        whole = [tasks for tasks in lines.values() if all(task in ends for task in tasks)]
        times = [
            max(ends[task] for task in tasks) - min(released[task] for task in tasks)
            for tasks in whole
            if max(ends[task] for task in tasks) >= self.begin
        ]
        return {
            "orders": len(times),
            "order_cycle_time_mean": statistics.fmean(times) if times else math.nan,
            "order_cycle_time_p95": float(np.quantile(times, 0.95)) if times else math.nan,
        }

    def pods(self, total):
        """A picker is at work while a robot in a station is unloading."""
        stored = sum(row[1] == "stored" and row[0] >= self.begin for row in self.rows)
        picks, inside, since = 0.0, set(), {}
        for time, kind, robot, *_ in [*self.rows, *((self.end, "idle", robot) for robot in range(self.size))]:
            if kind in {"docked", "enter"}:
                (inside.add if kind == "docked" else inside.discard)(robot)
            elif kind in STATES:
                picks += self.within(since.pop(robot, time), time)
                if kind == "unloading" and robot in inside:
                    since[robot] = time
                elif kind == "loaded":
                    inside.discard(robot)
        stations = self.layout.stations.values()
        hours = [self.model.hours(self.model.layout.stations[item.zone].hours) for item in stations]
        open_time = sum(
            item.servers * some.share(self.begin, self.end) * (self.end - self.begin)
            for item, some in zip(stations, hours, strict=True)
        )
        done_in_it = total["delivered"]
        return {
            "pod_visits": stored,
            "pile_on": done_in_it / stored if stored else math.nan,
            "station_idle": 1 - picks / open_time if open_time else math.nan,
            "distance_per_task": total["distance"] / done_in_it if done_in_it else math.nan,
        }

    def pickers(self):
        """A picker walks as long as his row says, and picks until the robot goes on or has delivered."""
        spec, spans = self.model.pickers, {"walking": [], "picking": []}
        picked, lines = {}, 0
        for time, kind, robot, *_, until, _ in [
            *self.rows,
            *((self.end, "idle", robot, 0, 0) for robot in range(self.size)),
        ]:
            if kind in {*STATES, "delivered"} and robot in picked:
                spans["picking"].append((picked.pop(robot), time))
            if kind == "walking":
                spans[kind].append((time, until))
            elif kind == "picking":
                picked[robot] = time
                lines += self.begin <= until <= self.end
        hours = self.model.hours(spec.hours)
        whole = spec.count * hours.share(self.begin, self.end) * (self.end - self.begin)
        worked = {
            kind: sum(
                max(min(end, last, self.end) - max(start, first, self.begin), 0.0)
                for start, end in some
                for first, last in hours.between(start, end)
            )
            for kind, some in spans.items()
        }
        return {
            "picker_utilisation": worked["picking"] / whole if whole else math.nan,
            "picker_walking": worked["walking"] / whole if whole else math.nan,
            "lines_per_picker": lines * self.model.units.hour / whole if whole else math.nan,
        }

    def spread(self):
        released = {row[3]: row[0] for row in self.rows if row[1] == "released"}
        times = [time - released[task] for task, time in done(self.run).items() if time >= self.begin]
        return {"cycle_time_cv": float(np.std(times, ddof=1) / np.mean(times)) if len(times) > 1 else math.nan}

    def encounters(self, total, hours):
        time = self.people["time"]
        return {
            "encounters_per_hour": total["encounters"] / hours if hours else math.nan,
            "shared_time": self.people["shared"] / time if time else math.nan,
        }


def differences(run):
    """Where the indicators and tallies of a run are not those of its log: a line each; none: all is right."""
    recount = Recount(run)
    lines = compare("kpis", run.kpis, recount.kpis(), run)
    for number, tally in enumerate(run.record.robots):
        lines += compare(f"robots[{number}]", tally, recount.robots[number], run)
    for row in run.record.edges:
        lines += compare(f"edges[{row['edge']}]", row, recount.edges[tuple(row["edge"].split(">"))], run, ("edge",))
    for row in run.record.nodes:
        first = row["node"].split("+")[0]
        lines += compare(f"nodes[{row['node']}]", row, recount.nodes[first], run, ("node", "passages"))
    shares = [value for key, value in run.kpis.items() if key.startswith("share_")]
    if not all(math.isnan(share) for share in shares):
        lines += [f"a share is {share}" for share in shares if not -1e-9 <= share <= 1 + 1e-9]
        if abs(sum(shares) - 1) > 1e-9:
            lines.append(f"shares add up to {sum(shares)}")
    return lines


def compare(place, told, counted, run, leave_out=()):
    """Times are the same within a millionth for every event; counts exactly."""
    lines = []
    for name, value in told.items():
        if name in leave_out or ":" in name:  # of a flow: that they are those of its tasks is shown in test_flows.py
            continue
        other = counted[name]
        if isinstance(value, int) and isinstance(other, int):
            same = value == other
        else:
            same = math.isclose(value, other, rel_tol=1e-6, abs_tol=1e-6) or (math.isnan(value) and math.isnan(other))
        if not same:
            lines.append(f"{place}.{name} is {value}, by the log {other}")
    return lines
