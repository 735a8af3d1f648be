"""CSV that a spreadsheet opens: text is never taken for a formula."""

import csv
import io

import pandas as pd
import pytest

import desim_warehouse as dw
from desim_warehouse.report.export import export
from desim_warehouse.run.spreadsheet import as_csv
from tests.run.ring import ring


def read(text):
    return list(csv.reader(io.StringIO(text)))


@pytest.mark.parametrize("text", ["=1+1", "+1", "-A", "@SUM(A1)", "\t=1"])
def test_text_that_begins_like_a_formula_is_quoted(text):
    table = pd.DataFrame({text: [text, "A=B"]}, index=pd.Index([text, "B"], name="name"))
    assert read(as_csv(table, index=True)) == [["name", f"'{text}"], [f"'{text}", f"'{text}"], ["B", "A=B"]]


def test_numbers_and_empty_cells_stay_as_they_are():
    table = pd.DataFrame({"a": [-1.5, 2.0], "b": [-1, 3], "c": ["x", None], "d": [-2, "-2"]})
    assert read(as_csv(table)) == [["a", "b", "c", "d"], ["-1.5", "-1", "x", "-2"], ["2.0", "3", "", "'-2"]]


def test_no_table_of_a_run_holds_a_formula(tmp_path):
    """Its nodes are named by somebody who means harm."""
    model = ring({"capacity": 1000, "threshold": 10, "consumption": 1, "charge_rate": 10}, 200)
    names = {"A": "=cmd|'/c calc'!A1", "B": "+B", "C": "-C", "D": "@D"}
    floor = model["layout"]
    floor["nodes"] = {names[node]: place for node, place in floor["nodes"].items()}
    floor["edges"] = [[names[a], names[b]] for a, b in floor["edges"]]
    floor["storage"] = [{"edge": [names["A"], names["B"]], "offset": 10}]
    floor["bays"]["home"]["at"] = [names["A"]]
    model["tasks"]["unload_at"] = [names["C"]]
    run = dw.simulate(dw.load(model))
    run.save(tmp_path / "run")
    export(run, "csv", tmp_path / "csv")
    files = sorted(tmp_path.rglob("*.csv"))
    assert len(files) == 11
    cells = [cell for file in files for row in read(file.read_text()) for cell in row]
    assert f"'{names['A']}" in cells
    assert [cell for cell in cells if cell.startswith(("=", "+", "-", "@")) and not is_number(cell)] == []
    assert dw.load_run(tmp_path / "run").kpis == run.kpis


def is_number(cell):
    try:
        float(cell)
    except ValueError:
        return False
    return True
