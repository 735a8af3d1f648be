"""Whoever hands out a run or the results of a study hands out ones that answer in words and show themselves."""

import pickle
from itertools import islice
from types import SimpleNamespace

import pytest

import desim_warehouse as dw
from desim_warehouse.live.answers import results_of
from desim_warehouse.policies import create
from desim_warehouse.questions.run import Run
from desim_warehouse.questions.study import Results

MODEL = "models/multibots.yaml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study of two designs, of which the folder has all runs."""
    path = tmp_path_factory.mktemp("study")
    dw.Study(MODEL, {"fleet.size": [1, 2]}, replications=2).run(out=path)
    return path


def partial(path):
    """A study that was ended after its first run, and is read from its folder."""
    stream = dw.Study(MODEL, {"fleet.size": [1, 2]}, replications=2).stream(out=path)
    list(islice(stream, 1))
    stream.close()
    return dw.Results.load(path)


def live(folder):
    """What the live page makes of the runs of its designs."""
    rows = dw.Results.load(folder).by_point
    designs = [
        (SimpleNamespace(words=f"{size} robots", changes={"fleet.size": size}), [row.outcome for row in rows[number]])
        for number, size in enumerate((1, 2))
    ]
    return results_of(dw.load(MODEL), designs, 0)


HOLDERS = {
    "run": lambda _folder, _new: dw.Study(MODEL, {"fleet.size": [1, 2]}, replications=2).run().results,
    "loaded": lambda folder, _new: dw.Results.load(folder),
    "opened": lambda folder, _new: dw.Study.open(folder).results,
    "resumed": lambda folder, _new: dw.Study.open(folder).run(out=folder).results,
    "partial": lambda _folder, new: partial(new),
    "unpickled": lambda folder, _new: pickle.loads(pickle.dumps(dw.Results.load(folder))),  # noqa: S301
    "live": lambda folder, _new: live(folder),
}


@pytest.mark.parametrize("holder", HOLDERS)
def test_results_answer_wherever_they_come_from(holder, folder, tmp_path):
    results = HOLDERS[holder](folder, tmp_path)
    assert type(results) is Results
    assert results.answer.answer
    assert str(results.answer).startswith(results.answer.answer[0])
    assert results._repr_html_().startswith("<iframe")


def test_runs_show_themselves_wherever_they_come_from(tmp_path):
    run = dw.simulate(MODEL)
    nearest, stepped = create("allocation", "nearest", {}), dw.steps(MODEL)
    for decision in stepped:
        stepped.tell(nearest.assign(decision.situation))
    runs = [run, dw.load_run(run.save(tmp_path)), pickle.loads(pickle.dumps(run)), stepped.run]  # noqa: S301
    assert {type(each) for each in runs} == {Run}
    assert all(each._repr_html_().startswith("<iframe") for each in runs)
