"""Logs of fleets: what is read, counted and refused."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from desim_warehouse.fleet_log import read_log
from desim_warehouse.fleet_log.runs import from_run
from desim_warehouse.fleet_log.table import ACTIONS, DROP, PICK

STANDARDS = Path(os.environ.get("DESIM_STANDARDS", "no such folder")) / "vda5050"


def message(second, robot="R1", node="A", **changes):
    return {
        "timestamp": f"2026-03-02T06:{second // 60:02}:{second % 60:02}Z",
        "serialNumber": robot,
        "lastNodeId": node,
        "driving": True,
        "actionStates": [],
        "batteryState": {"batteryCharge": 80.0, "charging": False},
        "errors": [],
        "loads": [],
        "agvPosition": {"x": float(second), "y": 0.0, "positionInitialized": True},
    } | changes


def log_of(folder, lines):
    path = folder / "log.jsonl"
    path.write_text("".join((line if isinstance(line, str) else json.dumps(line)) + "\n" for line in lines))
    return read_log(path)


def test_duplicates_late_messages_jumps_of_clocks_and_gaps_are_counted(tmp_path):
    seconds = [*range(20), 22, 21, 23, 23, 24, 100, *range(101, 110)]
    lines = [message(second) for second in seconds]
    lines.insert(5, message(4, timestamp="2031-01-01T00:00:00Z"))  # ahead for a moment
    lines.append(message(20, timestamp="2026-03-02T05:00:00Z"))  # an hour back
    log = log_of(tmp_path, lines)
    assert log.table["time"].tolist() == [*range(20), 21, 22, 23, 24, *range(100, 110)]
    assert (log.notes.duplicates, log.notes.late, log.notes.jumps, log.notes.gaps) == (1, 1, 2, 1)
    assert log.notes.missing == 75
    assert log.step == 1


def test_bad_rows_are_named_twenty_at_most(tmp_path):
    bad = [message(1, timestamp="yesterday"), {"serialNumber": "R1"}, "not JSON", *["{"] * 30]
    notes = log_of(tmp_path, [message(0), message(1), *bad]).notes
    assert (notes.rows, notes.bad, len(notes.problems)) == (35, 33, 20)
    assert "log.jsonl:3: timestamp: no time (got 'yesterday')" in notes.problems[0]
    assert "log.jsonl:4: no 'actionStates'" in notes.problems[1] or "log.jsonl:4: no 'errors'" in notes.problems[1]
    assert notes.lines()[20] == "and 13 more bad rows"


def test_a_log_without_a_good_row_is_refused(tmp_path):
    with pytest.raises(ReportError, match="no rows that can be read"):
        log_of(tmp_path, ["nothing"])


def test_what_robots_do_is_read_from_their_messages(tmp_path):
    def doing(kind, status="RUNNING"):
        return [{"actionId": "1", "actionType": kind, "actionStatus": status}]

    lines = [
        message(0, actionStates=doing("pick", "WAITING")),
        message(1, actionStates=doing("pick")),
        message(2, loads=[{}], errors=[{"errorType": "x", "errorLevel": "WARNING"}]),
        message(3, errors=[{"errorType": "x", "errorLevel": "FATAL"}]),
        message(4, batteryState={"batteryCharge": 12.5, "charging": True}),
        message(5, actionStates=doing("drop"), timestamp=1772431205000),
    ]
    table = log_of(tmp_path, lines).table
    assert [ACTIONS[code] for code in table["action"]] == ["", "pick", "", "", "charge", "drop"]
    assert table["load"].tolist() == [False, False, True, False, False, False]
    assert table["fault"].tolist() == [False, False, False, True, False, False]
    assert table["time"].tolist() == [0, 1, 2, 3, 4, 5]  # the last one in milliseconds since 1970


def test_where_no_message_has_loads_they_follow_from_the_actions(tmp_path):
    actions = ["", "pick", "pick", "", "", "drop", ""]
    lines = [message(second) for second in range(len(actions))]
    for line, kind in zip(lines, actions, strict=True):
        del line["loads"]
        line["actionStates"] = [{"actionId": "1", "actionType": kind, "actionStatus": "RUNNING"}] if kind else []
    assert log_of(tmp_path, lines).table["load"].tolist() == [False, False, False, True, True, True, False]


def test_trips_are_rows_at_both_ends(tmp_path):
    path = tmp_path / "trips.csv"
    path.write_text("robot,pick,drop,start,end\nR1,A,B,10,70\nR2,C,B,5,4\nR2,C,B,2026-01-01T00:00,x\nR2,A,B,20,50\n")
    log = read_log(path)
    assert log.table["time"].tolist() == [0, 60, 10, 40]
    assert log.table["action"].tolist() == [PICK, DROP, PICK, DROP]
    assert log.notes.problems[0].endswith("trips.csv:3: it ends before it starts (got '4')")
    assert log.notes.bad == 2
    path.write_text("robot,picks,drop,start,end\n")
    with pytest.raises(ReportError, match=r"no column 'pick'.*did you mean 'picks'"):
        read_log(path)


def test_a_run_written_as_messages_and_read_again_is_the_same(a_plant, tmp_path):
    a_plant.run.save(tmp_path / "run")
    here = from_run(a_plant.run)
    assert read_log(tmp_path / "run").table.equals(here.table)
    result = CliRunner().invoke(desim, ["export", str(tmp_path / "run"), "--format", "vda5050"])
    assert result.exit_code == 0, result.output
    again = read_log(tmp_path / "run" / "states.jsonl")
    assert len(again.table) == len(here.table)
    for name in ("driving", "load", "action", "fault"):
        assert again.table[name].to_numpy().tolist() == here.table[name].to_numpy().tolist(), name
    assert np.allclose(again.table["y"], -here.table["y"], atol=1e-4)  # the axes of the standard
    assert [again.nodes[n] for n in again.table["node"]] == [here.nodes[n] for n in here.table["node"]]
    options = ["--noise", "0.05", "--gaps", "4", "-o", str(tmp_path / "rough.jsonl")]
    CliRunner().invoke(desim, ["export", str(tmp_path / "run"), "--format", "vda5050", *options])
    rough = read_log(tmp_path / "rough.jsonl")
    assert rough.notes.gaps > 0
    assert 0.9 * len(here.table) < len(rough.table) < len(here.table)


def test_a_run_without_moves_cannot_be_exported(tmp_path, a_plant):
    run = dw.simulate(dw.load(a_plant.sheet, {"log": "tasks", "run.length": 600}))
    with pytest.raises(ReportError, match="log: all"):
        from_run(run)


@pytest.mark.skipif(not STANDARDS.is_dir(), reason="DESIM_STANDARDS names no folder with vda5050")
@pytest.mark.parametrize("version", ["2.0.0", "2.1.0"])
def test_messages_are_valid_by_the_schema_of_the_standard(a_plant, version):
    import jsonschema

    from desim_warehouse.fleet_log.vda5050 import messages

    text = (STANDARDS / f"state-{version}.schema").read_text(encoding="utf-8")
    schema = jsonschema.Draft202012Validator(YAML(typ="safe").load(text.replace("\t", " ")))  # it has trailing commas
    lines = [json.loads(line) for line in messages(a_plant.run, every=23.0)]
    assert {line["actionStates"][0]["actionType"] for line in lines if line["actionStates"]} >= {"pick", "drop"}
    assert any(line["errors"] for line in lines)
    assert [problem.message for line in lines for problem in schema.iter_errors(line)] == []
