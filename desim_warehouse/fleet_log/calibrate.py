"""Calibration of a model from logs of its real fleet: estimates with intervals and evidence, or not identified.

`calibrate` brings together the figures for driving, handling, breakdowns and demand, which have modules of their own.
Consumption in each state and the charge rate are estimated here, by `energy`, from levels that are rounded.

Most robots send whole per cents, so levels are read where they step. A step lies between two messages, and what the
level gained from one step to another is exact, rounded or cut off. A charge from its first message to its last missed
up to a step at either end, mostly the same one: with whole per cents that are cut off the rate was 1.1 % low, and 0
of 12 intervals held it. Of 160 made-up logs of 6 h, 40 with each way of rounding, 159 hold it now
(`tests/fleet_log/test_levels.py`).

Consumption comes from these steps in windows of a quarter of an hour, with intervals from leaving one window out.
Levels at set times are off by up to half a step, and after charges that end at one level all alike: 17 of 24
intervals held the truth with whole per cents, now 779 of 800 do, and they are 50 times narrower. Half of the time
between two messages counts as before the step: with all of it, driving empty came out up to 3 % low.
"""

from __future__ import annotations

import io
import math
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.text import WIDTH, printed_table
from desim_warehouse.errors import first_of, number_of
from desim_warehouse.fleet_log import read_logs
from desim_warehouse.fleet_log.demand import as_flow, as_they_are, demand
from desim_warehouse.fleet_log.estimates import CONFIDENCE, FEWEST, KeyEstimate, short, t_quantile, unknown
from desim_warehouse.fleet_log.floor import Tracks, lay_over
from desim_warehouse.fleet_log.handling import breakdowns, episodes, handling
from desim_warehouse.fleet_log.motion import DrivingTimes
from desim_warehouse.fleet_log.table import CHARGE, DROP, PICK, FleetLog
from desim_warehouse.model import Model, Source, as_model
from desim_warehouse.model.facts.charging import charge_alike
from desim_warehouse.model.overrides import UNSET
from desim_warehouse.values.arrays import Flags, Floats, Ints
from desim_warehouse.values.dates import Slashes

if TYPE_CHECKING:
    import pandas as pd
    from ruamel.yaml import YAML

_NEVER_SHOWN = "a log does not show who is sent where (policies.allocation), nor the distance that robots keep"
_HEAD = ("figure", "mean, and 95 % interval", "from")
_NAMED = 12
_OFTEN = 3
"""Passages from which on an edge is said to be missing in the model."""
_CONSUMPTION = "battery.consumption"

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


@dataclass(frozen=True, repr=False)
class Calibration:
    """Estimates of model parameters from logs of the real fleet: the result of `calibrate`.

    `print` shows them as `desim calibrate` does.

    Attributes:
        source: the model file; None for a model that was not given as a file.
        base: the model before calibration.
        estimates: for each key, a value with interval and evidence, or the reason why there is none.
        overrides: changes of the model by dotted key.
        notes: problems of the logs, and disagreements between logs and model.
    """

    source: Path | None
    base: Model
    estimates: tuple[KeyEstimate, ...]
    overrides: dict[str, Any]
    notes: tuple[str, ...]

    @property
    def model(self) -> Model:
        """The calibrated model."""
        return self.base.replace(self.overrides)

    @property
    def ranges(self) -> dict[str, dict[str, Any]]:
        """Interval of each key that was estimated: low, high, confidence and n."""
        ranges = {}
        for estimate in self.estimates:
            if estimate.identified and math.isfinite(estimate.low):
                bounds = {
                    "low": short(estimate.low),
                    "high": short(estimate.high) if math.isfinite(estimate.high) else None,
                }
                ranges[estimate.ranged or estimate.key] = {**bounds, "confidence": CONFIDENCE, "n": estimate.n}
        return ranges

    def files(self, out: Path) -> dict[Path, str]:
        """Return texts by path: the calibrated model file, with a comment for each change, and the ranges beside it.

        The comments of the model file stay; a model that was not given as a file is written whole, defaults too.
        """
        from ruamel.yaml import YAML

        yaml = YAML()
        yaml.indent(sequence=4, offset=2)
        yaml.width = 4096
        content = yaml.load(self._written(yaml))
        by_key = {estimate.key: estimate for estimate in self.estimates}
        for key, value in self.overrides.items():
            _write(content, key.split("."), _relative(value, out.parent), by_key[key].words() if key in by_key else "")
        if _CONSUMPTION in self.overrides:
            for state, section in (
                ("." + state, content["battery"]["consumption"]) for state in self.overrides[_CONSUMPTION]
            ):
                if _CONSUMPTION + state in by_key:
                    section.yaml_add_eol_comment(by_key[_CONSUMPTION + state].words(), state[1:])
        left = [f"{estimate.key}: {estimate.why}" for estimate in self.estimates if not estimate.identified]
        head = "\n".join(["Calibrated by desim calibrate. Not identified, so as they were:", *left])
        content.yaml_set_start_comment(head)
        text, ranges = io.StringIO(), io.StringIO()
        yaml.dump(content, text)
        yaml.dump(self.ranges, ranges)
        return {out: text.getvalue(), out.with_name(f"{out.stem}.ranges.yaml"): ranges.getvalue()}

    def _written(self, yaml: YAML) -> str:
        """Return the model before calibration as its file has it, or as YAML if it was not given as a file."""
        if self.source is not None:
            return self.source.read_text(encoding="utf-8-sig")
        text = io.StringIO()
        yaml.dump(self.base.content(), text)
        return text.getvalue()

    @property
    def table(self) -> pd.DataFrame:
        """A row for each key, in the units of the model: key, value, mean, low, high, evidence.

        Keys that were not identified have no numbers, and the reason as evidence.
        """
        import pandas as pd

        columns = ("key", "value", "mean", "low", "high", "evidence")
        rows = [[getattr(estimate, column) for column in columns] for estimate in self.estimates]
        return pd.DataFrame(rows, columns=list(columns))

    def text(self, width: int = WIDTH) -> str:
        """Return the notes on the logs and the estimates as text, `width` characters wide."""
        units = self.base.units
        rows = [
            (
                words.factor_head(estimate.key, units),
                numbers.within(estimate.mean, estimate.low, estimate.high) if estimate.identified else "not identified",
                estimate.evidence,
            )
            for estimate in self.estimates
        ]
        return "\n".join([printed_table("\n".join(self.notes), _HEAD, rows, width), _NEVER_SHOWN])

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        identified = sum(estimate.identified for estimate in self.estimates)
        return f"Calibration({self.base.name}: {identified} of {number_of(len(self.estimates), 'figure')} identified)"


def calibrate(
    model: Source,
    logs: str | Path | FleetLog | Sequence[str | Path | FleetLog],
    *,
    orders: str | Path | None = None,
    dates: Slashes | None = None,
) -> Calibration:
    """Estimate the parameters of a model from logs of the real fleet.

    Args:
        model: a model, or its file, with the layout and the node names of the real floor.
        logs: one, or one per day: VDA 5050 messages as JSON lines, trips as CSV, or folders of runs.
        orders: a plain table of orders, which becomes the demand of the calibrated model unchanged.
        dates: how to read 03/02/2026 in trips: "us", March 2, or "uk", 3 February.

    Returns:
        For each key a value with interval and evidence, in the units of the model; see `Calibration`.

    Raises:
        ReportError: logs that cannot be read or are of another floor. ModelError: the model or orders.
    """
    base = as_model(model)
    read = read_logs(logs, dates)
    notes = [line for log in read for line in (log.in_short(), *log.notes.lines())]
    tracks = lay_over(base, read) if any(log.step for log in read) else None
    estimates: list[KeyEstimate] = []
    if tracks is not None:
        notes += [*tracks.notes, *_differences(tracks)]
        estimates = [*DrivingTimes(tracks).estimates(), *handling(tracks), *energy(tracks), *breakdowns(tracks)]
    else:
        notes.append("trips alone say nothing of speeds, handling, energy and breakdowns")
    if orders is None:
        estimates += demand(base, read, tracks)
    overrides = _overrides(base, estimates)
    if orders is not None:
        overrides |= as_they_are(base, Path(orders))
    source = Path(model) if isinstance(model, str | Path) else None
    return Calibration(source, base, tuple(estimates), overrides, tuple(notes))


def _overrides(base: Model, estimates: Sequence[KeyEstimate]) -> dict[str, Any]:
    """Return overrides of the model by the estimates: consumption as a section, demand by hour as a flow."""
    overrides: dict[str, Any] = {}
    for estimate in estimates:
        if not estimate.identified:
            continue
        if estimate.key.startswith("tasks.flows."):
            overrides |= as_flow(base, estimate.value)
        elif estimate.key.startswith(_CONSUMPTION):
            assert base.battery is not None
            section = overrides.setdefault(_CONSUMPTION, dict(base.battery.draws.content()))
            section[estimate.key.rpartition(".")[2]] = estimate.value
        else:
            overrides[estimate.key] = estimate.value
    repair = "fleet.robot.breakdowns.repair"
    if repair in overrides and repair.replace("repair", "every") not in overrides:
        del overrides[repair]
    return overrides


def _differences(tracks: Tracks) -> list[str]:
    """Return words for edges that robots drove and the model lacks, and for edges that no robot drove."""
    names = list(tracks.model.floor.graph)
    passed = (np.diff(tracks.node) != 0) & (np.diff(tracks.robot) == 0) & tracks.joined[1:]
    pairs = Counter(zip(tracks.node[:-1][passed].tolist(), tracks.node[1:][passed].tolist(), strict=True))
    strange = [
        f"{names[a]}>{names[b]} ({count} times)"
        for (a, b), count in pairs.most_common()
        if min(a, b) >= 0 and count >= _OFTEN and not tracks.model.floor.graph.has_edge(names[a], names[b])
    ]
    used = {(names[a], names[b]) for a, b in pairs if min(a, b) >= 0}
    unused = [">".join(edge) for edge in tracks.edges if edge not in used]
    return [
        f"{what}: {first_of(some, _NAMED)}"
        for what, some in (("edges that the model lacks", strange), ("edges that no robot drove", unused))
        if some
    ]


def _relative(value: Any, folder: Path) -> Any:
    """Replace the paths of files in a value by paths relative to the folder of the model."""
    if isinstance(value, dict):
        return {
            key: os.path.relpath(item, folder) if key == "file" else _relative(item, folder)
            for key, item in value.items()
        }
    return value


def _write(section: Any, path: list[str], value: Any, comment: str) -> None:
    """Put a value into a file that was read with its comments, in block style, or take the key away."""
    from ruamel.yaml.comments import CommentedMap

    for key in path[:-1]:
        if not isinstance(section.get(key), dict):
            section[key] = CommentedMap()
        section = section[key]
        section.fa.set_block_style()
    if value is UNSET:
        section.pop(path[-1], None)
        return
    section[path[-1]] = _flowing(value) if path[-1] != "consumption" else CommentedMap(value)
    if comment:
        section.yaml_add_eol_comment(comment, path[-1])


def _flowing(value: Any) -> Any:
    """Mark a section to be written on one line."""
    from ruamel.yaml.comments import CommentedMap, CommentedSeq

    if isinstance(value, dict):
        section: Any = CommentedMap((key, _flowing(item)) for key, item in value.items())
    elif isinstance(value, list):
        section = CommentedSeq(map(_flowing, value))
    else:
        return value
    section.fa.set_flow_style()
    return section


def energy(tracks: Tracks) -> list[KeyEstimate]:
    """Estimate consumption by state and charge rate, in the energy unit of the model."""
    battery = tracks.model.battery
    keys = "battery.consumption", "battery.charge_rate", "battery.taper"
    if battery is None:
        return [unknown("battery", "the model has none")]
    if not charge_alike(tracks.model):
        return [unknown(key, "kinds of robots have batteries or chargers of their own") for key in keys]
    if not np.isfinite(tracks.charge).any() or np.nanmax(tracks.charge) == np.nanmin(tracks.charge):
        return [unknown(key, "the log has no levels of charge") for key in keys]
    estimates = _consumption(tracks, battery.capacity / 100)
    if tracks.model.policies.charging.name == "swap":
        return [*estimates, unknown(keys[1], "batteries are swapped")]
    return [
        *estimates,
        _charge_rate(tracks, battery.capacity / 100),
        unknown(keys[2], "levels near full are too coarse: measure it at a charger"),
    ]


def _kinds(tracks: Tracks) -> Ints:
    """Return the number in `_STATES` of each message's state; -1: charging, or in a bay with chargers."""
    moving = tracks.driving & ~tracks.fault
    kind = np.where(moving, np.where(tracks.load, 2, 1), 0)
    kind[np.isin(tracks.action, (PICK, DROP)) & ~tracks.fault] = 3
    names = list(tracks.model.floor.graph)
    bays = [names.index(node) for node, bay in tracks.model.floor.bays.items() if bay.chargers != 0]
    kind[(kind == 0) & np.isin(tracks.node, bays) & ~tracks.fault & ~tracks.load] = -1
    kind[tracks.action == CHARGE] = -1
    return kind


def _consumption(tracks: Tracks, per_cent: float) -> list[KeyEstimate]:
    """Estimate the consumption in each state by least squares within windows of time; errors by jackknife."""
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
    return _regressed(fell, since[point] - since[point - 1], tracks.charge[point] * per_cent, window[point], hours)


def _falls(level: Floats, run: Ints) -> Flags:
    """Whether each level is below all before it in its run, or the first: between two such levels the fall is exact."""
    lowest = np.minimum.accumulate(level - _BEYOND * run)
    return np.diff(lowest, prepend=0.0) < 0


def _regressed(spent: Floats, between: Floats, level: Floats, window: Ints, hours: Floats) -> list[KeyEstimate]:
    """Estimate consumption rates (energy per time) by least squares of levels on the time spent in each state.

    Args:
        spent: a row for each level, a column for each state: the time spent in the state until then.
        between: the part of that time that lies between the message of the level and the one before.
        level: energy in the battery, in each row.
        window: number of the window that each row belongs to; only differences inside a window count.
        hours: time spent in each state, in all; rare states get no rate.
    """
    window = np.unique(window, return_inverse=True)[1]
    count = np.bincount(window)

    def apart(values: Floats) -> Any:
        """Subtract from each value the mean of its window."""
        return values - (np.bincount(window, values) / count)[window]

    matrix = np.stack([apart(column) for column in spent.T], axis=1)
    drop = -apart(level)
    windows = int((count > 1).sum())
    keys = [f"battery.consumption.{state}" for state in _STATES]
    use = hours > _SHARE * hours.sum()
    if windows < len(_STATES) + FEWEST:
        return [unknown(key, f"{windows} quarters of an hour of discharging are too few", windows) for key in keys]
    rate, half = _jackknifed(matrix[:, use], drop, between[:, use], window, windows)
    estimates, rank = [], 0
    for key, is_used in zip(keys, use, strict=True):
        if not is_used:
            estimates.append(unknown(key, "robots were hardly ever in that state"))
            continue
        value, reach = float(rate[rank]), float(half[rank])
        rank += 1
        low, high = max(value - reach, 0.0), value + reach
        what = "quarters of an hour"
        if value <= 0:
            estimates.append(unknown(key, f"less than {high:.3g}, and not told from 0", windows, what))
        else:
            estimates.append(KeyEstimate(key, short(value), value, low, high, windows, what))
    return estimates


def _jackknifed(matrix: Floats, drop: Floats, between: Floats, window: Ints, windows: int) -> tuple[Floats, Floats]:
    """Return least-squares rates, one for each column, and half-widths of their intervals by jackknife over windows.

    Messages and falls of the level may keep step for hours, so that windows agree by chance. So the spread is at least
    that of falls at a random time between two messages.
    """
    states = matrix.shape[1]
    squares = np.zeros((int(window.max()) + 1, states, states))
    moments = np.zeros((len(squares), states))
    np.add.at(squares, window, matrix[:, :, None] * matrix[:, None, :])
    np.add.at(moments, window, matrix * drop[:, None])
    inverse = np.linalg.pinv(squares.sum(axis=0))
    rate = inverse @ moments.sum(axis=0)
    without = np.linalg.pinv(squares.sum(axis=0) - squares) @ (moments.sum(axis=0) - moments)[:, :, None]
    spread = ((without[:, :, 0] - rate) ** 2).sum(axis=0) * (windows - 1) / windows
    blur = ((matrix @ inverse * (between @ rate)[:, None]) ** 2).sum(axis=0) / 12
    return rate, t_quantile(windows - states) * np.sqrt(np.maximum(spread, blur))


def _charge_rate(tracks: Tracks, per_cent: float) -> KeyEstimate:
    """Estimate the energy gained per time at a charger, below the level where charging may slow down."""
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


def _between_steps(tracks: Tracks, charging: Flags) -> tuple[Floats, Floats, Floats]:
    """Return bounds of the first and the last rise of the level in each stretch (n x 2 each), and the gain between (n).

    A rounded level rises between two messages. The gain from one rise to another is exact, however it is rounded.
    """
    stretches = episodes(tracks, charging)
    begun, ended, gain = [], [], []
    for first, last in zip(stretches.first.tolist(), stretches.last.tolist(), strict=True):
        level = np.maximum.accumulate(tracks.charge[first : last + 1])
        rises = np.flatnonzero(np.diff(level) > 0) + 1
        if len(rises) > 1:
            begin, end = rises[0], rises[-1]
            begun.append(tracks.time[[first + begin - 1, first + begin]])
            ended.append(tracks.time[[first + end - 1, first + end]])
            gain.append(level[end] - level[begin])
    return np.reshape(begun, (-1, 2)), np.reshape(ended, (-1, 2)), np.array(gain)
