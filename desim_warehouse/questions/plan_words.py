"""The answer of `desim plan`: which fleet is enough for each demand, and which others were tried or remain open."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

from desim_warehouse.answer import busiest, numbers, words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import capital, sentence
from desim_warehouse.answer.parts import BigNumber, Folded, Option, PairGrid, Rows, SaidNumber, Subject
from desim_warehouse.answer.standing import WORDS, Standing, instead, lasts_not, standing
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model.facts.demand import due_within
from desim_warehouse.outcome.indicators import AT, find
from desim_warehouse.outcome.targets import Target
from desim_warehouse.questions import departures, judged, plan_cells, plan_sheet
from desim_warehouse.questions.sentences import capped
from desim_warehouse.study import rare
from desim_warehouse.study.fleet import FleetSizes, OneKey, Shown, Sized, Strategy
from desim_warehouse.study.fleet.hours import ON_TIME, Hour
from desim_warehouse.study.fleet.loads import TRIP
from desim_warehouse.study.fleet.most import RUNS
from desim_warehouse.study.statistics.cheapest import Counts
from desim_warehouse.study.statistics.intervals import Estimate

_LISTED = 4
"""Fleets that are named one by one."""


def answer(plan: FleetSizes, guesses: Sequence[str] | None = None) -> Answer:
    """Put the sizes of a fleet into words; `guesses`: keys of the model that are some, None: unknown."""
    return _Planned(plan, guesses).answer()


def more_orders(growth: float) -> str:
    """Demand in words, from times today's: `with 30 % more orders`."""
    percent = round(100 * (growth - 1), 6)
    return f"with {percent:g} % more orders" if percent >= 0 else f"with {-percent:g} % fewer orders"


class _Planned:
    """A plan, with the last demand that has an answer: of that alone a page shows anything."""

    def __init__(self, plan: FleetSizes, guesses: Sequence[str] | None) -> None:
        self.guesses = guesses
        self.plan, self.model, self.goal = plan, plan.model, plan.target
        self.packers = plan.designs.packers
        self.key = plan.designs if isinstance(plan.designs, OneKey) else None
        self.noun = "fleet" if plan.designs.is_fleet else "value"
        self.yearly = plan.today.year is not None
        self.demands = [plan.today] if plan.grown is None else [plan.today, plan.grown]
        self.answered = next((sized for sized in reversed(self.demands) if sized.best and not sized.open), None)

    def answer(self) -> Answer:
        plan = self.plan
        sized = [line for sized in self.demands for line in (self._sized(sized), *self._each(sized))]
        said = sized + self._lasts() + self._strategies() + self._busiest()
        options = tuple(option for sized in self.demands for option in self._options(sized))
        return Answer(
            kind="plan" if self.key is None else "size",
            name=self.model.name,
            description=self.model.description,
            question=self._question(),
            answer=tuple(said),
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
        chargers, packers = self.plan.designs.zone is not None, self.packers is not None
        fleet = spoken(["robots", *["chargers"] * chargers, *["packers"] * packers])
        later = f"in {len(self.plan.demands) - 1} years" if self.yearly else more_orders(self.demands[-1].growth)
        grown = "" if self.plan.grown is None else f", today and {later}"
        return f"How many {fleet} does it take for {self._targets()}{grown}?"

    # Sentences

    def _in_time(self, sized: Sized) -> str:
        """Name the demand at the end of a phrase; empty where one key is sized, which is for today's alone."""
        return "" if self.key is not None else f" {self._when(sized)}"

    def _then(self, sized: Sized, sentence: str) -> str:
        """Begin a sentence with the demand it is about, `Today (60 an hour): no fleet is enough`; not of one key."""
        return capital(sentence if self.key is not None else f"{self._when(sized)}: {sentence}")

    def _when(self, sized: Sized) -> str:
        later = more_orders(sized.growth) if sized.year is None else f"in year {sized.year}"
        when = "today" if sized is self.plan.today else later
        return when if sized.rate is None else f"{when} ({numbers.number(sized.rate)} an hour)"

    def _sized(self, sized: Sized) -> str:
        """The answer for one demand."""
        if sized.open:
            return self._ended(sized)
        if sized.best is None:
            return self._none(sized)
        cost = "" if sized.best.cost is None else f", {self._money(sized.best.cost)} a year"
        reached = words.reached(self.goal.indicator, self._text(sized, sized.best))
        name = capital(self._fleet(sized.best.counts))
        designs, best = self.plan.designs, sized.best.counts
        are = "is" if not designs.is_fleet or (designs.value(best) == 1 and not any(best[1:])) else "are"
        line = f"{name} {are} the {'cheapest' if cost else 'smallest'} {self.noun} shown to be enough"
        number = "" if self.plan.beside else f": {reached}"
        line = f"{line}{self._in_time(sized)}{number}{cost}{self._days(sized.best)}.{self._worst(sized)}"
        if close := plan_cells.left(self.plan, sized, "open"):
            line += f" {capital(close)} may also be enough; {self._would_tell(sized)}."
        if edge := plan_cells.left(self.plan, sized, "edge"):
            line += f" {capital(edge)} may also be enough, within {self._zone()} of the target, where no run will tell."
        return line + self._worse(sized) + self._against(sized) + self._most(sized)

    def _days(self, shown: Shown) -> str:
        """The worst of the days of a fleet, behind its mean; empty where there are several targets."""
        said = "" if self.plan.beside else judged.days(shown.days, self.goal, self.model)
        return said and f"; {said}"

    def _would_tell(self, sized: Sized) -> str:
        """How many runs of a fleet would tell whether it is enough, where those done did not."""
        needed = [one.to_tell for one in sized.below if standing(one.verdict) == "open"]
        known = [runs for runs in needed if runs is not None]
        if not known or len(known) < len(needed):
            return "even many more runs may not tell"
        return f"some {10 * math.ceil(max(known) / 10)} runs of a {self.noun} would tell (--cap)"

    def _ended(self, sized: Sized) -> str:
        """What is known where the runs allowed ended before an answer."""
        few = [self._fleet(one.counts) for one in sized.below]
        known = f" {capital(self._fleet(sized.best.counts))} are enough." if sized.best else ""
        known += f" {capital(spoken(few))} are too few." if 0 < len(few) <= _LISTED else ""
        left = f"{len(sized.open)} of {number_of(len(sized.counts), self.noun)} remain open"
        runs = number_of(self.plan.runs, "run")
        return f"{self._then(sized, f'undecided after {runs}')}.{known} {left}."

    def _none(self, sized: Sized) -> str:
        """What the largest fleet does, where none is enough, and what more robots would not cure."""
        if sized.undecided:
            return self._undecided(sized)
        largest = self._nearest(sized)
        line = f"{self._then(sized, f'no {self.noun} is enough')}. {capital(self._fleet(largest.counts))}: "
        text = self._text(sized, largest)
        if largest.flat:
            return f"{line}{text}. {capital(largest.flat)}."
        if self.plan.beside and not self._lasting(largest) and not largest.vetoed:
            none = self._then(sized, f"no {self.noun} is shown to be enough for all targets")
            return f"{none}. This is what {self._fleet(largest.counts)} would do:"
        line += text if self._lasting(largest) else words.reached(self.goal.indicator, text) + self._days(largest)
        line += "."
        if sized.fewer:
            return line
        line += self._most(sized) + self._worse(sized)
        line += "" if sized.capped is None else f" {capped(sized.capped, self.model)}."
        if sized.trip is not None:
            return f"{line} {self._trip(sized.trip)}"
        return f"{line} {sentence(capital(busiest.are(sized.loads, _time(sized))))}" if sized.loads else line

    def _each(self, sized: Sized) -> list[str]:
        """Of several targets a line for each, of the fleet that is named."""
        if not self.plan.beside or sized.open or not (sized.best or sized.below):
            return []
        named = sized.best or self._nearest(sized)
        if self._lasting(named) or named.vetoed:
            return []
        fleet = capital(self._fleet(named.counts))
        return [
            f"{fleet}, {words.target(goal)}: {judged.number(one, goal, self.model).text}, {WORDS[standing(one)]}."
            for goal, one in zip(self.plan.targets, named.verdict.each, strict=True)
        ]

    def _targets(self) -> str:
        """All that a fleet has to meet: `at least 95 % on time, express and mean cycle time at most 10 min`."""
        return spoken([words.target(goal) for goal in self.plan.targets])

    def _undecided(self, sized: Sized) -> str:
        """What is open where the runs tell of no fleet that it is enough, nor of the largest that it is not."""
        largest = self._nearest(sized)
        verdict, name = largest.verdict, capital(self._fleet(largest.counts))
        if judged.is_perfect(verdict, self.goal):
            fleet, known = self._fleet(largest.counts), judged.perfect(verdict, self.goal)
            return f"{self._then(sized, f'no {self.noun} can be shown to be enough')}. {capital(fleet)}: {known}"
        days = number_of(verdict.n, "day")
        line = f"{self._then(sized, f'not decided after {days}')}:"
        if left := plan_cells.left(self.plan, sized, "open"):
            line += f" {left} may be enough; {self._would_tell(sized)}."
        if edge := plan_cells.left(self.plan, sized, "edge"):
            line += f" {edge} may be enough, within {self._zone()} of the target, where no run will tell."
        if self.plan.beside:
            return f"{line} This is what {self._fleet(largest.counts)} would do:"
        reached = words.reached(self.goal.indicator, self._text(sized, largest)) + self._days(largest)
        return f"{line} {name}: {reached}."

    def _nearest(self, sized: Sized) -> Shown:
        """The largest fleet that was judged; where fewer robots do better the one that comes nearest to the target."""
        lasting = [one for one in sized.below if not one.vetoed]
        if not sized.fewer or not lasting or self.plan.beside:
            return sized.below[-1]
        return max(lasting, key=lambda one: self.goal.sign * one.verdict.mean)

    def _against(self, sized: Sized) -> str:
        """That the ends of the range contradict the guess of which fleets do better."""
        if not sized.against:
            return ""
        if sized.fewer:
            return " Fewer robots usually do better, not here, so each fleet was judged by itself."
        more = "More robots usually do" if self.plan.designs.is_fleet else "More usually does"
        return f" {more} better, not here: the smallest {self.noun} is enough, the largest is not."

    def _trip(self, trip: Estimate) -> str:
        """What a task takes against the time in which it is due, where nothing is scarce."""
        due = due_within(self.model)
        scale = words.scale(TRIP, self.model, (trip.mean,))
        of = "" if due is None else f" where {scale.value(due)} are allowed"
        return f"Nothing is scarce: a trip takes {scale.value(trip.mean)}{of}, waits included; more robots do not help."

    def _worse(self, sized: Sized) -> str:
        """Larger designs that do worse than a smaller one."""
        if not sized.worse:
            return ""
        said = [self._does_worse(*one) for one in sized.worse]
        return f" More is not always better here: {spoken(said)}."

    def _does_worse(self, more: Counts, less: Counts, by: Estimate | None, goal: Target) -> str:
        if by is None:
            return f"with {self._fleet(more)} robots run flat, with {self._fleet(less)} they do not"
        scale = words.scale(goal.indicator, self.model, (by.mean,))
        of = f" in {words.in_sentence(goal.indicator)}" if self.plan.beside else ""
        return f"{self._fleet(more)} do worse than {self._fleet(less)} by {scale.value(abs(by.mean))}{of}"

    def _most(self, sized: Sized) -> str:
        """With pods, which fleet does most, where more robots do worse."""
        most = sized.most
        if most is None:
            return ""
        scale = words.scale(self.goal.indicator, self.model, (most.mean, most.at_largest))
        best = f"{number_of(most.robots, 'robot')} do most, {scale.value(most.mean)} in {RUNS} runs"
        return f" More is not always better here: {best}; {most.largest} do {scale.value(most.at_largest)}."

    def _strategies(self) -> list[str]:
        """Whether another way of dispatching makes do with less."""
        plan = self.plan
        said = []
        if plan.strategy is not None:
            own = self._own()
            said = [f"This is with {_choice(plan.strategy)}, which needs fewer than {own}."]
        elif plan.strategies:
            tried = [_choice(one) for one in plan.strategies if one.shown]
            same = [_choice(one) for one in plan.strategies if not one.shown]
            parts = [f"{spoken(tried)} need{'s' * (len(tried) == 1)} as many"] if tried else []
            parts += [f"{spoken(same)} change{'s' * (len(same) == 1)} nothing"] if same else []
            said = [f"Other strategies than {self._own()} do not help: {', '.join(parts)}."]
        return said + ([f"No runs were left to try {spoken(plan.untried)}."] if plan.untried else [])

    def _own(self) -> str:
        """The strategy of the model in words."""
        return words.named_policy(self.plan.own)

    def _busiest(self) -> list[str]:
        """What is busiest with the fleet of the answer."""
        sized = self.answered
        if sized is None or sized.best is None:
            return []
        busy = busiest.are(sized.loads, _time(sized), f"with {self._fleet(sized.best.counts)}")
        return [sentence(busy)] if busy else []

    def _promise(self) -> str:
        plan = self.plan
        judged_fleets = [fleet for one in self.demands for fleet in (one.best, *one.below) if fleet is not None]
        if judged_fleets and all(fleet.verdict.deterministic for fleet in judged_fleets):
            return "Nothing in the model is left to chance, so each number above is exact."
        sure = f"{100 * plan.confidence:g} % confidence{' for each demand' * (self.key is None)}"
        if plan.ended or self.answered is None:
            return f"Each answer above holds with {sure}."
        most = [one.most.up_to for one in self.demands if one.most is not None]
        up_to = f", up to {min(most)} robots" if most else ""
        alike = f" This takes it that more never does worse{up_to}." if all(one.ordered for one in self.demands) else ""
        alike = f"{self._covers()}{alike}"
        if self.yearly:
            alike += " What fails with less demand is taken to fail with more."
        return (
            f"With {sure}, each {self.noun} reaches {self._targets()}, and no smaller one{plan_cells.but(plan)} "
            f"is better than that by {self._zone()} or more.{alike}"
        )

    def _covers(self) -> str:
        """Of which days the runs of the fleets named are enough to know."""
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
        """Why fleets are not met whose interval holds the target, and closures that never fall into a run."""
        return [*judged.holds_the_target(options, self.goal, self._zone()), *map(sentence, rare.closed(self.model))]

    # Numbers

    def _lasting(self, shown: Shown) -> Standing | None:
        return lasts_not(shown.wrong)

    def _text(self, sized: Sized, shown: Shown) -> str:
        """The number of a fleet, or what it does instead."""
        if self._lasting(shown):
            done = shown.delivered
            made = self.model.replace({**sized.overrides, **shown.overrides})
            return instead(shown.wrong, None if done is None else done.mean, made)
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
        if self.key is not None:
            value = self.key.value(best.counts)
            what = f"robot{'s' * (value != 1)}" if self.key.is_fleet else words.in_words(self.key.of)
            return [BigNumber(value=words.level(value), what=what), *self._reached(sized, best)]
        if len(self.demands) > 1:
            return [self._tile(one, one.best) for one in self.demands if one.best is not None and not one.open]
        found = [BigNumber(value=str(best.robots), what=f"robot{'s' * (best.robots != 1)}")]
        if best.chargers:
            found.append(BigNumber(value=str(best.chargers), what=f"charger{'s' * (best.chargers != 1)}"))
        if self.packers is not None:
            packers = best.packers * self.packers.nodes
            found.append(BigNumber(value=str(packers), what=f"packer{'s' * (packers != 1)}"))
        found += self._reached(sized, best)
        return found + ([] if best.cost is None else [BigNumber(value=self._money(best.cost), what="a year")])

    def _tile(self, sized: Sized, best: Shown) -> BigNumber:
        """The fleet for one of several demands, with what it reaches and costs."""
        reached = words.reached(self.goal.indicator, self._text(sized, best))
        cost = "" if best.cost is None else f"; {self._money(best.cost)} a year"
        return BigNumber(value=self._fleet(best.counts), what=self._when(sized), note=f"{reached}{cost}")

    def _reached(self, sized: Sized, best: Shown) -> list[BigNumber]:
        first = judged.tile(self._text(sized, best), words.in_sentence(self.goal.indicator))
        return [first, *(judged.tile(number.text, words.in_sentence(number.of)) for number in self._also(best))]

    def _options(self, sized: Sized) -> list[Option]:
        """The fleets that show the answer; with the last demand also those with other strategies."""
        last = sized is self.demands[-1]
        found = []
        tried = [*([sized.best] if sized.best else []), *sized.below]
        for one in tried if self.key is None else sorted(tried, key=lambda shown: shown.counts):
            same = [item.label for item in self.plan.strategies if one.counts in item.same]
            found.append(self._option(sized, one, self._fleet(one.counts), sized.overrides, same if last else []))
        if sized.capped is not None:
            found.append(self._capped(sized))
        for strategy in self.plan.strategies if last else ():
            for one in strategy.shown:
                changes = {**self._without_better(sized), **strategy.overrides}
                found.append(self._option(sized, one, f"{self._fleet(one.counts)}, {_choice(strategy)}", changes, []))
        return found

    def _without_better(self, sized: Sized) -> dict[str, Any]:
        """The changes of a demand, without those of a better strategy."""
        better = {} if self.plan.strategy is None else self.plan.strategy.overrides
        return {key: value for key, value in sized.overrides.items() if key not in better}

    def _option(self, sized: Sized, one: Shown, name: str, changes: Mapping[str, Any], same: Sequence[str]) -> Option:
        lasting = self._lasting(one)
        fails = one.estimate is None or one.vetoed is not None
        known = lasting is None and not fails
        return Option(
            name=name,
            standing=lasting or ("fails" if fails else judged.standing_of(one.verdict, self.goal)),
            number=judged.number(one.verdict, self.goal, self.model) if known else None,
            also=tuple(self._also(one)) if known else (),
            days=judged.in_row(one.days, self.goal, self.model) if known else "",
            said="" if known else self._text(sized, one),
            runs=one.verdict.n,
            cost=one.cost,
            group=self._when(sized) if len(self.demands) > 1 else "",
            set={**changes, **one.overrides},
            same=tuple(same),
        )

    def _also(self, one: Shown) -> list[SaidNumber]:
        """The numbers of a fleet for further targets."""
        each = zip(self.plan.targets[1:], one.verdict.each[1:], strict=False)
        return [judged.number(verdict, goal, self.model) for goal, verdict in each]

    def _capped(self, sized: Sized) -> Option:
        """What a cap on the robots under way gives the largest fleet."""
        found, largest = sized.capped, sized.below[-1]
        assert found is not None
        scale = words.scale(self.goal.indicator, self.model, (found.mean,))
        return Option(
            name=f"{self._fleet(largest.counts)}, at most {found.cap} under way",
            standing="known",
            number=judged.within(self.goal.indicator, scale, (found.mean, None, None)),
            runs=found.gain.n,
            group=self._when(sized) if len(self.demands) > 1 else "",
            set={**sized.overrides, **largest.overrides, **found.overrides},
        )

    # The figure, and the design that the page shows

    def _grid(self) -> PairGrid | None:
        """Every fleet searched, by robots and chargers; of packers those of the answer, or the most."""
        searched = dict.fromkeys(counts for sized in self.demands for counts in sized.counts)
        if not searched:
            return None
        robots, chargers, *_ = (sorted(set(side)) for side in zip(*searched, strict=True))
        panels = {}
        for sized in self.demands:
            cells = plan_cells.cells(sized)
            packers = (max(sized.counts) if sized.best is None else sized.best.counts)[2:]
            panels[f"{self._when(sized)}{self._with_packers(packers)}"] = tuple(
                tuple(cells.get((first, second, *packers), "untried") for first in robots)
                for second in reversed(chargers)
            )
        down = tuple(str(number) if number else "" for number in reversed(chargers))
        how = "robots across, chargers down" if any(chargers) else "by number of robots"
        title = f"Which fleets give {self._targets()}: {how}"
        return PairGrid(title=title, across=tuple(map(str, robots)), down=down, panels=panels)

    def _intervals(self, options: Sequence[Option]) -> Rows | None:
        """Every value looked at, with its interval beside the target."""
        title = capital(words.in_sentence(self.goal.indicator))
        bars = (judged.bar(one.name, one.number, one.standing) for one in options if one.number is not None)
        return judged.figure(title, bars, self.goal.value, judged.aim(self.goal))

    def _about(self) -> Subject | None:
        sized = self.answered
        if sized is None or sized.best is None:
            return None
        made = self.model.replace({**sized.overrides, **sized.best.overrides})
        when = "" if self.key is not None else f", {self._when(sized)}"
        days = sized.best.days
        known = None if days is None else (days, self.goal)
        return judged.about(f"{self._fleet(sized.best.counts)}{when}", made, self.plan.seed, known)

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
        }

    def _sheet(self) -> tuple[Folded, ...]:
        """What stands on the one sheet beside the answer; nothing where one key is sized."""
        if self.key is not None:
            return ()
        grown = [(capital(self._when(sized)), self._in_short(sized)) for sized in self.demands[1:]]
        return plan_sheet.tables(self.plan, grown, self.guesses)

    def _in_short(self, sized: Sized) -> str:
        if sized.open or sized.undecided:
            return "not decided"
        return f"no {self.noun} is enough" if sized.best is None else self._fleet(sized.best.counts)

    # Packers, hours and years

    def _fleet(self, counts: Counts) -> str:
        """The counts of a design: `6 robots, 2 chargers and 3 packers`."""
        return plan_cells.named(self.plan, counts)

    def _counted(self, counts: Counts) -> dict[str, Any]:
        """The counts of a design as JSON has them, packers in all nodes of their station."""
        if self.key is not None:
            return {self.key.of: self.key.value(counts)}
        found = dict(zip(("robots", "chargers"), counts, strict=False))
        return found if self.packers is None else {**found, "packers": counts[2] * self.packers.nodes}

    def _with_packers(self, packers: Counts) -> str:
        return f", {number_of(packers[0] * self.packers.nodes, 'packer')}" if packers and self.packers else ""

    def _worst(self, sized: Sized) -> str:
        """The worst part of the day with the fleet of an answer, unless one is the target: `11:30 to 13:00: 97 %.`."""
        lead = "" if sized.lead is None else departures.in_time(self.model, sized.lead)
        if not sized.hours or AT in self.goal.indicator:
            return lead
        worst = self._worst_of(sized)
        return f" {worst.named}: {words.reached(ON_TIME, self._on_time(worst))}.{lead}"

    def _worst_of(self, sized: Sized) -> Hour:
        return min(sized.hours, key=lambda one: one.share.mean)

    def _on_time(self, hour: Hour) -> str:
        low, high = hour.share.interval or (None, None)
        scale = words.scale(ON_TIME, self.model, (hour.share.mean,))
        return judged.within(ON_TIME, scale, (hour.share.mean, low, high)).text

    def _hours(self) -> list[Folded]:
        """How many orders come by the hour, and how many of them are done on time."""
        sized = self.answered
        if sized is None or sized.best is None or not sized.hours:
            return []
        rows = [(one.named, numbers.number(one.orders), self._on_time(one)) for one in sized.hours]
        note = f"With {self._fleet(sized.best.counts)}, by when orders come. All intervals hold at once."
        if self.goal.indicator == ON_TIME:
            worst = replace(self.goal, measure=find(self._worst_of(sized).indicator))
            note += f' A fleet for the worst part: --target "{worst.text}".'
        return [
            Folded(title="On time by the hour", note=note, head=("time", "orders", "done on time"), rows=tuple(rows))
        ]

    def _lasts(self) -> list[str]:
        """How long the fleet for today is enough."""
        first = self.plan.today.best
        if not self.yearly or first is None or self.plan.ended:
            return []
        later = [one for one in self.plan.demands if one.best is None or one.best.counts != first.counts]
        if not later:
            return ["The fleet for today is enough in all of these years."]
        known = plan_cells.cells(later[0]).get(first.counts)
        too_small = "is too small" if known == "not met" else "is not shown to be enough"
        return [f"The fleet for today {too_small} in year {later[0].year}."]

    def _years(self) -> list[Folded]:
        """The answer year by year."""
        if not self.yearly:
            return []
        parts = [
            what
            for what, most in zip(plan_cells.WHAT, map(max, zip(*self.plan.today.counts, strict=True)), strict=False)
            if most
        ]
        priced = any(sized.best and sized.best.cost is not None for sized in self.plan.demands)
        head = ("year", "orders an hour", *(f"{what}s" for what in parts), *["a year"] * priced)
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
    """A target as JSON has it."""
    return {"indicator": goal.indicator, "sense": goal.sense, "value": goal.value}


def _choice(strategy: Strategy) -> str:
    """A strategy by its name: `hungarian`."""
    return words.named_policy(strategy.label)


def _time(sized: Sized) -> str:
    """What shares of the time are of."""
    return "of their hours" if sized.in_hours else "of the time"
