"""Pickers beside robots, chargers and packers: counts of a plan, worked out by hand."""

import json

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import StudyError
from desim_warehouse.model.facts.costs import year_of
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.study.fleet import Designs
from desim_warehouse.study.fleet.people import people_of
from tests.docs import pages
from tests.world.test_pickers import RING

pytestmark = pytest.mark.usefixtures("brief_probes")
SLOW = dw.load(
    RING,
    {
        "tasks.goods": {"saturated": 8},
        "tasks.load_time": 100,
        "layout.aisles": "wide",
        "run.length": 3000,
        "run.warm_up": 600,
    },
)
"""A line takes a picker 100 s, so one does at most 36 an hour; and a robot 60 + 100 + 4 s, so two do at most 43.9."""
GOAL = "throughput_per_hour >= 45"
PRICES = {"hours": 2000, "robot": 6000, "station_hour": 1, "picker_hour": 20}
HOW = {"strategies": {}, "search": dw.Search(first=3, cap=6)}


def with_people(model, **given):
    return Designs(model, people=people_of(model, given))


def orders(rate, **pickers):
    """So many orders an hour, of which a picker needs 30 s each."""
    changes = {"tasks.goods": {"poisson": rate}, "tasks.load_time": 30}
    return SLOW.replace({**changes, **{f"pickers.{key}": value for key, value in pickers.items()}})


@pytest.mark.slow
def test_pickers_are_sized_beside_robots():
    plan = plan_fleet(SLOW, GOAL, robots="1..4", pickers="1..3", **HOW)
    assert (plan.robots, plan.chargers, plan.packers, plan.pickers) == (3, 0, 0, 2)
    assert plan.overrides == {"fleet.size": 3, "pickers.count": 2}
    assert {shown.counts for shown in plan.today.below} == {(2, 0, 3), (3, 0, 1)}
    assert list(plan.table.pickers) == [3, 1, 2]
    answer = plan.answer
    assert answer.question == "How many robots and pickers does it take for at least 45 tasks an hour?"
    assert answer.answer[0].startswith("3 robots and 2 pickers are the smallest fleet shown to be enough today: ")
    assert [(tile.value, tile.what) for tile in answer.tiles[:2]] == [("3", "robots"), ("2", "pickers")]
    assert " the robots and pickers are busiest: " in answer.answer[-1]
    assert list(answer.figure.panels) == ["today, 2 pickers"]


@pytest.mark.slow
def test_pickers_are_sized_beside_packers_for_the_least_wages():
    """Four robots with one picker would be cheaper: 24,000 and 40,000 a year beside the packer's 2,000."""
    plan = plan_fleet(
        SLOW.replace({"prices": PRICES}), GOAL, robots="1..4", packers="packing=1..2", pickers="1..3", **HOW
    )
    assert (plan.robots, plan.packers, plan.pickers, plan.cost) == (3, 1, 2, 3 * 6000 + 2000 + 2 * 40_000)
    best = {"robots": 3, "chargers": 0, "packers": 1, "pickers": 2, "cost": 100_000.0}
    assert plan.answer.content()["today"]["best"] == best
    assert plan.in_short() == "3 robots + 1 packer + 2 pickers"
    assert plan.answer.answer[0].startswith("3 robots, 1 packer and 2 pickers are the cheapest fleet ")


def test_pickers_cost_what_a_run_of_them_costs():
    """Two more at 20 an hour, at work for half of 2,000 hours."""
    hours = {"calendars": {"half": {"every": 200, "lasts": 100}}, "pickers.hours": "half"}
    model = SLOW.replace({**hours, "prices": PRICES})
    designs = with_people(model, pickers="1..3")
    assert designs.cost((2, 0, 3)) - designs.cost((2, 0, 1)) == 2 * 20 * 1000
    assert designs.cost((2, 0, 3)) == year_of(model.replace(designs.overrides((2, 0, 3))))


def test_without_a_range_there_are_as_many_as_in_the_model():
    designs = Designs(SLOW)
    assert designs.totals((3, 0)) == {"fleet.size": 3, "chargers": 0}
    assert designs.overrides((3, 0)) == {"fleet.size": 3}


@pytest.mark.parametrize(
    ("model", "numbers"),
    [
        (orders(60), range(1, 3)),  # 30 min of picks an hour, and beside them up to 10 min of walks
        (orders(250), range(3, 5)),  # 125 min of picks, and with 250 walks of 10 s 167
        (orders(250, count=3, zones=3), range(3, 5)),
        (orders(20, count=3, zones=3), range(3, 5)),
        (SLOW, range(1, 3)),  # no rate of orders: up to twice the one there is
    ],
    ids=["few", "many", "zones", "few in zones", "saturated"],
)
def test_the_estimate_says_which_pickers_are_searched(model, numbers):
    """From those who never walk to one more than enough for walks from anywhere; places are 5 m apart, 10 s on foot."""
    assert with_people(model, pickers="auto").ranges(1.0)[0][2] == list(numbers)


@pytest.mark.parametrize(
    ("changes", "pickers", "message"),
    [
        ({}, "0..2", "pickers 0..2: expected whole numbers upwards from 1"),
        (
            {"pickers.count": 2, "pickers.zones": 2},
            "1..3",
            "--pickers 1: fewer than their 2 zones, expected at least 2",
        ),
        ({"pickers": None}, "1..3", "--pickers: this model has no pickers, expected a section pickers"),
    ],
)
def test_pickers_that_cannot_be_are_one_message(changes, pickers, message):
    with pytest.raises(StudyError, match=message):
        plan_fleet(SLOW.replace(changes), GOAL, pickers=pickers)


@pytest.mark.slow
def test_the_command_says_which_scarce_people_it_did_not_count(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "w.yaml").write_text(json.dumps(SLOW.content()))
    plan = f"desim plan w.yaml --target '{GOAL}' --robots 3..4 --first 3 --cap 6 --quiet --vary tasks.load_time=100"
    status, _, err = pages.run_desim(plan)
    assert status == 3
    assert (
        "No fleet within --robots and --chargers is enough; pickers are scarce, and --pickers counts them, too; " in err
    )
    status, out, _ = pages.run_desim(f"{plan} --pickers 1..2")
    assert (status, out.partition(" are ")[0]) == (0, "3 robots and 2 pickers")
