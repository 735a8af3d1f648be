"""The standing of each fleet that a plan searched, and the words for the fleets that remain open."""

from __future__ import annotations

import math
from collections.abc import Mapping

from desim_warehouse.answer import words
from desim_warehouse.answer.standing import Standing, lasts_not, standing
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model.facts.people import COUNTED
from desim_warehouse.study.fleet import FleetSizes, OneKey, Sized
from desim_warehouse.study.statistics.cheapest import Counts, rules_out, within_counts

LISTED = 4
"""Number of fleets up to which they are named one by one."""


def named(plan: FleetSizes, counts: Counts) -> str:
    """Return the name of a design inside a sentence: `6 robots, 2 chargers and 3 packers`, or `battery threshold 2`."""
    if isinstance(plan.designs, OneKey):
        return words.design_spoken({plan.designs.of: plan.designs.value(counts)})
    totals = plan.designs.totals(counts)
    each = {
        kind.name: f" ({totals[kind.name] // kind.nodes} at each of {kind.nodes})"
        for kind in plan.designs.people
        if kind.nodes > 1
    }
    parts = [f"{number_of(number, COUNTED[name])}{each.get(name, '')}" for name, number in totals.items() if number]
    return spoken(parts)


def cells(sized: Sized) -> dict[Counts, Standing]:
    """Return the standing of each fleet: shown by its runs, or implied by other fleets if more never does worse."""
    best = None if sized.best is None else sized.best.counts
    standings: dict[Counts, Standing] = {
        counts: "drained" if drained else "not met" for counts, drained in sized.failed_before.items()
    }
    standings |= {shown.counts: lasts_not(shown.wrong) or standing(shown.verdict) for shown in sized.below}
    follows = sized.ordered
    return {counts: _stands(counts, best, standings, set(sized.open), follows=follows) for counts in sized.counts}


def left(plan: FleetSizes, sized: Sized, kind: Standing) -> str:
    """Name all fleets of one standing inside a sentence: `4 robots and 2 to 5 chargers`; empty if there are none."""
    counts = sorted(fleet for fleet, verdict in cells(sized).items() if verdict == kind)
    if not counts:
        return ""
    if isinstance(plan.designs, OneKey):
        return spoken([named(plan, fleet) for fleet in counts], "or")
    spans = [(min(side), max(side)) for side in zip(*counts, strict=True)]
    least, most = (plan.designs.totals(ends) for ends in zip(*spans, strict=True))
    parts = [
        f"{least[name]} to {high} {COUNTED[name]}s" if least[name] < high else number_of(high, COUNTED[name])
        for name, high in most.items()
        if high
    ]
    if len(counts) == math.prod(high - low + 1 for low, high in spans):
        return spoken(parts)
    if len(counts) <= LISTED:
        return spoken([named(plan, fleet) for fleet in counts], "or")
    return f"{len(counts)} other fleets, of {spoken(parts)},"


def but(plan: FleetSizes) -> str:
    """Return the end of a promise, with the fleets that remain open: `, except perhaps 2 robots and 1 charger`."""
    named = [sized for sized in (plan.today, plan.grown) if sized is not None and sized.best is not None]
    names = dict.fromkeys(name.removesuffix(",") for sized in named if (name := left(plan, sized, "open")))
    return f", except perhaps {spoken(list(names))}" if names else ""


def _stands(
    counts: Counts, best: Counts | None, standings: Mapping[Counts, Standing], left_open: set[Counts], *, follows: bool
) -> Standing:
    """Return the standing of a fleet.

    If more never does worse (`follows`), fleets below a failing one fail, and fleets above the best are enough.
    `left_open`: fleets whose standing is open.
    """
    if counts == best or (follows and best is not None and within_counts(best, counts)):
        return "met"
    if counts in standings or not follows:
        return standings.get(counts, "open" if counts in left_open else "untried")
    over = {verdict for other, verdict in standings.items() if rules_out(other, counts, drained=verdict == "drained")}
    if over & {"not met", "overloaded", "drained", "fails"}:
        return "not met"
    if counts in left_open or "open" in over:
        return "open"
    return "edge" if "edge" in over else "untried"
