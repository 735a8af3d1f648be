"""What an option was shown to be: one list of words for terminal, pages, files and the live page."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Literal, Protocol

from desim_warehouse.answer import numbers
from desim_warehouse.model import Model
from desim_warehouse.model.facts.demand import arrival_rate
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
"""What an option was shown to be, for people. `edge`: better than the target by so little that no run will tell."""
BY_VERDICT: dict[str, Standing] = {"meets": "met", "fails": "not met", "undecided": "open"}


_SHORT = re.compile(r"^not settled: |( while counted)?(;|: not sustainable).*$")
"""What is left out of a verdict in a row."""


class Judged(Protocol):
    """A verdict on a design."""

    @property
    def verdict(self) -> str:
        """Meets, fails or undecided."""

    @property
    def within_zone(self) -> bool:
        """Whether no run will tell."""


def standing(judged: Judged, wrong: Iterable[Verdict] = ()) -> Standing:
    """What a design was shown to be beside a target; `wrong`: verdicts on it, of which those that last count first."""
    lasting = lasts_not(wrong)
    if lasting is not None:
        return lasting
    return "edge" if judged.within_zone else BY_VERDICT[judged.verdict]


def lasts_not(wrong: Iterable[Verdict]) -> Standing | None:
    """Why the time to come is worse than the time simulated; None: it is not."""
    codes = [one.code for one in wrong if one.is_lasting]
    return "overloaded" if PILES_UP in codes else "drained" if codes else None


def instead(wrong: Iterable[Verdict], done: float | None, model: Model) -> str:
    """What is said of an option that cannot last: what it delivers (`done` an hour), never how much of that in time."""
    lasting = [one for one in wrong if one.is_lasting]
    rate = arrival_rate(model)
    asked = math.inf if rate is None else rate * model.units.hour
    if done is not None and done < asked and any(one.code == PILES_UP for one in lasting):
        of = "" if asked == math.inf else f" of {numbers.measured(asked)}"
        return f"only {numbers.measured(done)}{of} orders an hour delivered"
    return ", and ".join(_SHORT.sub("", one.text) for one in lasting)
