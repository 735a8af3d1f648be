"""Robots that keep their braking distance: where they decide, what it costs, and that the auditor would see less.

In most stories D = 2, robots drive 1 and gather and lose that in 2, so the braking distance is 1.
"""

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ModelError
from desim_warehouse.questions.check import check
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.motion import Motion
from tests.auditor import audit
from tests.laws.features import warehouse
from tests.world.floor import PARK, Floor, line

pytestmark = pytest.mark.usefixtures("brief_probes")

near = pytest.approx
HALF = Motion(2.0, 2.0)
CROSS = {"A": (0, 0), "B": (10, 0), "C": (20, 0), "X": (10, -10), "Y": (10, 10)}


def robots(floor, *ways, looks_ahead=True, **more):
    """Robots on their ways, all alike."""
    return [floor.robot(*way, motion=HALF, looks_ahead=looks_ahead, **more) for way in ways]


@pytest.mark.parametrize("looks_ahead", [False, True])
@pytest.mark.parametrize("length", [10, 3])
def test_alone_it_drives_as_any_other(looks_ahead, length):
    floor = line("A B C D", length, length, length)
    (robot,) = robots(floor, ["A B C D"], looks_ahead=looks_ahead)
    floor.run()
    assert floor.there(robot) == [near(3 * length + 2)]


@pytest.mark.parametrize(
    ("freed", "expected"),
    [
        (28, 42),  # B is free when the robot is D + 1 before it
        (28.5, 44),  # it has begun to brake, comes to a stand, and gathers speed again
        (30, 44),  # it stands
        (35, 35 + 1 + 2 + 10 + 1),  # and waits
    ],
)
def test_it_claims_an_intersection_a_braking_distance_before_the_stop_line(freed, expected):
    floor = Floor(CROSS, ["A>B", "B>C", "X>B"])
    robots(floor, ["X B", freed - 12, PARK])  # on B from 12 on
    (robot,) = robots(floor, ["A B C"], start=20)  # at the stop line, 8, at 29
    floor.run()
    assert floor.there(robot) == [near(expected)]


def test_one_that_keeps_only_its_distance_decides_at_the_stop_line():
    floor = Floor(CROSS, ["A>B", "B>C", "X>B"])
    robots(floor, ["X B", 17, PARK], looks_ahead=False)
    (robot,) = robots(floor, ["A B C"], start=20, looks_ahead=False)
    floor.run()
    assert floor.there(robot) == [near(42)]


@pytest.mark.parametrize(("looks_ahead", "later"), [(False, 0), (True, 1)])
def test_in_a_queue_that_sets_off_each_starts_later_by_the_time_for_its_braking_distance(looks_ahead, later):
    floor = line("A B C", 20, 20)
    first, second = robots(floor, [("A B", 10), 20, "B C"], [("A B", 8), 2, "B C"], looks_ahead=looks_ahead)
    floor.run()
    # The first stops at 10 from 12 to 32, the second is done long before: both gather speed together, 2 apart.
    gap = floor.enters(second)["B>C"] - floor.enters(first)["B>C"]
    assert gap == near(2 + later)


def test_behind_a_faster_one_it_sets_off_when_its_braking_distance_is_free_once_it_has_gathered_speed():
    """The first gathers 2 in 4 s: as if it drove that from 2 on. The second has its speed, 1, after 0.25.

    Then the first is to be D + 1 ahead, at 3.25, where it is at 2 + 3.25 / 2. The second leaves A 0.25 before that.
    """
    floor = line("A B C", 10, 10)
    first = floor.robot("A B", PARK, speed=2, motion=HALF, looks_ahead=True)
    second = floor.robot("A B C", PARK, motion=Motion(0.5, 2.0), looks_ahead=True, start=2)
    floor.run()
    assert floor.enters(first) == {"A>B": 2}
    assert floor.enters(second)["A>B"] == near(2 + 3.25 / 2 - 0.25)


def test_on_a_lane_too_short_to_stop_on_it_drives_slower():
    floor = line("A B C", 3, 3)
    robot = floor.robot("A B C", motion=Motion(24.0, 24.0), looks_ahead=True)
    floor.run()
    assert robot.pace == near(0.5)  # 0.5 ** 2 * 24 / 2 = 3
    assert floor.there(robot) == [near(6 / 0.5 + 0.5 * 24)]


def test_without_a_deceleration_there_is_no_braking_distance():
    with pytest.raises(ModelError, match=r"fleet\.robot\.keeps: braking without a deceleration.*expected deceleration"):
        dw.load("models/multibots.yaml").replace({"fleet.robot.keeps": "braking"})


@pytest.mark.slow
def test_a_kind_keeps_what_its_robot_keeps_or_its_own():
    mapping = {"deceleration": 0.4, "keeps": "braking"}
    changes = {f"fleet.robot.{key}": value for key, value in mapping.items()}
    changes["fleet.kinds"] = {"old": {"count": 1, "keeps": "distance"}, "new": {"count": 1}}
    model = dw.load("models/multibots.yaml").replace({"fleet.size": 3, **changes})
    assert [robot.keeps for robot in model.fleet.robots()] == ["distance", "braking", "braking"]
    assert any(line.endswith("follow up to 20 px farther behind") for line in check(model).facts)
    # It gathers speed no faster than it brakes.
    assert [robot.motion for robot in model.fleet.robots()] == [(0, 2.5), (2.5, 2.5), (2.5, 2.5)]


def careful(number):
    """A random model whose robots keep their braking distance, with the log of everything."""
    mapping = warehouse(number, ("moving", "wider moving", "closures moving")[number % 3])
    robot = {"deceleration": 0.3, **mapping["fleet"]["robot"], "keeps": "braking"}
    return dw.load({**mapping, "fleet": {**mapping["fleet"], "robot": robot}}).replace({"log": "all"})


@pytest.mark.slow
@pytest.mark.parametrize(("count", "least"), [(4, 1), pytest.param(10, 3, marks=pytest.mark.long)])
def test_the_auditor_sees_robots_that_do_not(count, least, monkeypatch):
    models = [careful(number) for number in range(0, 4 * count, 4)]
    assert [audit(dw.simulate(model)) for model in models] == [[]] * len(models)
    monkeypatch.setattr(Body, "keep_braking_distance", lambda *_: None)
    assert sum("drives" in str(audit(dw.simulate(model))) for model in models) >= least


@pytest.mark.long
@pytest.mark.parametrize(("robots", "distance", "braking"), [(20, 556, 544), (60, 1380, 1236), (100, 1581, 1261)])
def test_the_price_that_the_how_to_page_states(robots, distance, braking):
    model = dw.load("models/medium.yaml").replace({"run.length": 3600, "run.warm_up": 600, "fleet.size": robots})
    for keeps, stated in (("distance", distance), ("braking", braking)):
        kept = model.replace({"fleet.robot.keeps": keeps})
        rates = [dw.simulate(kept, seed).kpis["throughput_per_hour"] for seed in range(5)]
        assert round(sum(rates) / 5) == stated
