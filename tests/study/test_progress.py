"""How far a study is, in words."""

import io
import re

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.study.execution import progress
from desim_warehouse.study.execution.progress import Progress
from desim_warehouse.study.fleet.first_answer import first_answer
from desim_warehouse.study.procedures import about

pytestmark = pytest.mark.usefixtures("brief_probes")


@pytest.mark.parametrize(
    ("runs", "seconds", "message"),
    [(500, 2.0, "250 runs/s"), (9, 2.0, "4.5 runs/s"), (2, 2.0, "1.0 runs/s"), (5, 17.0, "3.4 s a run")],
)
def test_fast_runs_are_counted_by_the_second_and_slow_ones_are_timed(runs, seconds, message, monkeypatch):
    clock = iter([0.0, 0.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock, seconds))
    stream = io.StringIO()
    with Progress("night", stream=stream) as shown:
        shown.want(runs, 0)
        for _ in range(runs):
            shown.step(failed=False)
        assert shown.pace == message
        assert shown.summary() == f"night: {runs} runs in {seconds:.1f} s ({message})"
    if seconds > 10:
        assert stream.getvalue() == "night: 1 of 5 runs, 17.0 s a run, 1:08 min left\n"


def test_a_study_without_a_run_has_no_pace():
    assert Progress("x", stream=io.StringIO()).summary().startswith("x: 0 runs in ")


class Cell:
    """The bar of a cell, with all that it showed."""

    def __init__(self):
        self.shown = []

    def update(self, done, total, lines):
        self.shown.append((done, total, lines))


def test_a_cell_shows_the_last_line_and_below_it_what_was_said(monkeypatch):
    """Two of four runs are done by 20 s, one every 10 s; a line that is said stays below."""
    clock = iter([0.0, 0.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock, 20.0))
    monkeypatch.setattr(progress, "in_notebook", lambda: True)
    monkeypatch.setattr(progress, "CellBar", Cell)
    stream = io.StringIO()
    with Progress("night", stream=stream) as shown:
        shown.want(4, 0)
        shown.step(failed=False)
        shown.print("a worker process died")
        shown.shown_at = 0.0
        shown.step(failed=False)
        cell = shown.cell
    assert cell.shown[:3] == [
        (1, 4, ["night: 1 of 4 runs, 20.0 s a run, 1:00 min left"]),
        (1, 4, ["a worker process died"]),
        (2, 4, ["night: 2 of 4 runs, 10.0 s a run, 20.0 s left", "a worker process died"]),
    ]
    assert stream.getvalue() == ""


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self):
        return True


def planned(stream, monkeypatch, **more):
    monkeypatch.setattr(progress.sys, "stderr", stream)
    changes = {"tasks.goods": {"poisson": 200, "due_within": 150}, "run.length": 1500, "battery": None}
    return plan_fleet(
        dw.load("models/tutorial.yaml", changes),
        "on_time >= 80 %",
        robots="1..4",
        strategies={},
        growth="5%",
        search=dw.Search(progress=True, cache=False, **more),
    )


def test_a_terminal_shows_what_a_plan_knows_so_far(monkeypatch):
    terminal = Terminal()
    plan = planned(terminal, monkeypatch, first=5, cap=12)
    shown = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", terminal.getvalue())
    best = plan.today.best.robots
    assert re.search(rf"today: (\d robots?: [a-z ]+; )*{best} robots?: met", shown)
    assert re.search(r"first guess from single days: \d robots?; about \d fleets? to judge", shown)
    assert re.search(rf"today: {best} robots?; growth: \d robots?: (met|not met|open)", shown)


def test_a_search_says_what_it_looked_at_and_no_time_that_it_does_not_know(monkeypatch):
    """Two of three runs that were asked for are done, of two designs: how many follow is not known."""
    clock = iter([0.0, 0.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock, 20.0))
    stream = io.StringIO()
    with Progress("today", stream=stream) as shown:
        shown.is_search = True
        shown.want(3, 0, looked=2)
        for _ in range(2):
            shown.step(failed=False)
    assert stream.getvalue() == "today: 2 designs looked at, 1 run, 20.0 s a run\n"


def test_single_days_tell_about_how_many_robots_it_takes():
    """6 robots failed on their day, 12 and then 9 did not; before that only that 6 are too few is known."""
    designs = [(robots,) for robots in range(20)]
    guesses = [
        about(designs, lambda one: one, met, lambda n: f"{n} robots")
        for met in ({6: False}, {6: False, 12: True, 9: True})
    ]
    assert guesses == ["more than 6 robots", "about 9 robots"]
    assert about(designs, lambda one: one, {}, str) == ""


def test_the_first_answer_of_a_plan_counts_the_fleets_to_be_judged():
    """Of 3 robots with 1 charger, and 2 with 2, which failed, both are judged, beside 3 robots with 2 chargers."""
    designs = [(robots, chargers) for robots in (2, 3, 4) for chargers in (1, 2)]
    line = first_answer(
        designs, lambda one: one, {designs.index((3, 1)), designs.index((2, 2))}, lambda n: str(designs[n])
    )
    assert line == "first guess from single days: (3, 2); about 3 fleets to judge"
    assert first_answer(designs, lambda one: one, (), str) == "first guess from single days: 0; about 1 fleet to judge"
    assert first_answer(designs, lambda one: one, {5}, str) == "first guess from single days: no fleet is enough"


def stopped(stream, *, shown):
    with Progress("night", stream=stream, shown=shown) as progress_of_night:
        progress_of_night.tell("10 robots: met; 9 robots: not met")
        raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("shown", "message"), [(True, "known so far: 10 robots: met; 9 robots: not met\n"), (False, "")]
)
def test_what_is_known_so_far_is_said_where_ctrl_c_ends_it_unless_all_is_to_be_quiet(shown, message):
    stream = io.StringIO()
    with pytest.raises(KeyboardInterrupt):
        stopped(stream, shown=shown)
    assert stream.getvalue() == message


def test_a_study_that_ends_by_itself_leaves_no_line():
    stream = io.StringIO()
    with Progress("night", stream=stream) as shown:
        shown.tell("10 robots: met")
    assert stream.getvalue() == ""
