"""Findings about batteries, codes, and errors that are accepted; the cases behind them are simulated."""

import json
import re
from pathlib import Path
from typing import get_args

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse import BatteryError, CheckError, ModelError
from desim_warehouse.cli import desim
from desim_warehouse.feasibility.batteries import cause
from desim_warehouse.feasibility.mistakes import unused
from desim_warehouse.feasibility.power import drawn_at_rest
from desim_warehouse.findings import CODES, Acceptable
from desim_warehouse.layout import build
from desim_warehouse.questions.check import check
from tests.world.test_charging import RING
from tests.world.test_hours import SQUARE

pytestmark = pytest.mark.usefixtures("brief_probes")

PLANNER = Path(__file__).with_name("planner.yaml")
DEFAULTS = {"policies": {}, "battery.charge_rate": 0.009}
"""Twelve robots that draw as much as 4.3 chargers give, and there are four."""
NONE = ["--set", "layout.bays.chargers.chargers=0"]
TWO = {
    "policies.charging": "four-thresholds",
    "layout.bays.chargers.at": ["A", "H"],
    "layout.bays.parking.at": ["B", "C", "D", "E", "F", "G"],
    "run.length": 172800,
}


def planner(changes):
    return dw.load(PLANNER, {"log": "tasks", **changes})


def codes(changes):
    return {item.code: item for item in check(planner(changes)).findings}


def test_every_code_that_may_be_accepted_is_an_error():
    assert {CODES[code].level for code in get_args(Acceptable)} == {"error"}


def test_every_code_is_given_somewhere_and_none_that_is_not_listed():
    package = Path(dw.__file__).parent
    sources = [
        *(package / "layout").rglob("*.py"),
        *(package / "feasibility").rglob("*.py"),
        package / "run" / "night.py",
    ]
    given = set()
    for source in sources:
        given |= set(re.findall(r'(?:Finding\(\s*|code=)"([A-Z0-9_]+)"', source.read_text(encoding="utf-8")))
    assert given == set(CODES)


def test_robots_that_park_without_chargers_run_low_together():
    # 100 at 0.005 a second: all at 25 after 15,000 s. Four chargers take 75 / 0.009 = 8,333 s for a first group, and 25
    # last 5,000. Robots take turns, but eight draw 0.04 a second, and four chargers give 0.036.
    assert {"CHARGERS_SHORT", "REST_FLAT"} <= set(codes(DEFAULTS))
    with pytest.raises(BatteryError, match="at least 5 chargers are needed"):
        dw.simulate(planner({**DEFAULTS, "run.length": 172800}))


def test_robots_that_run_low_together_take_turns_where_chargers_give_enough():
    # With 0.02 a charger four give 0.08. A third group would wait 8,437 s for full batteries, on one that lasts 5,000.
    enough = {**DEFAULTS, "battery.charge_rate": 0.02}
    assert not check(planner(enough)).errors
    run = dw.simulate(planner({**enough, "run.length": 30_000}))
    assert run.kpis["energy_lowest"] > 0.05


def test_chargers_that_give_less_than_a_fleet_draws_at_rest_are_short_for_work_that_ends_too():
    """Eight robots draw 0.04 a second beside four chargers that give 0.036; twelve batteries hold 900 above 25.

    A task draws half a unit, so 500 are done without a charge, and 5,000 are not.
    """
    few, many = ({**DEFAULTS, "tasks.goods": {"random": count}, "run": {}} for count in (500, 5000))
    finding = codes(many)["CHARGERS_SHORT"]
    assert "at rest, 8 robots without a charger draw 0.04 per s, and 4 chargers supply 0.036: the batt" in finding.text
    assert "need at least 5 chargers" in finding.cure
    assert "CHARGERS_SHORT" not in codes(few)
    assert "CHARGERS_SHORT" not in codes({**many, "layout.bays.chargers.at": ["A", "C", "F", "H", "I"]})


def test_one_robot_without_a_charger_draws():
    """Five robots beside four chargers."""
    five = planner({**DEFAULTS, "fleet.size": 5})
    assert drawn_at_rest(five, five.floor) == "at rest, 1 robot without a charger draws 0.005 per s"


def test_what_a_kind_carries_without_load_types_is_told_at_its_own_key():
    kinds = planner({"fleet.kinds": {"truck": {"count": 1, "carries": ["pallet"]}}})
    told = [note.place for note in unused.notes(kinds, kinds.floor) if "load_type" in note.text]
    assert told == ["fleet.kinds.truck.carries"]


@pytest.mark.parametrize(
    ("changes", "short"),
    [
        ({"battery.threshold": 150}, False),  # 50 in 22: the drive from D to A takes 20, the charge at 25 a second 2
        ({"battery.threshold": 160}, True),  # 40 in 21.6 are less than the 2 that two robots draw
        ({"battery.threshold": 160, "layout.bays.home.places": 2}, False),  # the next waits beside the charger
        ({"battery.threshold": 160, "layout.bays.rest.at": ["B"]}, True),  # 40 in 61.6
    ],
)
def test_a_charger_is_idle_while_the_next_robot_drives_up(changes, short):
    bays = {"home": {"at": ["A"], "places": 1, "chargers": 1}, "rest": {"at": ["D"], "places": 3, "chargers": 0}}
    fleet = {**RING["fleet"], "size": 3, "start": ["rest"]}
    battery = {**RING["battery"], "charge_rate": 25, "reserve": 1000}
    model = dw.load(RING, {"layout.bays": bays, "fleet": fleet, "battery": battery, "tasks.goods": 20 * [0], **changes})
    texts = [item.text for item in check(model).findings if item.code == "CHARGERS_SHORT"]
    assert bool(texts) == short
    assert all("the next has to drive up: the batteries fall" in text for text in texts)


@pytest.mark.parametrize(
    "cure",
    [
        {"layout.bays.chargers": {"at": ["A", "C", "F", "H"], "places": 3, "chargers": 3}},
        pytest.param(
            {"layout.bays.chargers": {"at": ["A", "C", "F", "H"], "places": 2, "chargers": 2}}, marks=pytest.mark.long
        ),
        {"layout.bays.parking.chargers": 3},
    ],
)
def test_the_cures_help(cure):
    changes = {**DEFAULTS, **cure}
    assert not check(planner(changes)).errors
    assert dw.simulate(planner(changes), seed=1).kpis["tasks"] > 1100


THREE = {**TWO, "layout.bays.chargers.at": ["A", "D", "H"], "layout.bays.parking.at": ["B", "C", "E", "F", "G"]}


def test_two_chargers_are_too_few_and_three_are_enough():
    finding = codes(TWO)["CHARGERS_SHORT"]
    assert finding.text.split("2 chargers give ")[1].startswith(("0.03", "0.04"))  # 0.02 each, but for the probe
    assert "need at least 3 chargers" in finding.cure
    assert "CHARGERS_SHORT" not in codes(THREE)


@pytest.mark.long
def test_two_chargers_do_not_last_though_a_shift_looks_well():
    finding = codes(TWO)["CHARGERS_SHORT"]
    assert "2 chargers give 0.03999 per s" in finding.text  # 0.02 each, but for a rounding of the probe
    assert "up to 0.06" in finding.text
    assert "need at least 3 chargers" in finding.cure
    shift = dw.simulate(planner({**TWO, "run.length": 28800}), seed=1)
    assert shift.kpis["on_time"] == 1
    with pytest.raises(BatteryError):
        dw.simulate(planner(TWO), seed=1)
    assert "CHARGERS_SHORT" not in codes(THREE)


@pytest.mark.parametrize(("gives", "short"), [(0.0135, True), (0.016, False)])
def test_a_robot_at_the_charger_of_another_keeps_that_one_from_it(gives, short):
    """Three of twelve robots rest at chargers. Nine others rest elsewhere and draw 0.045, whoever is charged."""
    bays = {
        "chargers": {"at": ["A"], "places": 3, "chargers": 3},
        "parking": {"at": ["B", "D", "E"], "places": 4, "chargers": 0},
    }
    calm = {"tasks.goods": {"poisson": 5}, "policies": {"parking": "home"}, "fleet.start": 3 * ["A", "B", "D", "E"]}
    model = planner({**calm, "layout.bays": bays, "battery.charge_rate": gives})
    report = check(model)
    assert report.calculation.power.draws == pytest.approx(0.045, rel=0.01)
    assert ("CHARGERS_SHORT" in {item.code for item in report.findings}) == short


def test_without_chargers_a_run_that_its_batteries_last_for_is_no_error():
    none = {"layout.bays.chargers.chargers": 0, "run.warm_up": 0}
    # 75 above the threshold at 0.005 a second: 15,000 s
    assert "NO_CHARGER" not in codes({**none, "run.length": 14900})
    assert "NO_CHARGER" in codes({**none, "run.length": 15100})
    assert dw.simulate(planner({**none, "run.length": 14900})).kpis["tasks"] > 700
    # half full, it is 25
    assert "NO_CHARGER" in codes({**none, "run.length": 5100, "fleet.start_energy": 0.5})


def test_without_chargers_batteries_that_last_by_the_bound_alone_are_a_warning():
    """Standing draws a tenth of driving: certain is only what tasks cost that are asked for, without empty drives."""
    states = {"standing": 0.001, "empty": 0.02, "loaded": 0.01, "handling": 0.01}
    changes = {"layout.bays.chargers.chargers": 0, "run.warm_up": 0, "battery.consumption": states}
    findings = codes({**changes, "run.length": 16_000})
    assert "NEVER_CHARGED" in findings
    assert "the run draws about" in findings["NEVER_CHARGED"].text
    done = dw.simulate(planner({**changes, "run.length": 16_000}))
    assert max(done.record.energy) < 25  # where they stop working
    assert "NEVER_CHARGED" not in codes({**changes, "run.length": 4_000})
    assert "NO_CHARGER" in codes({**changes, "run.length": 160_000})


def test_the_cause_of_a_flat_battery_names_bays_and_cures():
    def why(changes, drew=0.0):
        model = planner(changes)
        return cause(model, build(model.layout), drew=drew)

    none = why({"layout.bays.chargers.chargers": 0})
    assert none == "no bay has a charger: give layout.bays.chargers.chargers (or total_chargers) some"
    assert (
        "2 chargers give 0.04 per s, but 12 robots that draw as this one did take 0.06; need at least 3 chargers"
    ) in why(TWO, drew=0.005)
    assert why({}) == (
        "4 chargers (at A, C, F, H) for 12 robots, none in the bays parking (layout.bays): it waited longer than its "
        "battery lasts, in traffic or for a charger; more chargers, more energy kept back (policies.charging: margin "
        "or level, battery.threshold), or a capacity above 100"
    )


# Accepting, in a file, on the command line and in a study


def desim_says(*arguments):
    return CliRunner().invoke(desim, [str(word) for word in arguments])


def test_an_accepted_error_is_recorded_with_the_run_and_said_in_its_report(tmp_path):
    wide = ["--set", "layout.blocks.aisle_width=0.9", "--set", "run={length: 4000}"]
    refused = desim_says("run", PLANNER, *wide, "--out", tmp_path / "wide")
    assert isinstance(refused.exception, CheckError)
    assert "ROBOT_WIDER_THAN_AISLE" in str(refused.exception)
    assert list((tmp_path / "wide").glob("*")) == []
    done = desim_says("run", PLANNER, *wide, "--accept", "ROBOT_WIDER_THAN_AISLE", "--out", tmp_path / "wide")
    assert done.exit_code == 0, done.output
    assert dw.load_run(tmp_path / "wide").model.accept == ("ROBOT_WIDER_THAN_AISLE",)
    from desim_warehouse.questions.run.warehouse import facts

    assert "an aisle is 0.9 m wide, a robot 1" in str(facts(dw.load_run(tmp_path / "wide").model))


def test_a_study_accepts_by_its_file():
    wide = {"layout.blocks.aisle_width": 0.9, "run": {"length": 2000}}
    study = dw.Study(dw.load(PLANNER), {"fleet.size": [2]}, changes=wide)
    with pytest.raises(dw.StudyError, match=r"no run finished: CheckError: .*ROBOT_WIDER_THAN_AISLE"):
        study.run()
    study = dw.Study(dw.load(PLANNER), {"fleet.size": [2]}, changes={**wide, "accept": ["ROBOT_WIDER_THAN_AISLE"]})
    study.run()
    assert study.table["tasks"].iloc[0] > 0


def test_what_nothing_can_be_simulated_without_is_not_accepted():
    with pytest.raises(ModelError, match=r"accept.0: should be 'BATTERY_TOO_SMALL', .* \(got 'NO_BAYS'\)"):
        planner({"accept": ["NO_BAYS"]})
    assert desim_says("check", PLANNER, "--accept", "NO_BAYS").exit_code == 2


def test_check_gives_the_verdict_first():
    lines = desim_says("check", PLANNER, *NONE).stdout.splitlines()
    assert lines[0] == "1 error: this model would be refused"
    assert lines[1].startswith("error: layout.bays: no bay has a charger, and the batteries do not last")
    done = desim_says("check", PLANNER, *NONE, "--accept", "NO_CHARGER")
    assert done.exit_code == 0
    assert done.stdout.startswith("no errors, 1 error accepted\naccepted error: layout.bays: no bay has a charger")
    output = desim_says("check", PLANNER, "--set", "fleet.robot.speed=5.4").stdout
    assert output.startswith("no errors, 1 warning\nwarning: fleet.robot.speed: a robot drives 5.4 m/s (19.44 km/h)")


def test_check_prints_json():
    done = desim_says("check", PLANNER, *NONE, "--json")
    assert done.exit_code == 2
    answer = json.loads(done.stdout)
    assert answer["refused"]
    assert answer["verdict"] == "1 error: this model would be refused"
    [finding] = [one for one in answer["findings"] if one["level"] == "error"]
    assert finding["code"] == "NO_CHARGER"
    assert finding["level"] == "error"
    assert not finding["accepted"]
    assert finding["cure"].startswith("give layout.bays.chargers.chargers")
    assert answer["calculation"]["power"]["needed"] == 3
    assert answer["calculation"]["rate"] == pytest.approx(200 / 3600)


def test_a_layout_with_errors_has_no_hand_calculation():
    answer = json.loads(desim_says("check", PLANNER, "--set", "fleet.start=[I]", "--json").stdout)
    assert answer["calculation"] is None
    assert answer["findings"][0]["code"] == "START_WITHOUT_BAY"


def test_swaps_that_take_no_time_have_no_bound_in_json():
    swap = "policies.charging={name: swap, time: 0}"
    answer = json.loads(desim_says("check", PLANNER, "--set", swap, "--json").stdout)
    assert answer["calculation"]["power"]["gives"] is None


def test_the_cause_of_a_flat_battery_names_all_that_a_robot_may_have_waited_for():
    lasts = {"capacity": 9000, "threshold": 2000, "consumption": 1, "charge_rate": 1.5}
    more = {
        "fleet.robot.breakdowns": {"every": 3600, "repair": 100},
        "layout.stations.desk.hours": "day",
        "traffic.closures": {"gate": {"members": [["A", "B"]], "hours": "late"}},
        "people": {"pickers": {"per_hour": 3, "stay": 3}},
    }
    plain, wide = (dw.load(SQUARE, {"battery": lasts, "fleet.size": 2, **over}) for over in ({}, more))
    assert "waited longer than its battery lasts, in traffic or for a charger; " in cause(plain, plain.floor)
    text = cause(wide, wide.floor)
    assert "in traffic, for a repair, for a station to open, for a lane to open, for people or for a charger; " in text


# Charging that ends below a full battery


def ring(capacity, **changes):
    """One robot on a ring of 200, two chargers; a task draws 210, and a tenth of the battery is kept back."""
    return dw.load(
        {
            "layout": {
                "nodes": {"A": [0, 0], "B": [50, 0], "C": [50, 50], "D": [0, 50]},
                "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
                "storage": [{"edge": ["B", "C"], "offset": 25}],
                "bays": {"home": {"at": ["A"], "places": 2}},
                "stations": {"s": {"at": ["D"]}},
            },
            "fleet": {"size": 1, "robot": {"radius": 0.3, "speed": 1}},
            "tasks": {"goods": [0] * 6, "unload_at": ["s"], "load_time": 5, "unload_time": 5},
            "battery": {"capacity": capacity, "threshold": capacity * 0.2, "consumption": 1, "charge_rate": 1.0},
            "policies": {"charging": "four-thresholds"},
        },
        changes,
    )


@pytest.mark.parametrize("capacity", [235, 240])
def test_a_battery_that_lasts_only_before_it_is_charged_is_refused(capacity):
    """Full it has 235, of which 210 are drawn and 23.5 kept; charged to 95 % it has 223.25."""
    fault = rf"policies\.charging: good 0 draws at least 210, .* ends charging at {0.95 * capacity:.4g} of {capacity}: "
    with pytest.raises(CheckError, match=fault):
        dw.simulate(ring(capacity))
    assert (
        dw.simulate(ring(capacity, **{"policies.charging": {"name": "four-thresholds", "full": 1}})).kpis["tasks"] == 6
    )


def test_a_battery_that_lasts_when_it_is_charged_is_not():
    """0.95 x 250 = 237.5 is 235 and what is over; what is said of it is that 250 last for four minutes."""
    assert [finding.code for finding in check(ring(250)).findings if finding.level != "note"] == ["BATTERY_RATES"]
    assert dw.simulate(ring(250)).kpis["tasks"] == 6


def test_where_its_first_charge_may_do_it_is_a_warning():
    model = ring(240, **{"tasks.goods": [0]})
    assert [finding.code for finding in check(model).findings if finding.level == "warning"] == [
        "CHARGED_TOO_LOW",
        "BATTERY_RATES",
    ]
    assert dw.simulate(model).kpis["tasks"] == 1


def test_a_run_that_stalls_names_what_robots_have_and_need_and_nothing_that_does_not_follow():
    model = ring(240, **{"accept": ["BATTERY_TOO_SMALL"], "battery.charge_rate": 24})
    with pytest.raises(
        dw.WarehouseError, match=r"only a robot that has not been charged .*; robot 0 has 228, and needs 23\d"
    ) as caught:
        dw.simulate(model)
    for unproven in ("FAST_CHARGE", "hours", "more chargers", "in traffic"):
        assert unproven not in str(caught.value)


def test_slots_beside_chargers_without_one_are_noted():
    bays = {"at": ["A", "C", "F", "H"], "places": 2, "total_chargers": 6}
    finding = codes({"layout.bays.chargers": bays})["CHARGER_SLOTS"]
    assert finding.level == "note"
    assert "2 slots beside chargers without one" in finding.text
    assert "charger: least-loaded" in finding.cure
    spread = {"layout.bays.chargers": bays, "policies.charging": {"name": "threshold", "charger": "least-loaded"}}
    assert "least-loaded" not in codes(spread)["CHARGER_SLOTS"].cure
    assert "CHARGER_SLOTS" not in codes({"layout.bays.chargers": {**bays, "places": None}})
    assert "CHARGER_SLOTS" not in codes({})
