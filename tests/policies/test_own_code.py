"""A user's own policies are code: it is run where a model is simulated or checked, and nowhere else."""

import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.policies.catalogue import user_source

pytestmark = pytest.mark.slow
TUTORIAL = str(Path(__file__).parents[2] / "models" / "tutorial.yaml")
CODE = """
from dataclasses import dataclass
from pathlib import Path

with Path(__file__).with_name("ran").open("a") as file:
    file.write("x")

@dataclass(frozen=True)
class Mine:
    patience: int = 1

    def assign(self, situation):
        robots, tasks = list(situation.robots), list(situation.tasks)
        return [(robots[0].number, tasks[0].number)] if situation.feasible(robots[0], tasks[0]) else []
"""


@pytest.fixture
def mine(tmp_path):
    (tmp_path / "mine.py").write_text(CODE)
    return f"{tmp_path / 'mine.py'}:Mine"


def has_run(folder):
    """Whether the code has run since it was last asked; afterwards nobody has imported it."""
    for name in [name for name in sys.modules if name.startswith("desim_policies_")]:
        del sys.modules[name]
    ran = (folder / "ran").exists()
    (folder / "ran").unlink(missing_ok=True)
    return ran


def call(*arguments):
    result = CliRunner().invoke(desim, [str(item) for item in arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_reading_a_model_does_not_run_it(mine, tmp_path):
    model = dw.load(TUTORIAL, {"policies.allocation": {"name": mine, "patience": "very"}})
    assert model.replace({"fleet.size": 2}).digest() != model.digest()
    assert model.content()["policies"]["allocation"] == {"name": mine, "patience": "very"}
    assert not has_run(tmp_path)


def test_looking_at_a_run_or_a_study_does_not_run_it(mine, tmp_path):
    out = tmp_path / "out"
    call("run", TUTORIAL, "--set", f"policies.allocation={mine}", "--out", out / "run")
    vary = [
        "--vary",
        "fleet.size=1,2",
        "--vary",
        f"policies.allocation={mine},nearest",
        "--replications",
        2,
        "--workers",
        1,
    ]
    call("what-if", TUTORIAL, *vary, "--out", out / "study", "--quiet")
    assert has_run(tmp_path)
    call("export", out / "run", "--format", "trace", "-o", out / "trace.json")
    call("replay", out / "run", "-o", out / "replay.html")
    call("report", out / "run")
    call("report", out / "study")
    call("compare", out / "study", "--indicator", "T")
    assert dw.load_run(out / "run").T > 0
    assert not has_run(tmp_path)


@pytest.mark.parametrize("command", ["run", "check"])
def test_what_simulates_or_checks_runs_it(command, mine, tmp_path):
    call(command, TUTORIAL, "--set", f"policies.allocation={mine}")
    assert has_run(tmp_path)


def test_a_wrong_parameter_is_told_before_anything_is_simulated(mine):
    overrides = {"policies.allocation": {"name": mine, "patience": "very"}}
    reason = r"patience: not understood \(got 'very'\), expected a whole number"
    with pytest.raises(dw.ModelError, match=rf"policies\.allocation\.{reason}"):
        dw.load(TUTORIAL, overrides, run_code=True)
    with pytest.raises(dw.PolicyError, match=rf"policies\.allocation\.{reason}"):
        dw.simulate(dw.load(TUTORIAL, overrides))
    with pytest.raises(dw.ModelError, match=rf"factors\.policies\.allocation\.0\.{reason}"):
        dw.Study(TUTORIAL, {"policies.allocation": [overrides["policies.allocation"], "nearest"]})


def test_a_file_whose_name_is_too_long_is_missing():
    name = "x" * 5000 + ".py:Mine"
    assert dw.load(TUTORIAL, {"policies.allocation": name}).policies.allocation.name == name
    with pytest.raises(dw.ModelError, match="no file xxx"):
        dw.load(TUTORIAL, {"policies.allocation": name}, run_code=True)


def test_the_digest_reads_a_module_without_importing_the_package_it_lies_in(tmp_path, monkeypatch):
    (tmp_path / "shelf" / "inner").mkdir(parents=True)
    for folder in ("shelf", "shelf/inner"):
        (tmp_path / folder / "__init__.py").write_text("raise RuntimeError")
    (tmp_path / "shelf" / "inner" / "mine.py").write_text(CODE)
    monkeypatch.syspath_prepend(tmp_path)
    assert user_source("shelf.inner.mine:Mine") == CODE.encode()
    assert user_source("shelf.nowhere:Mine") == user_source("nowhere.at.all:Mine") == b""
    assert user_source("json.decoder:JSONDecoder") == Path(sys.modules["json.decoder"].__file__).read_bytes()
