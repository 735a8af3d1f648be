"""The part of the auditor that looks at pickers: where they are, by whom, when and where each load is handled."""

import math
from collections import defaultdict

import networkx as nx

TOL = 1e-6


class Pickers:
    """Checks of people who pick into robots at storage places, for `Audit`."""

    def check_pickers(self):
        spec = self.run.model.pickers
        acts = [row for row in self.rows if row[1] in {"walking", "picking"}]
        if spec is None:
            for time, kind, *_ in acts:
                self.fault(time, f"a picker is {kind}, and there are none")
            return
        self.streets = nx.Graph()
        for a, b, length in self.graph.edges(data="length"):
            if not self.streets.has_edge(a, b) or self.streets.edges[a, b]["weight"] > length:
                self.streets.add_edge(a, b, weight=length)
        self.check_ways(spec, acts)
        self.check_picks(spec)
        self.check_calls(spec)

    # Where pickers are

    def check_ways(self, spec, acts):
        """Each does one thing at a time, begins where he was, walks at his speed, in his hours, and in his zone."""
        free, place, mine = defaultdict(float), {}, {}
        zone_of = {}
        hours = self.run.model.hours(spec.hours)
        for time, kind, robot, _, _, edge, offset, until, number in acts:
            spot = edge, offset
            if not 0 <= number < spec.count:
                self.fault(time, f"there is no picker {number}")
            if time < free[number] - self.delay:
                self.fault(time, f"picker {number} is {kind} and not yet done with what he did until {free[number]:g}")
            if kind == "picking" and place.get(number) != spot:
                self.fault(time, f"picker {number} picks at {spot}, and is at {place.get(number)}")
            if kind == "walking":
                if number in place and abs((until - time) * spec.speed - self.on_foot(place[number], spot)) > TOL:
                    self.fault(time, f"picker {number} walks from {place[number]} to {spot} in {until - time:g}")
                stays = spec.stay == "order" and mine.get(number) == robot
                if not stays and not hours.is_open(time) and not hours.is_open(time + TOL):
                    self.fault(time, f"picker {number} sets out for robot {robot} outside his hours")
            if zone_of.setdefault(spot, number % spec.zones) != number % spec.zones:
                self.fault(time, f"picker {number} is at {spot}, in the zone of others")
            free[number], place[number], mine[number] = until, spot, robot

    def on_foot(self, start, goal):
        """The shortest way along the lanes, as a graph with both spots as nodes of it."""
        if set(start[0]) == set(goal[0]):
            return abs(self.from_first(*start) - self.from_first(*goal))
        ways = self.streets.copy()
        for name, (edge, offset) in (("start", start), ("goal", goal)):
            ways.add_edge(name, edge[0], weight=offset)
            if edge[0] != edge[1]:
                ways.add_edge(name, edge[1], weight=self.graph.edges[edge]["length"] - offset)
        return nx.shortest_path_length(ways, "start", "goal", weight="weight")

    def from_first(self, edge, offset):
        """How far a spot is from the end of its aisle that is first by name."""
        return offset if edge[0] <= edge[1] else self.graph.edges[edge]["length"] - offset

    # What they handle

    def check_picks(self, spec):
        """Each load at a storage place is handled by one picker, while the robot loads or unloads, where it stands."""
        stored = {row[3] for row in self.rows if row[1] == "released" and row[6] >= 0}
        served = {row[3] for row in self.rows if row[1] == "released" and self.serves(spec, row[3])}
        spots = self.run.layout.storage
        places = {row[3]: spots[int(row[6])] for row in self.rows if row[1] == "released" and row[6] >= 0}
        places = {task: (place.edge, place.offset) for task, place in places.items()}
        doing, begun, loads = {}, {}, []
        for time, kind, robot, task, node, edge, value, until, _ in self.rows:
            if kind in self.run.record.robots[0] and kind != "waiting":
                was = doing.get(robot)
                if was is not None and was[0] == "awaiting_picker" and kind == "empty" and spec.stay == "pick":
                    self.fault(time, f"robot {robot} goes on without a picker")
                if robot in begun and abs(begun[robot] - time) > self.delay:
                    self.fault(time, f"robot {robot} is picked until {begun[robot]:g}, and goes on")
                begun.pop(robot, None)
                doing[robot] = kind, time
                if kind == "loading" and task in stored & served:
                    loads.append((time, robot, task))
            elif kind == "picking":
                begun[robot] = until
                if doing[robot][0] not in {"loading", "unloading"} or doing[robot][1] != time:
                    self.fault(time, f"robot {robot} is picked while {doing[robot]}")
                if task not in served:
                    self.fault(time, f"task {task} needs no picker")
                place = places.get(task) if doing[robot][0] == "loading" else (edge, value)
                if (edge, value) != place or not any((one.edge, one.offset) == place for one in spots):
                    self.fault(time, f"task {task} is picked at {edge}, {value:g}, and is at {place}")
        picks = defaultdict(list)
        for row in self.rows:
            if row[1] == "picking":
                picks[row[3]].append((row[0], row[2]))
        for time, robot, task in loads:
            if (time, robot) not in picks[task]:
                self.fault(time, f"robot {robot} loads task {task} by itself")
        ends = {row[3] for row in self.rows if row[1] == "delivered" and row[5] is not None}
        for task, times in picks.items():
            if len(times) > (task in stored) + (task in ends or task not in stored) and not self.stops_in_storage():
                self.fault(times[-1][0], f"task {task} is picked {len(times)} times")
        for task in ends & served:
            if len(picks[task]) < 1 + (task in stored):
                self.fault(self.run.record.end, f"task {task} was put away by nobody")

    def stops_in_storage(self):
        """Whether rows of files may have stops at storage places on their way."""
        return any("orders" in type(flow.when).model_fields for flow in self.run.model.tasks.flows.values())

    def serves(self, spec, task):
        flow = self.run.record.flows.get(task, "")
        return not spec.flows or flow in spec.flows

    # Whom they leave waiting

    def check_calls(self, spec):
        """No robot waits at a place with nobody sent while a picker of its zone stands free in his hours."""
        if spec.zones > 1 or spec.stay == "order":
            return
        hours, end = self.run.model.hours(spec.hours), self.run.record.end
        busy, waits, since, sent = defaultdict(list), [], {}, defaultdict(list)
        for time, kind, robot, *_, until, number in self.rows:
            if kind == "walking":
                sent[robot].append(time)
            if kind in {"walking", "picking"}:
                busy[number].append((time, until))
            elif kind == "awaiting_picker":
                since[robot] = time
            elif kind in {"loading", "unloading"} and robot in since:
                waits.append((robot, since.pop(robot), time))
        waits += [(robot, begin, end) for robot, begin in since.items()]
        for robot, begin, until in waits:
            alone = min([until, *(time for time in sent[robot] if begin <= time <= until)])
            if any(begin - TOL <= time <= until for time in sent[robot]) and alone <= begin:
                continue
            if any(time <= begin and self.on_way(robot, time, begin) for time in sent[robot]):
                continue  # one was sent ahead
            for first, last in hours.between(begin, alone):
                for number in range(spec.count):
                    gap = idle(busy[number], first, last)
                    if gap > self.delay * 10:
                        self.fault(begin, f"robot {robot} waits for {gap:g} while picker {number} is free")

    def on_way(self, robot, time, begin):
        """Whether the picker sent at a time was not sent elsewhere before the robot came."""
        row = next(row for row in self.rows if row[1] == "walking" and row[2] == robot and row[0] == time)
        later = [one for one in self.rows if one[1] == "walking" and one[8] == row[8] and row[0] < one[0] <= begin]
        picked = [one for one in self.rows if one[1] == "picking" and one[2] == robot and row[0] <= one[0] < begin]
        return not later and not picked


def idle(spans, begin, end):
    """The longest time within an interval in which none of some spans is under way."""
    now, longest = begin, 0.0
    for start, until in sorted(spans):
        if until <= now:
            continue
        if start >= end:
            break
        longest = max(longest, start - now)
        now = max(now, until)
    return max(longest, min(end, math.inf) - now) if now < end else longest
