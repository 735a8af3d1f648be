"""Where goods are unloaded: at the nodes for all tasks, or at those of the task itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.model.sections.goods import Good

if TYPE_CHECKING:
    from desim_warehouse.layout.layout import Layout
    from desim_warehouse.model.schema import Model


def own_destinations(model: Model, layout: Layout) -> list[tuple[str, ...]]:
    """For every task of the list the nodes of which one it goes to, empty for tasks.unload_at; [] for drawn goods."""
    goods = model.tasks.goods
    if not isinstance(goods, tuple):
        return []
    named: dict[str | None, tuple[str, ...]] = {None: ()}
    found = []
    for item in goods:
        name = item.to if isinstance(item, Good) else None
        if name not in named:
            named[name] = layout.nodes_of(str(name))
        found.append(named[name])
    return found


def destinations(model: Model, layout: Layout) -> tuple[str, ...]:
    """All nodes where goods are unloaded, those of tasks.unload_at first. With flows also where goods are loaded.

    And those where they stop on their way. Nodes that only a file of orders names are not among them.
    """
    if model.tasks.flows:
        routes = [route for flow in model.tasks.flows.values() for route in flow.routes]
        ends = [end for route in routes for end in (route.source, route.target)]
        ends += [layout.nodes_of(name) for flow in model.tasks.flows.values() for name in flow.via]
        return tuple(dict.fromkeys(node for end in ends if isinstance(end, tuple) for node in end))
    own = (node for nodes in dict.fromkeys(own_destinations(model, layout)) for node in nodes)
    return tuple(dict.fromkeys((*model.tasks.unload_at, *own)))
