"""A run in open formats: the tables, and a trace that Perfetto reads."""

import itertools
import json
from collections import Counter

import pandas as pd
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from desim_warehouse.report.export import export, state_table, trace

TABLES = {"kpis", "log", "tasks", "states", "waits", "robots", "edges", "nodes"}


@pytest.mark.parametrize(("form", "read"), [("csv", pd.read_csv), ("parquet", pd.read_parquet)])
def test_tables_come_back_as_they_were(run, tmp_path, form, read):
    folder = export(run, form, tmp_path / "deep" / form)
    assert {path.stem for path in folder.iterdir()} == TABLES
    log = read(folder / f"log.{form}")
    assert list(log["kind"]) == list(run.log["kind"])
    assert log["time"].tolist() == run.log["time"].tolist()
    kpis = read(folder / f"kpis.{form}").set_index("indicator")
    assert kpis["value"]["T"] == run.T
    assert kpis["unit"]["T"] == "step"
    assert read(folder / f"edges.{form}").set_index("edge")["passages"].to_dict() == run.edges["passages"].to_dict()


def test_states_fill_the_run_of_every_robot_and_match_the_tallies(lifelong):
    table = state_table(lifelong)
    waits = lifelong.waits
    for robot, mine in table.groupby("robot"):
        assert mine["start"].iloc[0] == 0
        assert mine["end"].iloc[-1] == lifelong.record.end
        assert mine["start"].tolist()[1:] == mine["end"].tolist()[:-1]
        assert (mine["end"] > mine["start"]).all()
        spent = (mine["end"] - mine["start"]).groupby(mine["state"]).sum()
        tally = lifelong.robots.loc[robot]
        waited = (waits["end"] - waits["start"])[waits["robot"] == robot].sum()
        assert waited == pytest.approx(tally["waiting"])
        for state in ("loading", "unloading", "charging", "idle"):  # nobody waits in traffic in these
            assert spent.get(state, 0.0) == pytest.approx(tally[state])
        assert spent.sum() == pytest.approx(lifelong.record.end)


def by_phase(events, phase):
    return [event for event in events if event["ph"] == phase]


def test_the_trace_has_robots_as_tracks_with_their_names(run):
    events = trace(run)["traceEvents"]
    names = {e["args"]["name"]: e["pid"] for e in by_phase(events, "M") if e["name"] == "process_name"}
    assert [f"robot {n}" in names for n in range(6)] == [True] * 6
    tracks = {(e["pid"], e["tid"]) for e in by_phase(events, "M") if e["name"] == "thread_name"}
    assert {(e["pid"], e["tid"]) for e in by_phase(events, "X")} <= tracks


def test_slices_of_a_track_never_overlap_and_times_are_microseconds(lifelong):
    slices = by_phase(trace(lifelong)["traceEvents"], "X")
    tracks = {}
    for event in slices:
        tracks.setdefault((event["pid"], event["tid"]), []).append((event["ts"], event["ts"] + event["dur"]))
    assert len(tracks) > 12
    for spans in tracks.values():
        spans.sort()
        assert all(after[0] >= before[1] - 0.002 for before, after in itertools.pairwise(spans))
    last = max(event["ts"] + event["dur"] for event in slices)
    assert last == pytest.approx(lifelong.record.end * 0.05 * 1e6)


def test_every_task_is_a_slice_of_the_robot_that_delivered_it(run):
    slices = [e for e in by_phase(trace(run)["traceEvents"], "X") if e["cat"] == "tasks"]
    delivered = run.log[run.log["kind"] == "delivered"]
    ended = {e["name"]: (e["pid"] - 2, e["ts"] + e["dur"]) for e in slices if e["args"]["ended"] == "delivered"}
    assert ended == {
        f"task {row.task}": (row.robot, pytest.approx(row.time * 50_000)) for row in delivered.itertuples()
    }


def test_a_task_given_back_and_taken_again_is_two_slices(model):
    low = dw.simulate(model.replace({"fleet.size": 1, "battery.threshold": 8}))
    returned = low.log[low.log["kind"] == "returned"]
    assert len(returned)
    slices = [e for e in by_phase(trace(low)["traceEvents"], "X") if e["cat"] == "tasks"]
    ends = Counter(e["args"]["ended"] for e in slices)
    assert ends == {"delivered": 10, "returned": len(returned)}


def test_flows_are_paired_and_lead_from_the_robot_in_the_way(lifelong):
    events = trace(lifelong)["traceEvents"]
    starts = {e["id"]: e for e in by_phase(events, "s")}
    finishes = {e["id"]: e for e in by_phase(events, "f")}
    waits = lifelong.waits
    assert starts.keys() == finishes.keys() == set(waits.index[waits["other"] >= 0])
    assert starts
    for number, wait in waits[waits["other"] >= 0].iterrows():
        assert starts[number]["pid"] == wait["other"] + 2
        assert finishes[number]["pid"] == wait["robot"] + 2
        assert starts[number]["ts"] <= finishes[number]["ts"]
    slices = by_phase(events, "X")
    for flow in (*starts.values(), *finishes.values()):  # a flow is bound to a slice on its track at its time
        assert any(
            e["pid"] == flow["pid"]
            and e["tid"] == flow["tid"]
            and e["ts"] - 0.002 <= flow["ts"] <= e["ts"] + e["dur"] + 0.002
            for e in slices
        )


def test_the_command_writes_json_from_a_run_folder(run, tmp_path):
    folder = run.save(tmp_path / "run")
    done = CliRunner().invoke(desim, ["export", str(folder), "--format", "trace"], catch_exceptions=False)
    assert done.output.strip() == str(folder / "trace.json")
    content = json.loads((folder / "trace.json").read_text())
    assert content == json.loads(json.dumps(trace(run)))
    assert content["otherData"]["model"] == "MultiBots"


def test_what_cannot_be_exported_is_said(run, tmp_path):
    with pytest.raises(ReportError, match="expected one of csv, parquet, trace"):
        export(run, "xlsx", tmp_path)
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(ReportError, match="cannot be written"):
        export(run, "csv", blocked)
    with pytest.raises(ReportError, match="no run can be read"):
        CliRunner().invoke(desim, ["export", str(tmp_path), "--format", "csv"], catch_exceptions=False)
