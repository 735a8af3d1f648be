"""A plan in rows, tiles and figures: the fleets that show the answer, each with its standing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from desim_warehouse.answer import words
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.parts import BigNumber, Option, PairGrid, Rows, ShownNumber
from desim_warehouse.answer.standing import lasts_not
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model.facts.people import COUNTED
from desim_warehouse.questions import judged
from desim_warehouse.questions.plan import cells, sheet
from desim_warehouse.questions.plan.planned import Planned
from desim_warehouse.study.fleet import Shown, Sized
from desim_warehouse.study.statistics.cheapest import Counts


def tiles(planned: Planned) -> list[BigNumber]:
    """Return the largest numbers of the answer: the counts of the fleet, what it reaches, and its cost."""
    sized = planned.answered
    if sized is None or sized.best is None:
        return []
    best = sized.best
    year = [] if best.cost is None else [BigNumber(value=planned.money(best.cost), what="cost a year")]
    if planned.key is not None:
        value = planned.key.value(best.counts)
        what = f"robot{'s' * (value != 1)}" if planned.key.is_fleet else words.in_words(planned.key.of)
        return [BigNumber(value=words.level(value), what=what), *_reached(planned, best), *year]
    if len(planned.demands) > 1:
        return [_tile(planned, size, size.best) for size in planned.demands if size.best is not None and not size.open]
    totals = planned.plan.designs.totals(best.counts)
    counts = [
        BigNumber(value=str(number), what=f"{COUNTED[name]}{'s' * (number != 1)}")
        for name, number in totals.items()
        if number
    ]
    return [*counts, *_reached(planned, best), *year]


def _tile(planned: Planned, sized: Sized, best: Shown) -> BigNumber:
    """Return the tile of the fleet for one of several demands, with its indicator and cost."""
    reached = words.reached(planned.goal.indicator, planned.text(best))
    cost = "" if best.cost is None else f"; {planned.money(best.cost)} a year"
    return BigNumber(value=planned.fleet(best.counts), what=planned.when(sized), note=f"{reached}{cost}")


def _reached(planned: Planned, best: Shown) -> list[BigNumber]:
    first = judged.tile(planned.text(best), words.in_sentence(planned.goal.indicator))
    return [first, *(judged.tile(number.text, words.in_sentence(number.of)) for number in _also(planned, best))]


def options(planned: Planned, sized: Sized) -> list[Option]:
    """Return the fleets that show the answer, for the last demand also with other strategies."""
    tried = [*([sized.best] if sized.best else []), *sized.below]
    if planned.key is not None:
        tried.sort(key=lambda shown: shown.counts)
    listing = [_option(planned, sized, shown, planned.chosen) for shown in tried]
    if sized.capped is not None:
        listing.append(_capped(planned, sized))
    if sized is not planned.demands[-1]:
        return listing
    if sized is not planned.with_own:
        listing += [
            _option(planned, planned.with_own, shown, planned.own_strategy()) for shown in planned.with_own.below
        ]
    for strategy in planned.plan.strategies:
        changed = replace(planned.with_own, overrides={**planned.with_own.overrides, **strategy.overrides})
        listed = {shown.counts for shown in tried} if strategy is planned.plan.strategy else set()
        name = sheet.choice(strategy)
        listing += [_option(planned, changed, shown, name) for shown in strategy.shown if shown.counts not in listed]
    return listing


def _design(planned: Planned, shown: Shown, strategy: str) -> str:
    """Return a design in words, with the name of its strategy unless this is empty."""
    return f"{planned.fleet(shown.counts)}, {strategy}" if strategy else planned.fleet(shown.counts)


def _option(planned: Planned, sized: Sized, shown: Shown, strategy: str) -> Option:
    """Return the row of a design; `strategy`: its strategy by name, empty for the model's if no other is better."""
    strategies = planned.plan.strategies if sized is planned.with_own else ()
    lasting = lasts_not(shown.wrong)
    fails = shown.estimate is None or shown.vetoed is not None
    has_number = lasting is None and not fails
    return Option(
        name=_design(planned, shown, strategy),
        standing=lasting or ("fails" if fails else judged.standing_of(shown.verdict, planned.goal)),
        number=judged.number(shown.verdict, planned.goal, planned.model) if has_number else None,
        also=tuple(_also(planned, shown)) if has_number else (),
        days=judged.in_row(shown.days, planned.goal, planned.model) if has_number else "",
        instead="" if has_number else planned.text(shown),
        runs=shown.verdict.n,
        cost=shown.cost,
        group=planned.when(sized) if len(planned.demands) > 1 else "",
        set={**sized.overrides, **shown.overrides},
        same=tuple(item.label for item in strategies if shown.counts in item.same),
    )


def _also(planned: Planned, shown: Shown) -> list[ShownNumber]:
    """Return the numbers of a fleet for the targets after the first."""
    each = zip(planned.plan.targets[1:], shown.verdict.each[1:], strict=False)
    return [judged.number(verdict, goal, planned.model) for goal, verdict in each]


def _capped(planned: Planned, sized: Sized) -> Option:
    """Return the row of the largest fleet with a cap on the robots under way."""
    cap, largest = sized.capped, sized.below[-1]
    assert cap is not None
    return Option(
        name=f"{_design(planned, largest, planned.chosen)}, at most {cap.cap} under way",
        standing="known",
        number=judged.within(planned.goal.indicator, planned.scale, (cap.mean, None, None)),
        runs=cap.gain.n,
        group=planned.when(sized) if len(planned.demands) > 1 else "",
        set={**sized.overrides, **largest.overrides, **cap.overrides},
    )


def grid(planned: Planned) -> PairGrid | None:
    """Draw the standing of every searched fleet, by robots and chargers, with the people of the answer.

    Without an answer the grid shows the most people.
    """
    searched = dict.fromkeys(counts for sized in planned.demands for counts in sized.counts)
    if not searched:
        return None
    robots, chargers, *_ = (sorted(set(side)) for side in zip(*searched, strict=True))
    panels = {}
    for sized in planned.demands:
        standings = cells.cells(sized)
        drawn = max(sized.counts) if sized.best is None else sized.best.counts
        panels[f"{planned.when(sized)}{_with_people(planned, drawn)}"] = tuple(
            tuple(standings.get((first, second, *drawn[2:]), "untried") for first in robots)
            for second in reversed(chargers)
        )
    down = tuple(str(number) if number else "" for number in reversed(chargers))
    how = "robots across, chargers down" if any(chargers) else "by number of robots"
    title = f"Which fleets give {planned.targets()}: {how}"
    return PairGrid(title=title, across=tuple(map(str, robots)), down=down, panels=panels)


def intervals(planned: Planned, options: Sequence[Option]) -> Rows | None:
    """Draw every judged value, with its interval, beside the target."""
    title = capital(words.in_sentence(planned.goal.indicator))
    bars = (judged.bar(row.name, row.number, row.standing) for row in options if row.number is not None)
    return judged.figure(title, bars, planned.goal.value, judged.aim(planned.goal))


def _with_people(planned: Planned, counts: Counts) -> str:
    totals = planned.plan.designs.totals(counts)
    people = [number_of(totals[kind.name], kind.noun) for kind in planned.plan.designs.people]
    return f", {spoken(people)}" if people else ""
