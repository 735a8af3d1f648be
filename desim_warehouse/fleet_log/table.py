"""Table of a fleet's log, whatever wrote it: a row for each state that a robot reported.

Rows are collected in compact columns, some 30 bytes a message, so a day of a large fleet fits into memory. What is
wrong with a log is counted in `Notes`, and the first bad rows are named.

A log is read rightly or refused. One in no order, or with a quarter of its messages left out as clocks jump, would
still refute a model by what is left. One of more than 31 days is nearly always one of wrong clocks, and each day of
it would be simulated.
"""

from __future__ import annotations

import datetime as dt
from array import array
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import ReportError, got, number_of
from desim_warehouse.values.fields import LIMITS

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

MOST_PROBLEMS = 20
"""Bad rows of a log that are named."""
NOTHING, PICK, DROP, CHARGE = range(4)
"""Codes of the column `action`."""
ACTIONS = ("", "pick", "drop", "charge")
FAR = 3600.0
"""A single time stamp that is later than its neighbours by so many seconds is wrong."""
HOUR, DAY = 3600.0, 86_400.0
_NEAR = 60.0
"""Seconds around a full hour in which a robot reports at least once."""
_TOGETHER = 4
"""Messages of a robot within which those of all others came, too."""
_SUNDAY, _MORNING, _CHANGES = 6, 4, (3, 4, 9, 10, 11)
MOST_DAYS = 31
"""Days of a log: each is simulated as long as it is."""
_MOST_JUMPS = 0.25
"""Share of the messages that wrong clocks may take away."""
_MOST_DUPLICATES = 0.9
_NEARLY_ALL = 0.9
GAP = 2.5
"""Messages further apart than this multiple of the usual step have a gap between them."""
_TYPES = {
    "time": "d",
    "robot": "i",
    "x": "f",
    "y": "f",
    "node": "i",
    "driving": "b",
    "load": "b",
    "action": "b",
    "charge": "f",
    "fault": "b",
}
_LOGICAL = ("driving", "load", "fault")
UNSAID = -1
"""In the column `load`: the message does not say whether the robot is loaded."""
LATE = 30.0
"""Seconds by which a message may come after a later one; beyond that the clock has jumped."""


@dataclass
class Notes:
    """Findings while reading a log: rows, bad rows (the first 20 by name), and faults of its time stamps.

    `late` are messages that came after later ones of their robot and stand in order now. `jumps` are those left out
    as the robot's clock ran back, or ahead for a moment. `gaps` are times without messages, `missing` seconds in all.
    `backwards`: the file has its newest message first. `assumed`: how its times are read, in words.
    """

    rows: int = 0
    bad: int = 0
    problems: list[str] = field(default_factory=list)
    duplicates: int = 0
    late: int = 0
    jumps: int = 0
    gaps: int = 0
    missing: float = 0.0
    backwards: bool = False
    assumed: list[str] = field(default_factory=list)

    def refuse(self, place: str, why: str) -> None:
        """Count a bad row, and name it if it is among the first."""
        self.bad += 1
        if len(self.problems) < MOST_PROBLEMS:
            self.problems.append(f"{place}: {why}")

    def lines(self) -> list[str]:
        """Remarks on the log, in words; empty where nothing was wrong."""
        lines = [*self.assumed, *self.problems]
        if self.bad > len(self.problems):
            lines.append(f"and {self.bad - len(self.problems):,} more bad rows")
        if self.backwards:
            lines.append("the newest message stands first: read from the end")
        counts = {
            "duplicates left out": self.duplicates,
            "messages that came late": self.late,
            "messages left out, as a clock jumped": self.jumps,
            f"gaps, {self.missing / 60:,.0f} robot minutes in all": self.gaps,
        }
        return lines + [f"{count:,} {what}" for what, count in counts.items() if count]


@dataclass(frozen=True)
class FleetLog:
    """Log of a fleet on one day: `table` is sorted by robot and time.

    Attributes:
        name: name of the file or folder.
        table: time (s, from `begin`), robot, x, y, node (the last that was reached), driving, load, action (a code of
            `ACTIONS`), charge (per cent, nan: not said) and fault; robot and node are numbers of `robots`, `nodes`.
        begin: the first time stamp, in seconds since 1970, or 0 for a run.
        step: the usual time between two messages of a robot; 0: the log has trips, one row where each begins and ends.
    """

    name: str
    table: pd.DataFrame
    robots: tuple[str, ...]
    nodes: tuple[str, ...]
    begin: float
    step: float
    notes: Notes

    @property
    def length(self) -> float:
        """The time from the first message to the last, in seconds."""
        return float(self.table["time"].max()) if len(self.table) else 0.0

    def in_short(self) -> str:
        """Summary of the log in one line, which reveals wrong units: robots, begin, length, levels of charge."""
        begin = dt.datetime.fromtimestamp(self.begin, dt.UTC).strftime("from %Y-%m-%d %H:%M on, " if self.begin else "")
        hours = f"{self.length / HOUR:,.1f} h"
        parts = [f"{self.name}: {number_of(len(self.robots), 'robot')}", f"{begin}{hours}"]
        levels = self.table["charge"].dropna()
        if len(levels):
            parts.append(f"charge {levels.min():.3g} to {levels.max():.3g} %")
            if levels.max() <= 1.0 and levels.max() > 0.0:
                parts.append("doubtful, as messages have per cent and not shares")
        return ", ".join(parts)


class Collector:
    """Takes the rows of a log one by one, in the order of the file, and makes a `FleetLog` of them."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.notes = Notes()
        self._columns = {name: array(code) for name, code in _TYPES.items()}
        self._add = [column.append for column in self._columns.values()]
        self._robots: dict[tuple[str, str], int] = {}
        self._nodes: dict[str, int] = {}

    def add(self, time: float, robot: tuple[str, str], x: float, y: float, node: str, *rest: float) -> None:
        """Add a row; `robot`: its serial number and maker; `rest`: driving, load, action, charge, fault."""
        number = self._robots.setdefault(robot, len(self._robots))
        place = self._nodes.setdefault(node, len(self._nodes))
        for count, limit in ((number, "robots"), (place, "nodes")):
            if count >= LIMITS[limit][0]:
                raise ReportError(f"{self.name}: more than {LIMITS[limit][0]:,} {limit}, expected the log of a fleet")
        for put, value in zip(self._add, (time, number, x, y, place, *rest), strict=True):
            put(value)  # type: ignore[arg-type]

    def log(self, *, trips: bool = False) -> FleetLog:
        """Make the log: all rows in order, without impossible ones.

        Raises:
            ReportError: a log without a single good row.
        """
        import pandas as pd

        notes = self.notes
        notes.rows = len(self._columns["time"]) + notes.bad
        if not len(self._columns["time"]):
            first = f"; {notes.problems[0]}" if notes.problems else ""
            raise ReportError(f"{self.name}: no rows that can be read, expected a log of a fleet{first}")
        columns: dict[str, Any] = {
            name: np.frombuffer(column, column.typecode) for name, column in self._columns.items()
        }
        if not trips:
            notes.backwards = _backwards(columns["robot"], columns["time"])
            columns = {name: column[:: -1 if notes.backwards else 1] for name, column in columns.items()}
            columns["time"] = self._on_one_clock(columns["robot"], columns["time"])
            keep = _in_order(columns["robot"], columns["time"], notes)
            self._check_left()
            columns = {name: column[keep] for name, column in columns.items()}
        if trips:
            keep = np.lexsort((columns["time"], columns["robot"]))
            columns = {name: column[keep] for name, column in columns.items()}
        if (columns["load"] == UNSAID).all():
            columns["load"] = _carried(columns["robot"], columns["action"])
        self._check_length(columns["time"], columns["robot"])
        begin, step = float(columns["time"].min()), 0.0
        if not trips:
            gaps = np.diff(columns["time"])[np.diff(columns["robot"]) == 0]
            step = float(np.median(gaps)) if len(gaps) else 0.0
            long = gaps[gaps > GAP * step]
            notes.gaps, notes.missing = len(long), float(long.sum() - len(long) * step)
        columns["time"] = columns["time"] - begin
        table = pd.DataFrame({name: value == 1 if name in _LOGICAL else value for name, value in columns.items()})
        return FleetLog(self.name, table, self._names(), tuple(self._nodes), begin, step, notes)

    def _names(self) -> tuple[str, ...]:
        """Return names of the robots: their serial numbers, with the maker where two have the same."""
        serials = Counter(serial for serial, _ in self._robots)
        return tuple(serial if serials[serial] == 1 else f"{serial} of {maker}" for serial, maker in self._robots)

    def _on_one_clock(self, robot: NDArray[Any], time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Correct times (s) for robots' clocks that are off, and for a clock change.

        What was put right is noted.
        """
        names, notes = self._names(), self.notes
        for number, ahead in _clocks_ahead(robot, time).items():
            time = time - ahead * (robot == number)
            side = "ahead of" if ahead > 0 else "behind"
            notes.assumed.append(
                f"the clock of {got(names[number])} is {abs(ahead):,.0f} s {side} the others': put right"
            )
        change = _clock_change(robot, time)
        if change is not None:
            hour, time = change
            when = dt.datetime.fromtimestamp(hour, dt.UTC).strftime("%Y-%m-%d %H:%M")
            notes.assumed.append(f"all clocks jump by an hour at {when}: a clock change, put right")
        return time

    def _check_left(self) -> None:
        """Refuse a log with too many messages that would be left out."""
        notes, rows = self.notes, len(self._columns["time"])
        for count, most, why, cure in (
            (notes.jumps, _MOST_JUMPS, "clocks run back or ahead", "in order of time; sort the file by time stamp"),
            (notes.duplicates, _MOST_DUPLICATES, "their robot has another of the same time", "with the time of each"),
        ):
            if count > most * rows:
                raise ReportError(
                    f"{self.name}: {count:,} of {rows:,} messages would be left out, as {why}; expected messages {cure}"
                )

    def _check_length(self, time: NDArray[np.float64], robot: NDArray[Any]) -> None:
        """Refuse a log of many days: its clocks are nearly always wrong."""
        first, last = int(time.argmin()), int(time.argmax())
        days = float(time[last] - time[first]) / DAY
        if days > MOST_DAYS:
            names = self._names()
            ends = " to ".join(f"{_date(float(time[row]))} ({got(names[robot[row]])})" for row in (first, last))
            raise ReportError(
                f"{self.name}: {days:,.0f} days, {ends}, expected {MOST_DAYS} at most; split the file by days, or "
                "leave out robots whose clocks are wrong"
            )


def _date(time: float) -> str:
    return dt.datetime.fromtimestamp(time, dt.UTC).strftime("%Y-%m-%d")


def _clocks_ahead(robot: NDArray[Any], time: NDArray[np.float64]) -> dict[int, float]:
    """Return offsets of robots' clocks from the others' in seconds, by robot, from the order of messages in the log.

    Messages that stand together in the log came together. One in order of its times says nothing of clocks, and two
    robots do not say which of them is wrong.
    """
    import pandas as pd

    together = _TOGETHER * (int(robot.max()) + 1)
    rows = len(time) // together * together
    off = time[:rows] - np.repeat(np.median(time[:rows].reshape(-1, together), axis=1), together)
    ahead = pd.Series(off).groupby(robot[:rows]).median()
    ahead -= ahead.median()
    wrong = ahead[ahead.abs() > LATE]
    return dict(zip(wrong.index.tolist(), wrong.tolist(), strict=True)) if len(wrong) * 2 < len(ahead) else {}


def _clock_change(robot: NDArray[Any], time: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]] | None:
    """Find the hour at which all clocks jump by an hour, and times on the clock before it; None without a jump.

    An hour ahead may be a gap, unless it is in a night of Sunday in spring or autumn; an hour back is none.
    """
    by_robot = np.argsort(robot, kind="stable")
    steps, same = np.diff(time[by_robot]), np.diff(robot[by_robot]) == 0
    before, after = time[by_robot][:-1], time[by_robot][1:]
    hours = np.ceil(before / HOUR) * HOUR
    for way in (1, -1):
        late = after - hours - way * HOUR
        jumps = same & (hours - before < _NEAR) & (late >= 0) & (late < _NEAR)
        if not jumps.any():
            continue
        hour = float(np.median(hours[jumps]))
        crossed = len(set(robot[time < hour - _NEAR].tolist()) & set(robot[time > hour + _NEAR].tolist()))
        if len(set(robot[by_robot][1:][jumps & (hours == hour)].tolist())) < _NEARLY_ALL * crossed:
            continue
        if way > 0:
            if not _is_night_of_change(hour) or ((time >= hour) & (time < hour + HOUR)).any():
                continue
            return hour, np.where(time >= hour + HOUR, time - HOUR, time)
        back = same & (steps < -LATE) & (np.abs(before - hour) <= HOUR)
        later = np.cumsum(back) - np.maximum.accumulate(np.where(same, 0, np.cumsum(back)))
        changed = time.copy()
        changed[by_robot[1:]] += HOUR * (later > 0)
        return hour, changed
    return None


def _is_night_of_change(hour: float) -> bool:
    """Whether clocks change at such an hour: before 4 on a Sunday, in spring or autumn."""
    date = dt.datetime.fromtimestamp(hour, dt.UTC)
    return date.weekday() == _SUNDAY and date.hour < _MORNING and date.month in _CHANGES


def _backwards(robot: NDArray[Any], time: NDArray[np.float64]) -> bool:
    """Whether nearly all messages of robots come before the one above them."""
    by_robot = np.argsort(robot, kind="stable")
    steps = np.diff(time[by_robot])[np.diff(robot[by_robot]) == 0]
    return bool((steps < 0).sum() > _NEARLY_ALL * len(steps[steps != 0]))


def _in_order(robot: NDArray[Any], time: NDArray[np.float64], notes: Notes) -> NDArray[np.int64]:
    """Return the numbers of the rows that stay, sorted by robot and time; counts the others in the notes."""
    by_robot = np.argsort(robot, kind="stable")
    kept = []
    for mine in np.split(by_robot, np.flatnonzero(np.diff(robot[by_robot])) + 1):
        times = time[mine]
        ahead = np.zeros(len(times), bool)
        ahead[1:-1] = (times[1:-1] - times[:-2] > FAR) & (times[1:-1] - times[2:] > FAR)
        back = np.maximum.accumulate(np.where(ahead, -np.inf, times)) - times
        jumped = ahead | (back >= LATE)
        rows = mine[~jumped]
        rows = rows[np.argsort(time[rows], kind="stable")]
        again = np.diff(time[rows], prepend=-np.inf) == 0
        notes.jumps += int(jumped.sum())
        notes.late += int(((back > 0) & ~jumped).sum())
        notes.duplicates += int(again.sum())
        kept.append(rows[~again])
    return np.concatenate(kept)


def _carried(robot: NDArray[Any], action: NDArray[Any]) -> NDArray[np.int8]:
    """Return whether each robot is loaded, by its last action, where no message says it.

    It is loaded after a pick, until a drop ends.
    """
    handling = np.isin(action, (PICK, DROP))
    last = np.maximum.accumulate(np.where(handling, np.arange(len(action)), -1))
    acted = (last >= 0) & (robot[last] == robot)
    then = np.where(acted, action[last], NOTHING)
    loaded: NDArray[np.int8] = (((then == PICK) & (action != PICK)) | (action == DROP)).astype(np.int8)
    return loaded
