"""Positions rebuilt from the log: exact at its events, continuous and no faster than robots drive in between."""

import itertools
import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import desim_warehouse as dw
from desim_warehouse.errors import ReportError
from desim_warehouse.outcome.positions import Positions
from desim_warehouse.outcome.zones import cell_size, zones
from tests.report.replay.floors import RUNS, busy, busy_run, drawn_run, grid_run, jammed_run, paper_run, people_run

EPS = 1e-6


@cache
def positions(name):
    return Positions(RUNS[name]().history)


def whereabouts(run):
    return {edge: number for number, edge in enumerate(run.layout.graph.edges)}


@pytest.mark.parametrize("name", RUNS)
def test_a_robot_is_at_its_target_when_the_log_says_it_gets_there(name):
    run, where = RUNS[name](), positions(name)
    number = whereabouts(run)
    last = {}
    for row in run.record.rows:
        if row[1] == "drive":
            last[row[2]] = row
    rows = [row for row in run.record.rows if row[1] == "drive" and row[7] > row[0] and row[7] <= run.record.end]
    for time, _, robot, _, _, edge, value, until, *_ in rows[:: max(len(rows) // 300, 1)]:
        on, at = where.at(until - 1e-9)
        assert on[robot] == number[edge]
        assert at[robot] == pytest.approx(value, abs=1e-5)
        assert where.at(time)[0][robot] == number[edge]
    for robot, (_, _, _, _, _, edge, value, until, _) in last.items():
        parked = [row for row in run.record.rows if row[1] in ("parked", "docked") and row[2] == robot]
        if until <= run.record.end and not (parked and parked[-1][0] >= until):
            assert where.at(run.record.end)[1][robot] == pytest.approx(value)
            assert where.at(run.record.end)[0][robot] == number[edge]


def offsets(layout, edge):
    """Where the goods of an edge lie: beside it, beside the edge back of a two-way lane, at its end."""
    two_way, length = layout.graph.edges[edge].get("two_way"), layout.length(edge)
    for place in layout.storage:
        if place.edge == edge:
            yield place.offset
        elif two_way and place.edge == edge[::-1]:
            yield length - place.offset
        elif place.edge == (edge[1], edge[1]):
            yield length


@pytest.mark.parametrize("name", RUNS)
def test_robots_load_where_their_good_lies(name):
    """In a full ring that cannot turn otherwise, less than D before it (docs/why.md)."""
    run, where = RUNS[name](), positions(name)
    short = run.model.fleet.contact if run.record.rings else 1e-6
    edges = list(run.layout.graph.edges)
    loads = [row for row in run.record.rows if row[1] == "loading"]
    assert loads
    for time, _, robot, *_ in loads[:60]:
        on, at = where.at(time)
        here = list(offsets(run.layout, edges[on[robot]]))
        assert any(-1e-6 <= offset - at[robot] < short for offset in here)


@pytest.mark.parametrize("name", RUNS)
def test_the_length_driven_is_the_length_counted(name):
    run, where = RUNS[name](), positions(name)
    legs = where.legs
    part = np.clip((run.record.end - legs.begin) / np.maximum(legs.end - legs.begin, 1e-12), 0, 1)
    real = legs.edge < where.edges.real
    driven = float((part * (legs.target - legs.origin))[real].sum())
    if run.record.begin:
        part = np.clip((run.record.begin - legs.begin) / np.maximum(legs.end - legs.begin, 1e-12), 0, 1)
        driven -= float((part * (legs.target - legs.origin))[real].sum())
    whole = run.model.run.length is None  # else robots are counted ahead by what they have committed to
    assert driven == pytest.approx(run.kpis["distance"], rel=1e-6 if whole else 1e-3)


@pytest.mark.parametrize("name", RUNS)
def test_legs_follow_each_other_without_a_jump(name):
    """In space a robot is only ever moved at once into a place beside its node (and from its last place there)."""
    where = positions(name)
    legs, edges = where.legs, where.edges
    start, end = edges.points(legs.edge, legs.origin), edges.points(legs.edge, legs.target)
    for low, high in itertools.pairwise(legs.first):
        for leg in range(low + 1, high):
            assert legs.begin[leg] >= legs.end[leg - 1] - EPS
            if legs.edge[leg] < edges.real or legs.edge[leg] == legs.edge[leg - 1]:
                assert math.dist(start[leg], end[leg - 1]) < EPS
            else:
                assert edges.target[legs.edge[leg - 1]] == edges.source[legs.edge[leg]]


@given(part=st.floats(0, 1), name=st.sampled_from(sorted(RUNS)))
def test_robots_on_one_lane_never_touch(part, name):
    run, where = RUNS[name](), positions(name)
    robot = run.model.fleet.robot
    on, at = where.at(part * run.record.end)
    for edge in set(on.tolist()):
        if edge < where.edges.real:
            lane = np.sort(at[on == edge])
            assert (np.diff(lane) >= 2 * robot.radius + robot.margin - 1e-4).all()


@given(part=st.floats(0, 1), name=st.sampled_from(sorted(RUNS)))
def test_no_two_robots_share_a_place_beside_a_node(part, name):
    run, where = RUNS[name](), positions(name)
    on, at = where.at(part * run.record.end)
    beside = on[(on >= where.edges.real) & (at == 0)].tolist()
    assert len(beside) == len(set(beside))


@given(part=st.floats(0, 0.999), step=st.floats(1e-4, 1.0))
def test_robots_drive_no_faster_than_their_speed(part, step):
    run, where = paper_run(), positions("paper")
    time = part * (run.record.end - 1)
    before, after = where.points(time), where.points(time + step)
    parked = {row[2] for row in run.record.rows if row[1] == "parked" and time <= row[0] <= time + step}
    for robot in set(range(run.model.fleet.size)) - parked:
        assert math.dist(before[robot], after[robot]) <= run.model.fleet.robot.speed * step + 1e-6


def test_the_paper_s_robots_start_in_the_zones_above_their_letters_and_drive_down_to_them():
    where = positions("paper")
    assert where.points(0).tolist() == [[25 + 150 * k, -15] for k in range(6)]
    assert where.points(11).tolist() == [[25 + 150 * k, 25] for k in range(6)]
    assert where.headings(5) == pytest.approx([math.pi / 2] * 6)


def test_places_of_a_crowded_bay_lie_outside_the_floor_and_apart():
    run = busy_run()
    for zone in positions("busy").zones:
        points = zone.places
        assert len(points) == {"bay": 5, "station": 3}[zone.kind]
        gaps = [math.dist(a, b) for a, b in itertools.combinations(points, 2)]
        assert min(gaps) >= 2 * run.model.fleet.robot.radius
        top, bottom = 0.0, max(data["y"] for _, data in run.layout.graph.nodes(data=True))
        assert all(y < top + 1 if zone.kind == "bay" else y > bottom for _, y in points)


def test_a_robot_in_a_bay_in_the_lane_stands_on_its_node():
    layout = {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [20, 0]},
        "edges": [{"from": "A", "to": "B", "two_way": True}, {"from": "B", "to": "C", "two_way": True}],
        "storage": [{"node": "B"}],
        "bays": {"park": {"at": ["C"], "in_lane": True}},
    }
    fleet = {"size": 1, "robot": {"radius": 0.5, "speed": 1}}
    tasks = {"goods": [0], "unload_at": ["A"], "load_time": 1, "unload_time": 1}
    run = dw.simulate(dw.load({"layout": layout, "fleet": fleet, "tasks": tasks}))
    assert Positions(run.history).points(0).tolist() == [[20, 0]]


@pytest.mark.parametrize("level", ["moves", "tasks"])
def test_a_log_without_drives_is_refused(level):
    run = dw.simulate(dw.load(busy(log=level)))
    with pytest.raises(ReportError, match=rf"log: all \(now log: {level}\).*--set log=all"):
        Positions(run.history)


def test_rotating_rings_are_in_the_jammed_run():
    """The other tests mean to cover them."""
    assert jammed_run().kpis["rotations"] > 0


def test_slots_on_a_grid_are_inside_their_cell_and_clear_of_each_other():
    """Beside a cell are other cells, not room: the floor of slots is the cell of their node."""
    run = grid_run()
    model, layout = run.model, run.history.layout
    assert cell_size(model, layout) == 1.0
    shown = zones(model, layout)
    assert [len(zone.places) for zone in shown] == [2, 2, 2]
    for zone in shown:
        node = layout.graph.nodes[zone.node]
        for x, y in zone.places:
            assert max(abs(x - node["x"]), abs(y - node["y"])) + zone.room <= 0.5
        assert math.dist(*zone.places) >= 2 * zone.room


def test_a_floor_is_a_grid_of_cells_up_to_eight_radii_wide():
    model = grid_run().model
    small, smaller = (model.replace({"fleet.robot.radius": radius}) for radius in (0.125, 0.124))
    assert (cell_size(small, small.floor), cell_size(smaller, smaller.floor)) == (1.0, 0.0)


def test_many_slots_of_a_station_do_not_hide_a_small_floor():
    few, many = (dw.load("models/tutorial.yaml", {"layout.stations.packing.places": places}) for places in (8, 28))
    width = max(data["x"] for _, data in many.floor.graph.nodes(data=True))

    def station(model):
        return next(zone for zone in zones(model, model.floor) if zone.kind == "station")

    assert station(few).room == 0.35  # as a robot
    spans = [max(values) - min(values) for values in zip(*station(many).places, strict=True)]
    assert (len(station(many).places), max(spans) <= 0.15 * width) == (28, True)
    assert station(many).room < 0.35


def test_floors_that_are_no_grid_have_their_slots_beside_the_node():
    for run in (people_run(), drawn_run()):
        assert cell_size(run.model, run.history.layout) == 0
        for zone in zones(run.model, run.history.layout):
            node = run.history.layout.graph.nodes[zone.node]
            assert all(math.dist(place, (node["x"], node["y"])) > 0 for place in zone.places)
