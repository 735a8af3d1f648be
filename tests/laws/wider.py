"""What plants have beside the paper's floor, put into any random model: picks at nodes, destinations of tasks."""

from __future__ import annotations

import random


def wider(mapping, seed):
    """A copy of a model with some of its goods at nodes and, of a list, some tasks with a place of their own to go."""
    draw = random.Random(f"wider {seed}")
    layout, tasks = dict(mapping["layout"]), dict(mapping["tasks"])
    nodes = list(layout.get("nodes", ()))
    if nodes:
        layout["storage"] = [at_node(draw, nodes) if draw.random() < 0.5 else item for item in layout["storage"]]
        goals = [*nodes, *layout["stations"]]
        if isinstance(tasks["goods"], list):
            tasks["goods"] = [with_goal(draw, item, goals) if draw.random() < 0.4 else item for item in tasks["goods"]]
    return {**mapping, "layout": layout, "tasks": tasks}


def at_node(draw, nodes):
    return {"node": draw.choice(nodes)}


def with_goal(draw, item, goals):
    return {**(item if isinstance(item, dict) else {"good": item}), "to": draw.choice(goals)}
