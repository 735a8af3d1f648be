"""`desim replay`: from a model or a run folder to a page, in one line."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from tests.report.replay.floors import paper_run

if TYPE_CHECKING:
    from pathlib import Path

MODEL = "models/multibots.yaml"


def call(*arguments: object) -> str:
    result = CliRunner().invoke(desim, ["replay", *map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_a_model_is_simulated_and_shown(tmp_path: Path) -> None:
    out = tmp_path / "six.html"
    assert "six.html: 0.1 MB" in call(MODEL, "-o", out)
    assert out.read_text(encoding="utf-8") == paper_run().replay().html


def test_settings_seed_window_and_palette_are_taken(tmp_path: Path) -> None:
    out = tmp_path / "two.html"
    settings = ["--set", "fleet.size=2", "--set", "tasks.goods={random: 4}", "--seed", 5]
    call(MODEL, "-o", out, *settings, "--from", 100, "--to", 400, "--palette", "paper")
    run = dw.simulate(dw.load(MODEL, {"fleet.size": 2, "tasks.goods": {"random": 4}}), seed=5)
    assert out.read_text(encoding="utf-8") == run.replay(start=100, end=400, palette="paper").html


def test_a_run_folder_is_shown_as_it_was(tmp_path: Path) -> None:
    paper_run().save(tmp_path / "run")
    call(tmp_path / "run", "-o", tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == paper_run().replay().html


def test_settings_for_a_run_that_is_over_are_refused(tmp_path: Path) -> None:
    paper_run().save(tmp_path / "run")
    with pytest.raises(ReportError, match="--set is for models"):
        call(tmp_path / "run", "--set", "fleet.size=2")


def test_another_run_stands_beside_it(tmp_path: Path) -> None:
    paper_run().save(tmp_path / "run")
    out = tmp_path / "two.html"
    call(MODEL, "--set", "fleet.size=2", "--beside", tmp_path / "run", "-o", out, "--to", 500)
    run = dw.simulate(dw.load(MODEL, {"fleet.size": 2}))
    assert out.read_text(encoding="utf-8") == run.replay(end=500, beside=paper_run()).html
    call(tmp_path / "run", "--beside", MODEL, "-o", out)
    assert out.read_text(encoding="utf-8") == paper_run().replay(beside=paper_run()).html


def test_a_model_that_records_too_little_is_told_what_to_set() -> None:
    with pytest.raises(ReportError, match=r"needs log: all \(now log: tasks\).*--set log=all"):
        call(MODEL, "--set", "log=tasks")


def test_a_new_user_s_model_is_replayed_and_reported_whatever_its_log_says(tmp_path: Path) -> None:
    model = tmp_path / "w.yaml"
    new = ["new", str(model), "--size", "16x14", "--orders", "60/h", "--due", "3"]
    assert CliRunner().invoke(desim, new, catch_exceptions=False).exit_code == 0
    assert dw.load(model).log == "tasks"
    short = ["--set", "run.length=1800", "--set", "run.warm_up=600"]
    call(model, *short, "-o", tmp_path / "page.html")
    assert "desimReplay" in (tmp_path / "page.html").read_text(encoding="utf-8")
    made = CliRunner().invoke(desim, ["report", str(model), *short, "-o", str(tmp_path / "report.html")])
    assert made.output.strip() == str(tmp_path / "report.html")
    first = (tmp_path / "report.html").read_text(encoding="utf-8").partition("<h2")[0]
    assert "tasks an hour" in first
    assert "Robots wait here" in first
    refused = CliRunner().invoke(desim, ["report", str(tmp_path), "--set", "fleet.size=2"])
    assert refused.exit_code == 2
    assert "--set is for models" in refused.output
