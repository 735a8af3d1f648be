"""Files, mappings and what messages call them."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from desim_warehouse.errors import ModelError
from desim_warehouse.model import load
from desim_warehouse.model.messages import dotted
from desim_warehouse.model.sections.fleet import Consumption
from desim_warehouse.model.sections.goods import Good, RandomGoods

MULTIBOTS = Path(__file__).parents[2] / "models" / "multibots.yaml"

SMALL = {
    "layout": {
        "blocks": {"columns": 2, "rows": 1, "block_depth": 2, "goods_size": 1, "aisle_width": 1},
        "bays": {"home": {"along": "north"}},
    },
    "fleet": {"size": 2, "robot": {"radius": 0.3, "speed": 1}},
    "tasks": {"goods": [0, 7], "unload_at": ["D"], "load_time": 5, "unload_time": 10},
}


def problems(source, overrides=None, **how):
    with pytest.raises(ModelError) as refused:
        load(source, overrides, **how)
    return refused.value.problems


def test_the_warehouse_of_the_paper_is_read_as_it_is_written():
    model = load(MULTIBOTS)
    assert (model.name, model.units.time, model.units.seconds) == ("MultiBots", "step", 0.05)
    assert model.layout.blocks.directions.columns == ("north", "south") * 3
    assert model.layout.bays["charging"].along == "north"
    assert (model.fleet.size, model.fleet.start) == (6, tuple("ABCDEF"))
    assert (model.fleet.robot.radius, model.fleet.robot.speed, model.fleet.robot.margin) == (12.5, 4, 8)
    assert model.tasks.goods == (11, 8, 39, 28, 53, 1, 69, 42, 79, 6)
    assert (model.tasks.unload_at, model.tasks.station_choice) == (("M",), "each")
    assert (model.battery.capacity, model.battery.threshold, model.battery.consumption) == (10, 3.5, 0.005)
    assert (model.traffic.collision_angle, model.traffic.node_time) == (30, 1.5)
    assert (model.policies.charging.name, dict(model.policies.charging.params)) == ("threshold", {})
    assert (model.cost.distance, model.cost.time, model.cost.collisions) == (1, 4, 100)


def test_a_path_and_its_name_give_the_same_model():
    assert load(str(MULTIBOTS)) == load(MULTIBOTS)


def test_sections_that_are_left_out_have_their_defaults():
    model = load(SMALL)
    assert (model.battery, model.run.length, model.log) == (None, None, "all")
    assert model.policies.routing.name == "highways"
    assert (model.layout.blocks.block_width, model.layout.blocks.directions) == (2, "ring")


def test_the_forms_of_a_key():
    model = load(
        SMALL,
        {
            "tasks.goods": [3, {"good": 5, "release": 2, "due": 9, "priority": 1}],
            "battery": {"capacity": 9, "threshold": 2, "charge_rate": 1},
            "battery.consumption": {"standing": 0, "empty": 1, "loaded": 2, "handling": 1},
        },
    )
    assert model.tasks.goods == (3, Good(good=5, release=2.0, due=9.0, priority=1))
    assert model.battery.consumption == Consumption(standing=0.0, empty=1.0, loaded=2.0, handling=1.0)
    assert load(SMALL, {"tasks.goods": {"random": 20}}).tasks.goods == RandomGoods(random=20)
    lifelong = load(SMALL, {"tasks.goods": {"poisson": 30, "due_within": 60}, "run.length": 3600})
    assert (lifelong.tasks.goods.poisson, lifelong.tasks.goods.due_within) == (30, 60)


def test_an_edge_may_be_written_short():
    layout = {
        "nodes": {"a": [0, 0], "b": [3, 4]},
        "edges": [["a", "b"], {"from": "b", "to": "a", "length": 9}],
        "storage": [{"edge": ["a", "b"], "offset": 4.5}],
    }
    model = load({**SMALL, "layout": layout}, {"tasks.goods": [0], "tasks.unload_at": ["b"]})
    assert [(edge.source, edge.target, edge.length) for edge in model.layout.edges] == [
        ("a", "b", None),
        ("b", "a", 9.0),
    ]
    assert list(model.layout.nodes) == ["a", "b"]


def test_words_that_yaml_once_took_for_truth_values_are_words(tmp_path):
    file = tmp_path / "words.yaml"
    file.write_text(
        "layout: {nodes: {N: [0, 0], no: [5, 0]}, edges: [[N, no], [no, N]],\n"
        "  storage: [{edge: [N, no], offset: 1}]}\n"
        "fleet: {size: 0o2, start: [N], robot: {radius: 1, speed: 1e1}}\n"
        "tasks: {goods: [0x0], unload_at: [no], load_time: 0, unload_time: 012}\n",
        encoding="utf-8",
    )
    model = load(file)
    assert (model.fleet.start, model.tasks.unload_at) == (("N",), ("no",))
    assert (model.fleet.size, model.fleet.robot.speed, model.tasks.unload_time) == (2, 10, 12)


def test_a_file_with_a_byte_order_mark_is_read(tmp_path):
    file = tmp_path / "bom.yaml"
    file.write_bytes(b"\xef\xbb\xbf" + MULTIBOTS.read_bytes())
    assert load(file) == load(MULTIBOTS)


def test_numbers_of_numpy_are_numbers():
    model = load(
        SMALL, {"fleet.size": np.int64(3), "tasks.goods": np.array([1, 2]), "traffic.node_time": np.float32(1.5)}
    )
    assert model == load(SMALL, {"fleet.size": 3, "tasks.goods": [1, 2], "traffic.node_time": 1.5})


def test_a_mapping_has_no_lines_but_its_order():
    bad = {**SMALL, "tasks": {**SMALL["tasks"], "load_time": -1, "goods": ["x"]}, "colour": "red"}
    assert problems(bad) == [
        (
            "<mapping>: tasks.goods.0: should be the number of a good, "
            "or a section with good, release, due, priority and to (got 'x')"
        ),
        "<mapping>: tasks.load_time: should be greater than or equal to 0 (got -1)",
        (
            "<mapping>: colour: unknown key, expected name, description, units, calendars, layout, fleet, "
            "tasks, pods, pickers, battery, traffic, people, policies, run, cost, prices, log or accept"
        ),
    ]


def test_what_no_file_can_hold_is_refused_in_a_mapping():
    bad = {**SMALL, "fleet": {**SMALL["fleet"], "start": {"A"}, 3: 4}}
    assert problems(bad) == [
        (
            "<mapping>: fleet.start: not a value a model file can have (got set), "
            "expected numbers, text, lists and mappings"
        ),
        "<mapping>: fleet.3: not a name (got 3), expected a name, in quotes",
    ]


def test_loading_leaves_the_mapping_as_it_is():
    source = {**SMALL, "policies": {"charging": "threshold"}}
    load(source, {"policies.charging.margin": 2, "fleet.robot.speed": 5})
    assert source["policies"] == {"charging": "threshold"}
    assert source["fleet"]["robot"]["speed"] == 1


def test_a_missing_file_is_said_with_the_one_probably_meant():
    wrong = MULTIBOTS.with_name("multibot.yaml")
    assert problems(wrong) == [f"{wrong}: no such file, expected a model file; did you mean '{MULTIBOTS}'?"]


def test_a_missing_file_unlike_any_other(tmp_path):
    assert problems(tmp_path / "x.yaml") == [f"{tmp_path / 'x.yaml'}: no such file, expected a model file"]


def test_a_directory_is_no_model(tmp_path):
    assert problems(tmp_path) == [f"{tmp_path}: cannot be read (Is a directory), expected a model file"]


def test_policies_are_asked_about_names_and_parameters(monkeypatch):
    model = load(SMALL, {"policies.charging": {"name": "thresold", "margin": -1}})

    def ask(kind, name, params):
        return [("", f"no {kind} policy {name}"), ("margin", f"got {params['margin']}")] if params else []

    monkeypatch.setattr("desim_warehouse.policies.catalogue.problems", ask)
    assert [(dotted(problem.keys), problem.text) for problem in model.policies.problems()] == [
        ("policies.charging", "no charging policy thresold"),
        ("policies.charging.margin", "got -1"),
    ]


def test_importing_the_schema_and_reading_needs_no_yaml_reader_yet():
    code = "import sys, desim_warehouse.model; print({'ruamel.yaml', 'pandas', 'scipy'} & set(sys.modules))"
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def test_the_name_of_a_station_or_bay_stands_for_its_nodes():
    zones = {
        "layout.bays.home": {"along": "north", "every": 2},
        "layout.stations": {"pack": {"along": "south"}, "A": {"at": ["A"]}},
        "tasks.station_choice": "nearest",
    }
    named = load(SMALL, {**zones, "fleet.start": ["home"], "tasks.unload_at": ["pack", "A"]})
    assert named.fleet.start == ("A", "C")
    assert named.tasks.unload_at == ("D", "E", "F", "A")
    assert load(named.content()) == named
    assert problems(SMALL, {**zones, "tasks.unload_at": ["pak"]}) == [
        (
            "override tasks.unload_at.0: no such node or station (got 'pak'), "
            "expected one of A, B, C, D, E or F, or station pack or A; did you mean 'pack'?"
        )
    ]


def test_a_bay_or_station_has_no_name_that_means_another_node():
    """Blocks call their nodes A to F, so flows to the station A at D would be unloaded in the lane at node A."""
    changes = {
        "layout.bays": {"A": {"at": ["A"]}, "B": {"at": ["B", "C"]}},
        "layout.stations": {"A": {"at": ["D"]}, "C": {"at": ["C", "E"]}, "E": {"at": ["F"]}, "pack": {"at": ["B"]}},
    }
    assert problems(SMALL, changes) == [
        f"override layout.{kind}s.{name}: two meanings: node {name}, and the {kind} at {at}, expected another name"
        for kind, name, at in (
            ("bay", "B", "B, C"),
            ("station", "A", "D"),
            ("station", "C", "C, E"),
            ("station", "E", "F"),
        )
    ]


def test_flows_to_storage_mean_the_shelves_and_nothing_else_of_this_name():
    floor = {
        "nodes": {"dock": [0, 0], "storage": [9, 0], "belt": [9, 9]},
        "edges": [["dock", "storage"], ["storage", "belt"], ["belt", "dock"]],
        "storage": [{"edge": ["dock", "storage"], "offset": 4}],
        "bays": {"home": {"at": ["dock"]}},
        "stations": {"storage": {"at": ["storage"]}},
    }
    flow = {"from": "dock", "to": "storage", "arrivals": {"poisson": 10}}
    tasks = {"flows": {"goods in": flow}, "load_time": 5, "unload_time": 5}
    model = {**SMALL, "layout": floor, "tasks": tasks, "run": {"length": 9}}
    meant = "two meanings: any storage place, in flows, and this"
    assert problems(model) == [f"<mapping>: layout.nodes.storage: {meant} node, expected another name"]
    bench = {"layout": {**SMALL["layout"], "stations": {"storage": {"at": ["D"]}}}}
    assert problems({**model, **bench, "tasks": {**tasks, "flows": {"goods in": {**flow, "from": "E"}}}}) == [
        f"<mapping>: layout.stations.storage: {meant} station, expected another name"
    ]


def test_sides_of_a_drawn_layout_are_told_by_the_outermost_nodes():
    layout = {
        "nodes": {"a": [0, 0], "b": [9, 0], "c": [9, 9], "d": [0, 9]},
        "edges": [["a", "b"], ["b", "c"], ["c", "d"], ["d", "a"]],
        "storage": [{"edge": ["a", "b"], "offset": 4.5}],
        "bays": {"home": {"at": ["a"]}},
        "stations": {"east": {"along": "east"}, "south": {"along": "south"}},
    }
    changes = {"tasks.goods": [0], "tasks.unload_at": ["east", "south"], "tasks.station_choice": "nearest"}
    assert load({**SMALL, "layout": layout}, changes).tasks.unload_at == ("b", "c", "d", "c")


def test_problems_of_one_section_do_not_hide_those_of_another():
    bad = {
        "layout.blocks.goods_size": -1,
        "fleet.start": ["Q"],
        "fleet.robot.speed": "fast",
        "tasks.goods": [0, 99],
        "tasks.load_time": -1,
        "tasks.unload_at": ["Z"],
        "run": {"length": 5, "warm_up": 6},
    }
    assert [line.partition(": ")[0].removeprefix("override ") for line in problems(SMALL, bad)] == [
        "fleet.robot.speed",
        "fleet.start.0",
        "layout.blocks.goods_size",
        "run.warm_up",
        "tasks.goods.1",
        "tasks.load_time",
        "tasks.unload_at.0",
    ]


def test_a_mistake_in_a_station_is_one_problem_where_its_name_is_used():
    layout = {**SMALL["layout"], "stations": {"packing": {"at": ["D"], "servers": 0}}}
    bays = {"home": {"along": "north", "places": 0}}
    bad = {**SMALL, "layout": layout, "tasks": {**SMALL["tasks"], "unload_at": ["packing"]}}
    assert problems(bad) == ["<mapping>: layout.stations.packing.servers: should be greater than or equal to 1 (got 0)"]
    bad = {**SMALL, "layout": {**layout, "stations": {}, "bays": bays}, "fleet": {**SMALL["fleet"], "start": ["home"]}}
    assert problems(bad) == ["<mapping>: layout.bays.home.places: should be greater than or equal to 1 (got 0)"]


def test_a_key_of_another_form_says_where_it_belongs():
    """`did you mean` the key itself is no help."""
    bad = {**SMALL, "tasks": {**SMALL["tasks"], "goods": {"saturated": 3, "hours": "day"}}}
    assert problems(bad, {"run.length": 100}) == [
        "<mapping>: tasks.goods.hours: not in this form, expected only in a section with poisson"
    ]
