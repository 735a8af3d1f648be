"""Where uncertain inputs tip the answer: plants whose thresholds are known, and what is said of them."""

import json
import math
import re

import numpy as np
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ModelError, StudyError
from desim_warehouse.questions import plan_words
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.report.write import report
from desim_warehouse.study.statistics.thresholds import LinearNeed, crossing, linear_need, worth
from desim_warehouse.study.tipping import TippingPoints, tipping_points
from tests.report.test_answer import is_everywhere
from tests.report.test_report import needs_nothing_from_outside
from tests.study import tipping_truth
from tests.study.tipping_banks import KEYS, TARGET, Plant, judged, searched

HALL = """\
name: a small hall
layout:
  blocks: {columns: 3, rows: 1, block_width: 2, block_depth: 3, goods_size: 1.2, aisle_width: 3, directions: ring}
  bays: {parking: {at: [A, B, C], places: 4, chargers: 0}}
  stations: {packing: {at: [G], places: 8, servers: 4}}
fleet: {size: 3, start: [parking], robot: {radius: 0.4, speed: 1, margin: 0.2}}
tasks: {goods: {saturated: 16}, unload_at: [packing], load_time: 3, unload_time: 3}
policies: {parking: nearest}
prices: {hours: 2000, robot: 6000, currency: EUR}
run: {length: 1000, warm_up: 100}
"""
RANGES = {"tasks.load_time": (2.0, 40.0), "tasks.unload_time": (2.0, 12.0)}
TARGET_HERE = "throughput_per_hour >= 150"


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("tipping") / "w.yaml"
    path.write_text(HALL, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def found(file):
    return tipping_points(dw.load(file), TARGET_HERE, RANGES, search=dw.Search(out=file.parent / "found"))


def test_a_line_through_needs_is_found_again():
    shares = np.random.default_rng(1).random((12, 2))
    found = linear_need(shares, 6 + 2 * (shares[:, 0] - 0.5) - (shares[:, 1] - 0.5))
    assert found.middle == pytest.approx(6)
    assert found.effects == pytest.approx((2, -1))
    assert found.fit == pytest.approx(1)
    assert found.spread == pytest.approx(0, abs=1e-9)


def test_needs_without_a_pattern_have_a_poor_fit():
    draw = np.random.default_rng(2)
    assert linear_need(draw.random((30, 3)), draw.random(30).tolist()).fit < 0.4


def test_knowing_the_only_input_saves_all_that_not_knowing_costs():
    """Need 5 or 6 with half a chance each: 6 are bought, of which one is too many half the time."""
    found = worth(LinearNeed(5.0, (1.0, 0.0), (0.0, 0.0), 0.0, 1.0))
    assert (found.middle, found.safe, found.doubt) == (5, 6, 0)
    assert found.cost == pytest.approx(0.5, abs=0.01)
    assert found.inputs == pytest.approx((0.5, 0.0), abs=0.01)


def test_a_robot_more_is_worth_it_where_too_few_are_likelier_than_the_confidence_allows():
    """Need 6 with a chance of 3 % only: 5 do with 95 %, 6 with 99 %."""
    need = LinearNeed(4.53, (1.0,), (0.0,), 0.0, 1.0)
    assert worth(need, 0.95).safe == 5
    assert worth(need, 0.99).safe == 6


def test_the_crossing_of_lines_with_noise_of_the_day_only_is_between_its_ends():
    days = np.array([-0.1, 0.0, 0.1, 0.05, -0.05])
    found = crossing([1.0, 2.0, 3.0], np.array([3.0, 2.0, 1.0]) + days[:, None], 1.8)
    assert found.at == pytest.approx(2.2, abs=0.002)
    assert found.high - 2.2 == pytest.approx(2.2 - found.low, abs=0.003)
    assert found.high - 2.2 == pytest.approx(2.776 * np.std(days, ddof=1) / math.sqrt(5), abs=0.003)


def test_without_values_on_both_sides_there_is_no_crossing_and_near_an_end_no_bound():
    values = np.array([3.0, 2.0, 1.0]) + np.array([[-0.4], [0.0], [0.4]])
    assert crossing([1.0, 2.0, 3.0], values, 0.5) is None
    assert crossing([1.0, 2.0, 3.0], values, 1.1).high == math.inf


def test_thresholds_of_made_up_plants_lie_in_their_intervals():
    right, runs, silent = [], [], 0
    for number in range(8):
        plant = Plant(number)
        found = searched(plant)
        runs.append(found.runs)
        silent += not found.says_something
        right += judged(plant, found)[0]
    assert len(right) >= 12
    assert sum(right) >= 0.8 * len(right)
    assert max(runs) <= 250
    assert silent <= 1


def test_large_fleets_that_run_flat_hide_nothing_where_the_search_begins_at_about_the_right_one():
    """With as few chargers as the answer needs."""
    right = []
    for number in range(3):
        plant = Plant(number)
        need = searched(plant).robots
        assert not searched(plant, begin=20, most=need + 3).says_something
        found = searched(plant, begin=need, most=need + 3)
        assert found.says_something
        assert abs(found.robots - need) <= 1
        right += judged(plant, found)[0]
    assert sum(right) >= 0.8 * len(right)


@pytest.mark.long
def test_thresholds_of_two_hundred_plants():
    right = [one for number in range(200) for one in judged(Plant(number), searched(Plant(number)))[0]]
    assert sum(right) >= 0.9 * len(right)


@pytest.mark.long
def test_thresholds_of_plants_that_are_simulated():
    right = [one.inside for number in range(12) for one in tipping_truth.judged(number)[1]]
    assert len(right) >= 12
    assert sum(right) >= 0.8 * len(right)


def silent(target, model):
    """What is found where lines do not fit."""
    return TippingPoints(target, 0.62, 0, 0, math.nan, math.nan, False, (), 150, 0.95, model=model)


def test_where_lines_do_not_fit_nothing_is_said(file):
    found = silent(TARGET, dw.load(file))
    said = found.answer.answer
    assert (found.answer.about, found.answer.tiles, found.answer.figure) == (None, (), None)
    assert said[0] == "Nothing is said of where the answer tips: R² is 0.620, and lines describe it from R² 0.8 on."
    assert len(said) == 2


def test_the_answer_says_which_input_needs_one_robot_more_and_what_knowing_it_is_worth(found, file):
    assert found.runs <= 250
    assert found.says_something
    first, second = found.inputs
    assert first.key == "tasks.load_time"
    assert first.effect > second.effect > 0
    assert first.worth >= second.worth
    answer = found.answer
    assert is_everywhere(answer)
    assert (
        answer.question
        == "How many robots give at least 150 tasks an hour, whatever load time and unload time turn out to be?"
    )
    said = answer.answer
    assert re.match(rf"{found.safe} robots are safe: the chance of too few is [\d.]+ %\.", said[0])
    assert re.match(
        r"In the middle of all ranges \d robots? are enough; not knowing better costs .+ EUR a year\.", said[1]
    )
    assert re.match(r"Load time, 2 to 40 s: \d robots above .+; knowing it is worth .+ EUR a year\.", said[2])
    assert answer.options[0].number.low == pytest.approx(first.effect - first.error)
    assert dw.load(answer.about.model).fleet.size == found.safe
    assert dw.load(answer.about.model).tasks.load_time == 21


def test_the_folder_of_tipping_points_opens_as_their_page(found, file):
    source = needs_nothing_from_outside(report(file.parent / "found").read_text(encoding="utf-8")).text
    for line in found.answer.answer:
        assert line in source.replace("\u00a0", " ")
    assert "Watch this run" not in source
    assert "iframe" in found._repr_html_()


def test_a_fleet_is_enough_on_one_side_of_its_threshold_and_too_small_on_the_other(found, file):
    tip = next(tip for tip in found.inputs[0].tips if tip.confirmed)
    assert f"{tip.robots + 1} robots above" in found.answer.answer[2]
    model = dw.load(file, {"fleet.size": tip.robots, "tasks.unload_time": 7})
    below, above = (
        [
            dw.simulate(model.replace({"tasks.load_time": at}), day).kpis["throughput_per_hour"]
            for day in range(100, 108)
        ]
        for at in (tip.low - 1, tip.high + 1)
    )
    assert np.mean(below) > 150 > np.mean(above)


def test_days_that_agree_on_a_count_by_chance_leave_its_step_open():
    """Of a run of a plant of the truth: with 260 a day at the middle probe the interval had no width."""
    counts = np.array([[268, 268, 264, 264, 268, 268], [260] * 6, [260, 256, 256, 252, 256, 256]], float)
    found = crossing([7.974, 9.197, 10.421], counts.T, 260.0)
    assert found.low < 8.9
    assert found.high > 9.5


def test_where_no_day_differs_a_count_is_told_from_the_target_by_more_than_its_step():
    """The middle probe is at the target; how far towards the others that reaches is not known."""
    found = crossing([1.0, 2.0, 3.0], np.array([[16.0, 8.0, 0.0], [16.0, 8.0, 0.0]]), 8.0)
    assert found.at == pytest.approx(2, abs=0.001)
    assert (found.low, found.high) == (-math.inf, math.inf)
    found = crossing([1.0, 2.0, 3.0], np.array([[16.0, 10.0, 0.0], [16.0, 10.0, 0.0]]), 9.0)
    assert 1 < found.low < 2 < found.at < found.high < 3.0


def test_the_command_has_what_is_not_known_in_its_json(file, tmp_path):
    ranges = tmp_path / "w.ranges.yaml"
    ranges.write_text("tasks.load_time: {low: 2, high: 40, n: 9}\nfleet.robot.breakdowns: {low: 9, high: null, n: 1}\n")
    words = ["plan", str(file), "--target", TARGET_HERE, "--robots", "6", "--vary", "policies.allocation=nearest"]
    words += ["--uncertain", str(ranges), "--uncertain", "tasks.unload_time=2s..0.2min", "--quiet"]
    words += ["--set", "run.length=400", "--set", "run.warm_up=50"]
    out = tmp_path / "plan"
    done = CliRunner().invoke(desim, [*words, "--runs", "200", "--json", "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "fleet.robot.breakdowns has no upper end, and is left out" in done.stderr
    found = json.loads(done.stdout.splitlines()[-1])["uncertain"]
    assert {key: (one["low"], one["high"]) for key, one in found["inputs"].items()} == RANGES
    assert found["runs"] <= 250
    assert "safe: the chance of too few is" in found["answer"][0]
    assert json.loads((out / "answer.json").read_text(encoding="utf-8"))["uncertain"] == found
    page = needs_nothing_from_outside(report(out).read_text(encoding="utf-8"))
    assert found["answer"][0] in page.text
    assert "Allowing for what is not known exactly, " in page.text
    head, *rows = page.tables["what-is-not-known-exactly"]
    assert head[:2] == ["input", "where the answer tips"]
    assert [row[0] for row in rows] == ["load time, 2 to 40 s", "unload time, 2 to 12 s"]
    assert [row[1] in line for row, line in zip(rows, found["answer"][2:], strict=True)] == [True, True]


def test_a_folder_says_where_nothing_is_said_and_one_without_ranges_is_silent(found, file, tmp_path):
    poor = silent(found.target, dw.load(file))
    planned = plan_fleet(dw.load(file), "T <= 1e9", strategies={}, robots=[6])
    answer = plan_words.answer(planned, poor)
    assert "Nothing is said of where the answer tips: R² is 0.620" in answer.tables[0].note
    assert answer.answer[-1] == poor.answer.answer[0]
    assert plan_words.answer(planned).tables == ()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("tasks.load_tim=1..2", "tasks.load_tim=1..2: no key of a model"),
        ("tasks.load_time=5", "tasks.load_time=5: no range"),
        ("nowhere.yaml", "nowhere.yaml: no KEY=LOW..HIGH, and no file"),
        ("tasks.load_time=9..3", "tasks.load_time=9..3: no range, expected the lower value first"),
    ],
)
def test_what_is_no_range_is_refused(file, given, said):
    words = ["plan", str(file), "--target", TARGET_HERE, "--robots", "6", "--quiet"]
    done = CliRunner().invoke(desim, [*words, "--uncertain", given])
    assert isinstance(done.exception, ModelError | StudyError)
    assert said in str(done.exception)


def test_an_end_that_cannot_be_simulated_is_named(file):
    with pytest.raises(StudyError, match=r"uncertain fleet.robot.speed: 0 cannot be simulated"):
        tipping_points(dw.load(file), "on_time >= 80 %", {"fleet.robot.speed": (0.0, 1.0)})
    assert len(KEYS) == len(Plant(0).ranges)
