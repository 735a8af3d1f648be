"""`desim fit`: what it proposes, the figure it writes, and files that it cannot read."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ModelError, ReportError, StudyError
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.study.fit import fit

pytestmark = pytest.mark.usefixtures("fewer_samples")


def call(*arguments):
    return CliRunner().invoke(desim, ["fit", *map(str, arguments)], catch_exceptions=False)


@pytest.fixture
def picks(tmp_path):
    times = np.random.default_rng(3).lognormal(2, 0.4, 200)
    file = tmp_path / "picks.csv"
    file.write_text("pick,load_s\n" + "".join(f"{n},{time:.1f}\n" for n, time in enumerate(times)), encoding="utf-8")
    return file


def test_what_is_proposed_can_be_put_into_a_model(picks, tmp_path):
    output = call(picks, "--column", "load_s", "--out", tmp_path / "out").stdout
    (proposed,) = (line.removeprefix("proposed: ") for line in output.splitlines() if line.startswith("proposed"))
    model = dw.load("models/tutorial.yaml", {"tasks.load_time": read_yaml(proposed, "proposed").data})
    assert model.tasks.load_time.kind == "lognormal"
    assert model.tasks.load_time.mean == pytest.approx(8.1, abs=0.3)
    assert {file.name for file in (tmp_path / "out").iterdir()} == {"answer.json", "fit.png", "fit.svg"}


PROPOSED = re.compile(r"proposed[^:]*: (.*)")


def proposal(file, column, *options):
    """The mean load time, in seconds, of a model with what is proposed."""
    text = PROPOSED.search(call(file, "--column", column, *options).stdout)[1]
    return text, dw.load("models/tutorial.yaml", {"tasks.load_time": read_yaml(text, "proposed").data}).tasks.load_time


def test_what_is_proposed_for_minutes_is_in_minutes(picks, tmp_path):
    """Loads of 8.1 min are 486 s where a model is in seconds; in seconds they are 8.1 s."""
    text, minutes = proposal(picks, "load_s", "--unit", "min")
    assert text.startswith("{lognormal: {mean: 8.")
    assert " min, cv: 0." in text
    _, seconds = proposal(picks, "load_s")
    assert minutes.mean == pytest.approx(60 * seconds.mean)
    assert minutes.cv == seconds.cv
    call(picks, "--column", "load_s", "--unit", "min", "--out", tmp_path / "out")
    assert text in json.loads((tmp_path / "out" / "answer.json").read_text("utf-8"))["answer"][1]


def test_where_nothing_fits_the_file_itself_is_proposed(tmp_path):
    """The mean of 5, 5.1, 20 and 21 is 12.775: minutes, of which each has 60 s."""
    file = tmp_path / "two.csv"
    file.write_text("s\n" + "5\n5.1\n" * 20 + "20\n21\n" * 20, encoding="utf-8")
    text, minutes = proposal(file, "s", "--unit", "min")
    assert text == f"{{empirical: {{file: {file}, column: s, unit: min}}}}"
    assert minutes.mean == pytest.approx(60 * 12.775)
    assert proposal(file, "s")[1].mean == pytest.approx(12.775)


def test_a_unit_of_no_known_size_is_refused(picks):
    assert "'min'" in call(picks, "--column", "load_s", "--unit", "minutes").output


def test_cells_that_are_no_times_are_listed_by_row(tmp_path):
    file = tmp_path / "bad.csv"
    file.write_text("s\n5\nsoon\n-1\n" + "x\n" * 30, encoding="utf-8")
    with pytest.raises(StudyError) as refused:
        call(file, "--column", "s")
    lines = str(refused.value).splitlines()
    assert lines[:2] == [
        f"{file}:3: s: not a time (got 'soon'), expected a number of at least 0",
        f"{file}:4: s: not a time (got '-1'), expected a number of at least 0",
    ]
    assert len(lines) == 21
    assert lines[-1] == f"{file}: and 12 more"


def test_a_column_that_is_not_there(picks, tmp_path):
    with pytest.raises(StudyError, match=r"no column 'load' .*did you mean 'load_s'"):
        call(picks, "--column", "load")
    with pytest.raises(StudyError, match="cannot be read"):
        call(tmp_path / "none.csv", "--column", "load")


@pytest.mark.parametrize(("mark", "named"), [(";", "semicolons"), ("\t", "tabs")])
def test_a_file_with_other_marks_between_its_cells_is_told_so(tmp_path, mark, named):
    """A sheet that was saved where numbers have decimal commas, read by `fit`, by a model, and as trips of a fleet."""
    file, message = tmp_path / "saved.csv", f"its cells end with {named}, expected commas, and decimal points"
    file.write_text(f"load_s{mark}n\n8,5{mark}1\n9,5{mark}2\n", encoding="utf-8")
    with pytest.raises(StudyError, match=rf"no column 'load_s' .*{message}"):
        call(file, "--column", "load_s")
    with pytest.raises(ModelError, match=message):
        dw.load("models/multibots.yaml", {"tasks.load_time": {"empirical": {"file": str(file), "column": "load_s"}}})
    with pytest.raises(ReportError, match=message):
        dw.read_log(file)


def test_the_figure_shows_the_times_and_the_best_three():
    times = np.random.default_rng(3).lognormal(2, 0.4, 200)
    fits = fit(times)
    axes = dw.plot.fitted(fits, unit="min")
    measured, *curves = axes.get_lines()
    assert measured.get_xdata() == pytest.approx(np.sort(times))
    assert measured.get_ydata()[-1] == 1
    assert [line.get_label() for line in curves] == [one.distribution.words("min") for one in fits.candidates[:3]]
    best = curves[0]
    assert best.get_ydata() == pytest.approx(fits.candidates[0].share_below(best.get_xdata()))
    assert axes.get_xlabel() == "Time (min)"
