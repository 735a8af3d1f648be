"""What is said of differences to the baseline of a study, run by run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from desim_warehouse._version import simulated_with
from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import Scale, capital
from desim_warehouse.answer.parts import Option, SaidNumber
from desim_warehouse.answer.standing import Standing
from desim_warehouse.questions import judged
from desim_warehouse.questions.sentences import apart_from, name_of
from desim_warehouse.study.results import ResultsData
from desim_warehouse.study.statistics.comparison import Difference, Differences

_STANDING: dict[bool | None, Standing] = {True: "differs", False: "alike", None: "open"}


def answer(study: ResultsData, found: Mapping[str, Differences]) -> Answer:
    """The differences of all designs to one of them, in each indicator."""
    base = baseline_of(study, next(iter(found.values())))
    statements = dict.fromkeys(
        one.statement for one in found.values() if any(row.estimate.interval for row in one.differences)
    )
    return Answer(
        kind="compare",
        name=study.plan.name,
        description=study.plan.description,
        question=f"How do the options differ from {base}?",
        answer=tuple(_most(study, name, one, base) for name, one in found.items()),
        measures=dict.fromkeys(found, "difference"),
        options=tuple(option for name, one in found.items() for option in _options(study, name, one, base)),
        promise=judged.promise("", 0.0, exact=True)
        if study.deterministic
        else " ".join(f"{capital(said)}." for said in statements),
        notes=(f"{capital(made)}.",) if (made := simulated_with(study.version)) else (),
        runs=len(study.rows),
        confidence=study.plan.confidence,
        made=dict(study.versions),
        baseline=base,
    )


def baseline_of(study: ResultsData, found: Differences) -> str:
    """What designs are compared with: a design, or what those have in common that are matched with them."""
    bases = list(dict.fromkeys(map(str, found.against.values())))
    if len(bases) == 1:
        return name_of(study, bases[0])
    levels = zip(study.factors, *(study.designs[base] for base in bases), strict=True)
    fixed = {key: first for key, first, *others in levels if set(others) == {first}}
    return f"{words.design_spoken(fixed)}, all else equal"


def difference(study: ResultsData, indicator: str, row: Difference, *, turned: bool = False) -> SaidNumber:
    """A difference with its interval; shares in points. `turned`: as if the baseline were compared with it."""
    one, sign = row.estimate, -1 if turned else 1
    scale = words.scale_of(indicator, study.base, study.estimates(indicator).values())
    scale = Scale("points", 100.0) if scale.is_share else scale
    ends = sorted(sign * end for end in one.interval) if one.interval else [None, None]
    shown = judged.within(indicator, scale, (sign * one.mean, ends[0], ends[1]), 0.0)
    equal = one.n > 1 and one.sd == 0 and one.mean == 0 and not one.deterministic
    return shown.model_copy(update={"text": f"{scale.value(0.0)} (the same in all {one.n} runs)"}) if equal else shown


def _most(study: ResultsData, indicator: str, found: Differences, base: str) -> str:
    """The design that differs most, of those that are shown to differ."""
    told = [row for row in found.differences if row.differs]
    if not told:
        return f"No difference in {words.in_sentence(indicator)} is shown."
    most = max(told, key=lambda row: abs(row.estimate.mean))
    down = most.estimate.mean < 0
    by = difference(study, indicator, most, turned=down).text
    name = words.indicator_name(indicator)
    return f"{name}: {by} {'less' if down else 'more'} with {name_of(study, str(most.design))} than with {base}."


def _options(study: ResultsData, indicator: str, found: Differences, base: str) -> Iterator[Option]:
    """A row for each design, those whose runs are equal once; of copies of the baseline that they are."""
    group = f"{words.indicator_name(indicator)}, compared with {base}"
    first = {design: study.same.get(design, design) for design in study.designs}
    equal = {one for one, other in found.against.items() if first[one] == first[other]}
    for design in filter(equal.__contains__, study.designs):
        runs = len(study.runs(design))
        yield Option(name=name_of(study, design), group=group, standing="same", said="equal, run by run", runs=runs)
    for row in found.differences:
        design = str(row.design)
        if design not in equal:
            pair = first[design], first[str(row.baseline)]
            copies = [
                other
                for other, base in found.against.items()
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
