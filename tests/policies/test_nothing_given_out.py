"""Policies that give out nothing: robots that draw energy at rest go on to charge, and the run ends all the same."""

import pytest

import desim_warehouse as dw
from desim_warehouse.contracts import EXAMPLE, AllocationContract
from desim_warehouse.errors import StallError

NEVER = """\
from dataclasses import dataclass


@dataclass(frozen=True)
class Never:
    def assign(self, situation):
        return []


@dataclass(frozen=True)
class Slow:
    wait: int = 3

    def assign(self, situation):
        if situation.time < 2000 * self.wait:
            return []
        pairs = zip(situation.robots, situation.tasks)
        return [(robot.number, task.number) for robot, task in pairs if situation.feasible(robot, task)]
"""


@pytest.fixture
def mine(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(NEVER, encoding="utf-8")
    return str(file)


def model(mine, name="Never", **changes):
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    return dw.load(EXAMPLE, {"policies.allocation": {"name": f"{mine}:{name}"}, **changes}, run_code=True)


def test_a_policy_that_gives_out_nothing_stalls_where_robots_draw_at_rest(mine):
    told = r"stalled at time .*: 0 of 16 tasks are done; policies.allocation \(Never\) gave out none of 16 open tasks"
    with pytest.raises(StallError, match=told):
        dw.simulate(model(mine), seed=1)


@pytest.mark.parametrize(
    "changes",
    [
        {"fleet__size": 1, "fleet__start": ["A"]},  # it rests beside a charger
        {"layout__bays__chargers__chargers": 2},
        {"policies__interval": 30},
        {"policies__charging": {"name": "threshold"}},
        {"tasks__goods": {"random": 5}},
    ],
)
def test_it_stalls_whatever_robots_do_at_rest(mine, changes):
    with pytest.raises(StallError, match="stalled at time"):
        dw.simulate(model(mine, **changes), seed=1)


def test_a_run_with_a_length_ends_there(mine):
    assert dw.simulate(model(mine, run={"length": 400}), seed=1).kpis["tasks"] == 0


def test_a_policy_that_waits_for_some_cycles_is_let_wait(mine):
    """Batteries of 300 last for 50 minutes at rest; work begins after 100."""
    run = dw.simulate(model(mine, "Slow"), seed=1)
    assert run.kpis["tasks"] == 16
    assert run.history.assignments[0].start >= 6000


def test_the_contract_test_of_such_a_policy_ends(mine, monkeypatch):
    class TestNever(AllocationContract):
        name = f"{mine}:Never"

        def given(self):
            return model(mine)

        def make(self):
            return type("Never", (), {"assign": lambda self, situation: []})()

    for test in ("test_a_run_ends_with_all_work_done", "test_answers_can_be_carried_out"):
        with pytest.raises(StallError):
            getattr(TestNever(), test)()
