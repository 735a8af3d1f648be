"""`desim import`: a foreign layout as a model file."""

from pathlib import Path

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim

YARD = str(Path(__file__).parents[1] / "plants" / "yard.xml")


def call(*arguments, **options):
    return CliRunner().invoke(desim, ["import", *arguments], catch_exceptions=False, **options)


def test_the_model_goes_to_standard_output_and_the_table_to_the_other(tmp_path):
    said = call(YARD)
    assert said.exit_code == 0
    (tmp_path / "model.yaml").write_text(said.stdout)
    assert dw.load(tmp_path / "model.yaml") == dw.read_layout(YARD)
    rows = [line.split() for line in said.stderr.splitlines()]
    assert [
        "unreachable",
        "1",
        "point",
        "robots",
        "cannot",
        "get",
        "there",
        "and",
        "back",
        "roof",
        "(line",
        "12)",
    ] in rows
    assert any(row[:2] == ["assumed", "run.length"] for row in rows)


def test_or_to_a_file_that_is_not_there_yet(tmp_path):
    path = tmp_path / "yard.yaml"
    said = call(YARD, "-o", str(path), "--fleet", "6", "--operation", "Weigh=unload")
    assert said.stdout.splitlines()[0] == f"{path}: 8 nodes, 8 edges, 2 stations, 6 robots"
    model = dw.load(path)
    assert model.fleet.size == 6
    assert set(model.layout.stations) == {"table 1", "scales"}
    with pytest.raises(dw.ModelError, match="the file exists; choose another name, or overwrite it with --force"):
        call(YARD, "-o", str(path))
    assert dw.load(path) == model
    assert call(YARD, "-o", str(path), "--force").exit_code == 0
    assert dw.load(path) == dw.read_layout(YARD)


def test_what_cannot_be_is_one_message(tmp_path):
    said = call(YARD, "--operation", "Weigh")
    assert said.exit_code == 2
    assert "expected NAME=WHAT such as 'Pack=unload'" in said.stderr
    with pytest.raises(dw.ModelError, match="no such file"):
        call(str(tmp_path / "none.xml"))
    with pytest.raises(dw.ModelError, match="cannot be written"):
        call(YARD, "-o", str(tmp_path / "none" / "model.yaml"))
