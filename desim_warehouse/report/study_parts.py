"""The sections of a study's report: on its page, and one by one in the notebook reports/study.ipynb."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ReportError, StudyError
from desim_warehouse.outcome.verdicts import is_no_answer
from desim_warehouse.report import html, plot, run_parts
from desim_warehouse.report import page as pages
from desim_warehouse.report.html import Html
from desim_warehouse.report.model_parts import model_facts
from desim_warehouse.report.text import answers, numbers, sentences, words
from desim_warehouse.report.text.sentences import name_of
from desim_warehouse.study.results import Results
from desim_warehouse.study.statistics import first_order, main_effects
from desim_warehouse.study.study import Study
from desim_warehouse.study.table import RESULTS, is_numeric

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from desim_warehouse.report.page import ReportPage
    from desim_warehouse.run import Run

_ROWS = 60
"""Designs in a table; the rest is in results.parquet."""
_PANELS = 12
"""Panels of a figure; with more combinations of further factors, it averages over them, and says so."""
_FOREST = 24
"""Designs in a forest plot."""
_UNNAMED = ("what-if", "size", "best", "study", "why")
"""Names of studies without one of their own: their reports have the name of the model."""


def read(folder: str | Path | None) -> Results:
    """The results of a study folder that has something to report; None: of a small study made now.

    Raises:
        ReportError: where there is no study, it is damaged, or no run has finished without an error.
    """
    if folder is None:
        return Study(pages.example(), {"fleet.size": [1, 2, 3]}, replications=5, target="on_time >= 90 %").run().results
    try:
        results = Results.load(folder)
    except StudyError as error:
        raise ReportError(str(error)) from error
    if not results.rows:
        raise ReportError(f"{Path(folder) / RESULTS}: no run has finished, so there is nothing to report")
    errors = [row.outcome.error for row in results.rows]
    if None not in errors:
        raise ReportError(f"{Path(folder) / RESULTS}: every run failed, the first with: {errors[0]}")
    return results


def page(folder: str | Path, replay: str | None = None) -> ReportPage:
    """The report of the study of a folder; `replay` is a file for the replay of one run, which the first page links."""
    study = read(folder)
    run = example_run(study)
    return pages.ReportPage(
        title=_title(study),
        first=[first_page(study, run, replay), *first_figure(study)],
        sections={
            "Where the time goes": [account(study, run), *run_parts.account_figures(run)],
            "Findings": [conclusions(study), *result_figures(study), results(study)],
            **run_parts.places(run),
        },
        appendix={
            "Which factor matters": [effects(study)],
            "Comparison with the baseline": [*comparison_figures(study), comparison(study)],
            "The warehouse": [plot.layout(study.base), warehouse(study)],
            "Design of the study": [design(study)],
            "Method and reproducibility": [method(study)],
        },
    )


def _title(study: Results) -> str:
    return study.base.name if study.plan.name in _UNNAMED else study.plan.name


def first_page(study: Results, run: Run | None, replay: str | None = None) -> Html:
    """The question, the answer, and what a year costs; `run` is linked as a replay where there is a path for it."""
    about = study.plan.description or study.base.description
    said, named = answers.answer(study)
    return pages.first_page(_title(study), about, answers.question(study), numbers_of(study, named), said, run, replay)


def numbers_of(study: Results, design: str | None) -> list[tuple[str, str, str]]:
    """What the design of the answer achieves: its first indicators with their intervals, and its cost."""
    if design is None:
        return []
    estimates = {name: study.shown(design, name) for name in (*study.main[:3], "annual_cost")}
    tiles = {
        name: words.scale(name, study.base, (found.mean,)).tile(
            found, words.in_sentence(name), sentences.aim_of(study, name)
        )
        for name, found in estimates.items()
        if found is not None and not is_no_answer(name, study.verdicts.get(design, ()))
    }
    year = estimates["annual_cost"]
    if year is not None and answers.cost_is_fixed(study):
        tiles["annual_cost"] = words.scale("annual_cost", study.base).value(year.mean), "a year", ""
    return list(tiles.values())


def first_figure(study: Results) -> list[Axes]:
    """The indicator of the target, or the first that differs, by all factors."""
    first = _first(study)
    return [] if first is None else [_figure(study, first)]


def _first(study: Results) -> str | None:
    first = study.target.indicator if study.target else next(iter(study.moving), None)
    return first if study.factors and first in study.table else None


def example_run(study: Results) -> Run | None:
    """A run of the design that the answer names, simulated again with everything logged."""
    _, design = answers.answer(study)
    good = [] if design is None else [row for row in study.runs(design) if row.outcome.error is None]
    if design is None or not good or design not in study.models:
        return None
    return pages.in_full(study.models[design], good[0].seed)


def account(study: Results, run: Run | None) -> Html | None:
    """The biggest part of a task's time, and which run that was."""
    _, design = answers.answer(study)
    return None if run is None or design is None else run_parts.account_of(run, name_of(study, design))


def conclusions(study: Results) -> Html:
    """What is wrong, and what the statistics show, one sentence a finding; or that they show nothing."""
    wrong = [sentences.sentence(line) for line in sentences.verdicts(study)]
    lines = [*answers.on_target(study), *sentences.conclusions(study)]
    said = html.bullets([*wrong, *lines], "answers") if wrong or lines else Html("")
    none = "No difference between the designs is significant." if len(study.designs) > 1 else "One design was run."
    return said if lines else said + html.paragraph(none, "note")


def warehouse(study: Results) -> Html:
    """The model in numbers."""
    return model_facts(study.base)


def design(study: Results) -> Html:
    """How many designs and runs, and by which design rule."""
    failed = int(study.table["error"].notna().sum()) if "error" in study.table else 0
    rows = [
        ("Designs", f"{len(study.designs)} ({study.plan.rule.name})"),
        ("Replications", words.replications(study.plan)),
        ("Runs", f"{len(study.table)}" + (f", {failed} of them failed" if failed else "")),
        ("Baseline", name_of(study, study.baseline)),
        ("Random numbers", "common: replication r has the same streams at every design"),
    ]
    if study.warm_ups:
        rows.insert(3, ("Warm-up", words.warm_up(study)))
    if study.deterministic:
        rows[-1] = ("Random numbers", "none: the models are deterministic, one run is enough")
    return html.facts(rows, "design")


def results(study: Results) -> Html:
    """Mean and half-width of the main indicators at each design."""
    tried = [design for design in study.designs if study.runs(design) and design not in study.same]
    shown = tried[:_ROWS]
    scales = {
        name: words.scale_of(name, study.base, [study.estimate(study.runs(design), name) for design in shown])
        for name in study.main
    }
    head = [*_heads(study), "runs", *(words.head(name, scale) for name, scale in scales.items())]
    rows = [
        [
            *(words.level(value) for value in study.designs[design]),
            str(len(study.runs(design))),
            *(sentences.cell(study, design, name, scale) for name, scale in scales.items()),
        ]
        for design in shown
    ]
    if study.target is not None:
        head.append(words.target(study.target))
        rows = [[*row, words.met(study, design)] for row, design in zip(rows, shown, strict=True)]
    if study.warm_ups:
        head.append(f"warm-up ({study.base.units.time})")
        rows = [[*row, numbers.number(study.warm_ups[design])] for row, design in zip(rows, shown, strict=True)]
    if any(study.verdicts.values()):
        head.append("verdict")
        rows = [[*row, sentences.marks(study, design)] for row, design in zip(rows, shown, strict=True)]
    marked = frozenset(
        number for number, design in enumerate(shown) if design == study.same.get(study.baseline, study.baseline)
    )
    made = html.table(head, rows, words=len(study.factors), name="results", marked=marked)
    note = (
        "The models are deterministic: replications cannot differ, so there are no intervals."
        if study.deterministic
        else f"Means with half-width, or the ends in brackets, of their {100 * study.plan.confidence:g} % intervals; "
        "without where chance plays no part, or there is only one replication."
    )
    if len(tried) > _ROWS:
        note += f" The first {_ROWS} of {len(tried)} designs; all are in results.parquet."
    left = " ".join(["", *sentences.alike(study), *sentences.left_open(study, study.main)])
    return made + html.paragraph(f"{note} The baseline is shaded.{left}", "note")


def result_figures(study: Results) -> list[Axes]:
    """Each main indicator that differs by all factors, but that of the first page; a surface of two where they fit."""
    if not study.factors:
        return []
    first, varied = _first(study), study.varied
    figures = []
    for indicator in study.moving:
        figures += [] if indicator == first else [_figure(study, indicator)]
        numeric = len(varied) > 1 and all(is_numeric(study.levels(key)) for key in varied[:2])
        if numeric and _arranged(study)[1] is None:
            figures.append(plot.surface(study.table, varied[0], varied[1], indicator, model=study.base))
    return figures


def _arranged(study: Results) -> tuple[str, str | None, list[str]]:
    """The factor along the axis (robots if they vary), that with a line for each level, those with panels."""
    ahead = [key for key in study.varied if key == "fleet.size"]
    ahead += [key for key in study.varied if "charger" in key]
    factor, *others = dict.fromkeys([*ahead, *study.varied]) or study.factors
    few = (key for key in others if len(study.levels(key)) <= len(plot.COLOURS))
    group = None if study.plan.rule.sampled else next(few, None)
    return factor, group, [key for key in others if key != group]


def _figure(study: Results, indicator: str) -> Axes:
    """An indicator by the factors; throughput by robots alone with its knee, that of the target with a line there."""
    factor, group, further = _arranged(study)
    goal = study.target if study.target and study.target.indicator == indicator else None
    common: dict[str, Any] = {"confidence": study.plan.confidence, "model": study.base}
    aim = {**common, "target": goal and goal.value}
    panels = math.prod(len(study.levels(key)) for key in further)
    if further and study.plan.rule.name == "grid" and panels <= _PANELS:
        return plot.facets(study.table, factor, indicator, group=group, by=further, **aim)
    alone = not (goal or group or further or study.plan.rule.sampled)
    if alone and (indicator, factor) == ("throughput_per_hour", "fleet.size"):
        return plot.throughput(study.table, **common)
    return plot.by_factor(study.table, factor, indicator, group=group, **aim)


def _heads(study: Results) -> list[str]:
    """The factors, for the head of a table."""
    return [words.factor_head(key, study.base.units) for key in study.factors]


def effects(study: Results) -> Html | None:
    """Which factor matters: largest minus smallest mean over each factor's levels, and its share of variance."""
    varied = study.varied
    if len(varied) < 2 or study.plan.rule.name == "paired":  # noqa: PLR2004 - one factor is all there is
        return None  # one factor, or factors varied together: their effects cannot be told apart
    rows, doubts = [], []
    for indicator in study.moving:
        swings = {item.factor: item.swing for item in main_effects(study.table, varied, indicator).factors}
        scale = words.scale(indicator, study.base)
        found = first_order(study.table, varied, indicator, confidence=study.plan.confidence)
        rows += [
            [
                words.indicator_name(indicator),
                words.factor_name(key),
                scale.bare(swings[key]),
                found.text(key),
            ]
            for key in found.shares
        ]
        if found.warning:
            doubts.append(f"{words.indicator_name(indicator)}: {found.warning}.")
    head = ["indicator", "factor", "largest − smallest mean", "share of variance"]
    note = "Share of the variance between designs that each factor explains alone (first-order Sobol index)."
    note = " ".join([note, *doubts])
    return html.table(head, rows, words=2, name="effects") + html.paragraph(note, "note")


def comparison(study: Results) -> Html | None:
    """Paired differences to the baseline, for each indicator."""
    parts = Html("")
    statement = ""
    for indicator in study.moving:
        found = study.compare_finished(indicator)
        if found is None:
            continue
        scale = words.scale_of(indicator, study.base, study.estimates(indicator).values())
        rows = [[name_of(study, str(row.design)), *scale.difference(row)] for row in found.differences[:_ROWS]]
        label = words.head(indicator, scale)
        head = [
            f"{label}: difference to {name_of(study, study.baseline)}",
            "mean",
            "from",
            "to",
            "p adjusted",
            "verdict",
        ]
        parts += html.table(head, rows, name=f"comparison-{indicator}")
        statement = "exact differences of deterministic models" if study.deterministic else found.statement
    if not statement:
        return None
    return parts + html.paragraph(f"For each indicator: {statement}.", "note")


def comparison_figures(study: Results) -> list[Axes]:
    """A forest plot for each main indicator; none for more designs than fit."""
    if not 1 < len(study.designs) <= _FOREST:
        return []
    names = {design: name_of(study, design) for design in study.designs}
    found = ((indicator, study.compare_finished(indicator)) for indicator in study.moving)
    return [
        plot.differences(made, indicator, names=names, model=study.base)
        for indicator, made in found
        if made is not None
    ]


def method(study: Results) -> Html:
    """How to get the same numbers again, and which runs failed."""
    rows = [("To repeat it in Python", f"dw.Study.open({str(study.folder)!r}).run(out=DIR)")] if study.folder else []
    rows += versions(study)
    steps = [
        "Each run is a discrete-event simulation; its seed is in the column seed of results.parquet.",
        (
            "A mean's interval is Student's t over independent replications (Law 2015, section 4.5), from ten on "
            "corrected for skewness (Hall 1992). Values of 0 and 1 have that of a proportion (Clopper-Pearson), and "
            "where all replications agree, a share of runs that the rule of three leaves open may differ. Shares of "
            "tasks count tasks, with a design effect for days (Korn & Graubard 1998)."
        ),
        (
            "Designs are compared replication by replication under common random numbers, intervals by Bonferroni "
            "(Law 2015, sections 10.2 and 10.3)."
        ),
        "A conclusion stands above only if its difference is significant after that correction.",
    ]
    if study.deterministic:
        steps[1:] = ["The models are deterministic: every difference is exact."]
    return html.bullets(steps) + html.facts(rows, "method") + _failures(study)


def versions(study: Results) -> list[tuple[str, str]]:
    """What the runs were made with."""
    return [
        ("Study seed", str(study.plan.seed)),
        ("Model", f"{study.base.name}, SHA-256 {study.base.digest()}"),
        *study.versions.items(),
        run_parts.made_with(),
    ]


def _failures(study: Results) -> Html:
    if "error" not in study.table or not study.table["error"].notna().any():
        return Html("")
    failed = study.table[study.table["error"].notna()]
    rows = [
        [*(words.level(row[key]) for key in study.factors), str(row["replication"]), str(row["error"])]
        for _, row in failed.head(_ROWS).iterrows()
    ]
    what = "1 run failed and is" if len(failed) == 1 else f"{len(failed)} runs failed and are"
    note = f"{what} left out everywhere above."
    head = [*_heads(study), "replication", "error"]
    return html.paragraph(note) + html.table(head, rows, words=len(head), name="failures")
