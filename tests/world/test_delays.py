"""Delays at nodes cost what they take, and the stop for it: nothing where there is none. D = 2, braking distance 1."""

from itertools import pairwise

import pytest

import desim_warehouse as dw
from desim_warehouse.world.traffic.motion import Motion
from tests.laws.features import ONE_WAY, warehouse
from tests.laws.two_way import KINDS
from tests.world.closed_form import drive_time
from tests.world.floor import line

HALF = Motion(2.0, 2.0)
"""Speed 1 is gathered in 2, over 1, and lost so: 1 later than at a steady pace for each."""


class Delays:
    """How long a robot is delayed at the end of the lanes that it enters as number 1, 2, and so on."""

    def __init__(self, *times):
        self.times = times

    def at(self, move):
        return self.times[move - 1] if 0 < move <= len(self.times) else 0.0


@pytest.mark.parametrize("looks_ahead", [False, True])
@pytest.mark.parametrize("length", [1.5, 3, 20])
@pytest.mark.parametrize("times", [(), (0, 0, 0, 0), (0, 3, 0, 0), (3, 0, 4, 0)])
def test_a_robot_stops_only_where_it_is_delayed(length, times, looks_ahead):
    """1.5 is shorter than D, so all is one crossing; on 3, shorter than 2 D, it goes from node to node."""
    floor = line("A B C D E", *[length] * 4)
    robot = floor.robot("A B C D E", motion=HALF, looks_ahead=looks_ahead)
    robot.delays = Delays(*times)
    floor.run()
    stands = [0, *(number for number, time in enumerate(times, 1) if time), 4]
    driven = sum(drive_time([((then - stand) * length, 1.0)], 0.5, 0.5) for stand, then in pairwise(stands))
    assert floor.there(robot) == [pytest.approx(driven + sum(times), abs=1e-9)]


def rows(mapping, seed, delays):
    fleet = mapping["fleet"]
    extra = {} if delays is None else {"delays": delays}
    changed = {**mapping, "fleet": {**fleet, "robot": {**fleet["robot"], **extra}}}
    return dw.simulate(dw.load(changed), seed).record.rows


NONE_AT_ALL = ({"share": 0, "time": 5}, {"share": 1, "time": 0}, {"share": 0, "time": {"uniform": [1, 3]}})


@pytest.mark.parametrize("seed", [*range(8), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(8, 300))])
def test_delays_that_never_are_change_nothing(seed):
    """Not a row of the log, also where robots keep their braking distance and go from node to node."""
    mapping = warehouse(seed, "moving", KINDS[seed % len(KINDS)] if seed % 2 else ONE_WAY)
    mapping["fleet"]["robot"] |= {"acceleration": 1.0, "deceleration": 1.0, "keeps": "braking"}
    assert rows(mapping, seed, NONE_AT_ALL[seed % 3]) == rows(mapping, seed, None)


def rounds(share):
    """Deliveries in an hour on a ring of short edges, by robots that keep their braking distance."""
    names = [f"n{number}" for number in range(12)]
    ring = {
        "layout": {
            "nodes": {name: [2 * number, 0] for number, name in enumerate(names)},
            "edges": [
                {"from": one, "to": other, "length": 1.5}
                for one, other in zip(names, names[1:] + names[:1], strict=True)
            ],
            "storage": [{"node": "n6"}],
            "bays": {"home": {"at": ["n0"]}},
            "stations": {"pack": {"at": ["n0"]}},
        },
        "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1, "acceleration": 0.5, "keeps": "braking"}},
        "tasks": {"goods": {"saturated": 1}, "unload_at": ["pack"], "load_time": 0, "unload_time": 0},
        "run": {"length": 20_000},
        "log": "all",
    }
    run = dw.simulate(dw.load(ring, {"fleet.robot.delays": {"share": share, "time": 1}}), 1)
    return run.kpis["tasks"]


@pytest.mark.slow
def test_few_delays_cost_little():
    """A round of 18 and two stops take 22. A delay of 1, with its stop, costs 3 at most, at twelve nodes a round."""
    assert rounds(0) == pytest.approx(20_000 / 22, abs=1)
    for share in (0.001, 0.05):
        least, most = 0.6 * share * 12 * 3, 1.2 * share * 12 * 3
        assert 20_000 / (22 + most) - 2 < rounds(share) < 20_000 / (22 + least) + 2
