"""Charging to the instant, on a ring of four nodes where every number can be worked out by hand.

A > B > C > D > A, 20 apart, speed 1, no node time. The good of task 0 is on B > C, 10 from B; unloading at C.
Robots start at A; the way from C to A is 40. One task: out at 1, good at 31, loaded at 36, C at 46, free at 56.
"""

import pytest

from desim_warehouse import BatteryError, ModelError, PolicyError, StallError, load
from desim_warehouse.world import World
from desim_warehouse.world.robots.battery import Battery

RING = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20], "D": [0, 20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["B", "C"], "offset": 10}],
        "bays": {"home": {"at": ["A"], "places": 2, "chargers": 2}},
    },
    "fleet": {"size": 1, "start": ["A"], "robot": {"radius": 0.5, "speed": 1}, "first_exit_time": 1, "exit_time": 1},
    "tasks": {"goods": [0], "unload_at": ["C"], "load_time": 5, "unload_time": 10},
    "battery": {"capacity": 200, "threshold": 20, "consumption": 1, "charge_rate": 10},
}
NEED = 1 + 30 + 5 + 10 + 10 + 40  # all that one task and the way home draw


def play(changes):
    world = World(load(RING, changes), 0)
    world.run()
    return world


def times(world, kind):
    return [row[0] for row in world.log.rows if row[1] == kind]


def test_the_ring_is_as_the_hand_calculation_says():
    world = play({})
    assert [times(world, kind)[0] for kind in ("loading", "loaded", "unloading", "delivered", "parked")] == [
        pytest.approx(time) for time in (31, 36, 46, 56, 96)
    ]
    assert world.robots[0].battery.drawn(world.env.now) == pytest.approx(NEED)


def test_reach_aware_takes_a_task_exactly_as_long_as_its_energy_lasts():
    reach = {"policies.charging": {"name": "reach-aware", "margin": 0.1}}
    world = play({**reach, "battery.capacity": (NEED + 0.001) / 0.9})
    assert times(world, "delivered") == [pytest.approx(56)]
    with pytest.raises(StallError, match="no robot's battery lasts for task 0: good 0 draws at least 96"):
        play({**reach, "battery.capacity": (NEED - 0.001) / 0.9, "accept": ["BATTERY_TOO_SMALL"]})


def test_reach_aware_goes_to_charge_after_the_last_task_it_can_finish():
    # 250: the first round takes NEED - 10 (to the station and free again at 56), as often as 25 + need is left:
    # 250 - 1 - 55 = 194 at 56, then each further task draws 20 + 40 + 35 = 95 and needs 95 + 40.
    world = play(
        {"policies.charging": {"name": "reach-aware", "margin": 0.1}, "battery.capacity": 250, "tasks.goods": [0] * 4}
    )
    # at 56: 194 >= 135 + 25; at 151: 99 < 160: home at 191 with 59, full 19.1 later, out again.
    assert times(world, "parked")[0] == pytest.approx(191)
    assert times(world, "recharged") == [pytest.approx(191 + 191 / 10)]
    assert world.robots[0].recharged == 1


def test_reach_aware_gives_its_task_back_at_the_instant_at_which_waiting_has_eaten_up_its_spare_energy():
    # Robot 0 unloads at C, standing on the node, from 46 to 246. Robot 1 gets the second good, beyond C, at 5.
    changes = {
        "layout.storage": [{"edge": ["B", "C"], "offset": 10}, {"edge": ["C", "D"], "offset": 10}],
        "fleet.size": 2,
        "tasks.goods": [0, {"good": 1, "release": 5}],
        "tasks.unload_time": 200,
        "policies.charging": {"name": "reach-aware", "margin": 0.1},
        "battery.capacity": 500,
    }
    need = 1 + 40 + 10 + 5 + (10 + 60) + 200 + 40
    spare = 500 - need - 50
    # Robot 1 loses 1 behind robot 0, which loads until 36, and stands one contact distance before C at 46.
    world = play(changes)
    returned = [(row[0], row[2]) for row in world.log.rows if row[1] == "returned"]
    assert returned == [(pytest.approx(46 + spare - 1), 1)]


def test_the_threshold_takes_a_task_back_at_the_threshold_to_the_instant():
    # 45 drawn at 1 from 0.0 on: out at 1 with 60 - 1; threshold 45 is reached at 15, on A > B: B at 21, home at 81.
    low = {"battery.capacity": 60, "battery.threshold": 45, "battery.reserve": 200, "accept": ["BATTERY_TOO_SMALL"]}
    world = play({**low, "run.length": 90})
    assert times(world, "returned")[0] == pytest.approx(15)
    assert times(world, "parked")[0] == pytest.approx(81)
    with pytest.raises(
        PolicyError, match=r"task 0 \(good 0\) was given back 100 times; .*the threshold 45 leaves only 15"
    ):
        play(low)


def test_charging_is_broken_off_at_sufficient_when_a_task_waits():
    levels = {"name": "four-thresholds", "critical": 0.3, "good": 0.9, "sufficient": 0.8, "full": 1.0, "margin": 0.0}
    world = play({"policies.charging": levels, "tasks.goods": [0, {"good": 0, "release": 97}]})
    # Home at 96 with 200 - 96 = 104; sufficient, 160, is reached 5.6 later: the task of 97 is given out then.
    assert times(world, "assigned")[1] == pytest.approx(96 + 5.6)
    assert times(world, "recharged") == [pytest.approx(101.6)]


def test_charging_goes_on_beyond_sufficient_until_a_task_comes():
    levels = {"name": "four-thresholds", "critical": 0.3, "good": 0.9, "sufficient": 0.6, "full": 1.0, "margin": 0.0}
    world = play({"policies.charging": levels, "tasks.goods": [0, {"good": 0, "release": 100}]})
    assert times(world, "assigned")[1] == pytest.approx(100)
    battery = world.robots[0].battery
    assert battery.drawn(world.env.now) == pytest.approx(2 * NEED)


def test_a_robot_that_holds_just_what_is_sufficient_waits_for_the_charger_free_for_a_task():
    """Both begin with 120 of 200: one charges, the other rests until it is given the charger at 4, with the task."""
    levels = {"name": "four-thresholds", "critical": 0.3, "good": 0.6, "sufficient": 0.6, "full": 1.0, "margin": 0.0}
    one_charger = {"layout.bays.home.chargers": 1, "fleet.size": 2, "fleet.start_energy": 0.6}
    world = play({**one_charger, "policies.charging": levels, "tasks.goods": [{"good": 0, "release": 4}]})
    assert [row[:3] for row in world.log.rows if row[1] == "charging"][:2] == [(0, "charging", 0), (4, "charging", 1)]
    assert times(world, "queueing") == [4 + 96]  # back from the task it finds the charger taken


def test_four_thresholds_leave_a_robot_above_good_parked_beside_the_charger():
    levels = {"name": "four-thresholds", "critical": 0.1, "good": 0.4, "sufficient": 0.6, "full": 1.0, "margin": 0.0}
    world = play({"policies.charging": levels})
    assert times(world, "charging") == []  # home with 104 of 200
    levels["good"] = 0.53
    world = play({"policies.charging": levels, "tasks.goods": [0, {"good": 0, "release": 100}]})
    assert times(world, "charging")[0] == pytest.approx(96)


def test_opportunity_charges_when_idle_and_breaks_off_as_soon_as_it_may_work():
    charging = {"name": "opportunity", "minimum": 0.2, "margin": 0.1}
    world = play({"policies.charging": charging, "tasks.goods": [0, {"good": 0, "release": 98}]})
    assert times(world, "charging")[0] == pytest.approx(96)
    # 104 at 96, 124 at 98; the task needs NEED and 20 left: it may go at once.
    assert times(world, "assigned")[1] == pytest.approx(98)


def test_opportunity_charges_on_until_the_energy_for_the_waiting_task_is_there():
    charging = {"name": "opportunity", "minimum": 0.2, "margin": 0.1}
    world = play({"policies.charging": charging, "battery.capacity": 150, "tasks.goods": [0, 0]})
    # 150 - 56 = 94 at the station, too little for 95 + 40 + 15: home at 96 with 54. The task needs NEED + 15 = 111.
    assert times(world, "assigned")[1] == pytest.approx(96 + (111 - 54) / 10, abs=1e-3)


def test_a_swap_takes_its_time_whatever_the_level():
    world = play(
        {
            "policies.charging": {"name": "swap", "time": 33, "level": 0.6},
            "tasks.goods": [0, {"good": 0, "release": 97}],
        }
    )
    assert times(world, "recharged") == [pytest.approx(96 + 33)]


def test_a_tapered_charge_takes_the_time_of_its_integral():
    world = play({"battery.taper": {"start": 0.8, "end_rate": 0.1}, "battery.capacity": 100, "tasks.goods": [0, 0]})
    battery = Battery(world.model.battery, world.robots[0].battery.rates)
    low, steps, time = 4.0, 200_000, 0.0
    for i in range(steps):  # the literal integral of dl / rate(l)
        level = low + (i + 0.5) * 96 / steps
        rate = 10.0 if level <= 80 else 10.0 * (1 - 0.9 * (level - 80) / 20)
        time += 96 / steps / rate
    assert battery.charge_time(4.0, 100.0) == pytest.approx(time, rel=1e-6)
    assert battery.charge_gain(4.0, time) == pytest.approx(96.0, rel=1e-6)


def test_states_draw_what_they_should():
    rates = {"standing": 0.1, "empty": 1.0, "loaded": 2.0, "handling": 0.5}
    world = play({"battery.consumption": rates})
    # idle in a bay with a charger draws nothing; out 1 + 30 empty, 15 handling, 10 loaded, 40 empty.
    assert world.robots[0].battery.drawn(world.env.now) == pytest.approx(31 + 15 * 0.5 + 20 + 40)


def test_a_robot_that_runs_flat_is_named_with_time_place_and_policy():
    with pytest.raises(BatteryError, match=r"robot 0 ran flat at time 50, .*C.*, unloading: good 0 draws at least 96"):
        play({"battery.capacity": 50, "battery.threshold": 10, "accept": ["BATTERY_TOO_SMALL"]})


SCARCE = {
    "layout.bays": {
        "charge": {"at": ["A"], "places": 1, "chargers": 1},
        "park": {"at": ["D"], "places": 3, "chargers": 0},
    },
    "fleet.size": 3,
    "fleet.start": ["D"],
    "tasks.goods": [0] * 12,
    "policies.charging": {"name": "reach-aware", "margin": 0.1},
    "battery.capacity": 400,
}


def test_what_is_enough_also_after_parking_includes_the_way_to_the_parking_slot():
    """From A 1 out, 30 to the good, 25 with it, 40 back and a margin of 40: 136. From D it is 20 more, and to D 61."""
    bays = {"home": {"at": ["A"], "places": 2, "chargers": 1}, "park": {"at": ["D"], "places": 1, "chargers": 0}}
    charging = {"name": "reach-aware", "margin": 0.1}
    low = {"battery.capacity": 400, "fleet.start_energy": 0.2, "policies.charging": charging}
    world = World(load(RING, {**low, "layout.bays": bays}), 0)
    world.begin(None)
    world.env.run(2)  # it charges, and the task is open
    view = world.robots[0].view()
    levels = world.reach.levels(view)
    assert world.reach.enough_for_first(view, levels) == pytest.approx(136)
    assert world.reach.enough_after_parking(view, levels) == pytest.approx(1 + 60 + 156)


def test_robots_share_one_charger_and_finish():
    rates = {"standing": 0.05, "empty": 1.0, "loaded": 1.0, "handling": 1.0}
    world = play({**SCARCE, "battery.consumption": rates})
    assert len(times(world, "delivered")) == 12
    assert sum(robot.recharged for robot in world.robots) >= 2
    for robot in world.robots:
        assert robot.battery.level(world.env.now) > 0


def test_a_robot_resting_without_a_charger_leaves_for_one_in_time():
    world = play({**SCARCE, "tasks.goods": [0, {"good": 0, "release": 2000}], "fleet.size": 1})
    # It rests at D drawing 1; from there to A takes 1 + 20, and 40 are to be left: it leaves with 61 in the battery.
    home = times(world, "parked")
    # out of D at 1, A at 21, B at 41, good at 51, loaded 56, C at 66, free 76, D at 96 with 304: 243 later it leaves.
    assert home[:2] == [pytest.approx(96), pytest.approx(96 + 243 + 21)]


def test_robots_that_must_charge_queue_for_the_one_charger_and_take_turns():
    goods = [0, {"good": 0, "release": 30}, {"good": 0, "release": 300}]
    one_charger = {"layout.bays": {"home": {"at": ["A"], "places": 2, "chargers": 1}}, "fleet.size": 2}
    world = play({**one_charger, "tasks.goods": goods, "battery.threshold": 110, "battery.charge_rate": 2})
    # Robot 0 is home at 96 with 104 left; robot 1, 30 later on its way and that long at rest, at 126 with 74. That is
    # less than three quarters of the threshold, and robot 0 is at 164, more than half of the threshold ahead: it goes.
    assert times(world, "parked")[:2] == [pytest.approx(96), pytest.approx(126)]
    assert times(world, "charging")[:2] == [pytest.approx(96), pytest.approx(126)]
    # Robot 0 rests until it is at 110, at 180; no need yet of robot 1, which is full at 189.
    assert times(world, "queueing") == [pytest.approx(126), pytest.approx(180)]
    assert times(world, "charging")[2] == pytest.approx(189)
    assert world.robots[0].time_in["queueing"] == pytest.approx(9)
    left = [row[6] for row in world.log.rows if row[1] == "charging"]
    assert left[:3] == [pytest.approx(104), pytest.approx(74), pytest.approx(101)]


def test_a_robot_is_charged_for_at_least_as_long_as_one_in_urgent_need_takes_to_drive_up():
    """Both begin with 75 and need a charger below 100. At D, 1 out and 20 away from A, 79 are beyond the way there.

    Three quarters of them and the way are 80.25, so the need at D is urgent. At A there is enough to leave for D and
    rest there, 1 + 60 + 100, after 86 / 5 = 17.2; but the other will be there 21 later. By then it is at 180.
    """
    bays = {"home": {"at": ["A"], "places": 1, "chargers": 1}, "rest": {"at": ["D"], "places": 2, "chargers": 0}}
    fleet = {**RING["fleet"], "size": 2, "start": ["A", "D"], "start_energy": 0.375}
    battery = {**RING["battery"], "threshold": 100, "charge_rate": 5}
    later = {"tasks.goods": [{"good": 0, "release": 500}], "run": {"length": 60}}
    world = play({"layout.bays": bays, "fleet": fleet, "battery": battery, "policies.parking": "home", **later})
    left = [row for row in world.log.rows if row[1] == "returning"]
    assert [(row[0], row[2], row[6]) for row in left] == [(21, 0, 180), (22, 1, 53)]


@pytest.mark.parametrize("chargers", [0, 1, 2, 4])
@pytest.mark.parametrize("charging", ["reach-aware", "opportunity", "four-thresholds", {"name": "swap", "time": 9}])
def test_robots_at_rest_draw_unless_they_are_connected_to_a_charger(chargers, charging):
    """Four robots in four slots rest from 90 % for 3000 at 0.01: 30 from each, less the time in which it is charged."""
    bays = {"home": {"at": ["A"], "places": 4, "chargers": chargers}, "far": {"at": ["C"], "places": 1, "chargers": 1}}
    changes = {"fleet.size": 4, "fleet.start_energy": 0.9, "policies.charging": charging, "policies.parking": "home"}
    draws = {"standing": 0.01, "empty": 0.05, "loaded": 0.05, "handling": 0.05}
    battery = {"capacity": 100, "threshold": 0, "consumption": draws, "charge_rate": 0.03}
    later = {"tasks.goods": [{"good": 0, "release": 3000}], "run": {"length": 3000}}
    world = play({**changes, **later, "layout.bays": bays, "battery": battery})
    charging_time = sum(row["charging"] for row in world.log.robots)
    drawn = 0 if chargers == 4 else 0.01 * (4 * 3000 - charging_time)
    assert sum(row["energy"] for row in world.log.robots) == pytest.approx(drawn)
    assert chargers or not charging_time


def test_a_robot_at_rest_beside_a_charger_of_several_slots_charges_again_before_it_is_low():
    """At 0.01 from 95 to 60, where it goes to charge when idle, takes 3,500; 35 are charged in 350."""
    bays = {"home": {"at": ["A"], "places": 2, "chargers": 1}}
    later = {"tasks.goods": [{"good": 0, "release": 20000}], "run": {"length": 10000}, "fleet.start_energy": 0.95}
    battery = {"capacity": 100, "threshold": 0, "consumption": 0.01, "charge_rate": 0.1}
    world = play({**later, "layout.bays": bays, "battery": battery, "policies.charging": "four-thresholds"})
    assert times(world, "charging") == [pytest.approx(3500), pytest.approx(7350)]


@pytest.mark.parametrize(
    ("battery", "alike"),
    [
        ({"capacity": 250, "usable": "80 %"}, {"capacity": 200}),  # an aged battery
        ({"capacity": 400, "usable": 0.5}, {"capacity": 200}),
        ({"capacity": 200, "usable": 1}, {"capacity": 200}),
        # levels of policies and charge curves are of what is usable
        ({"capacity": 250, "usable": 0.8, "taper": {"start": 0.5}}, {"capacity": 200, "taper": {"start": 0.5}}),
        ({"capacity": 2000, "usable": "10 %", "threshold": 90}, {"capacity": 200, "threshold": 90}),
    ],
)
def test_a_battery_of_which_a_part_is_usable_is_a_smaller_one(battery, alike):
    four = {"tasks.goods": [0, 0, 0, 0]}
    used, smaller = (play({**four, "battery": {**RING["battery"], **one}}) for one in (battery, alike))
    assert used.log.rows == smaller.log.rows
    assert used.robots[0].battery.drawn(used.env.now) == smaller.robots[0].battery.drawn(smaller.env.now)


def test_a_usable_part_of_a_battery_is_a_share_above_0_and_holds_the_threshold():
    assert load(RING, {"battery.usable": "80 %"}).battery.capacity == 160
    assert "usable" not in load(RING).battery.content()  # kept runs keep their digest
    for wrong, message in (
        ("0 %", "greater than 0"),
        ("120 %", "less than or equal to 1"),
        ("8 %", r"expected a level below the usable part of battery\.capacity, 16"),
    ):
        with pytest.raises(ModelError, match=message):
            load(RING, {"battery.usable": wrong})
    kind = {"large": {"count": 1, "battery": {**RING["battery"], "usable": 0.75}}}
    assert load(RING, {"fleet.kinds": kind}).fleet.kinds["large"].battery.capacity == 150


def test_without_a_slot_to_spare_a_robot_goes_to_the_charger_of_one_that_works():
    # Robot 0 has the charger at A, robot 1 rests at D. Robot 0 is out from 1 to 96 and from 151 on. With 40 left at 160
    # robot 1 goes out at 161 and is at A at 181, and full at 181 + 181 / 10. Robot 0, free at 206, parks at D at 226.
    bays = {"home": {"at": ["A"], "places": 1, "chargers": 1}, "rest": {"at": ["D"], "places": 1, "chargers": 0}}
    fleet = {**RING["fleet"], "size": 2, "start": ["A", "D"]}
    tasks = [0, {"good": 0, "release": 150}]
    world = play({"layout.bays": bays, "fleet": fleet, "tasks.goods": tasks, "battery.threshold": 40})
    parked = [(row[0], row[2], row[4]) for row in world.log.rows if row[1] == "parked"]
    assert parked == [(96, 0, "A"), (181, 1, "A"), (226, 0, "D")]
    assert world.robots[1].battery.level(world.env.now) > 150
