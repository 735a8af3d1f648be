"""What robots draw from their batteries in each state, and how fast they charge, from levels that are rounded.

Most robots send whole per cents, so levels are read where they step. A step lies between two messages, and what the
level gained from one step to another is exact, rounded or cut off. A charge from its first message to its last missed
up to a step at either end, mostly the same one: with whole per cents that are cut off the rate was 1.1 % low, and 0
of 12 intervals held it. Of 160 made-up logs of 6 h, 40 with each way of rounding, 159 hold it now
(`tests/fleet_log/test_levels.py`).

Consumption comes from these steps in windows of a quarter of an hour, with intervals from leaving one window out.
Levels at set times are off by up to half a step, and after charges that end at one level all alike: 17 of 24
intervals held the truth with whole per cents, now 77 of 80 do, and they are 60 times narrower. Half of the time
between two messages counts as before the step: with all of it, driving empty came out up to 3 % low.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.fleet_log.estimates import FEWEST, KeyEstimate, short, t_quantile, unknown
from desim_warehouse.fleet_log.floor import Tracks
from desim_warehouse.fleet_log.handling import episodes
from desim_warehouse.fleet_log.table import CHARGE, DROP, PICK
from desim_warehouse.model.facts.charging import charge_alike

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


_STATES = ("standing", "empty", "loaded", "handling")
_WINDOW = 900.0
"""Seconds of discharging that count as one observation: what is wrong with it at one end is so at the other."""
_POINTS = 60.0
"""Seconds between two levels that are read: those nearer say nothing more."""
_BEYOND = 1000.0
"""More than any level, in per cent."""
_FULL = 0.8
"""Share of the capacity above which charging may slow down."""
_SHARE = 0.01
"""States in which robots spend less of their time are not told apart."""


def energy(tracks: Tracks) -> list[KeyEstimate]:
    """Consumption by state and charge rate, in the energy unit of the model."""
    battery = tracks.model.battery
    keys = "battery.consumption", "battery.charge_rate", "battery.taper"
    if battery is None:
        return [unknown("battery", "the model has none")]
    if not charge_alike(tracks.model):
        return [unknown(key, "kinds of robots have batteries or chargers of their own") for key in keys]
    if not np.isfinite(tracks.charge).any() or np.nanmax(tracks.charge) == np.nanmin(tracks.charge):
        return [unknown(key, "the log has no levels of charge") for key in keys]
    found = _consumption(tracks, battery.capacity / 100)
    if tracks.model.policies.charging.name == "swap":
        return [*found, unknown(keys[1], "batteries are swapped")]
    return [
        *found,
        _charge_rate(tracks, battery.capacity / 100),
        unknown(keys[2], "levels near full are too coarse: measure it at a charger"),
    ]


def _kinds(tracks: Tracks) -> NDArray[np.int64]:
    """Each message's state by its number in `_STATES`; -1: charging, or in a bay with chargers: connected, perhaps."""
    moving = tracks.driving & ~tracks.fault
    kind = np.where(moving, np.where(tracks.load, 2, 1), 0)
    kind[np.isin(tracks.action, (PICK, DROP)) & ~tracks.fault] = 3
    names = list(tracks.model.floor.graph)
    bays = [names.index(node) for node, bay in tracks.model.floor.bays.items() if bay.chargers != 0]
    kind[(kind == 0) & np.isin(tracks.node, bays) & ~tracks.fault & ~tracks.load] = -1
    kind[tracks.action == CHARGE] = -1
    return kind


def _consumption(tracks: Tracks, per_cent: float) -> list[KeyEstimate]:
    """Rates by least squares of levels on the time spent in each state, window by window, errors by leaving one out."""
    kind = _kinds(tracks)
    seconds = tracks.model.units.seconds
    usable = (kind >= 0) & np.isfinite(tracks.charge) & (tracks.charge > 0)
    goes_on = usable[1:] & usable[:-1] & tracks.joined[1:]
    run = np.concatenate([[0], np.cumsum(~goes_on)])
    spent = np.zeros((len(kind), len(_STATES)))
    half = np.diff(tracks.time, prepend=tracks.time[0]) / 2
    half[~np.concatenate([[False], goes_on])] = 0.0
    for shift in (0, 1):  # the state changed anywhere between two messages: half of the time to each
        state = kind if not shift else np.concatenate([[0], kind[:-1]])
        rows = np.flatnonzero(half > 0)
        spent[rows, state[rows]] += half[rows]
    since = np.cumsum(spent, axis=0)
    first = np.concatenate([[True], ~goes_on])
    begin = np.maximum.accumulate(np.where(first, np.arange(len(kind)), 0))
    age = (tracks.time - tracks.time[begin]) * seconds
    window = np.unique(np.stack([run, age // _WINDOW]), axis=1, return_inverse=True)[1].ravel()
    falls = np.flatnonzero(usable & ~first & _falls(np.where(usable, tracks.charge, 0.0), run))
    ticks = np.stack([run[falls], age[falls] // _POINTS])
    point = falls[np.append(True, (np.diff(ticks) != 0).any(axis=0))] if len(falls) else falls
    hours = np.array([float(tracks.before[kind == state].sum()) for state in range(len(_STATES))])
    fell = (since[point] + since[point - 1]) / 2  # anywhere between two messages
    return _regressed(fell, tracks.charge[point] * per_cent, window[point], hours)


def _falls(level: Floats, run: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Messages whose level is below all before in their run, the first among them: between others falls are exact."""
    lowest = np.minimum.accumulate(level - _BEYOND * run)
    return np.diff(lowest, prepend=0.0) < 0


def _regressed(spent: Floats, level: Floats, window: NDArray[np.int64], hours: Floats) -> list[KeyEstimate]:
    """Rates of states in which robots spent `hours`, from levels and the time spent in each state before them."""
    window = np.unique(window, return_inverse=True)[1]
    count = np.bincount(window)

    def apart(values: Floats) -> Any:
        """Without the mean of each window."""
        return values - (np.bincount(window, values) / count)[window]

    matrix = np.stack([apart(column) for column in spent.T], axis=1)
    drop = -apart(level)
    windows = int((count > 1).sum())
    keys = [f"battery.consumption.{state}" for state in _STATES]
    use = hours > _SHARE * hours.sum()
    if windows < len(_STATES) + FEWEST:
        return [unknown(key, f"{windows} quarters of an hour of discharging are too few", windows) for key in keys]
    rate, half = _jackknifed(matrix[:, use], drop, window, windows)
    found, rank = [], 0
    for key, is_used in zip(keys, use, strict=True):
        if not is_used:
            found.append(unknown(key, "robots were hardly ever in that state"))
            continue
        value, reach = float(rate[rank]), float(half[rank])
        rank += 1
        low, high = max(value - reach, 0.0), value + reach
        what = "quarters of an hour"
        if value <= 0:
            found.append(unknown(key, f"less than {high:.3g}, and not told from 0", windows, what))
        else:
            found.append(KeyEstimate(key, short(value), value, low, high, windows, what))
    return found


def _jackknifed(matrix: Floats, drop: Floats, window: NDArray[np.int64], windows: int) -> tuple[Floats, Floats]:
    """Rates by least squares, and the half-widths of their intervals from leaving out one window after the other."""
    states = matrix.shape[1]
    squares = np.zeros((int(window.max()) + 1, states, states))
    moments = np.zeros((len(squares), states))
    np.add.at(squares, window, matrix[:, :, None] * matrix[:, None, :])
    np.add.at(moments, window, matrix * drop[:, None])
    rate = np.linalg.pinv(squares.sum(axis=0)) @ moments.sum(axis=0)
    without = np.linalg.pinv(squares.sum(axis=0) - squares) @ (moments.sum(axis=0) - moments)[:, :, None]
    spread = ((without[:, :, 0] - rate) ** 2).sum(axis=0) * (windows - 1) / windows
    return rate, t_quantile(windows - states) * np.sqrt(spread)


def _charge_rate(tracks: Tracks, per_cent: float) -> KeyEstimate:
    """Energy gained by time at a charger, below the level where charging may slow down."""
    key = "battery.charge_rate"
    taper = tracks.model.battery.taper if tracks.model.battery is not None else None
    most = 100 * min(_FULL, taper.start if taper is not None else 1.0)
    begun, ended, gain = _between_steps(tracks, (tracks.action == CHARGE) & (tracks.charge < most) & tracks.joined)
    time = ended.mean(axis=1) - begun.mean(axis=1)
    long = time * tracks.model.units.seconds > _POINTS
    begun, ended, time, gain = begun[long], ended[long], time[long], gain[long] * per_cent
    n = len(time)
    if n < 2:  # noqa: PLR2004 - they must be able to differ
        return unknown(key, f"{n} charges of more than a minute below {most:g} % are too few", n, "charges")
    rate = float(gain.sum() / time.sum())
    blur = rate**2 * sum(float((np.diff(ends, axis=1) ** 2).sum()) / 12 for ends in (begun, ended))
    spread = math.sqrt(max(float(((gain - rate * time) ** 2).sum()) * n / (n - 1), blur))
    half = t_quantile(n - 1) * spread / float(time.sum())
    if rate <= half:
        return unknown(key, "levels do not rise at chargers", n, "charges")
    return KeyEstimate(key, short(rate), rate, rate - half, rate + half, n, f"charges below {most:g} %")


def _between_steps(tracks: Tracks, so: NDArray[np.bool_]) -> tuple[Floats, Floats, Floats]:
    """From the first rise of the level in each stretch to the last: the bounds of both instants, and the gain.

    A rounded level rises between two messages. The gain from one rise to another is exact, however it is rounded.
    """
    stretches = episodes(tracks, so)
    begun, ended, gain = [], [], []
    for first, last in zip(stretches.first.tolist(), stretches.last.tolist(), strict=True):
        level = np.maximum.accumulate(tracks.charge[first : last + 1])
        rises = np.flatnonzero(np.diff(level) > 0) + 1
        if len(rises) > 1:
            one, other = rises[0], rises[-1]
            begun.append(tracks.time[[first + one - 1, first + one]])
            ended.append(tracks.time[[first + other - 1, first + other]])
            gain.append(level[other] - level[one])
    return np.reshape(begun, (-1, 2)), np.reshape(ended, (-1, 2)), np.array(gain)
