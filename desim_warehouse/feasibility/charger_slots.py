"""Slots of bays with and without chargers: where robots wait for one, and where none can change its slot."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import networkx as nx

from desim_warehouse.errors import number_of
from desim_warehouse.feasibility.batteries import must_charge
from desim_warehouse.findings import Finding
from desim_warehouse.model.facts.charging import by_kind, chargers_at

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model


def notes(model: Model, layout: Layout) -> Iterator[Finding]:
    """Slots in which robots wait for a charger, and do not work meanwhile."""
    homes, spare = Counter(model.fleet.homes(layout.bays)), Counter[str]()
    for node, chargers in chargers_at(model, layout).items():
        bay = layout.bays[node]
        spare[bay.zone] += max(bay.slots(homes[node]) - max(chargers, homes[node]), 0)
    for zone, count in spare.items():
        if count:
            yield Finding(
                "CHARGER_SLOTS",
                f"layout.bays.{zone}.places",
                f"{number_of(count, 'slot')} beside chargers without one: robots that wait there do no work",
                "as many slots as chargers may do better: total_chargers without places",
            )


def warnings(model: Model, layout: Layout) -> Iterator[Finding]:
    """As many slots as robots, not all at chargers: a robot that rests without a charger never comes to one.

    It keeps its slot until another is free, and the slot of a robot that is out is kept for it. So none is ever free
    if there are no more slots than robots (`Bays.may_take`). Where all can rest at chargers there is no danger.
    """
    kinds = Counter(model.fleet.kinds_of_robots())
    homes = Counter(model.fleet.homes(layout.bays))
    slots = {node: bay.slots(homes[node]) for node, bay in layout.bays.items()}
    count = sum(slots.values())
    at_chargers = _at_chargers(layout, kinds, slots)
    if count > model.fleet.size or at_chargers == model.fleet.size:
        return
    if not any(bay.chargers for bay in layout.bays.values()):
        return
    if not any(must_charge(alone, alone.floor) for alone in by_kind(model).values()):
        return
    zone = next((bay.zone for bay in layout.bays.values() if not bay.chargers), next(iter(layout.bays.values())).zone)
    who = number_of(at_chargers, "robot")
    own = " of their kind" if any(bay.kinds for bay in layout.bays.values()) else ""
    yield Finding(
        "NO_SPARE_SLOT",
        f"layout.bays.{zone}.places",
        (
            f"the bays have {number_of(count, 'slot')} for {number_of(model.fleet.size, 'robot')}, and at most {who} "
            f"can rest at chargers{own}: one that rests elsewhere cannot change places with them, and waits until it "
            "runs flat"
        ),
        f"one more slot in all, e.g. in the bays {zone}, or chargers for all who rest there",
    )


def _at_chargers(layout: Layout, kinds: Counter[str], slots: dict[str, int]) -> int:
    """How many robots can rest at chargers for their kind, all at once."""
    flow = nx.DiGraph()
    for kind, count in kinds.items():
        flow.add_edge("robots", ("kind", kind), capacity=count)
        for node, bay in layout.bays.items():
            if bay.charges(kind):
                flow.add_edge(("kind", kind), ("bay", node), capacity=count)
                flow.add_edge(("bay", node), "slots", capacity=slots[node])
    return int(nx.maximum_flow_value(flow, "robots", "slots")) if "slots" in flow else 0
