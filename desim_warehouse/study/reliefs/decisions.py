"""Decisions of the model that may hold a warehouse up: policies, and how often and for how many robots they decide.

Idle robots are no sign that charging cannot matter: below a threshold of 85 % they stand idle waiting for a charger.
Several policies are one suspect, as of two good ones neither would ever be shown to be better. What batches cost is
read from rows of their own, written when they are made: the release of the last task of a tour is wrong for a time
window, and for batches that wait for a robot.
"""

from __future__ import annotations

from collections.abc import Iterator

from desim_warehouse.model import Model
from desim_warehouse.outcome.account import UNTAKEN, share_of_tasks
from desim_warehouse.policies import catalogue
from desim_warehouse.run import Run
from desim_warehouse.states import Phase, names
from desim_warehouse.study.fleet.capped import KEY
from desim_warehouse.study.reliefs.suspect import MOST_UNTAKEN, Suspect

LEAST_CHARGING = 0.05
"""Part of the fleet's time on chargers from which the charging policy is looked at, where tasks wait for robots."""


def decisions(run: Run) -> Iterator[Suspect]:
    """Each decision with another in its place."""
    model = run.model
    if model.policies.batching.name != "single":
        yield Suspect("batching", "every task by itself", {"policies.batching": "single"})
    if model.policies.interval:
        yield Suspect("the interval of decisions", "decisions at once", {"policies.interval": 0})
    if model.traffic.most_out is not None:
        yield Suspect("the cap on robots under way", "no cap on robots under way", {KEY: None})
    charging = sum(run.kpis[f"share_{name}"] for name in names(lambda state: state.phase is Phase.CHARGING))
    if charging >= LEAST_CHARGING and share_of_tasks(run.history, *UNTAKEN) > MOST_UNTAKEN:
        yield from _charging(model)


def _charging(model: Model) -> Iterator[Suspect]:
    """The other built-in policies as they are by default, and the model's own without its parameters."""
    own, battery = model.policies.charging, model.battery
    for name in catalogue.OURS["charging"]:
        if name == own.name and not own.params:
            continue
        threshold = battery is not None and "threshold" in battery.model_fields_set
        if catalogue.problems("charging", name, {}) or (catalogue.reads_threshold(name, {}) and not threshold):
            continue  # it has no defaults
        yield Suspect("the charging policy", f"charging by {name}", {"policies.charging": name})
