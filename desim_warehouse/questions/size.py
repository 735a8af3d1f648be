"""The verbs `size`, for the smallest value of a key that meets a target, and `most`, for the value that does most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answered
from desim_warehouse.questions import race, sentences
from desim_warehouse.questions.plan.answer import answer as answer_of
from desim_warehouse.questions.race import Best
from desim_warehouse.questions.study import Study
from desim_warehouse.study import procedures
from desim_warehouse.study.fleet import FleetSizes, size_key
from desim_warehouse.study.fleet.capped import tried_cap, waits_much
from desim_warehouse.study.procedures import FLEET, ZONE
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.judge import DesignVerdict
from desim_warehouse.study.statistics.limits import FIRST


@dataclass(frozen=True, repr=False)
class Size(Answered, FleetSizes):
    """The smallest value of a key that meets a target: the result of `size`.

    Attributes:
        answer: the answer in words; shown by `print`.
        smallest: the smallest value; None if no value was shown to meet the target.
        target: the target to meet.
        decisions: the verdict on each value that was simulated.
        runs: total number of runs simulated.
    """

    @property
    def smallest(self) -> Any:
        """The smallest value that meets the target; None if no value was shown to meet it."""
        best = self.today.best
        return None if best is None else self.designs.value(best.counts)

    @property
    def decisions(self) -> tuple[DesignVerdict[Any], ...]:
        """The verdict on each value that was simulated, smallest first."""
        tried = [*self.today.below, *([self.today.best] if self.today.best else [])]
        tried.sort(key=lambda shown: shown.counts)
        return tuple(replace(shown.verdict, value=self.designs.value(shown.counts)) for shown in tried)

    def in_short(self) -> str:
        """Return the value and the target in a few words."""
        return f"{self.smallest}: {self.target}" if self.smallest is not None else f"none: {self.target}"


def size(
    study: Study,
    target: str | Sequence[str],
    *,
    zone: float | str | None = None,
    scan: bool = False,
    search: Search = USUAL,
) -> Size:
    """Find the smallest value of a study's factor whose mean is shown to meet a target.

    Args:
        study: a study with one factor, its values in ascending order.
        target: such as "throughput_per_hour >= 220"; for shares such as "on_time >= 95 %" or "on_time >= 0.95"; of
            several targets, a value has to meet all.
        zone: indifference zone of a single target, in its unit; default: 0.01 for shares, else 1 % of the target.
        scan: try all values from the first on, instead of bisection, as larger values may not be better.
        search: settings of runs; confidence, seed and time limit are the study's.

    Returns:
        The smallest value with the verdict on each simulated value, and the answer in words; see `Size`.

    Raises:
        StudyError: not one factor, a bad target, or a run that failed, unless a robot ran flat: such a value fails.

    Source: a search by bisection with sequential tests: a plan of one count.
    """
    sizes = size_key(study, target, zone=zone, scan=scan, search=search)
    return Size(**vars(sizes), answer=answer_of(sizes).keep(search.out, search.command))


def most(
    study: Study,
    indicator: str = "throughput_per_hour",
    *,
    share: float = ZONE,
    search: Search = USUAL,
) -> Best:
    """Find the smallest value of a study's factor with which most is done; larger values need not do more.

    If the factor is the number of robots and the largest fleet does less, that fleet is also tried with a cap on the
    robots under way.

    Args:
        study: a study with one factor, its values in ascending order.
        indicator: the indicator of what is done.
        share: a smaller difference, as a share of the largest mean of the first replications, does not matter.
        search: settings of runs; confidence, seed and time limit are the study's.

    Raises:
        StudyError: unknown indicator, fewer than two designs, or a run that failed.

    Source: see `procedures.race`.
    """
    [key] = (factor.key for factor in study.plan.factors)
    with search.together() as together:
        raced = procedures.race(study, indicator, share=share, search=together)
        falls = key == FLEET and raced.selection.eliminated_at[-1] is not None
        capped = _of_cap(study, indicator, together) if falls else ""
    least = f"{words.factor_name(key)} {words.level(raced.first.labels[key])}"
    alike = f"{least} is the smallest that does as much, within {100 * share:g} % of the most."
    return Best(
        **vars(raced),
        answer=race.answer(raced, "size", tuple(filter(None, (alike, capped)))).keep(search.out, search.command),
    )


def _of_cap(study: Study, indicator: str, search: Search) -> str:
    """Try caps on the robots under way of the largest fleet, and return the sentence on the best; empty if none helps.

    No cap is tried unless robots wait much.
    """
    largest = study.points[-1]
    rows = study.results.by_point[largest.number]
    if not waits_much(row.indicators for row in rows):
        return ""
    model = study.plan.base.replace(largest.overrides)
    first = search.first or FIRST
    best, _ = tried_cap(model, indicator, replace(search.under("cap"), first=first, cap=2 * first))
    return "" if best is None else f"{sentences.capped(best, words.scale(indicator, model, (best.mean,)))}."
