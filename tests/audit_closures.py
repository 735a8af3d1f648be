"""The part of the auditor for edges that are closed, slow, or have people in them."""

import math
from collections import defaultdict
from dataclasses import dataclass

from desim_warehouse.states import STATES

TOL = 1e-6


@dataclass
class Shut:
    """Edges that no robot enters from `begin` to `end`, except from another of these edges."""

    edges: frozenset
    begin: float
    end: float
    person: bool = False


class Closures:
    """Checks of closures, slow zones and people, for `Audit`, which knows where robots were."""

    def members(self, spec):
        edges = set()
        for member in spec.members:
            edges |= (
                set(self.graph.in_edges(member)) if isinstance(member, str) else {tuple(member), tuple(member)[::-1]}
            )
        return frozenset(edges)

    def slow_limit(self, edge, since, until):
        """Return the limit of slow zones that was in force from when a robot set out for an edge to `until`."""
        limit = math.inf
        for spec in self.run.model.traffic.slow.values():
            if edge in self.members(spec):
                hours = None if spec.hours is None else self.run.model.hours(spec.hours)
                if hours is None or (hours.is_open(since) and hours.changes(since) > until):
                    limit = min(limit, spec.speed)
        return limit

    def shut(self):
        """Yield all closures of edges, by calendars and by people."""
        model, end = self.run.model, self.run.record.end
        for spec in model.traffic.closures.values():
            hours, edges = model.hours(spec.hours), self.members(spec)
            begin, until = hours.following(0.0)
            while begin <= end:
                yield Shut(edges, begin, until)
                if math.isinf(until):
                    break
                begin, until = hours.following(until)
        people = defaultdict(lambda: Shut(frozenset(), math.inf, math.inf, person=True))
        for time, kind, _, _, _, edge, value, *_ in self.run.record.rows:
            if kind == "person_in":
                people[value] = Shut(people[value].edges | {edge}, time, math.inf, person=True)
            elif kind == "person_out":
                people[value].end = time
        yield from people.values()

    def check_closures(self):
        """No robot enters a closed edge, unless it comes from within or was past its stop line when the edge closed."""
        by_edge = defaultdict(list)
        for shut in self.shut():
            for edge in shut.edges:
                by_edge[edge].append(shut)
        if not by_edge:
            return
        waits = defaultdict(list)
        for time, kind, robot, _, node, *_ in self.run.record.rows:
            if kind in {"collision", "waiting_closed", "waiting_person"} and node is not None:
                waits[robot].append(time)
        for robot, visits in self.visits.items():
            for rank, visit in enumerate(visits):
                for shut in by_edge[visit.edge]:
                    begin = shut.begin + self.start_time  # a robot that was let in may still brake or gather speed
                    set_out = visit.enter - self.delays.get((robot, visit.edge, visit.enter), 0.0)
                    if not begin + TOL < set_out < shut.end - TOL:
                        continue
                    if self.comes_from_within(visits[:rank], shut):
                        continue
                    waited = any(begin + TOL < end <= visit.enter + TOL for end in waits[robot])
                    repaired = self.was_broken(robot, shut.begin, visit.enter)
                    let_in = not waited and (repaired or self.was_let_in(visits[:rank], begin))
                    if not let_in and not self.stepped_aside(robot, shut, by_edge[visit.edge], visit.enter):
                        self.fault(visit.enter, f"robot {robot} enters {visit.edge}, which is closed")

    def stepped_aside(self, robot, shut, others, enter):
        """Whether people who give way let a robot pass because it waited for them long enough."""
        after = [one.give_way.after for one in self.run.model.people.values() if one.give_way is not None]
        if not after or not shut.person:
            return False
        begin = shut.begin
        for other in sorted((one for one in others if one.person), key=lambda one: -one.begin):
            if other.begin < begin <= other.end:  # another person was there before
                begin = other.begin
        since = left = -math.inf  # its consecutive waits: first behind other robots, then for people
        for time, kind, number, _, node, _, value, *_ in self.run.record.rows:
            if number == robot and node is not None and kind in {"waiting_person", "waiting_closed", "collision"}:
                since, left = since if abs(time - value - left) < TOL else time - value, time
                if time <= enter + TOL and time - max(since, begin) >= min(after) - TOL:
                    return True
        return False

    def check_held(self):
        """No task on a closed edge is given out, unless another closure is in force when the edge opens."""
        closures = self.run.model.traffic.closures.values()
        held = [(self.members(spec), self.run.model.hours(spec.hours)) for spec in closures if spec.tasks == "hold"]
        goods = {row[3]: int(row[6]) for row in self.run.record.rows if row[1] == "released"}
        for time, kind, robot, task, *_ in self.run.record.rows if held else ():
            if kind != "assigned" or goods[task] < 0:
                continue
            edge = self.run.layout.storage[goods[task]].edge
            for edges, hours in held:
                if not {edge, edge[::-1]} & self.graph.edges.keys() <= edges:
                    continue
                begin, until = hours.following(time)
                shut = begin + TOL < time < until - TOL
                if shut and not any(others.is_open(until + TOL) for _, others in held):
                    self.fault(time, f"robot {robot} is given task {task} on {edge}, which is closed")

    def was_broken(self, robot, begin, enter):
        """Whether a robot was broken down from when an edge closed until it entered, and so had been let in before."""
        since = None
        for time, kind, number, *_ in self.run.record.rows:
            if number != robot or kind not in STATES:
                continue
            if kind == "broken":
                since = time if since is None else since
            elif since is not None and time > since:
                if since - TOL <= begin <= time + TOL and 0 <= enter - time <= self.start_time + TOL:
                    return True
                since = None
        return False

    def comes_from_within(self, visits, shut):
        """Whether a robot comes from another edge of the closure, edges within an intersection apart."""
        of = self.joined()
        for visit in reversed(visits):
            if visit.into_bay or visit.edge in shut.edges:
                return not visit.into_bay
            if of[visit.edge[0]] != of[visit.edge[1]]:
                return False
        return False

    def was_let_in(self, visits, time):
        """Whether a robot was past its last possible stand at a time: within D of the node, or on short edges.

        In a zone for one robot, no edge is a stand, however long.
        """
        inside = self.closed()
        for visit in reversed(visits):
            length = self.graph.edges[visit.edge]["length"]
            if visit.into_bay:
                return False
            if visit.enter <= time + TOL and visit.at(time) >= length - self.contact - self.slack:
                return True
            if not self.is_below(length, 2 * self.contact) and visit.edge not in inside:
                return False
            if visit.enter <= time + TOL:
                return True
        return False
