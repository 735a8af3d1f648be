"""What must hold of the account of time of any run: a line for each fault.

Parts are compared with the whole to the last digit but rounding, and with the tallies of robots and places, which the
simulator keeps without the log.
"""

import math

from desim_warehouse.outcome.chains import QUEUES, TRAFFIC

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
        same(f"robot {number} waiting", row["behind_robot"] + row["before_intersection"], tally["waiting"], 1e-6)
        same(f"robot {number}, other waits", row[apart].sum(), tally[apart].sum(), 1e-6)
    for edge, tally in run.edges.iterrows():
        same(f"edge {edge}", edges.loc[edge, "behind_robot"], tally["blocked"], 1e-6)
    for node, tally in run.nodes.iterrows():  # intersections of several nodes wait at the first of them
        same(f"node {node}", nodes.loc[node.split("+")[0], "before_intersection"], tally["blocked"], 1e-6)
    return found
