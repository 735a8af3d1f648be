"""The demand of a model: at which rates tasks arrive, and from which storage places they fetch."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

from desim_warehouse.layout import Layout
from desim_warehouse.model.facts.places import place_shares
from desim_warehouse.model.schema import Model, reading
from desim_warehouse.model.sections.flows import FlowSpec, OrdersArrivals, SaturatedArrivals, StorageEnd, mean_rate
from desim_warehouse.model.sections.goods import Good, PoissonGoods, SaturatedGoods
from desim_warehouse.model.sections.orders import Summary, files_of, summary


def arrival_rate(model: Model) -> float | None:
    """Return the tasks per time unit that arrive on average; None where the work is a list, or all that can be done."""
    tasks, hour = model.tasks, model.units.hour
    if isinstance(tasks.goods, PoissonGoods):
        return tasks.goods.poisson * tasks.demand / hour * open_share(model, tasks.goods.hours)
    if all(isinstance(flow.when, SaturatedArrivals) for flow in tasks.flows.values()):
        return None
    return math.fsum(flow_rates(model).values()) / hour


def due_within(model: Model) -> float | None:
    """Return the time from release to due, the least of all flows; None where no task is due so."""
    times: list[float | None] = [flow.due_within for flow in model.tasks.flows.values()]
    times.append(getattr(model.tasks.goods, "due_within", None))
    return min((time for time in times if time is not None), default=None)


def listed(model: Model) -> list[int]:
    """Return the storage places of the tasks of the list, in its order; none for drawn goods."""
    goods = model.tasks.goods
    return [item.good if isinstance(item, Good) else item for item in goods] if isinstance(goods, tuple) else []


def demand(model: Model, layout: Layout) -> Any:
    """Return each storage place's share of all tasks, of flows its share of their visits to storage: a numpy array."""
    import numpy as np

    goods, size = model.tasks.goods, len(layout.storage)
    if isinstance(goods, tuple):
        return np.bincount(listed(model), minlength=size) / len(goods)

    def drawn(end: StorageEnd | None) -> Any:
        drawn_shares = place_shares(model, layout, end)
        return np.full(size, 1 / size) if drawn_shares is None else drawn_shares

    if goods is not None:
        return drawn(None)
    rates = {} if always_open(model) else flow_rates(model)
    visits = np.zeros(size)
    for name, flow in model.tasks.flows.items():
        for route in flow.routes:
            for end in (route.source, route.target):
                if isinstance(end, StorageEnd):
                    visits += route.share * rates.get(name, 1.0) * drawn(end)
    return visits / (visits.sum() or 1.0)


def flow_rates(model: Model) -> dict[str, float]:
    """Return the tasks an hour of each flow, 0 for flows always open; if all are, how many tasks of each are open."""
    flows, hour = model.tasks.flows, model.units.hour
    length = asked_until(model)
    rates = {
        name: _rate_of_orders(model, flow, length)
        if isinstance(flow.when, OrdersArrivals)
        else mean_rate(flow, length, hour, model.run.start, model.hours(flow.hours)) or 0.0
        for name, flow in flows.items()
    }
    if any(rates.values()):
        return {name: rate * model.tasks.demand for name, rate in rates.items()}
    return {
        name: float(flow.when.saturated) for name, flow in flows.items() if isinstance(flow.when, SaturatedArrivals)
    } or dict.fromkeys(flows, 1.0)


def always_open(model: Model) -> bool:
    """Whether some tasks are always open, so that robots never rest."""
    tasks = model.tasks
    arrivals = (tasks.goods, *(flow.when for flow in tasks.flows.values()))
    return any(isinstance(when, SaturatedGoods | SaturatedArrivals) for when in arrivals)


def order_files(model: Model) -> list[Summary]:
    """Return the contents of the files of orders of a model, summed up."""
    files = files_of(model.tasks.flows)
    how = reading(model, model.floor) if files else None
    return [summary(file, how) for file in files if how is not None]


def orders_of(model: Model, flow: FlowSpec) -> Summary:
    """Return the contents of the file of a flow's orders, summed up."""
    assert isinstance(flow.when, OrdersArrivals)
    return summary(flow.when.orders, reading(model, model.floor))


def _rate_of_orders(model: Model, flow: FlowSpec, length: float) -> float:
    """Return the tasks an hour of a file of orders; of a file beyond the run, the mean rate of the whole file."""
    orders = orders_of(model, flow)
    return orders.tasks / max(length, orders.last) * model.units.hour


def last_release(model: Model) -> float:
    """Return when the last task of a list, of schedules and of files is released; 0 where all are at once."""
    goods, flows = model.tasks.goods, model.tasks.flows.values()
    times = [item.release for item in goods if isinstance(item, Good)] if isinstance(goods, tuple) else []
    times += [batch.at for flow in flows for batch in getattr(flow.when, "schedule", ())]
    times += [orders_of(model, flow).last for flow in flows if isinstance(flow.when, OrdersArrivals)]
    return max(times, default=0.0)


@lru_cache(maxsize=64)
def asked_until(model: Model) -> float:
    """Return the time over which demand and hours are averaged, in time units: the run's length, inf for a mere list.

    Flows without a length are asked for until the last release, or for an hour where all tasks are at once. Robots,
    stations and pickers that have not been open for as long by then work on until they have, or until they close.
    """
    if model.run.length is not None or not model.tasks.flows:
        return model.run.end
    last = last_release(model) or model.units.hour
    names = [*model.fleet.hours_of_robots(), *(station.hours for station in model.layout.stations.values())]
    names += [] if model.pickers is None else [model.pickers.hours]
    calendars = [model.hours(name) for name in dict.fromkeys(names)]
    done = [min(hours.when_open(last), hours.following(last)[1]) for hours in calendars]
    return max([last, *filter(math.isfinite, done)])


def open_share(model: Model, calendar: str | None) -> float:
    """Return the share of the time over which demand is averaged in which a calendar, None for always, is open."""
    return model.hours(calendar).share(0.0, asked_until(model))
