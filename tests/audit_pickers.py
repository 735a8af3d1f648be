"""The part of the auditor for pickers: where they are, and by whom, when and where each load is handled."""

import math
from collections import Counter, defaultdict

import networkx as nx

TOL, ROUNDING = 1e-6, 1e-14


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
        """Each picker does one thing at a time, starts where he was, and walks at his speed, in his hours and zone."""
        free, place, mine = defaultdict(float), {}, {}
        zone_of = {}
        places_at = Counter((place.edge, place.offset) for place in self.run.layout.storage)
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
                far = self.on_foot(place[number], spot) if number in place else (until - time) * spec.speed
                if abs((until - time) * spec.speed - far) > TOL + spec.speed * (1 + until) * ROUNDING:
                    self.fault(time, f"picker {number} walks from {place[number]} to {spot} in {until - time:g}")
                stays = spec.stay == "order" and mine.get(number) == robot
                if not stays and not hours.is_open(time) and not hours.is_open(time + TOL):
                    self.fault(time, f"picker {number} sets out for robot {robot} outside his hours")
            alone = places_at[spot] < 2  # of places at one spot, zones may get one each
            if alone and zone_of.setdefault(spot, number % spec.zones) != number % spec.zones:
                self.fault(time, f"picker {number} is at {spot}, in the zone of others")
            free[number], place[number], mine[number] = until, spot, robot

    def on_foot(self, start, goal):
        """Return the shortest distance on foot along the lanes, by a graph in which both spots are nodes."""
        one_aisle = set(start[0]) == set(goal[0])
        lengths = {self.graph.edges[edge]["length"] for edge, _ in (start, goal) if edge[0] != edge[1]}
        if one_aisle and (len(lengths) < 2 or max(lengths) - min(lengths) < TOL * max(lengths)):
            return abs(self.from_first(*start) - self.from_first(*goal))
        ways = self.streets.copy()
        for name, (edge, offset) in (("start", start), ("goal", goal)):
            ways.add_edge(name, edge[0], weight=offset)
            if edge[0] != edge[1]:
                ways.add_edge(name, edge[1], weight=self.graph.edges[edge]["length"] - offset)
        return nx.shortest_path_length(ways, "start", "goal", weight="weight")

    def from_first(self, edge, offset):
        """Return the distance of a spot from the end of its aisle that comes first by name."""
        return offset if edge[0] <= edge[1] else self.graph.edges[edge]["length"] - offset

    # What they handle

    def check_picks(self, spec):
        """Each load at a storage place is handled there by one picker, while the robot loads or unloads."""
        spots = self.run.layout.storage
        places = {row[3]: spots[int(row[6])] for row in self.rows if row[1] == "released" and row[6] >= 0}
        stored = {task: (place.edge, place.offset) for task, place in places.items()}
        served = {row[3] for row in self.rows if row[1] == "released" and self.serves(spec, row[3])}
        picks = defaultdict(list)
        for time, robot, task, edge, offset, act in self.picks():
            picks[task].append((time, robot))
            place = stored.get(task) if act == "loading" else (edge, offset)
            if (edge, offset) != place or not any((spot.edge, spot.offset) == place for spot in spots):
                self.fault(time, f"task {task} is picked at {edge}, {offset:g}, and is at {place}")
            if task not in served:
                self.fault(time, f"task {task} needs no picker")
        for time, kind, robot, task, *_ in self.rows:
            if kind == "loading" and task in stored.keys() & served and (time, robot) not in picks[task]:
                self.fault(time, f"robot {robot} loads task {task} by itself")
        put = {row[3] for row in self.rows if row[1] == "delivered" and row[5] is not None} & served
        for task, times in picks.items():
            if len(times) > 2 and not self.stops_in_storage():
                self.fault(times[-1][0], f"task {task} is picked {len(times)} times")
        for task in put:
            if len(picks[task]) < 1 + (task in stored):
                self.fault(self.run.record.end, f"task {task} was put away by nobody")

    def picks(self):
        """Return all picks as time, robot, task, edge, offset and act; a robot continues when its pick is done."""
        doing, due, picks = {}, {}, []
        for time, kind, robot, task, _, edge, offset, until, _ in self.rows:
            if kind == "picking":
                due[robot] = until
                act, since = doing[robot]
                if act not in {"loading", "unloading"} or since != time:
                    self.fault(time, f"robot {robot} is picked while {act}")
                picks.append((time, robot, task, edge, offset, act))
            elif kind in self.run.record.robots[0]:
                if abs(due.pop(robot, time) - time) > self.delay:
                    self.fault(time, f"robot {robot} goes on before, or after, it is picked")
                doing[robot] = kind, time
        return picks

    def stops_in_storage(self):
        """Whether tasks from files may have stops at storage places on their way."""
        return any("orders" in type(flow.when).model_fields for flow in self.run.model.tasks.flows.values())

    def serves(self, spec, task):
        flow = self.run.record.flows.get(task, "")
        return not spec.flows or flow in spec.flows

    # Whom they leave waiting

    def check_calls(self, spec):
        """No robot waits at a place without a picker on his way while a picker is free in his hours."""
        if spec.zones > 1 or spec.stay == "order":
            return
        hours, busy = self.run.model.hours(spec.hours), defaultdict(list)
        for time, kind, *_, until, number in self.rows:
            if kind in {"walking", "picking"}:
                busy[number].append((time, until))
        for robot, begin, until in self.alone():
            for first, last in hours.between(begin, until):
                gap = max(idle(busy[number], first, last) for number in range(spec.count))
                if gap > self.delay * 10:
                    self.fault(begin, f"robot {robot} waits for {gap:g} while a picker is free")

    def alone(self):
        """Return the waits of robots at a place to which no picker was sent, as robot, begin and end."""
        since, sent, waits = {}, defaultdict(list), []
        for time, kind, robot, *_ in [
            *self.rows,
            *((self.run.record.end, "loading", one) for one in range(len(self.robots))),
        ]:
            if kind == "walking":
                sent[robot].append(time)
            elif kind == "awaiting_picker":
                since[robot] = time
            elif kind in {"loading", "unloading"} and robot in since:
                begin = since.pop(robot)
                if not any(time <= begin and self.on_way(robot, time, begin) for time in sent[robot]):
                    waits.append((robot, begin, min([time, *(one for one in sent[robot] if one >= begin)])))
        return waits

    def on_way(self, robot, time, begin):
        """Whether the picker sent at a time was neither sent elsewhere nor done before the robot came at `begin`."""
        row = next(row for row in self.rows if row[1] == "walking" and row[2] == robot and row[0] == time)
        later = [one for one in self.rows if one[1] == "walking" and one[8] == row[8] and row[0] < one[0] <= begin]
        picked = [one for one in self.rows if one[1] == "picking" and one[2:4] == row[2:4] and row[0] <= one[0] < begin]
        return not later and not picked


def idle(spans, begin, end):
    """Return the longest time within an interval that none of some spans covers."""
    now, longest = begin, 0.0
    for start, until in sorted(spans):
        if until <= now:
            continue
        if start >= end:
            break
        longest = max(longest, start - now)
        now = max(now, until)
    return max(longest, min(end, math.inf) - now) if now < end else longest
