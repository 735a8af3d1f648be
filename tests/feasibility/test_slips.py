"""Slips of planners are said, each with its cure, and nothing of them is said of 45 random drafts."""

import random
from collections import Counter
from functools import cache

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.draft import Draft, draft
from desim_warehouse.errors import ModelError, StudyError
from desim_warehouse.findings import CODES
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.model.schema import Model
from desim_warehouse.outcome.indicators import INDICATORS
from desim_warehouse.questions.check import check
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.study.target import check_zone, read_target, too_short
from desim_warehouse.values.fields import Usual, sections_in
from desim_warehouse.values.units import UnitNames
from tests.daily import some
from tests.feasibility import fresh_slips, slips

pytestmark = pytest.mark.usefixtures("brief_probes")

SLIPS = tuple(CODES)[tuple(CODES).index("BATTERY_RATES") :]
BANK = {**slips.KNOWN, **slips.OURS}


@cache
def base(name):
    return dw.load(slips.PLANNER, slips.BASES[name])


@pytest.mark.parametrize("name", slips.BASES)
def test_the_warehouses_themselves_have_no_slips(name):
    assert [str(item) for item in check(base(name)).findings if item.code in SLIPS or item.level != "note"] == []


@pytest.mark.parametrize("slip", some(BANK, 8))
def test_a_slip_is_said_with_its_cure(slip):
    name, changes, code, cure = BANK[slip]
    findings = [item for item in check(base(name).replace(changes)).findings if item.code == code]
    assert any(cure in item.problem for item in findings), [str(item) for item in findings]


MOST_SILENT = 6
"""Of the slips that nobody had in view who wrote the checks."""


@cache
def said_of_base(name):
    return {str(item) for item in check(base(name)).findings}


def is_said(name, changes):
    """Whether a change is refused, warned of, or noted as a slip, or as something that is not used for it."""
    try:
        findings = check(base(name).replace(changes)).findings
    except ModelError:
        return True
    new = [item for item in findings if str(item) not in said_of_base(name)]
    return any(item.level != "note" or item.code in (*SLIPS, "NOT_USED") for item in new)


def test_a_slip_of_each_kind_is_said():
    banks = fresh_slips.SLIPS.values()
    assert sum(not is_said(*next(iter(bank.values()))) for bank in banks) <= 1


@pytest.mark.long
def test_hardly_any_of_sixty_fresh_slips_is_silent():
    told = {(kind, slip): is_said(*how) for kind, bank in fresh_slips.SLIPS.items() for slip, how in bank.items()}
    for target in fresh_slips.TARGETS:
        told["target", target] = refused(lambda target=target: read_target(target, UnitNames()))
    for target, zone in fresh_slips.ZONES:
        told["zone", (target, zone)] = refused(
            lambda t=target, z=zone: plan_fleet(base("goods"), t, zone=z, search=dw.Search(runs=10))
        )
    assert min(Counter(kind for kind, _ in told).values()) >= 4
    assert len(told) >= 60
    silent = [slip for slip, noticed in told.items() if not noticed]
    assert len(silent) <= MOST_SILENT, silent


def refused(call):
    try:
        call()
    except StudyError:
        return True
    return False


# Files of orders


def orders(tmp_path, rows, **flow):
    """What is said of the files of orders of a flow of picks."""
    file = tmp_path / "orders.csv"
    file.write_text("\n".join(("release,from,to", *rows)) + "\n", encoding="utf-8")
    picks = {"from": "storage", "to": "packing", **flow, "arrivals": {"orders": {"file": str(file)}}}
    findings = check(base("flows").replace({"tasks.flows": {"picks": picks}})).findings
    return {item.code: item.text for item in findings if item.place == "tasks.flows.picks.arrivals.orders"}


def test_rows_that_go_the_other_way_are_counted(tmp_path):
    rows = ["08:00,0,packing", "08:10,packing,5", "09:00,3,packing", "09:30,dock,storage", "10:00,,packing"]
    assert orders(tmp_path, rows) == {"ENDS_SWAPPED": "the flow leads from storage, and 2 of 5 rows lead to it"}
    put_away = {"from": "dock", "to": "storage"}
    assert orders(tmp_path, rows, **put_away) == {
        "ENDS_SWAPPED": "the flow leads to storage, and 2 of 5 rows lead from it"
    }
    assert orders(tmp_path, [rows[0], rows[2], rows[4]]) == {}
    assert orders(tmp_path, rows, **{"from": "dock", "to": "packing"}) == {}  # it leads past storage, and rows do not


def test_releases_as_parts_of_a_day_are_asked_about(tmp_path):
    texts = orders(tmp_path, ["0.26,0,packing", "0.5,1,packing", "0.75,2,packing"])
    assert texts == {"UNUSUAL": "all orders are released within 0.75 s"}
    assert orders(tmp_path, ["26,0,packing", "3600,1,packing"]) == {}


def test_a_lorry_may_come_in_the_first_minute_if_others_follow():
    """Twenty seconds after the start is no time for the only lorry, but for the first of three within an hour."""
    alone, followed = (check(base("flows").replace(slips.schedule(*at))).findings for at in ([20], [20, 90, 3700]))
    schedule = "tasks.flows.goods in.arrivals.schedule"
    assert [item.place for item in alone if item.code == "UNUSUAL"] == [f"{schedule}.0.at"]
    assert not [item for item in followed if item.code == "UNUSUAL"]


# Targets, zones, names


@pytest.mark.parametrize("target", slips.TARGETS)
def test_a_target_the_wrong_way_round_is_refused(target):
    with pytest.raises(StudyError, match=slips.TARGETS[target]) as error:
        read_target(target, UnitNames())
    turned = target.translate(str.maketrans("<>", "><"))
    assert f"did you mean {turned!r}?" in str(error.value)
    assert read_target(turned, UnitNames()).indicator in target


@pytest.mark.parametrize(("target", "zone"), slips.ZONES)
def test_a_zone_of_more_than_a_fifth_is_refused(target, zone):
    with pytest.raises(StudyError, match="expected at most") as error:
        plan_fleet(base("goods"), target, zone=zone, search=dw.Search(runs=10))
    assert slips.ZONES[target, zone] in str(error.value)


def test_smaller_zones_are_taken():
    check_zone(INDICATORS["on_time"], 0.2, 0.95)
    check_zone(INDICATORS["cycle_time_p95"], 60.0, 300.0)
    check_zone(INDICATORS["T"], 1e6)  # without a target nothing is known of times


NAMES, KEYS = {**slips.NAMES, **fresh_slips.NAMES}, {**slips.KEYS, **fresh_slips.KEYS}


@pytest.mark.parametrize("target", NAMES)
def test_an_indicator_by_another_name_is_named(target):
    with pytest.raises(StudyError, match=f"did you mean '{NAMES[target]}'"):
        read_target(target, UnitNames())


@pytest.mark.parametrize("key", KEYS)
def test_a_key_or_policy_by_another_name_is_named(key):
    key, _, value = (key if "=" in key else f"{key}=1").partition("=")
    with pytest.raises(ModelError, match=KEYS.get(f"{key}={value}", KEYS.get(key))):
        dw.load(slips.PLANNER, {key: value})


def test_a_cycle_time_below_the_handling_is_asked_about():
    model = base("goods")  # 15 s to load and 30 s to unload
    assert too_short("cycle_time_p95 <= 3", model).endswith("take 45, so no fleet meets it; did you mean 3 min?")
    assert too_short("cycle_time_p95 <= 46", model) == ""
    assert too_short("on_time >= 95 %", model) == ""
    assert too_short("cycle_time_cv <= 0.5", model) == ""


def test_a_cycle_time_is_held_against_the_times_of_its_flow_and_of_stations_that_have_their_own():
    """Handling takes 15 and 30 s; of `small` 5 and 30, and a packer takes 4 s for any load."""
    flow = {"from": "storage", "to": "packing", "arrivals": {"poisson": 20}}
    flows = {
        "tasks.goods": dw.UNSET,
        "tasks.unload_at": dw.UNSET,
        "tasks.flows": {"small": {**flow, "load_time": 5}, "large": flow},
    }
    model = base("goods").replace(flows)
    assert "alone take 45," in too_short("cycle_time_p95:large <= 40", model)
    assert "alone take 35," in too_short("cycle_time_p95:small <= 30", model)
    assert "alone take 35," in too_short("cycle_time_p95 <= 30", model)
    quick = model.replace({"layout.stations.packing.unload_time": 4})
    assert too_short("cycle_time_p95 <= 10", quick) == ""
    assert "alone take 19," in too_short("cycle_time_mean:large <= 10", quick)


def test_a_due_time_of_300_minutes_is_asked_about(tmp_path):
    done = CliRunner().invoke(desim, ["new", str(tmp_path / "w.yaml"), "--due", "300"])
    assert "300 is 300 min; for seconds write 300s" in done.stderr
    for right in ("300s", "5h", "20"):
        done = CliRunner().invoke(desim, ["new", str(tmp_path / "w.yaml"), "--force", "--due", right])
        assert done.stderr == "", right


# What is usual


def usual_of_the_model():
    left, seen = [Model], set()
    while left:
        section = left.pop()
        if section not in seen:
            seen.add(section)
            fields = section.model_fields.values()
            left += [inner for field in fields for inner in sections_in(field.annotation)]
            yield from ((section, note) for field in fields for note in field.metadata if isinstance(note, Usual))


def test_every_range_can_be_read():
    ranges = list(usual_of_the_model())
    assert len(ranges) > 40
    for section, usual in ranges:
        for kind in ("time", "length", "speed", "acceleration", "share"):
            try:
                low, high = usual.between(kind)
            except ValueError:
                continue
            assert 0 <= low < high, section
            break
        else:
            pytest.fail(f"{section.__name__}: {usual}")


@pytest.mark.parametrize(
    ("units", "is_unusual"),
    [
        ({"time": "min", "seconds": 60}, False),  # 40 min
        ({"time": "step", "seconds": 0.05}, True),  # 2 s
        ({"time": "step"}, False),  # nobody knows how long a step is
        pytest.param({"length": "px"}, False, marks=pytest.mark.long),
        ({}, True),
    ],
)
def test_a_time_is_held_against_seconds_only_where_the_model_says_how_long_its_unit_is(units, is_unusual):
    changes = {
        "units": units,
        slips.BREAKS: {"every": 1e6, "repair": 40},
        "accept": ["BATTERY_TOO_SMALL", "NO_CHARGER"],
    }
    findings = check(base("goods").replace(changes)).findings
    assert any("repair" in item.place and "is unusual" in item.text for item in findings) is is_unusual


def test_prices_in_other_currencies_are_not_judged():
    yen = slips.prices(currency="JPY", robot=600_000, station_hour=2_500, late_order=1_500)
    findings = check(base("goods").replace(yen)).findings
    assert not [item for item in findings if item.code == "UNUSUAL"]


def drafts(count):
    """Random drafts with what people add to them, from one seed."""
    dice = random.Random(39)
    for _ in range(count):
        size = dice.randint(20, 70), dice.randint(15, 50)
        words = Draft(size=size, orders=float(dice.randint(20, 200)), due=float(dice.choice([5, 8, 15, 30, 60, 120])))
        added = [
            {"fleet.robot.breakdowns": {"every": f"{dice.randint(1, 200)} h", "repair": f"{dice.randint(2, 60)} min"}},
            {"tasks.load_time": {"lognormal": {"mean": dice.randint(3, 40), "cv": 0.5}}},
            {"layout.stations.packing.work_time": dice.randint(5, 60)},
            {"people": {"pickers": {"per_hour": dice.randint(1, 20), "stay": f"{dice.randint(15, 90)} s"}}},
            {"fleet.robot.delays": {"share": dice.choice([0.01, 0.05, 0.1]), "time": dice.choice([1, 5, 20])}},
            {"tasks.demand": dice.choice([0.7, 0.8, 1.2, 1.3, 2])},
            {"prices": {**slips.MONEY, "currency": dice.choice(["EUR", "USD"]), "robot": dice.randint(500, 12_000)}},
        ]
        changes = {key: value for one in dice.sample(added, 2) for key, value in one.items()}
        yield words, changes


@pytest.mark.parametrize("count", [1, pytest.param(45, marks=pytest.mark.long)])
def test_nothing_is_said_of_random_drafts(count):
    for words, changes in drafts(count):
        model = Model.model_validate(read_yaml(draft(words), "draft").data).replace(changes)
        findings = [str(item) for item in check(model).findings if item.code in SLIPS]
        assert findings == [], (words, changes)
