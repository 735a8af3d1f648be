"""The work of pickers by the quick estimate: how often a task needs a picker, for how long, and how far they walk.

For `desim check`, if a model has pickers.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from functools import lru_cache

from desim_warehouse.feasibility.parts import PickerLoad
from desim_warehouse.layout.walking import walking_on, zones_of
from desim_warehouse.model import Model
from desim_warehouse.model.facts.demand import flow_rates, open_share
from desim_warehouse.model.sections.flows import StorageEnd
from desim_warehouse.model.sections.pickers import need_one
from desim_warehouse.values.distributions import mean_of

WALKS = 400
"""Number of sampled walks: they give a mean to about 3 %."""
MOST = 30
"""Largest number of pickers among whom the nearest is determined."""


@lru_cache(maxsize=64)
def picker_load(model: Model) -> PickerLoad | None:
    """Return the mean load that a task is for pickers; None without pickers."""
    pickers = model.pickers
    if pickers is None:
        return None
    stops = list(_stops(model))
    share = sum(part for part, _ in stops)
    pick = sum(part * time for part, time in stops) / share if share else 0.0
    each = max(round(pickers.count / pickers.zones), 1)
    walks = tuple(length / pickers.speed for length in _mean_walks(model, min(each, MOST)))
    waiting = max(round((model.fleet.size - pickers.count) / pickers.zones), 1)
    return PickerLoad(
        pickers.count,
        open_share(model, pickers.hours),
        share,
        pick,
        walks,
        in_duty=need_one(pickers, model.tasks.flows),
        crowded=_mean_walks(model, min(waiting, MOST))[-1] / pickers.speed,
    )


def _stops(model: Model) -> Iterator[tuple[float, float]]:
    """Yield for each kind of stop that needs a picker its mean number per task, and its time."""
    tasks, pickers = model.tasks, model.pickers
    if not tasks.flows:
        yield 1.0, mean_of(tasks.load_time)
        return
    rates = flow_rates(model)
    whole = sum(rates.values()) or 1.0
    for name, flow in tasks.flows.items():
        if pickers is None or not pickers.serves(name):
            continue
        loading, unloading = map(mean_of, tasks.handling_of(flow))
        for route in flow.routes:
            for end, time in ((route.source, loading), (route.target, unloading)):
                if isinstance(end, StorageEnd):
                    yield rates[name] / whole * route.share, time


def _mean_walks(model: Model, most: int) -> list[float]:
    """Return the mean distance from a place of a zone to the nearest of 1, 2, ... `most` other random places of it.

    All places are equally likely, with common random numbers for all models.
    """
    assert model.pickers is not None
    walking, zones = walking_on(model.floor), zones_of(model.floor, model.pickers.zones)
    draw = random.Random(1)  # noqa: S311 - a sample
    sums = [0.0] * most
    for rank in range(WALKS):
        spots = zones[rank % len(zones)]
        goal, nearest = draw.choice(spots), math.inf
        for number in range(most):
            nearest = min(nearest, walking.distance(draw.choice(spots), goal))
            sums[number] += nearest
    return [total / WALKS for total in sums]
