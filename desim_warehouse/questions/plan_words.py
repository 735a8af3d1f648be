"""The answer of `desim plan`: the fleet that is enough for each demand, the fleets tried, and those left open."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from typing import Any

from desim_warehouse.answer import busiest, numbers, words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import capital, sentence
from desim_warehouse.answer.parts import BigNumber, Folded, Option, PairGrid, Rows, ShownNumber, Subject
from desim_warehouse.answer.standing import WORDS, Standing, instead, lasts_not, standing
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model.facts.charging import without_charger
from desim_warehouse.model.facts.demand import due_within
from desim_warehouse.model.facts.people import COUNTED
from desim_warehouse.outcome.indicators import AT, find, is_of_due
from desim_warehouse.outcome.targets import Target
from desim_warehouse.questions import departures, judged, plan_cells, plan_sheet
from desim_warehouse.questions.sentences import capped, not_tried
from desim_warehouse.study import rare
from desim_warehouse.study.fleet import FleetSizes, OneKey, Shown, Sized
from desim_warehouse.study.fleet.hours import ON_TIME, Hour
from desim_warehouse.study.fleet.loads import TRIP
from desim_warehouse.study.fleet.most import RUNS
from desim_warehouse.study.statistics.cheapest import Counts
from desim_warehouse.study.statistics.intervals import Estimate
from desim_warehouse.study.target import is_cycle_time

_MAY_PILE_UP = "As demand exceeds capacity, work may pile up in a longer run (--set run.length=24h)."
"""A remark on the named fleet, as a target such as one on utilisation does not ask whether it keeps up."""


def answer(plan: FleetSizes, guesses: Sequence[str] | None = None) -> Answer:
    """Put the sizes of a fleet into words; `guesses`: keys of the model whose values are guesses, None if unknown."""
    return _Planned(plan, guesses).answer()


def more_orders(growth: float) -> str:
    """Return demand relative to today's in words: `with 30 % more orders`."""
    percent = round(100 * (growth - 1), 6)
    return f"with {percent:g} % more orders" if percent >= 0 else f"with {-percent:g} % fewer orders"


class _Planned:
    """A plan with the last demand that has an answer, which is the only demand that a page draws.

    `chosen`: the name of the strategy that is better than the model's; empty if none is. `with_own`: the answer for the
    last demand with the model's strategy.
    """

    def __init__(self, plan: FleetSizes, guesses: Sequence[str] | None) -> None:
        self.guesses = guesses
        self.plan, self.model, self.goal = plan, plan.model, plan.target
        self.scale = judged.scale_of(plan.target, plan.model)
        self.key = plan.designs if isinstance(plan.designs, OneKey) else None
        self.noun = "fleet" if plan.designs.is_fleet else "value"
        self.yearly = plan.today.year is not None
        self.demands = [plan.today] if plan.grown is None else [plan.today, plan.grown]
        self.chosen = "" if plan.strategy is None else plan_sheet.choice(plan.strategy)
        self.with_own = plan.with_own or self.demands[-1]
        self.answered = next((sized for sized in reversed(self.demands) if sized.best and not sized.open), None)

    def answer(self) -> Answer:
        plan = self.plan
        sized = [
            line
            for sized in self.demands
            for line in (self._sized(sized), *self._each(sized), *([] if sized.best else not_tried(sized.not_tried)))
        ]
        lines = list(dict.fromkeys(sized)) + self._lasts() + self._strategies() + self._busiest()
        options = tuple(option for sized in self.demands for option in self._options(sized))
        return Answer(
            kind="plan" if self.key is None else "size",
            name=self.model.name,
            description=self.model.description,
            question=self._question(),
            answer=tuple(lines),
            measures={goal.indicator: words.in_sentence(goal.indicator) for goal in plan.targets},
            tiles=tuple(self._tiles()),
            options=options,
            figure=self._grid() if self.key is None else self._intervals(options),
            nearest=() if self.key is not None else plan_sheet.nearest(options, self.goal),
            about=self._about(),
            tables=(*self._years(), *self._hours(), *self._sheet()),
            promise=self._promise(),
            notes=tuple(self._beside(options)),
            runs=plan.runs,
            confidence=plan.confidence,
            made={"seed": str(plan.seed), "model": self.model.digest()},
            feasible=plan.feasible,
            target=_bound(self.goal),
            **({"targets": [_bound(goal) for goal in plan.targets]} if plan.beside else {}),
            zone=plan.zone,
            strategy=plan.strategy.label if plan.strategy else plan.own,
            today=self._facts(plan.today),
            grown=None if plan.grown is None else self._facts(plan.grown),
            **({"years": [self._facts(sized) for sized in plan.demands]} if self.yearly else {}),
            **({} if self.key is None else {"key": self.key.of, "smallest": self._smallest(self.key)}),
        )

    def _smallest(self, key: OneKey) -> Any:
        best = self.plan.today.best
        return None if best is None else key.value(best.counts)

    def _question(self) -> str:
        if self.key is not None:
            return f"What is the smallest {words.in_words(self.key.of)} that gives {self._targets()}?"
        designs = self.plan.designs
        fleet = spoken(["robots", *["chargers"] * (designs.zone is not None), *(kind.name for kind in designs.people)])
        later = f"in {len(self.plan.demands) - 1} years" if self.yearly else more_orders(self.demands[-1].growth)
        grown = "" if self.plan.grown is None else f", today and {later}"
        return f"How many {fleet} does it take for {self._targets()}{grown}?"

    # Sentences

    def _in_time(self, sized: Sized) -> str:
        """Return the demand for the end of a phrase; empty if one key is sized, as this is for today's demand alone."""
        return "" if self.key is not None else f" {self._when(sized)}"

    def _then(self, sized: Sized, sentence: str) -> str:
        """Begin a sentence with its demand: `Today (60 an hour): no fleet is enough`; unchanged if one key is sized."""
        return capital(sentence if self.key is not None else f"{self._when(sized)}: {sentence}")

    def _when(self, sized: Sized) -> str:
        later = more_orders(sized.growth) if sized.year is None else f"in year {sized.year}"
        when = "today" if sized is self.plan.today else later
        return when if sized.rate is None else f"{when} ({numbers.number(sized.rate)} an hour)"

    def _sized(self, sized: Sized) -> str:
        """Return the answer for one demand: the fleet that is enough, or why none is named."""
        if sized.open:
            return self._ended(sized)
        if sized.best is None:
            return self._none(sized)
        cost = "" if sized.best.cost is None else f", {self._money(sized.best.cost)} a year"
        reached = words.reached(self.goal.indicator, self._text(sized.best))
        first = "cheapest" if cost and self.key is None else "smallest"
        line = f"{self._are(sized.best.counts)} the {first} {self.noun} shown to be enough"
        number = "" if self.plan.beside else f": {reached}"
        line = f"{line}{self._in_time(sized)}{number}{cost}.{self._days(sized.best)}{self._worst(sized)}"
        if close := plan_cells.left(self.plan, sized, "open"):
            line += f" {capital(close)} may also be enough; {self._would_tell(sized)}."
        if edge := plan_cells.left(self.plan, sized, "edge"):
            line += f" {capital(edge)} may also be enough; {self._too_close()}."
        return line + self._worse(sized) + self._against(sized) + self._most(sized)

    def _days(self, shown: Shown) -> str:
        """Return the sentence on the worst day of a fleet, after a blank; empty if there are several targets."""
        text = "" if self.plan.beside else judged.days(shown.days, self.goal, self.model)
        return text and f" {text}"

    def _too_close(self) -> str:
        return f"within {self._zone()} of the target, no number of runs will tell"

    def _would_tell(self, sized: Sized) -> str:
        """Return the estimate of how many runs would decide whether an open fleet is enough."""
        needed = [shown.to_tell for shown in sized.below if standing(shown.verdict) == "open"]
        runs_needed = [runs for runs in needed if runs is not None]
        if not runs_needed or len(runs_needed) < len(needed):
            return "even many more runs may not tell"
        option = "--runs" if self.plan.untried else "--cap"
        return f"about {10 * math.ceil(max(runs_needed) / 10)} runs of each {self.noun} would tell ({option})"

    def _ended(self, sized: Sized) -> str:
        """Return the fleets that are enough, too few or open if the runs ran out before an answer."""
        shown_enough = f" {self._are(sized.best.counts)} enough." if sized.best else ""
        if 0 < len(sized.below) <= plan_cells.LISTED:
            *others, last = (shown.counts for shown in sized.below)
            few = spoken([*map(self._fleet, others), self._are(last)])
            shown_enough += f" {capital(few)} too few."
        left = f"{len(sized.open)} of {number_of(len(sized.counts), self.noun)} remain open"
        runs = number_of(self.plan.runs, "run")
        return f"{self._then(sized, f'undecided after {runs}')}.{shown_enough} {left}."

    def _none(self, sized: Sized) -> str:
        """Return that no fleet is enough, the result of the largest, and what more robots would not cure."""
        if sized.undecided:
            return self._undecided(sized)
        largest = self._nearest(sized)
        line = f"{self._then(sized, self._none_is(sized, 'enough'))}. {capital(self._fleet(largest.counts))}: "
        text = self._text(largest)
        if largest.flat:
            return f"{line}{text}. {capital(largest.flat)}."
        if self.plan.beside and not self._lasting(largest) and not largest.vetoed:
            none = self._then(sized, self._none_is(sized, "shown to be enough for all targets"))
            return f"{none}. This is what {self._fleet(largest.counts)} would do:"
        line += f"{text}." if self._lasting(largest) else self._reached_by(largest, text)
        if sized.fewer:
            return line
        line += self._most(sized) + self._worse(sized)
        line += "" if sized.capped is None else f" {capped(sized.capped, self.scale)}."
        if sized.trip is not None:
            return f"{line} {self._trip(sized.trip)}"
        return f"{line} {sentence(capital(busiest.are(sized.loads, _time(sized))))}" if sized.loads else line

    def _each(self, sized: Sized) -> list[str]:
        """Return a line for each of several targets, on the fleet that the answer names."""
        if not self.plan.beside or sized.open or not (sized.best or sized.below):
            return []
        named = sized.best or self._nearest(sized)
        if self._lasting(named) or named.vetoed:
            return []
        fleet = capital(self._fleet(named.counts))
        return [
            f"{fleet}, {words.target(goal)}: {judged.number(mean, goal, self.model).text}, {WORDS[standing(mean)]}."
            for goal, mean in zip(self.plan.targets, named.verdict.each, strict=True)
        ]

    def _targets(self) -> str:
        """Join the targets of a fleet: `at least 95 % on time, express and mean cycle time at most 10 min`."""
        return spoken([words.target(goal) for goal in self.plan.targets])

    def _undecided(self, sized: Sized) -> str:
        """Return the fleets that remain open if no fleet is shown to be enough, nor the largest to miss."""
        largest = self._nearest(sized)
        verdict, name = largest.verdict, capital(self._fleet(largest.counts))
        if judged.is_perfect(verdict, self.goal):
            fleet, reason = self._fleet(largest.counts), judged.perfect(verdict, self.goal)
            return f"{self._then(sized, f'no {self.noun} can be shown to be enough')}. {capital(fleet)}: {reason}"
        days = number_of(verdict.n, "day")
        line = f"{self._then(sized, f'not decided after {days}')}."
        if left := plan_cells.left(self.plan, sized, "open"):
            line += f" {capital(left)} may be enough; {self._would_tell(sized)}."
        if edge := plan_cells.left(self.plan, sized, "edge"):
            line += f" {capital(edge)} may be enough; {self._too_close()}."
        if self.plan.beside:
            return f"{line} This is what {self._fleet(largest.counts)} would do:"
        return f"{line} {name}: {self._reached_by(largest, self._text(largest))}"

    def _reached_by(self, shown: Shown, text: str) -> str:
        """Return the end of a sentence on what a fleet reaches, and the sentence on its worst day."""
        return f"{words.reached(self.goal.indicator, text)}.{self._days(shown)}"

    def _nearest(self, sized: Sized) -> Shown:
        """Return the largest fleet judged or, if fewer robots do better, the fleet nearest to the target."""
        lasting = [shown for shown in sized.below if not shown.vetoed]
        if not sized.fewer or not lasting or self.plan.beside:
            return sized.below[-1]
        return max(lasting, key=lambda shown: self.goal.sign * shown.verdict.mean)

    def _against(self, sized: Sized) -> str:
        """Return that the ends of the range contradict the assumed order of fleets; empty if they agree with it."""
        if not sized.against:
            return ""
        if sized.fewer:
            return " Fewer robots usually do better, but not here, so each fleet was judged by itself."
        more = "More robots usually do" if self.plan.designs.is_fleet else "More usually does"
        return f" {more} better, but not here: the smallest {self.noun} is enough and the largest is not."

    def _trip(self, trip: Estimate) -> str:
        """Return the time of a trip beside the time that the target allows, if no resource is scarce."""
        if is_cycle_time(self.goal):
            allowed: float | None = self.goal.value
        else:
            allowed = due_within(self.model) if is_of_due(self.goal.indicator) else None
        scale = words.scale(TRIP, self.model, (trip.mean if allowed is None else allowed,))
        limit = "" if allowed is None else f", and the time allowed is {scale.value(allowed)}"
        return f"Robots are not the limit: a trip takes {scale.value(trip.mean)} on average, waits included{limit}."

    def _worse(self, sized: Sized) -> str:
        """Return the larger designs that do worse than a smaller design."""
        if not sized.worse:
            return ""
        phrases = [self._does_worse(*contrast) for contrast in sized.worse]
        return f" More is not always better here: {spoken(phrases)}."

    def _does_worse(self, more: Counts, less: Counts, by: Estimate | None, goal: Target) -> str:
        if by is None:
            return f"with {self._fleet(more)} robots run flat, with {self._fleet(less)} they do not"
        scale = words.scale(goal.indicator, self.model, (by.mean,))
        indicator = f" in {words.in_sentence(goal.indicator)}" if self.plan.beside else ""
        return f"{self._fleet(more)} do worse than {self._fleet(less)} by {scale.value(abs(by.mean))}{indicator}"

    def _most(self, sized: Sized) -> str:
        """Return the fleet with the largest output, if there are pods and more robots do worse."""
        most = sized.most
        if most is None:
            return ""
        scale = words.scale(self.goal.indicator, self.model, (most.mean, most.at_largest))
        best = f"{number_of(most.robots, 'robot')} do most, {scale.value(most.mean)} in {RUNS} runs"
        return f" More is not always better here: {best}; {most.largest} do {scale.value(most.at_largest)}."

    def _strategies(self) -> list[str]:
        """Return whether another dispatching policy needs a smaller fleet."""
        plan = self.plan
        lines = []
        if plan.strategy is not None:
            own = self._own()
            lines = [f"The strategy is {plan_sheet.choice(plan.strategy)}, which needs fewer than {own}."]
        elif plan.strategies:
            tried = [plan_sheet.choice(strategy) for strategy in plan.strategies if strategy.shown]
            same = [plan_sheet.choice(strategy) for strategy in plan.strategies if not strategy.shown]
            parts = [f"{spoken(tried)} need{'s' * (len(tried) == 1)} as large a fleet"] if tried else []
            parts += [f"{spoken(same)} change{'s' * (len(same) == 1)} nothing"] if same else []
            lines = [f"Strategies other than {self._own()} do not help: {', '.join(parts)}."]
        return lines + ([f"No runs were left to try {spoken(plan.untried)}."] if plan.untried else [])

    def _own(self) -> str:
        """Return the strategy of the model in words."""
        return words.named_policy(self.plan.own)

    def _busiest(self) -> list[str]:
        """Return the sentence on the busiest resource with the fleet of the answer, and whether demand exceeds it."""
        sized = self.answered
        if sized is None or sized.best is None:
            return []
        busy = busiest.are(sized.loads, _time(sized), f"with {self._fleet(sized.best.counts)}")
        if not busy:
            return []
        exceeds = any(load.mean > 1 for load in sized.loads)
        return [sentence(busy), *([_MAY_PILE_UP] if exceeds else [])]

    def _promise(self) -> str:
        plan = self.plan
        judged_fleets = [fleet for sized in self.demands for fleet in (sized.best, *sized.below) if fleet is not None]
        if judged_fleets and all(fleet.verdict.deterministic and not fleet.verdict.agrees for fleet in judged_fleets):
            return "Nothing in the model is left to chance, so each number above is exact."
        sure = f"{100 * plan.confidence:g} % confidence{' for each demand' * (self.key is None)}"
        if plan.ended or self.answered is None:
            return f"Each answer above holds with {sure}."
        most = [sized.most.up_to for sized in self.demands if sized.most is not None]
        up_to = f", up to {min(most)} robots" if most else ""
        is_ordered = all(sized.ordered for sized in self.demands)
        alike = f" Assumption: a larger {self.noun} never does worse{up_to}." if is_ordered else ""
        alike = f"{self._covers()}{alike}"
        if self.yearly:
            alike += " A fleet that fails with less demand is assumed to fail with more."
        aim = "these targets" if plan.beside else "this target"
        return (
            f"With {sure}, the {self.noun} shown to be enough reaches {self._targets()}, and no smaller {self.noun} "
            f"beats {aim} by {self._zone()} or more{plan_cells.but(plan)}.{alike}"
        )

    def _covers(self) -> str:
        """Return the sentence on how rare the days are that the runs of the named fleets cover."""
        named = [(sized, sized.best) for sized in self.demands if sized.best is not None]
        least = min(best.verdict.least for _, best in named)
        if not least or any(best.verdict.deterministic for _, best in named):
            return ""
        models = [self.model.replace({**sized.overrides, **best.overrides}) for sized, best in named]
        return f" {judged.covers(least, models)}"

    def _zone(self) -> str:
        zones = ((self.goal, self.plan.zone), *self.plan.beside)
        return spoken([words.amount(goal.indicator, zone, goal.unit) for goal, zone in zones])

    def _beside(self, options: Sequence[Option]) -> list[str]:
        """Return notes on fleets that miss although their interval holds the target, and on what no run shows.

        These are closures and, beside a fleet that is enough, fleets that cannot be simulated, robots that are never
        charged, and batteries that end the day lower.
        """
        zone = words.amount(self.goal.indicator, self.plan.zone, self.goal.unit)
        left_out = [line for sized in self.demands if sized.best for line in not_tried(sized.not_tried)]
        flat = [line for sized in self.demands if sized.best for line in self._without_charger(sized, sized.best)]
        return [
            *judged.holds_the_target(options, self.goal, zone),
            *map(sentence, rare.closed(self.model)),
            *dict.fromkeys(left_out),
            *dict.fromkeys(flat),
            *(words.batteries_end_lower(sized.best.lost) for sized in self.demands if sized.best and sized.best.lost),
        ]

    def _without_charger(self, sized: Sized, best: Shown) -> Iterator[str]:
        """Yield a sentence for each kind of robots that no charger serves: its batteries last for the run alone."""
        made = self.model.replace({**sized.overrides, **best.overrides})
        for kind, count in without_charger(made).items():
            robots = f"{number_of(count, 'robot')} of {f'kind {kind}' if kind else 'no kind'}"
            cure = "give bays for all robots some, or size a kind (desim size --key fleet.kinds.KIND.count)"
            yield f"With {self._fleet(best.counts)}, no bay has a charger for {robots}: {cure}."

    # Numbers

    def _lasting(self, shown: Shown) -> Standing | None:
        return lasts_not(shown.wrong)

    def _text(self, shown: Shown) -> str:
        """Return the indicator of a fleet in words, or the reason why it has none."""
        if self._lasting(shown):
            return instead(shown.wrong, self.model)
        if shown.vetoed or shown.estimate is None:
            return shown.vetoed or "no value"
        return judged.number(shown.verdict, self.goal, self.model).text

    def _money(self, value: float) -> str:
        return numbers.Scale(words.money(self.model)).value(value)

    def _tiles(self) -> list[BigNumber]:
        sized = self.answered
        if sized is None or sized.best is None:
            return []
        best = sized.best
        year = [] if best.cost is None else [BigNumber(value=self._money(best.cost), what="cost a year")]
        if self.key is not None:
            value = self.key.value(best.counts)
            what = f"robot{'s' * (value != 1)}" if self.key.is_fleet else words.in_words(self.key.of)
            return [BigNumber(value=words.level(value), what=what), *self._reached(best), *year]
        if len(self.demands) > 1:
            return [self._tile(size, size.best) for size in self.demands if size.best is not None and not size.open]
        totals = self.plan.designs.totals(best.counts)
        tiles = [
            BigNumber(value=str(number), what=f"{COUNTED[name]}{'s' * (number != 1)}")
            for name, number in totals.items()
            if number
        ]
        return [*tiles, *self._reached(best), *year]

    def _tile(self, sized: Sized, best: Shown) -> BigNumber:
        """Return the tile of the fleet for one of several demands, with its indicator and cost."""
        reached = words.reached(self.goal.indicator, self._text(best))
        cost = "" if best.cost is None else f"; {self._money(best.cost)} a year"
        return BigNumber(value=self._fleet(best.counts), what=self._when(sized), note=f"{reached}{cost}")

    def _reached(self, best: Shown) -> list[BigNumber]:
        first = judged.tile(self._text(best), words.in_sentence(self.goal.indicator))
        return [first, *(judged.tile(number.text, words.in_sentence(number.of)) for number in self._also(best))]

    def _options(self, sized: Sized) -> list[Option]:
        """Return the fleets that show the answer, for the last demand also with other strategies."""
        tried = [*([sized.best] if sized.best else []), *sized.below]
        if self.key is not None:
            tried.sort(key=lambda shown: shown.counts)
        options = [self._option(sized, shown, self.chosen) for shown in tried]
        if sized.capped is not None:
            options.append(self._capped(sized))
        if sized is not self.demands[-1]:
            return options
        if sized is not self.with_own:
            options += [self._option(self.with_own, shown, self._own()) for shown in self.with_own.below]
        for strategy in self.plan.strategies:
            changed = replace(self.with_own, overrides={**self.with_own.overrides, **strategy.overrides})
            listed = {shown.counts for shown in tried} if strategy is self.plan.strategy else set()
            name = plan_sheet.choice(strategy)
            options += [self._option(changed, shown, name) for shown in strategy.shown if shown.counts not in listed]
        return options

    def _design(self, shown: Shown, strategy: str) -> str:
        """Return a design in words, with the name of its strategy unless this is empty."""
        return f"{self._fleet(shown.counts)}, {strategy}" if strategy else self._fleet(shown.counts)

    def _option(self, sized: Sized, shown: Shown, strategy: str) -> Option:
        """Return the row of a design; `strategy`: its strategy by name, empty for the model's if no other is better."""
        strategies = self.plan.strategies if sized is self.with_own else ()
        lasting = self._lasting(shown)
        fails = shown.estimate is None or shown.vetoed is not None
        has_number = lasting is None and not fails
        return Option(
            name=self._design(shown, strategy),
            standing=lasting or ("fails" if fails else judged.standing_of(shown.verdict, self.goal)),
            number=judged.number(shown.verdict, self.goal, self.model) if has_number else None,
            also=tuple(self._also(shown)) if has_number else (),
            days=judged.in_row(shown.days, self.goal, self.model) if has_number else "",
            instead="" if has_number else self._text(shown),
            runs=shown.verdict.n,
            cost=shown.cost,
            group=self._when(sized) if len(self.demands) > 1 else "",
            set={**sized.overrides, **shown.overrides},
            same=tuple(item.label for item in strategies if shown.counts in item.same),
        )

    def _also(self, shown: Shown) -> list[ShownNumber]:
        """Return the numbers of a fleet for the targets after the first."""
        each = zip(self.plan.targets[1:], shown.verdict.each[1:], strict=False)
        return [judged.number(verdict, goal, self.model) for goal, verdict in each]

    def _capped(self, sized: Sized) -> Option:
        """Return the row of the largest fleet with a cap on the robots under way."""
        cap, largest = sized.capped, sized.below[-1]
        assert cap is not None
        return Option(
            name=f"{self._design(largest, self.chosen)}, at most {cap.cap} under way",
            standing="known",
            number=judged.within(self.goal.indicator, self.scale, (cap.mean, None, None)),
            runs=cap.gain.n,
            group=self._when(sized) if len(self.demands) > 1 else "",
            set={**sized.overrides, **largest.overrides, **cap.overrides},
        )

    # The figure, and the design that the page shows

    def _grid(self) -> PairGrid | None:
        """Draw the standing of every searched fleet, by robots and chargers, with the people of the answer.

        Without an answer the grid shows the most people.
        """
        searched = dict.fromkeys(counts for sized in self.demands for counts in sized.counts)
        if not searched:
            return None
        robots, chargers, *_ = (sorted(set(side)) for side in zip(*searched, strict=True))
        panels = {}
        for sized in self.demands:
            cells = plan_cells.cells(sized)
            drawn = max(sized.counts) if sized.best is None else sized.best.counts
            panels[f"{self._when(sized)}{self._with_people(drawn)}"] = tuple(
                tuple(cells.get((first, second, *drawn[2:]), "untried") for first in robots)
                for second in reversed(chargers)
            )
        down = tuple(str(number) if number else "" for number in reversed(chargers))
        how = "robots across, chargers down" if any(chargers) else "by number of robots"
        title = f"Which fleets give {self._targets()}: {how}"
        return PairGrid(title=title, across=tuple(map(str, robots)), down=down, panels=panels)

    def _intervals(self, options: Sequence[Option]) -> Rows | None:
        """Draw every judged value, with its interval, beside the target."""
        title = capital(words.in_sentence(self.goal.indicator))
        bars = (judged.bar(row.name, row.number, row.standing) for row in options if row.number is not None)
        return judged.figure(title, bars, self.goal.value, judged.aim(self.goal))

    def _about(self) -> Subject | None:
        sized = self.answered
        if sized is None or sized.best is None:
            return None
        made = self.model.replace({**sized.overrides, **sized.best.overrides})
        when = "" if self.key is not None else f", {self._when(sized)}"
        days = sized.best.days
        sorted_days = None if days is None else (days, self.goal)
        return judged.about(f"{self._fleet(sized.best.counts)}{when}", made, self.plan.seed, sorted_days)

    def _facts(self, sized: Sized) -> dict[str, Any]:
        best = sized.best
        return {
            "study": sized.name.replace(" ", "-"),
            "growth": sized.growth,
            "orders_per_hour": sized.rate,
            "best": best and {**self._counted(best.counts), "cost": best.cost},
            "capped": None if sized.capped is None else asdict(sized.capped),
            "open": [self._counted(counts) for counts in sized.open],
            "busy": {load.group.name: load.mean for load in sized.loads},
            **({"most": asdict(sized.most)} if sized.most else {}),
            **({"not_tried": list(map(asdict, sized.not_tried))} if sized.not_tried else {}),
        }

    def _sheet(self) -> tuple[Folded, ...]:
        """Return the tables beside the answer on its sheet; none if one key is sized."""
        if self.key is not None:
            return ()
        grown = [(capital(self._when(sized)), self._in_short(sized)) for sized in self.demands[1:]]
        return plan_sheet.tables(self.plan, grown, self.guesses)

    def _in_short(self, sized: Sized) -> str:
        if sized.open or sized.undecided:
            return "not decided"
        return self._none_is(sized, "enough") if sized.best is None else self._fleet(sized.best.counts)

    def _none_is(self, sized: Sized, what: str) -> str:
        """Return that no fleet is enough: no fleet tried, where larger ones cannot be simulated."""
        return f"no {self.noun}{' tried' * sized.is_cut_off} is {what}"

    # Counts, hours and years

    def _fleet(self, counts: Counts) -> str:
        """Return the counts of a design in words: `6 robots, 2 chargers and 3 packers`."""
        return plan_cells.named(self.plan, counts)

    def _are(self, counts: Counts) -> str:
        """Return the beginning of a sentence on a design: `6 robots and 1 charger are`, or `Battery threshold 2 is`."""
        designs = self.plan.designs
        is_one = not designs.is_fleet or (designs.value(counts) == 1 and not any(counts[1:]))
        return f"{capital(self._fleet(counts))} {'is' if is_one else 'are'}"

    def _counted(self, counts: Counts) -> dict[str, Any]:
        """Return the counts of a design for JSON, with people summed over the nodes of their station."""
        if self.key is not None:
            return {self.key.of: self.key.value(counts)}
        return {f"{COUNTED[name]}s": number for name, number in self.plan.designs.totals(counts).items()}

    def _with_people(self, counts: Counts) -> str:
        totals = self.plan.designs.totals(counts)
        people = [number_of(totals[kind.name], kind.noun) for kind in self.plan.designs.people]
        return f", {spoken(people)}" if people else ""

    def _worst(self, sized: Sized) -> str:
        """Return the sentence on the worst part of the day with the best fleet: `11:30 to 13:00: 97 %`.

        It is left out if the target itself is about a part of the day. The sentence on departures follows, if there are
        any.
        """
        lead = "" if sized.lead is None else departures.in_time(self.model, sized.lead)
        if not sized.hours or AT in self.goal.indicator:
            return lead
        worst = self._worst_of(sized)
        return f" {worst.named}: {words.reached(ON_TIME, self._on_time(worst))}.{lead}"

    def _worst_of(self, sized: Sized) -> Hour:
        return min(sized.hours, key=lambda hour: hour.share.mean)

    def _on_time(self, hour: Hour) -> str:
        low, high = hour.share.interval or (None, None)
        scale = words.scale(ON_TIME, self.model, (hour.share.mean,))
        return judged.within(ON_TIME, scale, (hour.share.mean, low, high)).text

    def _hours(self) -> list[Folded]:
        """Return the table of orders, and of shares on time, by the hour of the day."""
        sized = self.answered
        if sized is None or sized.best is None or not sized.hours:
            return []
        rows = [(hour.named, numbers.number(hour.orders), self._on_time(hour)) for hour in sized.hours]
        note = f"With {self._fleet(sized.best.counts)}, by when orders come. All intervals hold together."
        if self.goal.indicator == ON_TIME:
            worst = replace(self.goal, measure=find(self._worst_of(sized).indicator))
            note += f' A fleet for the worst part: --target "{worst.text}".'
        return [
            Folded(title="On time by the hour", note=note, head=("time", "orders", "done on time"), rows=tuple(rows))
        ]

    def _lasts(self) -> list[str]:
        """Return the sentence on the year up to which the fleet for today is enough."""
        first = self.plan.today.best
        if not self.yearly or first is None or self.plan.ended:
            return []
        later = [sized for sized in self.plan.demands if sized.best is None or sized.best.counts != first.counts]
        if not later:
            return ["The fleet for today is enough in all of these years."]
        standing_then = plan_cells.cells(later[0]).get(first.counts)
        too_small = "is too small" if standing_then == "not met" else "is not shown to be enough"
        return [f"The fleet for today {too_small} in year {later[0].year}."]

    def _years(self) -> list[Folded]:
        """Return the table of the answer year by year."""
        if not self.yearly:
            return []
        most = self._counted(tuple(map(max, zip(*self.plan.today.counts, strict=True))))
        priced = any(sized.best and sized.best.cost is not None for sized in self.plan.demands)
        head = (
            "year",
            f"{words.loads(self.model)} an hour",
            *(name for name, number in most.items() if number),
            *["a year"] * priced,
        )
        return [Folded(title="Year by year", head=head, rows=tuple(map(self._year, self.plan.demands)), printed=True)]

    def _year(self, sized: Sized) -> tuple[str, ...]:
        when = (
            "today" if not sized.year else f"{sized.year}",
            "" if sized.rate is None else numbers.number(sized.rate),
        )
        if sized.best is None or sized.open:
            return (*when, "open" if sized.open else "none")
        counts = [f"{count}" for count in self._counted(sized.best.counts).values() if count]
        return (*when, *counts, *([] if sized.best.cost is None else [self._money(sized.best.cost)]))


def _bound(goal: Target) -> dict[str, Any]:
    """Return a target for JSON."""
    return {"indicator": goal.indicator, "sense": goal.sense, "value": goal.value}


def _time(sized: Sized) -> str:
    """Return the time to which utilisations refer, in words: all of it, or the hours of a shift plan."""
    return "of their hours" if sized.in_hours else "of the time"
