"""The line before every answer: what the hand calculation warns of, on standard error."""

import json
import shlex

import pytest

from desim_warehouse.study.execution.time_limit import TimeLimit, TimeOutError
from tests.docs import pages

pytestmark = pytest.mark.usefixtures("brief_probes")

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


FLAT_AT_NIGHT = {
    "layout.bays": "{home: {at: [A], places: 3, chargers: 0}, plug: {at: [C], places: 1}}",
    "battery": "{capacity: 3600, consumption: 0.5, charge_rate: 0.4}",
    "policies.charging": "four-thresholds",
    "fleet.size": "3",
    "run.length": "24h",
}
"""Of three robots one can charge, and what it gets is less than the others draw standing."""


def test_a_machine_that_is_too_busy_changes_no_warning(at, monkeypatch):
    """Any limit of time is over as soon as it begins; the night, which is simulated, is among the warnings."""
    at(80)

    def over(*_):
        raise TimeOutError

    monkeypatch.setattr(TimeLimit, "__enter__", over)
    changes = " ".join(f"--set {shlex.quote(f'{key}={value}')}" for key, value in FLAT_AT_NIGHT.items())
    findings = json.loads(pages.run_desim(f"desim check w.yaml --json {changes}")[1])["findings"]
    codes = [item["code"] for item in findings if item["level"] == "warning"]
    assert codes == ["DEMAND_ABOVE_FLEET", "CHARGERS_SHORT", "NIGHT_FLAT"]
    err = pages.run_desim(f"desim run w.yaml {changes}")[2]
    assert err.startswith(f"3 warnings of the check: {', '.join(codes)} (")


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
    assert " the smallest fleet shown to be enough: " in out
    status, _, err = pages.run_desim("desim size w.yaml --key tasks.demand --target 'on_time >= 50 %'")
    assert status == 2
    assert "needs --range VALUES" in err
