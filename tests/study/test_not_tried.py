"""Fleets that cannot be simulated: no search drops them silently, or stops at them."""

import pytest

import desim_warehouse as dw
from desim_warehouse.cli.tables import show_failures
from desim_warehouse.errors import StudyError
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.questions.why import worded
from desim_warehouse.study.held_up import HeldUp
from desim_warehouse.study.statistics.effects import Gain, Gains
from desim_warehouse.study.suspects import Suspect, impossible

SEARCH = dw.Search(first=3, cap=6, cache=False, progress=False)
WHY = "4 robots start at D but its bay home has 3 slots; give it more, or spread fleet.start over more nodes"
SENTENCE = f"4 to 6 robots were not tried: {WHY}."


@pytest.fixture(scope="module")
def ring():
    """A ring of 60 m with three slots to park: a task takes 80 s, so three robots do 135 of the 160 an hour."""
    return dw.load(
        {
            "layout": {
                "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 10], "D": [0, 10]},
                "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
                "storage": [{"edge": ["A", "B"], "offset": 5}, {"edge": ["A", "B"], "offset": 15}],
                "bays": {"home": {"at": ["D"], "places": 3}},
                "stations": {"packing": {"at": ["C"], "places": 8}},
            },
            "fleet": {"size": 3, "robot": {"radius": 0.4, "speed": 1, "margin": 0.2}},
            "tasks": {
                "load_time": 10,
                "unload_time": 10,
                "flows": {
                    "orders": {"from": "storage", "to": "packing", "arrivals": {"poisson": 160}, "due_within": 120}
                },
            },
            "run": {"length": 1200, "warm_up": 300},
        }
    )


def test_plan_names_the_fleets_for_which_there_are_no_slots(ring):
    plan = plan_fleet(ring, "on_time >= 95 %", robots="1..6", strategies={}, search=SEARCH)
    assert plan.answer.answer[0].startswith("Today (160 an hour): no fleet tried is enough. 3 robots: ")
    assert plan.answer.answer[1] == SENTENCE
    assert plan.answer.content()["today"]["not_tried"][0]["options"] == [{"fleet.size": size} for size in (4, 5, 6)]
    assert plan.in_short() == "no fleet tried is enough"


def test_where_a_smaller_fleet_is_enough_they_stand_in_a_note(ring):
    """Three robots do 135 an hour."""
    plan = plan_fleet(ring, "throughput_per_hour >= 60", robots="3..6", strategies={}, search=SEARCH)
    assert plan.robots == 3
    assert plan.answer.notes == (SENTENCE,)


def test_where_no_fleet_can_be_simulated_the_error_says_why(ring):
    with pytest.raises(StudyError, match=f"nothing that is searched can be simulated: {WHY}"):
        plan_fleet(ring, "on_time >= 95 %", robots="4..6", search=SEARCH)


def test_size_and_best_go_on_with_the_others(ring):
    study = dw.Study(ring, {"fleet.size": [1, 2, 3, 4, 5, 6]})
    sized = dw.size(study, "throughput_per_hour >= 60", search=SEARCH)
    assert (sized.smallest, sized.answer.notes) == (3, (SENTENCE,))
    chosen = dw.best(study, "throughput_per_hour", search=SEARCH)
    assert (chosen.point.labels, chosen.answer.notes) == ({"fleet.size": 3}, (SENTENCE,))


def test_of_several_factors_each_option_that_is_left_out_is_named(ring):
    study = dw.Study(ring, {"fleet.size": [3, 4], "policies.allocation": ["nearest", "in-order"]})
    chosen = dw.best(study, "throughput_per_hour", search=SEARCH)
    assert [point.labels["fleet.size"] for point in chosen.study.points] == [3, 3]
    [note] = chosen.answer.notes
    assert note.startswith(
        "4 robots, dispatching: nearest and 4 robots, dispatching: in-order were not tried: 4 robots "
    )


def test_one_option_that_is_left_is_no_choice(ring):
    with pytest.raises(StudyError, match=f"the best of one design: .*; another cannot be simulated: {WHY}"):
        dw.best(dw.Study(ring, {"fleet.size": [3, 4]}), "throughput_per_hour", search=SEARCH)


def test_errors_that_differ_in_a_number_are_printed_once(ring, capsys):
    with pytest.warns(RuntimeWarning, match="2 of 3 runs failed"):
        study = dw.Study(ring, {"fleet.size": [3, 4, 5]}).run()
    show_failures(study.results)
    [line] = capsys.readouterr().err.splitlines()[:1]
    assert line.startswith("2 runs failed, the first: LayoutError: layout.bays.home.places: 4 robots ")


def test_no_bottleneck_is_crowned_without_the_relief_that_could_not_be_tried(ring):
    """One robot more has no slot, though the robots are the limit."""
    run = dw.simulate(ring.replace({"log": "all"}))
    assert impossible(run) == {"one robot more": "4 robots start at D but its bay home has 3 slots"}
    crossing = Suspect("intersection C", "nobody waits at C", {"traffic.nodes.C.free": True}, 0.01)
    gain = Gain(1, 1.3, 0.1, 2.5, 8)
    gains = Gains((gain,), 134, 1.34, 0.95, 16)
    costs = HeldUp(ring, "throughput_per_hour", ((crossing, gain),), gains, impossible=("one robot more",))
    assert (
        worded(costs)
        .answer.answer[0]
        .startswith(
            "Intersection C is the main bottleneck of all that could be tried; one robot more could not be. Nobody "
        )
    )
