"""Up to where a fleet is enough: plants whose thresholds are known, and what is said of them."""

import json
import math
import re

import numpy as np
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ModelError, StudyError
from desim_warehouse.questions import tipping
from desim_warehouse.report.write import report
from desim_warehouse.study.statistics.procedure import follow
from desim_warehouse.study.statistics.thresholds import crossing
from desim_warehouse.study.target import read_target
from desim_warehouse.study.thresholds import DAYS, HALVINGS, _Input, threshold_steps
from tests.report.test_answer import is_everywhere
from tests.report.test_report import needs_nothing_from_outside
from tests.study.tipping_banks import Plant, judged, searched

pytestmark = pytest.mark.usefixtures("brief_probes")

HALL = """\
name: a small hall
layout:
  blocks: {columns: 3, rows: 1, block_width: 2, block_depth: 3, goods_size: 1.2, aisle_width: 3, directions: ring}
  bays: {parking: {at: [A, B, C], places: 4, chargers: 0}}
  stations: {packing: {at: [G], places: 8, servers: 4}}
fleet: {size: 3, start: [parking], robot: {radius: 0.4, speed: 1, margin: 0.2}}
tasks: {goods: {saturated: 16}, unload_at: [packing], load_time: 3, unload_time: 3}
policies: {parking: nearest}
run: {length: 1000, warm_up: 100}
"""
RANGES = {"tasks.load_time": (2.0, 40.0), "tasks.unload_time": (3.0, 4.0)}
TARGET_HERE = "throughput_per_hour >= 150"


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("tipping") / "w.yaml"
    path.write_text(HALL, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def points(file):
    return dw.tipping_points(dw.load(file), TARGET_HERE, RANGES, search=dw.Search(out=file.parent / "points"))


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


def test_the_range_is_halved_around_the_threshold():
    """Of an input x the fleet does 100 - x, and 93.5 are enough, up to 6.5. In four probes: 8, 4, 6 and 7."""
    asked = []

    def number(_, value):
        if value not in asked:
            asked.append(value)
        return asked.index(value)

    ranged = _Input("tasks.load_time", 0.0, 16.0, read_target("throughput_per_hour >= 93.5"))
    runs = follow(threshold_steps([ranged], number, 2), lambda design, day: 100 - asked[design] + 0.01 * (day - 0.5))
    assert asked == [0, 16, 8, 4, 6, 7]
    assert runs == 6 * 2
    assert (ranged.below, ranged.middle, ranged.above) == (6, 7, 8)
    assert ranged.threshold().at == pytest.approx(6.5, abs=0.01)


def test_thresholds_of_made_up_plants_lie_in_their_intervals():
    right = []
    for number in range(20):
        thresholds, runs = searched(Plant(number))
        right += judged(Plant(number), thresholds)[0]
        assert runs <= (2 + HALVINGS) * DAYS * len(thresholds)
    assert len(right) >= 30
    assert sum(right) >= 0.85 * len(right)


def test_the_answer_says_up_to_where_the_fleet_is_enough(points):
    first, second = points.inputs
    assert (first.key, first.enough, first.confirmed) == ("tasks.load_time", (True, False), True)
    assert (second.enough, second.at, second.within) == ((True, True), None, None)
    answer = points.answer
    assert is_everywhere(answer)
    asked = "For which load time and unload time are 3 robots enough: at least 150 tasks an hour?"
    assert answer.question == asked
    threshold = r"Load time, 2 to 40 s: 3 robots are enough up to [\d.]+ s \([\d.]+ to [\d.]+\)\."
    assert re.fullmatch(threshold, answer.answer[0])
    assert answer.answer[1] == "Unload time, 3 to 4 s: 3 robots are enough at both ends."
    assert dw.load(answer.about.model).fleet.size == 3


def test_the_fleet_is_enough_on_one_side_of_its_threshold_and_too_small_on_the_other(points, file):
    low, high = points.inputs[0].within
    below, above = (
        [
            dw.simulate(dw.load(file, {"tasks.load_time": at}), day).kpis["throughput_per_hour"]
            for day in range(100, 108)
        ]
        for at in (low - 1, high + 1)
    )
    assert np.mean(below) > 150 > np.mean(above)


def test_the_folder_of_tipping_points_opens_as_their_page(points, file):
    source = needs_nothing_from_outside(report(file.parent / "points").read_text(encoding="utf-8")).text
    for line in points.answer.answer:
        assert line in source.replace("\u00a0", " ")
    assert "iframe" in points._repr_html_()


def planned(file, *more):
    words = ["plan", str(file), "--target", TARGET_HERE, "--robots", "5", "--vary", "policies.allocation=nearest"]
    words += ["--first", "3", "--cap", "6"]
    words += ["--set", "run.length=400", "--set", "run.warm_up=50", "--quiet"]
    return CliRunner().invoke(desim, [*words, *more])


def test_the_command_has_the_thresholds_in_its_json_and_its_page(file, tmp_path):
    ranges = tmp_path / "w.ranges.yaml"
    ranges.write_text("tasks.load_time: {low: 2, high: 40, n: 9}\nfleet.robot.breakdowns: {low: 9, high: null, n: 1}\n")
    out = tmp_path / "plan"
    both = ["--uncertain", str(ranges), "--uncertain", "tasks.unload_time=3s..4s"]
    done = planned(file, *both, "--json", "--out", str(out))
    assert done.exit_code == 0, done.output
    assert "fleet.robot.breakdowns has no upper end, and is left out" in done.stderr
    uncertain = json.loads(done.stdout)["uncertain"]
    assert {key: (one["low"], one["high"]) for key, one in uncertain["inputs"].items()} == RANGES
    assert uncertain["answer"][0].startswith("Load time, 2 to 40 s: ")
    assert json.loads((out / "answer.json").read_text(encoding="utf-8"))["uncertain"] == uncertain
    page = needs_nothing_from_outside(report(out).read_text(encoding="utf-8"))
    assert uncertain["answer"][0] in page.text.replace("\u00a0", " ")


@pytest.mark.parametrize("as_json", [False, True])
def test_a_failure_of_the_thresholds_loses_nothing_of_the_plan(file, tmp_path, monkeypatch, as_json):
    def fails(*_, **__):
        raise StudyError("no runs today")

    monkeypatch.setattr(tipping, "tipping_points", fails)
    out = tmp_path / "plan"
    done = planned(file, "--uncertain", "tasks.load_time=2..40", "--out", str(out), *["--json"] * as_json)
    assert isinstance(done.exception, StudyError)
    said = json.loads(done.stdout)["answer"] if as_json else [done.stdout]
    assert said[0].startswith("5 robots are")
    assert (out / "answer.json").is_file()


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


def test_what_cannot_be_looked_at_is_refused(file):
    model = dw.load(file)
    with pytest.raises(StudyError, match=r"uncertain fleet.robot.speed: 0 cannot be simulated"):
        dw.tipping_points(model, "on_time >= 80 %", {"fleet.robot.speed": (0.0, 1.0)})
    with pytest.raises(StudyError, match="50 runs: too few for 1 inputs, expected at least 60"):
        dw.tipping_points(model, TARGET_HERE, {"fleet.robot.speed": (0.5, 1.0)}, search=dw.Search(runs=50))
    with pytest.raises(StudyError, match="uncertain: nothing"):
        dw.tipping_points(model, TARGET_HERE, {})
