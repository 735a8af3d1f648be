"""`desim report` opens every folder that a command makes, and says what the command answered."""

import html
import json
import random
import shlex
from pathlib import Path

import pytest

import desim_warehouse as dw
from desim_warehouse.report.example import example
from desim_warehouse.report.write import report
from tests.docs import pages
from tests.lasting import LASTING
from tests.report.test_report import needs_nothing_from_outside
from tests.study.test_directions import DETOUR
from tests.world.crowded import crowded

pytestmark = pytest.mark.usefixtures("fewer_samples", "brief_probes")

SET = {"run.length": 900, "run.warm_up": 100, **LASTING}
SHORT = " ".join([*(f"--set {key}={value}" for key, value in SET.items()), "--quiet"])
TURNED = "orient turned.yaml -o better.yaml --indicator throughput_per_hour --runs 60 --quiet --study made"


@pytest.mark.parametrize(
    "command",
    [
        "run w.yaml --set run.length=900",
        pytest.param(f"what-if w.yaml --vary fleet.size=1,2 --replications 2 {SHORT}", marks=pytest.mark.long),
        "study s.yaml --quiet",
        f"size w.yaml --range 1..2 --target 'on_time >= 50 %' --first 2 --cap 2 {SHORT}",
        pytest.param(f"size w.yaml --range 1..2 --first 2 --cap 2 {SHORT}", marks=pytest.mark.long),
        f"best w.yaml --vary fleet.size=1,2 --indicator throughput_per_hour --first 2 --cap 2 {SHORT}",
        pytest.param(
            f"best w.yaml --vary fleet.size=1..3 --indicator throughput_per_hour --place-chargers 1 --runs 50 {SHORT}",
            marks=pytest.mark.long,
        ),
        pytest.param(
            f"plan w.yaml --target 'on_time >= 50 %' --robots 1..2 --chargers 1 --vary policies.allocation=nearest "
            f"{SHORT}",
            marks=pytest.mark.long,
        ),
        f"plan w.yaml --target 'on_time >= 50 %' --robots 1..2 --chargers 1 --runs 4 {SHORT}",
        f"why w.yaml --first 2 --cap 2 {SHORT}",
        pytest.param(
            "size jammed.yaml --range 30,60 --target 'throughput_per_hour >= 9000' --first 2 --cap 2 --quiet",
            marks=pytest.mark.long,
        ),
        pytest.param(
            "warm-up w.yaml --set run.length=1800 --set 'tasks.goods={saturated: 8}' --replications 2 "
            "--observations 50 " + " ".join(f"--set {key}={value}" for key, value in LASTING.items()),
            marks=pytest.mark.long,  # every day the page of another answer about inputs, that of a fit
        ),
        "fit times.csv --column load_s",
        pytest.param(TURNED, marks=pytest.mark.long),
    ],
)
def test_report_opens_every_folder_that_a_command_makes(command, tmp_path, monkeypatch):
    """Also those within it, of the parts of a search."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "turned.yaml").write_text(DETOUR, encoding="utf-8")
    (tmp_path / "jammed.yaml").write_text(json.dumps(crowded(60, run={"length": 300, "warm_up": 50})), encoding="utf-8")
    chance = random.Random(1)
    times = "\n".join(f"{chance.gammavariate(4, 2):.2f}" for _ in range(60))
    (tmp_path / "times.csv").write_text(f"load_s\n{times}\n", encoding="utf-8")
    (tmp_path / "w.yaml").write_text(json.dumps(example().content()), encoding="utf-8")
    study = {"model": "w.yaml", "set": SET, "factors": {"fleet.size": [1, 2]}}
    (tmp_path / "s.yaml").write_text(json.dumps(study), encoding="utf-8")
    command = f"desim {command}" if command is TURNED else f"desim {command} --out made"
    status, _, err = pages.run_desim(command)
    assert status in {0, 3}, err
    assert Path("made", "cap").is_dir() == ("jammed" in command)
    for folder in (Path("made"), *(one for one in Path("made").rglob("*") if one.is_dir())):
        status, _, err = pages.run_desim(f"desim report {folder}")
        assert status == 0, err
        needs_nothing_from_outside((folder / "report.html").read_text(encoding="utf-8"))
    source = Path("made", "report.html").read_text(encoding="utf-8")
    if Path("made", "answer.json").is_file() and command != f"desim {TURNED}":
        assert shlex.join(shlex.split(command)) in html.unescape(source)


def test_more_runs_leave_no_answer_of_fewer(tmp_path):
    study = dw.Study(example().replace(LASTING), {"fleet.size": [1, 2]}, replications=2).run(out=tmp_path)
    study.results.answer.save(tmp_path)
    dw.Study(example().replace(LASTING), {"fleet.size": [1, 2]}, replications=3).run(out=tmp_path)
    assert not (tmp_path / "answer.json").exists()


def test_what_python_finds_is_kept_in_its_folder(tmp_path):
    choice = dw.best(
        dw.Study(example().replace(LASTING), {"fleet.size": [1, 3]}),
        "throughput_per_hour",
        search=dw.Search(first=2, cap=2, out=tmp_path),
    )
    assert json.loads((tmp_path / "answer.json").read_text("utf-8"))["answer"] == list(choice.answer.answer)


def test_an_answer_that_another_replaces_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("w.yaml").write_text(json.dumps(example().content()), encoding="utf-8")
    size = f"desim size w.yaml --range 1..2 --target 'on_time >= 50 %' --first 2 --cap 2 {SHORT} --out made"
    assert pages.run_desim(size)[0] == 0
    _, _, err = pages.run_desim("desim best made --indicator throughput_per_hour --first 2 --cap 2 --quiet")
    assert err.startswith("made/answer.json: replaced; it answered: ")
    assert json.loads(Path("made", "answer.json").read_text("utf-8"))["kind"] == "best"


def test_a_page_of_the_run_before_does_not_stay_beside_another(tmp_path):
    """Saving the same run again keeps its page; a page that somebody else wrote stays, too."""
    folder = tmp_path / "run"
    model = example().replace({"run.length": 300, "run.warm_up": 0, **LASTING})
    dw.simulate(model).save(folder)
    page = report(folder)
    dw.simulate(model).save(folder)
    assert page.exists()
    dw.simulate(model, 1).save(folder)
    assert not page.exists()
    page.write_text("by hand", encoding="utf-8")
    dw.simulate(model, 2).save(folder)
    assert page.read_text(encoding="utf-8") == "by hand"
