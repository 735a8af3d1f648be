"""Departures: which are meant by the clock, and how many orders come after the last."""

import pytest

import desim_warehouse as dw
from desim_warehouse.feasibility.mistakes.clashes import after_last_departure, warnings
from desim_warehouse.questions.departures import in_time
from desim_warehouse.study.fleet.hours import Lead
from tests.world.test_flows import RING


def model(due_at, **changes):
    flow = {"from": "dock", "to": "pack", "arrivals": {"poisson": 30}, "due_at": due_at}
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    base = {"tasks.flows": {"orders": flow}, "run.start": "06:00", "run.length": "16 h"}
    return dw.load(RING, {**base, **changes})


def codes(due_at, **changes):
    given = model(due_at, **changes)
    return {one.code: one.text + one.cure for one in (*warnings(given, given.floor), *after_last_departure(given))}


def test_plain_hours_are_warned_of_where_the_run_starts_by_the_clock():
    texts = codes(["10 h", "14 h", "16 h"])
    assert "36,000 s counts from the start of the run at 06:00: that is 16:00 by the clock" in texts["DUE_CLOCK"]
    assert "due_at: ['16:00', '20:00', '22:00']" in texts["DUE_CLOCK"]
    assert "DUE_CLOCK" in codes({"times": ["4 h"], "cut_off": "10 min"})
    assert "DUE_CLOCK" not in codes(["10 h"], run__start="00:00")
    assert "DUE_CLOCK" not in codes(["10:00"])


@pytest.mark.parametrize(
    ("due_at", "late"),
    [
        (["10:00", "20:00"], "about 60 of 480 tasks come too late for the last departure of the run, 20:00"),
        ({"times": ["10:00", "20:00"], "cut_off": "30 min"}, "about 75 of 480 tasks"),
        (["4 h", "10 h"], "about 180 of 480 tasks come too late for the last departure of the run, 36,000 s"),
        (["10:00", "22:00"], None),  # the last leaves as the run ends
        ({"times": ["22:00"], "cut_off": "1 h"}, "about 30 of 480 tasks"),
    ],
)
def test_orders_after_the_last_departure_are_counted(due_at, late):
    warning = codes(due_at).get("LAST_DEPARTURE")
    assert warning is None if late is None else late in warning


def test_the_first_departure_may_be_after_the_run_and_may_be_its_end():
    assert codes(["23:00"])["NEVER_LATE"].startswith("no departure is in the run, which begins at 06:00 and lasts 16 h")
    assert "NEVER_LATE" in codes(["17 h"])
    assert "NEVER_LATE" not in codes(["16 h"])
    assert "NEVER_LATE" not in codes(["22:00"])


@pytest.mark.parametrize("due_at", [[], {"times": []}])
def test_no_departures_at_all_are_refused(due_at):
    with pytest.raises(dw.ModelError, match=r"should not be empty \(got \[\]\)"):
        model(due_at)


def test_the_latest_order_is_told_by_the_clock():
    day = model(["10:00", "18:00"])
    assert in_time(day, Lead(840.0, 24)) == (
        " In 95 % of days orders that come more than 14 min before a departure are in time for it: until 17:46 for "
        "18:00."
    )
    assert in_time(day, Lead(840.0, 8)).startswith(" On all 8 days run orders that come more than 14 min before ")
    assert in_time(model(["4 h"]), Lead(840.0, 24)).endswith("14 min before a departure are in time for it.")
    assert in_time(day, Lead(0.0, 24)) == " In 95 % of days no order misses its departure."
