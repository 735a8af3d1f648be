"""The answer of a comparison: the paired differences of designs from the baseline of a study."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from desim_warehouse._version import simulated_with
from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import Scale, capital
from desim_warehouse.answer.parts import Option, ShownNumber
from desim_warehouse.answer.standing import Standing
from desim_warehouse.questions import judged
from desim_warehouse.questions.sentences import apart_from, name_of
from desim_warehouse.study.results import ResultsData
from desim_warehouse.study.statistics.comparison import Difference, Differences

_STANDING: dict[bool | None, Standing] = {True: "differs", False: "alike", None: "open"}


def answer(study: ResultsData, comparisons: Mapping[str, Differences]) -> Answer:
    """Return the answer on how all designs differ from the baseline, in each indicator."""
    base = baseline_of(study, next(iter(comparisons.values())))
    statements = dict.fromkeys(
        comparison.statement
        for comparison in comparisons.values()
        if any(row.estimate.interval for row in comparison.differences)
    )
    return Answer(
        kind="compare",
        name=study.plan.name,
        description=study.plan.description,
        question=f"How do the options differ from {base}?",
        answer=tuple(_most(study, name, comparison, base) for name, comparison in comparisons.items()),
        measures=dict.fromkeys(comparisons, "difference"),
        options=tuple(
            option for name, comparison in comparisons.items() for option in _options(study, name, comparison, base)
        ),
        promise=judged.promise("", 0.0, exact=True)
        if study.deterministic
        else " ".join(f"{capital(statement)}." for statement in statements),
        notes=(f"{capital(made)}.",) if (made := simulated_with(study.version)) else (),
        runs=len(study.rows),
        confidence=study.plan.confidence,
        made=dict(study.versions),
        baseline=base,
    )


def baseline_of(study: ResultsData, differences: Differences) -> str:
    """Return the baseline in words: a design, or the levels that the baselines of all designs have in common."""
    bases = list(dict.fromkeys(map(str, differences.against.values())))
    if len(bases) == 1:
        return name_of(study, bases[0])
    levels = zip(study.factors, *(study.designs[base] for base in bases), strict=True)
    fixed = {key: first for key, first, *others in levels if set(others) == {first}}
    return f"{words.design_spoken(fixed)}, all else equal"


def difference(study: ResultsData, indicator: str, row: Difference, *, turned: bool = False) -> ShownNumber:
    """Return a difference with its interval, shares in points; `turned` reverses its sign."""
    estimate, sign = row.estimate, -1 if turned else 1
    scale = words.scale_of(indicator, study.base, study.estimates(indicator).values())
    scale = Scale("points", 100.0) if scale.is_share else scale
    ends = sorted(sign * end for end in estimate.interval) if estimate.interval else [None, None]
    shown = judged.within(indicator, scale, (sign * estimate.mean, ends[0], ends[1]), 0.0)
    equal = estimate.n > 1 and estimate.sd == 0 and estimate.mean == 0 and not estimate.deterministic
    return shown.model_copy(update={"text": scale.agreeing(0.0, estimate.n)}) if equal else shown


def _most(study: ResultsData, indicator: str, differences: Differences, base: str) -> str:
    """Return the sentence on the design with the largest significant difference."""
    shown = [row for row in differences.differences if row.differs]
    if not shown:
        return f"No difference in {words.in_sentence(indicator)} is evident."
    most = max(shown, key=lambda row: abs(row.estimate.mean))
    down = most.estimate.mean < 0
    by = difference(study, indicator, most, turned=down).text
    name = words.indicator_name(indicator)
    return f"{name}: {by} {'less' if down else 'more'} with {name_of(study, str(most.design))} than with {base}."


def _options(study: ResultsData, indicator: str, differences: Differences, base: str) -> Iterator[Option]:
    """Yield a row for each design; designs with equal runs share a row, and copies of the baseline say so."""
    group = f"{words.indicator_name(indicator)}, compared with {base}"
    first = {design: study.same.get(design, design) for design in study.designs}
    equal = {design for design, other in differences.against.items() if first[design] == first[other]}
    for design in filter(equal.__contains__, study.designs):
        runs = len(study.runs(design))
        yield Option(name=name_of(study, design), group=group, standing="same", instead="equal, run by run", runs=runs)
    for row in differences.differences:
        design = str(row.design)
        if design not in equal:
            pair = first[design], first[str(row.baseline)]
            copies = [
                other
                for other, base in differences.against.items()
                if other != design and (first[other], first[base]) == pair
            ]
            yield Option(
                name=name_of(study, design),
                group=group,
                standing=_STANDING[row.differs],
                number=difference(study, indicator, row),
                p=row.p_adjusted,
                runs=row.estimate.n,
                same=tuple(apart_from(study, other, design) for other in copies),
            )
