"""Indicators of the user's own: the table has them, they are kept and resumed, and every way to simulate agrees."""

import concurrent.futures
import functools
import io
import multiprocessing
import pickle
import threading
from pathlib import Path

import pandas as pd
import pytest

import desim_warehouse as dw
from tests.study.measuring import MODEL, per_task, row_of


def wrong(run):
    return run.kpis["no such indicator"]


def study(function=per_task, **more):
    return dw.Study(MODEL, {"fleet.size": [1, 2]}, replications=3, indicators={"per_task": function}, **more)


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return plain(study().run().table)


def plain(table):
    return table.drop(columns="run_time")


def by_hand(seed):
    run = dw.simulate(MODEL.replace({"fleet.size": 2}), seed=seed)
    return run.robots["distance"].sum() / run.kpis["tasks"]


def test_it_is_a_column_like_the_others(table):
    row = table.iloc[4]
    assert row["fleet.size"] == 2
    assert row["per_task"] == by_hand(int(row["seed"]))
    assert {"T", "S", "throughput_per_hour"} <= set(table)
    made = study().run()
    assert set(made.summary(["per_task"])["indicator"]) == {"per_task"}
    assert "per_task" in str(made.compare("per_task"))
    assert made.main_effects("per_task").factors[0].swing > 0


def kept(folder):
    """How many runs a folder has, those of other functions too."""
    return len((folder / "runs.jsonl").read_bytes().splitlines())


def test_it_is_kept_in_the_folder_and_resumed(tmp_path, table):
    study().run(out=tmp_path)
    pd.testing.assert_frame_equal(plain(study().run(out=tmp_path).table), table)
    opened = dw.Study.open(tmp_path)
    pd.testing.assert_frame_equal(plain(opened.run(out=tmp_path).table), table)
    assert kept(tmp_path) == 6
    more = dw.Study(MODEL, {"fleet.size": [1, 2]}, replications=4, indicators={"per_task": per_task}).run(out=tmp_path)
    assert kept(tmp_path) == len(more.table) == 8


def test_a_changed_function_is_another_indicator(tmp_path):
    study().run(out=tmp_path)
    twice = study(lambda run: 2 * per_task(run)).run(out=tmp_path)
    assert twice.table["per_task"].iloc[4] == 2 * by_hand(int(twice.table["seed"].iloc[4]))


def test_so_is_one_with_other_arguments(tmp_path):
    for by in (2, 3):
        made = study(functools.partial(lambda run, by: by * per_task(run), by=by)).run(out=tmp_path)
        assert made.table["per_task"].iloc[4] == by * by_hand(int(made.table["seed"].iloc[4]))
    assert kept(tmp_path) == 12


def test_what_nobody_can_look_into_is_simulated_anew_by_each_study(tmp_path):
    def locked(run, lock=threading.Lock()):  # noqa: B008 - as it is
        with lock:
            return per_task(run)

    made = study(locked)
    for runs in (6, 6):
        made.run(out=tmp_path)
        assert kept(tmp_path) == runs
    study(locked).run(out=tmp_path)
    assert kept(tmp_path) == 12


def test_a_folder_says_that_it_has_no_function(tmp_path):
    made = study().run(out=tmp_path)
    (tmp_path / "runs.jsonl").write_bytes(b"".join((tmp_path / "runs.jsonl").read_bytes().splitlines(True)[:3]))
    with pytest.raises(dw.StudyError, match="indicator per_task: its function is not in the folder"):
        dw.Study.open(tmp_path).run(out=tmp_path)
    assert len(made.run(out=tmp_path).table) == 6


def test_what_a_function_raises_is_told_with_its_line():
    line = wrong.__code__.co_firstlineno + 1
    with pytest.raises(dw.StudyError, match=rf"indicator per_task: raised .* in .*test_own_indicators.py, line {line}"):
        study(wrong).run()


@pytest.mark.parametrize(
    ("name", "holder"),
    [
        ("T", "an indicator"),
        ("on_time@11:30-13:00", "an indicator"),
        ("seed", "a column of its tables"),
        ("fleet.size", "a factor"),
        ("hours", "a factor"),
    ],
)
def test_the_name_of_another_column_is_refused(name, holder):
    factors = {"fleet.size": [1, 2], "hours": {"cases": {"short": {"run.length": 100}, "long": {"run.length": 200}}}}
    with pytest.raises(dw.StudyError, match=f"indicators, {name}: the name of {holder}, expected another"):
        dw.Study(MODEL, factors, indicators={name: per_task})


def test_the_name_of_a_column_of_means_is_free(tmp_path):
    """There an indicator is a row, not a column."""
    made = dw.Study(
        "models/tutorial.yaml", {"fleet.size": [3]}, replications=2, indicators={"missing": lambda run: run.T}
    )
    made.run(out=tmp_path / "out")
    assert made.summary(["missing"])["mean"].tolist() == made.summary(["T"])["mean"].tolist()


def test_the_name_is_a_text():
    with pytest.raises(dw.StudyError, match="indicators, 3: expected a name in quotes"):
        dw.Study(MODEL, indicators={3: per_task})


def test_a_function_that_is_none_is_refused():
    with pytest.raises(dw.StudyError, match="'per_task', expected a function of a run"):
        dw.Study(MODEL, indicators={"mine": "per_task"})


def test_an_indicator_goes_to_workers_as_it_is():
    """What a study sends them."""
    assert pickle.loads(pickle.dumps(per_task)) is per_task  # noqa: S301 - our own


@pytest.mark.long
def test_worker_processes_give_the_same_table(table):
    pd.testing.assert_frame_equal(plain(study().run(workers=2).table), table)


NAMES = ["T", "S", "C", "throughput_per_hour", "distance"]


def with_multiprocessing(jobs):
    with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        return list(pool.map(row_of, *zip(*jobs, strict=True)))


def with_joblib(jobs):
    joblib = pytest.importorskip("joblib", reason="joblib is not installed")
    return joblib.Parallel(n_jobs=2)(joblib.delayed(row_of)(*job) for job in jobs)


def with_dask(jobs):
    dask = pytest.importorskip("dask", reason="Dask is not installed")
    return list(dask.compute(*(dask.delayed(row_of)(*job) for job in jobs), scheduler="threads"))


def with_a_notebook(jobs):
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    cell = (
        "import pandas as pd\nfrom tests.study.measuring import row_of\n"
        f"print(pd.concat([row_of(*job) for job in {jobs!r}]).to_json(orient='records', double_precision=15))"
    )
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell)])
    root = Path(__file__).parents[2]
    nbclient.NotebookClient(book, timeout=60, resources={"metadata": {"path": str(root)}}).execute()
    (output,) = book.cells[0].outputs
    return [pd.read_json(io.StringIO(output.text), orient="records", precise_float=True)]


@pytest.mark.parametrize(
    "way",
    [
        pytest.param(with_multiprocessing, marks=pytest.mark.long),
        pytest.param(with_joblib, marks=pytest.mark.slow),
        with_dask,
        pytest.param(with_a_notebook, marks=pytest.mark.long),
    ],
)
def test_so_do_the_ways_of_the_user(way, table):
    jobs = list(zip(table["fleet.size"].tolist(), table["seed"].astype(int).tolist(), strict=True))
    rows = pd.concat(way(jobs), ignore_index=True)
    pd.testing.assert_frame_equal(rows[NAMES], table[NAMES], check_dtype=False, check_exact=True)


def test_the_best_design_is_chosen_by_it():
    search = dw.Search(first=3, cap=3, cache=False)
    best = dw.best(study(), "per_task", maximise=False, search=search)
    means = study().run().table.groupby("fleet.size")["per_task"].mean()
    assert best.overrides == {"fleet.size": means.idxmin()}
    assert f"{means.min():.3g}" in str(best)
    assert str(best).startswith("Per_task is smallest")
    with pytest.raises(dw.StudyError, match="of one of your own, expected maximise=False or True"):
        dw.best(study(), "per_task", search=search)
