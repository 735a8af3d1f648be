"""Conclusions in words, from the statistics: only what is significant is mentioned."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import spoken
from desim_warehouse.outcome.verdicts import RULES, is_no_answer, piles_up
from desim_warehouse.report.text import numbers, standing, words
from desim_warehouse.study.table import averaged_over, cells, is_numeric

if TYPE_CHECKING:
    from collections.abc import Iterable

    from desim_warehouse.report.text.numbers import Scale
    from desim_warehouse.study.results import Results
    from desim_warehouse.study.statistics import Comparison, Difference

UNSETTLED = "not settled by the middle of its runs, and counted from there on; make run.length longer"
"""Of a design whose warm-up was to be found."""
_MOST_TIMES = 10
"""Times the baseline up to which a difference is told as a part of it."""
VOLUMES = ("throughput_per_hour", "tasks", "moves", "distance")
"""Indicators that rise with demand in any warehouse."""


def conclusions(study: Results) -> list[str]:
    """What the study shows: each indicator's significant falls and rises, and where more robots stop paying off."""
    lines = []
    for indicator in study.moving:
        comparison = study.compare_finished(indicator)
        if comparison is not None:
            lines += against_baseline(study, indicator, comparison)
    return lines + knee_of_throughput(study)


def verdicts(study: Results) -> list[str]:
    """What is wrong, a line for each kind of verdict, with the design that has it worst."""
    lines = []
    for code in RULES:
        found = {design: one for design, said in study.verdicts.items() for one in said if one.code == code}
        if found:
            worst = max(found, key=lambda design: found[design].size)
            judged = sum(bool(study.runs(design)) for design in study.designs)
            of = f"; {len(found)} of {judged} designs" if len(found) > 1 else ""
            where = f" ({name_of(study, worst)}{of})" if len(study.designs) > 1 else ""
            lines.append(f"{found[worst].text}{where}")
    return lines


def sentence(line: str) -> str:
    """A line as a sentence, with a capital and a full stop."""
    return capital(f"{line}.")


def capital(line: str) -> str:
    """A sentence with a capital."""
    return f"{line[:1].upper()}{line[1:]}"


def marks(study: Results, design: str) -> str:
    """The marks of a design in a table; empty where nothing is wrong."""
    return ", ".join(one.mark for one in study.verdicts.get(design, ()))


def cell(study: Results, design: str, indicator: str, scale: Scale) -> str:
    """An estimate in a table of designs, unless it says nothing of the design."""
    if is_no_answer(indicator, study.verdicts.get(design, ())):
        return standing.WORDS["overloaded"]
    return scale.cell(study.shown(design, indicator), aim_of(study, indicator))


def aim_of(study: Results, indicator: str) -> float | None:
    """The target of a study where it is on this indicator."""
    goal = study.target
    return goal.value if goal is not None and goal.indicator == indicator else None


def alike(study: Results) -> list[str]:
    """Which designs are others by another name: a line for each of those that have copies."""
    copies: dict[str, list[str]] = {}
    for design, first in study.same.items():
        copies.setdefault(first, []).append(name_of(study, design))
    return [f"Run by run the same as {name_of(study, one)}: {spoken(names)}." for one, names in copies.items()]


def left_open(study: Results, shown: Iterable[str]) -> list[str]:
    """What cycle times in a table leave out, where that grows."""
    if not any(map(piles_up, study.verdicts.values())) or not any(name.startswith("cycle_time") for name in shown):
        return []
    return ["Cycle times are of tasks done: where the backlog grows, those still open are in none of them."]


def against_baseline(study: Results, indicator: str, comparison: Comparison) -> list[str]:
    """One sentence on the designs significantly below the baseline, and one on those above, with the farthest."""
    told = [row for row in comparison.differences if row.differs and not _follows(study, indicator, row)]
    sides = (
        ("lower", [row for row in told if row.estimate.mean < 0]),
        ("higher", [row for row in told if row.estimate.mean > 0]),
    )
    name, base = words.indicator_name(indicator), name_of(study, study.baseline)
    lines = []
    for word, rows in sides:
        if not rows:
            continue
        most = max(rows, key=lambda row: abs(row.estimate.mean))
        by = f"by {_amount(study, indicator, most)}"
        if len(comparison.differences) == 1:
            lines.append(f"{name} is {word} with {name_of(study, str(most.design))} than with {base}, {by}.")
        else:
            lines.append(
                f"{name} is {word} than with {base} in {len(rows)} of {len(comparison.differences)} designs, "
                f"most with {name_of(study, str(most.design))}: {by}."
            )
    return lines


def _follows(study: Results, indicator: str, row: Difference) -> bool:
    """Whether a difference only reflects more demand: no finding."""
    ours, base = study.models.get(str(row.design)), study.models.get(study.baseline)
    if indicator not in VOLUMES or ours is None or base is None:
        return False
    asked = [(model.tasks.goods, model.tasks.flows, model.tasks.demand) for model in (ours, base)]
    return asked[0] != asked[1]


def name_of(study: Results, design: str) -> str:
    """A design in words; factors that do not vary are left out."""
    return words.design_spoken(levels_of(study, design))


def levels_of(study: Results, design: str) -> dict[str, Any]:
    """The levels of a design by factor, without the factors that do not vary."""
    levels = zip(study.factors, study.designs[design], strict=True)
    return {key: level for key, level in levels if key in study.varied or len(study.factors) == 1}


def _amount(study: Results, indicator: str, row: Difference) -> str:
    """By how much: with the half-width, and as a share of the baseline's mean."""
    estimate = row.estimate
    values = study.values(study.baseline, indicator)
    base = values[~np.isnan(values)].mean()
    scale = words.scale(indicator, study.base, (base,))
    if scale.is_share:
        scale = numbers.Scale("percentage points", 100.0)
    half_width = None if estimate.half_width is None else scale.by * estimate.half_width
    digits = None if half_width is None else numbers.decimals(half_width)
    by = numbers.number(scale.by * abs(estimate.mean), digits)
    by += "" if half_width is None else f" ± {numbers.number(half_width, digits)}"
    by += f" {numbers.plural(scale.unit, scale.by * abs(estimate.mean))}" if scale.unit else ""
    by += ", exactly" if half_width is None else ""
    if not base or abs(estimate.mean) > _MOST_TIMES * abs(base):
        return by
    share = 100 * estimate.mean / abs(base)
    return f"{by} ({'+' if share > 0 else ''}{numbers.number(share, 0 if abs(share) >= 10 else 1)} %)"  # noqa: PLR2004


def knee_of_throughput(study: Results) -> list[str]:
    """Where more robots stop paying off, if throughput rises significantly up to there."""
    from desim_warehouse.study.statistics import knee, paired

    factor, indicator = "fleet.size", "throughput_per_hour"
    if study.plan.rule.sampled or factor not in study.factors or indicator not in study.moving:
        return []
    found = cells(study.table, [factor], indicator, study.plan.confidence)
    sizes = [cell.levels[0] for cell in found]
    if len(sizes) < 3 or not is_numeric(sizes):  # noqa: PLR2004 - fewer have no knee
        return []
    shape = knee(sizes, [cell.estimate.mean for cell in found])
    if shape.at is None or shape.output is None:
        return []
    first, there = found[0].by_replication, found[sizes.index(shape.at)].by_replication
    common = sorted(first.keys() & there.keys())
    if not common:
        return []
    rise = paired(
        [there[r] for r in common],
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
