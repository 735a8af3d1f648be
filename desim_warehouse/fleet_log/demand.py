"""Demand on a fleet: picks by hour and by place, or orders as they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from desim_warehouse.fleet_log.estimates import KeyEstimate, poisson_interval, short, unknown
from desim_warehouse.fleet_log.floor import Tracks
from desim_warehouse.fleet_log.handling import episodes
from desim_warehouse.fleet_log.table import PICK, FleetLog
from desim_warehouse.model import Model
from desim_warehouse.model.facts.places import place_shares
from desim_warehouse.model.overrides import UNSET
from desim_warehouse.model.sections.goods import PoissonGoods
from desim_warehouse.values.calendars import clock_of

HOUR = 3600.0
DAY_HOURS = 24
_SURE = 0.001
"""A p-value below which demand is taken to change from hour to hour, or places to differ from what the model says."""
_NEAR = 1e-3
FLOW = "orders"
"""Name of the flow that takes the place of goods."""


def demand(model: Model, logs: Sequence[FleetLog], tracks: Tracks | None) -> list[KeyEstimate]:
    """Estimate the tasks an hour, whether their rate changes over the day, and the popularity of storage places."""
    goods = model.tasks.goods
    if not isinstance(goods, PoissonGoods):
        return [unknown("tasks", "demand is given as it is; --orders takes it from the WMS")]
    times = [_begins(log) for log in logs]
    n, hours = sum(map(len, times)), sum(log.length for log in logs) / HOUR
    low, high = (bound / hours for bound in poisson_interval(n))
    key, rate = "tasks.goods.poisson", n / hours
    estimates = [KeyEstimate(key, short(rate), rate, low, high, n, "picks", "as far as the fleet kept up")]
    by_hour = _by_hour(times, logs)
    if _changes(*by_hour):
        picks, lasted = by_hour
        rates = [short(float(rate)) for rate in picks / np.maximum(lasted, 1e-9)]
        value = {"profile": {"per_hour": _by_clock(rates, model.run.start)}}
        why = f"from {min(rates):g} to {max(rates):g} an hour over the day"
        estimates = [KeyEstimate(f"tasks.flows.{FLOW}.arrivals", value, rate, low, high, n, "picks", why)]
    return [*estimates, *([] if tracks is None else [_popularity(tracks)])]


def _by_clock(rates: list[float], start: str) -> list[float]:
    """Return the rates of the hours of a log; a whole day is turned to begin at midnight, as profiles do."""
    late = round(clock_of(start) / HOUR)
    return rates[-late:] + rates[:-late] if late and len(rates) == DAY_HOURS else rates


def _begins(log: FleetLog) -> Any:
    """Return times at which picks began, in seconds from the begin of the log."""
    table = log.table
    new = np.diff(table["robot"], prepend=-1) != 0
    pick = table["action"].to_numpy() == PICK
    begins = pick if not log.step else pick & ~new & ~np.concatenate([[True], pick[:-1]])
    return table["time"].to_numpy()[begins]


def _by_hour(times: Sequence[Any], logs: Sequence[FleetLog]) -> tuple[Any, Any]:
    """Count the picks in each hour of the logs, and the hours of log that cover it."""
    most = math.ceil(max(log.length for log in logs) / HOUR)
    marks = np.arange(most + 1) * HOUR
    picks = sum(np.histogram(instants, marks)[0] for instants in times)
    lasted = sum(np.clip(log.length - marks[:-1], 0, HOUR) / HOUR for log in logs)
    return picks, lasted


def _changes(picks: Any, lasted: Any) -> bool:
    """Whether the rate changes from hour to hour (chi-square test; the first hour of a log counts, too)."""
    from scipy.stats import chi2

    expected = picks.sum() * lasted / lasted.sum()
    enough = expected >= 5  # noqa: PLR2004 - of the chi-square test
    if enough.sum() < 2:  # noqa: PLR2004
        return False
    statistic = float((((picks - expected) ** 2) / np.maximum(expected, 1e-9))[enough].sum())
    return float(chi2.sf(statistic, int(enough.sum()) - 1)) < _SURE


def _popularity(tracks: Tracks) -> KeyEstimate:
    """Estimate the weights of storage places: picks at each, smoothed by the model's shares as a prior."""
    from scipy.stats import chi2

    key, layout = "tasks.popularity", tracks.model.floor
    if not layout.storage:
        return unknown(key, "the layout has no storage places")
    picked = episodes(tracks, tracks.action == PICK)
    spots = (tracks.x + 1j * tracks.y)[picked.first]
    spots = spots[np.isfinite(spots)]
    if not len(spots):
        return unknown(key, "the log does not say where robots picked")
    stops = np.array([complex(*layout.position(place.edge, place.offset)) for place in layout.storage])
    kinds, inverse = np.unique(np.round(stops / _NEAR), return_inverse=True)
    picks = np.bincount(np.abs(spots[:, None] - kinds[None, :] * _NEAR).argmin(axis=1), minlength=len(kinds))
    prior = place_shares(tracks.model, layout)
    prior = np.full(len(stops), 1 / len(stops)) if prior is None else prior
    expected = np.bincount(inverse, prior)
    off = float((((picks - expected * len(spots)) ** 2)[expected > 0] / (expected * len(spots))[expected > 0]).sum())
    elsewhere = picks[expected == 0].sum() > 0
    if not elsewhere and float(chi2.sf(off, max(int((expected > 0).sum()) - 1, 1))) >= _SURE:
        return unknown(key, f"{len(spots):,} picks at {len(kinds)} stops agree with the model", len(spots), "picks")
    part = prior / np.maximum(expected[inverse], 1e-12)
    part = np.where(expected[inverse] > 0, part, 1 / np.bincount(inverse)[inverse])
    weights = picks[inverse] * part + prior * len(stops)
    value = {"weights": [short(float(weight)) for weight in weights]}
    why = f"{len(spots):,} picks at {len(kinds)} stops, and the model's own shares as the prior"
    return KeyEstimate(key, value, math.nan, math.nan, math.nan, len(spots), "picks", why)


def as_flow(model: Model, arrivals: dict[str, Any]) -> dict[str, Any]:
    """Return overrides that replace the goods of a model by a flow with these arrivals."""
    tasks = model.tasks.content()
    flows = tasks.get("flows")
    if flows:
        named = [name for name, flow in flows.items() if "orders" in (flow.get("arrivals") or {})]
        return {f"tasks.flows.{(named or list(flows))[0]}.arrivals": arrivals}
    flow: dict[str, Any] = {"from": "storage", "to": list(tasks["unload_at"]), "arrivals": arrivals}
    goods = tasks.get("goods")
    if isinstance(goods, dict):
        flow |= {key: goods[key] for key in ("due_within", "hours") if goods.get(key) is not None}
    return {"tasks.goods": UNSET, "tasks.unload_at": UNSET, f"tasks.flows.{FLOW}": flow}


def as_they_are(model: Model, orders: Path) -> dict[str, Any]:
    """Return overrides by which a model takes its orders from a file."""
    return as_flow(model, {"orders": {"file": str(orders.resolve())}})
