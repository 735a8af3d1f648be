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
    assert "log.jsonl:3: timestamp: no time from 1970 to 2099 (got 'yesterday')" in notes.problems[0]
    assert "log.jsonl:4: no 'timestamp', which every state message has" in notes.problems[1]
    assert notes.lines()[20] == "and 13 more bad rows"


STRANGE = {
    "deep": ("[" * 100_000, "too many lists or objects inside one another, expected a state message of VDA 5050"),
    "a list": ([], "expected a state message of VDA 5050, a JSON object (got []"),
    "a number": (7, "expected a state message of VDA 5050, a JSON object (got 7)"),
    "cut off": ('{"timestamp": 1', "not JSON (expecting ',' delimiter), expected a state message of VDA 5050"),
    "a key twice": ('{"errors": [], "errors": []}', "the top level: key 'errors' given twice, expected once"),
    "not a number": (message(2, agvPosition={"x": float("nan"), "y": 0.0}), "agvPosition.x: not a number (got NaN)"),
    "far away": (message(2, agvPosition={"x": 1e300, "y": 0.0}), "agvPosition.x: expected a number from -1e+09 to"),
    "a list for a position": (message(2, agvPosition=[1, 2]), "agvPosition: expected an object (got [1, 2])"),
    "text for a position": (message(2, agvPosition={"x": "1,5"}), "agvPosition.x: expected a number (got '1,5')"),
    "text for a truth": (message(2, driving="yes"), "driving: expected true or false (got 'yes')"),
    "text for states": (message(2, actionStates="none"), "actionStates: expected a list of objects (got 'none')"),
    "texts for errors": (message(2, errors=["motor"]), "errors: expected a list of objects (got [motor])"),
    "a state without status": (message(2, actionStates=[{}]), "no 'actionStates.actionStatus', which every"),
    "a number for a robot": (message(2, serialNumber=5), "serialNumber: expected text (got 5)"),
    "charge": (
        message(2, batteryState={"batteryCharge": 101}),
        "batteryCharge: expected a number from 0 to 100 (got 101)",
    ),
    "a time beyond all": (message(2, timestamp=1e300), "timestamp: no time from 1970 to 2099 (got 1e+300)"),
    "year 9999": (message(2, timestamp="9999-12-31T23:59:59Z"), "timestamp: no time from 1970 to 2099"),
    "year 1": (message(2, timestamp="0001-01-01T00:00:00+14:00"), "timestamp: no time from 1970 to 2099"),
    "no time": (message(2, timestamp=[1]), "timestamp: no time from 1970 to 2099 (got [1])"),
    "no robot": (message(2, serialNumber=None), "no 'serialNumber', which every state message has"),
}


@pytest.mark.parametrize("name", STRANGE)
def test_a_line_that_is_no_state_message_is_one_line_of_place_and_cure(tmp_path, name):
    line, fault = STRANGE[name]
    log = log_of(tmp_path, [message(0), message(1), line, message(3)])
    [problem] = log.notes.problems
    assert f"log.jsonl:3: {fault}" in problem or f"log.jsonl:3: batteryState.{fault}" in problem
    assert log.table["time"].tolist() == [0, 1, 3]


def test_a_line_without_an_end_is_not_read_to_it(tmp_path):
    with pytest.raises(
        ReportError, match=r"log.jsonl:2: a line of more than 1,000,000 bytes, expected a state message"
    ):
        log_of(tmp_path, [message(0), "[" + "1," * 1_000_000])


def test_a_log_with_its_newest_message_first_is_read_from_the_end(tmp_path):
    lines = [message(second, robot, "AB"[second // 10 % 2]) for second in range(90) for robot in ("R1", "R2")]
    there, back = log_of(tmp_path, lines), log_of(tmp_path, lines[::-1])
    assert (back.notes.jumps, back.notes.late, back.begin) == (0, 0, there.begin)
    assert back.notes.lines() == ["the newest message stands first: read from the end"]
    assert sorted(zip(*(back.table[name] for name in ("time", "x")), strict=True)) == sorted(
        zip(*(there.table[name] for name in ("time", "x")), strict=True)
    )


def test_a_log_in_no_order_is_refused_and_not_read_in_part(tmp_path):
    seconds = np.random.default_rng(0).permutation(1000).tolist()
    with pytest.raises(ReportError, match=r"of 1,000 messages would be left out, as clocks run back or ahead; .*sort"):
        log_of(tmp_path, [message(second) for second in seconds])


def test_a_log_whose_messages_all_have_one_time_is_refused(tmp_path):
    with pytest.raises(ReportError, match="99 of 100 messages would be left out, as their robot has another of the"):
        log_of(tmp_path, [message(0) for _ in range(100)])


def test_a_robot_whose_clock_is_years_ahead_is_named(tmp_path):
    ahead = [message(second, "R7", timestamp=f"2031-03-02T06:00:{second:02}Z") for second in range(30)]
    fault = r"1,826 days, 2026-03-02 \('?R1'?\) to 2031-03-02 \('?R7'?\), expected 31 at most; split"
    with pytest.raises(ReportError, match=fault):
        log_of(tmp_path, [*map(message, range(30)), *ahead])


def test_a_row_of_trips_without_all_cells_is_refused_in_words(tmp_path):
    path = tmp_path / "trips.csv"
    path.write_text("robot,pick,drop,start,end\nR1,A,B,10,70\nR1,A\nR1,A,B,80,90,100\nR1,A,B,80,1e300\n")
    short, long, late = read_log(path).notes.problems
    assert short.endswith("trips.csv:3: a row with other than 5 cells")
    assert long.endswith("trips.csv:4: a row with other than 5 cells")
    assert "trips.csv:5: timestamp: no time from 1970 to 2099 (got '1e300')" in late


def test_a_bad_row_of_trips_has_the_line_of_its_file(tmp_path):
    path = tmp_path / "trips.csv"
    path.write_text('robot,pick,drop,start,end\n\n"R1","A","B",10,70\n,,,,\n\nR1,A,B,oops,90\n')
    assert [problem.partition("trips.csv")[2][:3] for problem in read_log(path).notes.problems] == [":4:", ":6:"]


@pytest.mark.parametrize("encoding", ["utf-16", "cp1252"])
def test_trips_in_another_encoding_are_refused_with_the_one_to_save(tmp_path, encoding):
    (path := tmp_path / "trips.csv").write_text("robot,pick,drop,start,end\nGrün,A,B,10,70\n", encoding=encoding)
    with pytest.raises(ReportError, match=r"cannot be read \(not text in UTF-8\), expected trips as CSV UTF-8"):
        read_log(path)


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
    run = dw.simulate(a_plant.run.model.replace({"run.length": 900}), 1)
    run.save(tmp_path / "run")
    here = from_run(run)
    assert here.table["fault"].any()
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


def two_robots(**changes):
    return [message(second, robot, **changes) for second in range(10) for robot in ("R1", "R2")]


def of_version_3(one):
    battery = one.pop("batteryState")
    return one | {"powerSupply": {"stateOfCharge": battery["batteryCharge"], "charging": battery["charging"]}}


RECORDED = {
    "a topic before each": lambda one: f"uagv/v2/somebody/{one['serialNumber']}/state {json.dumps(one)}",
    "a time and a topic": lambda one: f"2026-03-02T06:00:00+0000\t{json.dumps(one)}",
    "a wrapper with text": lambda one: {"topic": "uagv/v2/x/1/state", "payload": json.dumps(one)},
    "a wrapper with an object": lambda one: {"qos": 0, "payload": one},
    "a list": lambda one: json.dumps([one]),
    "a topic before a wrapper": lambda one: f"fleet/raw {json.dumps({'payload': one})}",
    "version 3.0": of_version_3,
}


@pytest.mark.parametrize("form", RECORDED)
def test_logs_as_recorders_write_them_are_the_plain_one(tmp_path, form):
    plain = log_of(tmp_path, two_robots())
    log = log_of(tmp_path, [RECORDED[form](one) for one in two_robots()])
    assert log.table.equals(plain.table)
    assert (log.robots, log.notes.bad) == (("R1", "R2"), 0)


@pytest.mark.parametrize(("begin", "end"), [("[\n", "\n]\n"), ("[", "]")])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_list_with_a_message_on_each_line_is_the_plain_log(tmp_path, begin, end, encoding):
    text = begin + ",\n".join(map(json.dumps, two_robots())) + end
    (path := tmp_path / "list.json").write_text(text, encoding=encoding)
    log = read_log(path)
    assert log.table.equals(log_of(tmp_path, two_robots()).table)
    assert log.notes.bad == 0


def test_a_message_over_several_lines_is_refused_with_what_is_expected(tmp_path):
    (path := tmp_path / "log.json").write_text(json.dumps(two_robots(), indent=1))
    with pytest.raises(ReportError, match=r"log.json:2: not JSON .*expected a state message of VDA 5050 on each line"):
        read_log(path)


def test_a_log_of_one_time_calibrates_nothing(tmp_path, a_plant):
    (path := tmp_path / "log.jsonl").write_text(json.dumps(message(0)) + "\n{}\n")
    with pytest.raises(
        ReportError, match=r"all that can be read is of one time, expected the log of a day; .*jsonl:2:"
    ):
        dw.calibrate(a_plant.sheet, path)


def test_robots_of_two_makers_with_one_serial_number_are_two(tmp_path):
    lines = [*two_robots(manufacturer="AA"), *two_robots(manufacturer="BB")[::2]]
    log = log_of(tmp_path, lines)
    assert log.robots == ("R1 of AA", "R2", "R1 of BB")
    assert (len(log.table), log.notes.duplicates) == (30, 0)


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ({"payload": "not JSON"}, "expected a state message of VDA 5050"),
        ({"payload": {}}, "no 'timestamp', which every state message has"),
        ({"payload": 3}, "expected a state message of VDA 5050, a JSON object (got 3)"),
        (json.dumps([message(1), 5]), "expected a state message of VDA 5050, a JSON object (got 5)"),
        (of_version_3(message(2)) | {"powerSupply": {"stateOfCharge": 300}}, "powerSupply.stateOfCharge: expected a"),
        (message(2, manufacturer=7), "manufacturer: expected text (got 7)"),
    ],
)
def test_what_is_wrong_within_a_wrapper_is_a_bad_row(tmp_path, line, fault):
    (problem,) = log_of(tmp_path, [message(0), line]).notes.problems
    assert fault in problem
