"""Studies run from Python: the table, the same in whatever way it was run, and what statistics say of it."""

from pathlib import Path

import pandas as pd
import pytest

import desim_warehouse as dw
from desim_warehouse.policies.catalogue import find
from desim_warehouse.study.execution import pool
from desim_warehouse.study.factors import holder_of
from desim_warehouse.study.plan import run_seed
from desim_warehouse.study.statistics.comparison import paired
from desim_warehouse.study.statistics.intervals import estimate
from tests.policies.ours import every
from tests.world.test_flows import RING

from .conftest import MULTIBOTS

RANDOM = {"tasks.goods": {"random": 4}}


def study(factors=None, **more):
    more.setdefault("changes", RANDOM)
    return dw.Study(MULTIBOTS, factors or {"fleet.size": [1, 2]}, **more)


def same(one, other):
    """Bit for bit, run times apart."""
    return one.drop(columns="run_time").equals(other.drop(columns="run_time"))


def test_the_table_has_a_row_for_each_run():
    table = study(replications=3, indicators=["T", "S"]).run().table
    assert list(table.columns) == ["fleet.size", "replication", "seed", "T", "S", "deterministic", "run_time", "error"]
    assert table["fleet.size"].tolist() == [1, 1, 1, 2, 2, 2]
    assert table["replication"].tolist() == [0, 1, 2] * 2
    assert table["error"].isna().all()
    assert table["run_time"].gt(0).all()


def test_a_row_can_be_simulated_again_by_itself():
    made = study(replications=2).run()
    row = made.table.iloc[3]
    run = dw.simulate(dw.load(MULTIBOTS, {**RANDOM, "fleet.size": 2}), seed=int(row["seed"]))
    assert {name: row[name] for name in run.kpis} == pytest.approx(run.kpis, abs=0, rel=0, nan_ok=True)


def test_replications_use_common_random_numbers():
    table = study(replications=3, seed=7).run().table
    assert table["seed"].tolist() == [run_seed(7, r) for r in range(3)] * 2


@pytest.mark.filterwarnings("ignore:.* runs? failed:RuntimeWarning")
@pytest.mark.parametrize(("workers", "replications"), [(2, 3), pytest.param(3, 7, marks=pytest.mark.long)])
def test_several_processes_give_the_same_table_bit_for_bit(parking, workers, replications):
    """With the errors of runs that fail."""
    designs = {"one": {"fleet.size": 1}, "six": {"fleet.size": 6}, "bad": {"policies.parking": parking("raise")}}
    alone, shared = (
        study({"case": {"cases": designs}}, replications=replications).run(workers=n) for n in (1, workers)
    )
    assert same(alone.table, shared.table)
    assert shared.table.groupby("case")["error"].count().to_dict() == {"bad": replications, "one": 0, "six": 0}


def test_factors_of_any_kind_are_columns(tmp_path):
    factors = {
        "policies.charging": ["threshold", {"name": "reach-aware", "margin": 0.2}],
        "tasks.unload_at": [["M"], ["N"]],
        "load": {"cases": {"light": {"tasks.goods": [1, 2]}, "heavy": {"tasks.goods": [1, 2, 3, 4]}}},
    }
    study(factors).run(out=tmp_path)
    table = pd.read_parquet(tmp_path / "results.parquet")
    assert table["policies.charging"].unique().tolist() == ["threshold", "reach-aware(margin=0.2)"]
    assert table["tasks.unload_at"].unique().tolist() == ['["M"]', '["N"]']
    assert table.groupby("load")["tasks"].first().to_dict() == {"heavy": 4, "light": 2}


def test_a_factor_has_the_name_of_no_other_column_of_a_table():
    made = study(replications=2).run()
    columns = {*made.table, *made.summary(["T"]), *made.compare("T").table}
    assert {name for name in columns if not holder_of(name)} == {"fleet.size"}
    assert holder_of("fleet.size", made.results.factors) == "a factor"


def test_finished_runs_are_used_again_when_values_and_replications_are_added(tmp_path):
    study({"fleet.size": [1, 2]}, replications=2).run(out=tmp_path)
    before = (tmp_path / "runs.jsonl").read_text().splitlines()
    more = study({"fleet.size": [3, 2, 1], "battery.threshold": [3.5]}, replications=3).run(out=tmp_path)
    after = (tmp_path / "runs.jsonl").read_text().splitlines()
    assert after[: len(before)] == before
    assert len(after) == 9  # four were there
    assert same(more.table, study({"fleet.size": [3, 2, 1], "battery.threshold": [3.5]}, replications=3).run().table)


def test_the_interval_of_an_indicator_below_zero_is_around_its_mean():
    """Batteries that fall, and a backlog that shrinks, from a heap of tasks at the start on."""
    flows = {
        "heap": {"from": "storage", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 30}]}},
        "more": {"from": "storage", "to": "pack", "arrivals": {"poisson": 10}},
    }
    battery = {"capacity": 100, "threshold": 5, "consumption": 0.002, "charge_rate": 0.0001}
    model = dw.load(RING, {"tasks.flows": flows, "battery": battery, "run": {"length": 3600, "warm_up": 600}})
    runs = dw.Study(model, {"fleet.size": [2]}, replications=4)
    results = runs.run(workers=1).results
    for name in ("energy_drift_per_hour", "backlog_growth_per_hour"):
        drift = results.estimate(results.runs(results.baseline), name)
        assert drift.mean < 0
        assert drift.interval[0] < drift.mean < drift.interval[1]


def test_a_finished_study_runs_nothing(tmp_path, monkeypatch):
    first = study(replications=2).run(out=tmp_path)

    def never(*args, **kwargs):
        raise AssertionError("a run was simulated")

    monkeypatch.setattr("desim_warehouse.run.RunData.simulated", never)
    again = study(replications=2).run(out=tmp_path, workers=2, cluster="tcp://127.0.0.1:1")
    assert again.table.equals(first.table)


def test_runs_with_other_seeds_models_or_policy_code_are_not_mixed_up(tmp_path, policies, parking):
    def lines():
        return len((tmp_path / "out" / "runs.jsonl").read_text().splitlines())

    def run(policy, **more):
        study({"policies.parking": [policy]}, **more).run(out=tmp_path / "out")

    run("home")
    run("home", seed=1)
    assert lines() == 2
    run("home", changes={**RANDOM, "battery.threshold": 3})
    assert lines() == 3
    run(parking("nothing"))
    assert lines() == 4
    Path(policies).write_text(Path(policies).read_text() + "\n# changed\n")
    run(parking("nothing"))
    assert lines() == 5
    run(parking("nothing"))
    assert lines() == 5


RULE = {"indicator": "T", "half_width": "10 %", "minimum": 3, "cap": 40}


def test_replications_go_on_until_the_mean_is_known():
    one = study({"fleet.size": [1, 3]}, replications=RULE).run()
    for size, rows in one.table.groupby("fleet.size"):
        times = estimate(rows["T"])
        assert times.relative_half_width <= 0.1, size
        assert 3 <= len(rows) < 40


@pytest.mark.long
def test_they_go_on_alike_in_several_processes():
    one, two = (study({"fleet.size": [1, 3]}, replications=RULE).run(workers=workers) for workers in (1, 2))
    assert same(one.table, two.table)


def test_a_cap_ends_replications():
    rule = {"indicator": "T", "half_width": 0.0001, "minimum": 2, "cap": 5}
    assert len(study({"fleet.size": [1]}, replications=rule).run().table) == 5


@pytest.mark.parametrize(
    "workers", [1, pytest.param(2, marks=pytest.mark.long)]
)  # every day in several processes above
def test_a_failing_run_is_a_row_with_its_error(parking, workers):
    factors = {"policies.parking": {"named": {"good": "home", "bad": parking("raise")}}}
    with pytest.warns(RuntimeWarning, match="failed"):
        made = study(factors, replications=2).run(workers=workers)
    bad = made.table[made.table["policies.parking"] == "bad"]
    assert bad["error"].str.contains("no bay for me").all()
    assert bad["T"].isna().all()
    good = made.summary(["T"]).set_index("policies.parking")
    assert good["n"].to_dict() == {"good": 2, "bad": 0}
    assert good["failed"].to_dict() == {"good": 0, "bad": 2}


def test_the_summary_is_student_t_by_design():
    made = study(replications=5).run()
    row = made.summary(["T"]).iloc[1]
    times = estimate(made.table.query("`fleet.size` == 2")["T"])
    assert (row["mean"], row["half_width"], row["median"]) == (times.mean, times.half_width, times.median)
    assert not row["deterministic"]


def test_a_deterministic_model_says_so_instead_of_a_zero_interval():
    made = study(changes={"tasks.goods": [11, 8]}).run()
    summary = made.summary(["T"])
    assert summary["deterministic"].all()
    assert summary["half_width"].isna().all()
    (difference,) = made.compare("T").differences
    assert difference.differs
    assert difference.estimate.half_width is None


@pytest.mark.parametrize("kind", ["allocation", "routing", "charging", "parking"])
def test_what_needs_one_run_only_by_its_model_was_deterministic_by_its_record(kind):
    """What `best` and `size` know before a run is what its record says after: for all policies of ours."""
    for policy in every(kind):
        model = dw.load(MULTIBOTS, {"tasks.goods": [11, 8, 39], f"policies.{kind}": policy})
        assert model.is_deterministic != bool(getattr(find(kind, policy["name"]), "random", False))
        assert dw.simulate(model, 3).deterministic or not model.is_deterministic, policy


def test_policies_of_the_users_own_are_not_called_deterministic(parking):
    assert not dw.simulate(dw.load(MULTIBOTS, {"tasks.goods": [11], "policies.parking": parking("fine")})).deterministic


def test_designs_with_and_without_chance_are_judged_each_by_its_own_runs():
    made = study(
        {"tasks.goods": {"named": {"list": [11, 8], "drawn": {"random": 2}}}}, changes={}, replications=3
    ).run()
    assert made.summary(["T"])["deterministic"].tolist() == [True, False]
    assert not made.deterministic


def test_costs_that_depend_on_no_run_differ_exactly():
    prices = {"hours": 5000, "robot": 6000}
    made = study({"fleet.size": [1, 3]}, changes={"prices": prices, "tasks.goods": {"random": 2}}, replications=3).run()
    (difference,) = made.compare("annual_cost").differences
    assert difference.estimate.deterministic
    assert difference.estimate.mean == 2 * 6000


def test_comparisons_are_paired_with_the_baseline():
    made = study({"fleet.size": [1, 2, 3]}, replications=6, baseline={"fleet.size": 2}).run()
    comparison = made.compare("T")
    values = {size: rows["T"].to_numpy() for size, rows in made.table.groupby("fleet.size")}
    assert set(comparison.against.values()) == {"fleet.size=2"}
    by_design = {difference.design: difference.estimate for difference in comparison.differences}
    expected = paired(values[3], values[2], confidence=0.975)  # Bonferroni: two differences
    assert by_design["fleet.size=3"] == expected
    with pytest.raises(dw.StudyError, match=r"no design with fleet\.size=9"):
        made.compare("T", {"fleet.size": 9})
    with pytest.raises(dw.StudyError, match="'fleet' is no factor"):
        made.compare("T", {"fleet": 9})


def test_main_effects_begin_with_the_largest():
    made = study({"fleet.size": [1, 3], "tasks.load_time": [10, 11]}, replications=2).run()
    assert [effect.factor for effect in made.main_effects("T").factors] == ["fleet.size", "tasks.load_time"]


def test_an_open_study_is_the_one_that_was_run(tmp_path):
    rule = {"indicator": "T", "half_width": "20 %", "minimum": 3, "cap": 40}
    made = study(replications=rule, indicators=["T", "C"], baseline={"fleet.size": 2}).run(out=tmp_path)
    opened = dw.Study.open(tmp_path)
    assert opened.table.equals(made.table)
    assert opened.compare("T") == made.compare("T")
    assert opened.plan.points() == made.plan.points()
    with pytest.raises(dw.StudyError, match="no study there"):
        dw.Study.open(tmp_path / "elsewhere")


def test_a_study_that_was_not_run_says_so():
    with pytest.raises(dw.StudyError, match="call run"):
        _ = study().table


def test_an_unknown_indicator_is_told_with_the_nearest():
    made = study().run()
    with pytest.raises(dw.StudyError, match="did you mean 'throughput_per_hour'"):
        made.summary(["throughput"])


@pytest.mark.parametrize("workers", [0, -1, "many", 1.5, 257, 100_000, "9" * 10_000])
def test_workers_are_a_number_from_1_to_256_or_auto(workers):
    with pytest.raises(dw.StudyError, match=r"workers .*: expected a number from 1 to 256, or auto$"):
        study().run(workers=workers)


def test_no_more_processes_are_started_than_there_are_runs(monkeypatch):
    started = []

    class Counted(pool.Worker):
        def __init__(self):
            started.append(self)
            super().__init__()

    monkeypatch.setattr(pool, "Worker", Counted)
    assert len(study({"fleet.size": [1]}).run(workers=256).table) == 1
    assert len(started) == 1
