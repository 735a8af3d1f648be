"""Whatever the layout and however many robots: work ends, and nothing impossible happens on the way."""

from __future__ import annotations

import re
from collections import defaultdict
from itertools import pairwise

from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st

import desim_warehouse as dw
from desim_warehouse.errors import PolicyError, StallError, WarehouseError
from desim_warehouse.feasibility import errors
from tests.accounting import faults
from tests.auditor import Audit, audit
from tests.laws.worlds import block_layouts, models, reals

relaxed = settings(
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
)


def simulated(model, seed):
    """A run, unless the batteries are too small for the work."""
    try:
        return dw.simulate(model, seed)
    except (PolicyError, StallError) as error:
        if re.search("no battery seems to last|on the lanes: nobody.*no robot's battery lasts", str(error)) is None:
            raise
        reject()


@given(models(), st.integers(0, 3))
@relaxed
def test_every_task_ends_the_log_is_sound_and_no_time_is_lost(mapping, seed):
    model = dw.load(mapping)
    run = simulated(model, seed)
    assert run.kpis["tasks"] == len(model.tasks.goods)
    assert audit(run) == []
    assert faults(run) == []


@given(models(most_robots=6, most_goods=10), reals(0.05, 1), st.sampled_from([0.0, 30.0, 100.0]), st.integers(0, 3))
@relaxed
def test_a_model_that_ends_was_not_refused_for_its_batteries(mapping, share, reserve, seed):
    """What is called impossible beforehand is: batteries are drawn that last for a task, for many, or for none."""
    battery = mapping["battery"] or {"capacity": 2000.0, "threshold": 100.0, "consumption": 1, "charge_rate": 20}
    capacity, threshold = battery["capacity"] * share, battery["threshold"] * share
    mapping["battery"] = {**battery, "capacity": capacity, "threshold": threshold, "reserve": reserve}
    model = dw.load(mapping)
    try:
        run = dw.simulate(model, seed)
    except WarehouseError:
        return
    assert run.kpis["tasks"] == len(model.tasks.goods)
    assert {item.code for item in errors(model)} <= {"ROBOT_WIDER_THAN_AISLE"}


def crossings(run):
    """Every passage of a node onto an edge: (edge, robot, when it asked for the node, when it got it)."""
    result = []
    node_time = run.model.traffic.node_time
    visits = Audit(run)
    visits.rebuild()
    waits, stopped = {}, set()
    for time, kind, robot, _, node, _, value, _, _ in run.record.rows:
        if kind == "collision" and node is not None:
            waits[robot, node, round(time, 6)] = time - value
        elif kind in {"unloading", "returning"}:  # or called home
            stopped.add((robot, round(time, 6)))
    for robot, items in visits.visits.items():
        for before, after in pairwise(items):
            if before.leave != after.enter or before.times[-1] + node_time < after.enter - 1e-6:
                continue  # it was in a bay in between, or stood on the node
            if (robot, round(after.enter, 6)) in stopped:
                continue
            length = run.layout.graph.edges[before.edge]["length"]
            if length < 2 * visits.contact:
                continue  # it claims one node after the other
            moving = [t for t, p in zip(before.times, before.places[1:], strict=False) if p > length - visits.contact]
            granted = moving[0] if moving else before.leave
            asked = waits.get((robot, after.edge[0], round(granted, 6)), granted)
            result.append((after.edge, robot, asked, granted))
    return result


@given(models(layouts=block_layouts, most_robots=25), st.integers(0, 3))
@relaxed
def test_nobody_who_asked_later_for_the_same_lane_goes_first(mapping, seed):
    """So a waiting claim starves at most as long as its lane is full: it is the next onto it (rotations apart)."""
    run = simulated(dw.load(mapping), seed)
    turns = {round(time, 6) for time, _, _ in run.record.rings}
    by_edge = defaultdict(list)
    for edge, robot, asked, granted in crossings(run):
        if run.layout.graph.edges[edge]["length"] >= 2 * run.model.fleet.contact:
            by_edge[edge].append((granted, asked, robot))
    for edge, items in by_edge.items():
        for (first_granted, first_asked, first), (then_granted, then_asked, then) in pairwise(sorted(items)):
            if round(first_granted, 6) not in turns and then_granted > first_granted + 1e-6:
                assert then_asked > first_asked - 1e-6, f"{then} asked for {edge} before {first}, which went first"
