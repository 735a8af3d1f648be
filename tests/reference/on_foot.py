"""Pick-assist once more, without lanes: robots pass through each other, so nothing but pickers holds them up.

It shares no code with the simulator. Robots always have an order of one to four lines. They drive to the first place,
and then always to the nearest of the others, wait at each for the nearest picker who is free, and bring all to the
nearest station.
"""

import heapq
import itertools
import random

import networkx as nx

from desim_warehouse.values.distributions import mean_of


class Floor:
    """Distances by lanes, which robots drive forwards only and people walk both ways."""

    def __init__(self, layout):
        roads = nx.DiGraph()
        roads.add_weighted_edges_from(layout.graph.edges(data="length"))
        self.by_road = dict(nx.all_pairs_dijkstra_path_length(roads))
        self.on_foot = dict(nx.all_pairs_dijkstra_path_length(roads.to_undirected()))
        self.length = {(a, b): length for a, b, length in layout.graph.edges(data="length")}
        self.places = [(place.edge, place.offset) for place in layout.storage]
        self.stations = list(layout.stations)

    def drive(self, start, goal):
        """From a place, or a node with no offset, to another."""
        if start[0] == goal[0] and goal[1] >= start[1]:
            return goal[1] - start[1]
        out = 0.0 if start[1] is None else self.length[start[0]] - start[1]
        node = start[0] if start[1] is None else start[0][1]
        end, beyond = (goal[0], 0.0) if goal[1] is None else (goal[0][0], goal[1])
        return out + self.by_road[node][end] + beyond

    def walk(self, start, goal):
        if start[0] == goal[0]:
            return abs(start[1] - goal[1])
        ends = [[(edge[0], offset), (edge[1], self.length[edge] - offset)] for edge, offset in (start, goal)]
        return min(near + self.on_foot[a][b] + far for (a, near), (b, far) in itertools.product(*ends))


class Hall:
    """A run of a model: `events` to come, pickers by where they are, and robots that wait for one."""

    def __init__(self, model, seed):
        self.floor, self.draw = Floor(model.floor), random.Random(f"on foot {seed}")
        self.speed, self.walking = model.fleet.robot.speed, model.pickers.speed
        self.pick, self.put = mean_of(model.tasks.load_time), mean_of(model.tasks.unload_time)
        self.events, self.numbers, self.now, self.lines = [], itertools.count(), 0.0, []
        self.pickers = [self.draw.choice(self.floor.places) for _ in range(model.pickers.count)]
        self.free, self.waiting = set(range(model.pickers.count)), []
        for _ in range(model.fleet.size):
            self.begin((self.draw.choice(self.floor.stations), None))

    def after(self, time, do, *what):
        heapq.heappush(self.events, (self.now + time, next(self.numbers), do, what))

    def begin(self, here):
        """Take the next order at a station."""
        left = [self.draw.choice(self.floor.places) for _ in range(self.draw.randint(1, 4))]
        tour = [left.pop(0)]
        while left:
            tour.append(min(left, key=lambda place: self.floor.drive(tour[-1], place)))
            left.remove(tour[-1])
        self.go(here, tour, len(tour))

    def go(self, here, tour, lines):
        """Drive to the next place of a tour, or to a station with all that was picked."""
        if tour:
            self.after(self.floor.drive(here, tour[0]) / self.speed, self.come, tour, lines)
            return
        end = min(((node, None) for node in self.floor.stations), key=lambda node: self.floor.drive(here, node))
        self.after(self.floor.drive(here, end) / self.speed + self.put * lines, self.begin, end)

    def come(self, tour, lines):
        self.waiting.append((tour, lines))
        self.meet()

    def picked(self, picker, tour, lines):
        self.lines.append(self.now)
        self.free.add(picker)
        self.go(tour[0], tour[1:], lines)
        self.meet()

    def meet(self):
        """The closest pair of a robot that waits and a picker who is free, as long as there are both."""
        while self.free and self.waiting:
            pairs = itertools.product(self.waiting, sorted(self.free))
            (tour, lines), picker = min(pairs, key=lambda pair: self.floor.walk(self.pickers[pair[1]], pair[0][0][0]))
            self.waiting.remove((tour, lines))
            self.free.remove(picker)
            far, self.pickers[picker] = self.floor.walk(self.pickers[picker], tour[0]), tour[0]
            self.after(far / self.walking + self.pick, self.picked, picker, tour, lines)

    def run(self, begin, end):
        """Lines in a time, for each unit of it."""
        while self.events[0][0] <= end:
            self.now, _, do, what = heapq.heappop(self.events)
            do(*what)
        return sum(time >= begin for time in self.lines) / (end - begin)
