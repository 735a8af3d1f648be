"""What is said of directions that a search found."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of
from desim_warehouse.report.text import words
from desim_warehouse.report.text.numbers import Scale

if TYPE_CHECKING:
    from desim_warehouse.study.designs.directions import BetterDirections, DirectionGain


def sentences(found: BetterDirections) -> list[str]:
    """The answer: what is turned, what that gains on fresh days, for which fleets and demands it holds, its price."""
    if found.gain is None:
        return [f"No better directions found than those drawn, in {number_of(found.runs, 'run')}."]
    verdict = {True: "", False: ", which is worse", None: ", which may be chance"}[found.gain.is_better]
    name = words.indicator_name(found.indicator)
    gains = f"{name}: {_gain(found.gain)} in {found.gain.pairs} pairs of runs on fresh days"
    lines = [f"{len(found.turned)} of {found.units} turned: {'; '.join(found.turned)}.", f"{gains}{verdict}."]
    for is_better, said in ((True, "It holds"), (None, "It may be chance"), (False, "It is worse")):
        places = [f"{one.where}, {_gain(one)}" for one in found.elsewhere if one.is_better is is_better]
        if places:
            lines.append(f"{said} with {'; '.join(places)}.")
    if found.cost:
        lines.append(f"Turning costs {Scale(words.money(found.model)).value(found.cost)} once.")
    return lines


def _gain(gain: DirectionGain) -> str:
    low, mean, high = (
        f"{100 * share:+.1f}".replace("-", "\N{MINUS SIGN}") for share in (gain.low, gain.mean, gain.high)
    )
    return f"{mean} % ({low} to {high})"
