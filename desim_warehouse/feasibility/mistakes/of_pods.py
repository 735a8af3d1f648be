"""Goods to person: keys that nothing reads there, stock that runs out, and pods that are in each other's way."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of
from desim_warehouse.feasibility.pods import stations_of
from desim_warehouse.findings import Finding, amount
from desim_warehouse.model.facts.demand import end_of_schedule, flow_rates
from desim_warehouse.model.sections.flows import StorageEnd
from desim_warehouse.values.fields import parts_in

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.feasibility.estimate import QuickEstimate
    from desim_warehouse.feasibility.pods import PileOn
    from desim_warehouse.model import Model

TO_SPARE = 2
"""Pods bound for a picker beyond those that keep it busy, which even out that they come at random."""


def warnings(model: Model, found: QuickEstimate) -> Iterator[Finding]:
    """What is probably a mistake in a model with pods; `found`: its quick estimate, by line."""
    if found.pile_on is None:
        return
    yield from _not_read(model)
    yield from _stock(model, found)
    yield from _robots(model, found, found.pile_on)


def _not_read(model: Model) -> Iterator[Finding]:
    """What a model of single loads would look at."""
    popularity = "pods.popularity: which items are asked for"
    if model.tasks.popularity != "uniform":
        text = "with pods a line asks for an item, not for a storage place"
        yield Finding("CHANGES_NOTHING", "tasks.popularity", text, popularity)
    for place, end in parts_in(model.tasks, (StorageEnd,)):
        if isinstance(end, StorageEnd) and end.popularity is not None:
            yield Finding("CHANGES_NOTHING", f"tasks.{place}.popularity", "with pods no place is drawn", popularity)
    if model.fleet.largest_capacity > 1:
        yield Finding("CHANGES_NOTHING", "fleet.robot.capacity", "a robot carries one pod at a time", "leave it out")


def _stock(model: Model, found: QuickEstimate) -> Iterator[Finding]:
    """More of an item is picked in the run than pods hold of it and get."""
    pods, rates = model.pods, flow_rates(model)
    assert pods is not None
    there = pods.units
    if there is None or not found.rate:
        return
    flows, hours = model.tasks.flows.items(), (model.run.length or end_of_schedule(model)) / model.units.hour
    taken = sum(-pods.bundle * rates[n] if isinstance(flow.target, StorageEnd) else rates[n] for n, flow in flows)
    asked = taken * hours * pods.item_shares
    worst = int((asked - there).argmax())
    if asked[worst] > there[worst]:
        name = pods.names[worst] if pods.names else worst
        text = f"in this run {amount(asked[worst])} units of item {name} are picked beyond what is put onto pods, "
        text += f"which hold about {amount(there[worst])}: lines will wait without end"
        yield Finding("STOCK_RUNS_OUT", "pods.stock", text, "more stock, or a flow to storage that brings as much")


def _robots(model: Model, found: QuickEstimate, pile: PileOn) -> Iterator[Finding]:
    """Fewer robots than stations; pods that queue in no time; more pods at a station than keep its pickers busy."""
    nodes = {node for flow in model.tasks.flows.values() for node in stations_of(flow)}
    robots, stations = model.fleet.size, model.floor.stations
    if robots < len(nodes):
        text = f"{number_of(robots, 'robot')} for {number_of(len(nodes), 'station')}: some always wait for a pod"
        yield Finding("MORE_THAN_FIT", "fleet.size", text, "more robots, or fewer nodes in `to`")
    each = robots / len(nodes)
    zone = {node: f"layout.stations.{stations[node].zone}.places" for node in nodes}
    if not pile.change and each > 1 and any(stations[node].places > 1 for node in nodes):
        text = "pods queue at stations, and the next is in front of the picker in no time"
        yield Finding("UNUSUAL", "pods.change_time", text, "about 5 s, or what you measure")
    driving = (found.cycle.time - pile.pick) * pile.most - pile.change
    kept = 1 + driving / (pile.pick * pile.random + pile.change) if pile.pick else math.inf
    busy = found.rate is None or found.rate * pile.pick > pile.servers / 2
    for node in sorted(nodes) if busy else ():
        item = stations[node]
        bound, enough = min(item.places, each) / item.servers, math.ceil(kept) + TO_SPARE
        if bound > enough:
            text = f"up to {amount(bound)} pods are there or on their way for each picker, and {enough} keep it busy: "
            text += "each has fewer lines then, and fewer lines an hour may be done"
            yield Finding("PODS_QUEUE", zone[node], text, f"{enough * item.servers} places, or fewer robots")
            return
