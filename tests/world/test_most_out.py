"""A cap on robots under way (`traffic.most_out`): departures wait in bays, and work ends."""

import json

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from tests.auditor import audit
from tests.world.crowded import crowded

SHORT = {"run.length": 500, "run.warm_up": 150}


def most_out(run):
    """The most robots that were at once between being given a task in a bay, or setting out from one, and parking."""
    out, most = set(), 0
    for _, kind, robot, *_ in run.record.rows:
        if kind == "parked":
            out.discard(robot)
        elif kind in {"assigned", "empty", "returning"}:
            out.add(robot)
        most = max(most, len(out))
    return most


@pytest.mark.parametrize("most", [1, 2, 3])
def test_no_more_robots_are_under_way_and_all_work_is_done(most):
    run = dw.simulate(
        dw.load(crowded(12, run={}), {"tasks.goods": {"random": 60}, "traffic.most_out": most, "log": "all"})
    )
    assert run.kpis["tasks"] == 60
    assert most_out(run) == most
    assert audit(run) == []


@pytest.mark.slow
def test_without_a_cap_that_is_reached_nothing_changes():
    logs = [
        dw.simulate(dw.load(crowded(12), SHORT | {"traffic.most_out": most})).record.rows for most in (None, 12, 40)
    ]
    assert logs[0] == logs[1] == logs[2]


def test_robots_that_are_under_way_go_on_with_the_next_task_and_the_others_rest():
    run = dw.simulate(dw.load(crowded(12), {"traffic.most_out": 5}))
    assert [robot["delivered"] > 0 for robot in run.record.robots] == [True] * 5 + [False] * 7
    assert [row[1] for row in run.record.rows if row[1] == "parked"] == []


@pytest.mark.slow
def test_a_floor_with_too_many_robots_does_more_with_fewer_of_them_under_way():
    all_out = dw.simulate(dw.load(crowded(60), SHORT))
    capped = dw.simulate(dw.load(crowded(60), SHORT | {"traffic.most_out": 30}))
    thirty = dw.simulate(dw.load(crowded(30), SHORT))
    assert capped.kpis["throughput_per_hour"] > 1.2 * all_out.kpis["throughput_per_hour"]
    assert capped.kpis["throughput_per_hour"] >= 0.97 * thirty.kpis["throughput_per_hour"]


@pytest.mark.parametrize("policy", ["nearest", "hungarian", "auction", "regret", "cost-aware"])
def test_the_cap_holds_under_every_allocation_policy(policy):
    changes = {"tasks.goods": {"random": 40}, "traffic.most_out": 3, "policies.allocation": policy}
    run = dw.simulate(dw.load(crowded(8, run={}), changes))
    assert run.kpis["tasks"] == 40
    assert most_out(run) == 3


FEW_CHARGERS = {
    "layout.bays": {
        "chargers": {"at": ["0.0"], "places": 2},
        "parking": {"at": ["5.0", "9.1"], "places": 6, "chargers": 0},
    },
    "fleet.start": ["5.0", "9.1"],
    "battery": {
        "capacity": 400,
        "threshold": 150,
        "consumption": {"standing": 0.4, "empty": 1, "loaded": 1, "handling": 1},
        "charge_rate": 20,
    },
    "fleet.start_energy": {"uniform": [0.5, 1.0]},
    "tasks.goods": {"random": 60},
}


@pytest.mark.parametrize("charging", ["threshold", "reach-aware", "opportunity"])
@pytest.mark.parametrize("most", [1, 3])
def test_robots_whose_batteries_want_a_charger_do_not_wait_for_the_cap(charging, most):
    """Six robots park where there is no charger: had they to wait for the one robot at work, they would run flat."""
    made = crowded(8, run={}, log="all")
    changes = {**FEW_CHARGERS, "traffic.most_out": most, "policies.charging": charging}
    run = dw.simulate(dw.load(made, changes), 1)
    assert run.kpis["tasks"] == 60
    assert min(run.record.energy) > 0
    assert audit(run) == []


@pytest.mark.slow
def test_the_hand_calculation_knows_the_cap(tmp_path):
    path = tmp_path / "floor.json"
    path.write_text(json.dumps(crowded(60)))
    output = CliRunner().invoke(desim, ["check", str(path), "--set", "traffic.most_out=30", "--details"]).stdout
    assert "robots: 60 robots, at most 30 of them under way, can do 3,878 to 4,336 tasks an hour" in output
    assert "At most 30 of them are under way at a time (traffic.most_out)." in output


@pytest.mark.long
def test_size_finds_the_best_cap_and_the_smallest_that_meets_a_target(tmp_path):
    path = tmp_path / "floor.json"
    path.write_text(json.dumps(crowded(60, run={"length": 500, "warm_up": 100})))
    size = ["size", str(path), "--key", "traffic.most_out", "--quiet", "--first", "3"]
    best = CliRunner().invoke(desim, [*size, "--range", "10,30,60", "--cap", "6"], catch_exceptions=False).stdout
    assert "Robots out at once 30 is the smallest that does as much, within 1 % of the most" in best
    # Halving would look at 30 and 60 first, and never at what lies below a value that fails.
    target = ["--range", "10,20,60", "--target", "throughput_per_hour >= 3700"]
    smallest = CliRunner().invoke(desim, [*size, *target], catch_exceptions=False).stdout
    assert "Robots out at once 20 is the smallest value shown to be enough: " in smallest


def test_a_search_is_for_a_target(tmp_path):
    path = tmp_path / "floor.json"
    path.write_text(json.dumps(crowded(10)))
    size = ["size", str(path), "--key", "traffic.most_out", "--range", "1,2", "--search", "scan"]
    result = CliRunner().invoke(desim, size)
    assert result.exit_code == 2
    assert "--search is for a --target" in result.output


@pytest.mark.parametrize("most", [0, -1, 2.5, 20_000])
def test_a_cap_that_is_no_positive_number_is_refused(most):
    with pytest.raises(dw.ModelError, match=r"traffic\.most_out"):
        dw.load(crowded(10), {"traffic.most_out": most})
