"""Each answer comes with what a question returns, in a process that has imported nothing but that question."""

import json
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from desim_warehouse.answer.answer import load
from tests.daily import some

MODELS = Path(__file__).parents[2] / "models"
MULTIBOTS, TUTORIAL = MODELS / "multibots.yaml", MODELS / "tutorial.yaml"
DETOUR = """\
name: a short cut that leads the wrong way
layout:
  nodes: {A: [0, 0], B: [20, 0], C: [40, 0], D: [40, 20], E: [20, 20], F: [0, 20]}
  edges: [[A, B], [B, C], [C, D], [D, E], [E, F], [F, A], [E, B]]
  storage: [{edge: [E, F], offset: 5}, {edge: [E, F], offset: 10}, {edge: [A, B], offset: 10}]
  bays: {home: {at: [C], places: 3}}
  stations: {pack: {at: [A], places: 3, servers: 3}}
fleet: {size: 2, robot: {radius: 0.3, speed: 1, margin: 0.1}}
tasks: {goods: {saturated: 6}, unload_at: [pack], load_time: 2, unload_time: 2}
run: {length: 300}
"""
SOME = "--set 'tasks.goods={random: 3}' --first 2 --cap 2"
MET = "--target 'T <= 9999'"
COMMANDS = {
    "why": f"why {MULTIBOTS} {SOME}",
    "best": f"best {MULTIBOTS} --vary fleet.size=1,2 --indicator T {SOME}",
    "best of many": f"best {MULTIBOTS} --vary fleet.size=1..6 --indicator T {MET} --runs 50 {SOME}",
    "size": f"size {MULTIBOTS} --range 1..2 {MET} {SOME}",
    "most": f"size {MULTIBOTS} --range 1..2 {SOME}",
    "plan": f"plan {TUTORIAL} --robots 1..2 {MET} --runs 40 {SOME}",
    "what-if": f"what-if {MULTIBOTS} --vary fleet.size=1,2 --replications 2 --set 'tasks.goods={{random: 3}}'",
}
"""Each imports its verb from its own module."""
FEW = "Search(first=2, cap=2, runs=60, out='out')"
VERBS = {
    "best.best": f"best('model.yaml', 'T', vary={{'fleet.size': [1, 2]}}, search={FEW})",
    "why.why": f"why('model.yaml', search={FEW})",
    "orient.orient": f"orient('detour.yaml', 'throughput_per_hour', search={FEW})",
    "plan.options.plan_options": (
        f"plan_options({{'A': 'model.yaml', 'B': 'model.yaml'}}, 'T <= 9999', robots=[1], chargers=[1], search={FEW})"
    ),
}
START = "from desim_warehouse.cli import main; main()"


def in_a_fresh_process(folder, *arguments):
    """Run Python in a folder, and return what it prints."""
    done = subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("name", some(COMMANDS, 7))
def test_a_command_prints_the_answer_and_keeps_it(name, tmp_path):
    command = COMMANDS[name]
    printed = json.loads(in_a_fresh_process(tmp_path, "-c", START, *shlex.split(command), "--out", "out", "--json"))
    kept = load(tmp_path / "out")
    assert printed["answer"] == list(kept.answer)
    assert printed["command"] == kept.command != ""


@pytest.mark.long
def test_better_directions_are_printed_and_kept(tmp_path):
    """Every day, in the process of other tests, the command of `test_folders`."""
    (tmp_path / "detour.yaml").write_text(DETOUR, "utf-8")
    command = "orient detour.yaml -o turned.yaml --indicator throughput_per_hour --runs 60 --study out"
    printed = in_a_fresh_process(tmp_path, "-c", START, *command.split())
    assert printed.splitlines()[:-1] == list(load(tmp_path / "out").answer)


@pytest.mark.parametrize("question", some(VERBS, 4))
def test_a_verb_from_its_own_module_returns_the_answer_and_keeps_it(question, tmp_path):
    small = MULTIBOTS.read_text("utf-8").replace("goods: [11, 8, 39, 28, 53, 1, 69, 42, 79, 6]", "goods: [11, 8]")
    (tmp_path / "model.yaml").write_text(small, "utf-8")
    (tmp_path / "detour.yaml").write_text(DETOUR, "utf-8")
    module, _, verb = question.rpartition(".")
    lines = [
        "import json",
        f"from desim_warehouse.questions.{module} import {verb}",
        "from desim_warehouse.study.search import Search",
        f"print(json.dumps({VERBS[question]}.answer.content()))",
    ]
    printed = in_a_fresh_process(tmp_path, "-c", "\n".join(lines))
    assert json.loads(printed) == load(tmp_path / "out").content()
