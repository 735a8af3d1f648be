"""Pickers among what may hold a warehouse up, and among those who are busiest."""

import pytest

import desim_warehouse as dw
from desim_warehouse.answer.busiest import of_run
from desim_warehouse.outcome.loads import loads
from desim_warehouse.study.fleet.loads import loads_at
from desim_warehouse.study.study import StudyEngine
from desim_warehouse.study.suspects import suspects
from tests.world.test_pickers import RING

OPEN = {"tasks.goods": {"saturated": 8}, "fleet.size": 3, "run.length": 2000}


def simulated(**pickers):
    return dw.simulate(dw.load(RING, {**OPEN, "pickers": {"count": 1, "speed": 0.1, **pickers}}))


@pytest.mark.parametrize(
    ("pickers", "reliefs"),
    [
        ({}, ["one picker more", "pickers sent ahead"]),
        ({"call": "ahead"}, ["one picker more"]),
        ({"stay": "order"}, ["one picker more", "a picker free after each pick"]),
        ({"count": 2, "zones": 2}, ["one picker more", "pickers in all zones", "pickers sent ahead"]),
    ],
)
def test_pickers_and_how_they_share_the_work_are_looked_into(pickers, reliefs):
    run = simulated(**pickers)
    by_relief = {suspect.relief: suspect for suspect in suspects(run)}
    assert [relief for relief in by_relief if "picker" in relief] == reliefs
    assert by_relief["one picker more"].overrides == {"pickers.count": run.model.pickers.count + 1}
    assert by_relief["one picker more"].waited == run.kpis["share_awaiting_picker"]
    assert by_relief["one picker more"].dose == 1 / run.model.pickers.count


def test_where_pickers_go_home_before_the_orders_end_nothing_is_said_to_be_left_over():
    """They are there in the first half of two hours; 20 lines an hour that they walk 10 s to and pick in 7 are 9 %.

    As half of the work is left, twice that is asked of them. The robot, too, has twice as much to do as it did.
    """
    morning = {"calendars": {"morning": {"between": [[0, 3600]]}}}
    changes = {"tasks.goods": {"poisson": 20}, "run.length": 7200, "pickers.hours": "morning"}
    run = dw.simulate(dw.load({**RING, **morning}, changes))
    robots, pickers = (one for one in loads(run.history, run.kpis) if one.group.kind in {"robots", "pickers"})
    assert "CANNOT_KEEP_UP" in {verdict.code for verdict in run.verdicts}
    worked = run.kpis["picker_utilisation"] + run.kpis["picker_walking"]
    assert (worked, pickers.mean) == (pytest.approx(0.09, abs=0.03), pytest.approx(2 * worked, rel=0.2))
    line = of_run(run.history, run.kpis)
    assert line.startswith(f"The robots were the busiest, with demand at {100 * robots.mean:.1f} % of their capacity")


def test_hours_of_pickers_are_looked_into():
    model = dw.load({**RING, "calendars": {"half": {"every": 200, "lasts": 100}}}, {**OPEN, "pickers.hours": "half"})
    doses = {suspect.relief: suspect.dose for suspect in suspects(dw.simulate(model))}
    assert doses["pickers always at work"] == pytest.approx(1)


def test_pickers_are_the_busiest_where_robots_wait_for_them():
    """Walking and picking are their work."""
    run = simulated()
    load = next(load for load in loads(run.history, run.kpis) if load.group.name == "pickers")
    assert load.mean == run.kpis["picker_utilisation"] + run.kpis["picker_walking"] > 0.8
    assert of_run(run.history, run.kpis).startswith("The pickers were the busiest, at work 8")


def test_load_of_pickers_is_known_of_the_runs_of_a_study():
    study = StudyEngine(dw.load(RING, OPEN), {}, replications=2, seed=1)
    study.run()
    names = {load.group.name for load in loads_at(study, study.points[0])}
    assert "pickers" in names
