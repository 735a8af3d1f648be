"""Verdicts: what is wrong with a run or a design, in words. It cannot keep up, drains its batteries, or is jammed.

For the answer of a run, and for every verdict on a design.

The rules are in `RULES`: tables, reports, JSON and the reference in the documentation all read them. They
use indicators, of a run or as means over the runs of a design, so that both are judged alike.

A run counts in full once its batteries have settled (`fall`). Where their mean level falls, what charging costs is
still to come; where it rises, more is charged than will be, and the fleet looks worse than it is. `expected` says what
will be: settled, each robot charges for the part f of its time in which it takes up what it draws in the rest, with e
drawn and g given for each time unit (1 - f) e = f g.

Fewer robots under way may do more. Whether one run shows that, `past_knee` says by comparing its hours with fewer and
with more of them. A floor has a most that it lets through, with some number of robots under way, and lets less
through with more of them: the macroscopic fundamental diagram of road networks (Geroliminis and Daganzo, Transportation
Research B 42 (2008) 759-770). A run draws a part of that curve only where the number under way changes, and long enough
that jams have time to form or to dissolve. So the evaluation period is cut into windows in which a robot does two tasks
on average. Windows with many robots under way are compared with those with fewer. Where the number hardly changes, as
with work always waiting, one run cannot say it, and `desim size --key traffic.most_out` tries it out.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from statistics import fmean, stdev, variance
from typing import NamedTuple

from desim_warehouse.errors import number_of
from desim_warehouse.findings import amount
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import chargers_at, charging_rate, refills_overnight
from desim_warehouse.model.facts.hours import longest_closed, repeats_after
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.indicators import is_of_due

PILES_UP = "CANNOT_KEEP_UP"
LASTING = ("CANNOT_KEEP_UP", "BATTERIES_FALL", "NOT_SETTLED")
"""Verdicts on designs whose time to come is worse than the time simulated, if their size is above 0."""
ERRORS_OF_ARRIVALS = 3
"""Standard errors of the number of arrivals by which a backlog must have grown."""
LEAST_FALL = 0.01
"""Share of the capacity per hour by which batteries must fall."""
CHARGERS_BUSY = 0.95
"""Share of their time from which chargers count as always in use."""
MOST_WAITING = 0.5
"""Share of the fleet's time spent waiting in traffic from which it is jammed."""

LEAST_DRIFT = 0.01
"""Share of the capacity per hour by which the mean level must move."""
CONFIDENCE = 0.99
"""Of the interval that the move must exceed."""

LEAST_WAITING = 0.2
"""Part of the fleet's time in traffic below which nothing is past a knee."""
TASKS_A_WINDOW = 2
"""Tasks that a robot under way does in a window, on average."""
LEAST_WINDOWS = 6
"""Windows with many robots, and with fewer, that are needed."""
STANDARD_ERRORS = 4
"""By which more must be done with fewer robots, of the difference of the two means, beside `LEAST_GAIN`."""
LEAST_GAIN = 0.05
BANDS = 10
"""Windows are put together whose number of robots under way is the same to a tenth of the most."""
FEWER = 8
"""Bands up to this one are held against the highest one."""


@dataclass(frozen=True)
class Verdict:
    """A thing wrong with a run or a design: its code (see `RULES`), in words, and how much of it there is."""

    code: str
    text: str
    size: float

    def content(self) -> dict[str, str]:
        """Return the verdict as JSON has it."""
        return {"code": self.code, "text": self.text}

    @property
    def is_lasting(self) -> bool:
        """Whether the long run is worse than the run simulated, whatever its indicators say."""
        return self.code in LASTING and self.size > 0

    @property
    def mark(self) -> str:
        """The mark of a design in a table."""
        return RULES[self.code].mark


@dataclass(frozen=True)
class VerdictRule:
    """A rule for a verdict, in words (`when`) and by `size`: how much is wrong, None: nothing is.

    `mark`: in tables. `text`: the verdict, with the size to be put in as `{}`, `scale` times. Without `size` only the
    log of a run says it (`judge_run`).
    """

    mark: str
    text: str
    when: str
    size: Callable[[Mapping[str, float], Model], float | None] | None
    scale: float = 1.0


def _cannot_keep_up(kpis: Mapping[str, float], model: Model) -> float | None:
    """Return the growth per hour of the tasks not done, or of the load units in stations not worked on."""
    growths = [growth for growth in (_tasks_pile_up(kpis, model), _work_piles_up(kpis, model)) if growth is not None]
    return max(growths, default=None)


def _work_piles_up(kpis: Mapping[str, float], model: Model) -> float | None:
    """Return the growth per hour of load units put down and not worked on, from none at the start of the run.

    As much as may be by chance is allowed for, as where tasks arrive at random (see `_tasks_pile_up`).
    """
    left, end, counted = kpis.get("work_backlog", 0.0), kpis.get("T", math.nan), _counted(kpis, model)
    if not model.tasks.never_end or not left or not counted:
        return None
    put_down = left + kpis.get("worked", 0.0) * end / counted
    chance = ERRORS_OF_ARRIVALS * math.sqrt(put_down) + put_down * min(longest_closed(model) / end, 1.0)
    return left / end * model.units.hour if left > max(chance, model.fleet.size) else None


def _tasks_pile_up(kpis: Mapping[str, float], model: Model) -> float | None:
    """Return the growth of the backlog per hour.

    If demand just equalled what the fleet can do, the backlog after n arrivals would have moved by about as much as
    the number of arrivals is off its mean: sqrt(n), the standard deviation of a Poisson count. A stable queue stays
    below that.
    """
    growth, hours = kpis.get("backlog_growth_per_hour", math.nan), _counted(kpis, model) / model.units.hour
    if not model.tasks.arrive or not math.isfinite(growth):
        return None
    grown = growth * hours
    arrivals = kpis.get("tasks", 0.0) + grown
    chance = ERRORS_OF_ARRIVALS * math.sqrt(max(arrivals, 0.0))
    if hours:  # what comes while a station is closed, or robots are off, may still wait at the end
        chance += arrivals * min(longest_closed(model) / model.units.hour / hours, 1.0)
    return growth if grown > max(chance, model.fleet.size) else None


def _batteries_fall(kpis: Mapping[str, float], model: Model) -> float | None:
    """Return the fall of the mean level per hour, as a share of the capacity."""
    fall = -kpis.get("energy_drift_per_hour", math.nan)
    if model.battery is None or not model.tasks.never_end or not fall >= LEAST_FALL or _refills(fall, model):
        return None
    if kpis.get("charger_utilisation", 0.0) >= CHARGERS_BUSY:
        return fall
    chargers = sum(chargers_at(model, model.floor).values())
    gives = chargers * charging_rate(model) * _counted(kpis, model) if chargers else 0.0
    return fall if kpis.get("energy", 0.0) > gives else None


def _jammed(kpis: Mapping[str, float], _: Model) -> float | None:
    """Return the share of the fleet's time that is waiting in traffic."""
    share = kpis.get("share_waiting", math.nan)
    return share if share >= MOST_WAITING else None


def _ends_in_warm_up(kpis: Mapping[str, float], model: Model) -> float | None:
    """Return how long before the end of the warm-up the run ended, None if it did not."""
    early = model.run.warm_up - kpis.get("T", math.nan)
    return early if early > 0 else None


def _counted(kpis: Mapping[str, float], model: Model) -> float:
    """Return the evaluation period in the unit of the model; the whole run if it ends before its warm-up does."""
    end, warm_up = kpis.get("T", math.nan), model.run.warm_up
    return end - warm_up if end >= warm_up else end


RULES = {
    "CANNOT_KEEP_UP": VerdictRule(
        "backlog",
        "cannot keep up: open orders grow by {} an hour",
        "tasks arrive at random (`poisson`), and in the counted time the backlog grows by more than "
        f"{ERRORS_OF_ARRIVALS} √n, where n is the number of tasks that arrived in it (√n is the standard deviation of "
        "that number), and by more than one task per robot, leaving out what comes on average in the longest time "
        "outside the hours of a station, or of robots; or as many load units pile up in stations (`work_time`) without "
        "being worked on",
        _cannot_keep_up,
    ),
    "BATTERIES_FALL": VerdictRule(
        "batteries",
        "batteries fall by {} % an hour: not sustainable",
        f"work never ends, the fleet's mean level falls by at least {100 * LEAST_FALL:g} % of the capacity an hour, "
        "and the fleet draws more than its chargers could give if they were always in use, or they are in use for "
        f"{100 * CHARGERS_BUSY:g} % of the time",
        _batteries_fall,
        scale=100,
    ),
    "NOT_SETTLED": VerdictRule(
        "not settled",
        "not settled: batteries {} % an hour in the counted time; {}",
        "work never ends, and in the counted time the fleet's mean level falls, or rises, by at least "
        f"{100 * LEAST_DRIFT:g} % of the capacity an hour and by more than its {100 * CONFIDENCE:g} % "
        "confidence interval: for a run from the changes of its robots, for a design from those of its runs; one robot "
        "alone, or one run of a design, has no interval. Fleets that begin settled, a whole day after which hours and "
        "rates repeat, and runs with the verdict above do not get this one. If the level rises, a fleet looks worse "
        "than it will be. A day by the clock that begins with full batteries gets neither verdict if chargers fill "
        "them before the next",
        None,
    ),
    "JAMMED": VerdictRule(
        "jammed",
        "jammed: robots wait in traffic {} % of the time",
        f"the robots wait in traffic for at least {100 * MOST_WAITING:g} % of their time",
        _jammed,
        scale=100,
    ),
    "PAST_KNEE": VerdictRule(
        "past the knee",
        "past the knee: at most {} robots under way (traffic.most_out) would get more done than {} do",
        "only for a run whose log shows it: in the counted time the number of robots under way changes, and at least "
        f"{LEAST_WINDOWS} windows of time with fewer of them (up to {10 * FEWER} % of the most) get more done on "
        f"average than at least {LEAST_WINDOWS} with the most, by {100 * LEAST_GAIN:g} % and {STANDARD_ERRORS} "
        f"standard errors; a window lasts as long as a robot takes for {TASKS_A_WINDOW} tasks, and the robots wait for "
        f"at least {100 * LEAST_WAITING:g} % of their time",
        None,
    ),
    "ENDS_IN_WARM_UP": VerdictRule(
        "warm-up",
        "the run ended before its warm-up: the indicators count the whole run, its start too",
        "the work is done before `run.warm_up` is over; nothing is left out then",
        _ends_in_warm_up,
    ),
}
"""By code, in the order in which verdicts are listed."""


def piles_up(verdicts: Iterable[Verdict]) -> bool:
    """Whether the backlog of a run or design grows: cycle times of the tasks done then leave out ever more tasks."""
    return any(verdict.code == PILES_UP for verdict in verdicts)


def is_no_answer(indicator: str, verdicts: Iterable[Verdict]) -> bool:
    """Whether work piles up, so that an indicator says nothing: the share in time falls with the run's length."""
    return is_of_due(indicator) and piles_up(verdicts)


def judge(kpis: Mapping[str, float], model: Model) -> list[Verdict]:
    """Return the verdicts on a run, from its indicators, or on a design, from the means of its runs."""
    verdicts = []
    for code, rule in RULES.items():
        size = None if rule.size is None else rule.size(kpis, model)
        if size is not None:
            verdicts.append(Verdict(code, rule.text.format(_shown(rule.scale * size)), size))
    return verdicts


def judge_run(kpis: Mapping[str, float], history: History) -> list[Verdict]:
    """Return the verdicts on a run, also those that only its log shows."""
    moves = drifts_of_robots(history) if _may_move(kpis) else []
    verdicts, past = _with_drift(judge(kpis, history.model), moves, kpis, history.model), past_knee(history)
    if past is not None:
        code = "PAST_KNEE"
        verdicts.append(Verdict(code, RULES[code].text.format(past.cap, past.many), past.gain))
    return verdicts


def judge_design(runs: Sequence[Mapping[str, float]], model: Model, part: float = 1.0) -> list[Verdict]:
    """Return the verdicts on a design, from its runs: by the mean of each indicator over the runs that have it.

    `part`: the share of the error (alpha) to spend, where a design is judged again as runs come in.
    """
    values: defaultdict[str, list[float]] = defaultdict(list)
    for run in runs:
        for name, value in run.items():
            if math.isfinite(value):
                values[name].append(value)
    means = {name: math.fsum(numbers) / len(numbers) for name, numbers in values.items()}
    return _with_drift(judge(means, model), values["energy_drift_per_hour"], means, model, part)


def _may_move(kpis: Mapping[str, float]) -> bool:
    return abs(kpis.get("energy_drift_per_hour", 0.0)) >= LEAST_DRIFT


def _with_drift(
    verdicts: list[Verdict], moves: Sequence[float], kpis: Mapping[str, float], model: Model, part: float = 1.0
) -> list[Verdict]:
    """Insert the verdict that batteries have not settled at its rank in the list."""
    size = fall(moves, model, part)
    if size is None or any(verdict.code == "BATTERIES_FALL" for verdict in verdicts):
        return verdicts
    moves_by = f"{'fall' if size > 0 else 'rise'} by {_shown(100 * abs(size))}"
    text = RULES["NOT_SETTLED"].text.format(moves_by, expected(kpis, model))
    order, new = list(RULES), Verdict("NOT_SETTLED", text, size)
    return sorted([*verdicts, new], key=lambda verdict: order.index(verdict.code))


def _shown(value: float) -> str:
    """Return a value with two significant digits."""
    return f"{value:,.0f}" if value >= 10 else f"{value:.1f}".removesuffix(".0")  # noqa: PLR2004


def drifts_of_robots(history: History) -> list[float]:
    """Return by how much the level of each robot moved in the evaluation period: shares of the capacity an hour."""
    import numpy as np

    hours = history.counted / history.model.units.hour
    if not history.batteries or not hours:
        return []
    ends = [np.interp((history.begin, history.end), times, levels) for times, levels in history.energy_curves]
    pairs = zip(ends, history.batteries, strict=True)
    return [float(last - first) / battery.capacity / hours for (first, last), battery in pairs]


def fall(values: Sequence[float], model: Model, part: float = 1.0) -> float | None:
    """Return how fast battery levels fall, or rise (below 0), by the moves of robots or runs; None if by chance.

    Where the level only swings between two charges, the moves of robots, or of runs, differ as much as their mean does
    from 0 (a t interval). `part`: the share of the error (alpha) to spend, where it is asked again as runs come in.

    It returns None for a fleet that begins settled, as what is left of a drift comes from the run in which it settled.
    It also returns None for one whole day whose hours or rates repeat: the level at its end belongs beside the level a
    day later.
    """
    if model.battery is None or not model.tasks.never_end or len(values) < 2:  # noqa: PLR2004 - no interval of one
        return None
    if model.fleet.start_energy == "settled" or _is_one_day(model):
        return None
    mean = -fmean(values)
    if not abs(mean) >= LEAST_DRIFT or _refills(mean, model):
        return None
    from scipy.special import stdtrit

    half = float(stdtrit(len(values) - 1, 1 - (1 - CONFIDENCE) * part / 2)) * stdev(values) / math.sqrt(len(values))
    return mean if abs(mean) > half else None


def _is_one_day(model: Model) -> bool:
    """Whether a run counts a whole day after which hours and rates repeat, and less than two."""
    day = repeats_after(model)
    return 0 < day <= model.run.end - model.run.warm_up < 2 * day


def _refills(fall: float, model: Model) -> bool:
    """Whether a night makes up for the energy lost in a day, given the fall as a share of the capacity an hour."""
    return refills_overnight(model, fall * model.run.end / model.units.hour)


def expected(kpis: Mapping[str, float], model: Model) -> str:
    """Return in words the use of chargers and robots to expect once batteries have settled, by estimate."""
    time = kpis.get("T", math.nan)
    counted = time - model.run.warm_up if time > model.run.warm_up else time
    away = model.fleet.size * counted * (1 - kpis.get("share_charging", math.nan))
    drawn, chargers = kpis.get("energy", math.nan) / away, sum(chargers_at(model, model.floor).values())
    if not chargers or not math.isfinite(drawn):
        return "the cost of charging does not show"
    charging = model.fleet.size * drawn / (drawn + charging_rate(model))
    if charging > chargers:
        chargers_in_words = number_of(chargers, "charger")
        return f"in the long run {amount_of(charging)} robots would have to charge at a time, with {chargers_in_words}"
    used, now = (amount_of(100 * share) for share in (charging / chargers, kpis.get("charger_utilisation", math.nan)))
    return (
        f"once settled, chargers would be in use about {used} % of the time (here {now} %), and about "
        f"{amount_of(charging)} of {number_of(model.fleet.size, 'robot')} would be charging"
    )


def amount_of(value: float) -> str:
    """Return a value with two digits."""
    return amount(float(f"{value:.2g}"))


class PastKnee(NamedTuple):
    """The finding that a fleet is past its knee: with `cap` robots under way more was done an hour than with `many`.

    `gain`: the part by which more was done.
    """

    cap: int
    many: int
    gain: float


class Window(NamedTuple):
    """A window of time: robots under way on average, and goods moved per time unit (load and delivery count half)."""

    under_way: float
    done: float


def past_knee(history: History) -> PastKnee | None:
    """Return the finding that fewer robots under way do more, if the evaluation period shows it; else None."""
    fleet = history.counted * len(history.log.robots)
    if not fleet or history.totals["waiting"] < LEAST_WAITING * fleet:
        return None
    all_windows = windows(history)
    most = max((window.under_way for window in all_windows), default=0.0)
    bands: defaultdict[int, list[Window]] = defaultdict(list)
    for window in all_windows:
        bands[math.ceil(window.under_way / most * BANDS - 1e-9)].append(window)
    high = bands[BANDS]
    fewer = [band for number, band in bands.items() if number <= FEWER and len(band) >= LEAST_WINDOWS]
    if len(high) < LEAST_WINDOWS or not fewer:
        return None
    best = max(fewer, key=_done)
    error = math.sqrt(sum(variance(window.done for window in band) / len(band) for band in (best, high)))
    gain = _done(best) - _done(high)
    if gain <= STANDARD_ERRORS * error or gain < LEAST_GAIN * _done(high):
        return None
    cap, many = (round(fmean(window.under_way for window in band)) for band in (best, high))
    return PastKnee(cap, many, gain / _done(high))


def _done(band: list[Window]) -> float:
    return fmean(window.done for window in band)


def windows(history: History) -> list[Window]:
    """Cut the evaluation period in windows of equal length, in which a robot does about `TASKS_A_WINDOW` tasks."""
    changes: defaultdict[float, int] = defaultdict(int)
    for spans in history.changes:
        for span in spans:
            if span.end > span.start and not span.seen.is_parked:
                changes[max(span.start, history.begin)] += 1
                changes[max(span.end, history.begin)] -= 1
    goods = [time for task in history.tasks.values() for time in (task.loaded, task.delivered) if history.counts(time)]
    goods = sorted(time for time in goods if time <= history.end)
    times = sorted(changes)
    numbers = list(accumulate(changes[time] for time in times))
    total = math.fsum(n * (end - start) for n, start, end in zip(numbers, times, times[1:], strict=False))
    if not goods or not total:
        return []
    count = int(history.counted * len(goods) / 2 / total / TASKS_A_WINDOW)
    if not count:
        return []
    length = history.counted / count
    out, done = [0.0] * count, [0] * count
    for number, start, end in zip(numbers, times, times[1:], strict=False):
        for rank in range(int((start - history.begin) / length), count):
            left, right = history.begin + rank * length, history.begin + (rank + 1) * length
            if left >= end:
                break
            out[rank] += number * max(min(end, right) - max(start, left), 0.0)
    for time in goods:
        done[min(int((time - history.begin) / length), count - 1)] += 1
    return [Window(area / length, n / length) for area, n in zip(out, done, strict=True)]
