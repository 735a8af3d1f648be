"""The page of a validation, with the verdict, real days over the band of simulated days, and maps of the floor."""

from __future__ import annotations

from desim_warehouse import plot
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.page import page as page_of
from desim_warehouse.answer.parts import BigNumber, Folded
from desim_warehouse.fleet_log.validate import HEAD, Validation
from desim_warehouse.plot.days import farthest

_METHOD = (
    "Each real day is simulated many times, and measured from the same messages by the same code.",
    "All measures count at once: a right model is refuted on at most one day in twenty. Not refuted is no proof.",
    "Measures alone decide. Figures show where to look: the band of each holds all of a right day on 95 of 100 days.",
)


def page(validation: Validation, command: str = "") -> str:
    """Compose the page of a validation of a model against real days, as HTML; `command` repeats the validation."""
    days = len(validation.days)
    worst = farthest(validation)
    others = [number for number in range(days) if number != worst]
    first = "The day that lies out farthest" if others else "The day"
    drops = [plot.real_day(validation, worst)]
    driven = [] if validation.passed is None else [plot.passages(validation), plot.residuals(validation)]
    drawings = {
        first: drops,
        "Where robots drove": driven,
        "Where robots stood": [] if validation.stood is None else [plot.residuals(validation, by="stood")],
        "Other days": [plot.real_day(validation, number, title=validation.days[number]) for number in others],
    }
    answer = Answer(
        kind="validate",
        name=validation.model.name,
        question=f"Do {days} real days refute this model?" if days > 1 else "Does a real day refute this model?",
        answer=tuple(capital(f"{line}.") for line in validation.lines()),
        tiles=(
            BigNumber(
                value="refuted" if validation.refuted else "not refuted",
                what="Verdict",
                note=f"p = {validation.measures.p_value:.2g}",
            ),
            BigNumber(
                value=f"{len(validation.outside)} of {len(validation.names)}",
                what="Measures outside",
                note="even a correct model shows one on 1 day in 20",
            ),
        ),
        tables=(
            Folded(title=first, note=_in_words(validation, worst), printed=True),
            Folded(title="Measures", head=HEAD, rows=tuple(validation.cells()), numbers=True, printed=True),
            *(Folded(title=title) for title in drawings if title != first),
        ),
        notes=_METHOD,
        runs=0,
        confidence=None,
        command=command,
    )
    return page_of(answer, drawings)


def _in_words(validation: Validation, number: int) -> str:
    """Describe the figure of a day: the number of parts of the day in which drops are outside the simulated band."""
    out = int(validation.drops[number].out.sum())
    where = f"outside the band of the simulated days in {out} of its {len(validation.drops[number].out)} parts"
    held = where if out else "wholly inside the band of the simulated days"
    besides = ", which lies out farthest of all" if len(validation.days) > 1 else ""
    return f"Drops on the day {validation.days[number]}{besides}: {held}."
