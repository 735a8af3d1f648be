"""Words of the trade, and options of other commands: each is answered with what is meant here, before any run."""

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import nearest, synonym
from desim_warehouse.outcome.indicators import INDICATORS
from desim_warehouse.outcome.targets import parse_target

HALL = """
name: two flows
layout:
  blocks: {columns: 2, rows: 1, block_depth: 2, goods_size: 1, aisle_width: 1}
  bays: {home: {along: north}}
  stations: {packing: {at: [D]}}
fleet: {size: 1, robot: {radius: 0.3, speed: 1}}
tasks:
  load_time: 5
  unload_time: 10
  flows:
    express:
      from: storage
      to: [packing]
      due_within: 10 min
      arrivals: {profile: {every: 1 h, per_hour: [6, 12, 6]}}
    rest: {from: storage, to: [packing], arrivals: {poisson: 6}}
run: {start: "11:00", length: 3 h}
"""


@pytest.fixture
def hall(tmp_path):
    file = tmp_path / "hall.yaml"
    file.write_text(HALL)
    return str(file)


def said_by(*arguments):
    done = CliRunner().invoke(desim, arguments)
    assert done.exit_code, done.output
    return done.output if done.exception is None or isinstance(done.exception, SystemExit) else str(done.exception)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("utilisation", "robots_busy"),
        ("robot utilization", "robots_busy"),
        ("robots", "robots_busy"),
        ("service level", "on_time"),
        ("OTIF", "on_time"),
        ("lead time", "cycle_time_mean"),
        ("throughput", "throughput_per_hour"),
        ("packers", "server_utilisation"),
        ("Done on time", "on_time"),  # the heading of our own tables
        ("express on time", "on_time:express"),
        # further words
        ("Fleet Utilisation", "robots_busy"),
        ("SLA", "on_time"),
        ("turnaround time", "cycle_time_mean"),
        ("downtime", "share_broken"),
        ("Fleet driving empty", "share_empty"),
        ("on time express-NL", "on_time:express-NL"),
        ("orders on time", "orders_on_time"),
        ("makespan", "T"),
    ],
)
def test_a_target_in_words_of_the_trade_is_answered_with_the_indicator(typed, meant):
    with pytest.raises(dw.StudyError, match=f"unknown indicator .*, did you mean '{meant}'"):
        parse_target(f"{typed} >= 5")


def test_another_word_counts_only_where_its_meaning_is_to_be_had():
    assert synonym("packers", ["size", "workers"]) == "workers"
    assert synonym("robots", ["name", "size"]) == "size"
    assert synonym("OTIF", ["T", "S"]) is None
    assert nearest("on-time", INDICATORS) == "on_time"


@pytest.mark.parametrize(
    ("words", "cure"),
    [
        (("run", "--robots", "6"), "Did you mean '--set fleet.size=6'?"),
        (("run", "--robots=6"), "Did you mean '--set fleet.size=6'?"),
        (("run", "--replications", "5"), "It is an option of desim what-if"),
        (("what-if", "--vary", "robots=3,4"), "--vary robots: no key of a model, did you mean 'fleet.size'?"),
        (("run", "--set", "robots=3"), "--set robots: unknown key, did you mean 'fleet.size'?"),
        # further ones
        (("check", "--vehicles", "2"), "Did you mean '--set fleet.size=2'?"),
        (("run", "--speed", "2"), "Did you mean '--set fleet.robot.speed=2'?"),
        (("run", "--chargers"), "It is an option of desim new and plan."),
        (("run", "--seeds", "2"), "Did you mean one of: '--seed'"),  # as click says it
        (("best", "--target", "on_time >= 95 %", "--length", "8h"), "Did you mean '--set run.length=8h'?"),
    ],
)
def test_an_option_that_a_command_lacks_is_answered_with_what_to_type(hall, words, cure):
    assert cure in said_by(words[0], hall, *words[1:])


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("on_time:Express", "no such flow, did you mean 'on_time:express'?"),
        ("on_time:picks", "no such flow, expected express or rest"),
        ("on_time@12:00", "no such part of the day, did you mean 'on_time@12:00-13:00'?"),
        ("on_time@18:00-19:00", "no such part of the day, expected 11:00-12:00, 12:00-13:00 or 13:00-14:00"),
        ("robots_busy@noon", "no such part of the day, expected 11:00-12:00"),
    ],
)
def test_a_flow_or_part_of_the_day_is_looked_up_before_any_run(hall, name, message, monkeypatch):
    monkeypatch.setattr("desim_warehouse.world.world.World.run", lambda *_: pytest.fail("a run"))
    target = f"{name} >= 5 %"
    assert message in said_by("run", hall, "--indicator", name)
    assert message in said_by("plan", hall, "--target", target)
    assert message in said_by("plan", hall, "--target", "tasks >= 5", "--target", target)
    assert message in said_by("size", hall, "--key", "fleet.size", "--range", "1..2", "--target", target)
    assert message in said_by("what-if", hall, "--vary", "fleet.size=1,2", "--indicator", name)
    assert message in said_by("what-if", hall, "--vary", "fleet.size=1,2", "--until", name)
    assert message in said_by("best", hall, "--vary", "fleet.size=1,2", "--indicator", name)


def test_a_flow_that_only_one_of_the_designs_has_is_known(hall):
    flows: list = [{"rest": {"from": "storage", "to": ["packing"], "arrivals": {"poisson": 6}}}]
    flows.append({**flows[0], "bulk": flows[0]["rest"]})
    study = dw.Study(hall, {"tasks.flows": {"cases": {"a": {"tasks.flows": flows[0]}, "b": {"tasks.flows": flows[1]}}}})
    assert len(study.points) == 2
    of_bulk = {"indicators": ["tasks:bulk"]}
    dw.Study(hall, {"tasks.flows": {"cases": {"b": {"tasks.flows": flows[1]}}}}, **of_bulk)
    with pytest.raises(dw.ModelError, match="no such flow, expected rest"):
        dw.Study(hall, {"tasks.flows": {"cases": {"a": {"tasks.flows": flows[0]}}}}, **of_bulk)


def test_indicators_joined_by_a_comma_are_told_apart(hall):
    assert "the option may be repeated, for T and backlog" in said_by("run", hall, "--indicator", "T, backlog")
    assert "the option may be repeated" in said_by("what-if", hall, "--vary", "fleet.size=1", "--until", "T,S")


def test_a_model_without_flows_or_parts_says_so(hall):
    without = ("--unset", "tasks.flows", "--set", "tasks.goods=[0]", "--set", "tasks.unload_at=[packing]")
    assert "no such flow, the model has none" in said_by("run", hall, *without, "--indicator", "tasks:picks")
    assert "part of the day, the model has none" in said_by("run", hall, *without, "--indicator", "on_time@noon")
