"""Pods: movable shelves, what is on them, and how many orders a station works on at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator

from desim_warehouse.errors import got, number_of
from desim_warehouse.layout.spec import StationSpec
from desim_warehouse.model.sections.flows import FlowSpec, SaturatedArrivals, StorageEnd
from desim_warehouse.model.sections.goods import AbcClass, Popularity, shares
from desim_warehouse.values.fields import (
    SECTION,
    TOP,
    Count,
    Forms,
    Name,
    NotNegative,
    Part,
    Time,
    Usual,
    Whole,
    at_most,
    by_type,
    form,
    known,
    limited,
    wrong,
)


class ItemPopularity(Part):
    """How demand is spread over items: ABC classes, the first items in the first, or a weight for each item."""

    classes: tuple[AbcClass, ...] = Field((), description="A, B, C, ...: shares and demands add up to 1 each")
    weights: tuple[NotNegative, ...] = Field((), description="one for each item")

    @model_validator(mode="after")
    def _as_of_places(self) -> ItemPopularity:
        Popularity(classes=self.classes, weights=self.weights)
        return self


ItemPopularityRule = Annotated[
    Annotated[Literal["uniform"], form("rule")] | Annotated[ItemPopularity, form("given")],
    Forms("'uniform', or a section with classes or weights", pick=by_type(rule=str, given=SECTION)),
]


class HoldsFile(Part):
    """A row for each item on a pod; columns: pod, item, and optionally place (the number of its storage place), units.

    Pods and items are named or numbered as you like. Items have the numbers 0, 1, 2, ... in the order in which the file
    first names them; a file of orders calls them as this file does.
    """

    file: Name = Field(description="CSV file, relative to the model file")


class Holds(Part):
    """The contents and places of pods, as read from a file: columns `pod`, `item` and `units`."""

    names: tuple[Name, ...] = Field(description="of the items, in order of number")
    pod: tuple[Whole, ...] = Field(description="the number of a pod, for each item on it")
    item: tuple[Whole, ...] = Field(description="the number of the item")
    units: tuple[Whole, ...] = Field((), description="units of it at the start; default: pods.stock")
    places: tuple[Whole, ...] = Field((), description="the storage place of each pod; default: at random")

    @model_validator(mode="after")
    def _all_there(self) -> Holds:
        if len(self.pod) != len(self.item) or len(self.units) not in {0, len(self.pod)}:
            raise wrong("columns of different lengths, expected a pod, an item and units in each row")
        if max(self.item, default=-1) >= len(self.names):
            raise wrong(f"no such item (got {max(self.item)}), expected numbers below {len(self.names)}", "item")
        if len(set(self.places)) < len(self.places):
            twice = next(place for rank, place in enumerate(self.places) if place in self.places[:rank])
            raise wrong(f"two pods on place {twice}, expected a place for each", "places")
        return self


class PodsSpec(Part):
    """Goods to person: robots carry pods to stations, where lines of orders are picked from them, and back.

    A task of a flow from storage is a line: an item picked from a pod, for `stop_time` of its flow. One of a flow to
    storage puts a bundle of an item onto a pod. Robots lift a pod for `tasks.load_time` and put it down for
    `tasks.unload_time`, in the lane.

    - Every item is on as many pods as another, give or take one. A line's item is drawn by `popularity`.
    - The oldest order goes to a station, by `policies.order_station`, as long as it has fewer than `orders`; its
      place there is free when its last line is picked.
    - A line joins a pod that is bound for its station, or is there, and has its item. Otherwise it waits, and when a
      robot is free a pod is called, by `policies.pod`, for all the lines that it has. A pod is called only where it
      stands.
    - The robot waits for a picker, and takes the pod back when no line is left for it, to a place by
      `policies.storage`.
    - `places` of a station are the pods that are there or on their way to it.
    """

    count: Annotated[Count, limited("places")] = Field(
        title="pods", description="number of pods, each on a storage place at the start"
    )
    items: Annotated[Count, limited("places")] = Field(title="items", description="number of items (SKUs)")
    per_pod: Count = Field(15, title="items on a pod", description="items dealt to each pod")
    stock: Count | None = Field(
        None, title="units of an item", description="units of each item on a pod at the start; default: unlimited"
    )
    bundle: Count = Field(
        1, title="units of a bundle", description="units that a task of a flow to storage adds to a pod"
    )
    orders: Whole = Field(
        12, title="orders at a station", description="orders that a station works on at once; 0: no limit"
    )
    change_time: Annotated[Time, Usual(0, "1 min")] = Field(
        5.0,
        title="time to change pods",
        description="time from the end of one pod until the next in the queue is in front of the picker; none if no "
        "pod queued",
    )
    popularity: ItemPopularityRule = Field("uniform", description="of items, from the first to the last")
    holds: Annotated[Holds | None, Forms("{file: pods.csv} with the columns pod, item, place and units", HoldsFile)] = (
        Field(None, description="what each pod holds; default: per_pod items each, dealt out at random")
    )

    @field_validator("count")
    @classmethod
    def _have_places(cls, count: int, info: ValidationInfo) -> int:
        places = known(info).places
        if places is not None and count > places:
            raise wrong(f"{got(count)} pods for {places} storage places, expected at most {places}")
        return count

    @field_validator("holds")
    @classmethod
    def _fit(cls, holds: Holds | None, info: ValidationInfo) -> Holds | None:
        if holds is None:
            return None
        for key, number in (("count", max(holds.pod, default=-1) + 1), ("items", len(holds.names))):
            if info.data.get(key, number) != number:
                has = number_of(number, "pod" if key == "count" else "item")
                raise wrong(f"pods.holds has {has}, expected {key}: {number}", TOP, "pods", key)
        places = known(info).places
        if places is not None and (far := [place for place in holds.places if place >= places]):
            raise wrong(f"no such place (got {far[0]}), expected numbers from 0 to {places - 1}", "places")
        if holds.units and info.data.get("stock") is not None:
            raise wrong("units stand in the file, too, expected one of the two", TOP, "pods", "stock")
        return holds

    @model_validator(mode="after")
    def _all_somewhere(self) -> PodsSpec:
        if self.holds is not None:
            return self
        if self.per_pod > self.items:
            raise wrong(f"{got(self.per_pod)} items on a pod of {self.items} in all, expected at most those", "per_pod")
        if self.items > self.count * self.per_pod:
            pods = f"{number_of(self.count, 'pod')} hold{'s' * (self.count == 1)}"
            text = f"{got(self.items)} items, {pods} {self.count * self.per_pod}"
            raise wrong(f"{text}, expected at most as many", "items")
        at_most("stock", self.count * self.per_pod, "per_pod")
        weights = () if isinstance(self.popularity, str) else self.popularity.weights
        if weights and len(weights) != self.items:
            text = f"{number_of(len(weights), 'weight')} for {number_of(self.items, 'item')}, expected one for each"
            raise wrong(text, "popularity", "weights")
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the items in a file, in order of number; none without one."""
        return () if self.holds is None else self.holds.names

    def name_of(self, item: int) -> str:
        """Return how files of the model call an item: by its name, or else by its number."""
        return self.names[item] if self.names else str(item)

    @property
    def held(self) -> float:
        """The chance that a pod has an item."""
        if self.holds is None:
            return self.per_pod / self.items
        return len(set(zip(self.holds.pod, self.holds.item, strict=True))) / (self.count * self.items)

    @property
    def units(self) -> Any:
        """Units of every item on all pods at the start, a numpy array; None where they never run out."""
        import numpy as np

        holds = self.holds
        if holds is not None and holds.units:
            return np.bincount(holds.item, weights=holds.units, minlength=self.items)
        if self.stock is None:
            return None
        return self.stock * (np.full(self.items, self.count * self.held) if holds is None else np.bincount(holds.item))

    @property
    def item_shares(self) -> Any:
        """The share of every item in the demand, a numpy array."""
        import numpy as np

        equal = np.full(self.items, 1 / self.items)
        if isinstance(self.popularity, str):
            return equal
        popularity = Popularity(classes=self.popularity.classes, weights=self.popularity.weights)
        return shares(popularity, equal)  # type: ignore[arg-type]  # only the number of items is read

    def is_random(self, _model: Any) -> bool:
        """Return True: chance decides where pods stand, which items they have and which are asked for."""
        return True


def fit_for_pods(
    flows: Mapping[str, FlowSpec], stations: Mapping[str, StationSpec], nodes_of: Mapping[str, tuple[str, ...]]
) -> None:
    """Refuse flows that are no lines: all go between storage and stations beside nodes. `nodes_of`: by station."""
    beside = {node for nodes in nodes_of.values() for node in nodes}
    for name, station in stations.items():
        if station.work_time is not None:
            text = "nothing is put down where pods are brought; expected stop_time of a flow, in which a line is picked"
            raise wrong(text, TOP, "layout", "stations", name, "work_time")
    if not flows:
        raise wrong("goods are fetched one by one, pods need tasks.flows", TOP, "tasks", "goods")
    first = next(iter(flows.values()))
    for name, flow in flows.items():
        keys = (TOP, "tasks", "flows", name)
        nodes = _between(flow, keys)
        if far := [node for node in nodes if node not in beside]:
            text = (
                f"pods are brought to stations beside nodes, and {got(far[0])} is in the lane, expected layout.stations"
            )
            raise wrong(text, *keys, "to" if isinstance(flow.source, StorageEnd) else "from")
        if (flow.kinds, flow.load_type) != (first.kinds, first.load_type):
            raise wrong("one pod serves lines of all flows, expected the same in all", *keys, "kinds")
        if isinstance(flow.when, SaturatedArrivals) and not flow.stop_time:
            raise wrong(
                "always open and picked in no time, so that a visit never ends, expected some", *keys, "stop_time"
            )


def _between(flow: FlowSpec, keys: tuple[str, ...]) -> tuple[str, ...]:
    """Return the nodes of a flow's stations."""
    if flow.from_to or flow.via:
        key = "from_to" if flow.from_to else "via"
        raise wrong("pods go from storage to a station and back, expected from and to", *keys, key)
    source, target = flow.source, flow.target
    if isinstance(source, StorageEnd) == isinstance(target, StorageEnd):
        raise wrong("with pods a flow goes from storage to stations or from stations to storage", *keys, "to")
    return target if isinstance(target, tuple) else source if isinstance(source, tuple) else ()
