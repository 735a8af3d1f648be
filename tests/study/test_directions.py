"""Directions found by simulation: a floor whose middle aisle leads the wrong way, and what is said of the answer."""

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import StudyError
from desim_warehouse.questions.orient import orient

DETOUR = """\
name: a short cut that leads the wrong way   # a comment that stays
layout:
  nodes: {A: [0, 0], B: [20, 0], C: [40, 0], D: [40, 20], E: [20, 20], F: [0, 20]}
  edges:
    - [A, B]
    - [B, C]
    - [C, D]
    - [D, E]
    - [E, F]
    - [F, A]
    - [E, B]   # from A to the goods on E>F robots must drive all round
  storage:
    - {edge: [E, F], offset: 5}
    - {edge: [E, F], offset: 10}
    - {edge: [A, B], offset: 10}
  bays: {home: {at: [C], places: 3}}
  stations: {pack: {at: [A], places: 3, servers: 3}}
fleet: {size: 2, robot: {radius: 0.3, speed: 1, margin: 0.1}}
tasks: {goods: {saturated: 6}, unload_at: [pack], load_time: 2, unload_time: 2}
prices: {hours: 2000, turned_aisle: 150}
run: {length: 1200, warm_up: 120}
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "w.yaml"
    path.write_text(DETOUR, encoding="utf-8")
    return path


def truth(model):
    """All ways of this floor that keep it connected, each in three runs of an hour."""
    from desim_warehouse.study.designs.directions import Floor

    floor = Floor(model)
    seen = {floor.drawn}
    while more := {other for one in seen for other in floor.neighbours(one) if floor.allows(other)} - seen:
        seen |= more
    return {
        design: sum(
            dw.simulate(model.replace(floor.changes(design)), seed).kpis["throughput_per_hour"] for seed in range(3)
        )
        / 3
        for design in seen
    }


def test_the_directions_found_are_the_best_that_there_are(file):
    model = dw.load(file)
    directions = orient(model, "throughput_per_hour", search=dw.Search(runs=80))
    every = truth(model)
    best = max(every.values())
    chosen = next(mean for design, mean in every.items() if dict(directions.ways) == dict(_lanes(model, design)))
    assert chosen >= 0.99 * best
    assert directions.runs <= 80
    assert directions.gain.is_better
    assert directions.gain.low > 0
    assert directions.cost == 150 * len(directions.turned)
    assert not [item for item in dw.check(directions.model).findings if item.level == "error"]


def _lanes(model, design):
    from desim_warehouse.study.designs.directions import Floor

    return Floor(model).turnable.lanes(design)


def test_the_answer_does_not_depend_on_workers_and_what_ended_is_found_again(file, tmp_path):
    model = dw.load(file)
    one = orient(model, "throughput_per_hour", search=dw.Search(runs=60, out=tmp_path / "runs"))
    before = (tmp_path / "runs" / "search" / "runs.jsonl").stat().st_mtime_ns
    again = orient(model, "throughput_per_hour", search=dw.Search(runs=60, workers=2, out=tmp_path / "runs"))
    assert one.answer.answer == again.answer.answer
    assert (tmp_path / "runs" / "search" / "runs.jsonl").stat().st_mtime_ns == before
    assert (
        len(dw.Results.load(tmp_path / "runs" / "search").rows)
        + len(dw.Results.load(tmp_path / "runs" / "judged").rows)
        == one.runs
    )


def test_the_command_writes_the_model_and_says_what_it_gains(file):
    out = file.with_name("turned.yaml")
    words = ["orient", str(file), "-o", str(out), "--indicator", "throughput_per_hour", "--runs", "80", "--quiet"]
    done = CliRunner().invoke(desim, words)
    assert done.exit_code == 0, done.output
    assert "turned:" in done.output
    assert "Throughput: +" in done.output
    assert "in 20 pairs of runs on fresh days." not in done.output  # 80 runs leave 16 for them
    assert "Turning costs " in done.output
    assert "# a comment that stays" in out.read_text(encoding="utf-8")
    assert dw.load(out) == orient(dw.load(file), "throughput_per_hour", search=dw.Search(runs=80)).model


def test_a_floor_that_is_best_as_drawn_is_not_written(file):
    file.write_text(DETOUR.replace("[E, B]", "[B, E]"), encoding="utf-8")
    out = file.with_name("turned.yaml")
    words = ["orient", str(file), "-o", str(out), "--indicator", "throughput_per_hour", "--runs", "80", "--quiet"]
    done = CliRunner().invoke(desim, words)
    assert done.exit_code == 3
    assert done.output.startswith("No directions were found that are better than those drawn, in ")
    assert not out.exists()


def test_what_cannot_be_searched_is_refused(file):
    with pytest.raises(StudyError, match="too few to search directions, expected at least 50"):
        orient(dw.load(file), "throughput_per_hour", search=dw.Search(runs=20))
    with pytest.raises(StudyError, match="neither less nor more of it is better"):
        orient(dw.load(file), "share_loaded")
    with pytest.raises(StudyError, match="throughput_per_hou"):
        orient(dw.load(file), "throughput_per_hou")
