"""The auditor of pods, which reads the rows of a log without any code of the world.

It follows the place and the content of every pod, and the orders at each station.
"""

from collections import Counter, defaultdict


def audit_pods(run):
    """Return the faults of a run with pods, as texts."""
    reader = Reader(run.model, run.history.log, run.history.layout)
    for row in run.history.rows("released", "assigned", "returned", "lifted", "docked", "delivered", "stored"):
        getattr(reader, row.kind)(row)
    reader.orders()
    reader.pickers()
    return reader.faults


class Reader:
    """Follow the rows of a run, in which each pod is on a place or carried by a robot."""

    def __init__(self, model, log, layout):
        self.pods, self.flows, self.log = model.pods, model.tasks.flows, log
        self.servers = {node: item.servers for node, item in layout.stations.items()}
        self.places = len(layout.storage)
        self.puts = {name for name, flow in self.flows.items() if not isinstance(flow.target, tuple)}
        self.item, self.robot_of, self.carried, self.place_of, self.pod_at, self.at = {}, {}, {}, {}, {}, {}
        self.net, self.holds = defaultdict(Counter), None
        if (file := model.pods.holds) is not None:
            self.holds = defaultdict(Counter)
            for row, pod in enumerate(file.pod):
                self.holds[pod][file.item[row]] += file.units[row] if file.units else model.pods.stock or 10**9
            self.place_of = dict(enumerate(file.places))
            self.pod_at = {place: pod for pod, place in self.place_of.items()}
        self.done = {}
        self.faults = []

    def expect(self, holds, row, text):
        if not holds:
            self.faults.append(f"{row.time:g}: {text} ({row.kind}, robot {row.robot}, task {row.task})")

    def released(self, row):
        self.item[row.task] = row.other
        self.expect(0 <= row.other < self.pods.items, row, f"no item {row.other}")

    def assigned(self, row):
        self.expect(row.task in self.item and row.task not in self.robot_of, row, "not open")
        self.robot_of[row.task] = row.robot

    def returned(self, row):
        self.expect(self.robot_of.pop(row.task, None) == row.robot, row, "given back by another")
        self.expect(row.robot not in self.carried, row, "given back with a pod in hand")

    def lifted(self, row):
        pod, place = int(row.value), row.other
        self.expect(row.robot not in self.carried, row, "carries a pod already")
        self.expect(pod not in self.carried.values(), row, f"pod {pod} is carried by another")
        self.expect(self.place_of.get(pod, place) == place, row, f"pod {pod} stands at {self.place_of.get(pod)}")
        self.expect(self.pod_at.pop(place, pod) == pod, row, f"another pod stands at {place}")
        self.expect(self.robot_of.get(row.task) == row.robot, row, "lifted for nobody")
        self.carried[row.robot] = pod

    def docked(self, row):
        self.at[row.robot] = row.node

    def delivered(self, row):
        flow = self.log.flows[row.task]
        self.expect(row.task not in self.done, row, "done twice")
        self.done[row.task] = row
        self.expect(self.robot_of.get(row.task) == row.robot, row, "another robot's line")
        self.expect(self.carried.get(row.robot) == row.other, row, f"pod {row.other} is not there")
        self.expect(self.at.get(row.robot) == row.node, row, "its robot is not in the station")
        nodes = self.flows[flow].source if flow in self.puts else self.flows[flow].target
        self.expect(row.node in nodes, row, f"its flow goes to {nodes}")
        net = self.net[row.other]
        net[self.item[row.task]] += self.pods.bundle if flow in self.puts else -1
        if self.holds is not None:
            there = self.holds[row.other]
            self.expect(net[self.item[row.task]] >= -there[self.item[row.task]], row, f"pod {row.other} has none left")
            return
        if self.pods.stock is not None:
            self.expect(net[self.item[row.task]] >= -self.pods.stock, row, f"pod {row.other} has none left")
        given = sum(units < 0 for units in net.values())
        self.expect(given <= self.pods.per_pod, row, f"pod {row.other} gave more kinds than it holds")

    def stored(self, row):
        pod, place = int(row.value), row.other
        self.expect(self.carried.pop(row.robot, None) == pod, row, f"does not carry pod {pod}")
        self.expect(place not in self.pod_at, row, f"a pod stands at {place}")
        self.expect(0 <= place < self.places, row, f"no place {place}")
        self.pod_at[place], self.place_of[pod] = pod, place
        self.at.pop(row.robot, None)

    def orders(self):
        """No station works on too many orders; an order is open from its first assigned to its last done line."""
        lines, begun = defaultdict(list), {}
        for task, flow in self.log.flows.items():
            lines[flow, self.log.orders.get(task, f"#{task}")].append(task)
        of = {task: order for order, tasks in lines.items() for task in tasks}
        for row in self.log.of("assigned"):
            begun.setdefault(of[row.task], row.time)
        changes = defaultdict(list)
        for order, tasks in lines.items():
            rows = [self.done[task] for task in tasks if task in self.done]
            if len({row.node for row in rows}) > 1:
                self.faults.append(f"order {order} is at several stations")
            if rows:
                changes[rows[0].node].append((begun[order], 1))
                if len(rows) == len(tasks):
                    changes[rows[0].node].append((max(row.time for row in rows), -1))
        for node, some in changes.items():
            now = 0
            for time, change in sorted(some):
                now += change
                if self.pods.orders and now > self.pods.orders:
                    self.faults.append(f"{time:g}: {now} orders at {node}, at most {self.pods.orders}")
                    break

    def pickers(self):
        """No picker is faster than the shortest handling time, if the model fixes these times."""
        fixed = [flow.stop_time for flow in self.flows.values()]
        if not all(isinstance(time, int | float) for time in fixed):
            return
        for node, lines in Counter(row.node for row in self.done.values()).items():
            if min(fixed) * (lines - self.servers[node]) > self.servers[node] * self.log.end * (1 + 1e-9):
                self.faults.append(f"{lines} lines at {node} in {self.log.end:g}: quicker than its pickers")
