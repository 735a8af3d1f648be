"""What commands take Python takes, or it says in one sentence what it expects: models, seeds, growth, indicators."""

import json
import math
import pickle
from pathlib import Path

import numpy as np
import pytest

import desim_warehouse as dw
from desim_warehouse.study.fleet.given import counts_of, growth_of

TUTORIAL = "models/tutorial.yaml"


@pytest.fixture(scope="module")
def model():
    return dw.load(TUTORIAL)


@pytest.mark.parametrize("source", [TUTORIAL, Path(TUTORIAL), "content"])
def test_a_model_its_file_and_its_content_are_the_same(model, source):
    source = model.content() if source == "content" else source
    assert dw.simulate(source, 1).kpis == dw.simulate(model, 1).kpis
    assert dw.check(source).lines == dw.check(model).lines
    assert next(iter(dw.steps(source))).time == next(iter(dw.steps(model))).time


def test_searches_take_files_too(tmp_path):
    assert (
        dw.why(TUTORIAL, search=dw.Search(first=2, cap=2)).indicator
        == dw.why(dw.load(TUTORIAL), search=dw.Search(first=2, cap=2)).indicator
    )
    assert dw.write_layout(TUTORIAL, tmp_path / "floor.lif", "lif") is not None


@pytest.mark.parametrize("source", [None, 3, ["models/tutorial.yaml"], object])
@pytest.mark.parametrize("call", [dw.simulate, dw.check, dw.steps, dw.orient, lambda one: dw.plan(one, "S <= 1")])
def test_what_is_no_model_is_refused_in_a_line(call, source):
    with pytest.raises(dw.ModelError, match="expected a model, its file, or its content"):
        call(source)


@pytest.mark.parametrize("seed", [None, "1", 1.5, -1, True, [1]])
@pytest.mark.parametrize(
    "call", [dw.simulate, dw.steps, lambda model, seed: dw.why(model, search=dw.Search(seed=seed))]
)
def test_a_seed_that_no_run_could_be_repeated_with_is_refused(model, call, seed):
    with pytest.raises(dw.ModelError, match=r"^seed .*: expected a whole number from 0 on"):
        call(model, seed)


NUMBERS = {
    "until": lambda number, model: dw.simulate(model, until=number),
    "first": lambda number, _: dw.Search(first=number),
    "cap": lambda number, _: dw.Search(cap=number),
    "runs": lambda number, _: dw.Search(runs=number),
    "timeout": lambda number, _: dw.Search(timeout=number),
    "workers": lambda number, _: dw.Search(workers=number),
    "confidence": lambda number, _: dw.Search(confidence=number),
    "years": lambda number, model: dw.plan(model, "S <= 1", growth="5 %/year", years=number),
    "zone": lambda number, model: dw.size(dw.Study(model, {"fleet.size": [1, 2]}), "T <= 9", zone=number),
    "delta": lambda number, model: dw.best(dw.Study(model, {"fleet.size": [1, 2]}), "T", number),
    "place-chargers": lambda number, model: dw.best(model, "T", place_chargers=number),
    "runs of validate": lambda number, model: dw.validate(model, [], runs=number),
}


@pytest.mark.parametrize("number", [True, "x", math.nan, math.inf, -math.inf, -1, [1]])
@pytest.mark.parametrize("name", NUMBERS)
def test_what_is_no_number_to_work_with_is_refused_in_a_line(model, name, number):
    with pytest.raises(dw.WarehouseError, match=rf"^[^\n]*{name.split()[0]}[^\n]*(expected|not a time)[^\n]*$"):
        NUMBERS[name](number, model)


def test_a_search_without_a_time_limit_says_none():
    with pytest.raises(dw.StudyError, match=r"^timeout inf: expected seconds above 0, or None for no limit$"):
        dw.Search(timeout=float("inf"))
    assert dw.Search(timeout=None).timeout is None


def test_a_time_that_no_clock_can_show_is_refused(model):
    with pytest.raises(dw.ModelError, match=r"^until 10*: expected a time above 0, such as 600$"):
        dw.simulate(model, until=10**400)
    assert dw.simulate(model, until=np.int64(9)).record.end == 9


def test_seeds_of_numpy_are_whole_numbers(model):
    run = dw.simulate(model, np.int64(3))
    assert run.kpis == dw.simulate(model, 3).kpis
    assert run.seed == 3


@pytest.mark.parametrize(
    ("given", "times"),
    [("30%", 1.3), ("40 %", 1.4), ("140%", 2.4), (1.3, 1.3), ("1.3", 1.3), ("10", 10), ("-20 %", 0.8)],
)
def test_growth_as_the_command_takes_it(given, times):
    assert growth_of(given, "growth") == times


@pytest.mark.parametrize("given", [30, "30", 1, 0.3, -1, 0, "much", float("nan"), float("inf"), "-100%", True])
def test_growth_that_is_none_or_was_meant_in_per_cent_is_refused(given):
    with pytest.raises(dw.StudyError, match=r"^growth: "):
        growth_of(given, "growth")


def test_counts_as_the_command_takes_them():
    assert counts_of("2..4", "robots") == counts_of(range(2, 5), "robots") == [2, 3, 4]
    assert counts_of("4,6", "robots") == counts_of([4, 6], "robots") == [4, 6]
    for bad in ("4..2", "0..2", [], [2, 1], ["a"], 3, [True]):
        with pytest.raises(dw.StudyError, match=r"^robots .*: expected whole numbers upwards from 1"):
            counts_of(bad, "robots")


def test_an_indicator_that_a_run_does_not_have_says_why_or_which_is_meant(model):
    kpis = dw.simulate(model).kpis
    with pytest.raises(dw.ReportError, match=r"^indicator 'on_time': this run does not have it; .*due times"):
        kpis["on_time"]
    with pytest.raises(KeyError, match=r"did you mean 'cycle_time_mean'\?"):
        kpis["cycle_time_men"]
    assert kpis.get("on_time") is None
    assert pickle.loads(pickle.dumps(kpis)) == json.loads(json.dumps(kpis)) == kpis  # noqa: S301 - our own


def test_the_clock_stops_where_it_is_told_and_nothing_before_is_changed(model):
    whole, part = (dw.simulate(model.replace({"log": "all"}), 1, until=until) for until in (None, 100.0))
    assert part.record.end == 100 < whole.record.end
    begun = [row for row in whole.record.rows if row[0] < 100]
    assert [row for row in part.record.rows if row[0] < 100] == begun
    assert dw.simulate(model, 1, until=1e9).kpis == whole.kpis


def test_a_run_without_end_stops_there_too(model):
    endless = model.replace({"tasks.goods": {"poisson": 100}, "run.length": 7200})
    assert dw.simulate(endless, until=300.0).record.end == 300
    assert dw.simulate(endless, until=9000.0).record.end == 7200


def test_a_target_or_study_that_is_none_is_refused_in_a_line(model):
    with pytest.raises(dw.StudyError, match=r"^target None: expected words such as"):
        dw.plan(model, None)
    with pytest.raises(dw.StudyError, match=r"^size: .*expected a Study of one factor"):
        dw.size(TUTORIAL, "on_time >= 95 %")


def test_a_model_in_a_cell_is_one_line(model):
    """Of 2 x 1 blocks, so 3 x 2 nodes; two models that differ have the same size, and another digest."""
    day = model.replace({"run.length": "8 h", "tasks.load_time": 7})
    assert (
        repr(model)
        == str(model)
        == f"Model(tutorial: robots=3, nodes=6, until all work is done, digest={short(model)})"
    )
    assert repr(day) == f"Model(tutorial: robots=3, nodes=6, length=28800 s, digest={short(day)})"
    assert short(model) != short(day)


def short(model):
    return model.digest()[:8]
