"""Verdicts on problems of a run or a design: it cannot keep up, drains its batteries, or is jammed.

For the answer of a run, and for every verdict on a design.

The rules are in `RULES`, which tables, reports, JSON and the reference documentation all read. They use indicators, of
a run or as means over the runs of a design, so that both are judged alike.

A run is representative only once its batteries have settled (`fall`). If their mean level falls, the cost of charging
is still to come; if it rises, robots charge more than they will, and the fleet looks worse than it is. `expected`
estimates the steady state: each robot charges for the share f of its time in which it regains the energy drawn in the
rest, (1 - f) e = f g, with e drawn and g gained per time unit.

Fewer robots under way may do more. A floor's throughput has a maximum at some number of robots under way, and falls
beyond it: the macroscopic fundamental diagram of road networks (Geroliminis and Daganzo, Transportation Research B 42
(2008) 759-770). A run shows a part of that curve only if the number under way changes, and for long enough that jams
can form or dissolve. So `past_knee` cuts the evaluation period into windows in which a robot does two tasks on average,
and compares windows with many robots under way with windows with fewer. If the number hardly changes, as when work
always waits, one run shows nothing, and `desim size --key traffic.most_out` tries other numbers.
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
"""Codes of verdicts, with a size above 0, on designs that would do worse in the long run than in the run simulated."""
ERRORS_OF_ARRIVALS = 3
"""Least growth of a backlog that counts, in standard errors of the number of arrivals."""
LEAST_FALL = 0.01
"""Least fall of batteries that counts, as a share of the capacity per hour."""
CHARGERS_BUSY = 0.95
"""Utilisation from which chargers count as always in use."""
MOST_WAITING = 0.5
"""Share of the fleet's time waiting in traffic from which the fleet counts as jammed."""

LEAST_DRIFT = 0.01
"""Least drift of the mean battery level that counts, as a share of the capacity per hour."""
CONFIDENCE = 0.99
"""Confidence of the interval that the drift must exceed."""

LEAST_WAITING = 0.2
"""Share of the fleet's time waiting in traffic below which a fleet is never past its knee."""
TASKS_A_WINDOW = 2
"""Tasks that a robot under way does in a window, on average."""
LEAST_WINDOWS = 6
"""Fewest windows with many robots, and with fewer, for a comparison."""
STANDARD_ERRORS = 4
"""Standard errors by which work done with fewer robots must exceed work done with many, besides `LEAST_GAIN`."""
LEAST_GAIN = 0.05
BANDS = 10
"""Number of bands, of equal width up to the most robots under way, into which windows are grouped."""
FEWER = 8
"""Number of lower bands that are compared with the highest band."""


@dataclass(frozen=True)
class Verdict:
    """A problem of a run or a design: its code (see `RULES`), its description, and its size.

    `came`, `delivered`: where tasks pile up, the tasks an hour that were released and that were delivered.
    """

    code: str
    text: str
    size: float
    came: float = math.nan
    delivered: float = math.nan

    def content(self) -> dict[str, str]:
        """Return the verdict as JSON has it."""
        return {"code": self.code, "text": self.text}

    @property
    def is_lasting(self) -> bool:
        """Whether the long run is worse than the run simulated, regardless of its indicators."""
        return self.code in LASTING and self.size > 0

    @property
    def mark(self) -> str:
        """The mark of a design in a table."""
        return RULES[self.code].mark


@dataclass(frozen=True)
class VerdictRule:
    """A rule for a verdict, in words (`when`) and as a function (`size`) that returns its size, or None if it is met.

    `mark`: mark in tables. `text`: the verdict, in which `{}` stands for the size times `scale`. Without `size` the
    verdict follows only from the log of a run (`judge_run`).
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

    Growth that may be due to chance is disregarded, as for random arrivals of tasks (see `_tasks_pile_up`).
    """
    left, end, counted = kpis.get("work_backlog", 0.0), end_of_run(kpis, model), _counted(kpis, model)
    if not model.tasks.never_end or not left or not counted:
        return None
    put_down = left + kpis.get("worked", 0.0) * end / counted
    chance = ERRORS_OF_ARRIVALS * math.sqrt(put_down) + put_down * min(longest_closed(model) / end, 1.0)
    return left / end * model.units.hour if left > max(chance, model.fleet.size) else None


def _tasks_pile_up(kpis: Mapping[str, float], model: Model) -> float | None:
    """Return the growth of the backlog per hour.

    If demand equalled the fleet's capacity, the backlog after n arrivals would deviate about as much as the number of
    arrivals does from its mean: sqrt(n), the standard deviation of a Poisson count. A stable queue stays below that.
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
    """Return how long before the end of the warm-up the run ended; None if it ended later."""
    early = model.run.warm_up - end_of_run(kpis, model)
    return early if early > 0 else None


def end_of_run(kpis: Mapping[str, float], model: Model) -> float:
    """Return the time at which a run ended: T, or its length if that cut its work off."""
    time = kpis.get("T", math.nan)
    return model.run.end if math.isnan(time) else time


def _counted(kpis: Mapping[str, float], model: Model) -> float:
    """Return the length of the evaluation period in time units; of the whole run if it ends within the warm-up."""
    end, warm_up = end_of_run(kpis, model), model.run.warm_up
    return end - warm_up if end >= warm_up else end


RULES = {
    "CANNOT_KEEP_UP": VerdictRule(
        "backlog",
        "cannot keep up: open tasks grow by {} an hour",
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
"""Rules by code, in the order in which verdicts are listed."""


def piles_up(verdicts: Iterable[Verdict]) -> bool:
    """Whether the backlog of a run or design grows, so that cycle times of done tasks omit ever more tasks."""
    return any(verdict.code == PILES_UP for verdict in verdicts)


def is_no_answer(indicator: str, verdicts: Iterable[Verdict]) -> bool:
    """Whether an indicator is meaningless because work piles up: the share on time falls with the run length."""
    return is_of_due(indicator) and piles_up(verdicts)


def judge(kpis: Mapping[str, float], model: Model) -> list[Verdict]:
    """Return the verdicts on a run, from its indicators, or on a design, from the means of its runs."""
    verdicts = []
    for code, rule in RULES.items():
        size = None if rule.size is None else rule.size(kpis, model)
        if size is not None:
            rates = _rates(kpis, model) if code == PILES_UP else ()
            verdicts.append(Verdict(code, rule.text.format(_shown(rule.scale * size)), size, *rates))
    return verdicts


def _rates(kpis: Mapping[str, float], model: Model) -> tuple[float, ...]:
    """Return the tasks an hour released and delivered; none where tasks do not wait for delivery."""
    growth, delivered = _tasks_pile_up(kpis, model), kpis.get("throughput_per_hour", math.nan)
    until_worked = "worked" in kpis and model.tasks.done_when == "worked"
    return () if growth is None or until_worked else (delivered + growth, delivered)


def judge_run(kpis: Mapping[str, float], history: History) -> list[Verdict]:
    """Return the verdicts on a run, including verdicts that only its log shows."""
    moves = drifts_of_robots(history) if _may_move(kpis) else []
    verdicts = _with_drift(judge({**kpis, "T": history.end}, history.model), moves, kpis, history.model)
    past = past_knee(history)
    if past is not None:
        code = "PAST_KNEE"
        verdicts.append(Verdict(code, RULES[code].text.format(past.cap, past.many), past.gain))
    return verdicts


def judge_design(runs: Sequence[Mapping[str, float]], model: Model, part: float = 1.0) -> list[Verdict]:
    """Return the verdicts on a design, from its runs: by the mean of each indicator over the runs that have it.

    `part`: the share of alpha to spend, if a design is judged repeatedly as runs come in.
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
    """Return the drift of each robot's battery in the evaluation period, as a share of the capacity per hour."""
    import numpy as np

    hours = history.counted / history.model.units.hour
    if not history.batteries or not hours:
        return []
    ends = [np.interp((history.begin, history.end), times, levels) for times, levels in history.energy_curves]
    pairs = zip(ends, history.batteries, strict=True)
    return [float(last - first) / battery.capacity / hours for (first, last), battery in pairs]


def fall(values: Sequence[float], model: Model, part: float = 1.0) -> float | None:
    """Return how fast battery levels fall, or rise (below 0), from the drifts of robots or runs; None if by chance.

    If the level only swings between two charges, the t interval of the mean drift of robots, or of runs, includes 0.
    `part`: the share of alpha to spend, if a design is judged repeatedly as runs come in.

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


def lost_in_a_day(drift: float, model: Model) -> float:
    """Return the share of its capacity that the mean battery loses in a day that no night follows; 0 if little.

    Such a day has no verdict, as levels may be the same a day later. `drift`: the change of the mean level per hour.
    """
    if model.battery is None or model.fleet.start_energy == "settled" or not _is_one_day(model):
        return 0.0
    hours = (model.run.end - model.run.warm_up) / model.units.hour
    return -drift * hours if -drift >= LEAST_DRIFT and not _refills(-drift, model) else 0.0


def _is_one_day(model: Model) -> bool:
    """Whether a run counts a whole day after which hours and rates repeat, and less than two."""
    day = repeats_after(model)
    return 0 < day <= model.run.end - model.run.warm_up < 2 * day


def _refills(fall: float, model: Model) -> bool:
    """Whether a night makes up for the energy lost in a day, given the fall as a share of the capacity an hour."""
    return refills_overnight(model, fall * model.run.end / model.units.hour)


def expected(kpis: Mapping[str, float], model: Model) -> str:
    """Return a sentence on the estimated use of chargers once batteries have settled."""
    away = model.fleet.size * _counted(kpis, model) * (1 - kpis.get("share_charging", math.nan))
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
    """Return a value with two significant digits."""
    return amount(float(f"{value:.2g}"))


class PastKnee(NamedTuple):
    """The finding that a fleet is past its knee: more was done per hour with `cap` robots under way than with `many`.

    `gain`: relative gain of work done.
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
