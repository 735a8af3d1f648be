"""Clocks of a fleet that jump all at once, or differ from each other: named and put right; times by hand."""

import datetime as dt

import pytest

from tests.fleet_log.test_reading import log_of, message

SPRING, AUTUMN = map(dt.datetime.fromisoformat, ("2026-03-29 01:00", "2026-10-25 01:00"))
"""An hour before the clocks of Central Europe change, by the clock on the wall."""
ROBOTS = ("R1", "R2", "R3", "R4")


def night(begin, change, step=10, hours=2.0, robots=ROBOTS, **ahead):
    """Messages of robots every few seconds by clocks that change an hour after `begin`, by `change` hours."""
    lines = []
    for second in range(0, round(hours * 3600), step):
        for robot in robots:
            wall = begin + dt.timedelta(seconds=second + 3600 * change * (second >= 3600) + ahead.get(robot, 0))
            lines.append(message(0, robot, "AB"[second // 100 % 2], timestamp=wall.isoformat()))
    return lines


def times_of(log, robot=0):
    return log.table["time"][log.table["robot"] == robot].tolist()


@pytest.mark.parametrize(("begin", "change"), [(SPRING, 1), (AUTUMN, -1)])
@pytest.mark.parametrize("order", ["by time", "newest first", "by robot"])
def test_a_clock_change_is_named_and_put_right(tmp_path, begin, change, order):
    lines = night(begin, change)
    if order == "by robot":
        lines = sorted(lines, key=lambda line: line["serialNumber"])
    log = log_of(tmp_path, lines[:: -1 if order == "newest first" else 1])
    assert times_of(log) == [*range(0, 7200, 10)]
    assert (
        f"all clocks jump by an hour at {begin + dt.timedelta(hours=1):%Y-%m-%d %H:%M}: a clock change, put right"
        in (log.notes.lines())
    )
    assert (log.notes.gaps, log.notes.jumps, log.notes.duplicates) == (0, 0, 0)


def test_a_robot_that_is_silent_in_the_night_of_the_change_hides_it_not(tmp_path):
    lines = [
        line
        for rank, line in enumerate(night(SPRING, 1, robots=[f"R{number}" for number in range(12)]))
        if line["serialNumber"] != "R3" or not 3000 < rank // 12 * 10 < 4200
    ]
    log = log_of(tmp_path, lines)
    assert (log.notes.gaps, log.notes.missing) == (1, 1190)
    assert times_of(log, 3) == [*range(0, 3010, 10), *range(4200, 7200, 10)]


@pytest.mark.parametrize("hours", [8, -96, 24 * 90])
def test_an_hour_without_messages_in_another_night_is_a_gap(tmp_path, hours):
    log = log_of(tmp_path, night(SPRING + dt.timedelta(hours=hours), 1))
    assert (log.notes.gaps, log.notes.missing, log.notes.assumed) == (4, 4 * 3600, [])


def test_one_robot_that_jumps_alone_is_no_clock_change(tmp_path):
    lines = [*night(SPRING, 1, robots=ROBOTS[:1]), *night(SPRING, 0, robots=ROBOTS[1:])]
    log = log_of(tmp_path, sorted(lines, key=lambda line: line["timestamp"]))
    assert not any("clock change" in line for line in log.notes.lines())


def test_instants_with_offsets_of_the_night_are_as_they_are(tmp_path):
    zones = [dt.timezone(dt.timedelta(hours=hours)) for hours in (1, 2)]
    stamps = [
        dt.datetime(2026, 3, 29, 0, tzinfo=dt.UTC).astimezone(zones[second >= 3600]) + dt.timedelta(seconds=second)
        for second in range(0, 7200, 10)
    ]
    log = log_of(tmp_path, [message(0, timestamp=stamp.isoformat()) for stamp in stamps])
    assert times_of(log) == [*range(0, 7200, 10)]
    assert not log.notes.lines()


@pytest.mark.parametrize("ahead", [420, -95, 86_400])
def test_a_robot_whose_clock_differs_from_the_others_is_named_and_put_right(tmp_path, ahead):
    log = log_of(tmp_path, night(SPRING, 0, hours=0.5, R2=ahead))
    side = "ahead of" if ahead > 0 else "behind"
    assert log.notes.lines() == [f"the clock of 'R2' is {abs(ahead):,} s {side} the others': put right"]
    assert log.length == 1790
    assert times_of(log, 1) == times_of(log, 0)


def test_clocks_of_two_robots_and_of_logs_in_order_of_time_say_nothing(tmp_path):
    two = night(SPRING, 0, hours=0.5, robots=ROBOTS[:2], R2=420)
    assert not any("clock" in line for line in log_of(tmp_path, two).notes.lines())
    ordered = sorted(night(SPRING, 0, hours=0.5, R2=420), key=lambda line: line["timestamp"])
    assert not any("clock" in line for line in log_of(tmp_path, ordered).notes.lines())


def test_a_log_in_one_line(tmp_path):
    lines = [message(0, robot, timestamp=f"2026-03-02T06:{minute:02}:00Z") for minute in range(55) for robot in ROBOTS]
    lines[3]["batteryState"] = {"batteryCharge": 35.5, "charging": False}
    log = log_of(tmp_path, lines)
    assert log.in_short().endswith("log.jsonl: 4 robots, from 2026-03-02 06:00 on, 0.9 h, charge 35.5 to 80 %")
    shares = [line | {"batteryState": {"batteryCharge": 0.8, "charging": False}} for line in lines]
    ending = "charge 0.8 to 0.8 %, doubtful, as messages have per cent and not shares"
    assert log_of(tmp_path, shares).in_short().endswith(ending)


@pytest.mark.parametrize(
    "stamp",
    ["2026-03-02 06:00:{:02}", "02.03.2026 06:00:{:02}", "2026-03-02T07:00:{:02}+01:00", "2026-03-02 6:00:{:02} AM"],
)
def test_stamps_of_messages_are_read_as_those_of_orders(tmp_path, stamp):
    log = log_of(tmp_path, [message(0, timestamp=stamp.format(second)) for second in range(5)])
    assert times_of(log) == [0, 1, 2, 3, 4]
    assert log.begin == 1_772_431_200
