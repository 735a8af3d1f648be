"""Kinds of robots with batteries, charging policies and chargers of their own, on the ring of `test_charging`.

A > B > C > D > A, 20 apart, speed 1. A task from A: out at 1, good at 31, loaded at 36, C at 46, free at 56, A at 96.
"""

import re
from itertools import pairwise
from types import SimpleNamespace

import pytest
from simpy import Environment

import desim_warehouse as dw
from desim_warehouse import CheckError, ModelError, load
from desim_warehouse.errors import StudyError
from desim_warehouse.feasibility import examine
from desim_warehouse.model.facts.costs import year_of
from desim_warehouse.questions.check.words import sentences
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.run.quick import estimate
from desim_warehouse.study.fleet.designs import Designs
from desim_warehouse.world import World
from desim_warehouse.world.places.bays import Bay, Bays
from tests.world.test_charging import NEED, RING, times

pytestmark = pytest.mark.usefixtures("brief_probes")

LARGE = {"capacity": 400, "threshold": 20, "consumption": 2, "charge_rate": 20}
TWO = {"fleet.size": 2, "fleet.kinds": {"large": {"count": 1, "battery": LARGE}}}


def play(changes):
    world = World(load(RING, {**TWO, **changes}), 0)
    world.run()
    return world


def charging(world, robot):
    rows = [row for row in world.log.rows if row[2] == robot]
    return [(row[0], then[0]) for row, then in pairwise(rows) if row[1] == "charging"]


def test_each_robot_draws_and_charges_as_its_battery_does():
    world = play({"tasks.goods": [0, 0]})
    large, small = world.robots
    assert large.battery.drawn(96.0) == pytest.approx(2 * NEED)
    assert charging(world, 0) == [(pytest.approx(96), pytest.approx(96 + 2 * NEED / 20))]
    assert small.battery.drawn(world.env.now) == pytest.approx(world.env.now)  # its task ends where the run does
    assert world.log.energy == pytest.approx([400, 200 - world.env.now])


def test_indicators_are_shares_of_each_battery():
    # The large one sinks to 400 - 192 = 208 of 400, the other stays at home, at a charger, with 200 of 200.
    run = dw.simulate(load(RING, {**TWO, "battery.consumption": 1}), 0)
    assert run.history.lowest_levels == [pytest.approx(208 / 400), 1]
    assert run.kpis["energy_lowest"] == pytest.approx(208 / 400)
    drift = -2 * NEED / (400 + 200) * 3600 / 96
    assert run.kpis["energy_drift_per_hour"] == pytest.approx(drift)


def test_a_kind_charges_by_a_policy_of_its_own():
    # At home at 96 the large one has 400 - 192 = 208, below 60 %: its battery is swapped in 7.
    swap = {"name": "swap", "time": 7, "level": 0.6}
    world = play({"fleet.kinds.large.charging": swap, "tasks.goods": [0, {"good": 0, "release": 200}]})
    assert charging(world, 0)[0] == (pytest.approx(96), pytest.approx(103))
    assert [robot.reach.levels(robot.view()).swap_time for robot in world.robots] == [7, None]


CHARGERS = {
    "layout.bays": {
        "home": {"at": ["A"], "places": 1, "chargers": 1},
        "large": {"at": ["D"], "places": 1, "chargers": 1, "kinds": ["large"]},
    },
    "fleet.start": [],
}


def test_robots_start_and_charge_at_the_chargers_of_their_kind():
    # From D the good is 20 + 20 + 10 away: 51, loaded 56, C at 66, free at 76, D at 96, with 400 - 2 * 96 left.
    world = play({**CHARGERS, "fleet.start": ["D", "A"], "tasks.goods": [0, {"good": 0, "release": 300}]})
    assert [robot.home for robot in world.robots] == ["D", "A"]
    assert times(world, "loading")[0] == pytest.approx(51)
    assert charging(world, 0) == [(pytest.approx(96), pytest.approx(96 + 2 * NEED / 20))]  # D to D takes as long


def test_kinds_start_where_chargers_are_for_them_alone_and_others_elsewhere_if_there_is_a_bay():
    model = load(RING, {**TWO, **CHARGERS, "fleet.size": 4, "fleet.kinds.large.count": 2})
    assert model.fleet.homes(model.floor.bays) == ["D", "D", "A", "A"]
    assert {one.code for one in examine(model, model.floor, estimate)[0]} >= {"BAY_CROWDED"}  # one place each
    narrow = model.replace({"layout.bays.home.kinds": ["large"]})
    assert narrow.fleet.homes(narrow.floor.bays) == ["A", "D", "A", "D"]


def test_a_robot_leaves_chargers_for_all_to_others_while_those_for_its_kind_are_free():
    # Each kind works for hours from its own bay: were the large one at A, the nearest, the other would stay at D, flat.
    changes = {**CHARGERS, "tasks.goods": {"poisson": 30}, "run.length": 20000, "policies.parking": "nearest"}
    changes["policies.charging"] = {"name": "reach-aware", "margin": 0.1}
    run = dw.simulate(load(RING, {**TWO, **changes}), 0)
    assert {(row.robot, row.node) for row in run.history.rows("parked")} == {(0, "D"), (1, "A")}


def test_a_robot_at_the_chargers_of_others_makes_room_where_they_do_not_seek():
    env = Environment()
    large, both = Bay("A", 1, None, frozenset({"large"})), Bay("B", 1, None, frozenset({"", "large"}))
    park = Bay("C", 1, None)
    bays = Bays(env, [large, both, park])
    guest = SimpleNamespace(number=1, kind="", bay=None, leaving=None, is_out=False)
    bays.settle(guest, large)
    assert not bays.wants_room(guest)  # nobody seeks
    small, big = SimpleNamespace(number=2, kind=""), SimpleNamespace(number=3, kind="large")
    bays.seekers = [small]
    assert not bays.wants_room(guest)  # not these chargers
    bays.seekers = [big, small]
    assert bays.wants_room(guest)
    assert bays.away_from(guest) == [park]  # at B the large one may seek, too
    bays.making_room[2] = both
    assert not bays.wants_room(guest)  # one is enough for one
    park.taken = 1
    bays.making_room.clear()
    assert not bays.wants_room(guest)  # and it has nowhere to go


@pytest.mark.parametrize("seed", range(4))
def test_nobody_runs_flat_where_kinds_share_some_chargers(seed):
    bays = {
        "large": {"at": ["A"], "places": 2, "chargers": 1, "kinds": ["large"]},
        "both": {"at": ["B"], "places": 1, "chargers": 1},
        "rest": {"at": ["D"], "places": 3, "chargers": 0},
    }
    changes = {
        "layout.bays": bays,
        "fleet": {**RING["fleet"], "size": 4, "start": ["A", "D", "D", "D"]},
        "fleet.kinds": {"large": {"count": 2, "battery": LARGE, "charging": {"name": "reach-aware", "margin": 0.2}}},
        "policies": {"charging": {"name": "reach-aware", "margin": 0.2}, "parking": "nearest"},
        "battery.capacity": 400,
        "fleet.kinds.large.battery.capacity": 800,
        "tasks.goods": {"poisson": 40},
        "run.length": 20000,
    }
    run = dw.simulate(load(RING, changes), seed)
    where = {(row.robot, row.node) for row in run.history.rows("parked")}
    assert min(run.history.lowest_levels) > 0
    assert (0, "A") in where
    assert run.kpis["C"] > 20


SHARED = {
    "layout.bays": {
        "large": {"at": ["A"], "places": 2, "chargers": 1, "kinds": ["large"]},
        "both": {"at": ["B"], "places": 1, "chargers": 1},
        "rest": {"at": ["D"], "places": 1, "chargers": 0},
    },
    "fleet": {**RING["fleet"], "size": 4, "start": ["A", "A", "B", "D"]},
    "fleet.kinds": {"large": {"count": 2, "battery": LARGE, "charging": {"name": "reach-aware", "margin": 0.2}}},
    "policies.charging": {"name": "reach-aware", "margin": 0.2},
    "battery.capacity": 400,
    "fleet.kinds.large.battery.capacity": 800,
    "tasks.goods": {"poisson": 40},
    "run.length": 2000,
}


def no_spare_slot(changes):
    model = load(RING, {**SHARED, **changes})
    return [one for one in examine(model, model.floor, estimate)[0] if one.code == "NO_SPARE_SLOT"]


def test_without_a_slot_to_spare_a_robot_beside_the_chargers_of_others_runs_flat_while_all_rest():
    # Robot 3 rests at D, without a charger. The one at B keeps its slot, as that at D is not free: flat at 400 / 1.
    [finding] = no_spare_slot({})
    assert finding.place == "layout.bays.rest.places"
    assert "4 slots for 4 robots, and at most 3 robots can rest at chargers of their kind" in finding.text
    assert "one more slot in all" in finding.cure
    with pytest.raises(dw.BatteryError, match="robot 3 ran flat at time 400, in the bay at D, too low to work"):
        dw.simulate(load(RING, {**SHARED, "tasks.goods": [{"good": 0, "release": 1900}]}), 0)


@pytest.mark.parametrize(
    "changes",
    [
        {"layout.bays.rest.places": 2},  # the cure
        {"layout.bays.rest.chargers": 1},  # all rest at chargers
        {"run.length": 300, "tasks.goods": {"poisson": 4}},  # nobody has to charge
    ],
    ids=["a slot more", "a charger more", "short run"],
)
def test_nothing_is_said_where_all_charge_or_a_slot_is_free(changes):
    assert no_spare_slot(changes) == []


@pytest.mark.parametrize(("places", "idle"), [({}, ["2 chargers without a slot"]), ({"places": 2}, [])])
def test_chargers_where_no_robot_starts_have_no_slots_unless_places_gives_them_some(places, idle):
    bays = {"home": {"at": ["A"], "chargers": 0}, "plug": {"at": ["B"], "chargers": 2, **places}}
    model = load(RING, {"layout.bays": bays, "fleet.size": 2, "fleet.start": ["A"]})
    texts = [one.text for one in examine(model, model.floor, estimate)[0] if one.code == "CHARGERS_WITHOUT_SLOT"]
    assert [text.partition(":")[0] for text in texts] == idle


def test_kinds_with_chargers_of_their_own_need_no_slot_to_spare():
    own = {
        "large": {"at": ["A"], "places": 2, "chargers": 1, "kinds": ["large"]},
        "both": {"at": ["B"], "places": 2, "chargers": 1},
    }
    changes = {"layout.bays": own, "fleet.start": ["A", "A", "B", "B"]}
    assert no_spare_slot(changes) == []
    run = dw.simulate(load(RING, {**SHARED, **changes, "run.length": 20000}), 0)
    assert min(run.history.lowest_levels) > 0


def test_chargers_are_scarce_for_those_who_share_them():
    def scarce(**bays):
        world = World(load(RING, {**TWO, **CHARGERS, **{f"layout.bays.{key}": value for key, value in bays.items()}}))
        return {kind: reach.scarce for kind, reach in world.reaches.items()}

    assert scarce() == {"large": False, "": True}  # two may use the one at A, both are enough for the large one
    assert scarce(large={"at": ["D"], "places": 1, "chargers": 0}) == {"large": True, "": True}


def test_errors_say_where_and_what_instead():
    kind = {"count": 1, "battery": LARGE}
    for changes, message in (
        ({"battery": None, "fleet.kinds": {"large": kind}}, "kinds.large.battery: a battery for these robots"),
        ({"layout.bays.home.kinds": ["tall"]}, r"bays.home.kinds: no such kind of robot \(got 'tall'\)"),
        ({"fleet.kinds.large.charging": "mine.py:Mine"}, "a policy of ours here; your own, as policies.charging"),
        ({"fleet.kinds.large.charging": {"name": "swap", "tim": 3}}, "charging.tim: unknown parameter of swap"),
        (
            {"fleet.kinds.large.battery": {key: value for key, value in LARGE.items() if key != "threshold"}},
            "kinds.large.battery.threshold: missing, expected the level",
        ),
    ):
        with pytest.raises(ModelError, match=message):
            load(RING, {**TWO, **changes})


def test_check_names_the_kind_whose_battery_is_too_small_and_refuses_where_no_kind_has_one():
    weak = {**LARGE, "capacity": 150}
    model = load(RING, {**TWO, "fleet.kinds.large.battery": weak})
    findings = {item.code: item for item in examine(model, model.floor, estimate)[0]}
    assert findings["BATTERY_OF_KIND"].place == "fleet.kinds.large.battery.capacity"
    assert findings["BATTERY_OF_KIND"].text.startswith(f"kind large: good 0 draws at least {2 * NEED}")
    with pytest.raises(CheckError, match=r"kind large: .*\n.*robots of no kind: "):
        World(model.replace({"battery.capacity": 90}))


def test_a_kind_without_chargers_is_refused_where_it_runs_flat():
    bays = {"home": {"at": ["A"], "places": 2, "chargers": 2, "kinds": ["large"]}}
    model = load(RING, {**TWO, "layout.bays": bays, "tasks.goods": {"random": 20}})
    with pytest.raises(CheckError, match="robots of no kind: no bay has a charger"):
        World(model)


@pytest.mark.parametrize(
    ("kinds", "cure"),
    [((), "give layout.bays.home.chargers (or total_chargers) some"), (("large",), "give a bay without kinds some")],
)
def test_the_bay_that_is_to_get_chargers_is_one_that_the_robot_may_use(kinds, cure):
    """The first bay is for large robots alone; at home there is none, or one for large robots alone as well."""
    bays = {
        "large": {"at": ["C"], "places": 2, "chargers": 1, "kinds": ["large"]},
        "home": {"at": ["A"], "places": 3, "chargers": len(kinds), "kinds": list(kinds)},
    }
    with pytest.raises(CheckError, match=re.escape(f"{cure} chargers, ")):
        World(load(RING, {**TWO, "layout.bays": bays, "fleet.start": ["A"], "tasks.goods": {"random": 20}}))


@pytest.mark.parametrize(
    ("kind", "kinds_at_home", "begins"),
    [
        ("small", ["small"], "1 charger (at A) for 3 robots: it waited longer"),
        ("large", ["small"], "2 chargers (at D) for 1 robot: it waited longer"),
        ("small", [], "1 charger (at A) for 4 robots: it waited longer"),  # the large one may charge there, too
        ("large", [], "3 chargers (at A, D) for 4 robots: it waited longer"),
    ],
)
def test_a_robot_that_runs_flat_had_the_chargers_that_it_may_use_and_those_who_share_them(kind, kinds_at_home, begins):
    """Three small robots, and a large one with two chargers at D of its own."""
    bays = {
        "home": {"at": ["A"], "places": 4, "chargers": 1, "kinds": kinds_at_home},
        "large": {"at": ["D"], "places": 2, "chargers": 2, "kinds": ["large"]},
    }
    kinds = {"large": {"count": 1, "battery": {**LARGE, "consumption": 0.1}}, "small": {"count": 3}}
    changes = {"layout.bays": bays, "fleet": {**RING["fleet"], "size": 4, "start": ["A", "D"], "kinds": kinds}}
    world = World(load(RING, {**changes, "battery.consumption": 0.1}), 0)
    robot = next(robot for robot in world.robots if robot.kind == kind)
    assert robot.reach.why_flat(None, 0.1, robot.view(), resting=False).startswith(begins)


@pytest.mark.usefixtures("whole_probes")
def test_the_energy_balance_by_kind():
    # A saturated robot drives 80 a task, loads 5, unloads 10: 95 (its charging aside). The large one draws 190 of its
    # 400, and is charged at 20 from 20 to 400; the other 95 of its 200 at 10. A robot at work draws 2 or 1, so it must
    # charge the part c of its time for which c * 20 = (1 - c) * 2, or c * 10 = (1 - c): 1/11 both, 2/11 chargers.
    model = load(RING, {**TWO, "tasks.goods": {"saturated": 2}, "run.length": 36000})
    calculation = estimate(model)
    power = calculation.power
    cycle = calculation.cycle.time
    assert power is not None
    assert power.kinds["large"].task == pytest.approx(2 * cycle)
    assert power.kinds[""].task == pytest.approx(cycle)
    assert power.task == pytest.approx(1.5 * cycle)
    assert calculation.charging == pytest.approx(cycle / 10, rel=0.002)
    assert (power.kinds["large"].needed, power.kinds[""].needed, power.needed) == (1, 1, 1)
    many = model.replace({"fleet.size": 66, "fleet.kinds.large.count": 33, "layout.bays.home": {"at": ["A"]}})
    power = estimate(many).power
    assert power is not None
    assert (power.kinds["large"].needed, power.kinds[""].needed, power.needed) == (3, 3, 6)


def test_the_report_has_a_row_for_each_kind():
    from desim_warehouse.questions.run.page import kinds_of_robots

    table = str(kinds_of_robots(dw.simulate(load(RING, TWO), 0)))
    assert "kind large" in table
    assert "robots of no kind" in table
    assert "52" in table  # 208 of 400


def test_plan_adds_chargers_for_robots_of_no_kind():
    model = load(RING, {**TWO, **CHARGERS, "layout.bays.large": {"at": ["D"], "total_chargers": 3, "kinds": ["large"]}})
    assert Designs(model).zone == "home"
    assert Designs(model.replace({"layout.bays.large.kinds": []})).zone == "large"  # which has most


@pytest.mark.slow
def test_the_replay_shows_shares_of_each_battery():
    history = dw.simulate(load(RING, {**TWO, "log": "all"}), 0).history
    levels = [level / 400 for level in history.energy_curves[0][1]]
    assert (levels[0], levels[-1]) == (1, pytest.approx(208 / 400))
    assert [battery.capacity for battery in history.batteries] == [400, 200]
    assert dw.plot.battery(dw.simulate(load(RING, TWO), 0)).get_ylim()[1] == pytest.approx(400 * 1.03)


def test_plan_counts_all_chargers_of_the_hall_as_the_cost_does():
    """One charger at home and three for the large robot are four, of which those at home are sized; each costs 100."""
    large = {"at": ["D"], "total_chargers": 3, "kinds": ["large"]}
    prices = {"hours": 4000, "robot": 5000, "charger": 100}
    model = load(RING, {**TWO, **CHARGERS, "layout.bays.large": large, "prices": prices})
    designs = Designs(model, robots=[2], chargers=[3, 4, 5])
    assert designs.today == 4
    assert designs.of_chargers(5)["layout.bays.home.total_chargers"] == 2
    assert designs.cost((2, 5)) == 2 * 5000 + 5 * 100 == year_of(model.replace(designs.overrides((2, 5))))
    ranges, [not_tried] = designs.ranges(1.0)
    assert ranges == [[2], [4, 5]]
    assert (not_tried.options, not_tried.reason) == (({"chargers": 3},), "bays other than home keep 3 chargers")
    assert Designs(model, robots=[2]).ranges(1.0)[0][1][0] == 4  # one at home is the least
    with pytest.raises(StudyError, match="--chargers 2: bays other than home keep 3 chargers"):
        Designs(model, robots=[2], chargers=[1, 2]).ranges(1.0)


LARGE_ALONE = {
    "layout.bays": {
        "home": {"at": ["A"], "total_chargers": 2, "kinds": ["large"]},
        "park": {"at": ["D"], "chargers": 0},
    },
    "fleet.kinds.large.count": 2,
    "fleet.start": [],
}
"""Two large robots, which have all chargers."""


def test_plan_names_added_robots_of_no_kind_that_have_no_charger_with_the_cure():
    model = load(RING, {**TWO, **LARGE_ALONE, "tasks.goods": {"random": 40}})
    ranges, [not_tried] = Designs(model, robots=[2, 3, 4]).ranges(1.0)
    assert (ranges[0], not_tried.larger) == ([2], True)
    assert not_tried.options == ({"fleet.size": 3}, {"fleet.size": 4})
    assert not_tried.reason.startswith("robots of no kind: no bay has a charger, and the batteries do not last: ")
    assert "; give layout.bays." in not_tried.reason


def test_plan_says_which_robots_of_its_fleet_are_never_charged():
    """Batteries of 200 last for a run of 60, but no longer."""
    short = {"tasks.goods": {"saturated": 2}, "run.length": 60}
    model = load(RING, {**TWO, **LARGE_ALONE, **short})
    plan = plan_fleet(model, "robots_busy >= 1 %", robots="3", chargers="2", strategies={}, search=dw.Search(cap=2))
    [note] = plan.answer.notes
    assert note.startswith("With 3 robots and 2 chargers, no bay has a charger for 1 robot of no kind: give bays for ")


def test_kinds_that_share_no_charger_need_one_each():
    """Each needs 1/11 of a charger, as above: one where they share it, else one each."""
    busy = {"tasks.goods": {"saturated": 2}, "run.length": 36000}
    shared = load(RING, {**TWO, **busy})
    assert estimate(shared).power.needed == 1
    apart = shared.replace(
        {
            "layout.bays.home": {"at": ["A"], "total_chargers": 1, "kinds": ["large"]},
            "layout.bays.mine": {"at": ["D"], "total_chargers": 1, "kinds": []},
            "fleet.kinds.small": {"count": 1},
            "layout.bays.mine.kinds": ["small"],
            "fleet.start": [],
        }
    )
    needed = "1 for kind large and 1 for kind small"
    assert f"Chargers: 2 are enough, {needed}; you have 2." in chargers_in_words(apart)
    lacking = apart.replace({"layout.bays.home.total_chargers": 2, "layout.bays.mine.total_chargers": 0})
    have = "2 for kind large and none for kind small"
    assert f"Chargers: 2 are needed, {needed}; you have {have}." in chargers_in_words(lacking)


def chargers_in_words(model):
    return next(line for line in sentences(model, estimate(model)) if line.startswith("Chargers: "))


def test_a_wrong_count_of_a_kind_is_the_only_problem():
    with pytest.raises(ModelError) as error:
        load(RING, {**TWO, "fleet.kinds.large.count": 3, "prices": {"hours": 4000, "robot": 1, "kinds": {"large": 2}}})
    [problem] = error.value.problems
    assert "fleet.kinds.large.count: more robots than are left of fleet.size, 2 (got 3)" in problem


def test_a_fleet_that_would_run_flat_while_it_settles_is_simulated_for_its_own_time():
    """Robots of no kind have no charger; 200 last for 100 s, and not for the day in which others settle."""
    model = load(
        RING,
        {
            **TWO,
            **LARGE_ALONE,
            "fleet.kinds.large.count": 1,
            "fleet.start_energy": "settled",
            "tasks.goods": {"saturated": 2},
            "run.length": 60,
        },
    )
    assert dw.simulate(model).history.end == 60
