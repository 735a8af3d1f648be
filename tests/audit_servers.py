"""The part of the auditor for servers, each of which serves a robot until all its loads are handled."""

import math
from collections import defaultdict
from dataclasses import dataclass

TOL = 1e-6
HANDLES = {"loading", "unloading"}
WAITS = {"queueing", "closed"}


@dataclass
class Turn:
    """A robot's turn at a server: it queues from `asked`, is served from `begin` at the latest, and done at `end`."""

    robot: int
    asked: float
    begin: float | None = None
    end: float | None = None


class Servers:
    """Checks of the order in which robots are served, for `Audit`."""

    def check_servers(self):
        stations = self.run.layout.stations
        for node, turns in self.turns().items():
            spec = self.run.model.layout.stations[stations[node].zone]
            self.check_turns_of(node, turns, stations[node].servers)
            if spec.hours is None and (spec.work_time is None or spec.buffer is None):
                self.check_order(node, turns, stations[node].servers)

    def turns(self):
        """Return the turns of robots at servers by station, in the order in which they asked.

        A robot that comes out and loads or unloads at a storage place on the node needs no server.
        """
        turns, docked, turn, stored = defaultdict(list), {}, {}, set()
        visits = self.run.model.pods is not None
        joins = "assigned" if visits else None  # a line that joins a visit
        for time, kind, robot, task, node, edge, value, *_ in self.rows:
            if kind == "released" and value >= 0:
                stored.add(task)
            elif kind == "docked":
                docked[robot] = node
                turn.pop(robot, None)
            elif robot not in docked or (kind == "loading" and task in stored):
                continue
            elif kind == "delivered" and edge is not None:
                turns[docked.pop(robot)].remove(turn.pop(robot))
            elif kind in HANDLES | WAITS:
                if robot not in turn:
                    turn[robot] = Turn(robot, time)
                    turns[docked[robot]].append(turn[robot])
                turn[robot].end = None
                if kind in HANDLES and turn[robot].begin is None:
                    turn[robot].begin = time
            elif kind in {"loaded", "delivered"} and robot in turn:
                turn[robot].end = time
                docked = {one: at for one, at in docked.items() if not (visits and kind == "loaded" and one == robot)}
            elif kind not in {"drive", "walking", "picking", joins}:
                turn.pop(robot, None)
                if kind in {"enter", "parked"}:
                    del docked[robot]
        self.picked_from(docked, turn)
        return turns

    def picked_from(self, docked, turn):
        """Reopen the turns of robots whose pods are at a station when the run ends, as these have more lines."""
        for robot in docked.keys() & turn.keys() if self.run.model.pods is not None else ():
            turn[robot].end = None

    def check_turns_of(self, node, turns, servers):
        """No more robots are between their first and last load than there are servers."""
        changes = []
        for turn in turns:
            if turn.begin is not None:
                changes += [(turn.begin + TOL, 1), (self.run.record.end + 1 if turn.end is None else turn.end, -1)]
        busy = 0
        for time, change in sorted(changes):
            busy += change
            if busy > servers:
                self.fault(time, f"{busy} robots are served at {node}, which has {servers} servers")
                return

    def check_order(self, node, turns, servers):
        """Robots are served first come, first served, as soon as a server is free."""
        free = [0.0] * servers
        for turn in sorted(turns, key=lambda turn: (turn.asked, math.inf if turn.begin is None else turn.begin)):
            free.sort()
            due = max(turn.asked, free[0])
            if self.run.model.pods is not None and due > turn.asked + TOL:
                due += self.run.model.pods.change_time
            begin = self.run.record.end if turn.begin is None else turn.begin
            if abs(begin - min(due, self.run.record.end)) > TOL * (1 + due):
                self.fault(begin, f"robot {turn.robot} is served at {node} from {begin:g}, its turn was at {due:g}")
                return
            free[0] = self.run.record.end if turn.end is None else turn.end
