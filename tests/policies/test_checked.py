"""Wrong names, wrong parameters, wrong answers: each an error that names the policy and the fault."""

import concurrent.futures
import multiprocessing
from pathlib import Path

import pytest

from desim_warehouse import ModelError, PolicyError, load, simulate
from desim_warehouse.policies.catalogue import METHODS, OURS, problems, title_of
from desim_warehouse.study.plan import models
from desim_warehouse.study.reading import read_study
from tests.policies.ours import NUMBER, required
from tests.policies.test_contracts import KINDS

MULTIBOTS = "models/multibots.yaml"


def mine(tmp_path, body, method="assign(self, situation)", fields=""):
    path = tmp_path / "mine.py"
    path.write_text(
        "from dataclasses import dataclass\n\n@dataclass(frozen=True)\nclass Mine:\n"
        f"    {fields or 'pass'}\n\n    def {method}:\n        {body}\n"
    )
    return f"{path}:Mine"


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("return [(0, 99)]", r"allocation \(Mine\) at time 0: task 99 is not open"),
        ("return [(7, 0)]", r"there is no robot 7, only 0 to 5"),
        ("return [(0, 0), (1, 0)]", r"task 0 is given out twice"),
        ("return [3]", r"3 is no pair \(robot number, task number\)"),
        ("return [('a', 'b')]", r"is no pair"),
        ("return [(0, 1.7)]", r"\(0, 1\.7\) is no pair"),
        ("return [('0', 1)]", r"is no pair"),
        (
            "return None",
            r"returned None, expected pairs \(robot number, task number\) \(assign\(\) in .*mine.py, line 7\)",
        ),
        ("return 1 / 0", r"raised ZeroDivisionError\('division by zero'\) in .*mine.py, line 8"),
        ("situation.time = 3", r"raised AttributeError"),
        ("situation.robots[0].energy = 3", r"raised AttributeError"),
    ],
)
def test_answers_that_cannot_be_carried_out(tmp_path, body, message):
    with pytest.raises(PolicyError, match=message):
        simulate(load(MULTIBOTS, {"policies.allocation": mine(tmp_path, body)}))


def test_a_robot_whose_energy_does_not_last_gets_no_task(tmp_path):
    name = mine(tmp_path, "return [(r.number, t.number) for r, t in zip(situation.robots, situation.tasks)]")
    reach_aware = {"policies.charging": {"name": "reach-aware", "margin": 0.99}}
    model = load(MULTIBOTS, {"policies.allocation": name, "accept": ["BATTERY_TOO_SMALL"], **reach_aware})
    with pytest.raises(PolicyError, match=r"robot 0 may not take task 0: its energy, 10, .*charging \(reach-aware\)"):
        simulate(model)


@pytest.mark.parametrize(
    ("kind", "method", "body", "message"),
    [
        ("routing", "route(self, origin, goal, roads)", "return [origin, goal]", r"routing \(Mine\).*is no route from"),
        ("routing", "route(self, origin, goal, roads)", "return []", r"nothing is no route from"),
        (
            "parking",
            "choose(self, robot, bays, travel)",
            "return 'Z'",
            r"parking \(Mine\).*'Z' is no bay with a free slot",
        ),
        ("charging", "levels(self, robot)", "return 3", r"charging \(Mine\).*robot \d: 3 are no Levels"),
        (
            "charging",
            "levels(self, robot)",
            "from desim_warehouse.policies import Levels; return Levels(1, 1, 9, 8)",
            r"sufficient, 9, is above full, 8",
        ),
        (
            "charging",
            "levels(self, robot)",
            "from desim_warehouse.policies import Levels; return Levels('3', 5, 8, 10)",
            r"charging \(Mine\).*robot \d: critical is '3', expected a finite number \(levels\(\) in .*mine.py, line 7",
        ),
        (
            "charging",
            "levels(self, robot)",
            "from desim_warehouse.policies import Levels; return Levels(3, 5, 8, 10, margin='1')",
            r"charging \(Mine\).*robot \d: margin is '1', expected a finite number",
        ),
        (
            "charging",
            "levels(self, robot)",
            "from desim_warehouse.policies import Levels; return Levels(3, 5, 8, 1.5 * robot.capacity)",
            r"charging \(Mine\).*robot \d: full, 15, is above the capacity, 10",
        ),
    ],
)
def test_answers_of_the_other_kinds(tmp_path, kind, method, body, message):
    with pytest.raises(PolicyError, match=message):
        simulate(load(MULTIBOTS, {f"policies.{kind}": mine(tmp_path, body, method), "tasks.goods": [1]}))


def test_a_full_battery_may_be_computed_with_rounding(tmp_path):
    body = "from desim_warehouse.policies import Levels; c = robot.capacity; return Levels(1, 1, c, c + 1e-15 * c)"
    name = mine(tmp_path, body, "levels(self, robot)")
    assert simulate(load(MULTIBOTS, {"policies.charging": name, "tasks.goods": [1]})).kpis["tasks"] == 1


ODD = ["[[]]", "numpy.eye(2)", "given[-1]"]
"""Answers that no policy may give: they cannot be looked up, cannot be compared, or are what the policy was shown."""


@pytest.mark.parametrize("kind", METHODS)
def test_an_answer_of_any_type_is_blamed_on_the_policy_that_gave_it(tmp_path, kind):
    body = f"import numpy; return [{', '.join(ODD)}][self.rank]"
    name = mine(tmp_path, body, f"{METHODS[kind]}(self, *given)", "rank: int")
    model = load(KINDS[kind].model)
    for rank in range(len(ODD)):
        with pytest.raises(PolicyError, match=rf"^policies\.{kind} \(Mine\) at time .* in .*mine.py, line 7"):
            simulate(model.replace({f"policies.{kind}": {"name": name, "rank": rank}}))


def test_tasks_of_a_batch_that_are_no_list_are_blamed_on_the_batching_policy(tmp_path):
    body = "from desim_warehouse.policies import TaskBatch; return [TaskBatch(3)]"
    name = mine(tmp_path, body, "batches(self, waiting)")
    with pytest.raises(PolicyError, match=r"^policies\.batching \(Mine\) at time .*no len.* in .*mine.py, line 7"):
        simulate(load(KINDS["batching"].model, {"policies.batching": name}))


def test_a_batching_policy_may_answer_in_numbers_of_numpy(tmp_path):
    body = """from desim_warehouse.policies import TaskBatch; import numpy
        return [TaskBatch(numpy.array([task.number]), numpy.float32(0)) for task in waiting.tasks]"""
    run = simulate(load(KINDS["batching"].model, {"policies.batching": mine(tmp_path, body, "batches(self, waiting)")}))
    assert {type(row.task) for row in run.history.rows("batched")} == {int}


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (
            "nearst",
            "policies.allocation: no such policy (got 'nearst'), did you mean 'nearest'? expected one of in-order, ",
        ),
        ({"name": "nearest", "candidate": 3}, "unknown parameter of nearest, did you mean 'candidates'?"),
        ({"name": "in-order", "x": 3}, "policies.allocation.x: unknown parameter of in-order, expected none"),
        ({"name": "nearest", "candidates": "many"}, "not understood (got 'many'), expected a whole number"),
        ({"name": "nearest", "candidates": None}, "not understood (got nothing), expected a whole number"),
        ({"name": "nearest", "candidates": 0}, "policies.allocation.candidates: nearest: candidates is 0"),
        ({"name": "regret", "objective": "fun"}, "policies.allocation.objective: not understood (got 'fun')"),
        ("nowhere.py:Mine", "policies.allocation: no file nowhere.py"),
        ("no_such_module:Mine", "no_such_module cannot be loaded: ModuleNotFoundError"),
        (
            "desim_warehouse.policies:Situatio",
            "no class 'Situatio' in desim_warehouse.policies, did you mean 'Situation'?",
        ),
        ("desim_warehouse.policies:Situation", "the class has no method assign(), which policies.allocation needs"),
    ],
)
def test_a_wrong_name_or_parameter_is_reported_when_the_model_is_read(spec, message):
    with pytest.raises(ModelError) as caught:
        load(MULTIBOTS, {"policies.allocation": spec}, run_code=True)
    assert message in str(caught.value)


def test_the_message_has_the_line_of_the_file(tmp_path):
    text = (
        Path(MULTIBOTS).read_text(encoding="utf-8").replace("charging: threshold", "charging: {name: swap, level: 2}")
    )
    path = tmp_path / "model.yaml"
    path.write_text(text)
    line = 1 + text[: text.index("{name: swap")].count("\n")
    with pytest.raises(ModelError, match=rf"model.yaml:{line}:\d+: policies.charging.time: missing, swap must have it"):
        load(path)
    path.write_text(text.replace("level: 2", "time: 3, level: 2"))
    with pytest.raises(ModelError, match=rf"model.yaml:{line}:\d+: policies.charging.level: swap: level is 2"):
        load(path)


def test_every_policy_of_ours_can_be_had_by_its_name():
    for kind, policies in OURS.items():
        for name in policies:
            assert problems(kind, name, required(kind, name)) == []


@pytest.mark.parametrize("kind", OURS)
def test_all_policies_of_a_kind_have_an_everyday_name_or_none_has(kind):
    """Answers would otherwise call one `the nearest robot (nearest)` and another `lottery`."""
    assert len({title_of(kind, name) is None for name in OURS[kind]}) == 1


def test_what_a_policy_must_be_given_is_read_from_its_fields():
    """A swap takes a time, and a window a length of time; how many tasks `nearest` considers has a default."""
    assert required("charging", "swap") == {"time": NUMBER}
    assert required("batching", "time-window") == {"window": NUMBER}
    assert required("allocation", "nearest") == {}


PATIENT = """
from dataclasses import dataclass

@dataclass(frozen=True)
class Mine:
    turn: int = 1

    def assign(self, situation):
        tasks = [t.number for t in situation.tasks]
        return zip([r.number for r in situation.robots], tasks[:: self.turn])
"""


def outcome(content):
    return simulate(load(content)).T


@pytest.mark.slow
def test_a_policy_file_stands_beside_the_model_file_and_works_in_spawned_processes(tmp_path, monkeypatch):
    folder = tmp_path / "models"
    folder.mkdir()
    text = (
        Path(MULTIBOTS)
        .read_text(encoding="utf-8")
        .replace("allocation: in-order", "allocation: {name: own.py:Mine, turn: -1}")
    )
    (folder / "model.yaml").write_text(text)
    (folder / "own.py").write_text(PATIENT)
    model = load(folder / "model.yaml")
    here = simulate(model).T
    assert here != simulate(load(MULTIBOTS)).T
    monkeypatch.chdir(tmp_path)
    with concurrent.futures.ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        assert pool.submit(outcome, model.content()).result() == here


def test_a_changed_policy_file_is_another_model(tmp_path):
    (tmp_path / "own.py").write_text(PATIENT)
    spec = {"policies.allocation": {"name": f"{tmp_path}/own.py:Mine", "turn": 1}}
    model = load(MULTIBOTS, spec)
    first, time = model.digest(), simulate(model).T
    assert load(MULTIBOTS, spec).digest() == first
    (tmp_path / "own.py").write_text(PATIENT.replace(":: self.turn", "::-1"))
    assert load(MULTIBOTS, spec).digest() != first
    assert time != simulate(load(MULTIBOTS, spec)).T


def test_the_command_lists_all_policies_and_shows_one():
    from click.testing import CliRunner

    from desim_warehouse.cli import desim

    listed = CliRunner().invoke(desim, ["policies"]).output
    for policies in OURS.values():
        for name in policies:
            assert f"  {name} " in listed
    assert "parameters: minimum=0.2, margin=0.1, charger=nearest" in listed
    shown = CliRunner().invoke(desim, ["policies", "--doc", "hungarian"]).output
    assert "Kuhn" in shown
    assert "class Hungarian" in shown
    both = CliRunner().invoke(desim, ["policies", "--doc", "nearest"]).output
    assert "policies.allocation: nearest" in both
    assert "policies.parking: nearest" in both
    own = CliRunner().invoke(desim, ["policies", "--doc", "studies/my_policies.py:Patient"]).output
    assert "class Patient" in own
    assert "no policy 'hungarien'" in CliRunner().invoke(desim, ["policies", "--doc", "hungarien"]).output


def test_a_study_finds_a_policy_file_beside_itself(tmp_path, monkeypatch):
    (tmp_path / "own.py").write_text(PATIENT)
    model = Path(MULTIBOTS).resolve()
    text = f"model: {model}\nfactors:\n  policies.allocation: [in-order, {{name: 'own.py:Mine', turn: -1}}]\n"
    (tmp_path / "study.yaml").write_text(text)
    monkeypatch.chdir(model.parent)
    plan = read_study(tmp_path / "study.yaml")
    by_point = models(plan, plan.points())
    assert [by_point[i].policies.allocation.name for i in sorted(by_point)] == ["in-order", f"{tmp_path}/own.py:Mine"]
