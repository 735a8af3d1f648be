"""The page of real days held against a model: the verdict, a day over the simulated ones, and the floor by edges."""

from __future__ import annotations

from desim_warehouse import plot
from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.page import page as page_of
from desim_warehouse.answer.parts import BigNumber, Folded
from desim_warehouse.fleet_log.measures import MEASURES
from desim_warehouse.fleet_log.validate import Validation
from desim_warehouse.plot.days import farthest

_METHOD = (
    "Each real day is simulated many times, and measured from the same messages by the same code.",
    "All measures count at once: a right model is refuted on at most one day in twenty. Not refuted is no proof.",
    "Measures alone decide. Figures show where to look: the band of each holds all of a right day on 95 of 100 days.",
)
HEAD = ("Measure", "Real", "Simulated", "Band", "Verdict")


def page(found: Validation, command: str = "") -> str:
    """Compose the page of real days held against a model; `command` is the line that repeats it."""
    days = len(found.days)
    worst = farthest(found)
    others = [number for number in range(days) if number != worst]
    first = "The day that lies out farthest" if others else "The day"
    drawings = {
        first: [plot.real_day(found, worst)],
        "Where robots drove": [] if found.passed is None else [plot.passages(found), plot.residuals(found)],
        "Where robots stood": [] if found.stood is None else [plot.residuals(found, by="stood")],
        "Other days": [plot.real_day(found, number, title=found.days[number]) for number in others],
    }
    answer = Answer(
        kind="validate",
        name=found.model.name,
        question=f"Do {days} real days refute this model?" if days > 1 else "Does a real day refute this model?",
        answer=tuple(capital(f"{line}.") for line in found.lines()),
        tiles=(
            BigNumber(
                value="refuted" if found.refuted else "not refuted",
                what="Verdict",
                note=f"p = {found.measures.p_value:.2g}",
            ),
            BigNumber(
                value=f"{len(found.outside)} of {len(found.names)}",
                what="Measures outside",
                note="even a correct model shows one on 1 day in 20",
            ),
        ),
        tables=(
            Folded(title=first, note=_said_of(found, worst), printed=True),
            Folded(title="Measures", head=HEAD, rows=tuple(cells(found)), numbers=True, printed=True),
            *(Folded(title=title) for title in drawings if title != first),
        ),
        notes=_METHOD,
        runs=0,
        confidence=None,
        command=command,
    )
    return page_of(answer, drawings)


def _said_of(found: Validation, number: int) -> str:
    """What the first figure shows, in words."""
    out = int(found.drops[number].out.sum())
    where = f"outside the band of the simulated days in {out} of its {len(found.drops[number].out)} parts"
    held = where if out else "wholly inside the band of the simulated days"
    besides = ", which lies out farthest of all" if len(found.days) > 1 else ""
    return f"Drops on the day {found.days[number]}{besides}: {held}."


def cells(found: Validation) -> list[tuple[str, ...]]:
    """The rows of the table below `HEAD`, those farthest out first."""
    rows: list[tuple[str, ...]] = []
    for row in sorted(found.rows(), key=lambda row: -abs(row.off)):
        meaning, _, kind = MEASURES[row.name]
        scale = words.scale_of_kind(kind, found.model, (row.real, row.simulated))
        name = words.with_unit(capital(meaning), "" if scale.is_share else scale.unit)
        high = min(row.high, 1.0) if scale.is_share else row.high
        band = f"{scale.bare(row.low)} to {scale.single(high)}"
        rows.append((name, scale.single(row.real), scale.single(row.simulated), band, row.verdict))
    return rows
