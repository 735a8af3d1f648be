"""What users hold stays valid: folders of version 0.3.0, kept as it wrote them, open and say of which version they are.

`run` is of the tutorial's model with the whole log, `plan` and `why` are of a small draft. `study` is the study
of the why. None of them is ever written again.
"""

import json
import re
import shutil
import sys
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.report.write import read_answer

pytestmark = pytest.mark.usefixtures("brief_probes")

HERE = Path(__file__).parent / "0.3.0"
STUDY = HERE / "why"
SIMULATED = "simulated with version 0.3.0"


def called(*arguments):
    return CliRunner().invoke(desim, [str(one) for one in arguments], catch_exceptions=False)


@pytest.fixture
def kept(tmp_path):
    """The folders, to write into."""
    for name, folder in (("run", HERE / "run"), ("plan", HERE / "plan"), ("why", HERE / "why"), ("study", STUDY)):
        shutil.copytree(folder, tmp_path / name)
    (tmp_path / "study" / "why.json").unlink()
    return tmp_path


def changed(path, before, after):
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after), encoding="utf-8")


def test_a_run_has_the_tables_that_were_saved_with_it():
    run = dw.load_run(HERE / "run")
    assert run.version == "0.3.0" != dw.__version__
    log = pd.read_parquet(HERE / "run" / "log.parquet")
    pd.testing.assert_frame_equal(run.log[log.columns], log, check_dtype=False)  # columns that came later are empty
    for name in ("robots", "edges", "nodes"):
        pd.testing.assert_frame_equal(getattr(run, name), pd.read_csv(HERE / "run" / f"{name}.csv", index_col=0))
    assert run.history.energy_at_end == pytest.approx([100, 94.05, 83.38])


def test_a_run_has_the_indicators_that_were_saved_with_it(kept):
    """As if 0.3.0 had counted one collision more than this version does, and known an indicator that is gone."""
    saved = json.loads((kept / "run" / "kpis.json").read_text())
    assert {name: dw.load_run(kept / "run").kpis[name] for name in saved} == saved
    other = saved | {"S": saved["S"] + 1, "gone": 3.5}
    (kept / "run" / "kpis.json").write_text(json.dumps(other))
    run = dw.load_run(kept / "run")
    assert {name: run.kpis[name] for name in other} == other
    assert saved["S"] + 1 == run.S


def test_a_run_of_this_version_is_read_from_its_log_alone(kept):
    run = dw.load_run(kept / "run")
    again = dw.simulate(run.model, run.seed)
    (again.save(kept / "again") / "kpis.json").unlink()
    assert dw.load_run(kept / "again").kpis == again.kpis
    assert dw.load_run(kept / "again").version == dw.__version__


def test_a_run_that_is_saved_again_stays_of_its_version(kept):
    dw.load_run(kept / "run").save(kept / "again")
    assert dw.load_run(kept / "again").version == "0.3.0"


def test_a_run_is_replayed_and_the_page_says_of_which_version_it_is(kept):
    assert called("replay", kept / "run", "-o", kept / "page.html").exit_code == 0
    assert f'"label":"seed 0, {SIMULATED}"' in (kept / "page.html").read_text(encoding="utf-8").replace('": "', '":"')
    now = dw.simulate(dw.load_run(kept / "run").model)
    assert "simulated with" not in now.replay().html


@pytest.mark.parametrize(("form", "made"), [("csv", "csv/kpis.csv"), ("parquet", "parquet/kpis.parquet")])
def test_a_run_is_exported_with_its_saved_indicators(kept, form, made):
    changed(kept / "run" / "kpis.json", '"S": ', '"S": 100')
    assert called("export", kept / "run", "--format", form).exit_code == 0
    table = getattr(pd, f"read_{form}")(kept / "run" / made).set_index("indicator")
    assert table["value"]["S"] == json.loads((kept / "run" / "kpis.json").read_text())["S"] >= 100


def test_a_trace_names_the_version_that_simulated_it(kept):
    assert called("export", kept / "run", "--format", "trace").exit_code == 0
    assert json.loads((kept / "run" / "trace.json").read_text())["otherData"]["version"] == "0.3.0"


@pytest.mark.parametrize("name", ["run", "study", "plan", "why"])
def test_a_report_says_which_version_simulated_and_which_reports(kept, name):
    assert called("report", kept / name).exit_code == 0
    page = (kept / name / "report.html").read_text(encoding="utf-8")
    assert "0.3.0" in page
    assert f"desim-warehouse {dw.__version__}, Python {sys.version.split()[0]}" in page


def test_a_study_has_the_table_that_was_saved_with_it():
    results = dw.Results.load(STUDY)
    pd.testing.assert_frame_equal(results.table, pd.read_parquet(STUDY / "results.parquet"))
    assert results.version == "0.3.0"
    assert results.notes == ()


def test_a_study_is_compared_and_the_table_says_of_which_version_it_is(kept):
    done = called("compare", kept / "study")
    assert f"S{SIMULATED[1:]}.\n" in done.output
    # throughput in the saved table: 39.25 an hour on average, 39.375 as it is
    assert re.search(r"one charger more +−0\.12 tasks/h \(−0\.56 to 0\.31\) +not shown to differ", done.output)


def test_a_finished_study_is_shown_on_a_page_and_in_tables_without_simulating(kept):
    before = {path.name: path.read_bytes() for path in (kept / "study").iterdir()}
    done = called("study", kept / "study", "--page", kept / "page.html", "--quantile", "50%")
    assert f"50 % quantiles over runs, 95 % intervals, {SIMULATED}\n" in done.output
    assert SIMULATED[1:] in (kept / "page.html").read_text(encoding="utf-8")
    assert {path.name: path.read_bytes() for path in (kept / "study").iterdir()} == before


@pytest.mark.long  # one that is not finished is resumed every day
def test_resuming_a_finished_study_says_that_it_simulates_anew(kept):
    done = called("study", kept / "study", "--out", kept / "study")
    assert f"40 runs are of version 0.3.0 not used again, but kept; {dw.__version__} simulates anew" in done.output
    assert "simulated with" not in done.output
    assert dw.Results.load(kept / "study").version == dw.__version__
    assert len((kept / "study" / "runs.jsonl").read_bytes().splitlines()) == 40 + 40


@pytest.mark.parametrize(
    ("runs", "replications"),
    [(2, [1, 2]), pytest.param(40, [8, 8, 8, 8, 4, 5], marks=pytest.mark.long)],
    ids=["two runs", "all"],
)
def test_resuming_a_study_with_more_replications_says_that_it_simulates_anew(kept, runs, replications):
    """Of two runs it is a study of its first two designs."""
    folder, designs = kept / "study", len(replications)
    lines = (folder / "runs.jsonl").read_bytes().splitlines(keepends=True)
    (folder / "runs.jsonl").write_bytes(b"".join(lines[:runs]))  # the first runs of all designs come first
    content = json.loads((folder / "study.json").read_text())
    content["factors"][0]["levels"] = content["factors"][0]["levels"][:designs]
    content |= {"points": content["points"][:designs], "replications": replications}
    (folder / "study.json").write_text(json.dumps(content))
    assert not dw.Results.load(folder).is_whole
    done = called("study", folder)
    assert f"{runs} runs are of version 0.3.0 not used again" in done.output
    assert len(dw.Results.load(folder).rows) == runs + 1


def test_a_plan_is_read_with_the_sentences_that_were_saved_with_it():
    plan = read_answer(HERE / "plan")
    content = json.loads((HERE / "plan" / "plan.json").read_text())
    assert list(plan.answer) == content["answer"]
    assert [row[1] for row in plan.tables[0].rows] == [one["found"] for one in content["evidence"]]
    assert plan.made["desim-warehouse"] == "0.3.0"
    assert (plan.about, plan.tiles, plan.options) == (None, (), ())  # it is not judged anew


def test_models_and_plans_of_studies_load():
    content = json.loads((HERE / "run" / "run.json").read_text())["model"]
    model = dw.load(content)
    assert (model.name, model.fleet.size) == (content["name"], content["fleet"]["size"])
    assert dw.load(model.content()) == model
    assert dw.Study.open(STUDY).plan.replications == (8, 8, 8, 8, 4, 4)


@pytest.mark.parametrize("name", ["n", "q", "w"])
def test_drafts_of_030_load_and_pass_check(name):
    assert not dw.check(dw.load(HERE / f"{name}.yaml")).errors


@pytest.mark.parametrize(
    ("name", "file", "version"),
    [("run", "run.json", '"version": "'), ("study", "study.json", '"desim-warehouse": "')],
)
def test_a_folder_of_an_older_version_is_refused_with_the_version_that_reads_it(kept, name, file, version):
    changed(kept / name / file, f"{version}0.3.0", f"{version}0.2.0")
    with pytest.raises(
        dw.WarehouseError, match=r"of version 0\.2\.0, expected 0\.3 or later; desim-warehouse 0\.3\.0 reads it"
    ):
        called("report", kept / name)


@pytest.mark.parametrize(("name", "study"), [("plan", "today"), ("why", "")])
def test_an_answer_of_an_older_version_is_refused_too(kept, name, study):
    changed(kept / name / study / "study.json", '"desim-warehouse": "0.3.0', '"desim-warehouse": "0.2.0')
    with pytest.raises(dw.WarehouseError, match=r"desim-warehouse 0\.3\.0 reads it"):
        called("report", kept / name)
