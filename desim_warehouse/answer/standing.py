"""Standings of options, with the words for terminal, pages, files and the live page.

For the options of `desim plan`, `best`, `size`, `what-if` and `serve`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Literal, Protocol

from desim_warehouse.answer import numbers, words
from desim_warehouse.model import Model
from desim_warehouse.outcome.verdicts import PILES_UP, Verdict

Standing = Literal[
    "met",
    "not met",
    "open",
    "edge",
    "overloaded",
    "drained",
    "fails",
    "untried",
    "known",
    "best",
    "perhaps",
    "less",
    "same",
    "apart",
    "first",
    "near",
    "worse",
    "differs",
    "alike",
]
WORDS: dict[Standing, str] = {
    "met": "met",
    "not met": "not met",
    "open": "needs more runs",
    "edge": "on the edge",
    "overloaded": "cannot keep up",
    "drained": "cannot last",
    "fails": "runs fail",
    "untried": "not tried",
    "known": "",
    "best": "helps most",
    "perhaps": "needs more runs",
    "less": "helps less",
    "same": "no effect",
    "apart": "not ranked",
    "first": "best",
    "near": "as good",
    "worse": "worse",
    "differs": "differs",
    "alike": "not shown to differ",
}
"""Words for standings. `edge`: so close to the target (in the indifference zone) that no number of runs will decide."""
BY_VERDICT: dict[str, Standing] = {"meets": "met", "fails": "not met", "undecided": "open"}


DELIVERED = "an hour delivered"
"""The end of the text on what an option delivers, and so on its throughput."""
_SHORT = re.compile(r"^not settled: |( in the counted time)?(;|: not sustainable).*$")
"""The parts of a verdict that a row omits."""


class Judged(Protocol):
    """A verdict on a design, as the judge of a search returns it."""

    @property
    def verdict(self) -> str:
        """The verdict: `meets`, `fails` or `undecided`."""

    @property
    def within_zone(self) -> bool:
        """Whether the mean is in the target's indifference zone, so that no number of runs will decide."""


def standing(judged: Judged) -> Standing:
    """Return the standing of a design with respect to a target, such as met or not met.

    A design that cannot last in the long run has another standing (`lasts_not`).
    """
    return "edge" if judged.within_zone else BY_VERDICT[judged.verdict]


def lasts_not(wrong: Iterable[Verdict]) -> Standing | None:
    """Return the standing of a design that cannot last in the long run; None if no verdict says so."""
    codes = [verdict.code for verdict in wrong if verdict.is_lasting]
    return "overloaded" if PILES_UP in codes else "drained" if codes else None


def instead(wrong: Iterable[Verdict], model: Model) -> str:
    """Describe an option that cannot last by what it delivered of what came, never by its share on time."""
    lasting = [verdict for verdict in wrong if verdict.is_lasting]
    for verdict in lasting:
        if math.isfinite(verdict.delivered):
            done, came = numbers.measured(verdict.delivered), numbers.measured(verdict.came)
            return f"only {done} of {came} {words.loads(model)} {DELIVERED}"
    return ", and ".join(_SHORT.sub("", verdict.text) for verdict in lasting)
