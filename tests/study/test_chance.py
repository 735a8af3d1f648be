"""Procedures know whether one run is exact: from the models, and from the runs where models cannot say."""

from itertools import product

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.model import Model
from desim_warehouse.study.procedures import race

from .conftest import ROOT

pytestmark = pytest.mark.usefixtures("brief_probes")

TUTORIAL = ROOT / "models/tutorial.yaml"
LIST = ["--set", "tasks.goods=[0, 3, 5, 7, 2, 4]"]
CHANCE = {
    "breakdowns": "fleet.robot.breakdowns={every: {exponential: 60}, repair: {exponential: 30}}",
    "delays": "fleet.robot.delays={share: 0.3, time: 5}",
    "people": "people.p={per_hour: 60, stay: 30}",
    "outages": "layout.bays.parking.outages={every: {exponential: 60}, repair: {exponential: 30}}",
    "kinds": "fleet.kinds.old={count: 1, breakdowns: {every: {exponential: 60}, repair: 30}}",
}
COMMANDS = {
    "size": ["size", "--key", "fleet.size", "--range", "2..3", "--target", "T <= 150", "--first", "2", "--cap", "2"],
    "plan": ["plan", "--target", "T <= 150", "--robots", "2..3", "--first", "2", "--cap", "2"],
    "best": ["best", "--vary", "fleet.size=2,3", "--indicator", "T", "--delta", "5", "--first", "2", "--cap", "2"],
    "why": ["why", "--first", "2", "--cap", "2"],
    "what-if": ["what-if", "--vary", "fleet.size=2,3", "--replications", "2"],
}


def said(command, *changes):
    name, *options = COMMANDS[command]
    given = [part for change in changes for part in ("--set", change)]
    result = CliRunner().invoke(desim, [name, str(TUTORIAL), *options, *LIST, *given])
    assert result.exit_code in {0, 3}, result.output
    return result.output


# each command has one of them every day, and each of them a command
@pytest.mark.parametrize(
    ("command", "change"),
    [
        pytest.param(*one, marks=[] if one[0] == "what-if" or one[1] == "breakdowns" else [pytest.mark.long])
        for one in product(COMMANDS, CHANCE)
    ],
)
def test_no_command_calls_a_list_of_goods_exact_where_chance_plays_a_part(command, change):
    output = said(command, CHANCE[change])
    assert "exact" not in output
    assert "deterministic" not in output
    assert "(one run)" not in output


@pytest.mark.parametrize("command", ["size", "best", "why", "what-if"])
def test_a_list_of_goods_and_nothing_else_is_exact(command):
    output = said(command)
    assert "exact" in output or "deterministic" in output


def study(changes):
    made = dw.Study(TUTORIAL, {"fleet.size": [1, 2]}, changes=changes)
    made.plan = made.plan.unreplicated()
    return made


def test_one_storage_place_is_compared_exactly():
    """Whatever is drawn is the same good: sixteen replications could say no more than one."""
    only = {"tasks.goods": {"saturated": 4}, "tasks.popularity": {"weights": [1, *[0] * 11]}, "run.length": 900}
    sizing = dw.size(study(only), "throughput_per_hour >= 10")
    assert all(decision.deterministic and decision.n == 1 for decision in sizing.decisions)
    assert race(study(only), "throughput_per_hour").selection.deterministic


def test_runs_show_that_no_chance_was_used_where_a_model_cannot_say():
    """People who come when all is done: which aisle they choose is drawn, but never for this work."""
    late = {"tasks.goods": [0, 3], "people.p": {"times": [10_000], "stay": 5}}
    assert not dw.load(TUTORIAL, late).is_deterministic
    sizing = dw.size(study(late), "T <= 1000", search=dw.Search(first=4))
    assert all(decision.deterministic for decision in sizing.decisions)
    assert race(study(late), "T", 1).selection.deterministic


def test_runs_that_draw_are_not_exact_whatever_models_say(monkeypatch):
    """A model that forgot to say so: the first run that drew a number corrects it."""
    monkeypatch.setattr(Model, "is_deterministic", True)
    choice = race(study({"tasks.goods": {"random": 5}}), "T", 1000, search=dw.Search(first=3))
    assert not choice.selection.deterministic
    assert choice.selection.samples == (3, 3)
