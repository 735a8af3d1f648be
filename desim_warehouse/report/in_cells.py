"""A run and a check as Jupyter shows them: as pages of a report, without scripts, on light and dark ground."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.report import html, run_parts
from desim_warehouse.report.page import ReportPage
from desim_warehouse.report.web import StillPage

if TYPE_CHECKING:
    from desim_warehouse.run import Check, Run


def run_page(run: Run) -> StillPage:
    """The first page of its report, and all its indicators; `desim report` and `run.replay` have the rest."""
    page = ReportPage(
        title=run.model.name,
        first=[run_parts.first_page(run), *run_parts.first_figures(run)],
        sections={"Indicators": [run_parts.indicators(run)]},
        appendix={},
    )
    return StillPage(page.title, page.html())


def check_page(found: Check) -> StillPage:
    """The verdict, what was found, the layout in words, and the quick estimate."""
    name, _, size = found.facts[0].partition(": ")
    rows = [
        ["accepted error" if item.code in found.accepted else item.level, item.place, item.text, item.cure, item.code]
        for item in found.findings
    ]
    table = html.table(["finding", "place", "what is wrong", "what to do", "code"], rows, words=5)
    page = ReportPage(
        title=name,
        first=[html.heading(name), html.paragraph(found.verdict, "question"), table if rows else None],
        sections={
            "The model": [html.bullets([size, *found.facts[1:]])],
            "Quick estimate, without traffic": [html.bullets(found.lines) if found.lines else None],
        },
        appendix={},
    )
    return StillPage(page.title, page.html())
