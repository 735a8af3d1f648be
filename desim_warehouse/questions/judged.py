"""Parts of answers: a number with its interval, a tile, a figure, and the design that the page draws."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from desim_warehouse.answer import words
from desim_warehouse.answer.numbers import PERCENT, Mean, Scale, capital
from desim_warehouse.answer.parts import Bar, BigNumber, Option, Rows, ShownDay, ShownNumber, Subject
from desim_warehouse.answer.standing import Standing, standing
from desim_warehouse.model import Model
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.plan import run_seed
from desim_warehouse.study.rare import beyond
from desim_warehouse.study.statistics.judge import DesignVerdict
from desim_warehouse.study.statistics.limits import one_in
from desim_warehouse.study.target import Days


def number(verdict: DesignVerdict[Any], target: Target, model: Model) -> ShownNumber:
    """Return the mean of a judged design, with the bounds of its verdict."""
    scale = scale_of(target, model)
    if verdict.agrees:
        return ShownNumber(of=target.indicator, mean=verdict.mean, text=scale.agreeing(verdict.mean, verdict.n))
    return within(target.indicator, scale, (verdict.mean, verdict.low, verdict.high), target.value)


def estimated(indicator: str, scale: Scale, estimate: Mean, aim: float | None = None) -> ShownNumber:
    """Return a mean with its interval; without one, it says whether random runs agree."""
    if estimate.interval is None and estimate.n > 1 and not estimate.deterministic:
        return ShownNumber(of=indicator, mean=estimate.mean, text=scale.agreeing(estimate.mean, estimate.n))
    return within(indicator, scale, (estimate.mean, *(estimate.interval or (None, None))), aim)


def scale_of(target: Target, model: Model) -> Scale:
    """Return the scale of all numbers beside a target: times have the unit in which the target is written."""
    return words.scale(target.indicator, model, (target.value,))


def within(
    indicator: str, scale: Scale, mean_and_ends: tuple[float, float | None, float | None], aim: float | None = None
) -> ShownNumber:
    """Return a mean with the ends of its interval; without an interval if it is missing or has no width."""
    mean, low, high = mean_and_ends
    has_interval = low is not None and high is not None and not math.isnan(low) and low < high
    if not has_interval or low is None or high is None:
        return ShownNumber(of=indicator, mean=mean, text=scale.value(mean))
    return ShownNumber(of=indicator, mean=mean, low=low, high=high, text=scale.within(mean, low, high, aim))


def bar(label: str, value: ShownNumber, standing: str = "") -> Bar:
    """Return the row of a figure for a number."""
    return Bar(label=label, mean=value.mean, low=value.low, high=value.high, text=value.text, standing=standing)


def figure(title: str, bars: Iterable[Bar], value: float, at_words: str) -> Rows | None:
    """Return a figure of rows, with a line at `value`; None if there are no rows."""
    rows = tuple(bars)
    return Rows(title=title, at=value, at_words=at_words, rows=rows) if rows else None


def aim(goal: Target) -> str:
    """Return the label of a target's line in a figure: `target 95 %`."""
    return f"target {words.amount(goal.indicator, goal.value, goal.unit)}"


_ONE_IN = {2: "one in two", 5: "one in five", 10: "one in ten", 20: "one in twenty", 50: "one in fifty"}


def rarest(days: int) -> str:
    """Return the frequency of the rarest days that a number of days covers: `one in ten`."""
    return _ONE_IN.get(one_in(days), f"one in {one_in(days)}")


def covers(least: int, models: Iterable[Model]) -> str:
    """Return the sentences on how rare the days are that `least` days cover, and which events of models are rarer."""
    text = f"This covers days as rare as {rarest(least)}."
    more: dict[str, int] = {}
    for model in models:
        more |= beyond(model, least)
    for what, needed in more.items():
        how = f"are rarer and not covered (--first {needed})" if needed else "may be rarer"
        text += f" {capital(what)} {how}."
    return text


def is_perfect(verdict: DesignVerdict[Any], goal: Target) -> bool:
    """Return whether a random design had 100 % on every day, which no number of days can prove."""
    return goal.measure.is_share and goal.value == 1 and verdict.mean == 1 and not verdict.deterministic


def standing_of(verdict: DesignVerdict[Any], goal: Target) -> Standing:
    """Return the standing of a design; `edge` if every day is perfect, as no number of days proves 100 %."""
    return "edge" if is_perfect(verdict, goal) else standing(verdict)


def perfect(verdict: DesignVerdict[Any], goal: Target) -> str:
    """Return the words on the share that n days without a miss prove, as no number of days proves 100 %."""
    least = PERCENT.value(verdict.low or 0.0)
    return (
        f"{words.amount(goal.indicator, 1.0, goal.unit)} on every one of {verdict.n} days, which shows at least "
        f"{least}. No number of days shows 100 %: ask for 99 or 99.5 %."
    )


def days(shown: Days | None, goal: Target, model: Model) -> str:
    """Return the sentence on the days behind a mean; empty for a single day, and if all days are alike.

    Example: `The worst of 40 days had 35 %; 4 were below 95 %.`
    """
    if shown is None:
        return ""
    aim, beyond = words.amount(goal.indicator, goal.value, goal.unit), "below" if goal.sign > 0 else "above"
    missed = f"{shown.missed or 'none'} {'was' if shown.missed <= 1 else 'were'} {beyond} {aim}"
    return f"The worst of {shown.days} days had {_worst(shown, goal, model)}; {missed}."


def in_row(shown: Days | None, goal: Target, model: Model) -> str:
    """Return the worst day and the number of days that missed the target, for a table: `35 %, 4`."""
    if shown is None:
        return ""
    return f"{_worst(shown, goal, model)}, {shown.missed or 'none'}"


def _worst(shown: Days, goal: Target, model: Model) -> str:
    return scale_of(goal, model).value(shown.worst).replace(".0 %", " %")


def holds_the_target(options: Iterable[Option], goal: Target, zone: str) -> list[str]:
    """Explain why options are not met although their interval holds the target: none of it is better by the zone."""
    names = [
        option.name
        for option in options
        if option.standing == "not met" and (value := option.number) is not None and _holds(value, goal)
    ]
    if not names:
        return []
    aim = words.amount(goal.indicator, goal.value, goal.unit)
    why = f"The mean misses {aim}, and the interval rules out anything better by {zone} (--zone)"
    return [f"Not met, although the interval includes {aim}: {'; '.join(names)}. {why}."]


def _holds(value: ShownNumber, goal: Target) -> bool:
    """Return whether a mean misses a target that its interval includes; of several targets it may meet this one."""
    misses = goal.sign * (value.mean - goal.value) < 0
    return misses and value.low is not None and value.high is not None and value.low <= goal.value <= value.high


def promise(what: str, confidence: float, *, exact: bool) -> str:
    """Return the statement on the joint confidence of an answer, or that each number is exact."""
    if exact:
        return "Nothing in this model is random: one run of each option is exact."
    return f"All {what} hold together with {100 * confidence:g} % confidence."


def each(confidence: float) -> str:
    """Return the statement of confidence of an answer whose intervals hold individually, not jointly."""
    return f"Each interval holds with {100 * confidence:g} % confidence."


def tile(text: str, what: str) -> BigNumber:
    """Return a number as a tile, with its interval as the note."""
    value, _, ends = text.partition(" (")
    return BigNumber(value=value, what=what, note=ends.removesuffix(")"))


def about(name: str, model: Model, seed: int, days: tuple[Days, Target] | None = None) -> Subject:
    """Return the runs of a design that the page draws: its median and its worst day, or without days its first run.

    Args:
        name: the design in words.
        model: the design as simulated.
        seed: the seed of the study.
        days: the simulated days, and the target by which they are sorted.
    """
    if days is None:
        return Subject(name=name, model=model.content(), seed=run_seed(seed, 0))
    all_days, goal = days

    def day(which: str, value: float, run: int) -> ShownDay:
        reached = words.reached(goal.indicator, scale_of(goal, model).value(value))
        return ShownDay(words=f"the {which} of {all_days.days} days, {reached}", seed=run_seed(seed, run))

    median = day("median", all_days.median, all_days.median_run)
    worst = day("worst", all_days.worst, all_days.worst_run)
    return Subject(name=name, model=model.content(), seed=median.seed, day=median.words, worst=worst)
