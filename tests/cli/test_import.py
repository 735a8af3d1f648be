"""`desim import`: a foreign layout as a model file."""

from pathlib import Path

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from tests.plants.drawn_lif import dock, write
from tests.plants.grids import KIVA
from tests.plants.test_orders import ORDERS, WEIGH

YARD = str(Path(__file__).parents[1] / "plants" / "yard.xml")


def call(*arguments, **options):
    return CliRunner().invoke(desim, ["import", *arguments], catch_exceptions=False, **options)


def test_the_model_goes_to_standard_output_and_the_table_to_the_other(tmp_path):
    done = call(YARD)
    assert done.exit_code == 0
    (tmp_path / "model.yaml").write_text(done.stdout)
    assert dw.load(tmp_path / "model.yaml") == dw.read_layout(YARD)
    rows = [" ".join(line.split()) for line in done.stderr.splitlines()]
    assert "unreachable 1 point robots cannot get there and back: roof (line 12)" in rows
    assert any(row.startswith("assumed run.length") for row in rows)
    assert max(map(len, done.stderr.splitlines())) <= 100


def test_or_to_a_file_that_is_not_there_yet(tmp_path):
    path = tmp_path / "yard.yaml"
    output = call(YARD, "-o", str(path), "--fleet", "6", "--operation", "Weigh=unload").stdout
    assert output.splitlines()[0] == f"{path}: 8 nodes, 8 edges, 17 x 20 m, 2 stations, 6 robots"
    model = dw.load(path)
    assert model.fleet.size == 6
    assert set(model.layout.stations) == {"table 1", "scales"}
    with pytest.raises(dw.ModelError, match="the file exists; choose another name, or overwrite it with --force"):
        call(YARD, "-o", str(path))
    assert dw.load(path) == model
    assert call(YARD, "-o", str(path), "--force").exit_code == 0
    assert dw.load(path) == dw.read_layout(YARD)


def test_what_cannot_be_is_one_message(tmp_path):
    done = call(YARD, "--operation", "Weigh")
    assert done.exit_code == 2
    assert "expected NAME=WHAT such as 'Pack=unload'" in done.stderr
    with pytest.raises(dw.ModelError, match="no such file"):
        call(str(tmp_path / "none.xml"))
    with pytest.raises(dw.ModelError, match="cannot be written"):
        call(YARD, "-o", str(tmp_path / "none" / "model.yaml"))


def test_a_grid_is_written_with_its_orders_beside_it(tmp_path):
    grid, tasks, out = tmp_path / "small.map", tmp_path / "many.task", tmp_path / "small.yaml"
    grid.write_text(KIVA)
    tasks.write_text("\n".join(["501", *(f"0 {rank % 8} {(rank + 3) % 8}" for rank in range(501))]))
    words = ["import", str(grid), "--tasks", str(tasks), "--cell", "1.5"]
    done = CliRunner().invoke(desim, words)
    assert done.exit_code == 2
    assert "the tasks of this file are written beside the model; name one with -o" in done.output
    done = CliRunner().invoke(desim, [*words, "-o", str(out)])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "small.orders.csv").read_text().count("\n") == 502
    assert dw.load(out).layout.nodes["r0c2"] == (3, 0)
    before = out.read_text()
    done = CliRunner().invoke(desim, [*words, "-o", str(tmp_path / "other.yaml")])
    assert done.exit_code == 0
    (tmp_path / "other.yaml").unlink()
    done = CliRunner().invoke(desim, [*words, "-o", str(tmp_path / "other.yaml")])
    assert done.exit_code != 0  # its orders are there
    assert not (tmp_path / "other.yaml").exists()
    assert out.read_text() == before


def test_options_of_a_format_are_refused_for_others(tmp_path):
    path = str(write(tmp_path / "dock.lif.json", dock()))
    out = str(tmp_path / "dock.yaml")
    output = call(
        path, "-o", out, "--vehicle-type", "forklift", "--layout", "ground", "--strict", "--fleet", "2"
    ).stdout
    assert output.splitlines()[0] == f"{out}: 7 nodes, 7 edges, 21 x 8 m, 1 station, 2 robots"
    with pytest.raises(dw.ModelError, match="option 'strict': there is none for a plant model of openTCS"):
        call(YARD, "--strict")
    with pytest.raises(dw.ModelError, match="no layout 'attic'"):
        call(path, "--layout", "attic")


def test_robots_and_tasks_from_files(tmp_path):
    robot, tasks, out = tmp_path / "robot.yaml", tmp_path / "orders.xml", tmp_path / "yard.yaml"
    robot.write_text("robot: {radius: 0.4, speed: 1.2}")
    tasks.write_text(ORDERS.replace(WEIGH, ""))
    call(YARD, "-o", str(out), "--robot", str(robot), "--tasks", str(tasks))
    model = dw.load(out)
    assert (model.fleet.robot.radius, len(model.tasks.goods)) == (0.4, 3)
