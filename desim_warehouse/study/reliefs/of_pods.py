"""What may hold goods to person up beside robots and pickers: how pods are changed, called and filled."""

from __future__ import annotations

import math
from collections.abc import Iterator

from desim_warehouse.feasibility.pods import stations_of
from desim_warehouse.model import Model
from desim_warehouse.policies import catalogue
from desim_warehouse.study.reliefs.suspect import DOSE, Suspect
from desim_warehouse.values.distributions import scaled

HALF = 0.5
DECISIONS = {"pod": "pods called by", "order_station": "orders to stations by"}
"""Those by which lines of a visit are many or few; where pods are stored hardly moves them."""


def of_pods(model: Model) -> Iterator[Suspect]:
    """Reliefs of a model with pods, none of another. Robots do not wait for any of them."""
    pods = model.pods
    if pods is None:
        return
    if pods.change_time:
        half = {"pods.change_time": HALF * pods.change_time}
        yield Suspect("the change of pods", "pods changed in half the time", half, dose=-HALF)
    flows = {name: flow for name, flow in model.tasks.flows.items() if "." not in name}
    shorter = {
        f"tasks.flows.{name}.stop_time": scaled(flow.stop_time, 1 - DOSE)
        for name, flow in flows.items()
        if flow.stop_time
    }
    if shorter:
        yield Suspect("picking", "a line picked in a tenth less time", shorter, dose=-DOSE, beside=True)
    if pods.orders:
        more = _tenth(pods.orders)
        relief = f"{more - pods.orders} more of {pods.orders} orders at each station"
        yield Suspect("orders at the stations", relief, {"pods.orders": more}, dose=more / pods.orders - 1)
    if pods.holds is None:
        more = _tenth(pods.per_pod)
        relief = f"{more - pods.per_pod} more of {pods.per_pod} items on each pod"
        yield Suspect("what pods hold", relief, {"pods.per_pod": more}, dose=more / pods.per_pod - 1)
    if pods.stock is not None:
        yield Suspect("stock", "stock without end", {"pods.stock": None})
    yield from _fewer_places(model)
    for kind, words in DECISIONS.items():
        now = model.policies.of_pods(kind).name
        for name in catalogue.OURS[kind]:
            if name not in {now, "random"}:
                yield Suspect(f"policies.{kind}", f"{words} {name}", {f"policies.{kind}": name})


def _tenth(count: int) -> int:
    return math.ceil(count * (1 + DOSE))


def _fewer_places(model: Model) -> Iterator[Suspect]:
    """Fewer pods at a time at the stations, each for more lines, down to one that is picked and one that comes."""
    layout = model.floor
    used = [layout.stations[node] for flow in model.tasks.flows.values() for node in stations_of(flow)]
    least = {item.zone: item.places - 1 for item in used if item.places - 1 > item.servers and "." not in item.zone}
    if least:
        fewer = {f"layout.stations.{zone}.places": places for zone, places in least.items()}
        dose = -1 / max(least.values())
        yield Suspect("pods at the stations", "one place fewer at each node of the stations", fewer, dose=dose)
