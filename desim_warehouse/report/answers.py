"""What a study asks, and what it answers in a sentence or two: which designs meet its target, or which is best."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.errors import spoken
from desim_warehouse.indicators import look_up
from desim_warehouse.report import sentences, words
from desim_warehouse.study.table import is_numeric

if TYPE_CHECKING:
    from desim_warehouse.study.results import Results

_LISTED = 6
"""Designs and levels that are named one by one; of more it is said how many there are."""


def question(study: Results) -> str:
    """What was varied, and what for."""
    varied = spoken([_factor(study, key) for key in study.varied or study.factors]) or "the model as it is"
    if study.target is not None:
        return f"What meets {words.target(study.target)}: {varied}?"
    return f"What do {varied} change in {spoken([words.in_sentence(name) for name in study.main[:3]])}?"


def _factor(study: Results, key: str) -> str:
    """A factor with its levels: `6 to 14 robots`, `battery.threshold (2, 3.5, 5)`."""
    found = study.levels(key)
    first, last = words.level(found[0]), words.level(found[-1])
    if key == "fleet.size" and len(found) > 1:
        return f"{first} to {last} robots"
    if len(found) <= _LISTED:
        return f"{key} ({', '.join(map(words.level, found))})"
    return f"{key} ({first} to {last})" if is_numeric(found) else f"{key} ({len(found)} values)"


def answer(study: Results) -> tuple[list[str], str | None]:
    """The answer in sentences, and the design that it names; None where no run has a value to judge by."""
    lines, named = _best(study) if study.target is None else _on_target(study)
    return lines + ([] if named is None else cost(study, named)), named


def cost(study: Results, design: str) -> list[str]:
    """What a year with a design costs, if the model has prices."""
    found = [study.estimate(study.runs(design), name) for name in ("annual_cost", "cost_per_task")]
    year, task = (one and words.interval_text("annual_cost", one) for one in found)
    if year is None:
        return []
    return [f"A year with {_name(study, design)} costs {year}" + (f", a task {task}." if task else ".")]


def _on_target(study: Results) -> tuple[list[str], str | None]:
    """The first design that meets the target, the cheapest where there are prices, and which others do."""
    goal, judged = study.target, study.judged
    assert goal is not None
    if not judged:
        return [f"No run has a value of {goal.indicator}."], None
    by: dict[str, list[str]] = {"meets": [], "undecided": [], "fails": []}
    for design in _cheapest_first(study, list(judged)):
        by[judged[design].verdict].append(design)
    if not by["meets"]:
        near = max(judged, key=lambda design: goal.sign * judged[design].mean)
        lines = [f"No design was shown to meet {words.target(goal)}; with {_found(study, near, goal.indicator)}."]
    else:
        near, *others = by["meets"]
        how = " most cheaply" if others and _priced(study) else " first" if others else ""
        lines = [f"{words.target(goal)} is met{how} with {_found(study, near, goal.indicator)}."]
        lines += [f"Met with {_names(study, others)}, too."] if others else []
    lines += [f"Too close to tell: {_names(study, by['undecided'])}."] if by["undecided"] else []
    lines += [f"Not met with {_names(study, by['fails'])}."] if by["fails"] and by["meets"] else []
    return lines, near


def _best(study: Results) -> tuple[list[str], str | None]:
    """The design with the best mean of the first indicator of which less or more is better, and those as good."""
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
        return [f"No design is shown to be better in {name} than another; with {_found(study, best, indicator)}."], best
    extreme = "largest" if sense == "more" else "smallest"
    lines = [f"{words.indicator_name(indicator)} is {extreme} with {_found(study, best, indicator)}."]
    return lines + ([f"Not told from it: {_names(study, alike)}."] if alike else []), best


def _found(study: Results, design: str, indicator: str) -> str:
    """A design with its value: `8 robots: 97 % (96 to 98)`, and what is wrong with it."""
    estimate = study.estimate(study.runs(design), indicator)
    assert estimate is not None
    unit = words.unit(words.indicator_kind(indicator), study.base.units)
    wrong = [f", but {one.text}" for one in study.verdicts.get(design, ())]
    return f"{_name(study, design)}: {words.interval_text(indicator, estimate, unit)}{''.join(wrong)}"


def _name(study: Results, design: str) -> str:
    return words.design_spoken(sentences.levels_of(study, design))


def _names(study: Results, designs: list[str]) -> str:
    shown = designs if len(designs) <= _LISTED + 1 else designs[:_LISTED]
    more = len(designs) - len(shown)
    return "; ".join([*(_name(study, design) for design in shown), *([f"and {more} more"] if more else [])])


def _priced(study: Results) -> bool:
    return "annual_cost" in study.indicators


def _cheapest_first(study: Results, designs: list[str]) -> list[str]:
    """By cost where there are prices, else in the order of the study."""
    if not _priced(study):
        return designs
    found = {design: study.estimate(study.runs(design), "annual_cost") for design in designs}
    return sorted(designs, key=lambda design: one.mean if (one := found[design]) else float("inf"))
