"""The sections of a study's report, as the notebook shows them one by one."""

from __future__ import annotations

import math
import platform
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ReportError, StudyError, WarehouseError
from desim_warehouse.report import html, plot, sentences, words
from desim_warehouse.report.html import Html
from desim_warehouse.report.model_parts import model_facts
from desim_warehouse.report.sentences import name_of
from desim_warehouse.study.results import Results
from desim_warehouse.study.statistics import first_order, main_effects
from desim_warehouse.study.table import RESULTS, is_numeric

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from desim_warehouse.run import Run

_ROWS = 60
"""Designs in a table; the rest is in results.parquet."""
_PANELS = 12
"""Panels of a figure; with more combinations of further factors, it averages over them, and says so."""
_FOREST = 24
"""Designs in a forest plot."""


def read(folder: str | Path) -> Results:
    """The results of a study folder that has something to report.

    Raises:
        ReportError: where there is no study, it is damaged, or no run has finished without an error.
    """
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


def heading(study: Results) -> Html:
    """Title and what the study is."""
    lead = html.paragraph(study.plan.description or study.base.description or "A what-if study.", "lead")
    return html.heading(study.plan.name) + lead


def question(study: Results) -> Html:
    """What was varied, and which indicators are compared."""
    looked_at = _listed([words.in_sentence(name) for name in study.main])
    if not study.factors:
        return html.paragraph(f"What are {looked_at} of the model as it is?")
    lines = [f"{key}: {_said(key)}{_values(study, key)}" for key in study.factors]
    return html.paragraph(f"How do {looked_at} change with:") + html.bullets(lines)


def _said(key: str) -> str:
    """The schema's description of a factor, as the beginning of a sentence."""
    meaning = words.description(key)
    return f"{meaning}; " if meaning else ""


def _values(study: Results, key: str) -> str:
    found = study.levels(key)
    if len(found) > 12:  # noqa: PLR2004 - a line of text
        return f"{len(found)} values from {words.level(found[0])} to {words.level(found[-1])}"
    return ", ".join(words.level(value) for value in found)


def _listed(items: list[str]) -> str:
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"


def conclusions(study: Results) -> Html:
    """What is wrong, and what the statistics show, one sentence a finding; or that they show nothing."""
    wrong = [sentences.sentence(line) for line in sentences.verdicts(study)]
    lines = sentences.conclusions(study)
    said = html.bullets([*wrong, *lines], "answers") if wrong or lines else Html("")
    return said if lines else said + html.paragraph("No difference between the designs is significant.", "note")


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
    if study.deterministic:
        rows[-1] = ("Random numbers", "none: the models are deterministic, one run is enough")
    return html.facts(rows, "design")


def results(study: Results) -> Html:
    """Mean and half-width of the main indicators at each design."""
    units = study.base.units
    head = [*study.factors, "runs", *(words.indicator_label(name, units) for name in study.main)]
    shown = list(study.designs)[:_ROWS]
    rows = [_result(study, design) for design in shown]
    if any(study.verdicts.values()):
        head.append("verdict")
        rows = [[*row, sentences.marks(study, design)] for row, design in zip(rows, shown, strict=True)]
    marked = frozenset(number for number, design in enumerate(shown) if design == study.baseline)
    found = html.table(head, rows, words=len(study.factors), name="results", marked=marked)
    note = (
        "The models are deterministic: replications cannot differ, so there are no intervals."
        if study.deterministic
        else f"Mean ± half-width, which holds the {100 * study.plan.confidence:g} % interval of each mean; "
        "without ± where chance plays no part, or there is only one replication."
    )
    if len(study.designs) > _ROWS:
        note += f" The first {_ROWS} of {len(study.designs)} designs; all are in results.parquet."
    return found + html.paragraph(f"{note} The baseline is shaded.", "note")


def _result(study: Results, design: str) -> list[str]:
    runs = study.runs(design)
    cells = [*(words.level(value) for value in study.designs[design]), str(len(runs))]
    for indicator in study.main:
        found = study.estimate(runs, indicator)
        cells.append(words.mean_text(found) if found else "failed")
    return cells


def result_figures(study: Results) -> list[Axes]:
    """Each main indicator by the first factors, a panel for each level of the others; throughput with its knee."""
    if not study.varied:
        return []
    rule = study.plan.rule
    first, second = study.varied[0], study.varied[1] if len(study.varied) > 1 else None
    further = study.varied[2:]
    grouped = second is not None and len(study.levels(second)) <= len(plot.COLOURS) and not rule.sampled
    panels = math.prod(len(study.levels(key)) for key in further)
    figures = []
    for indicator in study.moving:
        common: dict[str, Any] = {"confidence": study.plan.confidence, "model": study.base}
        if grouped and further and rule.name == "grid" and panels <= _PANELS:
            figures.append(plot.facets(study.table, first, indicator, group=second, by=further, **common))
        elif indicator == "throughput_per_hour" and first == "fleet.size" and not grouped and not rule.sampled:
            figures.append(plot.throughput(study.table, **common))
        else:
            figures.append(plot.by_factor(study.table, first, indicator, group=second if grouped else None, **common))
        if second is not None and not grouped and all(is_numeric(study.levels(key)) for key in (first, second)):
            figures.append(plot.surface(study.table, first, second, indicator, model=study.base))
    return figures


def effects(study: Results) -> Html:
    """Which factor matters: largest minus smallest mean over each factor's levels, and its share of variance."""
    varied = study.varied
    if len(varied) < 2 or study.plan.rule.name == "paired":  # noqa: PLR2004 - one factor is all there is
        return html.paragraph("One factor, or factors varied together: their effects cannot be told apart.", "note")
    rows, doubts = [], []
    for indicator in study.moving:
        swings = {item.factor: item.swing for item in main_effects(study.table, varied, indicator).factors}
        found = first_order(study.table, varied, indicator, confidence=study.plan.confidence)
        rows += [
            [words.indicator_name(indicator), key, words.number(swings[key]), found.text(key)] for key in found.shares
        ]
        if found.warning:
            doubts.append(f"{words.indicator_name(indicator)}: {found.warning}.")
    head = ["indicator", "factor", "largest − smallest mean", "share of variance"]
    note = "Share of the variance between designs that each factor explains alone (first-order Sobol index)."
    note = " ".join([note, *doubts])
    return html.table(head, rows, words=2, name="effects") + html.paragraph(note, "note")


def comparison(study: Results) -> Html:
    """Paired differences to the baseline, for each indicator."""
    parts = Html("")
    statement = ""
    for indicator in study.moving:
        found = study.compare_finished(indicator)
        if found is None:
            continue
        rows = [
            [
                name_of(study, str(row.design)),
                words.mean_text(row.estimate),
                "–" if row.p_adjusted is None else _p_value(row.p_adjusted),
                {True: "yes", False: "no", None: "cannot be told"}[row.differs],
            ]
            for row in found.differences[:_ROWS]
        ]
        label = words.indicator_label(indicator, study.base.units)
        head = [f"{label}: difference to {name_of(study, study.baseline)}", "mean", "p adjusted", "differs"]
        parts += html.table(head, rows, name=f"comparison-{indicator}")
        statement = "exact differences of deterministic models" if study.deterministic else found.statement
    if not statement:
        return html.paragraph("There is nothing to compare with the baseline.", "note")
    return parts + html.paragraph(f"For each indicator: {statement}.", "note")


def _p_value(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}"  # noqa: PLR2004 - digits shown


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


def busiest(study: Results) -> tuple[str, Run] | None:
    """The design with the most waiting (else collisions), simulated again with the seed of its first good run."""
    from desim_warehouse.run import simulate

    by = next((name for name in ("waiting", "S") if name in study.table), None)
    if by is None:
        return None
    good = {design: [row for row in study.runs(design) if not math.isnan(row.value(by))] for design in study.designs}
    means = {design: math.fsum(row.value(by) for row in rows) / len(rows) for design, rows in good.items() if rows}
    design = max(means, key=lambda key: means[key], default="")
    if design not in study.models:
        return None
    if any(spec.own for spec in study.models[design].policies.specs().values()):
        return None  # opening a colleague's study must not run their code
    try:
        return design, simulate(study.models[design].replace({"log": "tasks"}), good[design][0].seed)
    except WarehouseError:
        return None


def congestion(study: Results, again: tuple[str, Run] | None) -> Html:
    """Which run the map shows, and where robots wait most."""
    from desim_warehouse.report.run_parts import worst_places

    if again is None:
        own = any(spec.own for model in study.models.values() for spec in model.policies.specs().values())
        why = ": a report does not run the code of policies of your own" if own else ""
        return html.paragraph(f"No run is simulated again{why}.", "note")
    design, run = again
    what = "waiting" if "waiting" in study.table else "collisions"
    where = f"One run of {name_of(study, design)}, the design with the most {what} (seed {run.seed})."
    return html.paragraph(where) + worst_places(run)


def method(study: Results) -> Html:
    """How to get the same numbers again, and which runs failed."""
    rows = [
        ("To repeat it in Python", f"dw.Study.open({str(study.folder)!r}).run(out=DIR)"),
        ("Study seed", str(study.plan.seed)),
        ("Model", f"{study.base.name}, SHA-256 {study.base.digest()}"),
        *((name, version) for name, version in study.versions.items()),
        ("Report made with", f"Python {platform.python_version()}"),
    ]
    steps = [
        "Each run is a discrete-event simulation; its seed is in the column seed of results.parquet.",
        (
            "A mean's interval is Student's t over independent replications (Law 2015, section 4.5), from ten on "
            "corrected for skewness (Hall 1992). Values of 0 and 1 have that of a proportion (Clopper-Pearson), and "
            "where all replications agree, a share of runs that the rule of three leaves open may differ."
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
    head = [*study.factors, "replication", "error"]
    return html.paragraph(note) + html.table(head, rows, words=len(head), name="failures")
