"""Pickers: people who walk to robots that wait at storage places, and handle the loads that these have come for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from desim_warehouse.errors import got, number_of, spoken
from desim_warehouse.model.sections.flows import FlowSpec, StorageEnd
from desim_warehouse.values.calendars import CalendarName
from desim_warehouse.values.fields import TOP, Count, Name, Part, Speed, Usual, known, limited, wrong


class PickersSpec(Part):
    """People who pick from shelves into robots, which wait for them at storage places.

    A robot that stops at a storage place waits there until a picker has walked to it, along the lanes, in either
    direction. The picker loads it, for `load_time` of the flow, or puts away what it brings, for `unload_time`, and is
    free for the next robot. Free pickers stay where they are. Robots and pickers do not hinder each other, nor do
    pickers among themselves. At the start pickers are spread evenly over the storage places of their zone.

    - `choose: nearest`: of robots that wait and pickers that are free those two meet that are closest to each other.
      `longest-waiting`: the robot that has waited longest is next, with the free picker who is closest to it.
    - `stay: order`: a robot waits in its bay or station until a picker is free, who then goes with it from place to
      place up to the last pick of its tour, and walks while it drives. All loads must be put down in stations.
    - `call: ahead`: pickers for whom no robot waits are sent to places to which robots are on their way. One who
      stands there before the robot comes may be called to a robot that waits elsewhere.
    - `zones`: storage places, in the order of their lanes, are divided into so many parts with as many places each, and
      pickers are shared out among them. Nobody leaves their zone.
    - `hours`: outside them no picker sets out for a robot; whoever is with one, or on the way to it, finishes.
    """

    count: Annotated[Count, limited("places")] = Field(title="pickers", description="number of pickers, in all zones")
    # a person walks at 1.4 m/s, with a scanner in hand between shelves at 0.75 to 1.2
    speed: Annotated[Speed, Usual("0.3 m/s", "2 m/s")] = Field(
        title="walking speed", description="the speed at which they walk"
    )
    zones: Count = Field(
        1, title="zones of pickers", description="parts of the storage places, each with pickers of its own"
    )
    choose: Literal["nearest", "longest-waiting"] = Field(
        "nearest", title="next robot", description="which robot a free picker goes to"
    )
    stay: Literal["pick", "order"] = Field(
        "pick",
        title="picker stays",
        description="how long a picker stays with a robot: for one pick, or for all picks of a tour",
    )
    call: Literal["there", "ahead"] = Field(
        "there",
        title="pickers called",
        description="when a picker may be sent to a robot: once it stands at the place, or while it is on its way",
    )
    flows: tuple[Name, ...] = Field((), description="flows that need pickers at storage places; default: all")
    hours: CalendarName | None = Field(None, description="hours, a calendar; default: always at work")

    @field_validator("zones")
    @classmethod
    def _someone_in_each(cls, zones: int, info: ValidationInfo) -> int:
        count, places = info.data.get("count"), known(info).places
        if count is not None and zones > count:
            raise wrong(f"{got(zones)} zones for {number_of(count, 'picker')}, expected at most one for each")
        if places is not None and zones > places:
            raise wrong(f"{got(zones)} zones of {number_of(places, 'storage place')}, expected at most one for each")
        return zones

    @field_validator("stay")
    @classmethod
    def _in_one_zone(cls, stay: str, info: ValidationInfo) -> str:
        if stay == "order" and info.data.get("zones", 1) > 1:
            raise wrong("nobody leaves their zone, so nobody stays with a robot that does, expected zones: 1")
        return stay

    @field_validator("call")
    @classmethod
    def _called_anyway(cls, call: str, info: ValidationInfo) -> str:
        if call == "ahead" and info.data.get("stay") == "order":
            raise wrong("a picker who stays is with the robot before it sets out; leave it out")
        return call

    def serves(self, flow: str) -> bool:
        """Whether tasks of a flow need a picker at storage places."""
        return not self.flows or flow in self.flows


def fit_for_pickers(pickers: PickersSpec, flows: Mapping[str, FlowSpec]) -> None:
    """Refuse names of flows that do not exist or stop at no storage place, and pickers for whom no robot ever waits.

    Raises:
        PydanticCustomError: with the key of the first such name.
    """
    stored = {name for name, flow in flows.items() if _is_stored(flow)}
    if flows and not stored:
        raise wrong("no flow begins or ends at a storage place, where pickers would come; leave them out")
    for rank, name in enumerate(pickers.flows):
        if name not in stored:
            expected = f"one of {spoken(sorted(stored), 'or')}" if flows else "none, as there are no flows"
            what = "it neither begins nor ends at a storage place" if name in flows else "no such flow"
            raise wrong(f"{what} (got {got(name)}), expected {expected}", "flows", rank)


def need_one(pickers: PickersSpec, flows: Mapping[str, FlowSpec]) -> bool:
    """Whether each task needs a picker, so that no work is done outside their hours."""
    return all(pickers.serves(name) and _is_stored(flow) for name, flow in flows.items())


def _is_stored(flow: FlowSpec) -> bool:
    return any(isinstance(end, StorageEnd) for route in flow.routes for end in (route.source, route.target))


def fit_for_staying(
    flows: Mapping[str, FlowSpec],
    unload_at: Iterable[str],
    stations: Mapping[str, tuple[str, ...]],
) -> None:
    """Refuse loads that are put down in the lane, where a robot would wait for its next picker and block others.

    Args:
        flows: of the model, by name.
        unload_at: nodes and stations where goods are put down, where there are no flows.
        stations: nodes of each station, by name.

    Raises:
        PydanticCustomError: with the key of the flow, or of the goods.
    """
    beside = {*stations, *(node for nodes in stations.values() for node in nodes)}
    cure = "a picker who stays is met in a bay or station; expected stations"
    for name, flow in flows.items():
        for route in flow.routes:
            if isinstance(route.target, StorageEnd):
                raise wrong(f"ends at a storage place, in the lane: {cure}", TOP, "tasks", "flows", name, "to")
            for node in route.target:
                if node not in beside:
                    raise wrong(f"ends in the lane (got {got(node)}): {cure}", TOP, "tasks", "flows", name, "to")
    for node in unload_at:
        if node not in beside:
            raise wrong(f"puts loads down in the lane (got {got(node)}): {cure}", TOP, "tasks", "unload_at")
