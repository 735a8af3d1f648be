"""What the page is given: read back as the page reads it, it is the run."""

import json
import math
import re

import numpy as np
import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ReportError
from desim_warehouse.look.web import safe_json
from desim_warehouse.outcome import chains
from desim_warehouse.outcome.positions import Positions
from desim_warehouse.outcome.resources import resources
from desim_warehouse.questions.run import words
from desim_warehouse.replay import replay
from desim_warehouse.replay.columns import pack
from desim_warehouse.replay.page import labels
from desim_warehouse.replay.payload import payload
from desim_warehouse.replay.stops import better
from desim_warehouse.replay.tiles import tiles
from tests.report.replay.floors import RUNS, busy, busy_run, due_run, paper_run, people_run
from tests.report.replay.unpacked import unpack
from tests.world.test_lifts import TWO


def read(run, start, end):
    header, columns = payload(run.history, start, end)
    return json.loads(safe_json(header)), unpack(*pack(columns))


def legs_of(header, columns):
    """The legs of each robot in the run's own units, decoded in the way of the page's script."""
    out = {}
    for edge, source in enumerate(header["source"][: header["real"]]):
        out.setdefault(source, []).append(edge)
    others = iter(columns["leg_other"].tolist())
    leg, robots = 0, []
    for robot, count in enumerate(columns["leg_count"].tolist()):
        now, edge, position, legs = 0, 0, int(columns["leg_origin"][robot]), []
        for i in range(leg, leg + count):
            code = int(columns["leg_code"][i])
            edge = edge if code == 0 else next(others) if code == 1 else out[header["target"][edge]][code - 2]
            position = 0 if code and i > leg else position
            now += int(columns["leg_pause"][i])
            begin, origin = now, position
            now += int(columns["leg_time"][i])
            position = round(header["length"][edge] / header["grain"]) - int(columns["leg_left"][i])
            tick, grain = header["tick"], header["grain"]
            legs.append(
                (begin * tick + header["start"], now * tick + header["start"], edge, origin * grain, position * grain)
            )
        leg += count
        robots.append(legs)
    return robots


@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize("window", [(0.0, 1.0), (0.4, 0.55)])
def test_legs_read_back_put_robots_where_the_log_has_them(name, window):
    run = RUNS[name]()
    start, end = (part * run.record.end for part in window)
    header, columns = read(run, start, end)
    where, robots = Positions(run.history), legs_of(header, columns)
    near = 0.03 * run.model.fleet.robot.radius  # far less than a pixel
    for time in np.random.default_rng(5).uniform(start, end, 25):
        on, at = where.at(float(time))
        points = where.edges.points(on, at)
        for robot, legs in enumerate(robots):
            begin, finish, edge, origin, target = [leg for leg in legs if leg[0] <= time][-1]
            part = min(max((time - begin) / (finish - begin), 0), 1) if finish > begin else 1
            point = where.edges.points(np.array([edge]), np.array([origin + part * (target - origin)]))[0]
            assert np.abs(point - points[robot]).max() <= near


def curve(columns, key):
    """Times in ticks and values of a tile, as the page reads them."""
    return np.cumsum(columns[f"{key}_time"]), np.cumsum(columns[f"{key}_value"])


@pytest.mark.parametrize("name", RUNS)
def test_tiles_end_with_the_run_s_own_indicators(name):
    run = RUNS[name]()
    header, columns = read(run, 0.0, run.record.end)
    unit = {"share": 1e-6, "time": header["tick"], "count": 1, "open": 1}
    compared = set()
    for key, _, form, _ in header["tiles"]:
        if form in unit:
            _, values = curve(columns, key)
            last = values[-1] * unit[form] if len(values) else 0
            assert last == pytest.approx(run.kpis[key], abs=0 if unit[form] == 1 else unit[form])
            compared.add(key)
        if form == "lost":
            _, values = curve(columns, key)
            all_robots = run.history.counted * run.model.fleet.size
            assert values[-1] * header["tick"] / all_robots == pytest.approx(run.kpis[key], abs=1e-6)
            compared.add(key)
    assert "tasks" in compared
    assert {"S", "share_waiting"} & compared


def test_tiles_depend_on_the_kind_of_run():
    def keys(run):
        return [tile.key for tile in tiles(run.history)]

    assert keys(paper_run())[:4] == ["backlog", "tasks", "throughput_per_hour", "S"]
    # so many open tasks as there always are; not due
    assert not {"backlog", "on_time", "T"} & set(keys(busy_run()))
    assert {"cycle_time_p95", "battery", "charger_utilisation"} <= set(keys(busy_run()))
    assert keys(due_run()) == ["backlog", "tasks", "throughput_per_hour", "on_time", "cycle_time_p95", "share_waiting"]


def test_a_tile_on_the_way_is_the_indicator_of_what_was_delivered_until_then():
    run = due_run()
    header, columns = read(run, 0.0, run.record.end)
    middle = (run.history.begin + run.history.end) / 2
    so_far = [task for task in run.history.counted_deliveries if task.delivered <= middle]
    expected = {
        "tasks": len(so_far),
        "backlog": sum(task.released <= middle < task.delivered for task in run.history.tasks.values()),
        "on_time": np.mean([not one.missed for one in run.history.deadlines if one.due <= middle]) / 1e-6,
        "cycle_time_p95": np.quantile([task.cycle_time for task in so_far], 0.95) / header["tick"],
    }
    assert 0 < expected["on_time"] < 1e6
    for key, value in expected.items():
        times, values = curve(columns, key)
        now = values[np.searchsorted(times, middle / header["tick"], side="right") - 1]
        assert now == pytest.approx(value, abs=1)


def test_counts_of_a_window_go_on_from_what_came_before_it():
    run = busy_run()
    middle = 400.0
    for key, times in (("tasks", [task.delivered for task in run.history.delivered]), ("C", run.history.recharges)):
        before = sum(run.record.begin <= time <= middle for time in times)
        assert before > 0
        (_, early), (_, late) = (curve(read(run, *span)[1], key) for span in ((0.0, middle), (middle, run.record.end)))
        assert early[-1] == late[0] == before


@pytest.mark.parametrize("name", RUNS)
def test_servers_and_chargers_are_in_use_as_the_account_of_time_has_it(name):
    run = RUNS[name]()
    nodes, (begin, end) = run.account("node"), (run.history.begin, run.history.end)
    for one in resources(run.history):
        row = nodes.loc[one.node]
        station = one.kind == "station"
        used = row["unloading"] + row["loading"] if station else row["charging"]
        queued = row["queueing_server" if station else "queueing_charger"]
        assert one.utilisation(begin, end) == pytest.approx(used / (one.number * (end - begin)))
        assert one.mean_queue(begin, end) == pytest.approx(queued / (end - begin))
        assert max(one.busy[1]) <= one.number
        assert one.busy[1][-1] >= 0 <= min(one.queue[1])
    if "charger_utilisation" in run.kpis:
        some = [one for one in resources(run.history) if one.kind == "chargers"]
        total = sum(one.utilisation(begin, end) * one.number for one in some)
        assert total / run.history.chargers == pytest.approx(run.kpis["charger_utilisation"])


def test_the_worst_jam_is_of_all_robots_that_wait_for_one_root():
    run = busy_run()
    jam = next(stop for stop in read(run, 0.0, run.record.end)[0]["stops"] if "jam" in stop["said"])
    by_root = {}
    for one in chains.lost(run.history):
        if one.start <= jam["time"] < one.end:
            by_root.setdefault(one.root, set()).add(one.robot)
    assert set(jam["robots"]) in by_root.values()
    assert f" {len(jam['robots'])} robots wait, in the end " in jam["said"]
    for time in np.linspace(0, run.record.end, 200):
        there = {}
        for one in chains.lost(run.history):
            if one.start <= time < one.end:
                there[one.root] = there.get(one.root, 0) + 1
        assert max(there.values(), default=0) <= len(jam["robots"])


def test_a_story_has_the_longest_wait_and_the_busiest_place():
    run = busy_run()
    busiest, longest, _, totals = read(run, 0.0, run.record.end)[0]["stops"]
    assert any(line.startswith(busiest["said"]) for line in words.sentences(run))
    assert busiest.keys() == {"said", "time"}, "robots are the busiest, wherever they are"
    wait = max(run.history.waits, key=lambda one: one.end - one.start)
    assert (longest["robots"], longest["time"]) == ([wait.robot], (wait.start + wait.end) / 2)
    assert totals["said"].startswith(f"In all: {run.kpis['tasks']} loads delivered")


def test_of_two_runs_the_better_one_is_named():
    few, many = (dw.simulate(dw.load("models/multibots.yaml", {"fleet.size": size})).history for size in (3, 5))
    less, more = ({"T": run.log.end} for run in (few, many))
    assert better([few, many], [less, more]).startswith("B does better in this run: done after ")
    assert better([many, few], [more, less]).startswith("A does better in this run: done after ")
    assert better([few, few], [less, less]) == "Both do the same."


def test_two_runs_are_told_apart_by_what_differs_in_their_models():
    few, many = (dw.simulate(dw.load("models/multibots.yaml", {"fleet.size": size})) for size in (3, 5))
    again = dw.simulate(few.model, seed=9)
    assert labels([few.history, many.history]) == ["3 robots", "5 robots"]
    assert labels([few.history, again.history]) == ["seed 0", "seed 9"]
    assert labels([many.history, again.history]) == ["5 robots, seed 0", "3 robots, seed 9"]
    assert labels([few.history]) == ["seed 0"]
    other = dw.simulate(dw.load("models/tutorial.yaml"))
    assert labels([few.history, other.history]) == ["MultiBots", "tutorial"]  # not the first of forty keys


@pytest.mark.parametrize("name", [name for name in RUNS if name != "grid"])  # where nobody waits that long
def test_a_robot_that_waits_on_a_lane_stands_still(name):
    run = RUNS[name]()
    where = Positions(run.history)
    stood = 0
    for wait in run.history.waits:
        if wait.end - wait.start > 0.5 and wait.end <= run.record.end:
            early, late = where.at(wait.start + 0.01), where.at(wait.end - 0.01)
            if early[0][wait.robot] < where.edges.real:
                stood += 1
                assert early[1][wait.robot] == pytest.approx(late[1][wait.robot])
    assert stood > 0


def test_goods_of_a_list_are_known_and_there_until_they_are_loaded():
    run = paper_run()
    tasks = run.history.tasks
    assert [tasks[number].good for number in range(10)] == [11, 8, 39, 28, 53, 1, 69, 42, 79, 6]
    loaded = {row[3]: row[0] for row in run.record.rows if row[1] == "loaded"}
    assert {number: task.loaded for number, task in tasks.items()} == loaded


def test_the_page_knows_lifts_and_the_floor_of_each_node():
    run = dw.simulate(dw.load(TWO, {"layout.lifts.main.cabins": 2, "layout.floors": {"wards": ["ward"]}}))
    header, columns = read(run, 0, run.T)
    assert header["floor_titles"] == ["floor 0", "wards"]
    node = {name: number for number, (name, _, _) in enumerate(header["nodes"])}
    assert header["lifts"] == [
        ["main", [node["lift0"], node["lift1"]]],
        ["main 2", [node["lift0 2"], node["lift1 2"]]],
    ]
    assert {name: header["floors"][number] for name, number in node.items()} == {
        **dict.fromkeys(("home", "hall", "lift0", "lift0 2"), 0),
        **dict.fromkeys(("lift1", "lift1 2", "ward", "far"), 1),
    }
    # a wait for the cabin is before its node, on the lane to it; a ride before the node that it leads to
    waits = [(columns["wait_node"][i], columns["wait_edge"][i]) for i in range(len(columns["wait_node"]))]
    edges = list(run.layout.graph.edges)
    lift = {lift.name: lift for lift in run.layout.lifts}[
        "main" if header["nodes"][waits[0][0]][0] == "lift0" else "main 2"
    ]
    low, high = lift.nodes
    named = [(header["nodes"][node][0], edges[edge]) for node, edge in waits]
    assert named == [(low, ("hall", low)), (high, (low, high)), (high, ("ward", high)), (low, (high, low))]


@pytest.mark.parametrize(
    ("start", "end"),
    [(5.0, 5.0), (7.0, 3.0), (-1.0, 5.0), (1e9, None), (0.0, float("nan")), (0.0, math.inf), ("a", None), ([1], None)],
)
def test_a_window_that_shows_nothing_is_refused(start, end):
    with pytest.raises(ReportError, match="shows nothing"):
        replay(paper_run().history, start=start, end=end)


@pytest.mark.parametrize("seconds", [0, -1, float("nan"), math.inf, "a", None, [1], True])
def test_so_are_first_minutes_that_are_none(seconds):
    with pytest.raises(ReportError, match=r"shows nothing|expected a number above 0"):
        paper_run().floor(seconds)


def test_a_palette_that_is_not_known_is_refused():
    with pytest.raises(ReportError, match=r"'red'.*safe, paper"):
        replay(paper_run().history, palette="red")


def test_the_page_is_one_file_that_names_no_other():
    text = replay(paper_run().history).html
    assert not re.search(r"(?:https?:)?//[a-z]", re.sub(r"(?m)//\s.*$", "", text))
    assert not re.search(r"\b(?:src|href)=\"(?!data:)", text)
    assert "default-src 'none'" in text


def test_names_cannot_leave_their_place_in_the_page():
    name = "</script><script>window.hacked=1</script><!-- \u2028 & \"'"
    run = dw.simulate(dw.load(busy(name=name, run={"length": 30.0})))
    page = replay(run.history)
    assert page.html.count("<script") == replay(paper_run().history).html.count("<script")
    assert "<script>window.hacked" not in page.html
    header = re.search(r'id="header">(.*?)</script>', page.html, re.DOTALL)
    assert header is not None
    assert json.loads(header[1])["runs"][0]["name"] == name
    assert "<script" not in page._repr_html_().split("srcdoc=", 1)[1]


def test_a_page_that_cannot_be_written_is_said(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(ReportError, match="cannot be written"):
        paper_run().replay(tmp_path / "file" / "replay.html")


def test_closed_edges_and_people_are_where_and_when_the_log_has_them():
    run = people_run()
    header, columns = read(run, 0.0, run.record.end)
    edges = list(run.layout.graph.edges)
    begin = np.cumsum(columns["shut_time"]) * header["tick"]
    end = begin + np.array(columns["shut_length"]) * header["tick"]
    shown = sorted(
        (edges[edge], round(start, 1), round(until, 1), visit)
        for edge, start, until, visit in zip(columns["shut_edge"], begin, end, columns["shut_visit"], strict=True)
    )
    blocked = sorted((one.edge, round(one.start, 1), round(one.end, 1), one.visit) for one in run.history.blocked)
    assert [(edge, visit) for edge, *_, visit in shown] == [(edge, visit) for edge, *_, visit in blocked]
    np.testing.assert_allclose([row[1:3] for row in shown], [row[1:3] for row in blocked], atol=0.11)
    causes = ["waiting", "waiting_closed", "waiting_person"]
    assert [causes[cause] for cause in columns["wait_cause"]] == [wait.cause for wait in run.history.waits]
    assert set(columns["wait_cause"]) == {0, 1, 2}
    assert "shut_edge" not in read(busy_run(), 0.0, 100.0)[1]
