"""Layouts of models for other programs: a small floor, worked out by hand, and the schemas of others where they are."""

import csv
import json
from pathlib import Path
from xml.etree import ElementTree as ET

import jsonschema
import networkx as nx
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.plants import import_layout
from tests.plants.foreign import needs_plants, plant_file
from tests.world.test_hours import SQUARE

MODELS = Path(__file__).parents[2] / "models"
FLOOR = {
    "name": "floor",
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [10, 8], "D": [0, 8], "P": [14, 8]},
        "edges": [
            {"from": "A", "to": "B", "speed": 1.2},
            {"from": "B", "to": "C", "length": 9},
            ["C", "D"],
            ["D", "A"],
            {"from": "C", "to": "P", "two_way": True, "speed": 0.5, "against": 2},
        ],
        "storage": [
            {"edge": ["A", "B"], "offset": 4},
            {"edge": ["A", "B"], "offset": 4, "popularity": 3},
            {"edge": ["P", "C"], "offset": 2},
            {"node": "D"},
        ],
        "stations": {"table": {"at": ["P"], "places": 2, "servers": 2}},
        "bays": {"dock": {"at": ["A"], "places": 3, "chargers": 1}, "yard": {"at": ["D"], "places": 2, "chargers": 0}},
    },
    "fleet": {"size": 2, "robot": {"radius": 0.4, "speed": 1.5, "margin": 0.1}},
    "tasks": {"goods": {"random": 4}, "unload_at": ["table"], "load_time": 5, "unload_time": 5},
    "battery": {"capacity": 100, "threshold": 20, "consumption": 0.01, "charge_rate": 0.1},
    "traffic": {"zones": {"mouth": {"members": [["P", "C"]], "rule": "one-direction"}}, "node_time": 1},
    "policies": {"routing": "fastest"},
}


@pytest.fixture
def floor():
    return dw.load(FLOOR)


def lost(remarks):
    return {(one.what, one.kind): one.names for one in remarks}


def test_a_floor_is_written_as_two_tables(floor, tmp_path):
    remarks = lost(dw.write_layout(floor, tmp_path / "floor", "csv"))
    nodes, edges = (
        list(csv.DictReader((tmp_path / "floor" / name).read_text().splitlines()))
        for name in ("nodes.csv", "edges.csv")
    )
    assert [list(row.values()) for row in nodes] == [
        ["A", "0.0", "0.0", "charge", ""],
        ["B", "10.0", "0.0", "", ""],
        ["C", "10.0", "8.0", "", ""],
        ["D", "0.0", "8.0", "park + load", ""],
        ["P", "14.0", "8.0", "unload", "table"],
        ["A-B 4", "4.0", "0.0", "load", ""],
        ["C-P 2", "12.0", "8.0", "load", ""],
    ]
    assert [list(row.values()) for row in edges] == [
        ["A", "A-B 4", "", "1.2", "", ""],
        ["A-B 4", "B", "", "1.2", "", ""],
        ["B", "C", "9.0", "", "", ""],
        ["C", "D", "", "", "", ""],
        ["C", "C-P 2", "", "0.5", "yes", ""],
        ["C-P 2", "P", "", "0.5", "yes", ""],
        ["D", "A", "", "", "", ""],
    ]
    assert remarks == {
        ("changed", "point"): ("A-B 4", "C-P 2"),
        ("changed", "place"): ("A-B 4",),
        ("left out", "popularity"): ("1",),
        ("left out", "station"): ("table",),
        ("left out", "bay"): ("dock", "yard"),
        ("left out", "preferred direction"): ("P>C",),
        ("left out", "section"): (
            "tasks",
            "battery",
            "policies",
            "traffic (but zones)",
            "fleet (but size, radius and speed of robots)",
        ),
        ("left out", "vehicle"): ("robot 1", "robot 2"),
        ("left out", "zone"): ("mouth",),
    }


def test_what_goes_wrong_and_when_is_named_as_lost(tmp_path):
    """No format has calendars, people, or robots that gather speed."""
    over = {
        "calendars": {"day": {"open": ["06:00-22:00"]}},
        "people": {"pickers": {"per_hour": 6, "stay": 30}},
        "fleet.robot.acceleration": 0.5,
    }
    remarks = lost(dw.write_layout(dw.load(SQUARE, over), tmp_path / "floor.lif.json", "lif"))
    assert remarks["left out", "section"] == (
        "calendars",
        "tasks",
        "people",
        "fleet (but size, radius and speed of robots)",
    )


def test_a_graph_that_networkx_reads(floor, tmp_path):
    dw.write_layout(floor, tmp_path / "floor.graphml", "graphml")
    graph = nx.read_graphml(tmp_path / "floor.graphml")
    assert graph.is_directed()
    assert graph.nodes["P"] == {"x": 14, "y": 8, "role": "unload", "station": "table"}
    assert graph.edges["B", "C"] == {"length": 9}
    assert graph.edges["C", "C-P 2"] == graph.edges["C-P 2", "C"] == {"speed": 0.5}


def test_a_plant_model_of_opentcs(floor, tmp_path):
    remarks = lost(dw.write_layout(floor, tmp_path / "floor.xml", "opentcs"))
    root = ET.fromstring((tmp_path / "floor.xml").read_bytes())  # noqa: S314 - written a line above
    points = {
        one.get("name"): (one.get("positionX"), one.get("positionY"), one.get("type")) for one in root.iter("point")
    }
    assert points["P"] == ("14000", "-8000", "HALT_POSITION")
    assert points["D"] == ("0", "-8000", "PARK_POSITION")
    paths = {
        one.get("name"): tuple(one.get(key) for key in ("length", "maxVelocity", "maxReverseVelocity"))
        for one in root.iter("path")
    }
    assert paths["B>C"] == ("9000", "1500", "0")
    assert paths["C>C-P 2"] == ("2000", "500", "500")
    assert remarks["changed", "path"] == ("B>C", "C>D", "D>A")
    assert [one.get("energyLevelCritical") for one in root.iter("vehicle")] == ["20", "20"]
    assert [one.get("name") for one in root.find("block").iter("member")] == ["C>C-P 2", "C-P 2", "C-P 2>P"]
    made = import_layout(tmp_path / "floor.xml")
    assert made.model.traffic.zones["mouth"].rule == "one-direction"
    assert (made.model.fleet.size, made.model.fleet.robot.radius) == (2, 0.4)
    assert set(made.model.layout.stations) == {"table"}


def test_a_floor_is_written_as_lif(floor, tmp_path):
    remarks = lost(dw.write_layout(floor, tmp_path / "floor.lif", "lif"))
    data = json.loads((tmp_path / "floor.lif").read_text())
    assert data["metaInformation"]["lifVersion"] == "1.0.0"
    [layout] = data["layouts"]
    nodes = {node["nodeId"]: node for node in layout["nodes"]}
    assert nodes["P"]["nodePosition"] == {"x": 14, "y": -8}
    [properties] = nodes["P"]["vehicleTypeNodeProperties"]
    assert [action["actionType"] for action in properties["actions"]] == ["drop"]
    edges = {(edge["startNodeId"], edge["endNodeId"]) for edge in layout["edges"]}
    assert {("P", "C-P 2"), ("C-P 2", "P"), ("A", "A-B 4")} <= edges
    assert len(edges) == len(layout["edges"]) == 9
    assert {one["stationId"]: one["interactionNodeIds"] for one in layout["stations"]}["table"] == ["P"]
    assert remarks["changed", "lane"] == ("B>C",)


@needs_plants
def test_what_is_written_is_valid_by_the_schema_of_vdma(floor, tmp_path):
    schema = json.loads(plant_file("lif-vdma/LIF.schema").read_text())
    for model in (floor, dw.load(MODELS / "medium.yaml")):
        dw.write_layout(model, tmp_path / "floor.lif", "lif")
        jsonschema.validate(json.loads((tmp_path / "floor.lif").read_text()), schema)
        assert len(import_layout(tmp_path / "floor.lif", strict=True).plant.points) > 5


@needs_plants
def test_what_is_written_is_valid_by_the_schema_of_opentcs(floor, tmp_path):
    schema = pytest.importorskip("xmlschema").XMLSchema(str(plant_file("opentcs/model-7.0.0.xsd")))
    for model in (floor, dw.load(MODELS / "multibots.yaml")):
        dw.write_layout(model, tmp_path / "floor.xml", "opentcs")
        schema.validate(str(tmp_path / "floor.xml"))


@pytest.mark.parametrize("form", ["csv", "graphml", "opentcs", "lif"])
def test_names_that_files_cannot_hold_are_changed_and_said(floor, form, tmp_path):
    text = json.dumps(floor.content())
    for old, new in (('"A"', '"A\\n1"'), ('"B"', '" B"'), ('"C"', '"\\uffff"')):
        text = text.replace(old, new)
    path = tmp_path / f"out.{form}"
    remarks = lost(dw.write_layout(dw.load(json.loads(text)), path, form))
    assert remarks["changed", "name"][:3] == ("A 1 from 'A\\n1'", "B from ' B'", "unnamed from '\\uffff'")
    assert {"A 1", "B", "unnamed", "D", "P"} <= set(dw.read_layout(path).layout.nodes)


def test_a_name_twice_gets_a_number_where_it_must(floor, tmp_path):
    model = floor.replace({"layout.stations": {"D": {"at": ["D"]}}, "tasks.unload_at": ["D"]})
    remarks = lost(dw.write_layout(model, tmp_path / "floor.xml", "opentcs"))
    assert remarks["changed", "name"] == ("location D",)
    assert set(dw.read_layout(tmp_path / "floor.xml").layout.stations) == {"D (2)"}


def test_other_units_become_metres_and_seconds(floor, tmp_path):
    content = {**floor.content(), "units": {"length": "cm", "time": "min", "seconds": 60}}
    for edge in content["layout"]["edges"]:
        edge["speed"] = 150 if edge.get("speed") else None
    dw.write_layout(dw.load(content), tmp_path / "floor", "csv")
    model = dw.read_layout(tmp_path / "floor")
    assert model.layout.nodes["P"] == (0.14, 0.08)
    assert {edge.speed for edge in model.layout.edges} == {None, 0.025}
    unknown = dw.load({**floor.content(), "units": {"length": "cells", "time": "s"}})
    assert lost(dw.write_layout(unknown, tmp_path / "cells", "csv"))["changed", "unit"] == ("cells",)


# The command


def call(*arguments):
    return CliRunner().invoke(desim, ["export", *map(str, arguments)], catch_exceptions=False)


@pytest.fixture
def file(floor, tmp_path):
    path = tmp_path / "floor.yaml"
    path.write_text(json.dumps(floor.content()))
    return path


def test_the_command_says_what_is_lost(file):
    done = call(file, "--format", "lif")
    assert done.stdout.splitlines()[0] == str(file.with_suffix(".lif"))
    assert any(line.split()[:4] == ["left", "out", "2", "vehicles"] for line in done.stdout.splitlines())
    with pytest.raises(dw.ReportError, match=r"floor\.lif: the file exists; choose another name with -o, or overwrite"):
        call(file, "--format", "lif")
    assert call(file, "--format", "lif", "--force").exit_code == 0


def test_a_folder_of_tables_and_a_picture(file, tmp_path):
    assert call(file, "--format", "csv").stdout.splitlines()[0] == str(tmp_path / "floor")
    assert sorted(path.name for path in (tmp_path / "floor").iterdir()) == ["edges.csv", "nodes.csv"]
    with pytest.raises(dw.ReportError, match=r"nodes\.csv: the file exists"):
        call(file, "--format", "csv")
    call(file, "--format", "svg", "-o", tmp_path / "floor.svg")
    assert "<svg" in (tmp_path / "floor.svg").read_text()


def test_a_run_knows_its_model(floor, tmp_path):
    dw.simulate(floor).save(tmp_path / "run")
    assert call(tmp_path / "run", "--format", "opentcs").stdout.splitlines()[0] == str(tmp_path / "run" / "layout.xml")
    assert call(tmp_path / "run", "--format", "csv").stdout == f"{tmp_path / 'run' / 'csv'}\n"


def test_what_cannot_be_written_is_one_message(floor, file, tmp_path):
    with pytest.raises(
        dw.ReportError, match="format 'lff': expected one of lif, opentcs, graphml, csv, rmf; did you mean"
    ):
        dw.write_layout(floor, tmp_path / "x", "lff")
    with pytest.raises(dw.ReportError, match="cannot be written"):
        dw.write_layout(floor, file / "x", "lif")
    with pytest.raises(dw.WarehouseError, match="no run can be read there"):
        call(file, "--format", "trace")
    with pytest.raises(dw.ModelError, match="no such file"):
        call(tmp_path / "none.yaml", "--format", "lif")
