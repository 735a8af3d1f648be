"""How many robots, chargers and packers it takes: `plan_fleet`, whose answer is put into words by `plan_words`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from desim_warehouse.answer.answer import Answered
from desim_warehouse.model import Source, as_model
from desim_warehouse.questions import plan_words
from desim_warehouse.study.fleet import FleetSizes, size_fleet
from desim_warehouse.study.search import USUAL, Search


@dataclass(frozen=True)
class FleetPlan(FleetSizes, Answered):
    """The sizes for each demand, with the answer."""


def plan_fleet(
    model: Source,
    target: str | Sequence[str],
    *,
    growth: float | str | None = None,
    years: int | None = None,
    strategies: Mapping[str, Any] | None = None,
    robots: Sequence[int] | str | None = None,
    chargers: Sequence[int] | str | None = None,
    packers: str | None = None,
    zone: float | str | None = None,
    search: Search = USUAL,
) -> FleetPlan:
    """Find how many robots, chargers and packers meet a target, today and with more demand, and with which strategy.

    Args:
        model: the warehouse, or its file. With prices of robots or chargers the cheapest are sought, else fewest
            robots, then chargers, then packers. Its bays with most chargers are those whose chargers are sized.
        target: such as "on_time >= 95 %"; of several, as in ["on_time:express >= 95 %", "on_time:rest >= 98 %"], a
            fleet has to meet all.
        growth: demand in times today's, such as 1.3 or "30%"; with years "20%/year"; None: today's only.
        years: that are planned after today's. What fails with less demand is taken to fail with more.
        strategies: key of the model -> its values, to be tried with designs too small (default: `STRATEGIES`).
        robots: fleet sizes that could be bought, such as "6..20" (default: around what the quick estimate needs).
        chargers: likewise.
        packers: a station and who may work there, at each of its nodes, such as "packing=1..4": its servers, or its
            workers where it has a work time; "packing": by the quick estimate; None: as many as the model has.
        zone: indifference zone in the unit of the one target; default: 0.01 for shares, else 1 % of the target. At most
            half of what is possible beyond the target: for 99.5 % it is 0.25 %.
        search: how runs are done, at most 5000 by default.

    Raises:
        StudyError: a bad target or zone, demand that cannot grow, a run that failed, too few runs to search.

    Source: see `cheapest_meeting_steps`, with what it promises and assumes.
    """
    sizes = size_fleet(
        as_model(model),
        target,
        growth=growth,
        years=years,
        strategies=strategies,
        robots=robots,
        chargers=chargers,
        packers=packers,
        zone=zone,
        search=search,
    )
    return worded(sizes, search)


def worded(sizes: FleetSizes, search: Search = USUAL) -> FleetPlan:
    """Add the answer to the sizes of a fleet, and write it to the folder of the search."""
    return FleetPlan(**vars(sizes), answer=plan_words.answer(sizes).keep(search.out, search.command))
