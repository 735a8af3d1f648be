"""What a study asks, and what it answers in a sentence or two: which designs meet its target, or which is best."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of, spoken
from desim_warehouse.outcome.indicators import look_up
from desim_warehouse.outcome.money import is_fixed
from desim_warehouse.outcome.verdicts import is_no_answer
from desim_warehouse.report.text import numbers, sentences, standing, words
from desim_warehouse.study.statistics import MOST_TO_TELL
from desim_warehouse.study.table import is_numeric

if TYPE_CHECKING:
    from desim_warehouse.report.text.standing import Standing
    from desim_warehouse.study.results import Results

_LISTED = 6
"""Designs and levels that are named one by one; of more, how many there are."""
_LONG = 80
"""Letters of levels that are named in a question."""


def question(study: Results) -> str:
    """What was varied, and what for."""
    varied = [_factor(study, key) for key in study.varied or study.factors]
    if study.target is not None:
        aim = words.target(study.target)
        return f"What gives {aim}: {spoken(varied)}?" if varied else f"Does the model as it is give {aim}?"
    main = spoken([words.in_sentence(name) for name in study.main[:3]])
    if not varied:
        return f"What does the model as it is achieve in {main}?"
    one = len(varied) == 1 and not varied[0].endswith(" robots")
    return f"What {'does' if one else 'do'} {spoken(varied)} change in {main}?"


def _factor(study: Results, key: str) -> str:
    """A factor with its levels: `6 to 14 robots`, `battery.threshold (2, 3.5, 5)`."""
    found = study.levels(key)
    first, last = words.level(found[0]), words.level(found[-1])
    if key == "fleet.size" and len(found) > 1:
        return f"{first} to {last} robots"
    name = words.in_words(key)
    listed = ", ".join(map(words.level, found))
    if len(found) <= _LISTED and len(listed) <= _LONG:
        return f"{name} ({listed})"
    return f"{name} ({first} to {last})" if is_numeric(found) else f"{name} ({len(found)} cases)"


def answer(study: Results) -> tuple[list[str], str | None]:
    """The answer in sentences, and the design that it names; None where no run has a value to judge by."""
    lines, named = _best(study) if study.target is None else _on_target(study)
    return lines + ([] if named is None else cost(study, named)), named


def cost(study: Results, design: str) -> list[str]:
    """What a year with a design costs, if the model has prices."""
    found = [study.estimate(study.runs(design), name) for name in ("annual_cost", "cost_per_task")]
    scale = words.scale("annual_cost", study.base)
    year, task = (one and scale.estimate(one) for one in found)
    if found[0] is None or year is None:
        return []
    if cost_is_fixed(study):
        year = scale.value(found[0].mean)
    return [f"A year with {_name(study, design)} costs {year}" + (f", a task {task}." if task else ".")]


def cost_is_fixed(study: Results) -> bool:
    """Whether nothing in the cost of a year depends on a run."""
    return is_fixed(study.base.prices)


def _on_target(study: Results) -> tuple[list[str], str | None]:
    """For each demand the first design that meets the target, the cheapest where there are prices."""
    if not study.judged:
        return [f"No run has a value that {study.plan.target} could be judged by."], None
    parts: dict[str, list[str]] = {}
    judged = [design for design in study.judged if design not in study.same]
    for design in _cheapest_first(study, judged):
        parts.setdefault(_name(study, design, demand=True), []).append(design)
    found = [_met_first(study, demand, designs) for demand, designs in parts.items()]
    met = Counter(_standing(study, design) for design in judged)
    meet = f"{met['met'] or 'none'} meet{'s' * (met['met'] < 2)}"  # noqa: PLR2004 - the singular
    count = f"Of {number_of(len(judged), 'design')} {meet} the target"
    count += f", {met['not met']} do{'es' * (met['not met'] == 1)} not" if met["not met"] else ""
    for cannot in ("overloaded", "drained"):
        count += f", {met[cannot]} {standing.WORDS[cannot]}" if met[cannot] else ""
    count += f", {met['open']} need{'s' * (met['open'] == 1)} more runs" if met["open"] else ""
    return [*(line for line, _ in found), f"{count}.{_runs_to_tell(study)}"], found[-1][1]


def _runs_to_tell(study: Results) -> str:
    """How many runs would tell of the designs that need more."""
    needed = list(study.runs_to_tell.values())
    if not needed:
        return ""
    known = [runs for runs in needed if runs is not None]
    many = f"{numbers.number(MOST_TO_TELL)} runs"
    if not known:
        return f" Even {many} of {'it' if len(needed) == 1 else 'each'} might not tell."
    enough = f" About {numbers.number(max(known))} runs of {'it' if len(needed) == 1 else 'each'} would probably tell"
    beyond = len(needed) - len(known)
    if not beyond:
        return f"{enough}."
    return f"{enough}; {beyond} {'is' if beyond == 1 else 'are'} so close that even {many} might not."


def _met_first(study: Results, demand: str, designs: list[str]) -> tuple[str, str]:
    """The answer for one demand, and the design that it names."""
    goal, judged = study.target, study.judged
    assert goal is not None
    when, aim = f"{demand}: " if demand else "", words.target(goal)
    enough = [design for design in designs if judged[design].verdict == "meets"]
    if not enough:
        near = max(designs, key=lambda design: goal.sign * judged[design].mean)
        none = f"{when}no design" if when else "No design"
        return f"{none} was shown to give {aim}; with {_found(study, near, goal.indicator)}.", near
    how = "" if len(enough) == 1 else " most cheaply" if _priced(study) else " first"
    return sentences.capital(f"{when}{aim} is reached{how} with {_found(study, enough[0], goal.indicator)}."), enough[0]


def on_target(study: Results) -> list[str]:
    """Every design by whether it meets the target."""
    by: dict[Standing, list[str]] = {}
    for design in (one for one in study.judged if one not in study.same):
        by.setdefault(_standing(study, design), []).append(sentences.name_of(study, design))
    kinds = [kind for kind in standing.WORDS if kind in by]
    return [f"{sentences.capital(standing.WORDS[kind])}: {_cut(by[kind])}." for kind in kinds]


def _standing(study: Results, design: str) -> Standing:
    return standing.standing(study.judged[design], study.verdicts.get(design, ()))


def _best(study: Results) -> tuple[list[str], str | None]:
    """The design with the best mean of the first indicator of which less or more is better, and those as good."""
    if len(study.designs) == 1:
        wrong = [sentences.sentence(one.text) for one in study.verdicts.get(study.baseline, ())]
        said = [name for name in study.main[:3] if not is_no_answer(name, study.verdicts.get(study.baseline, ()))]
        main = [f"{words.indicator_name(name)}: {_value(study, study.baseline, name)}." for name in said]
        return wrong + main, study.baseline
    better = {name: known.better for name in study.moving if (known := look_up(name)) and known.better}
    if not better:
        same = spoken([words.in_sentence(name) for name in study.main])
        return [f"Nothing that was varied changes {same}."] if same else [], study.baseline
    indicator, sense = next(iter(better.items()))
    found = {design: study.estimate(study.runs(design), indicator) for design in study.designs}
    means = {design: one.mean for design, one in found.items() if one is not None}
    best = (max if sense == "more" else min)(means, key=lambda design: means[design])
    comparison = study.compare_finished(indicator, best)
    alike = [str(row.design) for row in comparison.differences if not row.differs] if comparison else []
    if len(means) > 1 and len(alike) == len(means) - 1:
        name = words.in_sentence(indicator)
        return [
            f"No design is shown to be better in {name} than another.",
            f"The {'largest' if sense == 'more' else 'smallest'} mean may be chance: {_found(study, best, indicator)}.",
        ], best
    extreme = "largest" if sense == "more" else "smallest"
    lines = [f"{words.indicator_name(indicator)} is {extreme} with {_found(study, best, indicator)}."]
    return lines + ([f"Not shown to be worse: {_names(study, alike)}."] if alike else []), best


def _found(study: Results, design: str, indicator: str) -> str:
    """A design with its value: `8 robots: 97 % (96 to 98)`, and what is wrong with it."""
    wrong = study.verdicts.get(design, ())
    if is_no_answer(indicator, wrong):
        done = study.estimate(study.runs(design), "throughput_per_hour")
        said = standing.instead(wrong, None if done is None else done.mean, study.models[design])
        return f"{_name(study, design)}: {said}"
    return f"{_name(study, design)}: {_value(study, design, indicator)}{''.join(f', but {one.text}' for one in wrong)}"


def _value(study: Results, design: str, indicator: str) -> str:
    """The mean of an indicator at a design, with its interval."""
    estimate = study.shown(design, indicator)
    assert estimate is not None
    scale = words.scale(indicator, study.base, (estimate.mean,))
    return scale.estimate(estimate, sentences.aim_of(study, indicator))


def _name(study: Results, design: str, *, demand: bool = False) -> str:
    """What is decided in a design, or else the demand that it is for."""
    levels = sentences.levels_of(study, design)
    asked = [key for key in levels if study.is_demand(key)]
    if study.target is None or len(asked) == len(levels):
        asked = []
    found = {key: level for key, level in levels.items() if (key in asked) == demand}
    return words.design_spoken(found) if found or not (levels or demand) else ""


def _names(study: Results, designs: list[str]) -> str:
    return _cut([_name(study, design) for design in designs])


def _cut(names: list[str]) -> str:
    """Names, of many the first."""
    shown = names if len(names) <= _LISTED + 1 else names[:_LISTED]
    more = len(names) - len(shown)
    return "; ".join([*shown, *([f"and {more} more"] if more else [])])


def _priced(study: Results) -> bool:
    return "annual_cost" in study.indicators


def _cheapest_first(study: Results, designs: list[str]) -> list[str]:
    """By cost where there are prices, else in the order of the study."""
    if not _priced(study):
        return designs
    found = {design: study.estimate(study.runs(design), "annual_cost") for design in designs}
    return sorted(designs, key=lambda design: one.mean if (one := found[design]) else float("inf"))
