"""A night without orders: who runs flat, and what check, drafts and errors say of it."""

import random

import pytest
from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.errors import BatteryError, ModelError
from desim_warehouse.model.facts.hours import has_nights, longest_rest
from desim_warehouse.questions.check import check
from desim_warehouse.run.night import night
from desim_warehouse.world import World
from desim_warehouse.world.orders.demand import NoOrders
from tests.world.ring import RING

pytestmark = pytest.mark.usefixtures("brief_probes")

HOUR = 3600
NIGHT = [0] * 6 + [200] * 16 + [0] * 2
ALIKE = {"battery.consumption": 0.005}
"""As drafts were before: 100 % last 5.6 h, standing or driving."""
WORDS = Draft(size=(60, 40), orders=200, due=5, aisles=8, stations=3, robots=14, chargers=3)


def drafted(words=WORDS, changes=None):
    return dw.load(YAML(typ="safe").load(draft(words))).replace({"log": "tasks", **(changes or {})})


@pytest.fixture(scope="module")
def fourteen():
    return drafted()


def with_night(model, changes=None):
    profile = {"profile": {"per_hour": NIGHT}}
    flow = {"from": "storage", "to": "packing", "due_within": 300, "arrivals": profile}
    tasks = {"tasks.goods": dw.UNSET, "tasks.unload_at": dw.UNSET, "tasks.flows": {"orders": flow}}
    return model.replace({**tasks, "run": {"length": "8 h", "warm_up": 0}, **(changes or {})})


# Robots at rest on a ring: A to B, C, D and back is 20 each, at 1 a second


def ring(changes):
    """Two robots without a task, at D; a charger at A. They draw 0.01 a second at rest, and 1 driving."""
    bays = {"charging": {"at": ["A"], "places": 1, "chargers": 1}, "rest": {"at": ["D"], "places": 2, "chargers": 0}}
    return dw.load(
        RING,
        {
            "layout.bays": bays,
            "fleet": {**RING["fleet"], "size": 2, "start": ["D", "D"]},
            "policies": {"charging": {"name": "threshold"}, "parking": "nearest"},
            "battery": {
                "capacity": 1000,
                "threshold": 300,
                "charge_rate": 1,
                "consumption": {"standing": 0.01, "empty": 1, "loaded": 1, "handling": 0.01},
            },
            "tasks.goods": {"poisson": 1},
            "run": {"length": 1000},
            **changes,
        },
    )


def test_a_night_has_no_task_and_lasts_a_day_or_as_long_as_is_closed():
    model = ring({"fleet.start_energy": 0.9})
    assert longest_rest(model) == 0
    assert night(model) is None
    world = World(model, demand=NoOrders).run()
    assert world.dispatcher.done == 0
    assert world.env.now == 1000
    assert [row.kind for row in world.log.rows if row.kind == "released"] == []


def test_the_robot_that_cannot_reach_a_charger_runs_flat_first():
    # 20 left: the way to the charger takes 20 and more, at 1 a second
    flat = night(ring({"fleet.start_energy": {"uniform": [0.001, 0.02]}}))
    assert flat is not None
    assert flat.hours < 1
    assert flat.tried == 24


@pytest.mark.parametrize("charging", ["threshold", "reach-aware", "opportunity", "four-thresholds"])
def test_a_charger_that_may_fail_and_never_does_is_as_one_that_cannot(charging):
    """One robot is charged while the other seeks its slot: once it stayed there, full, and hardly a task was done."""
    low = {"fleet.start_energy": {"uniform": [0.25, 0.5]}, "policies.charging": charging}
    model = ring({**low, "tasks.goods": {"poisson": 60}, "run.length": 5000})
    never = model.replace({"layout.bays.charging.outages": {"every": 1e9, "repair": 10}})
    assert dw.simulate(never).kpis["tasks"] == dw.simulate(model).kpis["tasks"] > 60


def test_robots_of_one_bay_take_turns_at_its_charger():
    """Four rest at 0.01 a second, and the charger gives 0.04. They queued until one was full, and ran flat."""
    bays = {"charging": {"at": ["A"], "places": 5, "chargers": 1}}
    draws = {"standing": 0.01, "empty": 0.02, "loaded": 0.02, "handling": 0.01}
    battery = {"capacity": 100, "threshold": 30, "consumption": draws, "charge_rate": 0.04}
    low = {"fleet.size": 4, "fleet.start": ["A"], "fleet.start_energy": 0.12, "policies.charging": "reach-aware"}
    model = ring({"layout.bays": bays, "battery": battery, "run": {"length": 50_000}, **low})
    world = World(model, 0, demand=NoOrders).run()
    assert min(robot.charge_left() for robot in world.robots) > 0.04


def test_nearly_full_robots_take_turns_at_a_charger_that_tapers():
    """One is charged from 85 % on; the other, at 84 %, never is 20 % of a battery behind it."""
    high = {"fleet.start_energy": 0.9, "policies.charging": {"name": "threshold", "level": 850}}
    taper = {"battery.taper": {"start": 0.8, "end_rate": 0.1}}
    work = {"tasks.goods": {"poisson": 60}, "run.length": 2000}
    assert dw.simulate(ring({**high, **taper, **work})).kpis["tasks"] > 10


@pytest.mark.parametrize(
    ("changes", "hours"),
    [
        ({"calendars": {"day": {"open": ["06:00-22:00"]}}, "fleet.hours": "day"}, 8),
        ({"calendars": {"week": {"every": 168 * HOUR, "lasts": 112 * HOUR}}, "fleet.hours": "week"}, 56),
        ({"calendars": {"week": {"every": 168 * HOUR, "lasts": 112 * HOUR}}, "tasks.goods.hours": "week"}, 56),
    ],
)
def test_the_longest_rest_is_that_of_calendars(fourteen, changes, hours):
    model = fourteen.replace({"run.start": "06:00", **changes})
    assert longest_rest(model) == hours * HOUR
    assert has_nights(model)


def test_rates_of_0_are_a_night_and_flows_that_go_on_are_none(fourteen):
    assert longest_rest(with_night(fourteen)) == 8 * HOUR
    assert has_nights(with_night(fourteen))
    both = with_night(fourteen).content()["tasks"]["flows"]
    both["returns"] = {"from": "storage", "to": "packing", "arrivals": {"poisson": 3}}
    assert longest_rest(with_night(fourteen).replace({"tasks.flows": both})) == 0


# What is said


SHORT = {**ALIKE, "battery.charge_rate": 0.01}
"""Fourteen robots draw 0.07: three chargers give 0.03, five 0.05 for the nine others (0.045)."""


def night_codes(model):
    return {item.code: item for item in check(model).findings if item.code.endswith("_FLAT")}


def test_check_says_who_runs_flat_at_night_and_what_is_short(fourteen):
    finding = night_codes(with_night(fourteen, SHORT))["NIGHT_FLAT"]
    assert finding.level == "warning"
    assert "without orders, robot" in finding.text
    assert "(24 h were simulated)" in finding.text
    assert "at rest, 11 robots without a charger draw 0.055 per s, and 3 chargers supply 0.03" in finding.text
    assert "at least 5 chargers are needed" in finding.text
    assert night_codes(with_night(fourteen)) == {}


def test_it_is_a_note_where_the_run_has_no_night(fourteen):
    findings = night_codes(fourteen.replace(SHORT))
    assert {code: item.level for code, item in findings.items()} == {"REST_FLAT": "note"}
    assert set(night_codes(fourteen.replace({**SHORT, "run.length": "24 h"}))) == {"NIGHT_FLAT"}


def test_the_error_of_a_robot_at_rest_says_what_was_short(fourteen):
    with pytest.raises(BatteryError, match="at least 5 chargers are needed"):
        dw.simulate(with_night(fourteen, {**SHORT, "run.length": "24 h", "fleet.start_energy": 1}))


def test_policies_of_ones_own_are_not_run_by_a_check(fourteen):
    own = with_night(fourteen, {**SHORT, "policies.charging": "nowhere:Charging"})
    assert night_codes(own) == {}


@pytest.mark.parametrize(
    "charging",
    [
        pytest.param("four-thresholds", marks=pytest.mark.long),
        pytest.param("opportunity", marks=pytest.mark.long),
        "reach-aware",
    ],
)
def test_fourteen_robots_at_three_chargers_live_through_a_night(fourteen, charging):
    """Eleven draw 0.055 at rest, and three chargers give 0.06: they ran flat after 2.2 to 16.5 h."""
    levels = {"fleet.start_energy": {"uniform": [0.3, 0.95]}}  # between which they settle
    model = with_night(fourteen, {**ALIKE, "policies.charging": charging, "run.length": "6 h", **levels})
    assert night(model) is None
    assert dw.simulate(model).kpis["energy_lowest"] > 0.05


# Drafts


def test_a_draft_has_chargers_for_a_night():
    few = Draft(size=(60, 40), orders=10, robots=40)
    model = drafted(few)
    assert night(model) is None
    assert model.layout.bays["charging"].total_chargers == 3  # 40 x 0.00126 / (0.02 + 0.00126) = 2.4
    with pytest.raises(ModelError, match=r"--chargers 1: without orders robot .* expected at least 3"):
        draft(Draft(size=(60, 40), orders=10, robots=40, chargers=1))


POLICIES = [
    {"policies.charging": "four-thresholds"},
    {"policies.charging": "opportunity"},
    {"policies.charging": "reach-aware"},
    {"policies.charging": "threshold", "battery.threshold": 30},
    {"policies.charging": {"name": "swap", "time": 180}},
]


@pytest.mark.parametrize(
    ("seed", "hours"), [(43, 8), *(pytest.param(seed, 48, marks=pytest.mark.long) for seed in range(60))]
)
def test_drafts_run_two_days_of_two_shifts_and_a_night(seed, hours):
    """Until the first orders after the second night, which begins at 22:00 and ends at 06:00; every day after one."""
    chance = random.Random(seed)
    orders = chance.randint(20, 160)
    size = (chance.randint(20, 70), chance.randint(20, 60))
    words = Draft(size=size, orders=orders, due=chance.choice([5, 15, 30]))
    policy = chance.choice(POLICIES)
    model = with_night(drafted(words), {**policy, "run.length": f"{hours} h"})
    assert 0 < dw.simulate(model, seed).kpis["energy_lowest"] < 1
