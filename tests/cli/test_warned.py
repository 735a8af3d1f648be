"""The line before every answer: what the hand calculation warns of, on standard error."""

import json
import threading

import pytest

from desim_warehouse import feasibility
from desim_warehouse.cli import warned
from tests.docs import pages

MODEL = """\
layout:
  nodes: {A: [0, 0], B: [30, 0], C: [30, 10], E: [0, 10]}
  edges: [[A, B], [B, C], [C, E], [E, A]]
  storage: [{edge: [B, C], offset: 5}]
  bays: {home: {at: [A]}}
  stations: {desk: {at: [E]}}
fleet: {size: 1, robot: {radius: 0.3, speed: 1}}
tasks: {unload_at: [desk], goods: {poisson: RATE, due_within: 600}, load_time: 5, unload_time: 5}
run: {length: 3600}
"""
ANSWERS = {
    "run": "desim run w.yaml",
    "what-if": "desim what-if w.yaml --vary fleet.size=1,2 --quiet",
    "size": "desim size w.yaml --range 1..2 --target 'on_time >= 50 %' --first 2 --cap 2 --quiet",
    "most": "desim size w.yaml --range 1..2 --first 2 --cap 2 --quiet",
    "best": "desim best w.yaml --vary fleet.size=1,2 --indicator T --delta 50 --first 2 --cap 2 --quiet",
    "why": "desim why w.yaml --first 2 --cap 2 --quiet",
    "plan": "desim plan w.yaml --target 'on_time >= 50 %' --robots 1..2 --first 2 --cap 2 --quiet",
}
LINE = "1 warning of the check: DEMAND_ABOVE_FLEET (desim check w.yaml)"


@pytest.fixture
def at(tmp_path, monkeypatch):
    def written(rate):
        (tmp_path / "w.yaml").write_text(MODEL.replace("RATE", str(rate)), encoding="utf-8")
        monkeypatch.chdir(tmp_path)

    return written


@pytest.mark.parametrize("command", ANSWERS.values(), ids=ANSWERS)
def test_every_answer_begins_with_what_check_warns_of(command, at):
    """A ring of 80 m takes a robot 90 s a task, and 80 an hour are asked for."""
    at(80)
    _, out, err = pages.run_desim(command)
    assert err.splitlines()[0] == LINE
    assert "of the check" not in out
    at(30)
    assert "of the check" not in pages.run_desim(command)[2]


@pytest.mark.parametrize("name", ["run", "why", "plan"])
def test_json_has_the_warnings_and_the_line_is_left_out(name, at):
    at(80)
    _, out, err = pages.run_desim(f"{ANSWERS[name]} --json")
    (warning,) = json.loads(out)["warnings"]
    assert warning["code"] == "DEMAND_ABOVE_FLEET"
    assert "of the check" not in err


def test_the_line_names_the_changes_and_counts_what_comes_twice(at):
    at(80)
    _, _, err = pages.run_desim("desim run w.yaml --set fleet.robot.speed=4 --set tasks.goods.poisson=900")
    assert err.startswith("3 warnings of the check: FAST, DEMAND_ABOVE_FLEET, DEMAND_ABOVE_STATIONS ")
    assert err.endswith(" (desim check w.yaml --set fleet.robot.speed=4 --set tasks.goods.poisson=900)\n")
    _, _, err = pages.run_desim("desim run w.yaml --set tasks.load_time=3600 --set tasks.unload_time=3600")
    assert "LONG_HANDLING" in err


def test_what_takes_too_long_by_hand_is_left_out_and_said(at, monkeypatch):
    at(80)
    monkeypatch.setattr(warned, "MOST_TIME", 0.02)
    monkeypatch.setattr(feasibility, "examine", lambda *_: sum(1 for _ in iter(int, 1)))  # for ever
    threads = threading.active_count()
    _, out, err = pages.run_desim("desim run w.yaml --json")
    assert json.loads(out)["warnings"] is None
    _, out, err = pages.run_desim("desim run w.yaml")
    assert err == ("warnings of the check: left out, as it takes more than 0.02 s (desim check w.yaml)\n")
    assert "throughput_per_hour" in out
    assert threading.active_count() == threads


def test_a_model_that_is_refused_is_only_refused(at):
    at(80)
    status, _, err = pages.run_desim("desim run w.yaml --set fleet.size=3 --set layout.bays.home.places=1")
    assert status == 2
    assert "of the check" not in err


def test_verdicts_stand_above_tables(at):
    at(80)
    for command in (ANSWERS["run"], ANSWERS["what-if"], ANSWERS["best"]):
        lines = pages.run_desim(f"{command} --set run.length=7200 --set tasks.goods.poisson=200")[1].splitlines()
        verdict = next(rank for rank, line in enumerate(lines) if "cannot keep up" in line.lower())
        table = next(rank for rank, line in enumerate(lines) if "seed 0" in line or line.startswith("option "))
        assert verdict < table, command


def test_size_finds_the_fleets_that_it_looks_at_by_hand(at):
    at(80)
    _, out, err = pages.run_desim("desim size w.yaml --target 'on_time >= 50 %' --first 2 --cap 2 --quiet")
    assert "fleets from 1 to 8, by a quick estimate" in err
    assert " shown to give at least 50 % on time: " in out
    status, _, err = pages.run_desim("desim size w.yaml --key tasks.demand --target 'on_time >= 50 %'")
    assert status == 2
    assert "needs --range VALUES" in err
