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
    differences = []

    def same(what, sums, whole, tolerance=1e-9):
        if not math.isclose(sums, whole, rel_tol=tolerance, abs_tol=tolerance * (1 + run.record.end)):
            differences.append(f"{what}: {sums} of {whole}")

    of_robots, tallies = robots.to_dict("index"), run.robots.to_dict("index")
    for number, row in of_robots.items():
        same(f"robot {number}", math.fsum(row.values()), counted)
    of_tasks = dict(zip(tasks.index, tasks.to_numpy().sum(axis=1), strict=True))
    for number, task in history.tasks.items():
        if task.done >= history.begin:
            same(f"task {number}", of_tasks[number], min(task.done, run.record.end) - task.released)
    same("number of tasks", len(tasks), sum(task.done >= history.begin for task in history.tasks.values()))
    same("edges and nodes", edges.to_numpy().sum() + nodes.to_numpy().sum(), counted * fleet)
    for number, row in hours.to_dict("index").items():
        length = min(counted - number * run.model.units.hour, run.model.units.hour)
        same(f"hour {number}", math.fsum(row.values()), length * fleet)
    for table in (robots, tasks, edges, nodes, hours):
        same(f"below zero by {table.index.name}", min(table.to_numpy().min(initial=0), 0), 0)

    waits = [part for part in robots if part in {*TRAFFIC, *QUEUES, *apart}]
    same("lost time by root", math.fsum(run.lost_time["time"]), math.fsum(robots[waits].to_numpy().ravel()))

    for number, tally in tallies.items():  # waits have rounded times in the log: a millionth
        row = of_robots[number]
        for state in (*STATES, *({"broken"} & set(robots.columns))):
            same(f"robot {number} {state}", row[state], tally[state], 1e-6)
        same(f"robot {number} queueing", row["queueing_server"] + row["queueing_charger"], tally["queueing"], 1e-6)
        # by the root in the account, by what the robot itself met in the tally
        waited = math.fsum(row[part] for part in (*TRAFFIC, *apart))
        same(f"robot {number}, all waits", waited, math.fsum(tally[part] for part in ("waiting", *apart)), 1e-6)
    met = _met(history)
    blocked = {
        **{("robot", number): tally["waiting"] for number, tally in tallies.items()},
        **{("edge", edge): time for edge, time in run.edges["blocked"].items()},
        # intersections of several nodes wait at the first of them
        **{("node", node.split("+")[0]): time for node, time in run.nodes["blocked"].items()},
    }
    for place, tally in blocked.items():
        same(f"waiting, {place}", met[place], tally, 1e-6)
    return differences


def _met(history):
    """Counted time of waits for other robots, whatever those wait for, by robot, edge and node."""
    waited = Counter()
    for piece in (piece for robot in pieces(history) for piece in robot if piece.part in TRAFFIC):
        time = max(piece.end - max(piece.start, history.begin), 0.0)
        waited["robot", piece.robot] += time
        waited[("edge", piece.edge) if piece.edge else ("node", piece.node)] += time
    return waited
