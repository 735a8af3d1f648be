"""The commands about studies, by their runner."""

import re

import pandas as pd
import pytest
from click.testing import CliRunner

from desim_warehouse.cli import desim
from desim_warehouse.errors import WarehouseError
from desim_warehouse.questions.study import Results
from desim_warehouse.study.plan import run_seed

from .conftest import MULTIBOTS, ROOT

pytestmark = pytest.mark.usefixtures("brief_probes")

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
    assert re.search(r"option +task time +waits for another robot +", first.stdout)
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


def test_what_if_says_which_designs_meet_a_target():
    lifelong = ["--set", "tasks.goods={saturated: 5}", "--set", "run.length=2000", "--replications", "3", "--quiet"]
    easy, hard = (
        call("what-if", MULTIBOTS, *lifelong, "--target", f"tasks >= {least}", "--indicator", "T") for least in (1, 999)
    )
    assert "delivered at" in easy.stdout
    assert re.search(r" met +3\b", easy.stdout)
    assert re.search(r" not met +3\b", hard.stdout)
    assert max(map(len, easy.stdout.splitlines())) <= 100


def test_the_report_of_best_is_about_what_it_compared(tmp_path):
    vary = ["--vary", "fleet.size=1,2", "--indicator", "cost", "--delta", "5000", "--quiet"]
    call("best", MULTIBOTS, *vary, "--set", "tasks.goods={random: 5}", "--out", tmp_path)
    assert Results.load(tmp_path).main == ("cost",)


def test_the_half_width_is_a_share_or_a_percentage(tmp_path):
    until = ["--until", "T", "--cap", "4", "--indicator", "T", "--quiet"]
    share = call("what-if", MULTIBOTS, *GOODS, *until, "--half-width", "0.9", "--out", tmp_path)
    percent = call("what-if", MULTIBOTS, *GOODS, *until, "--half-width", "90 %", "--out", tmp_path)
    assert share.exit_code == 0
    assert share.stdout == percent.stdout


def test_a_deterministic_study_says_so(tmp_path):
    call("what-if", MULTIBOTS, "--vary", "fleet.size=1,2", "--out", tmp_path)
    result = call("compare", tmp_path, "--indicator", "T")
    assert "Nothing in this model is random: one run of each option is exact." in result.stdout
    assert "(" not in result.stdout


@pytest.mark.parametrize(
    ("command", "instead"), [("screen", "desim report FOLDER"), ("long-run", "desim what-if MODEL")]
)
def test_a_command_that_went_says_what_to_type_instead(command, instead):
    result = call(command, "out/study")
    assert result.exit_code == 2
    assert result.stderr.splitlines()[-1].startswith(f"Error: {command} went in 0.4; instead: {instead}")


def test_one_random_run_of_a_design_promises_no_intervals(tmp_path):
    vary = ["--vary", "fleet.size=1,2", *GOODS, "--indicator", "T"]
    result = call("what-if", MULTIBOTS, *vary, "--out", tmp_path)
    assert "more runs give intervals" in result.stdout
    assert "hold together" not in call("compare", tmp_path).stdout
    result = call("what-if", MULTIBOTS, *vary, "--replications", "3", "--out", tmp_path)
    assert "Each interval holds with 95 % confidence." in result.stdout
    assert "more replications" not in result.stdout
    assert "1 difference; its interval holds with 95 % confidence" in call("compare", tmp_path).stdout


def test_only_single_runs_are_said_to_say_little(tmp_path):
    """Several runs that happen to agree have an interval: that of a share of runs that may differ."""
    vary = ["--vary", "fleet.size=1,2", *GOODS, "--indicator", "rotations", "--out", tmp_path]
    assert "One run of a random model" in call("what-if", MULTIBOTS, *vary).stdout
    result = call("what-if", MULTIBOTS, *vary, "--replications", "3")
    assert "0 (0 to 1.2) " in result.stdout
    assert "One run of a random model" not in result.stdout


def test_compare_shows_nothing_where_the_baseline_is_wrong(tmp_path):
    call("what-if", MULTIBOTS, "--vary", "fleet.size=1,2", "--out", tmp_path)
    with pytest.raises(WarehouseError, match="--baseline fleet: no assignment, expected KEY=VALUE"):
        call("compare", tmp_path, "--baseline", "fleet")
    result = CliRunner().invoke(desim, ["compare", str(tmp_path), "--baseline", "fleet.size=9"])
    assert str(result.exception).endswith(
        "no design with fleet.size=9, expected values of the factors such as fleet.size=1"
    )
    assert result.stdout == ""


def test_a_place_that_cannot_be_written_is_told_in_words(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    lifelong = ["--set", "tasks.goods={saturated: 12}", "--set", "run.length=500", "--replications", "1"]
    for command in (["warm-up", *lifelong], ["run"], ["what-if"]):
        with pytest.raises(WarehouseError) as refused:
            call(*command, MULTIBOTS, "--out", blocked / "out")
        assert str(refused.value).startswith(f"{blocked / 'out'}: ")
        assert str(refused.value).endswith("(a file is in the place of a folder)")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--vary", "fleet.size"], "--vary fleet.size: nothing to vary, expected KEY=VALUES"),
        (["--vary", "fleet.size=1", "--vary", "fleet.size=2"], "fleet.size given twice"),
        (["--vary", "fleet.size=0"], "--vary fleet.size: should be greater than or equal to 1 (got 0)"),
        (["--vary", "fleet.sise=1,2"], "--vary fleet.sise: no key of a model, did you mean 'fleet.size'?"),
        (["--vary", "fleet.size={rang: [1, 2]}"], "--vary fleet.size: rang: unknown key, did you mean 'range'?"),
        (["--vary", "policies.charging={name: threshold, lvl: 1}"], "--vary policies.charging.lvl: unknown"),
        (["--vary", "fleet.size=8-12"], "--vary fleet.size: should be a whole number (got '8-12'); write 8..12"),
        (
            ["--vary", "fleet=2,4"],
            "should be a section with size and robot (got 2); vary a key in it, such as fleet.size",
        ),
        (["--replications", "30000000"], "--replications: too many (got 30000000), expected at most 100,000"),
        (["--set", "fleet.sise=3"], "--set fleet.sise: unknown key, did you mean 'fleet.size'?"),
        (["--indicator", "throughput"], "--indicator: unknown indicator (got 'throughput'), did you mean"),
        (["--until", "throughput"], "--until: unknown indicator (got 'throughput'), did you mean"),
        (["--until", "T", "--half-width", "far"], "--half-width: should be a number (got 'far')"),
        (["--workers", "some"], "workers 'some': expected a number"),
        (["--workers", "100000"], "workers '100000': expected a number from 1 to 256, or auto"),
        (["--replications", "none"], "--replications: should be a number of at least 1, or {indicator"),
        (["--design", "spiral"], "--design: should be 'grid' or 'paired' (got 'spiral')"),
        (["--design", "{sobol: 4}", "--vary", "fleet.size=1,2"], "--design: no sampled designs since 0.4"),
    ],
)
def test_mistakes_of_the_command_line_are_told_at_their_option(arguments, message):
    with pytest.raises(WarehouseError, match=re.escape(message)) as refused:
        call("what-if", MULTIBOTS, *arguments)
    assert str(refused.value).startswith(("--", "workers"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["what-if", MULTIBOTS, "--cap", "20"], "name an indicator with --until"),
        (["what-if", MULTIBOTS, "--confidence", "95"], "95.0 is not in the range 0<x<1"),
        (
            ["best", MULTIBOTS, "--indicator", "T", "--delta", "5", "--first", "30000000"],
            "not in the range 2<=x<=100000",
        ),
        (["warm-up", MULTIBOTS, "--replications", "30000000"], "30000000 is not in the range 1<=x<=100000"),
        (["size", MULTIBOTS, "--target", "T <= 9", "--range", "2,1"], "--range 2,1: not ascending"),
        (["warm-up", MULTIBOTS, "--observations", "0"], "0 is not in the range x>=1"),
    ],
)
def test_options_that_make_no_sense_are_refused(arguments, message):
    result = call(*arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_size_names_its_range_and_its_key():
    with pytest.raises(
        WarehouseError, match=re.escape("--range 0..2 --key fleet.size: should be greater than or equal to 1 (got 0)")
    ):
        call("size", MULTIBOTS, "--range", "0..2", "--target", "T <= 9")
    with pytest.raises(WarehouseError, match=re.escape("--range {named: 3} --key fleet.size: ")):
        call("size", MULTIBOTS, "--range", "{named: 3}", "--target", "T <= 9")
    with pytest.raises(WarehouseError, match=re.escape("--range 1,{:")):
        call("size", MULTIBOTS, "--range", "1,{", "--target", "T <= 9")
    with pytest.raises(WarehouseError, match=re.escape("--range  --key fleet.size: no values (got [])")):
        call("size", MULTIBOTS, "--range", "", "--target", "T <= 9")


def test_size_without_an_answer_says_so_by_its_exit_status():
    result = call("size", MULTIBOTS, "--range", "1..2", "--target", "T <= 10", "--quiet")
    assert result.exit_code == 3
    assert result.stdout.startswith("No fleet is enough. 2 robots: task time ")
    assert result.stderr == "no answer within --range 1..2: widen it, or ask for less with --target\n"


@pytest.mark.long
def test_size_does_not_name_a_fleet_whose_batteries_still_fall(tmp_path, monkeypatch):
    """Two hours from full batteries, which last 5.6 h: hardly a robot charges while it is counted."""
    monkeypatch.chdir(tmp_path)
    call("new", "w.yaml", "--size", "24x20", "--orders", "60/h", "--robots", "4", "--chargers", "4")
    short = ("--set", "run.length=2 h", "--set", "run.warm_up=20 min", "--cap", "10")
    options = ("--range", "4..5", "--target", "on_time >= 50 %", *short, "--quiet")
    full = call("size", "w.yaml", *options, "--set", "fleet.start_energy=1")
    assert full.exit_code == 3
    assert "batteries fall by" in full.stdout
    assert "cannot last" in full.stdout
    settled = call("size", "w.yaml", *options)
    assert settled.exit_code == 0
    assert "4 robots are the smallest fleet shown to be enough: " in settled.stdout


def test_a_model_file_is_no_study_and_a_study_file_no_model():
    study = ROOT / "studies" / "charging.yaml"
    for command in ("run", "check", "what-if", "warm-up"):
        with pytest.raises(WarehouseError) as refused:
            call(command, study)
        assert str(refused.value) == f"{study}: a study file, expected a model file; desim study {study} runs it"
    for command in (["study"], ["best", "--indicator", "T", "--delta", "5"]):
        with pytest.raises(WarehouseError) as refused:
            call(*command, MULTIBOTS)
        assert str(refused.value) == (
            f"{MULTIBOTS}: a model file, expected a study file; desim run {MULTIBOTS} simulates it, "
            "desim what-if and desim best vary it with --vary"
        )
    with pytest.raises(WarehouseError) as refused:
        call("compare", MULTIBOTS)
    assert str(refused.value) == (
        f"{MULTIBOTS}: a file, expected a study folder such as desim study STUDY --out DIR "
        "or desim what-if MODEL --out DIR makes"
    )


def test_a_folder_is_that_of_a_run_or_that_of_a_study(tmp_path):
    run, study = tmp_path / "run", tmp_path / "study"
    call("run", MULTIBOTS, "--out", run)
    call("what-if", MULTIBOTS, "--out", study)
    for command in (["what-if", MULTIBOTS], ["study", ROOT / "studies" / "charging.yaml"]):
        with pytest.raises(WarehouseError, match="holds a run; a study needs a folder of its own"):
            call(*command, "--out", run)
    with pytest.raises(WarehouseError, match="holds a study; a run needs a folder of its own"):
        call("run", MULTIBOTS, "--out", study)
    with pytest.raises(WarehouseError, match="a run, and no study there"):
        call("compare", run)
    assert not (run / "study.json").exists()
    assert not (study / "run.json").exists()


def test_a_change_to_a_study_is_named_by_its_option():
    with pytest.raises(WarehouseError) as refused:
        call("study", ROOT / "studies" / "charging.yaml", "--set", "fleet.sise=2", "--set", "tasks.load_time=-1")
    assert str(refused.value).splitlines() == [
        "--set fleet.sise: unknown key, did you mean 'fleet.size'?",
        "--set tasks.load_time: should be greater than or equal to 0 (got -1)",
    ]


def test_a_study_folder_keeps_its_model_and_what_was_planned(tmp_path):
    plan = ["--vary", "fleet.size=1,4", "--confidence", "0.8", "--seed", "7", *GOODS]
    call("what-if", MULTIBOTS, *plan, "--out", tmp_path, "--quiet")
    result = call("best", tmp_path, "--indicator", "T", "--delta", "100", "--quiet")
    assert result.stdout.startswith("Task time is smallest, ")
    assert "With 80 % confidence this is the best option, if " in result.stdout
    assert set(pd.read_parquet(tmp_path / "results.parquet")["seed"]) >= {run_seed(7, 0)}
    for command in (["study"], ["best", "--indicator", "T", "--delta", "5"]):
        with pytest.raises(WarehouseError, match="whose model is fixed; --set is for study files"):
            call(*command, tmp_path, *GOODS)


def test_the_paper_is_reproduced(tmp_path):
    """30 cells beside the paper's: C equal in all, T within 1 % in 29 at least, files written."""
    result = call("paper", "--study", ROOT / "studies" / "paper.yaml", "--out", tmp_path)
    assert "C: equal in 30 of 30 cells" in result.stdout
    table = pd.read_parquet(tmp_path / "paper.parquet")
    assert (table["T_difference"].abs() <= 0.01).sum() >= 29
    assert table["S_difference"].abs().max() <= 2
    names = {path.name for path in tmp_path.iterdir()}
    figures = {f"figure_{number}.{ending}" for number in (6, 7, 8) for ending in ("png", "svg")}
    assert names == figures | {"answer.json", "paper.csv", "paper.parquet"}
    pd.testing.assert_frame_equal(pd.read_csv(tmp_path / "paper.csv"), table, rtol=1e-4, check_dtype=False)


def test_a_paper_study_that_is_not_there_is_told():
    with pytest.raises(WarehouseError, match=r"no such study; expected studies/paper\.yaml"):
        call("paper", "--study", "nowhere.yaml")


def test_a_study_of_which_no_run_was_finished_fails():
    flat = ["--set", "battery.threshold=0", "--set", "battery.reserve=0", "--accept", "BATTERY_TOO_SMALL"]
    some = call("what-if", MULTIBOTS, "--vary", "battery.capacity=1,10", *flat)
    assert (some.exit_code, "1 run failed: BatteryError" in some.stderr) == (0, True)
    with pytest.raises(WarehouseError, match="no run was finished"):
        call("what-if", MULTIBOTS, "--vary", "battery.capacity=1,1.2", *flat)


def test_quantiles_of_a_study_folder(tmp_path):
    vary = ["--vary", "fleet.size=5,6", "--replications", "20", "--indicator", "T", "--quiet", "--out", tmp_path]
    call("what-if", MULTIBOTS, *vary, *GOODS)
    median = call("study", tmp_path, "--quantile", "50%", "--quiet").stdout
    assert "50 % quantiles over runs, 95 % intervals" in median
    assert median == call("study", tmp_path, "--quantile", "0.5", "--quiet").stdout
    assert "it takes 72 runs for both ends" in call("study", tmp_path, "--quantile", "95 %", "--quiet").stdout
    for wrong in ("95", "0", "100%", "most"):
        assert "expected a share between 0 and 1" in call("study", tmp_path, "--quantile", wrong).stderr
