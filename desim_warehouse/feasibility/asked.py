"""What is asked for where orders have several lines: orders, lines and the trips of robots for them, an hour."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.feasibility.ahead import most_loads
from desim_warehouse.findings import amount
from desim_warehouse.model.facts.demand import flow_rates
from desim_warehouse.model.sections.flows import SaturatedArrivals
from desim_warehouse.model.sections.lines import shares_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.model import Model


def orders_asked_for(model: Model) -> Iterator[str]:
    """For each flow whose orders have several lines: orders, lines and trips an hour, such as `250 orders an hour`.

    Without pods a trip serves one line or, by-order, as many of an order as a robot carries; other tours at least as
    many as that.
    """
    size, rates = most_loads(model), flow_rates(model)
    exact = model.policies.batching.name in {"single", "by-order"}
    for name, flow in model.tasks.flows.items():
        if flow.lines == 1 or isinstance(flow.when, SaturatedArrivals):
            continue
        lines, orders = rates[name], rates[name] / flow.mean_lines
        said = f"{amount(orders)} orders an hour of {amount(flow.mean_lines)} lines on average: {amount(lines)} lines"
        if model.pods is not None:  # how many lines a visit of a pod serves depends on what is open as it comes
            yield f"flow {name}: {said}, each a task"
            continue
        a_trip = math.fsum(share * math.ceil(count / size) for count, share in shares_of(flow.lines).items())
        trips = orders * a_trip if exact else lines / size
        least = "" if exact else "at least "
        yield f"flow {name}: {said}, each a task, in {least}{amount(trips)} trips"
