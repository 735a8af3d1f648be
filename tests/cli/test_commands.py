"""The commands that run, check and describe models, called as the click runner calls them."""

import json
import math

import click
import jsonschema
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import COMMANDS, desim
from desim_warehouse.errors import StudyError
from desim_warehouse.questions.run import words as run_words

pytestmark = pytest.mark.usefixtures("brief_probes")

MODEL = "models/multibots.yaml"


def call(*arguments):
    return CliRunner().invoke(desim, arguments, catch_exceptions=False)


def test_run_prints_one_json_object():
    done = call("run", MODEL, "--json", "--set", "fleet.size=3", "--set", "tasks.goods=[11, 8]", "--seed", "5")
    assert done.exit_code == 0
    [line] = done.stdout.splitlines()
    answer = json.loads(line)
    run = dw.simulate(dw.load(MODEL, {"fleet.size": 3, "tasks.goods": [11, 8]}), seed=5)
    sentences = run_words.sentences(run)
    told = {"answer": sentences, "verdicts": [], "warnings": [], "seed": 5, "version": dw.__version__}
    assert answer == {**run.kpis, **told}
    assert sentences[0].startswith("2 loads delivered in 584 steps")
    assert {"T", "S", "C", "moves", "distance", "energy", "waiting", "cost"} <= set(answer)


def test_what_is_no_number_is_null_in_json():
    answer = json.loads(call("run", "models/tutorial.yaml", "--json", "--set", "run.length=1").stdout)
    # nothing is delivered in 1 s, so there is no cycle time
    assert (answer["tasks"], answer["cycle_time_mean"]) == (0, None)


def test_run_prints_a_table_for_people():
    done = call("run", MODEL, "--set", "fleet.size=1")
    assert done.exit_code == 0
    run = dw.simulate(dw.load(MODEL, {"fleet.size": 1}))
    first, busiest, title, *lines = done.stdout.splitlines()
    # the paper's step is 0.05 s, 6,377.5 steps are 318.9 s
    assert first == "10 loads delivered in 6,378 steps (5.3 min), 113 an hour."
    assert busiest.startswith("The robots were the busiest, at work ")
    assert title == "MultiBots: 1 robot, seed 0"
    shown = by_name(lines)
    assert shown["T"] == "Task time 6,378 steps (5.3 min)"
    assert shown["C"] == "Charging stops 3"
    assert 6 <= len(shown) - 1 <= 10
    assert max(map(len, lines)) <= 100
    every = by_name(call("run", MODEL, "--set", "fleet.size=1", "--indicator", "all").stdout.splitlines())
    assert every["distance"] == f"Distance driven {run.kpis['distance']:,.0f} px"
    assert every["throughput_per_hour"] == "Throughput 113 tasks/h"
    assert every["share_empty"] == f"Fleet driving empty {100 * run.kpis['share_empty']:.1f} %"
    assert set(run.kpis) <= set(every)
    one = call("run", MODEL, "--set", "fleet.size=1", "--indicator", "moves").stdout.splitlines()
    assert list(by_name(one[3:])) == ["name", "moves"]
    with pytest.raises(StudyError, match="did you mean 'moves'"):
        call("run", MODEL, "--indicator", "move")


def by_name(lines):
    """The rows of a table of indicators, by the name at their end."""
    return {line.split()[-1]: " ".join(line.split()[:-1]) for line in lines}


def test_run_prints_seconds_once_and_says_where_there_is_no_value():
    output = call("run", "models/tutorial.yaml", "--set", "run.length=1", "--set", "tasks.goods={saturated: 3}").stdout
    assert output.startswith("0 loads delivered in 1 s")
    assert by_name(output.splitlines())["cycle_time_mean"] == "Cycle time, mean –"


def test_run_writes_a_folder_that_can_be_read_back(tmp_path):
    assert call("run", MODEL, "--out", str(tmp_path / "deep" / "run"), "--set", "fleet.size=2").exit_code == 0
    run = dw.simulate(dw.load(MODEL, {"fleet.size": 2}))
    assert dw.load_run(tmp_path / "deep" / "run").record == run.record


def test_check_says_what_a_planner_should_know():
    done = call("check", MODEL)
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert lines[:2] == ["no errors", "MultiBots: 6 robots, 6 chargers, 80 storage places."]
    assert not [line for line in lines if "ring of" in line or "D =" in line]
    details = call("check", MODEL, "--details").stdout.splitlines()
    assert details[: len(lines)] == lines
    assert details[len(lines) : len(lines) + 3] == [
        "MultiBots: 18 nodes, 27 edges, 80 storage places",
        "robots keep D = 33 px and drive up to 4 px/step",
        # rows: 15 of 150, with floor(150 / 33) - 1 = 3 places; columns: 12 of 250 with floor(250 / 33) - 1 = 6
        "the lanes hold 117 robots at once, the fleet has 6",
    ]
    assert any(line.startswith("ring of ") for line in details)
    assert "quick estimate:" in details


def test_check_finds_errors_and_says_that_the_model_would_be_refused():
    done = call("check", MODEL, "--set", "fleet.start=[A, G, M]")
    assert done.exit_code == 2
    assert done.stdout.splitlines()[:3] == [
        "2 errors: this model would be refused",
        "error: fleet.start: G: there is no bay at this node; name nodes with bays [START_WITHOUT_BAY]",
        "error: fleet.start: M: there is no bay at this node; name nodes with bays [START_WITHOUT_BAY]",
    ]
    assert call("check", MODEL, "--set", "fleet.start=[G]").stdout.startswith("1 error: this model would be refused\n")


def test_schema_is_a_json_schema_that_our_models_fit():
    schema = json.loads(call("schema").stdout)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    content = dw.load(MODEL).content()
    validator.validate(content)
    assert not validator.is_valid(content | {"fleets": {}})
    assert not validator.is_valid(content | {"fleet": {"size": 0}})


def test_version_is_printed():
    assert call("--version").stdout == f"desim, version {dw.__version__}\n"


@pytest.mark.parametrize("option", ["--help", "-h"])
def test_help_lists_all_commands(option):
    done = call(option)
    assert done.exit_code == 0
    listed = [line.split()[0] for line in done.stdout.split("Commands:")[1].splitlines() if line.strip()]
    assert [name for name in listed if name in COMMANDS] == list(COMMANDS)
    for _, summary in COMMANDS.values():
        assert summary.split()[0] in done.stdout


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_that_begins_as_the_overview_says(name):
    done = call(name, "--help")
    assert done.exit_code == 0
    assert done.stdout.startswith(f"Usage: desim {name} ")


def test_numbers_in_json_are_plain():
    answer = json.loads(call("run", "models/tutorial.yaml", "--json").stdout)
    for key in ("S", "C", "tasks", "moves", "rear_ends", "crossings", "rotations", "backlog"):
        assert isinstance(answer[key], int), key
    assert all(math.isfinite(value) for value in answer.values() if isinstance(value, float))


@pytest.mark.parametrize("name", COMMANDS)
def test_an_option_of_one_value_is_refused_where_it_is_typed_twice(name):
    command = desim.get_command(click.Context(desim), name)
    options = [one for one in command.params if isinstance(one, click.Option)]
    single = [one for one in options if not one.multiple and not one.is_flag]
    for option in single:
        for spelling in (option.opts[0], option.opts[-1]):
            refused = call(name, option.opts[0], "1", "model.yaml", f"{spelling}=2")
            assert refused.exit_code == 2
            assert refused.stderr.splitlines()[-1] == f"Error: {option.opts[0]}: typed twice, expected once"


def test_flags_and_options_that_may_repeat_are_not_refused():
    twice = ("--json", "--set", "fleet.size=2", "--set", "fleet.size=3", "--indicator", "T", "--json")
    assert json.loads(call("run", MODEL, *twice).stdout)["T"] == json.loads(call("run", MODEL, *twice[3:]).stdout)["T"]
