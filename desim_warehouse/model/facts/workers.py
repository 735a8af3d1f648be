"""The workers of a warehouse (robots, chargers, servers, pickers, people, lifts), and how much is asked of them.

The load of a group is what is asked of it over what it can give in its hours: 1.08 is 8 % too much. In its busiest hour
it is as many times larger as more work comes then from the flows that visit it. What is foreseen (`feasibility.loads`)
and what a run shows (`outcome.loads`) fill in this one list, so that all answers name the same groups.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from statistics import fmean
from typing import Literal

from desim_warehouse.model.facts.ahead import handling_of
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.demand import open_share
from desim_warehouse.model.facts.peak import mean_and_peak
from desim_warehouse.model.facts.places import slots
from desim_warehouse.model.facts.subfleets import Subfleet, subfleets
from desim_warehouse.model.schema import Model
from desim_warehouse.model.sections.flows import StorageEnd
from desim_warehouse.policies.situation import Act
from desim_warehouse.states import PACKING

Kind = Literal["robots", "chargers", "servers", "pickers", "people", "lifts", "lanes", "slots"]
"""Lanes and slots do not work, but hold robots up: lanes are named where robots wait in traffic longer than they work,
slots of stations where they are scarce and fewer than the robots.
"""
NEAR = 0.05
"""Loads that differ by no more are both named as the largest."""
SCARCE = 0.7
"""The load from which on a group is scarce."""
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Group:
    """Workers of one kind: all robots, all chargers, the lift `zone`, or those at the `nodes` of the station `zone`.

    `number`: of all of them. `open`: the part of the run in which they are in their hours. `subfleet`: the one whose
    name is the `zone`; None where all robots share their work.
    """

    kind: Kind
    zone: str = ""
    number: int = 1
    open: float = 1.0
    nodes: tuple[str, ...] = ()
    packs: bool = False
    subfleet: Subfleet | None = None

    @property
    def name(self) -> str:
        """The name in the plural: `robots`, `packers`, `places of dock`; of a lift `lift main`."""
        if not self.zone:
            return "slots of the stations" if self.kind == "slots" else self.kind
        if self.is_lift:
            return f"lift {self.zone}"
        who = {"robots": "robots", "people": "workers", "pickers": "pickers"}.get(self.kind, "places")
        return "packers" if self.packs else f"{who} of {self.zone}"

    @property
    def is_lift(self) -> bool:
        """Whether the group is a single lift, named in the singular."""
        return self.kind == "lifts"


LANES = Group("lanes")
"""What holds robots up that wait in traffic."""


@dataclass(frozen=True)
class Load:
    """The load of a group (utilisation, above 1 for too much work): on the `mean`, and in its busiest hour, `peak`.

    `peak`: None where the work that comes in an hour does not change, and of chargers, as batteries bridge an hour.
    `worst`: the mean at the node where it is largest. Of robots `mean` is work alone, charging included: `back` is the
    part of their time in which they drive back to parking, `held` that in which they wait in queues or traffic.
    `piles_up`: work was left at the end of a run, so that the load is the demand of all that came, not the part of the
    time worked.
    """

    group: Group
    mean: float
    peak: float | None = None
    worst: float = 0.0
    back: float = 0.0
    held: float = 0.0
    piles_up: bool = False

    @property
    def need(self) -> float:
        """The larger of the mean load and the load in the busiest hour."""
        return max(self.mean, self.peak or 0.0)

    @property
    def robots_needed(self) -> int:
        """The number of robots that the work of a group of robots takes, on the mean and in the busiest hour."""
        return math.ceil(self.need * self.group.number * (1 - _ROUNDING))

    @property
    def peak_with_waits(self) -> float | None:
        """The load of robots in the busiest hour with their waits, which grow at least as their work does."""
        return None if self.peak is None or not self.mean else self.peak * (1 + self.held / self.mean)


@lru_cache(maxsize=64)
def groups(model: Model) -> tuple[Group, ...]:
    """List the workers of a warehouse: robots, chargers, servers or pickers and people of each station, then lifts.

    Robots whose kinds share no flow are a group for each subfleet.

    Pickers of no station walk to robots.

    In a station named for packing the packers are its people where loads are worked on there (`work_time`), else its
    servers.
    """
    fleet, layout = model.fleet, model.floor
    on_duty = [open_share(model, name) for name in fleet.hours_of_robots()]
    workers = [
        Group("robots", part.name, len(part.robots), fmean(on_duty[robot] for robot in part.robots), subfleet=part)
        for part in subfleets(model)
    ] or [Group("robots", number=fleet.size, open=fmean(on_duty))]
    chargers = sum(chargers_at(model, layout).values()) if model.battery is not None else 0
    if chargers:
        workers.append(Group("chargers", number=chargers))
    for zone, spec in model.layout.stations.items():
        nodes = tuple(node for node, item in layout.stations.items() if item.zone == zone)
        if not nodes:
            continue
        part, worked = open_share(model, spec.hours), spec.work_time is not None
        kind: Kind = "servers" if model.pods is None else "pickers"
        servers = spec.servers * len(nodes)
        workers.append(Group(kind, zone, servers, part, nodes, zone == PACKING and not worked))
        if worked:
            workers.append(Group("people", zone, spec.workers * len(nodes), part, nodes, zone == PACKING))
    if model.pickers is not None:
        share = open_share(model, model.pickers.hours)
        workers.append(Group("pickers", number=model.pickers.count, open=share))
    workers += [Group("lifts", lift.name) for lift in layout.lifts]
    return tuple(workers)


def staff(model: Model, zone: str) -> str:
    """Return the word for the people or machines that serve robots in a station, in the singular.

    Where loads are worked on (`work_time`), packers are the people who do so.
    """
    packs = zone == PACKING and model.layout.stations[zone].work_time is None
    return "packer" if packs else "loading point"


@lru_cache(maxsize=256)
def peak_factor(model: Model, group: Group, since: float = 0.0) -> float | None:
    """Return the work for a group in its busiest hour, from a time of the run on, as a multiple of the mean work.

    None where the work that comes does not change.
    """
    work = {"": 1.0} | {name: work_of(model, group, name) for name in model.tasks.flows}
    mean, peak = mean_and_peak(model, work, since) or (0.0, 0.0)
    return peak / mean if mean else None


def work_of(model: Model, group: Group, flow: str) -> float:
    """Return the work that a task of a flow is for a group, on the mean; 0 if the flow does not visit it.

    For servers and pickers it is their time, for people the loads, and for robots and lifts all their tasks are alike.
    """
    if group.kind in {"robots", "lifts", "slots"}:
        return float(group.subfleet is None or flow in group.subfleet.flows)
    spec, times, work = model.tasks.flows[flow], handling_of(model, model.floor).means(), 0.0
    comes = not group.nodes and model.pickers is not None and model.pickers.serves(flow)
    stops: list[tuple[float, StorageEnd | tuple[str, ...], Act]] = [
        (1.0, model.floor.nodes_of(stop), "visit") for stop in spec.via
    ]
    for route in spec.routes:
        stops += [(route.share, route.source, "load"), (route.share, route.target, "unload")]
    for share, end, act in stops:
        if isinstance(end, StorageEnd):
            work += share * times.at_stop(act, flow) * comes
            continue
        for node in end:
            if node not in group.nodes:
                continue
            if group.kind == "people":
                work += share / len(end) * (act == "unload")
            else:
                work += share / len(end) * times.at_stop(act if model.pods is None else "visit", flow, node)
    return work


def in_peak(model: Model, group: Group, mean: float, since: float = 0.0) -> float | None:
    """Return the load of a group in its busiest hour, by its mean load from a time on: all of it is at work then."""
    factor = None if group.kind in {"chargers", "lanes"} else peak_factor(model, group, since)
    return None if factor is None else mean * group.open * factor


def at_nodes(model: Model, group: Group, of_nodes: Mapping[str, float], since: float = 0.0) -> Load | None:
    """Return the load of a group at a station from the loads of its nodes, equally weighted; None without any."""
    shares = [of_nodes[node] for node in group.nodes if math.isfinite(of_nodes.get(node, math.nan))]
    if not shares:
        return None
    mean = fmean(shares)
    return Load(group, mean, in_peak(model, group, mean, since), max(shares))


def of_slots(model: Model, tasks: float, since: float = 0.0) -> Load | None:
    """Return the load of the slots of stations, as a task has one until it is done; None where they are not scarce.

    `tasks`: the mean number of tasks in the hands of robots.
    """
    most = slots(model, model.floor)
    if most is None or most >= model.fleet.size:
        return None
    group, mean = Group("slots", number=most), tasks / most
    load = Load(group, mean, in_peak(model, group, mean, since), mean)
    return load if load.need >= SCARCE else None


def ranked(loads: Iterable[Load]) -> list[Load]:
    """Sort loads, the largest first; lanes take the time of robots beside what these work."""
    listed = list(loads)
    robots = next((load.mean for load in listed if load.group.kind == "robots"), 0.0)
    return sorted(listed, key=lambda load: -(load.need + robots * (load.group.kind == "lanes")))


def busiest(loads: Iterable[Load]) -> list[Load]:
    """Choose the largest load, and others hardly less, the largest first; empty where nobody works."""
    order = ranked(loads)
    if not order or order[0].need <= 0:
        return []
    first, *others = order
    near = [load for load in others if load.need >= first.need - NEAR and load.group.kind != "lanes"]
    return [first] if first.group.kind == "lanes" else [first, *near]


def scarce(loads: Iterable[Load]) -> list[Load]:
    """Choose the groups that have little time to spare, on the mean or in the busiest hour, the largest load first."""
    return [load for load in ranked(loads) if load.need >= SCARCE or load.group.kind == "lanes"]
