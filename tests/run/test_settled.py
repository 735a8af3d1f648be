"""Batteries that have not settled while a run counts, and what is to be expected once they have."""

import re

import pytest
from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.facts.charging import cycle_levels, night_after_run, refills_overnight
from desim_warehouse.outcome import verdicts
from desim_warehouse.outcome.verdicts import judge_design, judge_run, lost_in_a_day
from desim_warehouse.questions.check import check
from desim_warehouse.run.quick import estimate

pytestmark = pytest.mark.usefixtures("brief_probes")

WORDS = Draft(size=(60, 40), orders=200, robots=8, chargers=2, due=5, aisles=8, stations=3)

ALIKE = {"battery.consumption": 0.005}
"""100 % last 5.6 h, whatever a robot does."""


@pytest.fixture(scope="module")
def warehouse():
    return dw.load(YAML(typ="safe").load(draft(WORDS)), ALIKE)


def before(model):
    """As drafts were before: batteries at 40 to 100 %, which last 5.6 h, counted from hour 1 to 5."""
    return model.replace({"fleet.start_energy": {"uniform": [0.4, 1]}, "run": {"length": 18_000, "warm_up": 3600}})


def test_what_is_to_be_expected_is_simple_arithmetic(warehouse):
    """8 (1 - f) 0.005 = 8 f 0.02: f = 20 %, so that 1.6 robots charge, at two chargers that are used 80 %."""
    counted, share = 14_400.0, 0.15
    kpis = {
        "T": counted + 7200,
        "energy": 8 * counted * (1 - share) * 0.005,
        "share_charging": share,
        "charger_utilisation": 8 * share / 2,
    }
    assert verdicts.expected(kpis, warehouse) == (
        "once settled, chargers would be in use about 80 % of the time (here 60 %), and about 1.6 of 8 robots would be "
        "charging"
    )
    lone = warehouse.replace({"layout.bays.charging.total_chargers": 1})
    assert verdicts.expected(kpis, lone) == "in the long run 1.6 robots would have to charge at a time, with 1 charger"


def test_a_level_falls_if_it_does_by_more_than_its_interval_and_one_per_cent(warehouse):
    assert verdicts.fall([-0.04, -0.05, -0.06, -0.05], warehouse) is None  # it begins settled
    warehouse = before(warehouse)
    # the half-width of 99 % at 3 degrees of freedom is 5.84 s / 2: of a standard deviation of 0.01 it is 0.029
    assert verdicts.fall([-0.04, -0.05, -0.06, -0.05], warehouse) == pytest.approx(0.05)
    assert verdicts.fall([0.04, 0.05, 0.06, 0.05], warehouse) == pytest.approx(-0.05)
    assert verdicts.fall([0.01, 0.09, 0.0, 0.1], warehouse) is None
    assert verdicts.fall([-0.01, -0.09, 0.0, -0.1], warehouse) is None
    assert verdicts.fall([-0.009] * 4, warehouse) is None
    assert verdicts.fall([-0.05], warehouse) is None
    assert verdicts.fall([-0.05] * 4, warehouse.replace({"battery": None})) is None
    assert verdicts.fall([-0.05] * 4, warehouse.replace({"tasks.goods": {"random": 9}})) is None


def test_a_fleet_that_lives_on_its_stock_is_not_said_to_meet(warehouse):
    """The README's 8 robots and 2 chargers: 97 % on time in hours 1 to 5, below 95 % in hours 8 to 14."""
    short = before(warehouse).replace({"run.length": 9000})  # shows it, too
    study = dw.Study(short, {"fleet.size": [8]}, replications=4, target="on_time >= 50 %")
    study.run()
    [verdict] = [one for one in study.results.verdicts["fleet.size=8"] if one.code == "NOT_SETTLED"]
    assert verdict.text.startswith("not settled: batteries fall by ")
    assert "once settled, chargers would be in use about 80 % of the time" in verdict.text
    assert study.results.judged["fleet.size=8"].verdict == "fails"


@pytest.mark.parametrize(
    ("run", "replications"),
    [
        ({"length": 9000, "warm_up": 3600}, 4),
        pytest.param({"length": 21_600, "warm_up": 7200}, 6, marks=pytest.mark.long),
    ],
    ids=["an hour and a half", "as drafted"],
)
def test_a_draft_starts_settled_and_stays_so(warehouse, run, replications):
    """In an hour and a half of four runs the fleet above, which lives on its stock, is seen to fall."""
    assert cycle_levels(warehouse) == (30, 95)
    study = dw.Study(
        warehouse.replace({"run": run}), {"fleet.size": [8]}, replications=replications, target="on_time >= 50 %"
    )
    study.run()
    assert study.results.verdicts["fleet.size=8"] == []
    assert study.results.judged["fleet.size=8"].verdict == "meets"
    assert not [finding for finding in check(warehouse).findings if finding.code == "START_ENERGY"]
    [finding] = [one for one in check(before(warehouse)).findings if one.code == "START_ENERGY"]
    assert finding.level == "note"


def test_one_run_is_judged_by_the_moves_of_its_robots():
    """All start full and always work: each falls by what it draws, 0.005 of 100 a second, 18 % an hour."""
    text = draft(Draft(size=(30, 20), orders=40, robots=4, chargers=4))
    model = dw.load(
        YAML(typ="safe").load(text),
        {**ALIKE, "fleet.start_energy": 1, "tasks.goods": {"saturated": 8}, "run": {"length": 7200}},
    )
    run = dw.simulate(model)
    assert verdicts.drifts_of_robots(run.history) == pytest.approx([-0.18] * 4)
    assert [verdict.code for verdict in judge_run(run.kpis, run.history)] == ["NOT_SETTLED"]


def test_falling_for_good_is_said_once(warehouse):
    kpis = {"T": 21_600.0, "energy": 1e6, "charger_utilisation": 0.99, "share_charging": 0.2}
    runs = [{**kpis, "energy_drift_per_hour": drift} for drift in (-0.05, -0.06, -0.05)]
    assert [verdict.code for verdict in judge_design(runs, warehouse)] == ["BATTERIES_FALL"]


def test_a_fleet_that_starts_low_is_said_to_look_worse_than_it_will_be(warehouse):
    low = warehouse.replace({"fleet.start_energy": 0.31, "fleet.size": 9, "layout.bays.charging.total_chargers": 6})
    study = dw.Study(
        low.replace({"run": {"length": 7200}}), {"fleet.size": [9]}, replications=3, target="on_time >= 5 %"
    )
    study.run()
    [verdict] = study.results.verdicts["fleet.size=9"]
    assert verdict.code == "NOT_SETTLED"
    assert verdict.text.startswith("not settled: batteries rise by ")
    assert study.results.judged["fleet.size=9"].verdict == "meets"  # as what is to come is better


DAY = {"run": {"length": "16 h", "start": "06:00"}, "fleet.start_energy": 1, "layout.bays.charging.total_chargers": 4}


@pytest.mark.parametrize(
    ("changes", "is_day"),
    [
        ({}, True),
        ({"run": {"length": "16 h"}}, False),  # by no clock
        ({"run": {"length": "16 h", "start": "06:00", "warm_up": "1 h"}}, False),  # not counted as a whole
        ({"fleet.start_energy": 0.9}, False),
        ({"run": {"length": "24 h", "start": "06:00"}}, False),  # no night
    ],
)
def test_a_day_that_begins_full_after_a_night_on_chargers_is_sustainable(warehouse, changes, is_day):
    """The same fall is said of a run without a night."""
    model = warehouse.replace({**DAY, **changes})
    assert refills_overnight(model) == is_day
    kpis = {"T": model.run.length, "energy": 1e9, "charger_utilisation": 0.99, "energy_drift_per_hour": -0.04}
    assert [verdict.code for verdict in judge_design([kpis] * 3, model)] == ([] if is_day else ["BATTERIES_FALL"])
    calm = {**kpis, "energy": 0.0, "charger_utilisation": 0.5, "share_charging": 0.1}
    assert [verdict.code for verdict in judge_design([calm] * 3, model)] == ([] if is_day else ["NOT_SETTLED"])
    notes = [finding.code for finding in check(model).findings if finding.code == "START_ENERGY"]
    assert notes == ([] if is_day else ["START_ENERGY"])


@pytest.mark.parametrize(("night", "refills"), [(9334, True), (9333, False)])
def test_a_night_gives_what_chargers_give_less_what_robots_beside_them_draw(warehouse, night, refills):
    """Four chargers give 0.08 and four robots draw 0.02: 0.06 a second are 560, eight times 70, after 9,333.3 s."""
    assert refills_overnight(warehouse.replace({**DAY, "run.length": 86_400 - night})) == refills


def balance(model):
    return estimate(model).power


@pytest.mark.parametrize(
    ("chargers", "stored", "drawn", "given"),
    [
        # 3 x 576 - 5 x 144 = 1,008 would be more than 8 x 70 = 560, from 100 to 30 %: 0.00972 a second of 16 hours.
        # f robots at a charger: 0.02 f + 0.00972 = (8 - f) 0.005, so f = 1.211.
        (3, 560 / 57_600, 0.03394, 0.02422),
        # 2 x 576 - 6 x 144 = 288, so 0.02 f + 0.005 = (8 - f) 0.005, and f = 1.4
        (2, 288 / 57_600, 0.033, 0.028),
        # 576 - 7 x 144 = -432: the day would have to make up for the night, too, with 1.9 chargers, and has 1
        (1, -432 / 57_600, 0.035, 0.0425),
    ],
)
def test_what_nights_store_chargers_need_not_give_by_day(warehouse, chargers, stored, drawn, given):
    """A robot draws 0.005, always, and a charger gives 0.02: 144 and 576 in a night of 8 hours.

    In the long run 0.02 f = (8 - f) 0.005, so f = 1.6, whether there are nights or not: as much is drawn in all.
    """
    long_run = balance(warehouse)
    assert (long_run.by_chargers, long_run.needed, night_after_run(warehouse)) == (1, 2, None)
    assert long_run.at_once == pytest.approx(1.6, rel=0.01)
    day = warehouse.replace({**DAY, "layout.bays.charging.total_chargers": chargers})
    power = balance(day)
    assert power.slack == pytest.approx(stored, rel=0.001)
    assert power.draws == pytest.approx(drawn, rel=0.01)
    assert power.by_chargers * power.draws == pytest.approx(given, rel=0.01)
    assert power.at_once == pytest.approx(1.6, rel=0.01)
    assert (power.needed, power.short) == (2, chargers == 1)


def test_check_says_what_chargers_do_overnight_and_what_nights_do_not_make_up_for(warehouse):
    """Two chargers are in use 0.028 / 0.04 of the day.

    With one, 0.035 - 0.02 + 0.0075 a second are lacking, in 16 hours 162 % of the 800 that batteries hold.
    """
    text = str(check(warehouse.replace({**DAY, "layout.bays.charging.total_chargers": 2})))
    assert "Chargers: 2 are enough, as they charge overnight, too; you have 2." in text
    assert "chargers 69 %" in text  # as the probe shows 0.0202 a charger
    assert "CHARGERS_SHORT" not in text
    lone = check(warehouse.replace({**DAY, "layout.bays.charging.total_chargers": 1}))
    [short] = [finding.text for finding in lone.findings if finding.code == "CHARGERS_SHORT"]
    lost, rest = re.search(r"the batteries lose (\S+) (.*)", short).groups()
    assert float(lost) == pytest.approx(162, rel=0.01)
    assert rest == "% a day, nights included, however well a single day looks"


def test_the_chargers_needed_are_the_same_however_many_there_are(warehouse):
    """Robots at rest at chargers draw nothing, but where only those needed are there, none of them is free for that."""
    draws = {"standing": 0.004, "empty": 0.005, "loaded": 0.005, "handling": 0.005}
    rests = {"battery.consumption": draws, "tasks.goods.poisson": 20, "policies.parking": "nearest"}
    few, many = (
        balance(
            warehouse.replace(
                {**rests, "layout.bays": {"all": {"at": ["A"], "total_chargers": chargers}}, "fleet.start": []}
            )
        )
        for chargers in (2, 8)
    )
    assert (few.needed, many.needed) == (2, 2)


def test_kinds_alike_that_share_chargers_store_as_much_overnight_as_a_fleet_without_kinds(warehouse):
    """Two chargers for eight robots, as above, three of which are of a kind with the same battery."""
    day = warehouse.replace({**DAY, "layout.bays.charging.total_chargers": 2})
    alike = {"capacity": 100, "consumption": 0.005, "charge_rate": 0.02}
    twins = {"fleet.kinds": {"twin": {"count": 3, "battery": alike}}}
    power = balance(day.replace(twins))
    assert power.slack == pytest.approx(288 / 57_600, rel=0.001)
    assert (power.needed, power.night) == (2, 0.5)


def test_what_chargers_store_overnight_limits_a_day(warehouse):
    """Eight robots draw 0.001 standing, and one charger gives 0.02: 0.013 a second more at rest, half as long by night.

    So 1.5 x 0.013 are left for what tasks draw beyond standing. Four robots leave 0.017, but 0.00486 is all that the
    night can store in them: 4 x 70 in 16 hours.
    """
    draws = {"standing": 0.001, "empty": 0.02, "loaded": 0.02, "handling": 0.02}
    few = {"layout.bays.charging.total_chargers": 1, "battery.consumption": draws}
    quick = estimate(warehouse.replace({**DAY, **few}))
    more = quick.power.task - 0.001 * quick.cycle.time
    assert quick.limits["the chargers"] == pytest.approx(1.5 * 0.013 / more, rel=0.01)
    assert quick.bottleneck == "the chargers"
    assert quick.throughput(4) <= (0.017 + 280 / 57_600) / more * 1.01


def test_a_fleet_whose_rest_draws_more_than_chargers_give_can_do_nothing_in_the_long_run(warehouse):
    """Seven of eight robots stand beside the charger, which gives 0.02, and draw 0.021."""
    draws = {"standing": 0.003, "empty": 0.02, "loaded": 0.02, "handling": 0.02}
    day = warehouse.replace({**DAY, "layout.bays.charging.total_chargers": 1, "battery.consumption": draws})
    (line,) = [line for line in check(day).sentences if "can do" in line]
    assert line.startswith("With the chargers as the limit, 8 robots can do nothing in the long run; you need ")


def test_a_day_that_one_charge_lasts_is_limited_by_no_charger(warehouse):
    """A tenth of the draw: 14.4 % a robot in 8 hours, and the night of 16 has time to fill all from one charger."""
    draws = {"battery.consumption": 0.0005, "layout.bays.charging.total_chargers": 1, "run.length": "8 h"}
    day = warehouse.replace({**DAY, **draws})
    quick = estimate(day)
    power = quick.power
    assert (power.by_chargers, power.needed, quick.charging) == (0, 1, 0)
    assert "chargers" not in quick.limits
    assert "chargers" not in str(check(day)).partition("busiest")[2]
    assert dw.simulate(day, seed=1).kpis["charger_utilisation"] < 0.05  # when they have nothing else to do


def test_a_day_of_24_hours_that_begins_full_costs_batteries_what_no_night_fills(warehouse):
    """The rates repeat a day later, and levels might, so it has no verdict: 2 % an hour are 48 % in the day."""
    rates = {"tasks.goods": dw.UNSET, "tasks.unload_at": dw.UNSET, "tasks.station_choice": dw.UNSET}
    flow = {"from": "storage", "to": "packing", "arrivals": {"profile": {"per_hour": [10] * 24}}}
    run = {"length": "24 h", "start": "06:00"}
    day = warehouse.replace({**rates, "tasks.flows": {"orders": flow}, "run": run, "fleet.start_energy": 1})
    assert lost_in_a_day(-0.02, day) == pytest.approx(0.48)
    assert lost_in_a_day(-0.009, day) == 0
    assert lost_in_a_day(-0.02, day.replace({"fleet.start_energy": "settled"})) == 0
    assert lost_in_a_day(-0.02, day.replace({"run": {**run, "length": "16 h"}})) == 0


@pytest.mark.parametrize(
    ("policy", "levels"),
    [
        ("threshold", (25, 100)),
        ("reach-aware", (10, 100)),
        ("opportunity", (20, 100)),
        ({"name": "four-thresholds", "critical": 0.2, "sufficient": 0.2, "good": 0.4}, (20, 95)),
        ({"name": "swap", "time": 60}, (20, 100)),
    ],
)
def test_every_policy_says_between_which_levels_batteries_move(warehouse, policy, levels):
    assert cycle_levels(warehouse.replace({"policies.charging": policy, "battery.threshold": 25})) == pytest.approx(
        levels
    )


@pytest.mark.parametrize(("fall", "codes"), [(0.0449, []), (0.0451, ["BATTERIES_FALL"])])
def test_a_night_need_only_give_what_batteries_lack_in_the_evening_and_draw_in_it(warehouse, fall, codes):
    """Eight robots and a charger that gives 576 in 8 h: 72 each, of which 0.0288 are drawn, so 71.97 after 16 h."""
    draws = {"standing": 1e-6, "empty": 0.005, "loaded": 0.005, "handling": 0.005}
    model = warehouse.replace({**DAY, "battery.consumption": draws, "layout.bays.charging.total_chargers": 1})
    fallen = {"T": model.run.length, "energy": 1e9, "charger_utilisation": 0.99, "energy_drift_per_hour": -fall}
    assert [verdict.code for verdict in judge_design([fallen] * 3, model)] == codes


@pytest.mark.parametrize(("hours", "judged"), [(16, True), (24, False), (47, False), (48, True)])
def test_the_end_of_one_day_is_not_held_against_its_beginning(warehouse, hours, judged):
    """Rates that repeat after 24 h: what a full fleet loses until the first midnight tells nothing of the second."""
    orders = {"from": "storage", "to": ["packing"], "arrivals": {"profile": {"per_hour": [100] * 12 + [200] * 12}}}
    tasks = {"flows": {"orders": orders}, "load_time": 10, "unload_time": 20}
    day = before(warehouse).replace({"tasks": tasks, "run": {"length": hours * 3600}})
    assert (verdicts.fall([-0.018] * 4, day) is not None) == judged
