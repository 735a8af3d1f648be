"""The auditor names every fault that is planted in the rows of a valid run."""

import copy
import dataclasses
import re

import pytest

import desim_warehouse as dw
from tests.auditor import audit
from tests.world.test_tours import ring as tour

RING = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20], "D": [0, 20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["A", "B"], "offset": 10}, {"edge": ["B", "C"], "offset": 10}],
        "bays": {"home": {"at": ["A"], "places": 2}, "spare": {"at": ["D"], "places": 1}},
        "stations": {"pack": {"at": ["C"], "places": 2}, "tiny": {"at": ["D"], "places": 1}},
    },
    "fleet": {"size": 2, "start": ["A"], "robot": {"radius": 1, "speed": 1}},
    "tasks": {"goods": [0, 0, 1, 0], "unload_at": ["C"], "load_time": 5, "unload_time": 3},
    "battery": {"capacity": 1000, "threshold": 100, "consumption": 1, "charge_rate": 10},
    "traffic": {"collision_angle": 90},
}
CROSSING = {
    # two roads that cross at X at right angles, and ring roads home
    "layout": {
        "nodes": {"W": [0, 20], "X": [20, 20], "E": [40, 20], "N": [20, 0], "S": [20, 40]}
        | {"SW": [0, 40], "NE": [40, 0], "NW": [0, 0]},
        "edges": [
            list(edge.split()) for edge in ["W X", "X E", "N X", "X S", "E NE", "NE N", "S SW", "SW W", "N NW", "NW W"]
        ],
        "storage": [{"edge": ["X", "E"], "offset": 10}, {"edge": ["X", "S"], "offset": 10}],
        "bays": {"home": {"at": ["W", "N"]}},
    },
    "fleet": {"size": 2, "robot": {"radius": 1, "speed": 1}},
    "tasks": {"goods": [0, 1], "unload_at": ["E", "S"], "load_time": 5, "unload_time": 3},
    "traffic": {"collision_angle": 30},
}

JOINED = {
    # X and Y are 1 apart, less than D, so one intersection: W > X > F turns off before the road from N joins at Y
    "layout": {
        "nodes": {"W": [0, 20], "X": [20, 20], "Y": [21, 20], "E": [40, 20], "F": [40, 40]}
        | {"M": [40, 0], "N": [21, 0], "S": [0, 40]},
        "edges": [
            list(edge.split()) for edge in ["W X", "X Y", "X F", "N Y", "Y E", "E M", "M N", "E F", "F S", "S W"]
        ],
        "storage": [{"edge": ["X", "F"], "offset": 14}, {"edge": ["Y", "E"], "offset": 10}],
        "bays": {"home": {"at": ["W", "N"]}},
    },
    "fleet": {"size": 2, "robot": {"radius": 1, "speed": 1}},
    "tasks": {"goods": [0, 1], "unload_at": ["F", "E"], "load_time": 5, "unload_time": 3},
    "traffic": {"collision_angle": 60},
}


SPUR = {
    # two robots on a spur with the good at its tip: one direction at a time
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [40, 0]},
        "edges": [{"from": "A", "to": "B", "two_way": True}, {"from": "B", "to": "C", "two_way": True}],
        "storage": [{"edge": ["B", "C"], "offset": 10}],
        "bays": {"home": {"at": ["A"], "places": 2}},
        "stations": {"pack": {"at": ["A"], "places": 2}},
    },
    "fleet": {"size": 2, "robot": {"radius": 1, "speed": 1}},
    "tasks": {"goods": [0, 0], "unload_at": ["A"], "load_time": 5, "unload_time": 3},
}


AT_NODES = {
    **RING,
    "layout": {**RING["layout"], "storage": [{"node": "A"}, {"node": "B"}]},
    "tasks": {**RING["tasks"], "goods": [1, 0, 1, 0]},
    "battery": None,
}
TURNING = {**RING, "traffic": {**RING["traffic"], "turn_time": 4}}
AB, BC, DA = ("A", "B"), ("B", "C"), ("D", "A")


def kept(model):
    """Return a fixture with the run of a model, simulated once."""
    return pytest.fixture(scope="module")(lambda: dw.simulate(dw.load(model)))


ring, crossing, joined, spur = kept(RING), kept(CROSSING), kept(JOINED), kept(SPUR)
at_nodes, turning = kept(AT_NODES), kept(TURNING)


def altered(run, rows=None, **kpis):
    """Return a copy of a run with other rows or indicators."""
    other = copy.copy(run)
    record = run.record if rows is None else dataclasses.replace(run.record, rows=sorted(rows, key=lambda row: row[0]))
    other.record = record
    other.kpis = run.kpis | kpis
    return other


def change(row, **columns):
    names = ("time", "kind", "robot", "task", "node", "edge", "value", "until", "other")
    return tuple(columns.get(name, value) for name, value in zip(names, row, strict=True))


def first(rows, kind, robot=None, edge=None, node=None):
    return next(
        i
        for i, row in enumerate(rows)
        if row[1] == kind and robot in {None, row[2]} and edge in {None, row[5]} and node in {None, row[4]}
    )


def finds(run, text):
    problems = audit(run)
    assert any(re.search(text, line) for line in problems), problems


def test_valid_runs_have_no_faults(ring, crossing, joined):
    assert audit(ring) == []
    assert audit(crossing) == []
    assert audit(joined) == []
    # the runs have queues and a wait before a crossing, in which faults can be planted
    assert {row[1] for row in ring.record.rows} >= {"collision", "drive", "docked", "parked"}
    assert crossing.kpis["crossings"] >= 1


def moved(*, time=0.0, until=0.0, value=0.0, **columns):
    """Return a function that changes a row: numbers are added to its own, other columns replaced."""

    def shifted(row):
        later = {
            name: row[column] + by
            for name, column, by in (("time", 0, time), ("value", 6, value), ("until", 7, until))
            if by
        }
        return change(row, **later, **columns)

    return shifted


JUMP = r"robot 0 jumped from|robot 0 entered a bay at C from \('A', 'B'\)"
AWRY = r"robot 0 drives from 0.0 to [\d.]+ on \('B', 'C'\)"
LOW = "robot 0 drew|robot 0 had 1000 energy"
ONE_ROW = {
    # robot 1 stops 2 behind robot 0, which loads at 10
    "too close": ("ring", ("drive", 1, AB), moved(value=1, until=1), r"robots 0 and 1 are 1 apart on \('A', 'B'\)"),
    "near a node": ("spur", ("drive", 0, BC), moved(value=9, until=3), "robot 0 stands on .*, 1 from a node"),
    "an edge from elsewhere": ("ring", ("enter", 0, BC), moved(edge=DA), JUMP),
    "an edge too early": ("ring", ("enter", 0, BC), moved(time=-3), JUMP),
    "a drive elsewhere": ("ring", ("drive", 0, BC), moved(edge=DA), r"robot 0 drives on \('D', 'A'\), where it is not"),
    "no arrival": ("ring", ("drive", 0, AB), moved(until=30), "robot 0 sets off on .* before it had arrived"),
    "too fast": ("ring", ("drive", 0, BC), moved(until=-1), AWRY),
    "beyond the end": ("ring", ("drive", 0, BC), moved(value=10), AWRY),
    # robot 1 leaves A when robot 0 is 2 beyond it, at 2
    "out of a bay": ("ring", ("enter", 1, AB), moved(time=-1), "robot 1 came out of a bay at A, 1 from robot 0"),
    "into a bay": ("ring", ("parked", 0), moved(node="B"), "robot 0 entered a bay at B from"),
    "another edge": ("ring", ("released",), moved(value=1), "robot 0 loads good 1, which is not where it is"),
    "another place": ("ring", ("loading", 0), moved(time=-4), "robot 0 loads good 0 at 6, not at 10"),
    "another node": ("at_nodes", ("released",), moved(value=-1), "robot 0 loads good 0, which is not where it is"),
    "not cleared": ("at_nodes", ("loading", 1), moved(time=-1), "robot 1 came out of a bay at A, 1 from robot 0"),
    "a short turn": ("turning", ("enter", 0, BC), moved(time=-1), "robot 0 spends 3 of 4 at B"),
    # robot 0 has 990 left when it loads
    "below nothing": ("ring", ("loading", 0), moved(value=-991), "robot 0 has -1.0 energy"),
    "out of nothing": ("ring", ("loading", 0), moved(value=11), "robot 0 has 1001.0 energy"),
    "too much drawn": ("ring", ("loading", 0), moved(value=-90), LOW),
    "too little drawn": ("ring", ("loading", 0), moved(value=9), "robot 0 drew"),
}


@pytest.mark.parametrize(("run", "where", "planted", "text"), ONE_ROW.values(), ids=ONE_ROW)
def test_an_impossible_row_is_found(run, where, planted, text, request):
    run = request.getfixturevalue(run)
    assert audit(run) == []
    rows = list(run.record.rows)
    place = first(rows, *where)
    rows[place] = planted(rows[place])
    finds(altered(run, rows), text)


def test_an_edge_that_is_left_out_is_found(ring):
    finds(altered(ring, [row for row in ring.record.rows if (row[5], row[2]) != (BC, 0)]), JUMP)


def test_two_robots_that_meet_head_on_in_a_two_way_lane_are_found(spur):
    assert audit(spur) == []
    rows = list(spur.record.rows)
    # robot 1 enters the spur while robot 0, which came first, is on its way back on it
    back = first(rows, "enter", robot=0, edge=("B", "A"))
    mine = first(rows, "enter", robot=1, edge=("A", "B"))
    rows[mine] = change(rows[mine], time=rows[back][0] + 1)
    finds(altered(spur, rows), r"robots \d and \d meet head-on between A and B")


def test_a_robot_that_overtakes_is_found(ring):
    rows = list(ring.record.rows)
    # robot 1, behind robot 0 on A>B, is on B>C before robot 0
    ahead, behind = first(rows, "enter", 0, ("B", "C")), first(rows, "enter", 1, ("B", "C"))
    rows[behind] = change(rows[behind], time=rows[ahead][0] - 1)
    finds(altered(ring, rows), r"robot 1 overtook robot 0 on \('A', 'B'\)")


def from_then_on(rows, robot, time, earlier):
    """Return the rows with all rows of a robot after a time moved earlier."""
    return [
        change(row, time=row[0] - earlier, until=None if row[7] is None else row[7] - earlier)
        if row[2] == robot and row[0] >= time
        else row
        for row in rows
    ]


@pytest.mark.parametrize(
    ("earlier", "text"),
    [
        # robot 1 waited at its stop line 18 from 18 until robot 0 was c = D (cos 30 + sin 30 - 1) = 0.73 beyond X
        (0.2, r"robot 1 on \('N', 'X'\) drives at robot 0 on \('X', 'E'\)"),
        (0.7, r"robot 1 on \('N', 'X'\) drives at robot 0 on \('X', 'E'\)"),
        (2, r"robot 1 drove onto X while robot 0 was there"),
    ],
)
def test_two_robots_in_an_intersection_are_found(crossing, earlier, text):
    rows = list(crossing.record.rows)
    wait = rows[first(rows, "collision", 1, node="X")]
    assert wait[6] == pytest.approx(2 + 2 * (3**0.5 / 2 + 0.5 - 1))
    finds(altered(crossing, from_then_on(rows, 1, wait[0], earlier)), text)


@pytest.mark.parametrize(
    ("earlier", "text"),
    [
        # robot 1 waited at its stop line before Y until robot 0 was 0.6 beyond X, on its way past the road from N
        (0.3, r"robot 1 on \('N', 'Y'\) drives at robot 0 on \('X', 'F'\)"),
        (0.7, r"robot 1 drove onto X\+Y while robot 0 was there"),
    ],
)
def test_two_robots_in_nodes_that_are_one_intersection_are_found(joined, earlier, text):
    rows = list(joined.record.rows)
    wait = rows[first(rows, "collision", 1, node="X")]
    assert wait[6] == pytest.approx(2.6)
    finds(altered(joined, from_then_on(rows, 1, wait[0], earlier)), text)


def test_waiting_a_little_longer_is_no_fault(crossing):
    """Conversely, the auditor reports nothing that is allowed."""
    rows = list(crossing.record.rows)
    wait = rows[first(rows, "collision", 1, node="X")]
    assert audit(altered(crossing, from_then_on(rows, 1, wait[0], -0.5))) == []


def test_a_robot_that_leaves_another_bay_than_it_entered_is_found(ring):
    rows = list(ring.record.rows)
    parked = first(rows, "parked", 0)
    before = max(i for i in range(parked) if rows[i][1] == "enter" and rows[i][2] == 0)
    rows = [row for i, row in enumerate(rows) if not (before < i < parked and row[1] == "enter" and row[2] == 0)]
    here = first(rows, "enter", 1)
    rows[here] = change(rows[here], edge=("C", "D"))
    finds(altered(ring, rows), r"robot 1 was in a bay at A and came out onto \('C', 'D'\)")


@pytest.mark.parametrize(("kind", "node", "text"), [("parked", "D", "parked at D"), ("docked", "D", "docked at D")])
def test_more_robots_than_places_are_found(ring, kind, node, text):
    rows = list(ring.record.rows)
    end = rows[-1][0]
    rows += [(end, kind, robot, -1, node, None, None, None, -1) for robot in (0, 1)]
    finds(altered(ring, rows), rf"2 robots are {text}, which has 1")


@pytest.mark.parametrize(
    ("plant", "text"),
    [
        ("delivered twice", "task 0 was delivered after being delivered"),
        ("never delivered", "tasks were lost or made up"),
        ("never released", "task 0 was assigned after being None"),
        ("given out twice", "task 0 was assigned after being assigned"),
        ("two at once", "robot 0 was given task 1 while it had task 0"),
        ("by another robot", "task 0 was delivered by robot 1, which did not have it"),
        ("given back and delivered", "task 0 was delivered after being returned"),
        ("never loaded", "task 0 was delivered and never loaded"),
    ],
)
def test_tasks_that_are_lost_or_made_up_are_found(ring, plant, text):
    rows = list(ring.record.rows)

    def rank(kind, task=0):
        return next(i for i, row in enumerate(rows) if row[1] == kind and row[3] == task)

    if plant == "delivered twice":
        rows.append(rows[rank("delivered")])
    elif plant == "never delivered":
        del rows[rank("delivered", 3)]
    elif plant == "never released":
        del rows[rank("released")]
    elif plant == "given out twice":
        rows.insert(rank("assigned"), rows[rank("assigned")])
    elif plant == "two at once":
        rows[rank("assigned", 1)] = change(rows[rank("assigned", 1)], robot=0)
    elif plant == "by another robot":
        rows[rank("delivered")] = change(rows[rank("delivered")], robot=1)
    elif plant == "given back and delivered":
        rows.insert(rank("loading"), change(rows[rank("loading")], kind="returned"))
    else:
        del rows[rank("loading")]
    finds(altered(ring, rows), text)


def test_shares_that_do_not_add_up_are_found(ring):
    finds(altered(ring, share_idle=ring.kpis["share_idle"] + 0.01), "state shares add up to 1.01")


@pytest.mark.parametrize(
    ("kind", "key"),
    [("enter", "moves"), ("collision", "rear_ends|crossings"), ("delivered", "delivered"), ("recharged", "recharged")],
)
def test_missing_rows_are_found(ring, kind, key):
    rows = list(ring.record.rows)
    if kind == "recharged":
        rows.append(change(rows[-1], kind=kind))
    else:
        del rows[first(rows, kind)]
    finds(altered(ring, rows), rf"robot \d counts \d+ ({key}), \d+ are logged")


@pytest.mark.parametrize(
    ("earlier", "text"),
    [
        (1, r"2 robots are served at D, which has 1 servers"),
        (-1, r"robot 1 is served at D from 81, its turn was at 80"),
    ],
)
def test_a_robot_served_out_of_turn_is_found(earlier, text):
    """Robot 1 waits for the server at D from 76 until robot 0 has unloaded twice, at 80."""
    run = tour({"from": "dock", "to": "pack"}, (0, 4), fleet__size=2, traffic__collision_angle=0)
    rows = list(run.record.rows)
    turn = first(rows, "unloading", 1, node="D")
    assert rows[turn][0] == 80
    rows[turn] = change(rows[turn], time=80 - earlier)
    finds(altered(run, rows), text)
