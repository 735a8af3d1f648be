"""A run and a check as Jupyter shows them: as pages of a report, without scripts, on light and dark ground."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.answer.answer import Answer
from desim_warehouse.look import html
from desim_warehouse.look.web import StillPage, page_of
from desim_warehouse.report import answer_page, run_parts
from desim_warehouse.report.page import ReportPage
from desim_warehouse.report.svg import account, floor
from desim_warehouse.run import Check, Run

if TYPE_CHECKING:
    from desim_warehouse.report.page import Parts


@page_of.register
def run_page(run: Run) -> StillPage:
    """The first page of its report, and all its indicators; `desim report` and `run.replay` have the rest."""
    first = [run_parts.first_page(run), account(run), floor(run)]
    return _page(run.model.name, first, {"All indicators": [run_parts.indicators(run)]})


@page_of.register
def check_page(found: Check) -> StillPage:
    """The verdict, what was found, the quick estimate, and the layout in words."""
    name, _, size = found.facts[0].partition(": ")
    rows = [
        ["accepted error" if item.code in found.accepted else item.level, item.place, item.text, item.cure, item.code]
        for item in found.findings
    ]
    first = [html.heading(name), html.paragraph(found.verdict, "question")]
    if rows:
        first.append(html.table(["finding", "place", "what is wrong", "what to do", "code"], rows, words=5))
    if found.lines:
        first += [html.paragraph("Quick estimate, without traffic:"), html.bullets(found.lines)]
    return _page(name, first, {"The model": [html.bullets([size, *found.facts[1:]])]})


@page_of.register
def answer_page_(answer: Answer) -> StillPage:
    """The page of an answer without the run."""
    return StillPage(answer.question, answer_page.page(answer, run=None))


def _page(title: str, first: Parts, folded: dict[str, Parts]) -> StillPage:
    return StillPage(title, ReportPage(title=title, first=first, folded=folded).html())
