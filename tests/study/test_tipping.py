"""Up to where a fleet is enough: plants whose thresholds are known, and what is said of them."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ModelError, StudyError
from desim_warehouse.questions import tipping
from desim_warehouse.report.write import report
from desim_warehouse.study.designs.thresholds import DAYS, EXACT_DAYS, HALVINGS, _Input, threshold_steps
from desim_warehouse.study.statistics.procedure import follow
from desim_warehouse.study.target import read_target
from tests.report.test_answer import is_everywhere
from tests.report.test_report import needs_nothing_from_outside
from tests.study.tipping_banks import SHAPES, Plant, judged, searched, shaped

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


def probed(goal, high, run, days=DAYS):
    """An input from 0 to `high` after its search, and the values at which it was probed."""
    asked = []

    def number(_, value):
        if value not in asked:
            asked.append(value)
        return asked.index(value)

    ranged = _Input("tasks.load_time", 0.0, high, read_target(goal))
    runs = follow(threshold_steps([ranged], number, days), lambda design, day: run(asked[design], day))
    assert runs == len(asked) * days
    return ranged.threshold(), asked


def test_the_range_is_halved_around_the_threshold():
    """Of an input x the fleet does 100 - x, and 93.5 are enough, up to 6.5. In four probes: 8, 4, 6 and 7."""
    threshold, asked = probed("throughput_per_hour >= 93.5", 16.0, lambda x, day: 100 - x + 0.01 * (day - 4.5))
    assert asked == [0, 16, 8, 4, 6, 7]
    assert (threshold.at, threshold.within, threshold.confirmed) == (pytest.approx(6.5, abs=0.01), (6, 7), True)


def test_without_randomness_one_run_decides_on_each_probe():
    threshold, asked = probed("throughput_per_hour >= 93.5", 16.0, lambda x, _: 100 - x, EXACT_DAYS)
    assert asked == [0, 16, 8, 4, 6, 7]
    assert (threshold.at, threshold.within, threshold.confirmed) == (6.5, (6, 7), True)


def test_a_threshold_at_a_step_is_anywhere_between_the_probes_around_it():
    """Late from 9.9 on: between the probes at 9 and 10 nothing says where, so that a curve through them would err."""
    threshold, asked = probed("cycle_time_mean <= 100", 16.0, lambda x, day: 50 + 100 * (x > 9.9) + day)
    assert asked == [0, 16, 8, 12, 10, 9]
    assert (threshold.within, threshold.confirmed) == ((9, 10), True)


def test_around_a_probe_that_its_days_do_not_decide_both_sides_are_searched():
    """Means are 92 + x, odd days 2 more and even days 2 less, so that 10 days show a difference of 1.5 or more.

    The standard error is 2 / 3, and 2.26 of these are 1.51: of means 92 to 108 against 100, all but 99 to 101 differ.
    """
    threshold, asked = probed("cycle_time_mean <= 100", 16.0, lambda x, day: 92 + x + (2 if day % 2 else -2))
    assert asked == [0, 16, 8, 4, 12, 6]
    assert (threshold.at, threshold.within, threshold.confirmed) == (pytest.approx(8), (6, 12), True)


def test_a_side_that_no_probe_shows_ends_with_the_range_and_is_not_confirmed():
    threshold, _ = probed("cycle_time_mean <= 107", 16.0, lambda x, day: 92 + x + (2 if day % 2 else -2))
    assert threshold.within[0] < 15 <= threshold.within[1] == 16
    assert not threshold.confirmed


def test_a_search_that_starts_anew_forgets_the_run_that_seemed_exact():
    ranged = _Input("tasks.load_time", 0.0, 16.0, read_target("cycle_time_mean <= 100"))
    for days in (EXACT_DAYS, DAYS):
        follow(threshold_steps([ranged], lambda _, value: int(100 * value), days), lambda x, day: 92 + x / 100 + day)
    assert {len(values) for values in ranged.days.values()} == {DAYS}


def test_thresholds_of_made_up_plants_lie_in_their_intervals():
    right = []
    for number in range(20):
        thresholds, runs = searched(Plant(number))
        right += judged(Plant(number), thresholds)[0]
        assert runs <= (2 + HALVINGS) * DAYS * len(thresholds)
    assert len(right) >= 30
    assert sum(right) >= 0.85 * len(right)


@pytest.mark.parametrize("shape", SHAPES)
def test_thresholds_lie_in_their_intervals_whatever_the_shape_of_the_mean(shape):
    """A parabola through the last three probes held 23 % of the steps, and 69 % of the stations near full load."""
    right = [inside for inside, _, _ in shaped(shape, 15)]
    assert len(right) >= 13
    assert sum(right) >= len(right) - 2


@pytest.mark.long
@pytest.mark.parametrize("shape", SHAPES)
def test_95_of_100_thresholds_lie_in_their_intervals(shape):
    told = shaped(shape, 400)
    assert len(told) >= 380
    assert sum(inside for inside, _, _ in told) >= 0.95 * len(told)
    assert np.median([wide for _, wide, _ in told]) <= 0.4


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
    sentences = json.loads(done.stdout)["answer"] if as_json else [done.stdout]
    assert sentences[0].startswith("5 robots are")
    assert (out / "answer.json").is_file()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("tasks.load_tim=1..2", "tasks.load_tim=1..2: no key of a model"),
        ("tasks.load_time=5", "tasks.load_time=5: no range"),
        ("nowhere.yaml", "nowhere.yaml: no KEY=LOW..HIGH, and no file"),
        ("tasks.load_time=9..3", "tasks.load_time=9..3: no range, expected the lower value first"),
    ],
)
def test_what_is_no_range_is_refused(file, given, message):
    words = ["plan", str(file), "--target", TARGET_HERE, "--robots", "6", "--quiet"]
    done = CliRunner().invoke(desim, [*words, "--uncertain", given])
    assert isinstance(done.exception, ModelError | StudyError)
    assert message in str(done.exception)


def test_what_cannot_be_looked_at_is_refused(file):
    model = dw.load(file)
    with pytest.raises(StudyError, match=r"uncertain fleet.robot.speed: 0 cannot be simulated"):
        dw.tipping_points(model, "on_time >= 80 %", {"fleet.robot.speed": (0.0, 1.0)})
    with pytest.raises(StudyError, match="50 runs: too few for 1 inputs, expected at least 60"):
        dw.tipping_points(model, TARGET_HERE, {"fleet.robot.speed": (0.5, 1.0)}, search=dw.Search(runs=50))
    with pytest.raises(StudyError, match="uncertain: nothing"):
        dw.tipping_points(model, TARGET_HERE, {})
