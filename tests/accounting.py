"""What must hold of the account of time of any run: a line for each fault.

Parts are compared with the whole to the last digit but rounding, and with the tallies of robots and places, which the
simulator keeps without the log.
"""

import math
from collections import Counter

from desim_warehouse.outcome.chains import QUEUES, TRAFFIC
from desim_warehouse.outcome.pieces import pieces

STATES = ("idle", "empty", "loading", "loaded", "unloading", "returning", "charging")


def faults(run):
    """Where the parts do not add up to the whole, or are not what was tallied."""
    history, robots, tasks = run.history, run.account("robot"), run.account("task")
    edges, nodes, hours = run.account("edge"), run.account("node"), run.account("hour")
    counted, fleet, apart = history.counted, len(run.robots), list(run.model.waits_apart)
    found = []

    def same(what, sums, whole, tolerance=1e-9):
        if not math.isclose(sums, whole, rel_tol=tolerance, abs_tol=tolerance * (1 + run.T)):
            found.append(f"{what}: {sums} of {whole}")

    for number, row in robots.iterrows():
        same(f"robot {number}", row.sum(), counted)
    for number, task in history.tasks.items():
        if task.done >= history.begin:
            same(f"task {number}", tasks.loc[number].sum(), min(task.done, run.T) - task.released)
    same("number of tasks", len(tasks), sum(task.done >= history.begin for task in history.tasks.values()))
    same("edges and nodes", edges.to_numpy().sum() + nodes.to_numpy().sum(), counted * fleet)
    for number, row in hours.iterrows():
        length = min(counted - number * run.model.units.hour, run.model.units.hour)
        same(f"hour {number}", row.sum(), length * fleet)
    for table in (robots, tasks, edges, nodes, hours):
        same(f"below zero by {table.index.name}", min(table.to_numpy().min(initial=0), 0), 0)

    waits = [part for part in robots if part in {*TRAFFIC, *QUEUES, *apart}]
    same("lost time by root", math.fsum(run.lost_time["time"]), math.fsum(robots[waits].to_numpy().ravel()))

    for number, tally in run.robots.iterrows():  # waits have rounded times in the log: a millionth
        row = robots.loc[number]
        for state in (*STATES, *({"broken"} & set(robots.columns))):
            same(f"robot {number} {state}", row[state], tally[state], 1e-6)
        same(f"robot {number} queueing", row["queueing_server"] + row["queueing_charger"], tally["queueing"], 1e-6)
        waited = row[[*TRAFFIC, *apart]].sum()  # by the root in the account, by what the robot itself met in the tally
        same(f"robot {number}, all waits", waited, tally[["waiting", *apart]].sum(), 1e-6)
    met = _met(history)
    tallies = {
        **{("robot", number): tally["waiting"] for number, tally in run.robots.iterrows()},
        **{("edge", edge): tally["blocked"] for edge, tally in run.edges.iterrows()},
        # intersections of several nodes wait at the first of them
        **{("node", node.split("+")[0]): tally["blocked"] for node, tally in run.nodes.iterrows()},
    }
    for place, tally in tallies.items():
        same(f"waiting, {place}", met[place], tally, 1e-6)
    return found


def _met(history):
    """Counted time of waits for other robots, whatever those wait for, by robot, edge and node."""
    waited = Counter()
    for piece in (piece for robot in pieces(history) for piece in robot if piece.part in TRAFFIC):
        time = max(piece.end - max(piece.start, history.begin), 0.0)
        waited["robot", piece.robot] += time
        waited[("edge", piece.edge) if piece.edge else ("node", piece.node)] += time
    return waited
