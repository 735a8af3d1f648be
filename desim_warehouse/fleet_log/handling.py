"""Durations of loading, unloading and repairs, and breakdowns, from messages once a second.

Begin and end of each lie between two messages. The likelihood is that of these intervals, as `desim fit` has it for
times that a clock has rounded. The middle between the bounds is right on average, so it gives the interval of the
mean. The number of messages for the time is so, too, but spreads too much, and prefers families with long tails.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from desim_warehouse.fleet_log.estimates import (
    CONFIDENCE,
    FEWEST,
    KeyEstimate,
    poisson_interval,
    short,
    t_quantile,
    unknown,
)
from desim_warehouse.fleet_log.floor import Tracks
from desim_warehouse.fleet_log.table import DROP, PICK
from desim_warehouse.study.fit import fit_between
from desim_warehouse.values.arrays import Floats, Ints
from desim_warehouse.values.distributions import Distribution, LognormalTime

MANY = 30
"""Times from which on their mean is taken to be normal; below that their logarithms are."""
_QUICK = 2.0
"""Times of less than so many messages escape the log too often."""
_SAME = 0.03
"""Times that spread less than this share of their mean, as far as the log can tell, are all alike."""

_KEY = "fleet.robot.breakdowns"


@dataclass(frozen=True)
class Episodes:
    """Stretches of messages of one robot in which a condition holds.

    `begun` and `ended` have two instants for each: between them it began, and ended (inf: not seen). `first` and `last`
    are the messages in it.
    """

    begun: Floats
    ended: Floats
    first: Ints
    last: Ints

    def only(self, which: Any) -> Episodes:
        """Select some of the stretches."""
        return Episodes(self.begun[which], self.ended[which], self.first[which], self.last[which])

    @property
    def over(self) -> Any:
        """Whether each stretch was seen to end: not where a gap in the log or its end came first."""
        return np.isfinite(self.ended[:, 1])

    @property
    def middle(self) -> Floats:
        """Duration of each stretch between the middles of its bounds; open stretches count as far as they were seen."""
        ended = np.where(self.over, self.ended.mean(axis=1), self.ended[:, 0])
        return np.asarray(ended - self.begun.mean(axis=1))


def episodes(tracks: Tracks, mask: Any) -> Episodes:
    """Find the stretches of messages in `mask` that begin outside of gaps; ends in a gap, or with the log, are open."""
    new = np.diff(tracks.robot, prepend=-1) != 0
    starts = np.flatnonzero(mask & ~new & ~np.concatenate([[True], mask[:-1]]) & tracks.joined)
    off = np.flatnonzero(~mask | new)
    after = np.append(off, len(mask))[np.searchsorted(off, starts + 1)]
    last = after - 1
    seen = np.zeros(len(starts), bool)
    inside = after < len(mask)
    seen[inside] = tracks.joined[after[inside]]
    end = np.full(len(starts), math.inf)
    end[seen] = tracks.time[after[seen]]
    begun = np.stack([tracks.time[starts - 1], tracks.time[starts]], axis=1)
    return Episodes(begun, np.stack([tracks.time[last], end], axis=1), starts, last)


def handling(tracks: Tracks) -> list[KeyEstimate]:
    """Estimate loading and unloading times, without stretches that a breakdown cut short."""
    faults = np.concatenate([[0], np.cumsum(tracks.fault)])
    estimates = []
    for key, action in (("load_time", PICK), ("unload_time", DROP)):
        all_of_them = episodes(tracks, tracks.action == action)
        end = np.minimum(all_of_them.last + 2, len(tracks.time))
        whole = (faults[end] == faults[all_of_them.first - 1]) & all_of_them.over
        one_time = episodes_mean(
            f"tasks.{key}", all_of_them.only(whole), tracks.step, "picks" if action == PICK else "drops"
        )
        own = [name for name, flow in tracks.model.tasks.flows.items() if getattr(flow, key) is not None]
        if own and one_time.identified:
            one_time = unknown(one_time.key, f"flows have their own ({', '.join(own)})", one_time.n, one_time.what)
        estimates.append(one_time)
    return estimates


def episodes_mean(key: str, stretches: Episodes, step: float, what: str) -> KeyEstimate:
    """Fit a distribution to the durations of stretches, with the interval of its mean."""
    n, times = len(stretches.begun), stretches.middle
    if n < FEWEST:
        return unknown(key, f"{n} {what} are too few", n, what)
    mean = float(times.mean())
    if mean < _QUICK * step:
        return unknown(key, f"{mean:.2g} is too short for messages every {step:.2g}", n, what)
    blur = sum(float((np.diff(ends, axis=1) ** 2).mean()) / 12 for ends in (stretches.begun, stretches.ended))
    spread = math.sqrt(max(float(times.var(ddof=1)) - blur, 0.0))
    if spread < max(_SAME * mean, math.sqrt(blur) / 4):
        low, high = mean_interval(times)
        return KeyEstimate(key, short(mean), mean, low, high, n, what, "always the same, as far as can be seen")
    fitted = fit_between(stretches.begun, stretches.ended)
    if n < MANY:  # too few to tell families apart
        fitted = LognormalTime.model_validate({"lognormal": {"mean": short(mean), "cv": short(spread / mean)}})
    return _of(key, fitted, times, n, what)


def _of(key: str, fitted: Distribution, times: Floats, n: int, what: str) -> KeyEstimate:
    low, high = mean_interval(times)
    shift = fitted.mean - float(times.mean())
    kind = fitted.kind
    ranged = f"{key}.{kind}" + ({"weibull": ".scale", "exponential": ""}.get(kind, ".mean"))
    scale = fitted.content()[kind]["scale"] / fitted.mean if kind == "weibull" else 1.0
    low, high = max(low + shift, 0.0), high + shift
    why = f"{kind}, cv {fitted.cv:.2g}"
    if scale != 1.0:
        why += f"; the interval of the scale is {low * scale:.4g} to {high * scale:.4g}"
    return KeyEstimate(key, fitted.content(), fitted.mean, low, high, n, what, why, ranged)


def mean_interval(times: Floats) -> tuple[float, float]:
    """Return the interval of the mean of some times: by Student, and of few by their logarithms (Cox).

    Source: Zhou & Gao (1997), Confidence intervals for the log-normal mean, Statistics in Medicine 16, 783-790.
    """
    n, mean = len(times), float(times.mean())
    if n >= MANY or times.std() < _SAME * mean:
        half = t_quantile(n - 1) * float(times.std(ddof=1)) / math.sqrt(n)
        return max(mean - half, 0.0), mean + half
    logs = np.log(np.maximum(times, 1e-3 * mean))
    square = float(logs.var(ddof=1))
    half = t_quantile(n - 1) * math.sqrt(square / n + square**2 / (2 * (n - 1)))
    return math.exp(float(logs.mean()) + square / 2 - half), math.exp(float(logs.mean()) + square / 2 + half)


# Breakdowns


def breakdowns(tracks: Tracks) -> list[KeyEstimate]:
    """Estimate the time in operation between breakdowns (exact for a Poisson process), and repair times."""
    broken = episodes(tracks, tracks.fault)
    n = len(broken.begun)
    at_work = (tracks.driving | np.isin(tracks.action, (PICK, DROP))) & ~tracks.fault
    operated = float(tracks.before[at_work].sum())
    fewest, most = poisson_interval(n)
    low, high = operated / most, operated / fewest if n else math.inf
    if not n:
        why = f"none in {operated:,.0f} of operation: less often than every {low:,.0f}"
        return [unknown(_KEY, why, 0, "breakdowns")]
    over = broken.only(broken.over)
    every = KeyEstimate(
        f"{_KEY}.every", {"exponential": short(operated / n)}, operated / n, low, high, n, "breakdowns",
        ranged=f"{_KEY}.every.exponential",
    )  # fmt: skip
    repair = episodes_mean(f"{_KEY}.repair", over, tracks.step, "repairs")
    if not repair.identified:
        repair = _few_repairs(broken)
    return [every, repair]


def _few_repairs(broken: Episodes) -> KeyEstimate:
    """Estimate repair times from fewer than a handful: exponential (the widest interval), open repairs counted."""
    from scipy.stats import chi2

    total, n = float(broken.middle.sum()), max(int(broken.over.sum()), 1)
    tail = (1 - CONFIDENCE) / 2
    low, high = (2 * total / float(chi2.ppf(share, 2 * n)) for share in (1 - tail, tail))
    mean = total / n
    key = f"{_KEY}.repair"
    why = "too few to tell a distribution"
    return KeyEstimate(key, {"exponential": short(mean)}, mean, low, high, n, "repairs", why, f"{key}.exponential")
