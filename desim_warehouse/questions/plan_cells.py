"""What each fleet that a plan searched was shown to be, and by which words those that remain open are called."""

from __future__ import annotations

import math
from collections.abc import Mapping

from desim_warehouse.answer import words
from desim_warehouse.answer.standing import Standing, lasts_not, standing
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.study.fleet import FleetSizes, OneKey, Sized
from desim_warehouse.study.statistics.cheapest import Counts, within_counts

WHAT = ("robot", "charger", "packer")
"""What is counted."""
_LISTED = 4
"""Fleets that are named one by one."""


def named(plan: FleetSizes, counts: Counts) -> str:
    """Name a design inside a sentence: `6 robots, 2 chargers and 3 packers`, or of one key `battery threshold 2`."""
    if isinstance(plan.designs, OneKey):
        return words.design_spoken({plan.designs.of: plan.designs.value(counts)})
    return words.fleet(*counts, nodes=1 if plan.designs.packers is None else plan.designs.packers.nodes)


def cells(sized: Sized) -> dict[Counts, Standing]:
    """What each fleet was shown to be, or what follows from others where more never does worse."""
    best = None if sized.best is None else sized.best.counts
    known: dict[Counts, Standing] = dict.fromkeys(sized.failed_before, "not met")
    known |= {one.counts: lasts_not(one.wrong) or standing(one.verdict) for one in sized.below}
    follows = sized.ordered
    return {one: _stands(one, best, known, set(sized.open), follows=follows) for one in sized.counts}


def left(plan: FleetSizes, sized: Sized, kind: Standing) -> str:
    """Name all fleets of one standing inside a sentence, `4 robots and 2 to 5 chargers`; empty where there is none."""
    counts = sorted(one for one, known in cells(sized).items() if known == kind)
    if not counts:
        return ""
    if isinstance(plan.designs, OneKey):
        return spoken([named(plan, one) for one in counts], "or")
    packers = plan.designs.packers
    nodes = (1, 1, 1 if packers is None else packers.nodes)
    spans = [(min(side), max(side)) for side in zip(*counts, strict=True)]
    parts = [
        f"{low * each} to {high * each} {what}s" if low < high else number_of(high * each, what)
        for (low, high), what, each in zip(spans, WHAT, nodes, strict=False)
        if high
    ]
    if len(counts) == math.prod(high - low + 1 for low, high in spans):
        return spoken(parts)
    if len(counts) <= _LISTED:
        return spoken([named(plan, one) for one in counts], "or")
    return f"{len(counts)} other fleets, of {spoken(parts)},"


def but(plan: FleetSizes) -> str:
    """The smaller fleets that a promise leaves out, as they may be enough: `, but for 2 robots and 1 charger,`."""
    named = [sized for sized in (plan.today, plan.grown) if sized is not None and sized.best is not None]
    names = dict.fromkeys(name.removesuffix(",") for sized in named if (name := left(plan, sized, "open")))
    return f", but for {spoken(list(names))}," if names else ""


def _stands(
    one: Counts, best: Counts | None, known: Mapping[Counts, Standing], untold: set[Counts], *, follows: bool
) -> Standing:
    """What a fleet is: none smaller than one that is too small is enough, and all larger than one that is are."""
    if one == best or (follows and best is not None and within_counts(best, one)):
        return "met"
    if one in known or not follows:
        return known.get(one, "open" if one in untold else "untried")
    over = {verdict for other, verdict in known.items() if within_counts(one, other)}
    if over & {"not met", "overloaded", "drained", "fails"}:
        return "not met"
    if one in untold or "open" in over:
        return "open"
    return "edge" if "edge" in over else "untried"
