"""Where chance enters a model: what it says of itself before a run, and what the run then did."""

from pathlib import Path

import pytest

import desim_warehouse as dw
from desim_warehouse.values.distributions import LognormalTime, MeanAndCv, UniformTime, Varying
from desim_warehouse.values.fields import FrozenMap, Named, Part

TUTORIAL = Path(__file__).parents[2] / "models/tutorial.yaml"
LIST = {"tasks.goods": [0, 3, 5, 7, 2, 4]}
RANDOM = {"exponential": 100}


def flow(**more):
    work = {"from": ["B"], "to": ["F"], "arrivals": {"schedule": [{"at": 1}]}, **more}
    return {"tasks": {"flows": {"f": work}, "load_time": 5, "unload_time": 6}}


CHANCE = {
    "breakdowns": {"fleet.robot.breakdowns": {"every": RANDOM, "repair": 20}},
    "repairs": {"fleet.robot.breakdowns": {"every": 100, "repair": {"uniform": [5, 9]}}},
    "breakdowns of a kind": {"fleet.kinds.old": {"count": 1, "breakdowns": {"every": RANDOM, "repair": 20}}},
    "delays at some nodes": {"fleet.robot.delays": {"share": 0.3, "time": 5}},
    "delays that vary": {"fleet.robot.delays": {"share": 1, "time": {"uniform": [1, 3]}}},
    "people at any time": {"people.p": {"aisles": [["A", "B"]], "per_hour": 90, "stay": 10}},
    "people anywhere": {"people.p": {"aisles": [["A", "B"], ["B", "C"]], "times": [5], "stay": 10}},
    "people who stay as they like": {"people.p": {"aisles": [["A", "B"]], "times": [5], "stay": RANDOM}},
    "outages of chargers": {"layout.bays.parking.outages": {"every": RANDOM, "repair": 20}},
    "batteries": {"fleet.start_energy": {"uniform": [0.6, 1]}},
    "loading": {"tasks.load_time": {"uniform": [4, 6]}},
    "work": {"layout.stations.packing.work_time": {"lognormal": {"mean": 8, "cv": 0.4}}},
    "goods drawn": {"tasks.goods": {"random": 5}},
    "goods always open": {"tasks.goods": {"saturated": 3}, "run.length": 500},
    "goods that arrive": {"tasks.goods": {"poisson": 60}, "run.length": 500},
    "a station drawn": {"tasks.unload_at": ["F", "C"], "tasks.station_choice": "random"},
    "a flow that arrives": {**flow(arrivals={"poisson": 60}), "run.length": 500},
    "a flow by the hour": {**flow(arrivals={"profile": {"per_hour": [20, 90]}}), "run.length": 500},
    "a flow from one of two": flow(**{"from": ["B", "C"]}),
    "a flow from storage": flow(**{"from": "storage"}),
    "a flow to storage": flow(to="storage"),
    "a flow of priorities": flow(priority=[{"priority": 1, "share": 0.5}, {"priority": 0, "share": 0.5}]),
    "a flow by a matrix": flow(
        **{"from": None, "to": None},
        from_to=[{"from": "B", "to": "F", "per_hour": 9}, {"from": "C", "to": "F", "per_hour": 9}],
    ),
    "a flow that is loaded so": flow(load_time={"uniform": [4, 6]}),
    "a flow from a station that loads so": {
        **flow(**{"from": ["E"], "to": ["C"]}),
        "layout.stations.packing.load_time": {"uniform": [4, 6]},
    },
}
NONE = {
    "a list": {},
    "breakdowns by the clock": {"fleet.robot.breakdowns": {"every": 100, "repair": 20}},
    "delays at every node": {"fleet.robot.delays": {"share": 1, "time": 2}},
    "delays at no node": {"fleet.robot.delays": {"share": 0, "time": {"uniform": [1, 3]}}},
    "people by the clock": {"people.p": {"aisles": [["A", "B"]], "times": [5, 60], "stay": 10}},
    "outages by the clock": {"layout.bays.parking.outages": {"every": 100, "repair": 20}},
    "batteries alike": {"fleet.start_energy": {"uniform": [0.9, 0.9]}},
    "energy without batteries": {"fleet.start_energy": {"uniform": [0.1, 0.9]}, "battery": None},
    "times without spread": {
        "tasks.load_time": {"uniform": [5, 5]},
        "tasks.unload_time": {"discrete": {"values": [6, 9], "weights": [1, 0]}},
    },
    "loading at a station where a list ends": {"layout.stations.packing.load_time": {"uniform": [4, 6]}},
    "loading at a station where a flow ends": {
        **flow(to=["E"]),
        "layout.stations.packing.load_time": {"uniform": [4, 6]},
    },
    "one station to draw": {"tasks.station_choice": "random"},
    "one place to draw": {
        "tasks.goods": {"saturated": 3},
        "tasks.popularity": {"weights": [0, 0, 1, *[0] * 9]},
        "run.length": 500,
    },
    "a flow by a schedule": flow(to=["C", "F"]),
    "a flow from the one place": flow(**{"from": {"popularity": {"weights": [0, 0, 1, *[0] * 9]}}}),
}


def tutorial(changes):
    return dw.load(TUTORIAL, changes if "tasks" in changes else {**LIST, **changes})


@pytest.mark.parametrize("changes", CHANCE.values(), ids=CHANCE)
def test_a_list_of_goods_with_chance_in_it_is_not_called_deterministic(changes):
    model = tutorial(changes)
    assert not model.is_deterministic
    assert not dw.simulate(model).deterministic


@pytest.mark.parametrize("changes", NONE.values(), ids=NONE)
def test_what_is_left_to_nobody_is_known_to_be_deterministic(changes):
    model = tutorial(changes)
    assert model.is_deterministic
    runs = [dw.simulate(model, seed) for seed in (1, 2, 3)]
    assert all(run.deterministic for run in runs)
    assert runs[0].record.rows == runs[1].record.rows == runs[2].record.rows


def test_a_section_that_is_not_known_yet_is_seen_by_its_parts():
    """A random process that somebody adds needs no entry in a list: its distribution says it."""

    class Failing(Part):
        every: Varying

    class Conveyor(Part):
        belts: Named[Failing]
        fixed: tuple[float, ...] = (1.0, 2.0)

    uneven = LognormalTime(lognormal=MeanAndCv(mean=8, cv=0.4))
    assert Conveyor(belts=FrozenMap(a=Failing(every=8.0), b=Failing(every=uneven))).is_random(None)
    assert not Conveyor(belts=FrozenMap(a=Failing(every=8.0))).is_random(None)
    assert not Conveyor(belts=FrozenMap(a=Failing(every=UniformTime(uniform=(8.0, 8.0))))).is_random(None)
