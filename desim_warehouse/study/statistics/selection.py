"""Selection of the best of several designs by the KN procedure of Kim and Nelson, for `desim best`.

The procedure (ranking and selection) drops clearly worse designs as replications come in.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.checks import check_confidence
from desim_warehouse.study.statistics.intervals import bounds, differing_share, gaps
from desim_warehouse.study.statistics.limits import COMMON_DAYS, MOST_RUNS
from desim_warehouse.study.statistics.procedure import Procedure, request
from desim_warehouse.values.arrays import Floats


@dataclass(frozen=True)
class Selection:
    """The design chosen by KN, and when others were eliminated; designs have numbers from 0, in the indicator's unit.

    `means[i]` is over the replications that design i was judged on: `eliminated_at[i]`, or all if it was never
    eliminated (None). `samples[i]` counts the runs requested. `guaranteed` is False if a limit ended the race; `best`
    then merely has the best mean of the `survivors`. `within`: the other designs that are less than delta worse than
    the best, with simultaneous `confidence` (one-sided bounds of the differences, Bonferroni), so that any will do.
    `equal`: the designs among them that equal the best in every run.
    """

    best: int
    within: tuple[int, ...]
    survivors: tuple[int, ...]
    eliminated_at: tuple[int | None, ...]
    means: tuple[float, ...]
    samples: tuple[int, ...]
    guaranteed: bool
    deterministic: bool
    delta: float
    confidence: float
    equal: tuple[int, ...] = ()


def kn_constants(k: int, confidence: float, n0: int) -> tuple[float, float]:
    """Return the constants η and h² of KN for c = 1.

    Source: Kim & Nelson (2001): η = ½ [(2α / (k-1))^(-2/(n0-1)) - 1], h² = 2 c η (n0-1).

    Raises:
        StudyError: fewer than two designs or first replications, or a confidence that pure chance gives.
    """
    check_confidence(confidence)
    if k < 2 or n0 < 2:  # noqa: PLR2004
        raise StudyError(f"selection among {k} designs from {n0} replications: expected at least 2 of each")
    if confidence <= 1.0 / k:
        raise StudyError(f"confidence {confidence:g}: expected more than 1/{k}, the confidence of a random choice")
    eta = 0.5 * ((2.0 * (1.0 - confidence) / (k - 1)) ** (-2.0 / (n0 - 1)) - 1.0)
    return eta, 2.0 * eta * (n0 - 1)


def kn_steps(
    k: int,
    delta: float,
    confidence: float = 0.95,
    n0: int = 10,
    *,
    maximise: bool = True,
    cap: int = 1000,
    most: int = MOST_RUNS,
    ahead: int = 1,
    deterministic: bool = False,
) -> Procedure[Selection]:
    """Select the best of `k` designs by the mean of an indicator, with as few runs as the differences allow.

    Args:
        k: number of designs, at least 2.
        delta: indifference zone, in the indicator's unit: a smaller difference does not matter to the user.
        confidence: probability of a right choice, more than 1/k.
        n0: replications of every design in the first stage, at least 2; 10 or more are recommended.
        maximise: the largest mean is best, or else the smallest.
        cap: most replications of one design; `guaranteed` is False when it ends the race.
        most: most runs of all designs together, at least n0 of each; it ends the race likewise.
        ahead: replications of each survivor to request at a time. More of them keep many workers busy at the price
            of some superfluous runs; the selection does not change.
        deterministic: the models use no random numbers, so that differences are exact.

    Raises:
        StudyError: arguments outside these ranges, or a run whose value is not finite.

    Source: Kim & Nelson (2001), A fully sequential procedure for indifference-zone selection in simulation,
    ACM TOMACS 11(3), 251-273, with c = 1.
    Assumes: independent replications, jointly normal over the designs, with unknown and unequal variances. Runs of
    the same replication may be dependent: common random numbers reduce the variance of the differences, and with it
    the number of runs. Guarantee: the best design is selected with `confidence` if it leads by at least delta; with
    closer rivals, experience (not the theorem) shows that a design within delta is selected. Differences that agree in
    all n0 replications get the variance of the share of runs that may still differ. Two designs whose varying values
    are equal run by run count as equal from 33 runs on, which would show a difference on one day in ten.
    """
    _, h2 = kn_constants(k, confidence, n0)
    if not delta > 0.0:
        raise StudyError(f"indifference zone {delta!r}: expected a number above 0, in the indicator's unit")
    if cap < n0 or ahead < 1:
        raise StudyError(f"cap {cap}, ahead {ahead}: expected a cap of at least n0 = {n0}, and ahead >= 1")
    if most < k * n0:
        raise StudyError(f"{most} runs: too few for {k} designs, expected at least {k * n0}, {n0} for each")
    race = _Race(k, 1.0 if maximise else -1.0)
    yield from race.run(n0)
    each = 1.0 - (1.0 - confidence) / (k - 1)
    variances = np.zeros((k, k)) if deterministic else race.difference_variances(each)
    slack = race.shortened(h2 * variances / delta**2)  # N_il of the paper, before rounding down
    race.screen(slack, delta)
    while not race.over(slack) and race.r < (last := min(cap, race.last(most))):
        yield from race.run(1, ahead=min(ahead, last - race.r))
        slack = race.shortened(h2 * variances / delta**2)
        race.screen(slack, delta)
    return Selection(
        best=race.leader(),
        within=race.within(delta, None if deterministic else each),
        survivors=race.alive,
        eliminated_at=tuple(race.eliminated_at),
        means=tuple(race.means().tolist()),
        samples=tuple(len(row) for row in race.data),
        guaranteed=race.over(slack),
        deterministic=deterministic,
        delta=delta,
        confidence=confidence,
        equal=tuple(i for i in range(k) if i != race.leader() and race.equal(i, race.leader())),
    )


class _Race:
    """The surviving designs, their values, and when the others were eliminated."""

    def __init__(self, k: int, sign: float) -> None:
        self.sign = sign  # +1: the largest mean is best, -1: the smallest
        self.data: list[list[float]] = [[] for _ in range(k)]
        self.totals = np.zeros(k)
        self.judged_on = np.zeros(k, dtype=int)
        self.r = 0  # replications of every survivor judged so far
        self.alive = tuple(range(k))
        self.eliminated_at: list[int | None] = [None] * k

    def run(self, more: int, ahead: int = 1) -> Procedure[None]:
        """Judge the survivors on `more` further replications, requesting runs that are missing."""
        have, want = len(self.data[self.alive[0]]), self.r + more
        if have < want:
            runs = [(i, rep) for rep in range(have, have + max(more, ahead)) for i in self.alive]
            for (design, _), value in zip(runs, (yield from request(runs)), strict=True):
                self.data[design].append(value)
        for i in self.alive:
            self.totals[i] += sum(self.data[i][self.r : want])
            self.judged_on[i] = want
        self.r = want

    def last(self, most: int) -> int:
        """Return the replications that every survivor can have within `most` runs of all designs together."""
        made = [len(row) for row in self.data]
        return made[self.alive[0]] + (most - sum(made)) // len(self.alive)

    def difference_variances(self, level: float) -> Floats:
        """Return S²_il of the paper: variances (divisor n0-1) of paired differences, shape (k, k).

        Differences that agree so far get the variance that they would have if the share of runs that may still differ
        (at `level`) did so, as far as they may.
        """
        first = np.array(self.data)
        result = np.zeros((len(first), len(first)))
        for i, j in combinations(range(len(first)), 2):
            differences, reach = gaps(first[i], first[j])
            variance = differences.var(ddof=1) or differing_share(differences.size, level) * reach**2
            result[i, j] = result[j, i] = variance
        return result

    def shortened(self, slack: Floats) -> Floats:
        """Return N_il, shortened for designs equal in every run so far: a difference on one day in ten would show."""
        made = slack.copy()
        for i, j in combinations(range(len(self.data)), 2):
            if self.equal(i, j):
                made[i, j] = made[j, i] = min(slack[i, j], COMMON_DAYS.least - 1)
        return made

    def equal(self, i: int, j: int) -> bool:
        """Whether two designs have equal, varying values in all runs on which both were judged."""
        n = min(self.judged_on[i], self.judged_on[j])
        ours, theirs = self.data[i][:n], self.data[j][:n]
        return ours == theirs and len(set(ours)) > 1

    def within(self, delta: float, level: float | None) -> tuple[int, ...]:
        """Return designs less than `delta` worse than the leader, by bounds with `level` (None: exact)."""
        best, tied = self.leader(), []
        for i in range(len(self.data)):
            n = min(self.judged_on[i], self.judged_on[best])
            worse, reach = gaps(self.sign * np.array(self.data[best][:n]), self.sign * np.array(self.data[i][:n]))
            alike = n >= COMMON_DAYS.least and self.equal(i, best)
            most = worse[0] if level is None or alike else bounds(worse, level, reach=reach)[1]
            if i != best and most < delta:
                tied.append(i)
        return tuple(tied)

    def screen(self, slack: Floats, delta: float) -> None:
        """Drop designs whose mean is more than W_il(r) = max(0, δ/2r (N_il - r)) below another survivor's."""
        ids = np.array(self.alive)
        means = self.sign * self.means()[ids]
        width = np.maximum(0.0, delta / (2 * self.r) * (slack[np.ix_(ids, ids)] - self.r))
        np.fill_diagonal(width, 0.0)
        kept = tuple(ids[(means[:, None] >= means[None, :] - width).all(axis=1)].tolist())
        for i in set(self.alive) - set(kept):
            self.eliminated_at[i] = self.r
        self.alive = kept

    def over(self, slack: Floats) -> bool:
        """Whether one design is left, or r has reached the largest N_il + 1, when only equal means are left."""
        return all(self.r >= int(slack[i, j]) + 1 for i, j in combinations(self.alive, 2))

    def means(self) -> Floats:
        return self.totals / self.judged_on

    def leader(self) -> int:
        """Return the survivor with the best mean, and of equals the one with the lowest number."""
        means = self.sign * self.means()
        return max(self.alive, key=lambda i: (means[i], -i))
