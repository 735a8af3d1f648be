"""The smallest design that meets a target: halve the range, replicate each probe until its mean is clear."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Generic, Literal, TypeVar

import numpy as np

from desim_warehouse.errors import StudyError, spoken
from desim_warehouse.study.statistics.checks import check_confidence
from desim_warehouse.study.statistics.intervals import ANYTHING, bounds, bounds_of, gaps
from desim_warehouse.study.statistics.procedure import Procedure, follow, request
from desim_warehouse.study.statistics.targets import Target, parse_target
from desim_warehouse.study.statistics.telling import SPARE, fewest

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from desim_warehouse.study.statistics.intervals import Interval

V = TypeVar("V")
Verdict = Literal["meets", "fails", "undecided"]
FEWEST_BESIDE = 5  # runs from which on one of them may be called an outlier


@dataclass(frozen=True)
class DesignVerdict(Generic[V]):
    """The verdict on one design.

    `low` and `high` are the bounds the verdict rests on, each valid with `level`; both None where the values
    are `deterministic` and the mean is exact. `outlier`: the replication without which an undecided design would be
    clear; None: there is no such one. `within_zone`: it is better than the target by less than the zone, so that more
    runs would tell nothing that matters.
    """

    value: V
    verdict: Verdict
    n: int
    mean: float
    low: float | None
    high: float | None
    level: float
    deterministic: bool
    within_zone: bool = False
    outlier: int | None = None


@dataclass(frozen=True)
class Sizing(Generic[V]):
    """The answer, every design examined in the order of the search, and caveats.

    `smallest` is None if no design was shown to meet the target. `below` is the decision about its neighbour: that it
    "fails" makes the answer the smallest, "undecided" says so in `note`, and it is None if there is no neighbour.
    `vetoed` meet the target only as counted, with the reason.
    `falls` lists pairs of probed values between which the response clearly moves away from the target: then it is not
    monotone, and only search="scan" can be trusted.
    """

    smallest: V | None
    target: Target
    below: DesignVerdict[V] | None
    decisions: tuple[DesignVerdict[V], ...]
    falls: tuple[tuple[V, V], ...]
    runs: int
    confidence: float
    search: str
    vetoed: tuple[tuple[V, str], ...] = ()

    @property
    def note(self) -> str:
        """The answer in words, with its caveats."""
        return self.said(f"meet {self.target}")

    def said(self, aim: str) -> str:
        """The same, where what designs were shown to do is said in other words: `meet T <= 50`."""
        if self.smallest is None:
            parts = [f"no design was shown to {aim}"]
        else:
            parts = [f"{self.smallest} is the smallest shown to {aim}"]
        if self.vetoed:
            values = spoken(str(value) for value, _ in self.vetoed)
            parts.append(f"only as counted with {values}: {self.vetoed[0][1]}")
        if self.below is not None and self.below.verdict == "undecided":
            alone = "" if self.below.outlier is None else f", for replication {self.below.outlier} alone"
            parts.append(f"{self.below.value} is too close to call after {self.below.n} replications{alone}")
        if self.falls and self.search == "bisection":
            pairs = ", ".join(f"{a} to {b}" for a, b in self.falls)
            parts.append(f"the response is not monotone (worse from {pairs}): repeat with the search 'scan'")
        return "; ".join(parts)


def smallest_meeting(
    sample: Callable[[V, int], float],
    values: Sequence[V],
    target: Target | str,
    confidence: float = 0.95,
    *,
    n0: int = 10,
    cap: int = 320,
    search: Literal["bisection", "scan"] = "bisection",
    deterministic: bool = False,
    within: Interval = ANYTHING,
) -> Sizing[V]:
    """The first of `values` (fleet sizes, say) whose mean indicator meets the target, with confidence.

    Args:
        sample: (value, replication) -> the indicator of that run.
        values: the designs to choose from, smallest (cheapest) first.
        target: as "throughput_per_hour >= 220".
        confidence: that every "meets" and "fails" of the search is right.
        n0: replications at the first look at a design. Every further look doubles them.
        cap: most replications of a design; a mean not clear by then is "undecided" and taken as not meeting.
        search: "bisection", or "scan" through the values from the smallest, which needs no monotone response.
        deterministic: the models use no random numbers: one run of a design is exact.
        within: the range of the indicator, such as (0, 1) for a share.

    Raises:
        StudyError: no or repeated values, arguments out of range, a bad target, a run whose value is not
            finite.

    Source: one-sided bounds (`intervals.bounds`), exact for values of 0 and 1. Several looks at
    several designs would accumulate errors, so each bound has confidence 1 - α / (designs on the path ·
    looks), Bonferroni.
    Assumes: as `bounds`; for "bisection" that a larger design never does worse (congestion breaks this: see
    `Sizing.falls`); that a mean lies off the target: one exactly on it stays undecided, and so does a target
    that only "never" or "always" would meet, such as a share of at least 1.
    """
    steps = smallest_meeting_steps(
        values, target, confidence, n0=n0, cap=cap, search=search, deterministic=deterministic, within=within
    )
    return follow(steps, lambda design, replication: sample(values[design], replication))


def smallest_meeting_steps(
    values: Sequence[V],
    target: Target | str,
    confidence: float = 0.95,
    *,
    n0: int = 10,
    cap: int = 320,
    search: Literal["bisection", "scan"] = "bisection",
    deterministic: bool = False,
    within: Interval = ANYTHING,
    veto: Callable[[int], str | None] | None = None,
) -> Procedure[Sizing[V]]:
    """The steps of `smallest_meeting`: yields (position in `values`, replication), returns the Sizing.

    `veto` says why a design (its position in `values`) that meets the target by its runs would not do so for long.
    """
    goal = parse_target(target) if isinstance(target, str) else target
    check_confidence(confidence)
    if not values or any(a == b for i, a in enumerate(values) for b in values[:i]):
        raise StudyError(f"values to search {list(values)!r}: expected at least one, none twice")
    if not 2 <= n0 <= cap or search not in {"bisection", "scan"}:  # noqa: PLR2004
        raise StudyError(f"n0 {n0}, cap {cap}, search {search!r}: expected 2 <= n0 <= cap, and bisection or scan")
    looks = [1] if deterministic else looks_at(n0, cap)
    path = len(values).bit_length() if search == "bisection" else len(values)
    level = 1.0 - (1.0 - confidence) / (path * len(looks))
    data: dict[int, list[float]] = {}
    verdicts: dict[int, DesignVerdict[V]] = {}
    vetoed: list[tuple[V, str]] = []
    failing, meeting = -1, len(values)  # the answer lies above `failing`, at most at `meeting`
    while meeting - failing > 1:
        probe = failing + 1 if search == "scan" else (failing + meeting) // 2
        data[probe] = []
        for n in looks:
            data[probe] += yield from request([(probe, r) for r in range(len(data[probe]), n)])
            verdicts[probe] = judged(values[probe], data[probe], goal, level, deterministic, within)
            if verdicts[probe].verdict != "undecided":
                break
        if verdicts[probe].verdict == "meets" and veto is not None and (reason := veto(probe)) is not None:
            vetoed.append((values[probe], reason))
            verdicts[probe] = replace(verdicts[probe], verdict="fails")
        if verdicts[probe].verdict == "meets":
            meeting = probe
        else:
            failing = probe
    smallest = values[meeting] if meeting < len(values) else None
    falls = tuple((values[i], values[j]) for i, j in _falls(data, goal.sign, confidence))
    below = verdicts.get(meeting - 1)
    runs = sum(map(len, data.values()))
    return Sizing(smallest, goal, below, tuple(verdicts.values()), falls, runs, confidence, search, tuple(vetoed))


def looks_at(n0: int, cap: int) -> list[int]:
    """Replications at each look: n0, 2 n0, 4 n0, ..., cap."""
    looks = [n0]
    while looks[-1] < cap:
        looks.append(min(2 * looks[-1], cap))
    return looks


def judged(
    value: V,
    data: list[float],
    target: Target,
    level: float,
    deterministic: bool,
    within: Interval,
    zone: float = 0.0,
) -> DesignVerdict[V]:
    """The verdict on one design: it meets the target if even its worse bound does.

    It fails if its mean does not, and its better bound does not meet a target that is harder by `zone`, in the
    indicator's unit. So no run that turns out better makes a design fail that met the target before.
    """
    mean = float(np.mean(data))
    if deterministic:
        return DesignVerdict(
            value, "meets" if target.met_by(mean) else "fails", len(data), mean, None, None, level, True
        )
    verdict, (low, high), within_zone = _verdict(data, mean, target, level, within, zone)
    outlier = None
    if verdict == "undecided" and not within_zone and len(data) >= FEWEST_BESIDE:
        farthest = int(np.argmax(np.abs(np.array(data) - mean)))
        others = [*data[:farthest], *data[farthest + 1 :]]
        if _verdict(others, float(np.mean(others)), target, level, within, zone)[0] != "undecided":
            outlier = farthest
    return DesignVerdict(value, verdict, len(data), mean, low, high, level, False, within_zone, outlier)


def runs_to_tell(values: Sequence[float], target: Target, level: float, within: Interval) -> int | None:
    """How many runs in all would probably tell whether a design meets the target; None: more than `MOST_TO_TELL`.

    Further runs are taken to be like those so far, whose mean lies 1.5 times as far from the target as the bounds
    reach: were it the true one, five of six such designs would be told. At least two runs; `level` as of `judged`.
    """
    mean = float(np.mean(values))
    wider = math.sqrt(len(values) / (len(values) - 1))  # repeated values vary less than new ones
    nearer = replace(target, value=mean + (target.value - mean) / (SPARE * wider))

    def told(runs: int) -> bool:
        further = [values[run % len(values)] for run in range(runs)]
        return _verdict(further, float(np.mean(further)), nearer, level, within, 0.0)[0] != "undecided"

    return fewest(told, len(values))


def _verdict(
    data: Sequence[float], mean: float, target: Target, level: float, within: Interval, zone: float
) -> tuple[Verdict, Interval, bool]:
    """The verdict, its bounds, and whether the design is better than the target by less than the zone."""
    low, high = bounds_of(data, level, within)
    worse, better = (low, high) if target.sign > 0 else (high, low)
    if target.met_by(worse):
        return "meets", (low, high), False
    short = not target.met_by(better - target.sign * zone)
    fails = short and not target.met_by(mean)
    return "fails" if fails else "undecided", (low, high), short and not fails


def _falls(data: dict[int, list[float]], sign: float, confidence: float) -> list[tuple[int, int]]:
    """Probed neighbours whose larger one is worse, by paired one-sided bounds (Bonferroni)."""
    probed = sorted(data)
    level = 1.0 - (1.0 - confidence) / max(1, len(probed) - 1)
    falls = []
    for i, j in pairwise(probed):
        n = min(len(data[i]), len(data[j]))
        gains, reach = gaps(sign * np.array(data[j][:n]), sign * np.array(data[i][:n]))
        if (bounds(gains, level, reach=reach)[1] if n > 1 else gains[0]) < 0.0:
            falls.append((i, j))
    return falls
