"""No robot starves at an intersection, and no model that can finish is refused for its batteries."""

import random
from collections import defaultdict
from itertools import pairwise

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import WarehouseError
from desim_warehouse.feasibility import errors
from tests.auditor import Audit
from tests.laws.features import restless, warehouse
from tests.laws.random_models import Draw

LONG = 1000


def every_day(daily, size):
    """Parametrise a test by numbers in chunks; numbers beyond the daily ones are for the long run."""
    long = [pytest.param(range(n, n + size), marks=pytest.mark.long) for n in range(daily, LONG, size)]
    return pytest.mark.parametrize("numbers", [*(range(n, n + size) for n in range(0, daily, size)), *long])


@every_day(20, 20)
def test_a_model_that_ends_was_not_refused_for_its_batteries(numbers):
    """A model that the check refuses is impossible; random batteries last for one task, for many, or for none."""
    ended = 0
    for number in numbers:
        draw, mapping = random.Random(f"batteries {number}"), warehouse(number, "restless")
        battery = mapping["battery"] or {"capacity": 2000.0, "threshold": 100.0, "consumption": 1, "charge_rate": 20}
        share = draw.uniform(0.05, 1)
        less = {key: battery[key] * share for key in ("capacity", "threshold")}
        mapping["battery"] = {**battery, **less, "reserve": draw.choice((0.0, 30.0, 100.0))}
        mapping["run"] = {"length": mapping["run"]["length"] / 20}
        model = dw.load(mapping)
        try:
            run = dw.simulate(model, number)
        except WarehouseError:
            continue
        if not run.kpis["backlog"]:
            ended += 1
            assert list(errors(model)) == [], number
    assert ended > 2


def crossings(run):
    """Return every passage of a node onto an edge: (edge, robot, time of the request, time of the grant)."""
    result = []
    node_time = run.model.traffic.node_time
    visits = Audit(run)
    visits.rebuild()
    waits, stopped = {}, set()
    for time, kind, robot, _, node, _, value, *_ in run.record.rows:
        if kind == "collision" and node is not None:
            waits[robot, node, round(time, 6)] = time - value
        elif kind in {"unloading", "returning"}:  # or recalled
            stopped.add((robot, round(time, 6)))
    for robot, items in visits.visits.items():
        for before, after in pairwise(items):
            if before.leave != after.enter or before.times[-1] + node_time < after.enter - 1e-6:
                continue  # it was in a bay in between, or stood on the node
            if (robot, round(after.enter, 6)) in stopped:
                continue
            length = run.layout.graph.edges[before.edge]["length"]
            if length < 2 * visits.contact:
                continue  # the robot claims the two nodes one by one
            moving = [t for t, p in zip(before.times, before.places[1:], strict=False) if p > length - visits.contact]
            granted = moving[0] if moving else before.leave
            asked = waits.get((robot, after.edge[0], round(granted, 6)), granted)
            result.append((after.edge, robot, asked, granted))
    return result


@every_day(20, 20)
def test_no_robot_that_asked_later_for_a_lane_enters_it_first(numbers):
    """So a claim waits only as long as its lane is full, and is then the next to enter (rotations apart)."""
    compared = 0
    for number in numbers:
        plain = Draw(random.Random(f"blocks {number}"), grounds=("blocks",)).whole()
        run = dw.simulate(dw.load(restless(plain, number)), number)
        turns = {round(time, 6) for time, _, _ in run.record.rings}
        by_edge = defaultdict(list)
        for edge, robot, asked, granted in crossings(run):
            if run.layout.graph.edges[edge]["length"] >= 2 * run.model.fleet.contact:
                by_edge[edge].append((granted, asked, robot))
        for edge, items in by_edge.items():
            for (first_granted, first_asked, first), (then_granted, then_asked, then) in pairwise(sorted(items)):
                if round(first_granted, 6) not in turns and then_granted > first_granted + 1e-6:
                    compared += then_granted > then_asked
                    assert then_asked > first_asked - 1e-6, (number, edge, f"{then} asked before {first}")
    assert compared > 10
