"""Sentences on the fleet that is enough for one demand, the strategies tried, and the busiest resource."""

from __future__ import annotations

import math

from desim_warehouse.answer import busiest, words
from desim_warehouse.answer.numbers import capital, sentence
from desim_warehouse.answer.standing import WORDS, lasts_not, standing
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model.facts.demand import due_within
from desim_warehouse.outcome.indicators import is_of_due
from desim_warehouse.outcome.targets import Target
from desim_warehouse.questions import judged
from desim_warehouse.questions.plan import cells, hours, sheet
from desim_warehouse.questions.plan.planned import Planned
from desim_warehouse.questions.sentences import capped
from desim_warehouse.study.fleet import Shown, Sized
from desim_warehouse.study.fleet.loads import TRIP
from desim_warehouse.study.fleet.most import RUNS
from desim_warehouse.study.statistics.cheapest import Counts
from desim_warehouse.study.statistics.intervals import Estimate
from desim_warehouse.study.target import is_cycle_time

_MAY_PILE_UP = "As demand exceeds capacity, work may pile up in a longer run (--set run.length=24h)."
"""A remark on the named fleet, as a target such as one on utilisation does not ask whether it keeps up."""


def of_demand(planned: Planned, sized: Sized) -> str:
    """Return the answer for one demand: the fleet that is enough, or why none is named."""
    if sized.open:
        return _ended(planned, sized)
    if sized.best is None:
        return _none(planned, sized)
    cost = "" if sized.best.cost is None else f", {planned.money(sized.best.cost)} a year"
    reached = words.reached(planned.goal.indicator, planned.text(sized.best))
    first = "cheapest" if cost and planned.key is None else "smallest"
    line = f"{planned.are(sized.best.counts)} the {first} {planned.noun} shown to be enough"
    number = "" if planned.plan.beside else f": {reached}"
    line = f"{line}{planned.in_time(sized)}{number}{cost}.{_days(planned, sized.best)}{hours.worst(planned, sized)}"
    if close := cells.left(planned.plan, sized, "open"):
        line += f" {capital(close)} may also be enough; {_would_tell(planned, sized)}."
    if edge := cells.left(planned.plan, sized, "edge"):
        line += f" {capital(edge)} may also be enough; {_too_close(planned)}."
    return line + _worse(planned, sized) + _against(planned, sized) + _most(planned, sized)


def of_each_target(planned: Planned, sized: Sized) -> list[str]:
    """Return a line for each of several targets, on the fleet that the answer names."""
    if not planned.plan.beside or sized.open or not (sized.best or sized.below):
        return []
    named = sized.best or _nearest(planned, sized)
    if lasts_not(named.wrong) or named.vetoed:
        return []
    fleet = capital(planned.fleet(named.counts))
    return [
        f"{fleet}, {words.target(goal)}: {judged.number(mean, goal, planned.model).text}, {WORDS[standing(mean)]}."
        for goal, mean in zip(planned.plan.targets, named.verdict.each, strict=True)
    ]


def _days(planned: Planned, shown: Shown) -> str:
    """Return the sentence on the worst day of a fleet, after a blank; empty if there are several targets."""
    text = "" if planned.plan.beside else judged.days(shown.days, planned.goal, planned.model)
    return text and f" {text}"


def _too_close(planned: Planned) -> str:
    return f"within {planned.zone()} of the target, no number of runs will tell"


def _would_tell(planned: Planned, sized: Sized) -> str:
    """Return the estimate of how many runs would decide whether an open fleet is enough."""
    needed = [shown.to_tell for shown in sized.below if standing(shown.verdict) == "open"]
    runs_needed = [runs for runs in needed if runs is not None]
    if not runs_needed or len(runs_needed) < len(needed):
        return "even many more runs may not tell"
    option = "--runs" if planned.plan.untried else "--cap"
    return f"about {10 * math.ceil(max(runs_needed) / 10)} runs of each {planned.noun} would tell ({option})"


def _ended(planned: Planned, sized: Sized) -> str:
    """Return the fleets that are enough, too few or open if the runs ran out before an answer."""
    shown_enough = f" {planned.are(sized.best.counts)} enough." if sized.best else ""
    if 0 < len(sized.below) <= cells.LISTED:
        *others, last = (shown.counts for shown in sized.below)
        few = spoken([*map(planned.fleet, others), planned.are(last)])
        shown_enough += f" {capital(few)} too few."
    left = f"{len(sized.open)} of {number_of(len(sized.counts), planned.noun)} remain open"
    runs = number_of(planned.plan.runs, "run")
    return f"{planned.then(sized, f'undecided after {runs}')}.{shown_enough} {left}."


def _none(planned: Planned, sized: Sized) -> str:
    """Return that no fleet is enough, the result of the largest, and what more robots would not cure."""
    if sized.undecided:
        return _undecided(planned, sized)
    largest = _nearest(planned, sized)
    line = f"{planned.then(sized, planned.none_is(sized, 'enough'))}. {capital(planned.fleet(largest.counts))}: "
    text = planned.text(largest)
    if largest.flat:
        return f"{line}{text}. {capital(largest.flat)}."
    if planned.plan.beside and not lasts_not(largest.wrong) and not largest.vetoed:
        none = planned.then(sized, planned.none_is(sized, "shown to be enough for all targets"))
        return f"{none}. This is what {planned.fleet(largest.counts)} would do:"
    line += f"{text}." if lasts_not(largest.wrong) else _reached_by(planned, largest, text)
    if sized.fewer:
        return line
    line += _most(planned, sized) + _worse(planned, sized)
    line += "" if sized.capped is None else f" {capped(sized.capped, planned.scale)}."
    if sized.trip is not None:
        return f"{line} {_trip(planned, sized.trip)}"
    return f"{line} {sentence(capital(busiest.are(sized.loads, _time(sized))))}" if sized.loads else line


def _undecided(planned: Planned, sized: Sized) -> str:
    """Return the fleets that remain open if no fleet is shown to be enough, nor the largest to miss."""
    largest = _nearest(planned, sized)
    verdict, name = largest.verdict, capital(planned.fleet(largest.counts))
    if judged.is_perfect(verdict, planned.goal):
        fleet, reason = planned.fleet(largest.counts), judged.perfect(verdict, planned.goal)
        return f"{planned.then(sized, f'no {planned.noun} can be shown to be enough')}. {capital(fleet)}: {reason}"
    days = number_of(verdict.n, "day")
    line = f"{planned.then(sized, f'not decided after {days}')}."
    if left := cells.left(planned.plan, sized, "open"):
        line += f" {capital(left)} may be enough; {_would_tell(planned, sized)}."
    if edge := cells.left(planned.plan, sized, "edge"):
        line += f" {capital(edge)} may be enough; {_too_close(planned)}."
    if planned.plan.beside:
        return f"{line} This is what {planned.fleet(largest.counts)} would do:"
    return f"{line} {name}: {_reached_by(planned, largest, planned.text(largest))}"


def _reached_by(planned: Planned, shown: Shown, text: str) -> str:
    """Return the end of a sentence on what a fleet reaches, and the sentence on its worst day."""
    return f"{words.reached(planned.goal.indicator, text)}.{_days(planned, shown)}"


def _nearest(planned: Planned, sized: Sized) -> Shown:
    """Return the largest fleet judged or, if fewer robots do better, the fleet nearest to the target."""
    lasting = [shown for shown in sized.below if not shown.vetoed]
    if not sized.fewer or not lasting or planned.plan.beside:
        return sized.below[-1]
    return max(lasting, key=lambda shown: planned.goal.sign * shown.verdict.mean)


def _against(planned: Planned, sized: Sized) -> str:
    """Return that the ends of the range contradict the assumed order of fleets; empty if they agree with it."""
    if not sized.against:
        return ""
    if sized.fewer:
        return " Fewer robots usually do better, but not here, so each fleet was judged by itself."
    more = "More robots usually do" if planned.plan.designs.is_fleet else "More usually does"
    return f" {more} better, but not here: the smallest {planned.noun} is enough and the largest is not."


def _trip(planned: Planned, trip: Estimate) -> str:
    """Return the time of a trip beside the time that the target allows, if no resource is scarce."""
    if is_cycle_time(planned.goal):
        allowed: float | None = planned.goal.value
    else:
        allowed = due_within(planned.model) if is_of_due(planned.goal.indicator) else None
    scale = words.scale(TRIP, planned.model, (trip.mean if allowed is None else allowed,))
    limit = "" if allowed is None else f", and the time allowed is {scale.value(allowed)}"
    return f"Robots are not the limit: a trip takes {scale.value(trip.mean)} on average, waits included{limit}."


def _worse(planned: Planned, sized: Sized) -> str:
    """Return the larger designs that do worse than a smaller design."""
    if not sized.worse:
        return ""
    phrases = [_does_worse(planned, *contrast) for contrast in sized.worse]
    return f" More is not always better here: {spoken(phrases)}."


def _does_worse(planned: Planned, more: Counts, less: Counts, by: Estimate | None, goal: Target) -> str:
    if by is None:
        return f"with {planned.fleet(more)} robots run flat, with {planned.fleet(less)} they do not"
    scale = words.scale(goal.indicator, planned.model, (by.mean,))
    indicator = f" in {words.in_sentence(goal.indicator)}" if planned.plan.beside else ""
    return f"{planned.fleet(more)} do worse than {planned.fleet(less)} by {scale.value(abs(by.mean))}{indicator}"


def _most(planned: Planned, sized: Sized) -> str:
    """Return the fleet with the largest output, if there are pods and more robots do worse."""
    most = sized.most
    if most is None:
        return ""
    scale = words.scale(planned.goal.indicator, planned.model, (most.mean, most.at_largest))
    best = f"{number_of(most.robots, 'robot')} do most, {scale.value(most.mean)} in {RUNS} runs"
    return f" More is not always better here: {best}; {most.largest} do {scale.value(most.at_largest)}."


def of_strategies(planned: Planned) -> list[str]:
    """Return whether another dispatching policy needs a smaller fleet."""
    plan = planned.plan
    lines = []
    if plan.strategy is not None:
        own = planned.own_strategy()
        lines = [f"The strategy is {sheet.choice(plan.strategy)}, which needs fewer than {own}."]
    elif plan.strategies:
        tried = [sheet.choice(strategy) for strategy in plan.strategies if strategy.shown]
        same = [sheet.choice(strategy) for strategy in plan.strategies if not strategy.shown]
        parts = [f"{spoken(tried)} need{'s' * (len(tried) == 1)} as large a fleet"] if tried else []
        parts += [f"{spoken(same)} change{'s' * (len(same) == 1)} nothing"] if same else []
        lines = [f"Strategies other than {planned.own_strategy()} do not help: {', '.join(parts)}."]
    return lines + ([f"No runs were left to try {spoken(plan.untried)}."] if plan.untried else [])


def of_busiest(planned: Planned) -> list[str]:
    """Return the sentence on the busiest resource with the fleet of the answer, and whether demand exceeds it."""
    sized = planned.answered
    if sized is None or sized.best is None:
        return []
    busy = busiest.are(sized.loads, _time(sized), f"with {planned.fleet(sized.best.counts)}")
    if not busy:
        return []
    exceeds = any(load.mean > 1 for load in sized.loads)
    return [sentence(busy), *([_MAY_PILE_UP] if exceeds else [])]


def _time(sized: Sized) -> str:
    """Return the time to which utilisations refer, in words: all of it, or the hours of a shift plan."""
    return "of their hours" if sized.in_hours else "of the time"
