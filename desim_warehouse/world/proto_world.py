"""Trial assembly for measuring (to be replaced by world.py)."""
from __future__ import annotations
import math
import networkx as nx
import simpy
from simpy.events import Timeout, Event
from desim_warehouse.layout import build
from desim_warehouse.log import Log
from desim_warehouse.world.body import Body
from desim_warehouse.world.battery import Battery
from desim_warehouse.world.traffic import Traffic


class Robot(Body):
    def __init__(self, world, number, home):
        m = world.model
        super().__init__(number, m.fleet.robot.speed, m.fleet.robot.radius + m.fleet.robot.margin / 2, world.traffic.nodes[home])
        self.world = world
        self.home = home
        self.battery = Battery(m.battery.capacity)
        self.good = None
        self.idle = None
        self.committed = False
        self.outing = 0

    def low(self, outing):
        if outing != self.outing or self.good is None or self.committed: return
        place = self.world.layout.storage[self.good]
        if self.lane is not None and (self.lane.edge == place.edge or (self.lane.edge[1] == place.edge[0] and self.pos >= self.lane.length)):
            return
        self.world.goods.insert(0, self.good); self.good = None
        self.world.poke()

    def life(self):
        w = self.world; m = w.model; env = w.env; b = self.battery
        first = True
        while True:
            while not w.goods:
                if w.done == w.total: return
                self.idle = Event(env); yield self.idle
            if not first: w.C += 1
            self.good = w.goods.pop(0)
            b.draw(env.now, m.battery.consumption)
            self.outing += 1; outing = self.outing; self.committed = False
            self.recall_at = env.now + b.time_to(env.now, m.battery.threshold)
            Timeout(env, b.time_to(env.now, m.battery.threshold)).callbacks.append(lambda _, o=outing: self.low(o))
            yield Timeout(env, m.fleet.first_exit_time if first else m.fleet.exit_time)
            first = False
            at = self.home
            while self.good is not None:
                place = w.layout.storage[self.good]
                ok = yield from w.traffic.drive(self, [*w.path(at, place.edge[0]), w.traffic.lanes[place.edge]], place.offset)
                if not ok: break
                self.committed = True; rec = self.recall_at; self.recall_at = math.inf
                yield Timeout(env, m.tasks.load_time)
                u = m.tasks.unload_at[0]
                yield from w.traffic.drive(self, w.path(place.edge[1], u))
                yield Timeout(env, m.tasks.unload_time)
                w.done += 1
                self.committed = False; self.recall_at = rec
                at = u
                self.good = w.goods.pop(0) if w.goods and b.level(env.now) > m.battery.threshold else None
                if w.done == w.total: w.poke()
                yield Timeout(env, m.tasks.clear_time)
            self.recall_at = math.inf
            at = self.lane.edge[1]
            yield from w.traffic.drive(self, w.path(at, self.home))
            w.traffic.into_bay(self)
            w.T = max(w.T, env.now)
            yield Timeout(env, (m.battery.capacity - b.level(env.now)) / m.battery.charge_rate)
            b.fill(env.now, m.battery.capacity)


class World:
    def __init__(self, model, variant=None):
        self.model = model
        self.env = simpy.Environment()
        self.layout = build(model.layout)
        self.log = Log(model.log)
        r = model.fleet.robot
        self.traffic = Traffic(self.env, self.layout, self.log, contact=2 * r.radius + r.margin, theta=math.radians(model.traffic.collision_angle), node_time=model.traffic.node_time)
        self.goods = list(model.tasks.goods); self.total = len(self.goods); self.done = 0; self.C = 0; self.T = 0.0
        start = model.fleet.start
        self.robots = [Robot(self, i, start[i % len(start)]) for i in range(model.fleet.size)]
        self.cache = {}

    def path(self, a, b):
        p = self.cache.get((a, b))
        if p is None:
            names = nx.single_source_shortest_path(self.layout.graph, a)[b]
            p = self.cache[a, b] = [self.traffic.lanes[e] for e in zip(names, names[1:])]
        return p

    def poke(self):
        for r in self.robots:
            if r.idle is not None:
                e = r.idle; r.idle = None; e.succeed()

    def run(self):
        for r in self.robots: self.env.process(r.life())
        self.env.run()
        return self

    @property
    def S(self): return sum(r.rear_ends + r.crossings for r in self.robots)
