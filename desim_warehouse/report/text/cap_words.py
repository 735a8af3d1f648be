"""What a cap on the robots under way gives, in a sentence."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of
from desim_warehouse.report.text import words
from desim_warehouse.study.fleet.capped import KEY

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.study.fleet.capped import Capped


def capped(found: Capped, model: Model | None) -> str:
    """What a cap on the robots under way gives."""
    scale_of = words.scale(found.indicator, model, (found.mean,))
    gain, is_now = found.gain, f"{words.in_sentence(found.indicator)} is {scale_of.value(found.mean)}"
    ends = "" if gain.low == gain.high else f" ({scale_of.bare(gain.low)} to {scale_of.bare(gain.high)})"
    return (
        f"With at most {found.cap} of {number_of(found.robots, 'robot')} under way {is_now}: better by "
        f"{scale_of.value(gain.mean)}{ends}; desim size --key {KEY} finds the best cap"
    )
