"""The page of real days held against a model: the verdict, a day over the simulated ones, and the floor by edges."""

from __future__ import annotations

from desim_warehouse import plot
from desim_warehouse.answer import words
from desim_warehouse.answer.numbers import capital
from desim_warehouse.fleet_log.measures import MEASURES
from desim_warehouse.fleet_log.validate import Validation
from desim_warehouse.look import html
from desim_warehouse.look import page as pages
from desim_warehouse.plot.days import farthest

_METHOD = (
    "Each real day is simulated many times, and measured from the same messages by the same code.",
    "All measures count at once: a right model is refuted on at most one day in twenty. Not refuted is no proof.",
    "Measures alone decide. Figures show where to look: the band of each holds all of a right day on 95 of 100 days.",
)
HEAD = ("Measure", "Real", "Simulated", "Band", "Verdict")


def page(found: Validation, command: str = "") -> pages.ReportPage:
    """The report of real days held against a model; `command` is the line that repeats it."""
    days = len(found.days)
    question = f"Do {days} real days refute this model?" if days > 1 else "Does a real day refute this model?"
    verdict = "refuted" if found.refuted else "not refuted"
    outside = f"{len(found.outside)} of {len(found.names)}"
    tiles = [
        (verdict, "Verdict", f"p = {found.measures.p_value:.2g}"),
        (outside, "Measures outside", "even a correct model shows one on 1 day in 20"),
    ]
    answer = [capital(f"{line}.") for line in found.lines()]
    worst = farthest(found)
    others = [number for number in range(days) if number != worst]
    return pages.ReportPage(
        title=found.model.name,
        first=[
            pages.first_page(found.model.name, "", question, tiles, answer),
            html.paragraph(_said_of(found, worst)),
            plot.real_day(found, worst),
            html.table(HEAD, cells(found), name="measures"),
        ],
        folded={
            "Where robots drove": [] if found.passed is None else [plot.passages(found), plot.residuals(found)],
            "Where robots stood": [] if found.stood is None else [plot.residuals(found, by="stood")],
            "Other days": [plot.real_day(found, number, title=found.days[number]) for number in others],
            "Method and reproducibility": [
                html.bullets(_METHOD),
                *([html.code(command)] if command else []),
            ],
        },
    )


def _said_of(found: Validation, number: int) -> str:
    """What the first figure shows, in words."""
    out = int(found.drops[number].out.sum())
    where = f"outside the band of the simulated days in {out} of its {len(found.drops[number].out)} parts"
    held = where if out else "wholly inside the band of the simulated days"
    besides = ", which lies out farthest of all" if len(found.days) > 1 else ""
    return f"Drops on the day {found.days[number]}{besides}: {held}."


def cells(found: Validation) -> list[list[str]]:
    """The rows of the table below `HEAD`, those farthest out first."""
    rows = []
    for row in sorted(found.rows(), key=lambda row: -abs(row.off)):
        meaning, _, kind = MEASURES[row.name]
        scale = words.scale_of_kind(kind, found.model, (row.real, row.simulated))
        name = words.with_unit(capital(meaning), "" if scale.is_share else scale.unit)
        high = min(row.high, 1.0) if scale.is_share else row.high
        band = f"{scale.bare(row.low)} to {scale.single(high)}"
        rows.append([name, scale.single(row.real), scale.single(row.simulated), band, row.verdict])
    return rows
