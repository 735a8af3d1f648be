"""Faults of batteries where kinds of robots differ in battery, charging policy or chargers.

Each kind is examined as if all robots were of this kind, with only its chargers (`as_kind`).

For `desim check`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import networkx as nx

from desim_warehouse.errors import number_of
from desim_warehouse.feasibility import batteries
from desim_warehouse.feasibility.power import Power
from desim_warehouse.findings import Finding
from desim_warehouse.layout import Layout
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import by_kind, charge_alike, chargers_at, kind_in_words, slots_at

TOO_SMALL = "BATTERY_TOO_SMALL"


def errors(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find errors of kinds: a kind that runs flat without a charger, or tasks too long for the batteries of all."""
    if charge_alike(model):
        yield from batteries.errors(model, layout)
        return
    errors_by_kind = _errors(model)
    for kind, findings in errors_by_kind.items():
        for finding in findings:
            if finding.code != TOO_SMALL or _for_all(errors_by_kind):
                yield _of(model, kind, finding)


def warnings(model: Model, layout: Layout, balance: Power | None) -> Iterator[Finding]:
    """Find faults of kinds that a planner should know, and kinds that leave tasks to other kinds."""
    if charge_alike(model):
        yield from batteries.warnings(model, layout, balance)
        yield from _slots(model, layout)
        return
    errors_by_kind = _errors(model)
    powers = {} if balance is None else balance.kinds
    short = list(batteries.chargers_short(model, balance))
    for kind, alone in by_kind(model).items():
        if not _for_all(errors_by_kind):
            for finding in errors_by_kind[kind]:
                if finding.code == TOO_SMALL:
                    yield _of(model, kind, Finding("BATTERY_OF_KIND", finding.place, finding.text, finding.cure))
        own = batteries.chargers_short(alone, powers.get(kind)) if not short else ()
        for finding in (*own, *batteries.of_levels(alone, alone.floor, powers.get(kind))):
            yield _of(model, kind, finding)
    yield from short
    yield from _slots(model, layout)


def _slots(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find faults of slots at chargers, over all kinds."""
    yield from _no_spare(model, layout)
    yield from _waiting(model, layout)
    yield from _without_slots(model, layout)


def _errors(model: Model) -> dict[str, list[Finding]]:
    """Return the errors of each kind."""
    bays = model.floor.bays.values()
    return {
        kind: list(batteries.errors(alone, alone.floor, [bay for bay in bays if bay.is_for(kind)]))
        for kind, alone in by_kind(model).items()
    }


def _for_all(errors_by_kind: dict[str, list[Finding]]) -> bool:
    """Return whether every kind has a battery that is too small for some task."""
    return all(any(finding.code == TOO_SMALL for finding in findings) for findings in errors_by_kind.values())


def _of(model: Model, kind: str, finding: Finding) -> Finding:
    """Return a finding of a kind with its place at the kind's own key, if it has one."""
    own, place = model.fleet.kinds.get(kind), finding.place
    if own is not None and own.battery is not None and place.startswith("battery"):
        place = f"fleet.kinds.{kind}.{place}"
    elif own is not None and own.charging is not None and place.startswith("policies.charging"):
        place = place.replace("policies", f"fleet.kinds.{kind}", 1)
    return replace(finding, place=place, text=f"{kind_in_words(kind)}: {finding.text}")


# Slots over all kinds: robots that wait for a charger, and robots that cannot change places


def _waiting(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find slots in which robots wait for a charger instead of working."""
    homes, slots, spare = Counter(model.fleet.homes(layout.bays)), slots_at(model, layout), Counter[str]()
    for node, chargers in chargers_at(model, layout).items():
        spare[layout.bays[node].zone] += max(slots[node] - max(chargers, homes[node]), 0)
    cure, charging = "as many slots as chargers may do better: total_chargers without places", model.policies.charging
    if len(chargers_at(model, layout)) > 1 and not charging.own and charging.params.get("charger") != "least-loaded":
        cure += "; or charger: least-loaded of policies.charging, which sees who waits where"
    for zone, count in spare.items():
        if count:
            yield Finding(
                "CHARGER_SLOTS",
                f"layout.bays.{zone}.places",
                f"{number_of(count, 'slot')} beside chargers without one: robots that wait there do no work",
                cure,
            )


def _without_slots(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find chargers that no robot can use, because their bay has fewer slots than chargers."""
    slots, idle = slots_at(model, layout), Counter[str]()
    for node, bay in layout.bays.items():
        idle[bay.zone] += max((bay.chargers or 0) - slots[node], 0)
    for zone, count in idle.items():
        if count:
            yield Finding(
                "CHARGERS_WITHOUT_SLOT",
                f"layout.bays.{zone}.places",
                f"{number_of(count, 'charger')} without a slot: a bay without places has one slot for each robot that "
                "starts there",
                "places as many as chargers, or total_chargers, which gives each charger a slot",
            )


def _no_spare(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find fleets with as many slots as robots, not all at chargers: while all rest, none can change places.

    A robot that rests without a charger goes to a charger while the robot whose slot it is works. There is no danger if
    all robots can rest at chargers.
    """
    kinds = Counter(model.fleet.kinds_of_robots())
    slots = slots_at(model, layout)
    count = sum(slots.values())
    at_chargers = _at_chargers(layout, kinds, slots)
    if count > model.fleet.size or at_chargers == model.fleet.size:
        return
    if not any(bay.chargers for bay in layout.bays.values()):
        return
    if not any(batteries.must_charge(alone, alone.floor) for alone in by_kind(model).values()):
        return
    zone = next((bay.zone for bay in layout.bays.values() if not bay.chargers), next(iter(layout.bays.values())).zone)
    who = number_of(at_chargers, "robot")
    own = " of their kind" if any(bay.kinds for bay in layout.bays.values()) else ""
    yield Finding(
        "NO_SPARE_SLOT",
        f"layout.bays.{zone}.places",
        (
            f"the bays have {number_of(count, 'slot')} for {number_of(model.fleet.size, 'robot')}, and at most {who} "
            f"can rest at chargers{own}: while all robots rest, the others cannot change places with them, and may run "
            "flat"
        ),
        f"one more slot in all, e.g. in the bays {zone}, or chargers for all who rest there",
    )


def _at_chargers(layout: Layout, kinds: Counter[str], slots: dict[str, int]) -> int:
    """Return the number of robots that can rest at chargers for their kind at once, by a maximum flow."""
    flow = nx.DiGraph()
    for kind, count in kinds.items():
        flow.add_edge("robots", ("kind", kind), capacity=count)
        for node, bay in layout.bays.items():
            if bay.charges(kind):
                flow.add_edge(("kind", kind), ("bay", node), capacity=count)
                flow.add_edge(("bay", node), "slots", capacity=slots[node])
    return int(nx.maximum_flow_value(flow, "robots", "slots")) if "slots" in flow else 0
