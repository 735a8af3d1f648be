"""Weights and storage places from CSV files beside the model file."""

import json

import pytest

from desim_warehouse.errors import ModelError
from desim_warehouse.model import load

MODEL = """
layout:
  nodes: {dock: [0, 0], gate: [10, 0], rack: [10, 5]}
  edges: [[dock, gate], [gate, rack], [rack, dock]]
  storage: {file: storage.csv}
  bays: {home: {at: [dock]}}
fleet: {size: 1, robot: {radius: 0.3, speed: 1}}
tasks: {goods: {random: 5}, popularity: layout, unload_at: [gate], load_time: 5, unload_time: 10}
"""
STORAGE = "to,from,offset,popularity,remark\ngate,dock,2.5,3,by the door\nrack, gate ,4,0.5,\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "model.yaml").write_text(MODEL, encoding="utf-8")
    (tmp_path / "storage.csv").write_text(STORAGE, encoding="utf-8")
    (tmp_path / "demand.csv").write_text("week,popularity\n3,1.5\n9,0\n", encoding="utf-8-sig")
    return tmp_path


def test_storage_places_are_read_by_their_columns(folder):
    places = load(folder / "model.yaml").layout.storage
    assert [(place.edge, place.offset, place.popularity) for place in places] == [
        (("dock", "gate"), 2.5, 3.0),
        (("gate", "rack"), 4.0, 0.5),
    ]


def test_weights_are_read_from_the_named_column(folder):
    model = load(folder / "model.yaml", {"tasks.popularity": {"file": "demand.csv", "column": "week"}})
    assert model.tasks.popularity.weights == (3.0, 9.0)


def test_weights_are_read_from_the_column_popularity_if_none_is_named(folder):
    model = load(folder / "model.yaml", {"tasks.popularity": {"file": "demand.csv"}})
    assert model.tasks.popularity.weights == (1.5, 0.0)


def test_weights_belong_to_the_places_that_their_table_names(folder):
    """A list of picks that is sorted by picks, as analyses of fast movers are."""
    (folder / "picks.csv").write_text("place,picks\n1,90\n0,10\n")
    model = load(folder / "model.yaml", {"tasks.popularity": {"file": "picks.csv", "column": "picks"}})
    assert model.tasks.popularity.weights == (10.0, 90.0)


@pytest.mark.parametrize("places", [("R1", "R2"), ("1", "2"), ("1", "1"), ("0.5", "1"), ("", "1")])
def test_weights_of_places_that_are_no_numbers_from_0_are_refused(folder, places):
    (folder / "picks.csv").write_text(f"place,picks\n{places[0]},90\n{places[1]},10\n")
    with pytest.raises(ModelError) as refused:
        load(folder / "model.yaml", {"tasks.popularity": {"file": "picks.csv", "column": "picks"}})
    (problem,) = refused.value.problems
    line = 3 if places[0] == "1" else 2
    assert f"no number of a storage place, or a second time (got {folder / 'picks.csv'}:{line}:1), expected" in problem
    assert problem.endswith("all numbers from 0 to 1 in column 'place', or no such column")


def test_the_model_is_complete_without_its_tables(folder):
    model = load(folder / "model.yaml")
    (folder / "storage.csv").unlink()
    assert load(model.content()) == model
    assert model.replace({"fleet.size": 2}).layout == model.layout


def test_tables_of_a_mapping_are_looked_for_in_the_working_directory(folder, monkeypatch):
    model = load(folder / "model.yaml")
    monkeypatch.chdir(folder)
    assert (
        load({**model.content(), "layout": {**model.content()["layout"], "storage": {"file": "storage.csv"}}}) == model
    )


def test_a_place_beyond_its_edge_is_named_by_its_line_in_the_table(folder):
    (folder / "storage.csv").write_text(STORAGE.replace("2.5", "12.5"), encoding="utf-8")
    with pytest.raises(ModelError) as refused:
        load(folder / "model.yaml")
    assert refused.value.problems == [
        (
            f"{folder / 'storage.csv'}:2:11: layout.storage.0.offset: beyond the end of its edge (got 12.5), "
            "expected an offset below the edge's length, 10"
        )
    ]


def test_storage_places_at_nodes_have_a_column_of_their_own(folder):
    (folder / "storage.csv").write_text("node,popularity\nrack,2\ngate,1\n", encoding="utf-8")
    model = load(folder / "model.yaml")
    assert [(place.node, place.popularity) for place in model.layout.storage] == [("rack", 2), ("gate", 1)]


def test_rows_of_a_table_are_on_edges_or_at_nodes(folder):
    (folder / "storage.csv").write_text("from,to,offset,node\ndock,gate,2.5,\n,,,rack\n,,3,rock\n", encoding="utf-8")
    with pytest.raises(ModelError, match=r"storage.csv:4.*offset beside node"):
        load(folder / "model.yaml")
    (folder / "storage.csv").write_text("from,to,offset,node\ndock,gate,2.5,\n,,,rack\n", encoding="utf-8")
    assert [item.content() for item in load(folder / "model.yaml").layout.storage] == [
        {"edge": ["dock", "gate"], "offset": 2.5, "popularity": 1},
        {"node": "rack", "popularity": 1},
    ]


# The layout in a file of its own

BESIDE = """
layout: {file: floor.json, bays: {home: {at: [dock]}}}
fleet: {size: 1, robot: {radius: 0.3, speed: 1}}
tasks: {goods: {random: 5}, unload_at: [gate], load_time: 5, unload_time: 10}
"""
FLOOR = {
    "nodes": {"dock": [0, 0], "gate": [10, 0], "rack": [10, 5]},
    "edges": [["dock", "gate"], {"from": "gate", "to": "rack"}, ["rack", "dock"]],
    "storage": [{"node": "rack"}],
}


@pytest.fixture
def beside(tmp_path):
    (tmp_path / "model.yaml").write_text(BESIDE, encoding="utf-8")
    (tmp_path / "floor.json").write_text(json.dumps(FLOOR), encoding="utf-8")
    return tmp_path


def test_a_layout_in_a_file_of_its_own_is_the_same_layout(beside):
    model = load(beside / "model.yaml")
    content = model.content()
    assert content["layout"].keys() == load(MODEL_INLINE).content()["layout"].keys()
    assert model.digest() == load(MODEL_INLINE).digest()
    (beside / "floor.json").unlink()
    assert load(content) == model


MODEL_INLINE = {
    "layout": {**FLOOR, "bays": {"home": {"at": ["dock"]}}},
    "fleet": {"size": 1, "robot": {"radius": 0.3, "speed": 1}},
    "tasks": {"goods": {"random": 5}, "unload_at": ["gate"], "load_time": 5, "unload_time": 10},
}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"nodes": {"dock": [0, 0]', ":1:26: not JSON (expecting ',' delimiter)"),
        ("[1]", "floor.json: not a section (got [1]), expected a JSON file with keys of the layout section"),
        ('{"nodes": {"dock": [0, 0], "dock": [1, 1]}}', "nodes: key 'dock' given twice, expected once"),
        ('{"nodes": {"dock": [0, NaN]}}', "nodes.dock[1]: not a number (got NaN)"),
        ("[" * 100_000, "too many lists or objects inside one another"),
        (
            '{"bays": {"away": {"at": ["dock"]}}}',
            "has bays, which stands beside it, too, expected it in one of the two",
        ),
        ('{"file": "floor.json"}', "floor.json' names a file itself"),
        (json.dumps({**FLOOR, "edges": [["dock", "gat"]]}), "floor.json: layout.edges.0.to: no such node (got 'gat')"),
        (json.dumps({**FLOOR, "node": {}}), "floor.json: layout.node: unknown key, did you mean 'layout.nodes'?"),
    ],
    ids=lambda text: text[:20],
)
def test_a_wrong_layout_file_gives_one_message(beside, text, message):
    (beside / "floor.json").write_text(text, encoding="utf-8")
    with pytest.raises(ModelError) as refused:
        load(beside / "model.yaml")
    (line,) = refused.value.problems
    assert message in line
    assert "floor.json" in line


def test_a_missing_layout_file_is_named(beside):
    (beside / "floor.json").unlink()
    with pytest.raises(ModelError) as refused:
        load(beside / "model.yaml")
    (line,) = refused.value.problems
    assert "model.yaml:2:16: layout.file: cannot be read (got '" in line
    assert "No such file" in line
