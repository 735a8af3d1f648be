"""Search for the smallest value of one key that meets a target: a plan whose designs have one count."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from desim_warehouse.errors import StudyError, shown
from desim_warehouse.study.fleet.designs import OneKey
from desim_warehouse.study.fleet.given import goals_of
from desim_warehouse.study.fleet.plan import Planner
from desim_warehouse.study.fleet.sizes import FleetSizes
from desim_warehouse.study.possible import possible_part
from desim_warehouse.study.procedures import refuse_other
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.judge import Budget
from desim_warehouse.study.statistics.limits import MOST_RUNS
from desim_warehouse.study.study import StudyEngine


def size_key(
    study: StudyEngine,
    target: str | Sequence[str],
    *,
    zone: float | str | None = None,
    scan: bool = False,
    search: Search = USUAL,
) -> FleetSizes:
    """Find the smallest value of a study's only factor that meets a target, at today's demand.

    The arguments are those of `questions.size.size`.

    Raises:
        StudyError: not exactly one factor, a bad target or zone, or a run that failed other than by a flat battery.

    Source: see `cheapest_meeting_steps`, with what it promises and assumes.
    """
    if not isinstance(study, StudyEngine):
        raise StudyError(f"size: {shown(study):.60}, expected a Study of one factor")
    if not isinstance(search, Search):
        raise StudyError(f"size, search: {shown(search):.60}, expected a Search; scan=True looks at all values")
    refuse_other(study, search)
    study, not_tried = possible_part(study)
    base, confidence, seed = study.plan.base, study.plan.confidence, study.plan.seed
    goal, zone, beside = goals_of(target, zone, base)
    designs, budget = OneKey(study, scan=scan, not_tried=not_tried), Budget(search.runs or MOST_RUNS)
    with replace(search, confidence=confidence, seed=seed).together() as together:
        planner = Planner(base, goal, zone, designs, together, budget, beside=beside)
        sized = planner.size(1.0, {}, study.plan.name)
    return FleetSizes(
        base, goal, zone, confidence, "", (sized,), (), None, designs, budget.spent, seed=seed, beside=beside
    )
