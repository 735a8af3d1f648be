"""What commands write: never over files of somebody else, over ours as often as asked, and by Ctrl-C nothing half."""

import os
from concurrent.futures import ThreadPoolExecutor

import pandas as pd
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim


@pytest.fixture(autouse=True)
def hardly_any_samples(monkeypatch):
    """What a fit says is not tested here."""
    monkeypatch.setattr("desim_warehouse.study.fit.SAMPLES", 3)


HALL = """
name: one robot
layout:
  blocks: {columns: 2, rows: 1, block_depth: 2, goods_size: 1, aisle_width: 1}
  bays: {home: {along: north}}
fleet: {size: 1, robot: {radius: 0.3, speed: 1}}
tasks: {goods: [0, 7], unload_at: [D], load_time: 5, unload_time: {lognormal: {mean: 10, cv: 0.3}}}
log: all
"""
THEIRS = "of mine\n"


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    folder = tmp_path_factory.mktemp("home")
    (folder / "hall.yaml").write_text(HALL)
    dw.simulate(dw.load(folder / "hall.yaml")).save(folder / "run")
    (folder / "times.csv").write_text("load_s\n" + "\n".join(str(3 + n % 7) for n in range(40)) + "\n")
    return folder


def call(words):
    done = CliRunner().invoke(desim, words)
    if isinstance(done.exception, dw.WarehouseError | OSError):
        return str(done.exception)
    assert done.exit_code == 0, done.output
    return ""


MODEL, RUN = "{home}/hall.yaml", "{home}/run"
WRITERS = {
    "csv": (("export", RUN, "--format", "csv", "-o", "{out}"), "kpis.csv"),
    "a table among others": (("export", RUN, "--format", "csv", "-o", "{out}"), "edges.csv"),
    "parquet": (("export", RUN, "--format", "parquet", "-o", "{out}"), "log.parquet"),
    "trace": (("export", RUN, "--format", "trace", "-o", "{out}/t.json"), "t.json"),
    "messages": (("export", RUN, "--format", "vda5050", "-o", "{out}/s.jsonl"), "s.jsonl"),
    "replay": (("replay", RUN, "-o", "{out}/r.html"), "r.html"),
    "report": (("report", RUN, "-o", "{out}/r.html"), "r.html"),
    "notebook": (("report", RUN, "-o", "{out}/r.html", "--notebook", "{out}/n.ipynb"), "n.ipynb"),
    "drawing": (("draw", MODEL, "-o", "{out}/f.svg"), "f.svg"),
    "picture": (("draw", MODEL, "-o", "{out}/f.png"), "f.png"),
    "run": (("run", MODEL, "--out", "{out}"), "kpis.json"),
    "fit": (("fit", "{home}/times.csv", "--column", "load_s", "--out", "{out}"), "fit.svg"),
    "what-if": (("what-if", MODEL, "--vary", "fleet.size=1", "--quiet", "--out", "{out}"), "results.parquet"),
    "page": (("what-if", MODEL, "--vary", "fleet.size=1,2", "--quiet", "--page", "{out}/w.html"), "w.html"),
}


@pytest.mark.parametrize(
    "writer", [pytest.param(name, marks=[pytest.mark.long] if name == "picture" else []) for name in WRITERS]
)
def test_what_is_there_and_not_ours_stays_as_it_is(home, tmp_path, writer):
    words, name = WRITERS[writer]
    words = [word.format(home=home, out=tmp_path) for word in words]
    theirs = tmp_path / name
    theirs.write_text(THEIRS)
    assert "of somebody else" in call(words)
    assert theirs.read_text() == THEIRS
    theirs.unlink()
    assert call(words) == ""
    made = theirs.read_bytes()
    assert call(words) == ""  # what is ours is written anew
    assert theirs.stat().st_size == pytest.approx(len(made), rel=0.1)


def test_force_overwrites(home, tmp_path):
    for form, name in (("csv", "log.csv"), ("trace", "trace.json")):
        path = tmp_path / name
        path.write_text(THEIRS)
        out = tmp_path if form == "csv" else path
        assert call(["export", f"{home}/run", "--format", form, "-o", str(out), "--force"]) == ""
        assert path.read_text() != THEIRS
    (tmp_path / "f.svg").write_text(THEIRS)
    assert call(["export", f"{home}/hall.yaml", "--format", "svg", "-o", str(tmp_path / "f.svg"), "--force"]) == ""


def test_a_table_of_the_users_own_beside_an_export_of_ours_is_no_reason_to_refuse(home, tmp_path):
    words = ["export", f"{home}/run", "--format", "parquet", "-o", str(tmp_path)]
    (tmp_path / "notes.txt").write_text(THEIRS)
    assert call(words) == call(words) == ""
    assert (tmp_path / "notes.txt").read_text() == THEIRS
    assert list(pd.read_parquet(tmp_path / "kpis.parquet").columns) == ["indicator", "value", "unit"]


def struck(*_, **__):
    raise KeyboardInterrupt


def struck_at_the_second(*_, **__):
    yield '{"headerId": 1}'
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("writer", "moment"),
    [
        ("run", "desim_warehouse.cli.run.simulated"),
        ("run", "desim_warehouse.run.folder.sha256"),  # the log is written, and nothing else
        ("run", "desim_warehouse.run.folder.drop_page"),
        ("page", "desim_warehouse.study.study.StudyEngine.run_by"),
        ("report", "desim_warehouse.report.write.run_page.page"),
        ("csv", "desim_warehouse.report.export.as_csv"),
        ("messages", "desim_warehouse.report.export.messages"),
    ],
)
def test_ctrl_c_leaves_no_empty_folder_and_no_half_of_a_file(home, tmp_path, monkeypatch, writer, moment):
    monkeypatch.setattr(moment, struck_at_the_second if writer == "messages" else struck)
    words, _ = WRITERS[writer]
    done = CliRunner().invoke(desim, [word.format(home=home, out=tmp_path / "new" / "one") for word in words])
    assert done.exit_code == 130
    assert list(tmp_path.iterdir()) == []


def test_messages_go_to_a_pipe_as_to_a_file(home, tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with ThreadPoolExecutor() as thread:
        read = thread.submit(pipe.read_text)
        assert call(["export", f"{home}/run", "--format", "vda5050", "-o", str(pipe)]) == ""
    assert read.result().startswith('{"headerId":')
    assert pipe.is_fifo()
