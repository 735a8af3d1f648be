"""Laws that hold in every random model, by number: 100 of them every day, 5,000 in the long run (some six minutes).

A fault names its number; `python -m tests.laws.test_random_models 17` looks at that model alone.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import WarehouseError
from tests import little
from tests.accounting import faults
from tests.auditor import audit
from tests.laws.random_models import WHOLE, model
from tests.recount import differences

DAILY, LONG, CHUNK = 100, 5000, 100


@dataclass
class Found:
    """What is wrong in some models, a line each: runs that fail, logs that cannot be, wrong counts, what is lost."""

    unsound: list[str] = field(default_factory=list)
    miscounted: list[str] = field(default_factory=list)
    unaccounted: list[str] = field(default_factory=list)
    not_little: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, numbers, make=model):
        """What is wrong in the models of these numbers."""
        seen = cls()
        for number in numbers:
            seen.look_at(number, make)
        return seen

    def __str__(self):
        return "\n".join([*self.unsound, *self.miscounted, *self.unaccounted, *self.not_little])

    def look_at(self, number, make):
        mapping = make(number)
        try:
            run = dw.simulate(dw.load(mapping), number)
        except WarehouseError as error:
            self.unsound.append(f"{number}: {type(error).__name__}: {error}")
            return
        problems = [*audit(run), *standstill(run), *crowded(run), *endless(run)]
        self.unsound += [f"{number}: {problem}" for problem in problems]
        self.miscounted += [f"{number}: {line}" for line in differences(run)]
        self.unaccounted += [f"{number}: {line}" for line in faults(run)]
        self.not_little += [f"{number}: {line}" for line in little.faults(run)]


def standstill(run):
    """In work without an end no run can stall in so many words: there, nothing has happened for long."""
    model = run.model
    exogenous = {"released", "edge_closed", "edge_opened", "person_in", "person_out"}
    last = max((row[0] for row in run.record.rows if row[1] not in exogenous), default=0.0)
    slowest = min(
        [robot.speed for robot in model.fleet.robots()] + [slow.speed for slow in model.traffic.slow.values()]
    )
    graph = run.layout.graph
    around = sum(length / min(slowest, limit) for *_, length, limit in each_edge(graph))
    patience = 3 * (around + len(graph) * model.traffic.node_time) + 50 + model.policies.interval
    if model.battery is not None:
        patience += 5 * model.battery.capacity / model.battery.charge_rate
    patience += 10 * max((one.end - one.start for one in run.history.blocked), default=0.0)
    if getattr(model.tasks.goods, "saturated", 0) and run.T - last > patience:
        return [f"nothing happened from {last:g} to {run.T:g}"]
    return []


def endless(run):
    """Work that has an end is done long before the run is given up."""
    if run.model.name == WHOLE and run.model.run.length == run.T:
        return [f"{run.kpis['backlog']} tasks are not done by {run.T:g}"]
    return []


def each_edge(graph):
    return ((a, b, data["length"], data["speed"]) for a, b, data in graph.edges(data=True))


def crowded(run):
    """With `saturated: n` a task is released only while fewer than n are open; those given back come on top."""
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


def chunks(begin, end, *marks):
    return [
        pytest.param(range(first, first + CHUNK), id=f"{first}-{first + CHUNK - 1}", marks=marks)
        for first in range(begin, end, CHUNK)
    ]


@pytest.fixture(scope="module", params=[*chunks(0, DAILY), *chunks(DAILY, LONG, pytest.mark.long)])
def found(request):
    return Found.of(request.param)


def test_work_ends_and_nothing_impossible_happens(found):
    assert found.unsound == []


def test_indicators_are_those_of_the_log(found):
    assert found.miscounted == []


def test_the_parts_of_an_account_of_time_add_up(found):
    assert found.unaccounted == []


def test_littles_law_holds(found):
    assert found.not_little == []


def test_models_are_of_every_kind():
    """Whatever can go wrong is drawn: else the laws say little."""
    drawn = [dw.load(model(number)) for number in range(DAILY)]
    for kind in ("allocation", "routing", "charging", "parking"):
        assert len({getattr(one.policies, kind).name for one in drawn}) == {"allocation": 8, "charging": 5}.get(kind, 4)
    assert {type(one.tasks.goods).__name__ for one in drawn} == {
        "tuple",
        "RandomGoods",
        "SaturatedGoods",
        "PoissonGoods",
    }
    assert {one.tasks.station_choice for one in drawn} == {"each", "nearest", "least-loaded", "random"}
    assert sum(1 for one in drawn if one.battery is not None) > DAILY / 3
    assert sum(1 for one in drawn if one.name != WHOLE and one.run.warm_up) > DAILY / 5
    assert sum(1 for one in drawn if len({robot.speed for robot in one.fleet.robots()}) > 1) > DAILY / 4


def test_the_same_number_is_the_same_model():
    assert model(7) == model(7) != model(8)


if __name__ == "__main__":
    print(Found.of([int(sys.argv[1])]))  # noqa: T201 - a tool to be read
