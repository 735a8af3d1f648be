"""How far a study is, in words."""

import io

import pytest

from desim_warehouse.study.execution import progress
from desim_warehouse.study.execution.progress import Progress


@pytest.mark.parametrize(
    ("runs", "seconds", "said"),
    [(500, 2.0, "250 runs/s"), (9, 2.0, "4.5 runs/s"), (2, 2.0, "1.0 runs/s"), (5, 17.0, "3.4 s a run")],
)
def test_fast_runs_are_counted_by_the_second_and_slow_ones_are_timed(runs, seconds, said, monkeypatch):
    clock = iter([0.0, 0.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock, seconds))
    stream = io.StringIO()
    with Progress("night", stream=stream) as shown:
        shown.want(runs, 0)
        for _ in range(runs):
            shown.step(failed=False)
        assert shown.pace == said
        assert shown.summary() == f"night: {runs} runs in {seconds:.1f} s ({said})"
    if seconds > 10:
        assert stream.getvalue() == "night: 1 of 5 runs, 17.0 s a run, 1:08 min left\n"


def test_a_study_without_a_run_has_no_pace():
    assert Progress("x", stream=io.StringIO()).summary().startswith("x: 0 runs in ")
