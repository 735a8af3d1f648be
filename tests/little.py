"""Little's law, L = lambda W, on any run: a line for each place where it does not hold.

L comes from the log alone, event by event: how many are there, and for how long. lambda counts the
tasks done, and W is the indicator.
Over a counted time that cuts tasks off at both ends the law is exact once their missing parts are added: the area under
the number of open tasks is tasks x mean cycle time, less what delivered tasks had spent before the counted time,
plus what open tasks have spent in it (Little 2011, Operations Research 59(3), 536-549, section 2).
"""

import math
from operator import itemgetter

from tests.done import ends

TOL = 1e-9


def faults(run):
    """Where the law does not hold: for all tasks, and for those of each flow."""
    differences = []
    for flow in ("", *run.model.tasks.flows):
        counted, told = areas(run, flow)
        if not math.isclose(counted, told, rel_tol=TOL, abs_tol=TOL * (1 + run.record.end)):
            differences.append(f"tasks {flow}: L x time is {counted}, lambda x W x time {told}")
    return differences


def areas(run, flow=""):
    """The area under the number of open tasks by the log, and by the indicators."""
    begin, end = run.record.begin, run.record.end
    of = f":{flow}" if flow else ""
    last = ends(run)
    rows = [row for row in run.record.rows if row[1] == "released"] + last
    rows = sorted((row for row in rows if not flow or run.record.flows.get(row[3]) == flow), key=itemgetter(0))
    area, number, since = 0.0, 0, begin
    released, finished = {}, {}
    for time, kind, _, task, *_ in rows:
        now = max(time, begin)
        area += number * (now - since)
        number, since = number + (1 if kind == "released" else -1), now
        (released if kind == "released" else finished)[task] = time
    area += number * (end - since)
    done, cycle = sum(time >= begin for time in finished.values()), run.kpis[f"cycle_time_mean{of}"]
    before = sum(max(begin - released[task], 0.0) for task, time in finished.items() if time >= begin)
    still = sum(end - max(time, begin) for task, time in released.items() if task not in finished)
    return area, (done * cycle if done else 0.0) - before + still
