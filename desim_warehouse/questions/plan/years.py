"""A plan for several years: how long the fleet for today is enough, and the answer year by year."""

from __future__ import annotations

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.parts import Folded
from desim_warehouse.questions.plan import cells
from desim_warehouse.questions.plan.planned import Planned
from desim_warehouse.study.fleet import Sized


def lasts(planned: Planned) -> list[str]:
    """Return the sentence on the year up to which the fleet for today is enough."""
    first = planned.plan.today.best
    if not planned.yearly or first is None or planned.plan.ended:
        return []
    later = [sized for sized in planned.plan.demands if sized.best is None or sized.best.counts != first.counts]
    if not later:
        return ["The fleet for today is enough in all of these years."]
    standing_then = cells.cells(later[0]).get(first.counts)
    too_small = "is too small" if standing_then == "not met" else "is not shown to be enough"
    return [f"The fleet for today {too_small} in year {later[0].year}."]


def table(planned: Planned) -> list[Folded]:
    """Return the table of the answer year by year."""
    if not planned.yearly:
        return []
    most = planned.counted(tuple(map(max, zip(*planned.plan.today.counts, strict=True))))
    priced = any(sized.best and sized.best.cost is not None for sized in planned.plan.demands)
    head = (
        "year",
        f"{words.loads(planned.model)} an hour",
        *(name for name, number in most.items() if number),
        *["a year"] * priced,
    )
    return [
        Folded(
            title="Year by year",
            head=head,
            rows=tuple(_year(planned, sized) for sized in planned.plan.demands),
            printed=True,
        )
    ]


def _year(planned: Planned, sized: Sized) -> tuple[str, ...]:
    when = (
        "today" if not sized.year else f"{sized.year}",
        "" if sized.rate is None else numbers.number(sized.rate),
    )
    if sized.best is None or sized.open:
        return (*when, "open" if sized.open else "none")
    counts = [f"{count}" for count in planned.counted(sized.best.counts).values() if count]
    return (*when, *counts, *([] if sized.best.cost is None else [planned.money(sized.best.cost)]))
