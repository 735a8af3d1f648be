"""What the page is given of pickers: where each is at any time, for whom, and who was busiest."""

import numpy as np
import pytest

from desim_warehouse.replay.columns import pack
from desim_warehouse.replay.payload import payload
from tests.report.replay.floors import paper_run
from tests.report.replay.unpacked import unpack
from tests.world.test_pickers import AROUND, BOTH, ring


def columns_of(run, start=0.0):
    header, columns = payload(run.history, start, run.record.end)
    return header, unpack(*pack(columns))


def test_acts_are_those_of_the_log_and_spots_those_of_the_places():
    """He begins at 10 m, walks to 5 m and to 15 m of the first edge, and picks at both."""
    run = ring(tasks__goods=[0, 2], **BOTH, log="all")
    header, columns = columns_of(run)
    tick, grain = header["tick"], header["grain"]
    begin = np.cumsum(columns["act_time"])
    spans = [*zip(begin * tick, (begin + columns["act_length"]) * tick, strict=True)]
    assert spans == [pytest.approx(span, abs=2 * tick) for span in [(5, 15), (15, 22), (32, 52), (52, 59)]]
    assert columns["act_nodes"].tolist() == [0, -1, 0, -1]
    assert columns["act_at"] * grain == pytest.approx([5, 15], abs=grain)
    assert (columns["picker_edge"].tolist(), columns["picker_at"] * grain) == ([0], pytest.approx([10], abs=grain))
    assert columns["act_robot"].tolist() == [0] * 4


def test_way_passes_the_nodes_of_the_shortest_way():
    """From 10 on the edge CD he is 5 from D by 10 on, and 5 beyond D on DA: 15 away; the other way it is 45."""
    run = ring(tasks__goods=[2], layout__storage=AROUND, log="all")
    _, columns = columns_of(run)
    assert columns["act_nodes"].tolist() == [1, -1]
    assert columns["act_node"].tolist() == [3]


def test_window_begins_where_pickers_are_then():
    run = ring(tasks__goods=[0, 2], **BOTH, log="all")
    header, columns = columns_of(run, start=30.0)
    assert columns["picker_at"] * header["grain"] == pytest.approx([5], abs=header["grain"])
    assert columns["act_nodes"].tolist() == [0, -1]


def test_story_tells_who_was_busiest_and_goes_to_the_longest_walk():
    """Of 101 time units 14 are for two lines and 30 for two ways; the second lasts from 32 to 52."""
    run = ring(tasks__goods=[0, 2], **BOTH, log="all")
    header, _ = columns_of(run)
    (stop,) = (stop for stop in header["stops"] if "busiest picker" in stop["said"])
    assert run.record.end == 112
    assert stop["said"] == "The busiest picker: 0, 2 lines, 12.5 % of the time picking, 26.8 % walking."
    assert (stop["time"], stop["robots"]) == (42, [1])


def test_models_without_pickers_have_no_such_columns():
    header, columns = columns_of(paper_run())
    assert not [name for name in columns if name.startswith(("picker_", "act_"))]
    assert not [stop for stop in header["stops"] if "picker" in stop["said"]]
