"""Faults of a run of any model, a line each: errors, an impossible log, wrong counts, lost time."""

import desim_warehouse as dw
from desim_warehouse.errors import WarehouseError
from tests import accounting, little
from tests.audit_pods import audit_pods
from tests.auditor import audit
from tests.laws.random_models import CUT
from tests.recount import differences


def faults_of(mapping, seed):
    """Return the faults of a run: impossible events, endless work, wrong indicators or accounts, a violated law."""
    try:
        run = dw.simulate(dw.load(mapping), seed)
    except WarehouseError as error:
        return [f"{type(error).__name__}: {error}"]
    rules = (audit, standstill, crowded, endless, differences, accounting.faults, little.faults)
    if run.model.pods is not None:
        rules += (audit_pods,)
    return [fault for rule in rules for fault in rule(run)]


def standstill(run):
    """Return a fault if nothing happens for long in endless work, in which a run raises no error when it stalls."""
    model = run.model
    exogenous = {"released", "edge_closed", "edge_opened", "person_in", "person_out", "person_rides", "lift_fails"}
    last = max((row[0] for row in run.record.rows if row[1] not in exogenous), default=0.0)
    slowest = min(
        [robot.speed for robot in model.fleet.robots()] + [slow.speed for slow in model.traffic.slow.values()]
    )
    edges = run.layout.graph.edges(data=True)
    around = sum(data["length"] / min(slowest, data["speed"]) for *_, data in edges)
    around += 10 * sum(data.get("takes", 0.0) for *_, data in edges)
    patience = 3 * (around + len(run.layout.graph) * model.traffic.node_time) + 50 + model.policies.interval
    if model.battery is not None:
        patience += 5 * model.battery.capacity / model.battery.charge_rate
    patience += 10 * max((one.end - one.start for one in run.history.blocked), default=0.0)
    if getattr(model.tasks.goods, "saturated", 0) and run.record.end - last > patience:
        return [f"nothing happened from {last:g} to {run.record.end:g}"]
    return []


def endless(run):
    """Return a fault if work that ends is not done by the time at which the run is given up."""
    if run.model.name != CUT and (run.kpis["backlog"] or run.model.run.length == run.record.end):
        return [f"{run.kpis['backlog']} tasks are not done by {run.record.end:g}"]
    return []


def crowded(run):
    """Return a fault if `saturated: n` releases a task while n are open; returned tasks may exceed n."""
    most = getattr(run.model.tasks.goods, "saturated", None)
    if most is None:
        return []
    steps = {"released": 1, "returned": 1, "assigned": -1}
    count = 0
    for row in run.record.rows:
        count += steps.get(row[1], 0)
        if row[1] == "released" and count > most:
            return [f"{row[0]:g}: {count} tasks are open, of {most}"]
    return []
