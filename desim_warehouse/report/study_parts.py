"""The sections of a study's report, as the notebook shows them one by one."""

from __future__ import annotations

import math
import platform
from typing import TYPE_CHECKING

from desim_warehouse.errors import WarehouseError
from desim_warehouse.report import html, plot, sentences, words
from desim_warehouse.report.html import Html
from desim_warehouse.report.model_parts import model_facts
from desim_warehouse.report.tables import is_numeric
from desim_warehouse.study.indicators import within
from desim_warehouse.study.statistics import estimate, first_order, main_effects

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from desim_warehouse.report.source import Design, StudyFacts
    from desim_warehouse.run import Run
    from desim_warehouse.study.statistics import Estimate

_ROWS = 60
"""Designs in a table; the rest is in results.parquet."""
_FOREST = 24
"""Designs in a forest plot."""


def heading(study: StudyFacts) -> Html:
    """Title and what the study is."""
    lead = html.paragraph(study.description or study.base.description or "A what-if study.", "lead")
    return html.heading(study.name) + lead


def question(study: StudyFacts) -> Html:
    """What was varied, and what was looked at."""
    looked_at = _listed([words.in_sentence(name) for name in study.main])
    if not study.factors:
        return html.paragraph(f"What are {looked_at} of the model as it is?")
    lines = [f"{key}: {_said(key)}{_values(study, key)}" for key in study.factors]
    return html.paragraph(f"How do {looked_at} change with:") + html.bullets(lines)


def _said(key: str) -> str:
    """What the schema says of a factor, as the beginning of a sentence."""
    meaning = words.description(key)
    return f"{meaning}; " if meaning else ""


def _values(study: StudyFacts, key: str) -> str:
    found = study.levels(key)
    if len(found) > 12:  # noqa: PLR2004 - a line of text
        return f"{len(found)} values from {words.level(found[0])} to {words.level(found[-1])}"
    return ", ".join(words.level(value) for value in found)


def _listed(items: list[str]) -> str:
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"


def conclusions(study: StudyFacts) -> Html:
    """What the statistics show, one sentence a finding; or that they show nothing."""
    lines = sentences.conclusions(study)
    if not lines:
        return html.paragraph("No difference between the designs is significant.", "note")
    return html.bullets(lines, "answers")


def warehouse(study: StudyFacts) -> Html:
    """The model in numbers."""
    return model_facts(study.base)


def design(study: StudyFacts) -> Html:
    """How many designs and runs, and by which rule."""
    failed = int(study.table["error"].notna().sum()) if "error" in study.table else 0
    rows = [
        ("Designs", f"{len(study.designs)} ({study.rule})"),
        ("Replications", study.replications),
        ("Runs", f"{len(study.table)}" + (f", {failed} of them failed" if failed else "")),
        ("Baseline", study.name_of(study.baseline)),
        ("Random numbers", "common: replication r has the same streams at every design"),
    ]
    if study.deterministic:
        rows[-1] = ("Random numbers", "none: the models are deterministic, one run tells all")
    return html.facts(rows, "design")


def results(study: StudyFacts) -> Html:
    """Mean and half-width of the main indicators at each design."""
    units = study.base.units
    head = [*study.factors, "runs", *(words.indicator_label(name, units) for name in study.main)]
    shown = study.designs[:_ROWS]
    rows = [_result(study, design) for design in shown]
    marked = frozenset(number for number, design in enumerate(shown) if design == study.baseline)
    found = html.table(head, rows, words=len(study.factors), name="results", marked=marked)
    note = (
        "The models are deterministic: replications cannot differ, so there are no intervals."
        if study.deterministic
        else f"Mean ± half-width, which holds the {100 * study.confidence:g} % interval of each mean; "
        "without ± where there is only one replication."
    )
    if len(study.designs) > _ROWS:
        note += f" The first {_ROWS} of {len(study.designs)} designs; all are in results.parquet."
    return found + html.paragraph(f"{note} The baseline is shaded.", "note")


def _result(study: StudyFacts, design: Design) -> list[str]:
    runs = study.runs(design)
    cells = [*(words.level(value) for value in design), str(len(runs))]
    for indicator in study.main:
        values = runs[indicator].dropna().astype(float).tolist()
        cells.append(words.mean_text(_estimate(study, design, indicator, values)) if values else "failed")
    return cells


def _estimate(study: StudyFacts, design: Design, indicator: str, values: list[float]) -> Estimate:
    fixed = study.is_deterministic(design)
    return estimate(values, study.confidence, deterministic=fixed, within=within(indicator))


def result_figures(study: StudyFacts) -> list[Axes]:
    """Each main indicator by the first factors; throughput by fleet size with its knee; surfaces of two."""
    if not study.factors:
        return []
    varied = [key for key in study.factors if len(study.levels(key)) > 1]
    if not varied:
        return []
    first, second = varied[0], (varied[1] if len(varied) > 1 else None)
    few = second is not None and len(study.levels(second)) <= len(plot.COLOURS) and not study.sampled
    figures = []
    for indicator in study.moving:
        if indicator == "throughput_per_hour" and first == "fleet.size" and not few and not study.sampled:
            figures.append(plot.throughput(study.table, model=study.base, confidence=study.confidence))
            continue
        figures.append(
            plot.by_factor(
                study.table,
                first,
                indicator,
                group=second if few else None,
                confidence=study.confidence,
                model=study.base,
            )
        )
        if second is not None and not few and all(is_numeric(study.levels(key)) for key in (first, second)):
            figures.append(plot.surface(study.table, first, second, indicator, model=study.base))
    return figures


def effects(study: StudyFacts) -> Html:
    """Which factor matters: largest minus smallest mean over each factor's levels, and its share of variance."""
    varied = [key for key in study.factors if len(study.levels(key)) > 1]
    if len(varied) < 2 or study.rule == "paired":  # noqa: PLR2004 - one factor is all there is
        return html.paragraph("One factor, or factors varied together: their effects cannot be told apart.", "note")
    rows, doubts = [], []
    for indicator in study.moving:
        swings = {item.factor: item.swing for item in main_effects(study.table, varied, indicator).factors}
        found = first_order(study.table, varied, indicator, confidence=study.confidence)
        rows += [
            [words.indicator_name(indicator), key, words.number(swings[key]), found.text(key)] for key in found.shares
        ]
        if found.warning:
            doubts.append(f"{words.indicator_name(indicator)}: {found.warning}.")
    head = ["indicator", "factor", "largest − smallest mean", "share of variance"]
    note = "Share of the variance between designs that each factor explains alone (first-order Sobol index)."
    note = " ".join([note, *doubts])
    return html.table(head, rows, words=2, name="effects") + html.paragraph(note, "note")


def comparison(study: StudyFacts) -> Html:
    """Paired differences to the baseline, for each indicator."""
    parts = Html("")
    statement = ""
    for indicator in study.moving:
        found = study.comparison(indicator)
        if found is None:
            continue
        rows = [
            [
                study.name_of(row.design),  # type: ignore[arg-type]
                words.mean_text(row.estimate),
                "–" if row.p_adjusted is None else _p_value(row.p_adjusted),
                {True: "yes", False: "no", None: "cannot be told"}[row.differs],
            ]
            for row in found.differences[:_ROWS]
        ]
        label = words.indicator_label(indicator, study.base.units)
        head = [f"{label}: difference to {study.name_of(study.baseline)}", "mean", "p adjusted", "differs"]
        parts += html.table(head, rows, name=f"comparison-{indicator}")
        statement = "exact differences of deterministic models" if study.deterministic else found.statement
    if not statement:
        return html.paragraph("There is nothing to compare with the baseline.", "note")
    return parts + html.paragraph(f"For each indicator: {statement}.", "note")


def _p_value(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}"  # noqa: PLR2004 - digits shown


def comparison_figures(study: StudyFacts) -> list[Axes]:
    """A forest plot for each main indicator; none for more designs than fit."""
    if not 1 < len(study.designs) <= _FOREST:
        return []
    names = {design: study.name_of(design) for design in study.designs}
    found = ((indicator, study.comparison(indicator)) for indicator in study.moving)
    return [
        plot.differences(made, indicator, names=names, model=study.base)
        for indicator, made in found
        if made is not None
    ]


def busiest(study: StudyFacts) -> tuple[Design, Run] | None:
    """The design with the most waiting (else collisions), simulated again with the seed of its first good run."""
    from desim_warehouse.run import simulate

    by = next((name for name in ("waiting", "S") if name in study.table), None)
    if by is None:
        return None
    means = {design: float(study.runs(design)[by].mean()) for design in study.designs}
    design = max(study.designs, key=lambda key: -1.0 if math.isnan(means[key]) else means[key])
    good = study.runs(design).dropna(subset=[by])
    if good.empty or design not in study.models:
        return None
    try:
        return design, simulate(study.models[design].replace({"log": "tasks"}), int(good["seed"].iloc[0]))
    except WarehouseError:
        return None


def congestion(study: StudyFacts, again: tuple[Design, Run] | None) -> Html:
    """Which run the map shows, and where most is waited."""
    from desim_warehouse.report.run_parts import worst_places

    if again is None:
        return html.paragraph("No run is simulated again.", "note")
    design, run = again
    what = "waiting" if "waiting" in study.table else "collisions"
    where = f"One run of {study.name_of(design)}, the design with the most {what} (seed {run.seed})."
    return html.paragraph(where) + worst_places(run)


def method(study: StudyFacts) -> Html:
    """How to get the same numbers again, and which runs failed."""
    rows = [
        ("Again, in Python", f"dw.Study.open({study.folder!r}).run(out=DIR)"),
        ("Study seed", str(study.seed)),
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


def _failures(study: StudyFacts) -> Html:
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
