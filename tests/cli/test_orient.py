"""`desim orient`: a model file with two-way lanes becomes one with Highways, comments and all."""

import json

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim

FLOOR = """\
name: two aisles and a dock   # a comment that stays
layout:
  nodes: {A: [0, 0], B: [10, 0], C: [20, 0], D: [0, 10], E: [10, 10], F: [20, 10], dock: [10, 15]}
  edges:
    - {from: A, to: B, two_way: true}
    - {from: B, to: C, two_way: true}
    - [D, E]
    - [E, D]
    - {from: E, to: F, two_way: true, speed: 1}
    - {from: A, to: D, two_way: true}
    - {from: B, to: E, two_way: true}
    - {from: C, to: F, two_way: true}
    - {from: E, to: dock, two_way: true}   # the only lane there
  storage:
    - {edge: [A, B], offset: 3}
    - {edge: [E, D], offset: 4}
    - {edge: [B, C], offset: 7, popularity: 2}
  bays: {home: {at: [A, C], places: 2}}
  stations: {pack: {at: [dock]}}
fleet: {size: 3, start: [home], robot: {radius: 0.3, speed: 2, margin: 0.1}}
tasks: {goods: {poisson: 60}, unload_at: [pack], load_time: 2, unload_time: 3}
units: {length: m, time: s}
run: {length: 3600}
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "two-way.yaml"
    path.write_text(FLOOR, encoding="utf-8")
    return path


def told(*words):
    done = CliRunner().invoke(desim, list(words))
    assert done.exit_code == 0, done.output
    return done.output


def test_a_floor_is_oriented_and_both_are_compared(file):
    out = file.with_name("one-way.yaml")
    text = told("orient", str(file), "-o", str(out), "--runs", "6")
    assert "7 two-way lanes are one-way now; trips between storage and stations are 1." in text
    assert "1 stay two-way, as they alone lead to what is beyond: E-dock" in text
    assert "mean cycle time of 3 runs each: one-way " in text
    assert "by pairs: two-way does better" in text
    model = dw.load(out)
    assert "# a comment that stays" in out.read_text(encoding="utf-8")
    assert dw.simulate(model).layout.two_way == [("E", "dock")]


def test_goods_stay_where_they_are(file):
    out = file.with_name("one-way.yaml")
    told("orient", str(file), "-o", str(out), "--runs", "0")
    before, after = (dw.simulate(dw.load(path)).layout for path in (file, out))
    assert len(after.graph.edges) == 7 + 2
    for old, new in zip(before.storage, after.storage, strict=True):
        assert new.edge in after.graph.edges
        assert before.position(old.edge, old.offset) == after.position(new.edge, new.offset)
        assert new.popularity == old.popularity


def test_places_at_nodes_of_a_storage_file_stay_there(file):
    file.with_name("places.csv").write_text("node,from,to,offset\nE,,,\n,A,B,3\n,E,D,4\n", encoding="utf-8")
    listed = FLOOR[FLOOR.index("  storage:") : FLOOR.index("  bays:")]
    file.write_text(FLOOR.replace(listed, "  storage: {file: places.csv}\n"), encoding="utf-8")
    out = file.with_name("one-way.yaml")
    told("orient", str(file), "-o", str(out), "--runs", "0")
    before, after = (dw.load(path).floor for path in (file, out))
    assert after.storage[0].edge == ("E", "E")
    for old, new in zip(before.storage, after.storage, strict=True):
        assert (old.x, old.y) == (new.x, new.y)


def test_a_model_is_oriented_in_python(file):
    model = dw.orient(dw.load(file))
    assert dw.simulate(model).layout.two_way == [("E", "dock")]


def test_no_file_is_lost_and_what_cannot_be_oriented_is_refused(file):
    def refused(*words):
        done = CliRunner().invoke(desim, list(words))
        assert isinstance(done.exception, dw.ModelError)
        return str(done.exception)

    assert "the file exists" in refused("orient", str(file), "-o", str(file))
    out = file.with_name("one-way.yaml")
    assert "no two-way lane" in refused("orient", "models/multibots.yaml", "-o", str(out))
    file.write_text(FLOOR.replace("    - {from: E, to: dock, two_way: true}", "    - [E, dock]"), encoding="utf-8")
    assert "node dock cannot be reached or left" in refused("orient", str(file), "-o", str(out))
    assert not out.exists()


def test_a_layout_file_is_oriented_into_one_beside_the_new_model(file):
    content = dw.load(file).content()
    layout = content.pop("layout")
    bays, stations = layout.pop("bays"), layout.pop("stations")
    file.with_name("floor.json").write_text(json.dumps(layout), encoding="utf-8")
    split = {**content, "layout": {"file": "floor.json", "bays": bays, "stations": stations}}
    file.with_name("split.yaml").write_text(json.dumps(split), encoding="utf-8")
    before = file.with_name("floor.json").read_bytes()
    for name in ("two-way", "split"):
        told("orient", str(file.with_name(f"{name}.yaml")), "-o", str(file.with_name(f"{name} 1.yaml")), "--runs", "0")
    assert dw.load(file.with_name("split 1.yaml")) == dw.load(file.with_name("two-way 1.yaml"))
    assert file.with_name("split 1.layout.json").exists()
    assert file.with_name("floor.json").read_bytes() == before


def test_preferred_directions_are_tried_and_the_best_floor_is_written(file):
    """Of 20 robots on these few lanes many meet head-on: 2 does best, and every lane but the bridge has it."""
    file.write_text(FLOOR.replace("size: 3", "size: 6").replace("places: 2", "places: 3"), encoding="utf-8")
    out = file.with_name("preferred.yaml")
    text = told("orient", str(file), "-o", str(out), "--runs", "8", "--prefer")
    lines = [line.split() for line in text.splitlines() if line.startswith("  ")]
    assert [line[0].strip(",") for line in lines] == ["two-way", "one-way", "preferred", "preferred"]
    [best] = [line for line in lines if line[-1] == "best"]
    means = [float(line[2 if line[0] == "preferred," else 1]) for line in lines]
    assert means[lines.index(best)] == min(means)
    assert ("is not written" in text) == (best[0] == "two-way") != out.exists()


@pytest.mark.parametrize("against", [1.5, 2.0])
def test_a_preferred_direction_is_that_of_orient_and_bridges_have_none(file, against):
    from desim_warehouse.model.oriented import orientation, oriented, oriented_files

    base = dw.load(file)
    directions = orientation(base)
    [(out, text)] = oriented_files(file, base, directions, file.with_name("preferred.yaml"), against).items()
    out.write_text(text, encoding="utf-8")
    model = dw.load(out)
    assert model.floor.graph.edges == base.floor.graph.edges
    counts = {edge: data.get("counts", 1) for edge, data in model.floor.graph.edges.items()}
    assert {edge for edge, count in counts.items() if count == against} == {lane[::-1] for lane in directions.kept}
    assert set(counts.values()) == {1, against}
    assert "# a comment that stays" in text
    assert oriented(base, directions, against).floor.graph.edges == model.floor.graph.edges
    assert model.layout.storage == base.layout.storage


def test_preferred_directions_are_chosen_by_runs(file):
    done = CliRunner().invoke(desim, ["orient", str(file), "-o", "x.yaml", "--runs", "0", "--prefer"])
    assert done.exit_code == 2
    assert "--prefer chooses by runs; expected --runs 4 or more" in done.output
