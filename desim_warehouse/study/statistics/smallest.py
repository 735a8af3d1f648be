"""The smallest design that meets a target: the search of `cheapest` with one count."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from desim_warehouse.errors import StudyError, spoken
from desim_warehouse.study.statistics.cheapest import cheapest_meeting_steps

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from desim_warehouse.study.statistics.cheapest import Cheapest
    from desim_warehouse.study.statistics.judge import DesignVerdict, Judge
    from desim_warehouse.study.statistics.procedure import Procedure
    from desim_warehouse.study.statistics.targets import Target

V = TypeVar("V")


@dataclass(frozen=True)
class Sizing(Generic[V]):
    """The answer, every design judged in the order of the search, and caveats.

    `smallest` is None if no design was shown to meet the target. `below` is the decision about its neighbour: that it
    "fails" makes the answer the smallest, "undecided" says so in `note`, and it is None if there is no neighbour.
    `vetoed` fail whatever their runs say of the target, with the reason. `falls` lists pairs of values of which the
    larger one does worse: then each smaller design was judged by itself.
    """

    smallest: V | None
    target: Target
    below: DesignVerdict[V] | None
    decisions: tuple[DesignVerdict[V], ...]
    falls: tuple[tuple[V, V], ...]
    runs: int
    confidence: float
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
            parts.append(f"not {values}: {self.vetoed[0][1]}")
        if self.below is not None and self.below.verdict == "undecided":
            alone = "" if self.below.outlier is None else f", which replication {self.below.outlier} alone leaves open"
            parts.append(f"{self.below.value} is too close to call after {self.below.n} replications{alone}")
        if self.falls:
            pairs = ", ".join(f"{b} than with {a}" for a, b in self.falls)
            parts.append(f"it does worse with {pairs}, so each smaller one was judged by itself")
        return "; ".join(parts)


def smallest_meeting_steps(
    values: Sequence[V], judge: Judge, doubted: Collection[int] = (), *, scan: bool = False
) -> Procedure[Sizing[V]]:
    """The first of `values` (fleet sizes, say) whose mean indicator meets the target: yields positions in `values`.

    Args:
        values: the designs to choose from, smallest (cheapest) first.
        judge: knows the target, and has judged nothing yet.
        doubted: positions of those that a search with other runs found to fail (`scout_steps`).
        scan: judge all from the smallest, which needs no response that only rises.

    Raises:
        StudyError: no or repeated values, or a run whose value is not finite.

    Source: `cheapest_meeting_steps`, with what it promises and assumes.
    """
    if not values or any(a == b for i, a in enumerate(values) for b in values[:i]):
        raise StudyError(f"values to search {list(values)!r}: expected at least one, none twice")
    found = yield from cheapest_meeting_steps(line(len(values)), lambda design: design, judge, doubted, scan=scan)
    return _sizing(values, found, judge.target)


def line(number: int) -> list[tuple[int, ...]]:
    """Designs with one count."""
    return [(position,) for position in range(number)]


def _sizing(values: Sequence[V], found: Cheapest, target: Target) -> Sizing[V]:
    verdicts: Mapping[int, DesignVerdict[Any]] = found.verdicts
    decisions = {number: replace(one, value=values[number]) for number, one in verdicts.items()}
    smallest = found.design
    return Sizing(
        None if smallest is None else values[smallest],
        target,
        decisions.get(len(values) - 1 if smallest is None else smallest - 1),
        tuple(decisions.values()),
        tuple((values[one.base], values[one.number]) for one in found.larger if one.worse),
        found.runs,
        found.confidence,
        tuple((values[number], why) for number, why in found.vetoed.items()),
    )
