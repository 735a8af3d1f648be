"""Shares of tasks, such as what was delivered on time: tasks are counted, and those of one day depend on each other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Self

import numpy as np

from desim_warehouse.study.statistics.student import t_quantile

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

ALIKE = 0.04
"""The least correlation that tasks of one day are taken to have, however little few days differ.

Days of drafts at and above their target show 0 to 0.008, overloaded ones 0.014 (docs/dev/performance.md)."""
FEW = 20
"""Up to so many days; more of them show themselves how they differ, and the least falls in proportion."""


class TaskShare(float):
    """A share of the tasks of one run, which knows of how many: a float for all that only reads its value."""

    of: float

    def __new__(cls, share: float, of: float) -> Self:
        """A share of a number of tasks."""
        made = super().__new__(cls, share)
        made.of = of
        return made


def tasks_of(values: Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64] | None:
    """How many tasks each value is a share of, shape (n,); None unless all are shares of tasks."""
    found = [value.of for value in values if isinstance(value, TaskShare) and value.of > 0]
    return np.array(found) if found and len(found) == len(values) else None


def share_bounds(shares: NDArray[np.float64], tasks: NDArray[np.float64], level: float) -> tuple[float, float]:
    """A lower and an upper bound of the mean share over all days, each right with probability `level`.

    The lower one is Clopper and Pearson's with the effective number of tasks of Korn and Graubard: as many independent
    tasks as would make the mean vary as it does from day to day. It is never more than tasks that correlate by 0.04
    within a day are worth (Kish's design effect, 1 + (tasks - 1) 0.04), so each of up to 20 days counts for at most 25
    tasks; where all days are alike that is all that is known. Of n > 20 days it is 0.04 times 20 / n, and each counts
    for at most 1.25 n: bad days that are rarer matter less. The upper one is the larger of Clopper and Pearson's with
    that most, and Student's t over days.

    Neither falls where a day gets better: the lower one is the least that it would be if the best days had been
    perfect, the upper one the least if the worst days had been less bad.

    Args:
        shares: one for each day, shape (n,), n at least 2.
        tasks: of how many, shape (n,).
        level: of each bound, above 0.5.

    Source: Korn & Graubard (1998), Confidence intervals for proportions with small expected number of positive counts
    estimated from survey data, Survey Methodology 24(2), 193-201; Kish (1965), Survey Sampling, section 5.4; Clopper &
    Pearson (1934), Biometrika 26(4), 404-413.
    Assumes: days independent. docs/dev/validation.md has the error rates by how much tasks of a day correlate.
    """
    n = shares.size
    alike = ALIKE * min(1.0, FEW / n)
    most = n * n / float(((1.0 + (tasks - 1.0) * alike) / tasks).sum())
    worst_first = np.sort(shares)
    high = max(_by_tasks_high(float(shares.mean()), most, level), _by_days_high(worst_first, level))
    return _low(1.0 - worst_first, most, level), min(high, 1.0)


def _low(missed: NDArray[np.float64], most: float, level: float) -> float:
    """The lower bound from the share of tasks missed on each day, the worst day first."""
    from scipy.special import betaincinv, ndtri

    n = missed.size
    sums, squares = np.cumsum(missed), np.cumsum(missed**2)  # of the worst days, the others perfect
    means = np.clip(sums / n, 0.0, 1.0)
    wider = (t_quantile(n - 1, level) / float(ndtri(level))) ** 2
    varies = wider * np.maximum(squares / n - means**2, 0.0) / (n - 1)
    binomial = means * (1.0 - means)
    tasks = np.where(varies * most > binomial, binomial / np.maximum(varies, 1e-300), most)
    met, not_met = np.maximum((1.0 - means) * tasks, 1e-12), means * tasks + 1.0
    found = np.where(means < 1.0, betaincinv(met, not_met, 1.0 - level), 0.0)
    return float(min(found.min(), (1.0 - level) ** (1.0 / most)))


def _by_tasks_high(mean: float, most: float, level: float) -> float:
    """Clopper and Pearson's upper bound for a number of tasks."""
    from scipy.special import betaincinv

    return float(betaincinv(mean * most + 1.0, (1.0 - mean) * most, level)) if mean < 1.0 else 1.0


def _by_days_high(days: NDArray[np.float64], level: float) -> float:
    """The least upper bound of Student's t if the k worst days, which come first, had all been c; over k and c.

    For k days at c it is a + k c / n + b sqrt(u² + d), convex in c = u + away: its least value has a closed form.
    """
    n, best = days.size, days[-1]
    k = np.arange(1, n)
    below = days - best  # sums of these are exact where the days left are alike
    rest, squares = (np.cumsum(power[::-1])[::-1][1:] for power in (below, below**2))
    scale = k * (n - k) / n
    away = rest / (n - k)
    spread = np.maximum(squares - rest**2 / (n - k), 0.0) / scale
    times = t_quantile(n - 1, level) / math.sqrt(n * (n - 1)) * np.sqrt(scale)
    slope = k / n / times  # from 1 on it rises with c everywhere
    turn = away - slope * np.sqrt(spread / np.where(slope < 1.0, 1.0 - slope**2, 1.0))
    at = np.where(slope < 1.0, np.clip(turn, below[:-1], below[1:]), below[:-1])
    found = (rest + k * at) / n + times * np.sqrt((at - away) ** 2 + spread)
    return float(best + found.min())
