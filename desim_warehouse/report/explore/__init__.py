"""The what-if page: a study as one HTML page in which sliders choose designs, without a network.

Everything is worked out here, for every design and every pair of designs; the page only looks it up.
"""

from __future__ import annotations

import html
import math
from typing import TYPE_CHECKING

from desim_warehouse.errors import ReportError
from desim_warehouse.report.explore.payload import payload
from desim_warehouse.report.web import WebPage, joined, safe_json

if TYPE_CHECKING:
    from pathlib import Path

    from desim_warehouse.study.plan import StudyPlan
    from desim_warehouse.study.results import Results

MOST_DESIGNS = 120
"""Designs of a page: it holds the differences of every two of them."""


class WhatIfPage(WebPage):
    """A what-if page: write it with `save`; in Jupyter it shows itself."""


def explore(results: Results, path: str | Path | None = None, *, command: str = "") -> WhatIfPage:
    """Make the what-if page of a study.

    Args:
        results: the finished runs of a study whose designs are all combinations of its factors' values.
        path: where to write the page; None: nowhere yet.
        command: the line that repeats the study, for readers; default: that of its folder, if it has one.

    Raises:
        ReportError: a design that has no page (`check`), no finished run, or a path that cannot be written.
    """
    check(results.plan)
    if all(row.outcome.error is not None for row in results.rows):
        raise ReportError(f"{results.plan.name}: no run has finished, so a page has nothing to show")
    parts = {
        "title": html.escape(f"{results.plan.name}: what if"),
        "study": safe_json(payload(results, command)),
    }
    made = WhatIfPage(f"{results.plan.name}: what if", joined("desim_warehouse.report.explore", parts))
    if path is not None:
        made.save(path)
    return made


def check(plan: StudyPlan) -> None:
    """Refuse a study that a page cannot show, before it is simulated.

    Raises:
        ReportError: designs that are not all combinations of the factors' values, or too few or too many of them.
    """
    count = len({str(point) for point in plan.points()})
    levels = [len({str(level.label) for level in factor.levels}) for factor in plan.factors]
    if plan.rule.sampled or count != math.prod(levels):
        raise ReportError(
            f"a page has a slider for each factor, so every combination must be a design (got {plan.rule.name}), "
            "expected design: grid"
        )
    if not 1 < count <= MOST_DESIGNS:
        cure = "vary something, such as --vary fleet.size=1..6" if count == 1 else "vary less"
        raise ReportError(f"a page compares 2 to {MOST_DESIGNS} designs (got {count}), {cure}")
