"""What the page is given of pods: where each is at any time, what it holds, and the lines that it goes for."""

import numpy as np
import pytest

from desim_warehouse.replay.columns import pack
from desim_warehouse.replay.payload import payload
from tests.report.replay.floors import paper_run, pods_run
from tests.report.replay.unpacked import unpack


def columns_of(run, start=0.0, end=None):
    header, columns = payload(run.history, start, run.record.end if end is None else end)
    return header["tick"], unpack(*pack(columns))


def test_moves_are_those_of_the_log():
    run = pods_run()
    tick, columns = columns_of(run)
    times = np.cumsum(columns["move_time"]) * tick
    rows = list(run.history.rows("lifted", "stored"))
    assert times == pytest.approx([row.time for row in rows], abs=tick)
    assert columns["move_to"].tolist() == [-1, rows[1].other] * 3  # robot 0, and back to its own place
    assert columns["pod_at"].tolist() == [rows[0].other]


def test_a_window_begins_where_pods_are_then():
    run = pods_run()
    lifted = next(row.time for row in run.history.rows("lifted"))
    _, columns = columns_of(run, start=lifted + 1)
    assert columns["pod_at"].tolist() == [-1]
    assert len(columns["move_to"]) == 5


def test_what_is_held_and_picked_and_put_there():
    run = pods_run()
    tick, columns = columns_of(run)
    assert columns["hold_item"].tolist() == [0]
    assert columns["hold_units"].tolist() == [1]
    assert columns["line_units"].tolist() == [1, -2, 1, 1]
    assert columns["line_task"].tolist() == [row.task for row in run.history.rows("delivered")]
    done = np.cumsum(columns["line_time"]) + columns["line_length"]
    assert done * tick == pytest.approx([row.time for row in run.history.rows("delivered")], abs=tick)


def test_single_loads_have_no_pods():
    _, columns = columns_of(paper_run())
    assert not [name for name in columns if name.startswith(("pod_", "move_", "hold_", "line_"))]
