"""Comparison of designs with a baseline under common random numbers: paired differences, simultaneous intervals.

For `desim compare` and `what-if`, and for the last comparison of `best` and `orient`.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence, finite
from desim_warehouse.study.statistics.intervals import Estimate, bounds, described, gaps, p_value
from desim_warehouse.values.arrays import Floats

D = TypeVar("D", bound="Hashable")
Method = Literal["bonferroni", "holm"]

STATEMENTS = {
    "bonferroni": "{m} differences; all intervals hold together with {c:g} % confidence (Bonferroni: each at "
    "{e:.4g} %); p-values times {m}",
    "holm": "{m} differences; p-values by Holm's step-down, wrong about any with at most {a:g} %; "
    "all intervals hold together with {c:g} % confidence (Bonferroni: each at {e:.4g} %), so Holm may tell a "
    "difference whose interval contains 0",
}


@dataclass(frozen=True)
class Difference:
    """The difference of a design to its baseline, in the indicator's unit.

    `estimate.interval` is simultaneous with the intervals of the other designs. `missing` counts replications left
    out because either run failed. `differs` is None if there is only one pair. Between deterministic models there is
    no p-value, and `differs` tells whether the difference is nonzero.
    """

    design: Hashable
    baseline: Hashable
    estimate: Estimate
    missing: int
    p_value: float | None
    p_adjusted: float | None
    differs: bool | None


@dataclass(frozen=True)
class Differences:
    """The differences of all designs to their baselines; `statement` puts into words what intervals and p-values mean.

    `against`: the baseline of each design, including designs without a `Difference` because their runs are equal.
    """

    against: Mapping[Any, Any]
    confidence: float
    differences: tuple[Difference, ...]
    statement: str


def paired(
    values: Sequence[float] | Floats,
    baseline_values: Sequence[float] | Floats,
    confidence: float = 0.95,
    *,
    deterministic: bool = False,
) -> Estimate:
    """Estimate the mean difference of a design to the baseline from pairs of replications.

    Replication r of both must use the same random numbers (common random numbers). The difference then varies far less
    than the two means, as long as both designs do the same at the same time. Shapes (n,), in the indicator's unit.
    `deterministic`: the runs used no random numbers, so that one pair gives the exact difference.

    Raises:
        StudyError: different numbers of replications, a value that is not finite, or differences of deterministic
            models that differ.

    Source: Law (2015), section 10.2.1 (paired t) and 11.2 (common random numbers).
    Assumes: the differences, not the values, are independent; variances may be unequal.
    """
    check_confidence(confidence)
    ours, base = finite(values, "design"), finite(baseline_values, "baseline")
    if ours.size != base.size:
        raise StudyError(f"paired: {ours.size} replications against {base.size} of the baseline")
    differences, reach = gaps(ours, base)
    if deterministic and np.ptp(differences):
        raise StudyError(f"deterministic models gave differences from {differences.min():g} to {differences.max():g}")
    is_exact = deterministic or differences.size == 1
    return described(
        differences,
        None if is_exact else bounds(differences, 0.5 + confidence / 2, reach=reach),
        deterministic,
        confidence,
    )


def compare(
    table: Mapping[D, Sequence[float] | Floats],
    baseline: D,
    method: Method = "bonferroni",
    confidence: float = 0.95,
    *,
    deterministic: bool | Collection[D] = False,
) -> Differences:
    """Return the difference of every design to the baseline: see `compare_pairs`.

    Raises:
        StudyError: unknown baseline or method, no other design, no replication in common.
    """
    if baseline not in table:
        raise StudyError(f"baseline {baseline!r}: expected one of {', '.join(map(repr, table))}")
    against = {design: baseline for design in table if design != baseline}
    if not against:
        raise StudyError(f"nothing to compare with the baseline {baseline!r}: the only design")
    return compare_pairs(table, against, method, confidence, deterministic=deterministic)


def compare_pairs(
    table: Mapping[D, Sequence[float] | Floats],
    against: Mapping[D, D],
    method: Method = "bonferroni",
    confidence: float = 0.95,
    *,
    deterministic: bool | Collection[D] = False,
) -> Differences:
    """Return the differences of designs to their baselines, with intervals and p-values that hold for all at once.

    Args:
        table: design -> values by replication number, in the indicator's unit, nan for a failed run. Designs
            may have different numbers of replications: a difference uses those that both have.
        against: design -> its baseline.
        method: "bonferroni", or "holm", whose p-values are never larger; the intervals are Bonferroni's in
            both, as Holm's step-down has no two-sided ones of its own.
        confidence: probability that all statements are right at once.
        deterministic: designs whose runs used no random numbers (True: all); for two such designs one replication
            gives the exact difference.

    Raises:
        StudyError: unknown method, no replication in common.

    Source: Law (2015), section 10.3.1 (all against a standard, Bonferroni); Holm (1979), Scandinavian J. of
    Statistics 6(2), 65-70.
    Assumes: as `paired`; the differences may depend on one another in any way. Runs fail independently of the
    indicator's value; otherwise a design that fails under load looks better than it is.
    """
    check_confidence(confidence)
    if method not in STATEMENTS:
        raise StudyError(f"method {method!r}: expected bonferroni or holm")
    m = len(against)
    each = 1.0 - (1.0 - confidence) / m
    pairs = {d: _common(d, table[d], table[base]) for d, base in against.items()}
    without_chance = set(table if deterministic is True else deterministic or ())
    exact = {d for d, base in against.items() if {d, base} <= without_chance}
    estimates = {d: paired(ours, base, each, deterministic=d in exact) for d, (ours, base, _) in pairs.items()}
    p_values = {d: p_value(*gaps(*pairs[d][:2])) for d, e in estimates.items() if e.interval}
    adjusted = _adjusted(p_values, method, m)
    differences = tuple(
        Difference(
            design=d,
            baseline=against[d],
            estimate=e,
            missing=pairs[d][2],
            p_value=p_values.get(d),
            p_adjusted=adjusted.get(d),
            differs=adjusted[d] <= 1.0 - confidence if d in adjusted else e.mean != 0.0 if d in exact else None,
        )
        for d, e in estimates.items()
    )
    statement = STATEMENTS[method] if m > 1 else "1 difference; its interval holds with {c:g} % confidence"
    statement = statement.format(m=m, c=100 * confidence, a=100 * (1 - confidence), e=100 * each)
    return Differences(dict(against), confidence, differences, statement)


def holm(p_values: Sequence[float], family: int | None = None) -> list[float]:
    """Return Holm's adjusted p-values in the given order; rejecting those <= α keeps the familywise error within α.

    `family` is the number of hypotheses if some have no p-value; default: the number of p-values.

    Source: Holm (1979): sorted upwards, the i-th (from 0) times family - i, never below the one before, at
    most 1.
    """
    m = len(p_values) if family is None else family
    order = np.argsort(p_values, kind="stable")
    adjusted = [0.0] * len(p_values)
    highest = 0.0
    for rank, index in enumerate(order.tolist()):
        highest = max(highest, min(1.0, (m - rank) * p_values[index]))
        adjusted[index] = highest
    return adjusted


def _adjusted(p_values: Mapping[D, float], method: Method, m: int) -> dict[D, float]:
    """Return the p-values of a family of `m` differences, adjusted by the given method."""
    if method == "holm":
        return dict(zip(p_values, holm(list(p_values.values()), m), strict=True))
    return {design: min(1.0, m * p) for design, p in p_values.items()}


def _common(
    design: Hashable, ours: Sequence[float] | Floats, base: Sequence[float] | Floats
) -> tuple[Floats, Floats, int]:
    """Return the values of both designs in their common replications, and how many replications either lacks."""
    a, b = np.asarray(ours, dtype=float), np.asarray(base, dtype=float)
    n = min(a.size, b.size)
    both = np.isfinite(a[:n]) & np.isfinite(b[:n])
    if not both.any():
        raise StudyError(f"design {design!r} has no finished replication in common with the baseline")
    return a[:n][both], b[:n][both], max(a.size, b.size) - int(both.sum())
