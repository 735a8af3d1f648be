"""The people of a design: what is counted beside robots and chargers, and who is paid by the hour."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from desim_warehouse.model.facts.workers import groups
from desim_warehouse.model.schema import Model
from desim_warehouse.values.calendars import Stretch


@dataclass(frozen=True)
class PeopleKind:
    """People of one kind: the noun for one of them, and the key of `prices` that holds the wage of an hour."""

    noun: str
    wage: str


PACKERS, PICKERS = "packers", "pickers"
PEOPLE = {PACKERS: PeopleKind("packer", "station_hour"), PICKERS: PeopleKind("picker", "picker_hour")}
"""All kinds: the people of a station, and those of no station, who walk to robots."""
COUNTED = {"fleet.size": "robot", "chargers": "charger", **{name: kind.noun for name, kind in PEOPLE.items()}}
"""What a design has a number of, by the name of the factor in a study: the noun for one."""


def at_work(model: Model, counted: Stretch, numbers: Mapping[str, int] | None = None) -> dict[str, float]:
    """Return how many people of each kind are at work on average in the counted time, and paid for it.

    In a station those are paid who work on loads there, else its servers.

    Args:
        model: the warehouse.
        counted: begin and end of the counted time, in time units of the model.
        numbers: how many there are in some stations, in all nodes of each, and under "" of no station; default: as in
            the model.
    """
    (begin, end), paid = counted, numbers or {}
    means: dict[str, list[float]] = {name: [] for name in PEOPLE}
    for zone, number in {group.zone: group.number for group in groups(model) if group.nodes}.items():
        share = model.hours(model.layout.stations[zone].hours).share(begin, end)
        means[PACKERS].append(paid.get(zone, number) * share)
    if model.pickers is not None:
        means[PICKERS].append(paid.get("", model.pickers.count) * model.hours(model.pickers.hours).share(begin, end))
    return {name: math.fsum(each) for name, each in means.items()}
