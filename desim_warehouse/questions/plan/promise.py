"""The promise of a plan, and notes on what it does not cover."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from desim_warehouse.answer import words
from desim_warehouse.answer.numbers import sentence
from desim_warehouse.answer.parts import Option
from desim_warehouse.errors import number_of
from desim_warehouse.model.facts.charging import without_charger
from desim_warehouse.questions import judged
from desim_warehouse.questions.plan import cells
from desim_warehouse.questions.plan.planned import Planned
from desim_warehouse.questions.sentences import not_tried
from desim_warehouse.study import rare
from desim_warehouse.study.fleet import Shown, Sized


def promise(planned: Planned) -> str:
    """Return the sentence on what holds with which confidence, and on the days that it covers."""
    plan = planned.plan
    judged_fleets = [fleet for sized in planned.demands for fleet in (sized.best, *sized.below) if fleet is not None]
    if judged_fleets and all(fleet.verdict.deterministic and not fleet.verdict.agrees for fleet in judged_fleets):
        return "Nothing in the model is left to chance, so each number above is exact."
    sure = f"{100 * plan.confidence:g} % confidence{' for each demand' * (planned.key is None)}"
    if plan.ended or planned.answered is None:
        return f"Each answer above holds with {sure}."
    most = [sized.most.up_to for sized in planned.demands if sized.most is not None]
    up_to = f", up to {number_of(min(most), 'robot')}" if most else ""
    is_ordered = all(sized.ordered for sized in planned.demands)
    alike = f" Assumption: a larger {planned.noun} never does worse{up_to}." if is_ordered else ""
    alike = f"{_covers(planned)}{alike}"
    if planned.yearly:
        alike += " A fleet that fails with less demand is assumed to fail with more."
    aim = "these targets" if plan.beside else "this target"
    return (
        f"With {sure}, the {planned.noun} shown to be enough reaches {planned.targets()}, "
        f"and no smaller {planned.noun} beats {aim} by {planned.zone()} or more{cells.but(plan)}.{alike}"
    )


def _covers(planned: Planned) -> str:
    """Return the sentence on how rare the days are that the runs of the named fleets cover."""
    named = [(sized, sized.best) for sized in planned.demands if sized.best is not None]
    least = min(best.verdict.least for _, best in named)
    if not least or any(best.verdict.deterministic for _, best in named):
        return ""
    models = [planned.model.replace({**sized.overrides, **best.overrides}) for sized, best in named]
    return f" {judged.covers(least, models)}"


def notes(planned: Planned, options: Sequence[Option]) -> list[str]:
    """Return notes on fleets that miss although their interval holds the target, and on what no run shows.

    These are closures and, beside a fleet that is enough, fleets that cannot be simulated, robots that are never
    charged, and batteries that end the day lower.
    """
    zone = words.amount(planned.goal.indicator, planned.plan.zone, planned.goal.unit)
    left_out = [line for sized in planned.demands if sized.best for line in not_tried(sized.not_tried)]
    flat = [line for sized in planned.demands if sized.best for line in _without_charger(planned, sized, sized.best)]
    return [
        *judged.holds_the_target(options, planned.goal, zone),
        *map(sentence, rare.closed(planned.model)),
        *dict.fromkeys(left_out),
        *dict.fromkeys(flat),
        *(words.batteries_end_lower(sized.best.lost) for sized in planned.demands if sized.best and sized.best.lost),
    ]


def _without_charger(planned: Planned, sized: Sized, best: Shown) -> Iterator[str]:
    """Yield a sentence for each kind of robots that no charger serves: its batteries last for the run alone."""
    made = planned.model.replace({**sized.overrides, **best.overrides})
    for kind, count in without_charger(made).items():
        robots = f"{number_of(count, 'robot')} of {f'kind {kind}' if kind else 'no kind'}"
        cure = "give bays for all robots some, or size a kind (desim size --key fleet.kinds.KIND.count)"
        yield f"With {planned.fleet(best.counts)}, no bay has a charger for {robots}: {cure}."
