"""Grids of planners: drawn for these tests and worked out by hand, and those of others where they are."""

import itertools
import json
import math
import time

import networkx as nx
import pytest

import desim_warehouse as dw
from benchmarks.grids import reading, warehouse, write
from desim_warehouse.layout import build
from desim_warehouse.plants import import_layout, read_plant
from tests.auditor import audit
from tests.plants.foreign import needs_plants, plant_file, remarks
from tests.plants.grids import GGO, KIVA, MAP, ROUND, TASKS, problem, written

# The formats


def test_free_cells_are_points_a_metre_apart_and_neighbours_are_joined_by_one_two_way_lane(tmp_path):
    plant = read_plant(written(tmp_path, "yard.map", MAP))
    assert list(plant.points) == ["r0c0", "r0c1", "r0c3", "r1c0", "r1c2", "r1c3", "r2c0", "r2c1", "r2c2"]
    assert (plant.points["r1c3"].x, plant.points["r1c3"].y) == (3, 1)  # column to the right, row downwards
    model = dw.read_layout(tmp_path / "yard.map")
    pairs = {(edge.source, edge.target) for edge in model.layout.edges}
    assert pairs == {
        ("r0c0", "r0c1"),
        ("r0c0", "r1c0"),
        ("r0c3", "r1c3"),
        ("r1c0", "r2c0"),
        ("r1c2", "r1c3"),
        ("r1c2", "r2c2"),
        ("r2c0", "r2c1"),
        ("r2c1", "r2c2"),
    }
    assert all(edge.two_way for edge in model.layout.edges)
    assert len(build(model.layout).two_way) == 8
    assert model.fleet.contact == 1  # a robot fills a cell
    assert model.layout.stations["anywhere"].at == tuple(plant.points)  # the map names no places of work


def test_cells_have_the_size_that_is_given(tmp_path):
    model = dw.read_layout(written(tmp_path, "yard.map", MAP), cell=0.8)
    assert model.layout.nodes["r2c1"] == (0.8, 1.6)
    assert (model.fleet.robot.radius, model.fleet.robot.speed) == (0.4, 0.8)
    for cell in (0, -1, math.nan, math.inf, "1 m", True):
        with pytest.raises(dw.ModelError, match=r"yard\.map: cell .*: expected metres from 0\.01 to 1000"):
            dw.read_layout(tmp_path / "yard.map", cell=cell)
    for robots in (0, -1, 1.5, "two", True):
        with pytest.raises(dw.ModelError, match=r"yard\.map .*: robots .*: expected a whole number above 0"):
            dw.read_layout(tmp_path / "yard.map", robots=robots)


def test_the_league_marks_where_goods_are_picked_and_delivered(tmp_path):
    model = dw.read_layout(written(tmp_path, "yard.map", MAP.replace(".T..", "ET.S").replace("...W", "S..W")))
    assert [place.node for place in model.layout.storage] == ["r1c3", "r2c0"]
    assert model.layout.stations["delivery"].at == ("r1c0",)
    swamps = dw.read_layout(written(tmp_path, "swamp.map", MAP.replace(".T..", "ST.S")))
    assert len(swamps.layout.storage) == 9  # S is a free cell like others there


def test_a_kiva_map_has_endpoints_homes_and_as_many_robots(tmp_path):
    made = import_layout(written(tmp_path, "small.map", KIVA))
    model = made.model
    ends = [f"r{row}c{column}" for row in (1, 3) for column in (1, 2, 3, 4)]
    assert [place.node for place in model.layout.storage] == list(model.layout.stations["endpoint"].at) == ends
    assert model.layout.bays["parking"].at == model.fleet.start == ("r1c6", "r3c6")
    assert model.fleet.size == 2
    assert len(model.layout.nodes) == 36
    assert "fleet.robot.radius" in {remark.kind for remark in made.remarks if remark.what == "assumed"}
    assert dw.read_layout(tmp_path / "small.map", robots=5).layout == model.layout


def test_tasks_of_mapd_name_endpoints_by_rank_and_take_no_time_for_handling(tmp_path):
    files = written(tmp_path, "small.map", KIVA), written(tmp_path, "small.task", TASKS)
    model = dw.read_layout(files[0], tasks=files[1])
    storage = [place.node for place in model.layout.storage]
    tasks = [(task.release, storage[task.good], task.to) for task in model.tasks.goods]
    assert tasks == [(0, "r1c1", "r3c2"), (4, "r1c3", "r3c4"), (4, "r1c2", "r3c3")]
    assert (model.tasks.load_time, model.tasks.unload_time) == (0, 0)
    run = dw.simulate(model, seed=0)
    audit(run)
    assert run.kpis["tasks"] == 3
    # The robot at r3c6 is 7 steps from r1c1 and 2 rows and a column further brings the load to r3c2; the other one is
    # 5 away and is taken: r1c6, 5 steps to r1c1, then 5 around the shelf at column 0 to r3c2.
    assert run.history.tasks[0].delivered == 5 + 5


def test_many_tasks_are_orders_in_a_file_beside_the_model(tmp_path):
    many = [f"{rank} {rank % 8} {(rank + 3) % 8}" for rank in range(600)]
    written(tmp_path, "small.map", KIVA)
    written(tmp_path, "many.task", "\n".join(["600 1000", *many]))
    made = import_layout(tmp_path / "small.map", tasks=tmp_path / "many.task")
    files = made.files(tmp_path / "small.yaml")
    assert [path.name for path in files] == ["small.yaml", "small.orders.csv"]
    for path, text in files.items():
        path.write_text(text)
    assert (tmp_path / "small.orders.csv").read_text().splitlines()[:2] == [
        "order,release,from,to",
        "task 0,0,r1c1,r1c4",
    ]
    run = dw.simulate(dw.load(tmp_path / "small.yaml", {"run.length": 700, "log": "tasks"}))
    assert run.kpis["tasks"] == dw.simulate(made.model.replace({"run.length": 700, "log": "tasks"})).kpis["tasks"] > 20


def test_ggo_goods_go_from_endpoints_to_workstations(tmp_path):
    made = import_layout(written(tmp_path, "shelves.json", GGO), robots=3)
    model = made.model
    assert model.name == "two shelves"
    assert [place.node for place in model.layout.storage] == ["r1c1", "r1c3", "r2c1", "r2c3"]
    assert model.layout.stations["workstation"].at == ("r0c0", "r3c4")
    assert ("key", ("maxtime",)) in remarks(made, "left out")
    without = {**GGO, "layout": [row.replace("w", "r") for row in GGO["layout"]], "n_agent_loc": 2}
    model = dw.read_layout(written(tmp_path, "homes.json", without))
    assert model.layout.stations["endpoint"].at == ("r1c1", "r1c3", "r2c1", "r2c3")
    assert model.layout.bays["parking"].at == ("r0c0", "r3c4")


def test_ggo_weights_are_preferred_directions(tmp_path):
    """Cells A B over C D; arcs in the order east, north, west, south of A, B, C, D, after the weight of waiting."""
    weights = [1, 1, 4, 2, 1, 1, 1, 3, 0.5]
    square = {"layout": ["ee", "ee"], "weight": True, "weights": weights}
    made = import_layout(written(tmp_path, "square.json", square))
    edges = {(edge.source, edge.target): edge.against for edge in made.model.layout.edges}
    assert edges == {
        ("r0c0", "r0c1"): 2,  # 1 there, 2 back
        ("r1c0", "r0c0"): 4,  # 4 down, 1 up
        ("r0c1", "r1c1"): 3,  # 1 down, 3 up
        ("r1c1", "r1c0"): 2,  # 1 there, 0.5 back
    }
    assert ("weight", ("of waiting",)) in remarks(made, "left out")


def test_a_problem_of_the_league_has_its_robots_and_tasks(tmp_path):
    made = import_layout(problem(tmp_path))
    model = made.model
    assert model.layout.bays["parking"].at == model.fleet.start == ("r0c0", "r2c2")  # two of three, as teamSize says
    assert made.orders.splitlines() == [
        "order,release,from,via,to",
        "task 0,0,r0c1,,r2c0",
        "task 1,0,r2c1,r1c2,r0c3",
        "task 2,0,r1c3,,r1c3",
    ]
    assert remarks(made, "left out") == {("key", ("numTasksReveal",)), ("key", ("delayConfig",))}
    run = dw.simulate(model, seed=0)
    audit(run)
    assert run.kpis["tasks"] == 3
    assert [(row[1], row[4]) for row in run.record.rows if row[3] == 1 and row[1] in {"loaded", "delivered"}] == [
        ("loaded", "r2c1"),
        ("loaded", "r1c2"),  # the stop on the way
        ("delivered", "r0c3"),
    ]


def test_a_road_network_leads_one_way(tmp_path):
    made = import_layout(written(tmp_path, "round.grid", ROUND), robots=2)
    layout = made.model.layout
    assert layout.nodes["x0y0"] == (0, 1)  # y is upwards there
    edges = {(edge.source, edge.target) for edge in layout.edges}
    ring = ["x0y0", "x0y1", "x1y1", "x2y1", "x2y0", "x1y0", "x0y0"]
    assert edges == set(itertools.pairwise(ring))
    assert not layout.two_way
    assert [place.node for place in layout.storage] == ["x0y0"]
    assert layout.stations["Eject 9"].at == ("x2y0", "x2y1")
    assert ("weight", ("x1y1-x2y1",)) in remarks(made, "left out")
    audit(dw.simulate(made.model.replace({"run.length": 300})))


# Other ways to write them


@pytest.mark.parametrize(
    ("name", "text", "plain"),
    [
        ("crlf.map", MAP.replace("\n", "\r\n"), MAP),
        ("blanks.map", MAP.replace("\n", "  \n") + "\n\n", MAP),
        ("marked.map", "\ufeff" + MAP, MAP),
        ("upper.map", MAP.replace("type octile", "Type Octile").replace("height", "Height"), MAP),
        ("order.map", MAP.replace("height 3\nwidth 4", "width 4\nheight 3"), MAP),
        ("letters.map", MAP.replace("@", "O").replace("..", "G.", 1), MAP),
        ("no name", MAP, MAP),
        ("comma.map", KIVA.replace("5 8", "5,8"), KIVA),
        ("spaces.map", KIVA.replace("5 8", "5 , 8 ").replace("\n", " \r\n"), KIVA),
        ("kiva.txt", KIVA, KIVA),
        ("pretty.json", json.dumps(GGO, indent=4), json.dumps(GGO)),
        ("crlf.grid", ROUND.replace("\n", "\r\n"), ROUND),
        ("blanks.grid", ROUND.replace(",", ", "), ROUND),
    ],
)
def test_other_spellings_are_read_all_the_same(tmp_path, name, text, plain):
    plant, expected = read_plant(written(tmp_path, name, text)), read_plant(written(tmp_path, "plain", plain))
    assert list(plant.points) == list(expected.points)
    assert [(link.source, link.target) for link in plant.links] == [(one.source, one.target) for one in expected.links]
    assert [place.operations for place in plant.locations] == [place.operations for place in expected.locations]


@pytest.mark.parametrize(("height", "width"), [(1, 2), (2, 1), (40, 3), (7, 90)])
def test_grids_of_any_size_are_read(tmp_path, height, width):
    text = f"type octile\nheight {height}\nwidth {width}\nmap\n" + ("." * width + "\n") * height
    model = dw.read_layout(written(tmp_path, "open.map", text))
    assert len(model.layout.nodes) == height * width
    assert len(model.layout.edges) == height * (width - 1) + width * (height - 1)


def test_cells_that_cannot_be_reached_are_named(tmp_path):
    made = import_layout(written(tmp_path, "cut.map", "type octile\nheight 2\nwidth 4\nmap\n.@..\n.@..\n"))
    assert ("point", ("r0c0", "r1c0")) in remarks(made, "unreachable")
    assert made.model.layout.stations["anywhere"].at == ("r0c2", "r0c3", "r1c2", "r1c3")


def test_files_of_a_problem_may_lie_beside_it(tmp_path):
    path = problem(tmp_path)
    (tmp_path / "maps" / "yard.map").rename(tmp_path / "yard.map")
    assert len(read_plant(path).points) == 9


# Those of others


@needs_plants
@pytest.mark.parametrize(
    ("name", "free", "storage", "stations", "robots"),
    [
        ("ggo/kiva_small_r_mode_alternate_baseline_bi-directed.json", 320, 40, 40, 1),
        ("ggo/pibt_warehouse_33x36_w_mode.json", 948, 480, 22, 1),
        ("lorr/random-64-64-10.map", 3687, 3687, 3687, 1),
        ("lorr/random-example_400.json", 3687, 2189, 2169, 400),
    ],
)
def test_grids_of_others_load(name, free, storage, stations, robots):
    made = import_layout(plant_file(name))
    layout = made.model.layout
    assert len(layout.nodes) == free
    assert len(layout.storage) == storage
    assert sum(len(station.at) for station in layout.stations.values()) == stations
    assert made.model.fleet.size == robots
    assert all(edge.two_way for edge in layout.edges)
    assert nx.is_strongly_connected(build(layout).graph) or remarks(made, "unreachable")
    assert not remarks(made, "changed") - {("weight", ("weights",))}


@needs_plants
def test_the_preferred_directions_of_others_alternate():
    model = dw.read_layout(plant_file("ggo/kiva_small_r_mode_alternate_baseline_bi-directed.json"))
    assert {edge.against for edge in model.layout.edges} == {2}
    turns = {}
    for edge in model.layout.edges:
        (x0, y0), (x1, y1) = model.layout.nodes[edge.source], model.layout.nodes[edge.target]
        turns.setdefault(("row", y0) if y0 == y1 else ("column", x0), set()).add((x1 - x0, y1 - y0))
    assert all(len(ways) == 1 for ways in turns.values())
    assert all(turns["row", y] != turns["row", y + 1] for y in range(16))


@needs_plants
def test_tasks_of_others_are_tours():
    made = import_layout(plant_file("lorr/random-example_400.json"))
    lines = made.orders.splitlines()
    assert len(lines) == 1 + 3200
    assert lines[1] == "task 0,0,r26c53,r22c12,r4c33"  # 1717, 1420, 289 in rows of 64 cells


def test_cells_hold_a_robot_each(tmp_path):
    from desim_warehouse.layout.checks import room

    model = dw.read_layout(written(tmp_path, "small.map", KIVA))
    assert room(build(model.layout), model.fleet.contact) == len(model.layout.nodes) == 36
    thin = model.replace({"fleet.robot.radius": 0.25})  # two fit between neighbours: one more on each of 54 lanes
    assert room(build(thin.layout), thin.fleet.contact) == 54


# Large ones


@pytest.mark.long
def test_a_grid_of_fifty_thousand_cells_is_read_soon_and_in_little_memory(tmp_path):
    """Some 2.5 s of processor time and 240 MB; the limits leave room for slow machines."""
    begin = time.process_time()
    model = write(tmp_path, warehouse(70, 20))
    assert time.process_time() - begin < 15
    assert model.stat().st_size < 10_000  # readable: the layout stands beside it
    nodes, seconds, megabytes = reading(model)
    assert nodes == 54_445
    assert seconds < 8
    assert megabytes < 500
