"""The page of a search for the best design: the answer, costs against the target, and all designs tried."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.report import html, plot
from desim_warehouse.report import page as pages
from desim_warehouse.report.text import best_words, words

if TYPE_CHECKING:
    from desim_warehouse.study.designs.best_of_many import BestOfMany


def page(found: BestOfMany, command: str = "") -> pages.ReportPage:
    """The report of a search; `command` is the line that repeats it."""
    answer = best_words.sentences(found)
    sense = "largest" if found.maximise else "smallest"
    aim = "" if found.target is None else f" with {words.target(found.target)}"
    question = f"With which design is {words.in_sentence(found.indicator)} {sense}{aim}?"
    head, rows = best_words.table(found, best_words.in_order(found))
    tiles = [
        words.scale(name, found.model, [mean.mean]).tile(mean, words.indicator_name(name))
        for name, mean in (
            (found.indicator, found.best.value),
            (found.target.indicator if found.target else found.indicator, found.best.reached),
        )
        if mean is not None
    ]
    return pages.ReportPage(
        title=found.model.name,
        first=[pages.first_page(found.model.name, "", question, tiles, answer, None, None), plot.trade_off(found)],
        sections={"All designs tried": [html.table(head, rows, words=len(found.best.labels), name="tried")]},
        appendix={
            "The floor with the best design": [plot.layout(found.model)],
            "Method and reproducibility": [
                html.bullets(
                    [
                        "Four fifths of the runs search: from a design to its neighbours, which race on the same days.",
                        "The means of the table are those of the search, where the best owe something to luck.",
                        "What is said of the best design and the next rests on fresh days alone.",
                    ]
                ),
                *([html.code(command)] if command else []),
            ],
        },
    )
