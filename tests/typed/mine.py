"""A study of strategies with a policy and an indicator of my own: 60 lines that a type checker can follow."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np
import pandas as pd

import desim_warehouse as dw


@dataclass(frozen=True)
class Cheapest:
    """The pair with the least driving time, and a little for collisions seen so far."""

    collisions: float = 1.0

    def assign(self, situation: dw.Situation) -> Iterator[tuple[int, int]]:
        robots, tasks = list(situation.robots), situation.tasks[:50]
        cost = situation.approach(robots, tasks)
        seen: Mapping[tuple[str, str], float] = situation.collisions()
        cost += self.collisions * np.array([seen.get(task.edge, 0.0) for task in tasks])
        cost[~situation.allowed(robots, tasks)] = np.inf
        while np.isfinite(cost).any():
            robot, task = divmod(int(cost.argmin()), len(tasks))
            yield robots[robot].number, tasks[task].number
            cost[robot, :] = np.inf
            cost[:, task] = np.inf


@dataclass(frozen=True)
class Rested:
    """Out again at seven tenths."""

    def levels(self, robot: dw.RobotView) -> dw.Levels:
        full = robot.capacity
        return dw.Levels(critical=0.35 * full, good=0.35 * full, sufficient=0.7 * full, full=0.7 * full)


@dataclass(frozen=True)
class Fewest:
    """Fewest edges."""

    def route(self, origin: str, goal: str, roads: dw.Roads) -> Sequence[str]:
        nodes: list[str] = nx.shortest_path(roads.graph, origin, goal)
        return nodes


def metres_a_task(run: dw.Run) -> float:
    return float(run.robots["distance"].sum() / run.kpis["tasks"])


def main() -> str:
    allocation: dw.Allocation = Cheapest()
    charging: dw.Charging = Rested()
    routing: dw.Routing = Fewest()
    policies = [allocation, charging, routing]
    study = dw.Study("w.yaml", {"fleet.size": [2, 3]}, replications=5, indicators={"per_task": metres_a_task})
    table: pd.DataFrame = study.run(workers=2).table
    differences: dw.Comparison = study.compare("T", baseline={"fleet.size": 2})
    plan: dw.Plan = dw.plan("w.yaml", "T <= 300", search=dw.Search(runs=200))
    held: dw.Why = dw.why(dw.simulate("w.yaml", seed=1))
    both = pd.concat([table, differences.table])
    return f"{policies} {both} {plan.robots} {plan.cost} {held.bottleneck}"
