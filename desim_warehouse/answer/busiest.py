"""Who was at work for the largest part of a run, in the one sentence that the terminal, reports and the replay have."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from desim_warehouse.answer import numbers
from desim_warehouse.answer.numbers import capital
from desim_warehouse.outcome.resources import busy_share, servers_in_use, standing
from desim_warehouse.states import staff

if TYPE_CHECKING:
    from collections.abc import Mapping

    from desim_warehouse.outcome.history import History

CHARGERS = "chargers"
_USED = {
    "robots": "the robots were the busiest, at work",
    CHARGERS: "the chargers were the busiest, in use",
    "workers": "the workers were the busiest, at work",
}


class Busiest(NamedTuple):
    """What was busiest, `robots`, `chargers`, `workers` or a group of stations, and the share of its time."""

    name: str
    share: float

    @property
    def sentence(self) -> str:
        """It in words, with a capital letter and a full stop."""
        who = _USED.get(self.name, f"the {staff(self.name)}s of {self.name} were the busiest, in use")
        return f"{capital(who)} {numbers.PERCENT.value(self.share)} of the time."


def busiest(history: History, kpis: Mapping[str, float]) -> Busiest | None:
    """Compare robots, chargers, workers and the servers of each group of stations; None where no time was counted."""
    model = history.model
    used = {
        "robots": busy_share([kpis[name] for name in standing(model)], kpis.get("share_on_break", 0.0)),
        CHARGERS: kpis.get("charger_utilisation", math.nan),
        "workers": kpis.get("worker_utilisation", math.nan),
        **servers_in_use(history),
    }
    known = {name: share for name, share in used.items() if math.isfinite(share)}
    if not known:
        return None
    name = max(known, key=known.__getitem__)
    return Busiest(name, known[name])
