"""The answer of a study: the options that meet the target or, without a target, the best option."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from desim_warehouse._version import simulated_with
from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import Scale, capital, sentence
from desim_warehouse.answer.parts import BigNumber, Folded, Option, Rows, ShownNumber, Subject
from desim_warehouse.answer.standing import WORDS, Standing, instead, lasts_not, standing
from desim_warehouse.errors import spoken
from desim_warehouse.model.facts.costs import is_fixed
from desim_warehouse.outcome.indicators import depends_on_length, look_up
from desim_warehouse.questions import judged
from desim_warehouse.questions.sentences import UNSETTLED, apart_from, knee_of_throughput, name_of, option_of, wrong
from desim_warehouse.study.plan import StudyPlan
from desim_warehouse.study.rare import days_needed
from desim_warehouse.study.results import ResultsData
from desim_warehouse.study.statistics.judge import MOST_TO_TELL
from desim_warehouse.study.statistics.screening import main_effects
from desim_warehouse.study.target import Days, days_of

_LISTED = 6
"""Number of options up to which they are named one by one; beyond it, the rest are counted."""
_DRAWN = 40
"""Most rows of a figure."""
_RARE = 3
"""Most lines on rare events."""
_TILES, _SHOWN = 3, 4
"""Most tiles, and number of indicators that are shown by default."""
_UNNAMED = ("what-if", "size", "best", "study", "why")
"""Default names of studies, whose answers have the name of the model instead."""


def answer(study: ResultsData, indicators: Sequence[str] = ()) -> Answer:
    """Return the answer of a study, in the given `indicators` or, without any, in the usual ones."""
    if all(row.outcome.error is not None for row in study.rows):
        return _nothing(study)
    return _Studied(study, indicators).answer()


def _nothing(study: ResultsData) -> Answer:
    """Return the answer of a study without a finished run."""
    errors = [row.outcome.error for row in study.rows]
    return Answer(
        kind="study",
        name=study.plan.name,
        question="What do its options do?",
        answer=(sentence(f"No run finished: {errors[0]}") if errors else "No run has been done.",),
        runs=len(study.rows),
        confidence=None,
    )


class _Studied:
    """The designs that have runs, each group of designs with equal runs once, with their shown indicators."""

    def __init__(self, study: ResultsData, indicators: Sequence[str]) -> None:
        self.study, self.goal, self.base = study, study.target, study.base
        most = None if study.plan.indicators else _SHOWN
        shown = study.chosen(indicators) if indicators else list(study.main[:most])
        if self.goal is not None and self.goal.indicator in study.indicators:
            shown = list(dict.fromkeys([self.goal.indicator, *shown]))
        self.shown = shown
        self.scales: dict[str, Scale] = {
            name: words.scale_of(name, self.base, study.estimates(name).values()) for name in shown
        }
        if self.goal is not None:
            self.scales[self.goal.indicator] = judged.scale_of(self.goal, self.base)
        self.tried = [design for design in study.designs if study.runs(design) and design not in study.same]
        self.options = {design: self._option(design) for design in self.tried}

    def answer(self) -> Answer:
        study, plan = self.study, self.study.plan
        lines, named = self._best() if self.goal is None else self._on_target()
        lines += self._did_not_run()
        return Answer(
            kind="study",
            name=self.base.name if plan.name in _UNNAMED else plan.name,
            description=plan.description or self.base.description,
            question=self._question(),
            answer=tuple(lines),
            tiles=() if named is None else self._tiles(named),
            measures={name: words.in_sentence(name) for name in self.shown},
            options=tuple(self.options.values()),
            figure=self._figure(),
            about=None if named is None else self._about(named),
            tables=tuple(self._tables()),
            promise=self._promise(),
            notes=tuple(self._notes()),
            runs=len(study.rows),
            confidence=plan.confidence,
            made={"seed": str(plan.seed), "model": self.base.digest(), **study.versions},
            baseline=self.options[first].name if (first := self._first(study.baseline)) in self.options else None,
            target=None if self.goal is None else {"text": plan.target, "value": self.goal.value},
        )

    def _first(self, design: str) -> str:
        """Return the design that represents all designs with equal runs."""
        return self.study.same.get(design, design)

    # Options

    def _option(self, design: str) -> Option:
        study, model = self.study, self.study.models.get(design)
        verdicts = study.verdicts.get(design, ())
        lasting = lasts_not(verdicts)
        note = instead(verdicts, model) if lasting and model is not None else ""
        values = [value for name in self.shown if (value := self.number(design, name)) is not None]
        kind: Standing = lasting or ("known" if values else "fails")
        if self.goal is not None and not lasting:
            kind = standing(study.judged[design]) if design in study.judged else "fails"
        year = study.estimate(study.runs(design), "annual_cost")
        copies = [apart_from(study, other, design) for other, original in study.same.items() if original == design]
        point = next(point for point in study.points if str(point) == design)
        name, group = option_of(study, design)
        return Option(
            name=name,
            group=group,
            standing=kind,
            number=values[0] if values and not note else None,
            also=tuple(values[not note :]),
            days="" if note else self._days(design),
            instead=note,
            runs=len(study.runs(design)),
            cost=None if year is None else year.mean,
            set=dict(point.overrides),
            same=tuple(copies),
        )

    def _days(self, design: str) -> str:
        """Return the worst day of an option and the number of days that miss the target; empty without a target."""
        return "" if self.goal is None else judged.in_row(self._all_days(design), self.goal, self.base)

    def _all_days(self, design: str) -> Days | None:
        return None if self.goal is None else days_of(self.study.values(design, self.goal.indicator), self.goal)

    def number(self, design: str, indicator: str) -> ShownNumber | None:
        """Return an indicator with its interval; None if it has no value, or no meaningful one."""
        verdicts = self.study.verdicts.get(design, ())
        estimate = self.study.shown(design, indicator)
        if estimate is None or (lasts_not(verdicts) and depends_on_length(indicator)):
            return None
        aim = self.goal.value if self.goal is not None and indicator == self._aim() else None
        return judged.estimated(indicator, self.scales[indicator], estimate, aim)

    def _aim(self) -> str | None:
        """Return the indicator of the target; None without a target."""
        return None if self.goal is None else self.goal.indicator

    def _found(self, design: str, indicator: str) -> str:
        """Return an option's value for a sentence, or the text that replaces it."""
        value = None if indicator == self._aim() and self.options[design].instead else self.number(design, indicator)
        return self.options[design].instead or "no value" if value is None else value.text

    def _did_not_run(self) -> list[str]:
        """Return the sentence on designs without a finished run, with the first error."""
        errors = {design: [row.outcome.error for row in self.study.runs(design)] for design in self.tried}
        dead = {design: design_errors[0] for design, design_errors in errors.items() if None not in design_errors}
        return (
            [sentence(f"{capital(self._names(list(dead)))} did not run: {next(iter(dead.values()))}")] if dead else []
        )

    # Sentences with a target

    def _on_target(self) -> tuple[list[str], str | None]:
        """Return the sentences on the first, or cheapest, option that meets the target for each demand, and its design.

        Without such an option the design is None.
        """
        judged_ones = [design for design in self.tried if design in self.study.judged]
        if not judged_ones:
            return [f"No run has a value by which {self.study.plan.target} could be judged."], None
        groups: dict[str, list[str]] = {}
        for design in sorted(judged_ones, key=lambda name: self.options[name].cost or 0.0):
            groups.setdefault(self.options[design].group, []).append(design)
        named_lines = [self._met_first(group, designs) for group, designs in groups.items()]
        lines = [line for line, _ in named_lines]
        named = [design for _, design in named_lines if design is not None]
        few = dict.fromkeys(line for design in named for line in self._few(design))
        return [*lines, *self._count(judged_ones), *few], named[-1] if named else None

    def _met_first(self, group: str, designs: list[str]) -> tuple[str, str | None]:
        goal = self.goal
        assert goal is not None
        when, aim = f"{group}: " if group else "", words.target(goal)
        enough = [design for design in designs if self.options[design].standing == "met"]
        if enough:
            option = self.options[enough[0]]
            several = option.name[:1].isdigit() and not option.name.startswith("1 ") and ", " not in option.name
            are = "are" if several else "is"
            which = "only" if len(enough) == 1 else "cheapest" if option.cost is not None else "first"
            year = f", {self._year(enough[0])} a year" if option.cost is not None else ""
            comma = "," * (", " in option.name)
            text = f"{when}{option.name}{comma} {are} the {which} option shown to give {aim}: "
            return capital(f"{text}{self._found(enough[0], goal.indicator)}{year}."), enough[0]
        lasting = [design for design in designs if self.options[design].number is not None]
        near = max(lasting or designs, key=lambda design: goal.sign * self.study.judged[design].mean)
        best = f"{self.options[near].name}, {self._found(near, goal.indicator)}"
        return capital(f"{when}no option is shown to give {aim}. Best so far: {best}."), None

    def _few(self, design: str) -> list[str]:
        """Return the sentence on days too few to promise that a design meets the target; none if there are enough."""
        verdict, model = self.study.judged[design], self.study.models.get(design)
        least = 0 if model is None or verdict.deterministic else days_needed(model).least
        if verdict.n >= least:
            return []
        return [f"{verdict.n} days cover only days as rare as {judged.rarest(verdict.n)}: rely on it after {least}."]

    def _count(self, designs: list[str]) -> list[str]:
        """Return the number of options of each standing, and how many runs would probably decide the open ones."""
        if len(designs) == 1 and self.options[designs[0]].standing != "open":
            return []
        met = Counter(self.options[design].standing for design in designs)
        missed = "it" if met["met"] else "the target"
        forms = {"met": "{} meet{} the target", "not met": f"{{}} miss{{}} {missed}", "open": "{} need{} more runs"}
        parts = []
        for kind, many in ((kind, met[kind]) for kind in WORDS if met[kind]):
            form = forms.get(kind, f"{{}} {WORDS[kind]}")
            end = "" if many > 1 else "es" if kind == "not met" else "s"
            parts.append(form.format(many, end))
        if len(parts) == 1:
            every = parts[0].removeprefix(f"{len(designs)} ")
            whole = {1: "The option", 2: "Both options"}.get(len(designs), f"All {len(designs):,} options")
            return [f"{whole} {every}.{self._runs_to_tell()}"]
        return [f"Of {len(designs):,} options, {spoken(parts)}.{self._runs_to_tell()}"]

    def _runs_to_tell(self) -> str:
        needed = list(self.study.runs_to_tell.values())
        counts = [runs for runs in needed if runs is not None]
        of_each, them = ("", "that option") if len(needed) == 1 else (" of each", "them")
        if not needed:
            return ""
        if not counts:
            return f" Even {numbers.number(MOST_TO_TELL)} runs{of_each} might not decide {them}."
        beyond = len(needed) - len(counts)
        close = f"; {beyond} may need more than {numbers.number(MOST_TO_TELL)}" if beyond else ""
        return f" About {numbers.number(max(counts))} runs{of_each} would probably decide {them}{close}."

    # Sentences without a target

    def _best(self) -> tuple[list[str], str | None]:
        """Return the sentences on the option with the best mean and the options as good, and its design.

        The indicator is the first that varies and for which more or less is better.
        """
        study = self.study
        if len(self.tried) == 1:
            return self._alone(self.tried[0]), self.tried[0]
        better = {name: measure.better for name in study.moving if (measure := look_up(name)) and measure.better}
        if not better:
            same = spoken([words.in_sentence(name) for name in study.main])
            failed = any(row.outcome.error for row in study.rows)
            nothing = "The options that ran are alike in" if failed else "Nothing that was varied changes"
            return [f"{nothing} {same}."] if same else [], None
        indicator, sense = next((name, better[name]) for name in better)
        lasting = [design for design in self.tried if not self.options[design].instead] or self.tried
        means = {
            design: estimate.mean for design in lasting if (estimate := study.shown(design, indicator)) is not None
        }
        best = (max if sense == "more" else min)(means, key=lambda design: means[design])
        comparison = study.compare_finished(indicator, best)
        rows = comparison.differences if comparison else ()
        alike = [str(row.design) for row in rows if str(row.design) in means and not row.differs]
        extreme = "largest" if sense == "more" else "smallest"
        name = words.in_sentence(indicator)
        if len(means) > 1 and len(alike) == len(means) - 1:
            return [f"In {name}, no option is shown to be better than another.", *self._wrong(lasting=True)], None
        most = f"{capital(name)} is {extreme}, {self._found(best, indicator)}, with {self.options[best].name}."
        lines = [most] + ([f"Not shown to be worse: {self._names(alike)}."] if alike else []) + self._costs(best)
        return [*lines, *knee_of_throughput(study), *self._wrong(lasting=True)], best

    def _alone(self, design: str) -> list[str]:
        lines = [sentence(verdict.text) for verdict in self.study.verdicts.get(design, ())]
        shown = [value for name in self.shown[:_TILES] if (value := self.number(design, name)) is not None]
        return lines + [f"{words.indicator_name(value.of)}: {value.text}." for value in shown] + self._costs(design)

    def _costs(self, design: str) -> list[str]:
        if self.options[design].cost is None or "annual_cost" in self.shown:
            return []
        return [f"A year with {self.options[design].name} costs {self._year(design)}."]

    def _year(self, design: str) -> str:
        """Return the annual cost, without an interval if all prices are fixed."""
        estimate = self.study.estimate(self.study.runs(design), "annual_cost")
        assert estimate is not None
        scale = words.scale("annual_cost", self.base)
        return scale.value(estimate.mean) if is_fixed(self.base) else scale.estimate(estimate)

    def _names(self, designs: list[str]) -> str:
        """Return the names of options; of many, the first ones and the number of the rest."""
        names = [self.options[design].name for design in designs if design in self.options]
        return spoken(names if len(names) <= _LISTED + 1 else [*names[:_LISTED], f"{len(names) - _LISTED} more"])

    def _question(self) -> str:
        """Return the question, with the factors that vary, and the target or the indicators."""
        study = self.study
        keys = [key for key in study.varied or study.factors if self.goal is None or not study.is_demand(key)]
        robots = [self._robots() for key in keys if key == "fleet.size" and len(study.levels(key)) > 1]
        names = [words.in_words(key) for key in keys if not (robots and key == "fleet.size")]
        others = spoken(names) if names else ""
        if self.goal is None:
            main = spoken([words.in_sentence(name) for name in study.main[:3]])
            if not keys:
                return f"What does the model achieve in {main}?"
            do = "do" if robots or len(keys) > 1 else "does"
            return f"What {do} {spoken([*robots, *names])} change in {main}?"
        aim = words.target(self.goal)
        if robots:
            return f"Which of {robots[0]}{f', with which {others},' if others else ''} give {aim}?"
        return f"Which {others} give{'s' * (len(keys) == 1)} {aim}?" if others else f"Does the model give {aim}?"

    def _robots(self) -> str:
        sizes = self.study.levels("fleet.size")
        return f"{words.level(sizes[0])} to {words.level(sizes[-1])} robots"

    # Numbers and tables

    def _tiles(self, design: str) -> tuple[BigNumber, ...]:
        shown = [value for name in self.shown[:_TILES] if (value := self.number(design, name)) is not None]
        tiles = [judged.tile(value.text, words.in_sentence(value.of)) for value in shown]
        year = [judged.tile(self._year(design), "cost a year")] if self.options[design].cost is not None else []
        return (*tiles, *year) if not self.options[design].instead else ()

    def _about(self, design: str) -> Subject | None:
        model = self.study.models.get(design)
        if model is None:
            return None
        name, seed, days = name_of(self.study, design), self.study.plan.seed, self._all_days(design)
        return judged.about(name, model, seed, None if self.goal is None or days is None else (days, self.goal))

    def _figure(self) -> Rows | None:
        """Return the figure of the target's indicator, or of the first that differs, for the options that have it."""
        indicator = self.goal.indicator if self.goal is not None else next(iter(self.study.moving), None)
        shown = [
            (option, number) for option in self.options.values() for number in option.numbers if number.of == indicator
        ]
        if indicator is None or len(shown) < 2 or len(shown) > _DRAWN:  # noqa: PLR2004 - one row compares nothing
            return None
        bars = [
            judged.bar(", ".join(filter(None, (option.group, option.name))), number, option.standing)
            for option, number in shown
        ]
        goal = self.goal
        line = goal.value if goal else None
        aim = judged.aim(goal) if goal else ""
        return Rows(title=capital(words.in_sentence(indicator)), at=line, at_words=aim, rows=tuple(bars))

    def _tables(self) -> Iterator[Folded]:
        effects = self._effects()
        if effects is not None:
            yield effects
        study = self.study
        failed = [row for row in study.rows if row.outcome.error is not None]
        rows = [(name_of(study, str(row.point)), str(row.replication), str(row.outcome.error)) for row in failed]
        if rows:
            yield Folded(title="Runs that failed", head=("option", "run", "error"), rows=tuple(rows[:_DRAWN]))
        facts = [("options", f"{len(study.designs)}, {study.plan.rule}"), ("runs of each", _replications(study.plan))]
        facts += [("warm-up", _warm_up(study))]
        facts += [(words.factor_name(key), ", ".join(map(words.level, study.levels(key)))) for key in study.factors]
        yield Folded(title="The study", head=("", ""), rows=tuple(facts))

    def _effects(self) -> Folded | None:
        """Return the table of each factor's effect: its largest minus its smallest mean; None for a single factor."""
        study, varied = self.study, self.study.varied
        if len(varied) < 2 or study.plan.rule == "paired":  # noqa: PLR2004
            return None  # one factor, or factors varied together: their effects cannot be told apart
        rows: list[tuple[str, ...]] = []
        for indicator in study.moving:
            name, effects = words.indicator_name(indicator), main_effects(study.table, varied, indicator).factors
            scale = words.scale(indicator, study.base, [effect.swing for effect in effects])
            rows += [(name, words.factor_name(effect.factor), scale.value(effect.swing)) for effect in effects]
        head = ("indicator", "factor", "largest − smallest mean")
        return Folded(title="Which factor matters", head=head, rows=tuple(rows))

    def _promise(self) -> str:
        study, sure = self.study, self.study.plan.confidence
        if study.deterministic:
            return judged.promise("", sure, exact=True)
        if max(len(study.runs(design)) for design in self.tried) == 1:
            return "One run of a random model says little; more runs give intervals."
        if self.goal is not None:
            return judged.promise("verdicts", sure, exact=False)
        return judged.each(sure)

    def _wrong(self, *, lasting: bool = False) -> list[str]:
        return [sentence(line) for line in wrong(self.study, lasting=lasting)] if len(self.tried) > 1 else []

    def _notes(self) -> list[str]:
        study = self.study
        lines = self._wrong() if self.goal is not None else []
        if study.warm_ups:
            unit = self.base.units.time
            starts = [
                f"{words.in_unit(time, unit)} with {name_of(study, design)}" for design, time in study.warm_ups.items()
            ]
            lines.append(f"Counting began at {'; '.join(starts[:_LISTED])}.")
        lines += [f"{name_of(study, design)}: {UNSETTLED}." for design in study.unsettled]
        lines += self._left_blank()
        made = simulated_with(study.version)
        return [*lines, *map(sentence, study.rare[:_RARE]), *([f"{capital(made)}."] if made else [])]

    def _left_blank(self) -> list[str]:
        """Return the sentence on indicators that are left blank for options that cannot last, if any are."""
        lasting = [option for option in self.options.values() if option.standing in {"overloaded", "drained"}]
        blank = [words.in_sentence(name) for name in self.shown if depends_on_length(name)]
        if not lasting or not blank:
            return []
        cannot = " or ".join(dict.fromkeys(WORDS[option.standing] for option in lasting))
        why = "it depends" if len(blank) == 1 else "they depend"
        return [f"Left blank where an option {cannot}, as {why} on the length of the run: {'; '.join(blank)}."]


def _replications(plan: StudyPlan) -> str:
    """Return the number of replications of each design in words."""
    rule = plan.replications
    if isinstance(rule, int):
        return str(rule)
    if isinstance(rule, tuple):
        many = f"{min(rule)} to {max(rule)}" if min(rule) < max(rule) else f"{max(rule)}"
        return f"{many} of each option, as the procedure asked for"
    return (
        f"{rule.minimum} to {rule.cap} of each option, until the half-width of {rule.indicator} is at most "
        f"{numbers.number(100 * rule.half_width)} % of its mean"
    )


def _warm_up(study: ResultsData) -> str:
    """Return the warm-up that is left out, in words: one for all designs, or one found for each."""
    times, unit = study.warm_ups.values(), study.base.units.time
    if not times:
        return f"{numbers.duration(study.base.run.warm_up, unit)}, not counted"
    shortest, longest = (numbers.duration(time, unit) for time in (min(times), max(times)))
    return f"{shortest} to {longest}, found for each option, not counted"
