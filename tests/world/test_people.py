"""People in the aisles: when robots wait for them, whom they meet, and that they come alike whatever robots do."""

import numpy as np
import pytest
from scipy import stats

import desim_warehouse as dw
from desim_warehouse.layout import build
from desim_warehouse.questions.check import check
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.traffic.people import sources, storage_aisles
from tests.auditor import audit
from tests.recount import differences
from tests.world.test_zones import LOOP, on

pytestmark = pytest.mark.usefixtures("brief_probes")

ONE = {"fleet.size": 1, "tasks.goods": [0]}


def with_people(*, robots=ONE, **people):
    return dw.load(LOOP, {**robots, "people": {"pickers": people}})


def visits(model, seed=0, until=1e5):
    """All visits of a model's people: begin, end and first edge."""
    layout = build(model.layout)
    arrivals = []
    for source in sources(model, layout, ()):
        source.start(Streams(seed), model.hours(source.spec.hours), model.units.hour)
        source.come(until)
        arrivals += [(visit.begin, visit.end, visit.edges[0]) for visit in source.visits]
    return arrivals


def test_a_robot_waits_before_an_aisle_until_all_have_left():
    """Two people are in B>C, from 5 to 35 and from 20 to 50; the robot is at the stop line at 9."""
    run = dw.simulate(with_people(aisles=[["B", "C"]], times=[5, 20], stay=30))
    assert on(run, ("B", "C"))[0] == (51, 71)
    assert (run.kpis["waiting_person"], run.kpis["waiting"], run.S) == (41, 0, 0)
    assert run.waits["cause"].tolist() == ["waiting_person"]
    assert run.kpis["encounters_per_hour"] == pytest.approx(3600 / run.T)
    assert run.kpis["shared_time"] == 0
    assert audit(run) == differences(run) == []


def test_people_step_aside_for_each_robot_that_has_waited_for_so_long():
    """Robot 0 is at the stop line at 9 and sets out at 14; robot 1 is there at 15, and sets out at 20."""
    over = {"fleet.size": 2, "tasks.goods": [0, 0]}
    model = with_people(robots=over, aisles=[["B", "C"]], times=[5], stay=95, give_way={"after": 5})
    run = dw.simulate(model)
    assert on(run, ("B", "C"))[:2] == [(15, 35), (21, 41)]
    assert run.kpis["waiting_person"] == 5 + 5
    assert audit(run) == differences(run) == []


@pytest.mark.parametrize(("come", "stay", "enters"), [(8, 95, 15), (5, 7, 13), (2, 4, 10)])
def test_who_leaves_sooner_need_not_step_aside(come, stay, enters):
    """Who has come later, at 8, is asked from 9 on, too; else the robot waits until they leave, or not at all."""
    model = with_people(aisles=[["B", "C"]], times=[come], stay=stay, give_way={"after": 5})
    assert on(dw.simulate(model), ("B", "C"))[0][0] == enters


def test_it_waits_from_when_both_are_there():
    """B>C is closed until 20, with a robot before it from 9 on; somebody is there from 12, and steps aside at 17."""
    over = {"calendars.works": {"between": [[0, 20]]}}
    over["traffic.closures"] = {"works": {"members": [["B", "C"]], "hours": "works", "tasks": "go"}}
    model = with_people(robots={**ONE, **over}, aisles=[["B", "C"]], times=[12], stay=95, give_way={"after": 5})
    run = dw.simulate(model)
    assert on(run, ("B", "C"))[0][0] == 21
    assert audit(run) == differences(run) == []


def test_a_robot_that_is_in_the_aisle_drives_on_and_both_share_it():
    """B>C is driven from 10 to 30; somebody comes at 15 and stays to 55, so they share 15 of 40."""
    run = dw.simulate(with_people(aisles=[["B", "C"]], times=[15], stay=40))
    assert on(run, ("B", "C"))[0] == (10, 30)
    assert run.kpis["waiting_person"] == 0
    assert run.kpis["encounters_per_hour"] == pytest.approx(3600 / run.T)
    assert run.record.people == {"visits": 1, "time": 40, "shared": 15}
    assert run.kpis["shared_time"] == 15 / 40
    assert list(run.robots["encounters"]) == [1]
    assert audit(run) == differences(run) == []


def test_an_aisle_of_several_edges_is_occupied_and_left_as_a_whole():
    """A person in B>C>D from 15 to 100: the robot on B>C goes on over C>D, and is out of the aisle at 40."""
    run = dw.simulate(with_people(aisles=[["B", "C", "D"]], times=[15], stay=85))
    assert on(run, ("C", "D"))[0] == (30, 40)
    assert run.record.people["shared"] == 25
    assert run.kpis["encounters_per_hour"] == pytest.approx(3600 / run.T)
    assert audit(run) == differences(run) == []


def test_what_is_counted_is_counted_from_the_end_of_the_warm_up_on():
    people = {"aisles": [["B", "C"]], "times": [15, 500], "stay": 40}
    over = {"tasks.goods": {"saturated": 1}, "fleet.size": 1}
    run = dw.simulate(dw.load(LOOP, {**over, "people": {"p": people}, "run": {"warm_up": 20, "length": 520}}))
    assert (run.record.people["visits"], run.record.people["time"]) == (1, 35 + 20)
    assert run.record.people["shared"] >= 10
    assert differences(run) == []


def test_people_come_alike_whatever_robots_do():
    people = {"pickers": {"aisles": [["B", "C"], ["D", "E"]], "per_hour": 60, "stay": {"exponential": 30}}}
    over = {"tasks.goods": {"random": 12}, "tasks.load_time": {"exponential": 5}, "people": people}
    few, many = (dw.simulate(dw.load(LOOP, {**over, "fleet.size": size}), seed=3) for size in (1, 3))
    end = min(few.T, many.T)

    def came(run):
        return [row[:7] for row in run.record.rows if row[1] in {"person_in", "person_out"} and row[0] <= end]

    assert came(few) == came(many) != []
    assert many.kpis["waiting_person"] > 0


@pytest.mark.parametrize(("hours", "near"), [(300, 0.055), pytest.param(1000, 0.03, marks=pytest.mark.long)])
def test_they_come_at_random_at_their_rate_and_stay_as_long_as_their_distribution_says(hours, near):
    """Ten an hour: gaps and stays are exponential, and aisles are as likely; within three standard deviations."""
    model = with_people(aisles=[["B", "C"], ["D", "E"]], per_hour=10, stay={"exponential": 30})
    arrivals = visits(model, until=3600 * hours)
    begins = np.array([begin for begin, *_ in arrivals])
    stays = np.array([end - begin for begin, end, _ in arrivals])
    assert len(arrivals) == pytest.approx(10 * hours, rel=near)
    assert stats.kstest(np.diff(begins), "expon", (0, 360)).pvalue > 0.01
    assert stats.kstest(stays, "expon", (0, 30)).pvalue > 0.01
    assert sum(edge == ("B", "C") for *_, edge in arrivals) == pytest.approx(5 * hours, rel=1.5 * near)


def test_they_come_only_in_their_hours():
    calendars = {"day": {"every": 1000, "lasts": 250}}
    people = {"aisles": [["B", "C"]], "per_hour": 100, "hours": "day", "stay": 1}
    arrivals = visits(dw.load(LOOP, {**ONE, "calendars": calendars, "people": {"p": people}}), until=3.6e6)
    assert all(begin % 1000 < 250 for begin, *_ in arrivals)
    assert len(arrivals) == pytest.approx(25_000, rel=0.03)


def test_by_default_they_come_to_storage_as_demand_does():
    """Two goods of three are on E>A, one on B>C; weights make it 1 to 4, and a list of goods as it is listed."""
    storage = [
        {"edge": ["E", "A"], "offset": 10},
        {"edge": ["B", "C"], "offset": 10},
        {"edge": ["E", "A"], "offset": 5},
    ]

    def weights(**over):
        tasks = {**LOOP["tasks"], "goods": {"random": 3}, **over}
        model = dw.load(LOOP, {"layout.storage": storage, "tasks": tasks})
        aisles, shares = storage_aisles(model, build(model.layout), ())
        return {aisle[0]: pytest.approx(share) for aisle, share in zip(aisles, shares, strict=True)}

    assert weights() == {("E", "A"): 2 / 3, ("B", "C"): 1 / 3}
    assert weights(popularity={"weights": [1, 4, 0]}) == {("E", "A"): 1 / 5, ("B", "C"): 4 / 5}
    assert weights(goods=[0, 1, 1, 1]) == {("E", "A"): 1 / 4, ("B", "C"): 3 / 4}


def test_people_come_to_no_storage_inside_an_intersection():
    storage = [{"edge": ["E", "A"], "offset": 10}, {"edge": ["B", "C"], "offset": 10}]
    model = dw.load(LOOP, {"layout.storage": storage, "tasks.goods": {"random": 3}})
    assert storage_aisles(model, build(model.layout), {("B", "C")}) == ([(("E", "A"),)], [1])


def test_in_flows_people_come_to_storage_by_the_rates_of_the_flows():
    """30 an hour to any of two places, 10 from the second."""
    flows = {
        "in": {"from": "packing", "to": "storage", "arrivals": {"poisson": 30}},
        "out": {"from": {"popularity": {"weights": [0, 1]}}, "to": "packing", "arrivals": {"poisson": 10}},
    }
    storage = [{"edge": ["E", "A"], "offset": 10}, {"edge": ["B", "C"], "offset": 10}]
    spec = {**LOOP, "tasks": {"flows": flows, "load_time": 1, "unload_time": 1}}
    model = dw.load(spec, {"layout.storage": storage, "run": {"length": 3600}})
    assert storage_aisles(model, build(model.layout), ())[1] == pytest.approx([15 / 40, 25 / 40])
    half = model.replace({"calendars.morning": {"between": [[0, 1800]]}, "tasks.flows.in.hours": "morning"})
    assert storage_aisles(half, build(half.layout), ())[1] == pytest.approx([7.5 / 25, 17.5 / 25])


@pytest.mark.parametrize(("stay", "left"), [(30, 15), ({"exponential": 30}, 30), ({"uniform": [0, 30]}, 10)])
def test_the_mean_time_left_of_a_stay_is_that_of_renewal_theory(stay, left):
    """E[S^2] / 2 E[S]: half of a fixed stay, all of an exponential one."""
    model = with_people(aisles=[["B", "C"]], times=[5], stay=stay)
    assert sources(model, build(model.layout), ())[0].mean_left == pytest.approx(left)


@pytest.mark.parametrize(
    ("people", "message"),
    [
        ({"stay": 3}, "neither per_hour nor times"),
        ({"stay": 3, "per_hour": 4, "times": [1]}, "both per_hour and times"),
        ({"stay": 3, "times": [1], "hours": "day"}, "beside times, which say when people come"),
        ({"stay": 3, "per_hour": 1, "hours": "x"}, "no such calendar"),
        ({"stay": 3, "times": [1], "aisles": [["A", "C"]]}, "no edge from one to the next"),
        ({"stay": 3, "times": [1], "aisles": [["A"]]}, "two or more along an aisle"),
    ],
)
def test_what_makes_no_sense_is_refused(people, message):
    with pytest.raises(dw.ModelError, match=message):
        with_people(robots={**ONE, "calendars": {"day": {"every": 10, "lasts": 5}}}, **people)


def test_where_goods_lie_at_nodes_people_must_be_told_their_aisles():
    """By default they come to edges with storage places: a place at a node is in none."""
    at_nodes = {"layout.storage": [{"node": "B"}], "tasks.goods": [0]}
    with pytest.raises(dw.CheckError, match=r"people\.p: there is no edge with storage places .* say which aisles"):
        dw.simulate(dw.load(LOOP, {**at_nodes, "people": {"p": {"per_hour": 60, "stay": 30}}}))
    some = {"layout.storage": [{"node": "B"}, {"edge": ["B", "C"], "offset": 10}], "tasks.goods": [0]}
    facts = check(dw.load(LOOP, {**some, "people": {"p": {"per_hour": 60, "stay": 30}}})).facts
    assert any("somebody in it for 39.3 % of the time" in fact for fact in facts)  # 1 - exp(-0.5): of one aisle


@pytest.mark.slow
def test_aisles_that_are_hardly_ever_free_are_warned_of():
    findings = check(with_people(aisles=[["B", "C"]], per_hour=100, stay=100)).findings
    assert [item.text for item in findings if item.code == "AISLES_OCCUPIED"] == [
        "an aisle has somebody in it for 93.8 % of the time on average"
    ]


def two(**changes):
    """Two robots whose goods lie 1.5 into B>C, where the first of them takes 10 to load."""
    near = {"storage": [{"edge": ["B", "C"], "offset": 1.5}]}
    return {
        "fleet.size": 2,
        "tasks.goods": [0, 0],
        "tasks.load_time": 10,
        "layout": {**LOOP["layout"], **near, **changes},
        "log": "all",
    }


def waits_of(run, robot):
    mine = run.waits[run.waits["robot"] == robot]
    return [(row.start, row.end, row.cause) for row in mine.itertuples()]


def test_a_wait_behind_a_robot_goes_on_as_one_for_a_person():
    """Robot 0 is in B>C from 10 on and loads until 21.5; robot 1 waits before B from 10, as it lacks room beyond.

    Somebody comes at 15 and stays until 55: from 21.5 on, when there would be room, they alone keep robot 1 out.
    """
    run = dw.simulate(with_people(robots=two(), aisles=[["B", "C"]], times=[15], stay=40))
    out_of_the_bay, behind, person = waits_of(run, 1)[:3]
    assert out_of_the_bay[1:] == (1, "waiting")
    assert behind == (10, 21.5, "waiting")
    assert person == (21.5, 55, "waiting_person")
    assert (run.kpis["waiting_person"], run.kpis["encounters_per_hour"] * run.T) == (33.5, pytest.approx(2 * 3600))
    assert audit(run) == differences(run) == []


def test_a_queue_behind_a_robot_that_waits_for_a_person_waits_for_that_in_the_account():
    """Somebody is in B>C until 50: robots 1 and 2 stand behind robot 0, which alone waits for them in the log."""
    run = dw.simulate(
        with_people(robots={"fleet.size": 3, "tasks.goods": [0, 0, 0]}, aisles=[["B", "C"]], times=[5], stay=45)
    )
    waited = run.account("robot")["waiting_person"]
    starts = [next(start for start, end, _ in waits_of(run, robot) if start < 50 <= end) for robot in range(3)]
    assert list(waited) == pytest.approx([50 - start for start in starts])
    assert run.kpis["waiting_person"] == pytest.approx(waited[0])
    assert run.account("robot").sum(axis=1).to_numpy() == pytest.approx(run.T)


@pytest.mark.parametrize(("stay", "after"), [(40, 50), (95, 20), (95, 45)])
def test_people_step_aside_for_who_has_waited_long_whatever_for(stay, after):
    """`after` is counted from when both are there: the person from 15 on, robot 1 from about 10."""
    model = with_people(robots=two(), aisles=[["B", "C"]], times=[15], stay=stay, give_way={"after": after})
    run = dw.simulate(model)
    assert waits_of(run, 1)[-1][1:] == (pytest.approx(min(15 + after, 15 + stay)), "waiting_person")
    assert audit(run) == differences(run) == []


def test_a_wait_for_a_person_goes_on_as_one_for_a_robot():
    """Both come out of the bay at B, where somebody is in B>C until 20; the second then waits for the first."""
    over = two(bays={"home": {"at": ["B"], "places": 2}})
    run = dw.simulate(with_people(robots=over, aisles=[["B", "C"]], times=[0], stay=20))
    assert waits_of(run, 0)[0] == (0, 20, "waiting_person")
    first, second = waits_of(run, 1)[:2]
    assert first == (0, 20, "waiting_person")
    assert second[::2] == (20, "waiting")
    assert run.kpis["waiting_person"] == 40
    assert audit(run) == differences(run) == []


def test_two_people_one_after_the_other_are_one_wait():
    """One is in B>C from 5 to 35, and one of another source from 20 to 50: robot 0 is kept out once."""
    people = {name: {"aisles": [["B", "C"]], "times": [time], "stay": 30} for name, time in (("a", 5), ("b", 20))}
    run = dw.simulate(dw.load(LOOP, {**ONE, "people": people}))
    assert waits_of(run, 0)[0] == (9, 50, "waiting_person")
    assert run.kpis["encounters_per_hour"] == pytest.approx(3600 / run.T)


def test_without_an_aisle_to_come_to_people_are_refused_and_nobody_comes():
    layout = {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "A"]],
        "bays": {"home": {"at": ["A"]}},
        "stations": {"dock": {"at": ["B"]}, "pack": {"at": ["C"]}},
    }
    tasks = {"flows": {"in": {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0}]}}}}
    model = dw.load(
        {
            "layout": layout,
            "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
            "tasks": {**tasks, "load_time": 4, "unload_time": 6},
            "people": {"pickers": {"per_hour": 60, "stay": 30}},
        }
    )
    finding = dw.check(model).findings[0]
    assert (finding.code, finding.place) == ("CLOSURE", "people.pickers")
