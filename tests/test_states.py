"""The register of states: what is true of a state is said there, and nobody else knows one by its name."""

import ast
import dataclasses
import json
import re
from pathlib import Path
from typing import get_args

import pytest

import desim_warehouse
from desim_warehouse.model.schema import Tasks
from desim_warehouse.model.sections.fleet import Consumption
from desim_warehouse.model.sections.policy import Policies
from desim_warehouse.outcome.log import KINDS
from desim_warehouse.states import APART, AT_START, ROLES, SHOWN, STATES, TIMES, WAITING, Phase, Role, State, seen
from desim_warehouse.world.robots.robot import Robot
from tests.register import extended, python, renamed

ROOT = Path(desim_warehouse.__file__).parent
NAMES = {*STATES, *SHOWN, *APART}

# Every state says what is true of it


def test_no_answer_about_a_state_is_given_by_default():
    for field in dataclasses.fields(State):
        assert field.default is field.default_factory is dataclasses.MISSING, field.name


@pytest.mark.parametrize("state", SHOWN.values(), ids=lambda state: state.name)
def test_a_state_is_in_one_part_of_a_robots_round_and_queues_for_something_only_there(state):
    assert state.phase in Phase
    assert (state.queue is not None) == (state.phase is Phase.QUEUE)
    assert not (state.queue is not None and state.occupies is not None)
    assert state.better in (None, "less", "more")
    assert state.role in get_args(Role)
    assert state.begins, "what its row in the log says"


def test_every_role_has_its_colours():
    assert set(ROLES) == set(get_args(Role))


def test_a_wait_in_traffic_is_in_no_part_of_the_round_as_robots_wait_in_any():
    for state in (WAITING, *APART.values()):
        assert (state.phase, state.queue, state.occupies, state.is_parked) == (None, None, None, False)


WHERE = {
    "idle": "parked",
    "empty": None,
    "loading": "has a station",
    "loaded": None,
    "queueing_server": "queues at a station",
    "unloading": "has a station",
    "returning": None,
    "queueing_charger": "parked, queues at chargers",
    "charging": "parked, has chargers",
    "closed": "queues at a station",
    "on_break": "parked",
    "broken": None,
    "awaiting": None,
    "too_low": "parked, queues at chargers",
}


@pytest.mark.parametrize(("name", "where"), WHERE.items())
def test_where_a_robot_is_in_a_state(name, where):
    state = SHOWN[name]
    parts = ["parked"] if state.is_parked else []
    parts += [f"has {'a ' * (state.occupies == 'station')}{state.occupies}"] if state.occupies else []
    parts += [f"queues at {'a ' * (state.queue.at == 'station')}{state.queue.at}"] if state.queue else []
    assert (", ".join(parts) or None) == where


def test_a_run_begins_at_rest_and_a_robot_without_a_task_queues_for_a_charger():
    assert STATES[AT_START].phase is Phase.REST
    assert (seen("queueing", 3).name, seen("queueing", -1).name) == ("queueing_server", "queueing_charger")


def test_names_places_in_the_stack_and_colours_are_of_one_state_each():
    for of in ("name", "stacked", "colour", "doing"):
        marks = [getattr(state, of) for state in TIMES.values()]
        assert len(marks) == len(set(marks)), of
    assert set(STATES) | set(APART) <= set(KINDS)


# Nobody else knows a state by its name

MEANS_ELSE = {
    *Policies.model_fields,  # a kind of policy
    *Consumption.model_fields,
    *(f"{key.removesuffix('_time')}ing" for key in Tasks.model_fields if key.endswith("_time")),  # in a sentence
    *get_args(Role),
    *(word for kind in KINDS.keys() - NAMES for word in kind.split("_")),
}
"""Words that model files, pages and kinds of rows have, too: states where something is compared with them."""


def entered(nodes):
    """Constants by which a robot enters a state: handed to `enter`, or given a name or returned for that."""
    constants = set()

    def take(node):
        if isinstance(node, ast.IfExp):
            take(node.body)
            take(node.orelse)
        elif isinstance(node, ast.Constant):
            constants.add(node)

    for node in nodes:
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "enter":
            for argument in node.args:
                take(argument)
        elif isinstance(node, ast.Return | ast.Assign | ast.AnnAssign):
            take(node.value)
    return constants


def operands(node):
    """What is compared, one by one."""
    if isinstance(node, ast.MatchValue):
        return [node.value]
    sides = [node.left, *node.comparators] if isinstance(node, ast.Compare) else []
    return [part for side in sides for part in getattr(side, "elts", [side])]


def named(source, *, world=True):
    """States that a source names, other than to enter them."""
    nodes = list(ast.walk(ast.parse(source)))
    may = entered(nodes) if world else set()
    compared = [part for node in nodes for part in operands(node)]
    return {
        node.value
        for node in nodes
        if isinstance(node, ast.Constant) and node not in may and isinstance(node.value, str) and node.value in NAMES
        if node in compared or node.value not in MEANS_ELSE
    }


@pytest.mark.parametrize(
    "source",
    [
        'if robot.state == "closed": pass',
        'if robot.state in ("idle", kind): pass',
        'use = {"returning": 1}',
        'use = totals["queueing"]',
        'rows = history.rows("on_break")',
        'match state:\n    case "empty": pass',
        'self.encounters += wait == "waiting_person"',
    ],
)
def test_the_law_sees_what_it_forbids(source):
    assert named(source)


def test_a_robot_enters_a_state_by_its_name():
    assert not named('self.enter("empty" if self.job else "returning")')
    assert not named('def at_rest(self):\n    return "idle" if duty else "on_break"')
    assert named('self.enter(STATES["returning"])')
    assert not named('policies = {"charging": "threshold"}')


def test_no_file_but_the_register_knows_a_state_by_its_name():
    uses = {}
    for file in ROOT.rglob("*.py"):
        path = file.relative_to(ROOT).as_posix()
        names = named(file.read_text(), world=path.startswith("world/"))
        if names and path != "states.py":
            uses[path] = names
    assert uses == {}


def test_the_replay_page_draws_roles_and_knows_no_other_name_of_a_state():
    others = "|".join(sorted(NAMES - set(get_args(Role))))
    uses = {
        (file.name, name)
        for file in (ROOT / "replay").rglob("*.js")
        for name in re.findall(rf"[\"'`]({others})[\"'`]", file.read_text())
    }
    assert uses == {("18-legend.js", "closed")}, "the word in the legend, of an edge"


# A name is nothing but a name

LOOK = """
import json
import desim_warehouse as dw
from desim_warehouse.outcome.resources import resources
from desim_warehouse.outcome.positions import Positions
from desim_warehouse.replay.payload import payload
from desim_warehouse.study.suspects import suspects
from desim_warehouse.world.robots.forecast import busy_view
from desim_warehouse.world.robots.robot import Robot

enter, forecasts = Robot.enter, []

def under_its_name(self, state):
    note(self)
    enter(self, state if state.startswith(PREFIX) else PREFIX + state)
    note(self)

def note(self):
    if self.job is not None and self.tour.stops:
        view = busy_view(self, self.reach, self.env.now)
        forecasts.append((self.number, view.node, view.free_in, self.body.recall_at))

Robot.enter = under_its_name
for path, changes in CASES:
    run = dw.simulate(dw.load(path, {**changes, "log": "all"}), 3)
    legs, (header, columns) = Positions(run.history).legs, payload(run.history, 0.0, run.record.end)
    said = {
        "rows": run.record.rows,
        "indicators": dict(run.kpis),
        "resources": [(one.kind, one.node, one.busy, one.queue) for one in resources(run.history)],
        "forecasts": forecasts,
        "legs": [getattr(legs, name).tolist() for name in ("begin", "end", "edge", "origin", "target")],
        "energy": run.history.energy_curves,
        "accounts": [run.account(by=by).to_csv() for by in ("task", "robot", "node")],
        "tasks": [repr(task) for task in run.history.tasks.values()],
        "suspects": [repr(one) for one in suspects(run)],
        "robots": run.robots.to_csv(),
        "page": header,
        "columns": {name: list(column) for name, column in columns.items()},
    }
    assert PREFIX + "loaded" in {row[1] for row in run.record.rows}
    print(json.dumps({key: repr(value).replace(PREFIX, "") for key, value in said.items()}))
"""

CASES = [
    ("models/tutorial.yaml", {"fleet.size": 5, "policies.allocation": "regret"}),
    ("models/tutorial.yaml", {"fleet.size": 4, "fleet.robot.breakdowns": {"every": {"exponential": 60}, "repair": 25}}),
    ("models/people.yaml", {"run.length": 1500, "run.warm_up": 300}),
    ("tests/golden/models/flows.yaml", {}),
    (
        "tests/cases/packing_hall.yaml",
        {
            "run": {"length": 5400, "warm_up": 3600},
            "policies.charging": "four-thresholds",
            "fleet.start_energy": {"uniform": [0.3, 1]},
            "layout.bays.chargers.outages": {"every": {"exponential": 900}, "repair": 100},
        },
    ),
]


FEW = [CASES[0], *((path, changes | {"run": {"length": 2700}}) for path, changes in CASES[4:])]


@pytest.mark.parametrize("cases", [FEW, pytest.param(CASES, marks=pytest.mark.long)], ids=["few", "all"])
def test_states_by_other_names_change_nothing_but_the_names(cases, monkeypatch, capsys):
    """Decisions, forecasts, batteries, queues, suspects, positions: all is as it was, under the new names."""
    monkeypatch.setattr(Robot, "enter", Robot.enter)  # which is put back after the look
    root = Path(__file__).parent.parent
    files = [(str(root / path), changes) for path, changes in cases]
    exec(compile(LOOK, "look", "exec"), {"PREFIX": "", "CASES": files})  # noqa: S102 - with its names in this process
    before = capsys.readouterr().out
    after = python(f"PREFIX = 'zz_'\nCASES = {files!r}\n{LOOK}", renamed("zz_"))
    for old, new, (path, _) in zip(before.splitlines(), after.splitlines(), cases, strict=True):
        printed = json.loads(new)
        for key, value in json.loads(old).items():
            assert printed[key] == value, (path, key)


# A new state is one entry

DOWN = """
        State(
            "down",
            doing="waiting for a station to be repaired",
            begins="in a station that has failed it waits for the repair",
            time="in a station, waiting for its repair",
            better="less",
            draws="standing",
            phase=Phase.QUEUE,
            queue=Queue("station", "its repair"),
            role="loaded",
            colour="#117733",
            stacked=15,
            applies=_always,
        ),
"""
FAILS = """
import json
from simpy.events import Timeout
import desim_warehouse as dw
from desim_warehouse.outcome.indicators import INDICATORS
from desim_warehouse.outcome.resources import resources
from desim_warehouse.world.orders.dispatch import Dispatcher
from desim_warehouse.world.robots.forecast import busy_view
from desim_warehouse.world.places.service import Service

begin = Service.begin
seen = []

def repaired_first(self, stop):
    if self.env.now < 100:
        self.robot.enter("down")
        view = busy_view(self.robot, self.robot.reach, self.env.now)
        seen.append((self.env.now, view.node, view.free_in))
        yield Timeout(self.env, 100 - self.env.now)
    yield from begin(self, stop)

Service.begin = repaired_first
run = dw.simulate(dw.load(MODEL), 0)
station = resources(run.history)[0]
print(json.dumps({
    "queue": station.queue, "mean": station.mean_queue(0, run.record.end), "end": run.record.end, "seen": seen,
    "share": run.kpis["share_down"], "better": INDICATORS["share_down"].better, "wait": run.kpis["station_wait"],
    "account": run.account(by="node").loc["B", "down"], "docked": run.log.query("kind == 'docked'").time.tolist(),
}))
"""


def test_a_state_down_for_a_station_that_has_failed_is_right_everywhere():
    """A server that works from 100 on; robots come at 35 and at 41, and the second waits 40 more for the first.

    The second closes up to 1 behind the first, which loads from 20 to 25: it is at the good at 26, and loads for 5.
    It is unloaded at 180 and home at 210, 10 to C and 20 to D. In a queue were 65 + 59 + 40 of 210.
    """
    model = {
        "layout": {
            "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 10], "D": [0, 10]},
            "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 10}],
            "bays": {"home": {"at": ["D"], "places": 2}},
            "stations": {"pack": {"at": ["B"], "places": 2, "servers": 1}},
        },
        "fleet": {"size": 2, "robot": {"radius": 0.4, "speed": 1.0, "margin": 0.2}},
        "tasks": {"goods": [0, 0], "unload_at": ["B"], "load_time": 5, "unload_time": 40},
    }
    printed = json.loads(python(f"MODEL = {model!r}\n{FAILS}", extended(DOWN)))
    assert printed["docked"] == [35, 41]
    assert printed["end"] == 210
    assert printed["queue"] == [[0, 35, 41, 100, 140], [0, 1, 2, 1, 0]]
    assert printed["mean"] == pytest.approx(164 / 210), "40 / 210 where robots in `down` are not known to queue"
    assert printed["seen"] == [[35, "B", 40], [41, "B", 40]], "forecast to need their unloading and no way any more"
    assert (printed["account"], printed["share"]) == (124, pytest.approx(124 / 420))
    assert (printed["wait"], printed["better"]) == (40, "less"), "`station_wait` is for a server alone"
