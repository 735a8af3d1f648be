"""`desim replay`: from a model or a run folder to a page, in one line."""

import json
import re

import pandas as pd
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from desim_warehouse.replay.tiles import tiles
from tests.lasting import LASTING
from tests.report.replay.floors import paper_run

pytestmark = pytest.mark.usefixtures("brief_probes")

MODEL = "models/multibots.yaml"


def call(*arguments):
    result = CliRunner().invoke(desim, ["replay", *map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_a_model_is_simulated_and_shown(tmp_path):
    out = tmp_path / "six.html"
    assert "six.html: 0.1 MB" in call(MODEL, "-o", out)
    assert out.read_text(encoding="utf-8") == paper_run().replay().html


def test_settings_seed_window_and_palette_are_taken(tmp_path):
    out = tmp_path / "two.html"
    settings = ["--set", "fleet.size=2", "--set", "tasks.goods={random: 4}", "--seed", 5]
    call(MODEL, "-o", out, *settings, "--from", 100, "--to", 400, "--palette", "paper")
    run = dw.simulate(dw.load(MODEL, {"fleet.size": 2, "tasks.goods": {"random": 4}}), seed=5, until=400)
    assert out.read_text(encoding="utf-8") == run.replay(start=100, end=400, palette="paper").html


def test_the_clock_stops_at_the_end_of_the_window_and_robots_are_where_they_are_in_the_whole_run():
    model = dw.load("models/medium.yaml", {"log": "all"})
    part, whole = dw.simulate(model, until=240), dw.simulate(model.replace({"run.length": 600, "run.warm_up": 0}))
    assert part.record.end == 240
    pd.testing.assert_frame_equal(part.positions(range(0, 240, 7)), whole.positions(range(0, 240, 7)))


def test_what_is_counted_is_counted_from_the_start_of_the_window(tmp_path):
    out = tmp_path / "page.html"
    call("models/medium.yaml", "-o", out, "--from", "5min", "--to", "10min")
    header = json.loads(re.search(r'id="header">(.*?)</script>', out.read_text(encoding="utf-8"))[1])["runs"][0]
    run = dw.simulate(dw.load("models/medium.yaml", {"log": "all"}), until=600)
    done = [task.delivered for task in run.history.tasks.values() if 300 <= task.delivered <= 600]
    assert (header["begin"], header["start"], header["end"]) == (300, 300, 600)
    (tile,) = [one for one in tiles(run.history.since(300)) if one.key == "tasks"]
    assert (tile.title, tile.curve[1][-1]) == ("Delivered", len(done))


@pytest.mark.parametrize(
    ("window", "message"), [(("--to", 0), "0 is not after"), (("--from", 9, "--to", 5), "5 is not")]
)
def test_a_window_that_ends_before_it_begins_is_refused_before_anything_is_simulated(window, message):
    result = CliRunner().invoke(desim, ["replay", "models/large.yaml", *map(str, window)])
    assert (result.exit_code, message in result.output) == (2, True)


def test_a_run_folder_is_shown_as_it_was(tmp_path):
    paper_run().save(tmp_path / "run")
    call(tmp_path / "run", "-o", tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == paper_run().replay().html


def test_settings_for_a_run_that_is_over_are_refused(tmp_path):
    paper_run().save(tmp_path / "run")
    with pytest.raises(ReportError, match="--set is for models"):
        call(tmp_path / "run", "--set", "fleet.size=2")


def test_another_run_stands_beside_it(tmp_path):
    paper_run().save(tmp_path / "run")
    out = tmp_path / "two.html"
    call(MODEL, "--set", "fleet.size=2", "--beside", tmp_path / "run", "-o", out, "--to", 500)
    run = dw.simulate(dw.load(MODEL, {"fleet.size": 2}), until=500)
    assert out.read_text(encoding="utf-8") == run.replay(end=500, beside=paper_run()).html
    call(tmp_path / "run", "--beside", MODEL, "-o", out)
    assert out.read_text(encoding="utf-8") == paper_run().replay(beside=paper_run()).html


def test_a_model_that_records_too_little_is_told_what_to_set():
    with pytest.raises(ReportError, match=r"needs log: all \(now log: tasks\).*--set log=all"):
        call(MODEL, "--set", "log=tasks")


def test_a_new_user_s_model_is_replayed_and_reported_whatever_its_log_says(tmp_path):
    model = tmp_path / "w.yaml"
    new = ["new", str(model), "--size", "16x14", "--orders", "60/h", "--due", "3"]
    assert CliRunner().invoke(desim, new, catch_exceptions=False).exit_code == 0
    assert dw.load(model).log == "tasks"
    changes = {"run.length": 1800, "run.warm_up": 600, **LASTING}
    short = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    call(model, *short, "-o", tmp_path / "page.html")
    assert "desimReplay" in (tmp_path / "page.html").read_text(encoding="utf-8")
    made = CliRunner().invoke(desim, ["report", str(model), *short, "-o", str(tmp_path / "report.html")])
    assert made.output.strip() == str(tmp_path / "report.html")
    first = (tmp_path / "report.html").read_text(encoding="utf-8").partition("<details")[0]
    assert "tasks an hour" in first
    assert "How it went by the clock" in first
    refused = CliRunner().invoke(desim, ["report", str(tmp_path), "--set", "fleet.size=2"])
    assert refused.exit_code == 2
    assert "--set is for models" in refused.output
