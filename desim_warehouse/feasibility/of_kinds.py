"""What is wrong with batteries where kinds of robots differ in battery, charging policy or chargers.

Each kind is looked at as if all robots were of it, with its chargers alone (`as_kind`). That batteries run low together
is not looked for then: nothing is certain of robots that draw and charge at different rates.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from desim_warehouse.feasibility import batteries, charger_slots
from desim_warehouse.findings import Finding
from desim_warehouse.model.facts.charging import by_kind, charge_alike, said

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.feasibility.power import Power
    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model

TOO_SMALL = "BATTERY_TOO_SMALL"
TOGETHER = {"HOME_WITHOUT_CHARGER", "CHARGE_TOGETHER"}


def errors(model: Model, layout: Layout) -> Iterator[Finding]:
    """What `simulate` refuses: a kind that runs flat without a charger, tasks that no kind's battery lasts for."""
    if charge_alike(model):
        yield from batteries.errors(model, layout)
        return
    found = _errors(model)
    for kind, some in found.items():
        yield from (_of(model, kind, one) for one in some if one.code != TOO_SMALL or _for_all(found))


def warnings(model: Model, layout: Layout, balance: Power | None) -> Iterator[Finding]:
    """What a planner should know; also which kinds leave tasks to others."""
    if charge_alike(model):
        yield from batteries.warnings(model, layout, balance)
        yield from _slots(model, layout)
        return
    found = _errors(model)
    powers = {} if balance is None else balance.kinds
    short = list(batteries.chargers_short(model, balance))
    for kind, alone in by_kind(model).items():
        if not _for_all(found):
            for one in found[kind]:
                if one.code == TOO_SMALL:
                    yield _of(model, kind, Finding("BATTERY_OF_KIND", one.place, one.text, one.cure))
        own = batteries.chargers_short(alone, powers.get(kind)) if not short else ()
        for one in (*own, *batteries.of_levels(alone, alone.floor, powers.get(kind))):
            if one.code not in TOGETHER:
                yield _of(model, kind, one)
    yield from short
    yield from _slots(model, layout)


def _slots(model: Model, layout: Layout) -> Iterator[Finding]:
    """Slots at chargers, of all kinds together."""
    yield from charger_slots.warnings(model, layout)
    yield from charger_slots.notes(model, layout)


def _errors(model: Model) -> dict[str, list[Finding]]:
    """The errors of each kind."""
    return {
        kind: [one for one in batteries.errors(alone, alone.floor) if one.code not in TOGETHER]
        for kind, alone in by_kind(model).items()
    }


def _for_all(found: dict[str, list[Finding]]) -> bool:
    """Whether no kind has a battery for all tasks."""
    return all(any(one.code == TOO_SMALL for one in some) for some in found.values())


def _of(model: Model, kind: str, one: Finding) -> Finding:
    """A finding of a kind, at the key that this kind has of its own."""
    own, place = model.fleet.kinds.get(kind), one.place
    if own is not None and own.battery is not None and place.startswith("battery"):
        place = f"fleet.kinds.{kind}.{place}"
    elif own is not None and own.charging is not None and place.startswith("policies.charging"):
        place = place.replace("policies", f"fleet.kinds.{kind}", 1)
    return replace(one, place=place, text=f"{said(kind)}: {one.text}")
