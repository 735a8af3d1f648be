"""Words for designs of a study: their names, their problems, and the knee of the throughput."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.numbers import Scale, capital, sentence
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model.facts.people import COUNTED
from desim_warehouse.outcome.verdicts import RULES
from desim_warehouse.study.fleet.capped import KEY, Capped
from desim_warehouse.study.possible import NotTried
from desim_warehouse.study.results import ResultsData
from desim_warehouse.study.table import averaged_over, cells, is_numeric

UNSETTLED = "not settled by the middle of its runs, and counted from there on; longer runs may settle"
"""Words on a design whose warm-up was to be found."""
_LISTED = 4
"""Number of options up to which they are named one by one."""


def wrong(study: ResultsData, *, lasting: bool = False) -> list[str]:
    """Return a line for each kind of verdict, with the worst design of its kind.

    `lasting`: include designs that cannot last, which some answers already report in the rows of these designs.
    """
    lines = []
    for code in RULES:
        by_design = {
            design: verdict
            for design, verdicts in study.verdicts.items()
            for verdict in verdicts
            if verdict.code == code and (lasting or not verdict.is_lasting)
        }
        if by_design:
            worst = max(by_design, key=lambda design: by_design[design].size)
            judged = sum(bool(study.runs(design)) for design in study.designs)
            share = f"; {len(by_design)} of {judged} options" if len(by_design) > 1 else ""
            where = f" ({name_of(study, worst)}{share})" if len(study.designs) > 1 else ""
            lines.append(f"{by_design[worst].text}{where}")
    return lines


def name_of(study: ResultsData, design: str) -> str:
    """Return a design in words, without factors that do not vary."""
    return words.design_spoken(_levels(study, design))


def option_of(study: ResultsData, design: str) -> tuple[str, str]:
    """Return the decisions of a design, and the demand that it is for; without a target both in the first."""
    levels = _levels(study, design)
    asked = {key: level for key, level in levels.items() if study.is_demand(key)}
    if study.target is None or len(asked) in {0, len(levels)}:
        return words.design_spoken(levels), ""
    decided = {key: level for key, level in levels.items() if key not in asked}
    return words.design_spoken(decided), words.design_spoken(asked)


def apart_from(study: ResultsData, design: str, other: str) -> str:
    """Return a design in words by the factors in which it differs from another design."""
    ours, theirs = _levels(study, design), _levels(study, other)
    differ = {key: level for key, level in ours.items() if level != theirs[key]}
    if len(differ) != 1:
        return words.design_spoken(differ)
    [(key, level)] = differ.items()
    return words.setting(key, level).removeprefix(f"{words.in_words(key)}: ")


def _levels(study: ResultsData, design: str) -> dict[str, Any]:
    """Return the levels of a design by factor, without the factors that do not vary."""
    levels = zip(study.factors, study.designs[design], strict=True)
    return {key: level for key, level in levels if key in study.varied or len(study.factors) == 1}


def knee_of_throughput(study: ResultsData) -> list[str]:
    """Return the sentence on where more robots stop paying off, if throughput rises significantly up to this knee."""
    from desim_warehouse.study.statistics.comparison import paired
    from desim_warehouse.study.statistics.knee import knee

    factor, indicator = "fleet.size", "throughput_per_hour"
    if factor not in study.factors or indicator not in study.moving:
        return []
    means = cells(study.table, [factor], indicator, study.plan.confidence)
    sizes = [cell.levels[0] for cell in means]
    if len(sizes) < 3 or not is_numeric(sizes):  # noqa: PLR2004 - fewer have no knee
        return []
    shape = knee(sizes, [cell.estimate.mean for cell in means])
    if shape.at is None or shape.output is None:
        return []
    first, at_knee = means[0].by_replication, means[sizes.index(shape.at)].by_replication
    common = sorted(first.keys() & at_knee.keys())
    if not common:
        return []
    rise = paired(
        [at_knee[r] for r in common],
        [first[r] for r in common],
        study.plan.confidence,
        deterministic=study.deterministic,
    )
    low = rise.mean if rise.deterministic else rise.interval[0] if rise.interval else 0.0
    if low <= 0:
        return []
    over = averaged_over(study.table, [factor])
    on_average = f" on average over {spoken(map(words.in_words, over))}" if over else ""
    return [
        (
            f"Throughput has its knee at {words.level(shape.at)} robots, with {numbers.measured(shape.output)} tasks "
            f"an hour{on_average}: beyond it, each further robot adds less than before. "
            f"The largest mean, {numbers.measured(shape.maximum)}, is at {words.level(shape.maximum_at)}."
        )
    ]


def capped(tried: Capped, scale: Scale) -> str:
    """Return the sentence on the gain of a cap on the robots under way."""
    gain, is_now = tried.gain, f"{words.in_sentence(tried.indicator)} is {scale.value(tried.mean)}"
    ends = "" if gain.low == gain.high else f" ({scale.bare(gain.low)} to {scale.bare(gain.high)})"
    return (
        f"With at most {tried.cap} of {number_of(tried.robots, 'robot')} under way, {is_now}: better by "
        f"{scale.value(gain.mean)}{ends}; desim size --key {KEY} finds the best cap"
    )


def not_tried(items: Iterable[NotTried]) -> list[str]:
    """Return a sentence for each reason for which options cannot be simulated: `4 to 6 robots were not tried: ...`."""
    return [
        sentence(f"{capital(_options(item))} {'was' if _is_one(item) else 'were'} not tried: {item.reason}")
        for item in items
    ]


def _is_one(item: NotTried) -> bool:
    """Whether the verb is in the singular: of one option, unless this is a number of robots or the like."""
    (first, *others) = item.options
    return not others and not any(key in COUNTED and value != 1 for key, value in first.items())


def _options(item: NotTried) -> str:
    """Name options inside a sentence: numbers by their ends, of many others the first and how many more."""
    names = [words.design_spoken(option) for option in item.options]
    levels = [level for option in item.options for level in option.values()]
    if 1 < len(names) == len(levels) and is_numeric(levels):
        [key] = item.options[0]
        return f"{levels[0]} to {names[-1]}" if key in COUNTED else f"{names[0]} to {levels[-1]}"
    return spoken(names if len(names) <= _LISTED else [*names[: _LISTED - 1], f"{len(names) - _LISTED + 1} more"])
