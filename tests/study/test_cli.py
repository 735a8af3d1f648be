"""The commands about studies, by their runner."""

import re

import pandas as pd
import pytest
from click.testing import CliRunner

from desim_warehouse.cli import desim
from desim_warehouse.errors import WarehouseError

from .conftest import MULTIBOTS, ROOT

GOODS = ["--set", "tasks.goods={random: 4}"]


def call(*arguments):
    result = CliRunner().invoke(desim, [str(argument) for argument in arguments])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def test_a_study_file_is_run_and_gone_on_with(tmp_path):
    path = tmp_path / "study.yaml"
    path.write_text(f"model: {MULTIBOTS}\nfactors: {{fleet.size: 1..2}}\nset: {{tasks.goods: {{random: 3}}}}\n")
    first = call("study", path, "--out", tmp_path / "out")
    assert first.exit_code == 0
    assert "study: 2 runs in" in first.stderr
    assert re.search(r"fleet.size +T +S +C +throughput_per_hour +runs", first.stdout)
    again = call("study", tmp_path / "out", "--workers", "2")
    assert "0 runs in" in again.stderr
    assert "2 were there already" in again.stderr
    assert again.stdout == first.stdout


def test_what_if_varies_keys_without_a_file(tmp_path):
    vary = ["--vary", "fleet.size=1..3", "--vary", "battery.threshold=2,3.5", "--vary", "policies.charging=threshold"]
    result = call("what-if", MULTIBOTS, *vary, *GOODS, "--replications", "2", "--out", tmp_path, "--quiet")
    assert result.stderr == ""
    table = pd.read_parquet(tmp_path / "results.parquet")
    assert len(table) == 12
    assert table["battery.threshold"].unique().tolist() == [2.0, 3.5]


def test_what_if_can_replicate_until_the_mean_is_known(tmp_path):
    until = ["--until", "T", "--half-width", "20 %", "--cap", "30", "--replications", "3"]
    call("what-if", MULTIBOTS, *GOODS, *until, "--out", tmp_path)
    assert 3 <= len(pd.read_parquet(tmp_path / "results.parquet")) <= 30


def test_compare_shows_differences_and_what_they_promise(tmp_path):
    call("what-if", MULTIBOTS, "--vary", "fleet.size=1..3", *GOODS, "--replications", "5", "--out", tmp_path)
    result = call("compare", tmp_path, "--indicator", "T", "--baseline", "fleet.size=2", "--method", "holm")
    assert "T: difference to fleet.size=2" in result.stdout
    assert "Holm" in result.stdout
    assert result.stdout.count("differs") >= 1


def test_a_deterministic_study_says_so(tmp_path):
    call("what-if", MULTIBOTS, "--vary", "fleet.size=1,2", "--out", tmp_path)
    result = call("compare", tmp_path, "--indicator", "T")
    assert "Chance plays no part" in result.stdout
    assert "exact" in result.stdout
    assert "±" not in result.stdout


def test_best_and_size_answer_in_a_sentence():
    result = call(
        "best", MULTIBOTS, "--vary", "fleet.size=1,4", *GOODS, "--indicator", "T", "--delta", "100", "--quiet"
    )
    assert "fleet.size=4: smallest T; best with 95 %" in result.stdout
    lifelong = ["--set", "tasks.goods={saturated: 12}", "--set", "run.length=6000"]
    target = ["--target", "throughput_per_hour >= 250"]
    result = call("size", MULTIBOTS, "--range", "1..6", *lifelong, *target, "--quiet")
    assert "fleet.size: 3 is the smallest shown to meet throughput_per_hour >= 250" in result.stdout


def test_screen_ranks_factors(tmp_path):
    vary = ["--vary", "fleet.size=1,4", "--vary", "tasks.load_time=10,11"]
    call("what-if", MULTIBOTS, *vary, *GOODS, "--out", tmp_path)
    result = call("screen", tmp_path, "--indicator", "T")
    assert result.stdout.index("fleet.size") < result.stdout.index("tasks.load_time")


def test_warm_up_writes_a_plot(tmp_path):
    lifelong = ["--set", "tasks.goods={saturated: 12}", "--set", "run.length=5000"]
    result = call("warm-up", MULTIBOTS, *lifelong, "--replications", "2", "--out", tmp_path)
    assert "observations" in result.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"warm-up.png", "warm-up.svg"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--vary", "fleet.size"], "--vary fleet.size: nothing to vary, expected KEY=VALUES"),
        (["--vary", "fleet.size=1", "--vary", "fleet.size=2"], "fleet.size given twice"),
        (["--vary", "fleet.size=0"], "factors.fleet.size.0: too small"),
        (["--workers", "some"], "workers 'some': expected a number"),
        (["--replications", "none"], "replications: not understood"),
        (["--design", "spiral"], "design: not understood"),
    ],
)
def test_mistakes_of_the_command_line_are_told(arguments, message):
    with pytest.raises(WarehouseError, match=re.escape(message)):
        call("what-if", MULTIBOTS, *arguments)


def test_the_paper_again(tmp_path):
    """30 cells beside the paper's: C equal in all, T within 1 % in 29 at least, files written."""
    result = call("paper", "--study", ROOT / "studies" / "paper.yaml", "--out", tmp_path)
    assert "C: equal in 30 of 30 cells" in result.stdout
    table = pd.read_parquet(tmp_path / "paper.parquet")
    assert (table["T_difference"].abs() <= 0.01).sum() >= 29
    assert table["S_difference"].abs().max() <= 2
    names = {path.name for path in tmp_path.iterdir()}
    figures = {f"figure_{number}.{ending}" for number in (6, 7, 8) for ending in ("png", "svg")}
    assert names == figures | {"paper.csv", "paper.parquet"}
    pd.testing.assert_frame_equal(pd.read_csv(tmp_path / "paper.csv"), table, rtol=1e-4, check_dtype=False)


def test_a_paper_study_that_is_not_there_is_told():
    with pytest.raises(WarehouseError, match=r"no such study; expected studies/paper\.yaml"):
        call("paper", "--study", "nowhere.yaml")
