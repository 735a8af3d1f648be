"""What questions return: printed it is the text of the command, its repr is a line, and it has a table."""

import ast
import inspect
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.answer import text as answer_text
from desim_warehouse.cli import desim

pytestmark = pytest.mark.usefixtures("brief_probes")
ROOT = Path(__file__).parents[2]
MODEL = dw.load(ROOT / "models" / "tutorial.yaml")
RUNS = dw.Search(first=5, cap=5, cache=False)
MOST = 2000


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    factors = {"fleet.size": [1, 3], "policies.allocation": ["in-order", "nearest"]}
    made = dw.Study(MODEL, factors, replications=3, indicators=["T", "S"])
    return made.run(out=tmp_path_factory.mktemp("interface") / "study")


@pytest.fixture(scope="module")
def returned(study):
    return {
        "run": dw.simulate(MODEL),
        "check": dw.check(MODEL),
        "results": study.results,
        "compare": study.compare("T"),
        "effects": study.main_effects("T"),
        "why": dw.why(MODEL, search=RUNS),
        "plan": dw.plan(MODEL, "T <= 1000", robots=[1, 2], chargers=[1], strategies={}, search=RUNS),
        "best": dw.best(dw.Study(MODEL, {"fleet.size": [1, 3]}), "T", search=RUNS),
        "size": dw.size(dw.Study(MODEL, {"fleet.size": [1, 3]}), "T <= 1000", search=RUNS),
    }


def command(*words):
    return CliRunner().invoke(desim, [str(word) for word in words], catch_exceptions=False).stdout.rstrip("\n")


def test_each_prints_in_a_screen_and_its_repr_is_a_line(returned):
    for name, thing in returned.items():
        assert 0 < len(str(thing).encode()) <= MOST, name
        assert re.fullmatch(rf"{type(thing).__name__}\(.+\)", repr(thing)), name
        assert len(repr(thing)) < 150, name
        assert len(thing.table) or name == "check", name
    for name in ("results", "compare", "why", "plan", "best", "size"):
        assert str(returned[name]) == str(returned[name].answer)


def test_the_repr_of_a_plan_is_its_fleet(returned):
    plan = returned["plan"]
    assert (plan.robots, plan.chargers, plan.packers, plan.cost) == (1, 1, 0, None)
    assert repr(plan) == "Plan(1 robot + 1 charger)"
    assert plan.model.replace(plan.overrides).fleet.size == 1
    assert list(plan.table["robots"]) == [1]
    assert list(plan.table)[:4] == ["growth", "robots", "chargers", "packers"]
    row = plan.table.iloc[0]
    assert row["verdict"] == "met"
    assert not row["T"] > 1000


@pytest.mark.usefixtures("whole_probes")
def test_text_is_what_the_command_prints(returned, study, tmp_path):
    file = tmp_path / "model.json"
    file.write_text(json.dumps(MODEL.content()))
    assert command("run", file) == str(returned["run"])
    assert command("check", file) == str(returned["check"])
    assert command("compare", study.folder, "--indicator", "T") == str(returned["compare"])
    assert command("study", study.folder, "--quiet") == str(study.results)


def test_text_stays_text_whatever_the_terminal_is_called(study, monkeypatch):
    before = str(study.results)
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TTY_INTERACTIVE", "1")
    assert str(study.results) == before
    assert "\x1b" not in before
    code = "import desim_warehouse.answer.text as text; print(repr(text.printed_table('t', ('a', 'b'), [('1', '2')])))"
    notebook = f"import IPython.core.interactiveshell as shell; shell.InteractiveShell.instance().run_cell({code!r})"
    output = subprocess.run([sys.executable, "-c", notebook], capture_output=True, text=True, check=True).stdout
    assert output.strip() == repr("t\na  b\n1  2")


def test_each_policy_is_compared_with_the_baseline_at_its_own_fleet(study):
    matched = study.compare("T", baseline={"policies.allocation": "in-order"})
    pairs = {(str(one.design), str(one.baseline)) for one in matched.differences}
    assert pairs == {
        (f"fleet.size={size}, policies.allocation=nearest", f"fleet.size={size}, policies.allocation=in-order")
        for size in (1, 3)
    }
    for one in matched.differences:
        base, ours = (study.results.values(str(of), "T") for of in (one.baseline, one.design))
        assert one.estimate.mean == pytest.approx((ours - base).mean())
    assert "all intervals hold together" in matched.statement
    assert "dispatching: in-order, all else equal" in str(matched)
    whole = study.compare("T", baseline={"policies.allocation": "in-order", "fleet.size": 3})
    assert len(whole.differences) == 3
    assert set(whole.table["baseline"]) == {"fleet.size=3, policies.allocation=in-order"}
    assert {"difference", "difference_low", "difference_high", "fleet.size"} <= set(whole.table)


def public(kind):
    return {name: value for name in dw.__all__ if kind(value := getattr(dw, name))}


def test_names_the_reference_and_the_types_agree():
    page = (ROOT / "docs/reference/api.md").read_text("utf-8")
    assert set(re.findall(r"(?m)^::: desim_warehouse\.(\w+)$", page)) == set(dw.__all__) - {"__version__"}
    tree = ast.parse(Path(dw.__file__).read_text("utf-8"))
    typed = {
        alias.asname or alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert set(dw.__all__) - {"__version__"} <= typed
    returned = {
        word
        for function in public(inspect.isfunction).values()
        for word in re.findall(r"\b[A-Z]\w+", str(inspect.signature(function).return_annotation))
    }
    assert returned - {"Any", "Path"} <= set(dw.__all__)


def test_every_public_function_spells_out_its_arguments_and_says_what_it_returns():
    methods = [
        (f"{name}.{member}", value)
        for name in ("Study", "Results", "Run")
        for member, value in inspect.getmembers(getattr(dw, name), inspect.isfunction)
        if not member.startswith("_") and member not in INTERNAL
    ]
    for name, function in (*public(inspect.isfunction).items(), *methods):
        kinds = {one.kind for one in inspect.signature(function).parameters.values()}
        assert inspect.Parameter.VAR_KEYWORD not in kinds, name
    for name, function in public(inspect.isfunction).items():
        assert "Returns:" in inspect.getdoc(function), name
        assert not re.search(r"`\w+_steps`|see `\w+_\w+`", inspect.getdoc(function)), name


INTERNAL = {"carry_out"}
"""For searches of our own."""


def test_a_type_checker_does_not_see_names_that_are_not_there():
    tree = ast.parse(Path(dw.__file__).read_text("utf-8"))
    hidden = [node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "not TYPE_CHECKING"]
    assert [one.name for node in hidden for one in node.body] == ["__getattr__"]
    assert "__getattr__" not in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.long
def test_a_script_of_a_user_passes_a_strict_type_checker_and_a_misspelt_name_does_not(tmp_path):
    script = (ROOT / "tests" / "typed" / "mine.py").read_text("utf-8")
    assert len([line for line in script.splitlines() if line.strip()]) <= 60

    def checked(text):
        (tmp_path / "mine.py").write_text(text, "utf-8")
        words = ["--strict", "--config-file", str(ROOT / "pyproject.toml"), "--cache-dir", str(tmp_path / "cache")]
        command = [sys.executable, "-m", "mypy", *words, str(tmp_path / "mine.py")]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stdout

    assert checked(script) == "Success: no issues found in 1 source file\n"
    for right, wrong in (("dw.simulate", "dw.simulat"), ("seed=", "sed="), ("plan.robots", "plan.robot")):
        assert "error: " in checked(script.replace(right, wrong)), wrong


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    factors = {"fleet.size": range(1, 7), "policies.allocation": ["in-order", "nearest", "regret", "auction"]}
    small = MODEL.replace({"tasks.goods": {"random": 14}})
    made = dw.Study(small, factors, replications=2, indicators=["T", "S"])
    return made.run(out=tmp_path_factory.mktemp("large") / "study")


@pytest.mark.slow
def test_a_large_study_prints_what_says_most_and_where_the_rest_is(large):
    results, compared = large.results, large.compare("T")
    for thing in (results, compared):
        assert 1000 < len(str(thing).encode()) <= MOST
    assert re.search(
        r"^\d+ more options( and more tables)? are on the page and in the table \(\.table; --json\)\.$",
        str(results),
        re.MULTILINE,
    )
    differ = [one.name for one in compared.answer.options if one.standing == "differs"]
    assert differ
    assert all(name in str(compared) for name in differ)
    many = answer_text.printed_rows("", ("level", "effect"), [(str(level), "+1") for level in range(500)])
    assert len(many.encode()) <= MOST
    assert re.search(r"\d+ more rows are in the table", many)


@pytest.mark.long  # of a small one every day
def test_text_of_a_large_study_is_what_the_command_prints(large):
    assert command("compare", large.folder, "--indicator", "T") == str(large.compare("T"))
    assert command("study", large.folder, "--quiet") == str(large.results)
