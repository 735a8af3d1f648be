"""The model: what one simulation run is made of, as frozen, checked values."""

from __future__ import annotations

import datetime as dt
import hashlib
import json
import math
from collections.abc import Collection, Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator

from desim_warehouse.errors import LayoutError, ModelError, first_of, got, number_of
from desim_warehouse.findings import Acceptable, amount
from desim_warehouse.layout import Layout, build
from desim_warehouse.layout.spec import (
    LayoutSpec,
    NodesOfStations,
)
from desim_warehouse.model.events import too_many
from desim_warehouse.model.messages import Outline, report
from desim_warehouse.model.overrides import override
from desim_warehouse.model.parse import Document, from_mapping, valid
from desim_warehouse.model.sections.departures import Timetable
from desim_warehouse.model.sections.fleet import BatterySpec, Fleet
from desim_warehouse.model.sections.flows import (
    STORAGE,
    FlowSpec,
    PoissonArrivals,
    Profile,
    ProfileArrivals,
    Rates,
    SaturatedArrivals,
    StorageEnd,
    ends_of_storage,
    fixed_orders,
    mean_rate,
)
from desim_warehouse.model.sections.goods import (
    GOODS_FORM,
    Good,
    GoodsRule,
    PoissonGoods,
    Popularity,
    PopularityRule,
    SaturatedGoods,
)
from desim_warehouse.model.sections.order_lines import Reading
from desim_warehouse.model.sections.orders import files_of, problems_of
from desim_warehouse.model.sections.pickers import PickersSpec, fit_for_pickers, fit_for_staying
from desim_warehouse.model.sections.pods import PodsSpec, fit_for_pods
from desim_warehouse.model.sections.policy import Policies
from desim_warehouse.model.sections.traffic import PeopleSpec, TrafficSpec
from desim_warehouse.model.tables import resolve
from desim_warehouse.policies import catalogue
from desim_warehouse.states import APART
from desim_warehouse.values.calendars import ALWAYS, DAY, MONDAY, Calendar, Hours, clock_time, in_24_hours
from desim_warehouse.values.dates import has_time, read_times
from desim_warehouse.values.distributions import Distribution, Varying
from desim_warehouse.values.fields import (
    TOP,
    Duration,
    FrozenMap,
    Known,
    Name,
    Named,
    NotNegative,
    Part,
    Positive,
    Quantity,
    Text,
    Time,
    Usual,
    all_wrong,
    at_most,
    known,
    see_kinds,
    wrong,
)
from desim_warehouse.values.units import METRES, SECONDS, UnitNames

BY_YEAR = "what it costs to buy, divided by the years of use, in whole units of the currency"
# small robots cost 2,000 to buy and last ten years; for the upper end see PRICE_A_YEAR
ROBOT_PRICE = Usual(100, price=True, words="a year", cure=BY_YEAR)


class Units(Part):
    """Names of the units the file is written in, and the seconds in one time unit."""

    length: Name = Field("m", description="name of the length unit")
    time: Name = Field("s", description="name of the time unit")
    seconds: Positive = Field(
        1.0, title="seconds in a time unit", description="seconds in one time unit, for reports and hourly rates"
    )

    @property
    def metre(self) -> float | None:
        """Metres in the length unit, or None where its name does not say."""
        return float(METRES[self.length]) if self.length in METRES else None

    @property
    def has_seconds(self) -> bool:
        """Whether the time unit has a known length: by its name, or given. A model in steps may not say."""
        return self.time in SECONDS or self.seconds != 1

    @property
    def names(self) -> UnitNames:
        """The names of the units that quantities with units are converted to."""
        return UnitNames(self.length, self.time, self.seconds)

    @property
    def hour(self) -> float:
        """Time units in an hour."""
        return 3600 / self.seconds

    def lasts(self, time: float) -> str:
        """Return a time in words: in hours, minutes or seconds; in a unit of unknown length, in that unit."""
        if not self.has_seconds:
            return f"{amount(time)} {self.time}"
        in_seconds = time * self.seconds
        unit = next((unit for unit in ("h", "min") if in_seconds >= SECONDS[unit]), "s")
        return f"{amount(in_seconds / float(SECONDS[unit]))} {unit}"


class Tasks(Part):
    """The work: which goods, where they are unloaded, how long handling takes."""

    goods: GoodsRule | None = Field(None, description="the goods to fetch, listed or drawn; this or flows")
    flows: Named[FlowSpec] = Field(FrozenMap(), description="instead of goods: what is brought from where to where")
    demand: Annotated[Positive, Quantity("share"), Usual(0.65, 10)] = Field(
        1.0,
        description="multiplies all arrival rates, schedules and resampled orders; work that is always open stays so",
    )
    popularity: PopularityRule = Field(
        "uniform", description="for drawn goods: uniform, the layout's popularity column, classes or weights"
    )
    unload_at: NodesOfStations = Field(
        (),
        min_length=1,
        description="nodes, or names of stations: one for all robots or one each; must be given with goods",
    )
    station_choice: Literal["each", "nearest", "least-loaded", "random"] = Field(
        "each",
        description="each: the one of all robots or of each robot, for flows the nearest; otherwise one of several, "
        "chosen for every task",
    )
    # a roller takes over a tote in 1 s; from an hour on it is LONG_HANDLING
    load_time: Annotated[Varying, Usual("1 s")] = Field(description="at the storage place")
    unload_time: Annotated[Varying, Usual("1 s")] = Field(description="at the station")
    clear_time: Annotated[Time, Usual(0, "10 min")] = Field(
        0.0, description="time after unloading before the robot drives on; its next task is assigned before that"
    )
    done_when: Literal["delivered", "worked"] = Field(
        "worked",
        description="when a load counts as done, for due times and cycle times: when it is delivered or, at a "
        "station with work_time, (worked) when it has also been worked on",
    )

    def is_random(self, model: Model) -> bool:
        """Whether chance decides anything of the work, such as the stations of tasks."""
        if self.station_choice == "random" and self._choice_of_nodes(model):
            return True
        return super().is_random(model)

    def _choice_of_nodes(self, model: Model) -> bool:
        """Whether some task may be unloaded at one of several nodes."""
        if self.flows:
            return any(flow.may_end_at_several for flow in self.flows.values())
        listed = self.goods if isinstance(self.goods, tuple) else ()
        named = {item.to for item in listed if isinstance(item, Good) and item.to is not None}
        return len(self.unload_at) > 1 or any(len(model.floor.nodes_of(name)) > 1 for name in named)

    def may_begin_at(self, nodes: Collection[str]) -> bool:
        """Whether a load may be picked up at one of some nodes, rather than in storage."""
        return bool(files_of(self.flows)) or not self.picked_at.isdisjoint(nodes)

    @property
    def picked_at(self) -> set[str]:
        """The nodes at which loads of flows are picked up, rather than in storage."""
        sources = [route.source for flow in self.flows.values() for route in flow.routes]
        return {node for source in sources if isinstance(source, tuple) for node in source}

    def handling_of(self, flow: FlowSpec) -> tuple[float | Distribution, float | Distribution]:
        """Return the times of loading and unloading a task: set by its flow, else by `load_time` and `unload_time`."""
        loading = self.load_time if flow.load_time is None else flow.load_time
        return loading, self.unload_time if flow.unload_time is None else flow.unload_time

    @property
    def has_via(self) -> bool:
        """Whether tasks stop on their way."""
        return any(flow.may_stop for flow in self.flows.values())

    @field_validator("goods", mode="before")
    @classmethod
    def _not_too_many(cls, goods: Any) -> Any:
        if isinstance(goods, list | tuple):
            at_most("tasks", len(goods))
        return goods

    @property
    def never_end(self) -> bool:
        """Whether tasks are released without end."""
        if self.flows:
            return any(flow.never_ends for flow in self.flows.values())
        return isinstance(self.goods, SaturatedGoods | PoissonGoods)

    @property
    def arrive(self) -> bool:
        """Whether tasks arrive at random, however many are open."""
        if self.flows:
            return any(isinstance(flow.when, PoissonArrivals | ProfileArrivals) for flow in self.flows.values())
        return isinstance(self.goods, PoissonGoods)

    @model_validator(mode="after")
    def _goods_or_flows(self) -> Tasks:
        if self.goods is None and not self.flows:
            raise wrong(f"missing, expected {GOODS_FORM}, or flows", "goods")
        if self.goods is not None and self.flows:
            raise wrong("both goods and flows, expected one of the two", "flows")
        if self.flows and self.unload_at:
            raise wrong("beside flows, which say where their loads go (to); leave it out", "unload_at")
        if not self.flows and not self.unload_at:
            raise wrong("missing, expected names of stations or nodes", "unload_at")
        at_most("tasks", sum(flow.scheduled for flow in self.flows.values()) * self.demand, "flows")
        return self

    @property
    def has_rates(self) -> bool:
        """Whether all tasks that are not always open arrive at rates that `demand` can multiply."""
        if self.flows:
            some = [flow for flow in self.flows.values() if not isinstance(flow.when, SaturatedArrivals)]
            return bool(some) and not any(fixed_orders(flow) for flow in some)
        return isinstance(self.goods, PoissonGoods)

    @model_validator(mode="after")
    def _near_what(self) -> Tasks:
        """Refuse classes by distance where no load is driven between storage and a station."""
        if self.flows and not ends_of_storage(self.flows.values())[0]:
            for keys, popularity in self.popularities():
                if isinstance(popularity, Popularity) and popularity.by == "distance":
                    text = "nothing is brought from storage to a station, or back (got 'distance')"
                    raise wrong(f"{text}, expected number or random", *keys, "by")
        return self

    def popularities(self) -> Iterator[tuple[tuple[str, ...], str | Popularity]]:
        """Iterate over every popularity that is given, and where it stands below this section."""
        yield ("popularity",), self.popularity
        for name, flow in self.flows.items():
            for key, end in (("from", flow.source), ("to", flow.target)):
                if isinstance(end, StorageEnd) and end.popularity is not None:
                    yield ("flows", name, key, "popularity"), end.popularity

    @property
    def grow(self) -> bool:
        """Whether tasks arrive at rates (`has_rates`), and none of the work ends, as a schedule does."""
        return self.has_rates and all(flow.never_ends for flow in self.flows.values())

    @model_validator(mode="after")
    def _demand(self) -> Tasks:
        if self.demand == 1 or self.has_rates:
            return self
        fixed = next((name for name, flow in self.flows.items() if fixed_orders(flow)), None)
        if fixed is not None:
            cure = f"1, or resample: in tasks.flows.{fixed}.arrivals.orders"
            raise wrong(f"does not multiply the rows of a file (got {got(self.demand)}), expected {cure}", "demand")
        cure = "1, or tasks that arrive at a rate, such as {poisson: 40}"
        raise wrong(f"there is no rate to multiply (got {got(self.demand)}), expected {cure}", "demand")

    @model_validator(mode="after")
    def _stations(self, info: ValidationInfo) -> Tasks:
        if self.flows:
            return self
        entries, robots = len(self.unload_at), known(info).robots
        if self.station_choice == "each" and robots is not None and entries not in {1, robots}:
            fleet = number_of(robots, "robot")
            expected = "one node" if robots == 1 else f"one node for all, or {robots}: one for each robot of fleet.size"
            text = f"{entries} nodes for {fleet} (got {got(self.unload_at)}), expected {expected}"
            raise wrong(text, "unload_at")
        return self


class RunSpec(Part):
    """How long a run lasts; lifelong demand needs a length."""

    length: Annotated[Duration | None, Usual("1 min", "400 d")] = Field(
        None, title="run length", description="default: until all work is done"
    )
    start: Text = Field(
        "00:00",
        title="start of the run",
        description="when a run starts: a time of day, or a date with one (2026-03-02T06:00 or 02.03.2026 06:00); for "
        "orders from files",
    )
    warm_up: Time = Field(0.0, title="warm-up", description="indicators count from here on")

    @property
    def end(self) -> float:
        """When a run ends at the latest; inf where only its work ends it."""
        return math.inf if self.length is None else self.length

    @field_validator("start")
    @classmethod
    def _a_time(cls, start: str) -> str:
        if (written := _instant_of(start)) is None:
            raise wrong(f"not a time (got {got(start)}), expected one such as '06:00' or '2026-03-02T06:00'")
        return written

    @field_validator("warm_up")
    @classmethod
    def _before_the_end(cls, warm_up: float, info: ValidationInfo) -> float:
        length = info.data.get("length")
        if length is not None and warm_up >= length:
            raise wrong(f"too long (got {got(warm_up)}), expected a time below run.length, {got(length)}")
        return warm_up


def _instant_of(start: str) -> str | None:
    """Return a time of day, or a date with one, as `06:00` or `2026-03-02T06:00`; None for anything else.

    Both may be as people write them, in one reading, without a time zone.
    """
    start = in_24_hours(start)
    day, _, clock = start.rpartition("T")
    try:
        dt.date.fromisoformat(day or MONDAY)
        if clock_time(clock) < DAY:
            return start
    except ValueError:
        pass
    [date] = read_times([start]).dates
    if date is None or date.tzinfo is not None or not has_time(start):
        return None
    return date.isoformat(timespec="seconds" if date.second else "minutes")


def _without_end(tasks: Tasks) -> str:
    """Return the words that say which work goes on for ever, for a message."""
    for name, flow in tasks.flows.items():
        if flow.never_ends:
            return f"as tasks.flows.{name} goes on for ever"
    kind, number = next(iter(tasks.goods.content().items())) if isinstance(tasks.goods, Part) else ("", "")
    return f"as tasks.goods {{{kind}: {number}}} goes on for ever"


class Cost(Part):
    """Weights of Cost_total = distance x w_d + time x w_t + collisions x w_c (the paper's outlook)."""

    distance: NotNegative = Field(1.0, title="weight of distance", description="w_d, for each length unit driven")
    time: NotNegative = Field(1.0, title="weight of time", description="w_t, for each time unit of T")
    collisions: NotNegative = Field(1.0, title="weight of collisions", description="w_c, for each collision")

    def total(self, distance: float, time: float, collisions: float) -> float:
        """Return Cost_total of a distance in length units, a time in time units, and a number of collisions."""
        return distance * self.distance + time * self.time + collisions * self.collisions


_Wage = Annotated[
    NotNegative, Usual(2, 300, price=True, words="an hour", cure="wages of a year, divided by the hours worked")
]


class Prices(Part):
    """The costs of running the warehouse, in any one currency: for annual_cost and cost_per_task."""

    currency: Name | None = Field(None, description="its name, such as EUR, for sums on pages and in sentences")
    # a shift a week is 400 hours a year, a leap year 8,784
    hours: Annotated[
        Positive, Usual(400, 8784, words="hours a year", cure="all year are 8,760, a shift of 8 h on 250 days 2,000")
    ] = Field(title="hours a year", description="hours a year that the warehouse runs as in this model")
    robot: Annotated[NotNegative, ROBOT_PRICE] = Field(
        0.0, title="price of a robot", description="a robot, per year: price / years of use, plus maintenance"
    )
    kinds: Annotated[Named[NotNegative], ROBOT_PRICE] = Field(
        FrozenMap(), title="price of a robot", description="robots of a kind, per year; default: robot"
    )
    charger: Annotated[NotNegative, Usual(20, price=True, words="a year", cure=BY_YEAR)] = Field(
        0.0, title="price of a charger", description="a charger, per year"
    )
    battery: Annotated[NotNegative, Usual(20, price=True, words="a year", cure=BY_YEAR)] = Field(
        0.0, title="price of a spare battery", description="a spare battery (policies.charging.batteries), per year"
    )
    energy: NotNegative = Field(0.0, title="price of energy", description="a unit of the energy that robots draw")
    station_hour: _Wage = Field(
        0.0,
        title="price of a station hour",
        description="an hour of a worker at an open station or, without `work_time`, of a server there",
    )
    picker_hour: _Wage = Field(
        0.0,
        title="price of a picker's hour",
        description="an hour at work of a picker who walks to robots (`pickers`)",
    )
    late_order: Annotated[
        NotNegative,
        Usual(0.01, 1000, price=True, words="an order", cure="what one order costs that is late, not all of a year"),
    ] = Field(
        0.0,
        title="price of a late order",
        description="an order that is due and not done; a task that belongs to no order of a file counts as one",
    )
    turned_aisle: NotNegative = Field(
        0.0, title="price of a turned aisle", description="an aisle turned by desim orient --indicator, once"
    )

    @property
    def any(self) -> bool:
        """Whether anything has a price."""
        return self.of_fleet or any((self.energy, self.station_hour, self.picker_hour, self.late_order))

    @property
    def of_fleet(self) -> bool:
        """Whether robots or chargers have a price."""
        return any((self.robot, self.charger, self.battery, *self.kinds.values()))

    @field_validator("kinds")
    @classmethod
    def _of_the_fleet(cls, kinds: Mapping[str, float], info: ValidationInfo) -> Mapping[str, float]:
        see_kinds(((kind, kind) for kind in kinds), known(info).kinds)
        return kinds


class Model(Part):
    """A complete model: everything that a run depends on, except the seed."""

    name: Text = Field("model", description="a short name, for reports")
    description: Text = Field("", description="a sentence or two")
    units: Units = Units()
    calendars: Named[Calendar] = Field(
        FrozenMap(),
        validate_default=True,
        description="opening hours, shifts and times of closures, by name",
    )
    layout: LayoutSpec
    fleet: Fleet
    tasks: Tasks
    pods: PodsSpec | None = Field(None, description="goods to person; none: robots bring single loads")
    pickers: PickersSpec | None = Field(
        None, description="people who pick into robots that wait at storage places; none: robots load by themselves"
    )
    battery: BatterySpec | None = Field(None, validate_default=True, description="none: robots never need charging")
    traffic: TrafficSpec = TrafficSpec()
    people: Named[PeopleSpec] = Field(FrozenMap(), description="people in the aisles, by name of where they come from")
    policies: Policies = Field(Policies(), validate_default=True)
    run: RunSpec = Field(RunSpec(), validate_default=True)
    cost: Cost = Cost()
    prices: Prices | None = Field(None, description="none: no costs are calculated")
    log: Literal["all", "moves", "tasks"] = Field("all", description="how much is recorded")
    accept: tuple[Acceptable, ...] = Field(
        (),
        description="error codes of `desim check` to accept: the model is simulated anyway, and the report says so",
    )

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Model:
        """Check values against one another, too: each against what was read before it."""
        return super().model_validate(obj, **{"context": Known(), **options})

    @field_validator("units")
    @classmethod
    def _convert(cls, units: Units, info: ValidationInfo) -> Units:
        known(info).units = units.names
        return units

    @field_validator("calendars")
    @classmethod
    def _names(cls, calendars: Mapping[str, Calendar], info: ValidationInfo) -> Mapping[str, Calendar]:
        known(info).calendars = tuple(calendars)
        return calendars

    @field_validator("layout")
    @classmethod
    def _whole(cls, layout: LayoutSpec) -> LayoutSpec:
        if layout.blocks is None and not layout.nodes:
            raise wrong("neither blocks nor nodes, expected one of the two")
        if layout.nodes and not layout.edges:
            raise wrong("a layout of nodes without edges, expected at least one entry", "edges")
        return layout

    @field_validator("layout")
    @classmethod
    def _names_mean_one_thing(cls, layout: LayoutSpec, info: ValidationInfo) -> LayoutSpec:
        """Refuse a bay or station with the name of a node, unless it is at this node alone and both mean the same."""
        here = known(info)
        problems = [
            wrong(
                f"two meanings: node {name}, and the {kind[:-1]} at {first_of(nodes, 3)}, expected another name",
                kind,
                name,
            )
            for kind, nodes_of in here.zones.items()
            for name, nodes in nodes_of.items()
            if name in (here.nodes or ()) and nodes != (name,)
        ]
        if problems:
            raise all_wrong(problems)
        return layout

    @field_validator("fleet")
    @classmethod
    def _of_kinds(cls, fleet: Fleet, info: ValidationInfo) -> Fleet:
        layout: LayoutSpec | None = info.data.get("layout")
        for name, bay in () if layout is None else layout.bays.items():
            see_kinds(((None, kind) for kind in bay.kinds), tuple(fleet.kinds), TOP, "layout", "bays", name, "kinds")
        return fleet

    @field_validator("tasks")
    @classmethod
    def _storage_means_places(cls, tasks: Tasks, info: ValidationInfo) -> Tasks:
        """Refuse nodes and stations called `storage` beside flows, where this word means any storage place."""
        layout: LayoutSpec | None = info.data.get("layout")
        named = {} if layout is None or not tasks.flows else {"nodes": layout.nodes, "stations": layout.stations}
        for kind, names in named.items():
            if STORAGE in names:
                text = f"two meanings: any storage place, in flows, and this {kind[:-1]}, expected another name"
                raise wrong(text, TOP, "layout", kind, STORAGE)
        return tasks

    @field_validator("tasks")
    @classmethod
    def _have_storage(cls, tasks: Tasks, info: ValidationInfo) -> Tasks:
        """Refuse tasks that begin or end at a storage place where the layout has none."""
        layout: LayoutSpec | None = info.data.get("layout")
        if layout is None or layout.storage_places:
            return tasks
        what = "goods are" if tasks.goods is not None else None
        for name, flow in tasks.flows.items():
            if any(isinstance(end, StorageEnd) for route in flow.routes for end in (route.source, route.target)):
                what = f"tasks of flow '{name}' begin or end"
        if what is not None:
            expected = "at least one entry, or flows between stations or nodes"
            raise wrong(f"no storage places, where {what}, expected {expected}", TOP, "layout", "storage")
        return tasks

    @field_validator("pods")
    @classmethod
    def _lines_of_flows(cls, pods: PodsSpec | None, info: ValidationInfo) -> PodsSpec | None:
        tasks, layout = info.data.get("tasks"), info.data.get("layout")
        if pods is not None and tasks is not None and layout is not None:
            fit_for_pods(tasks.flows, layout.stations, known(info).zones.get("stations", {}))
            if layout.may_be_wide:
                text = "pods stand beside the lanes (pods), where there is no room for robots, expected narrow"
                raise wrong(f"{text} (got {got(layout.aisles)})", TOP, "layout", "aisles")
        return pods

    @field_validator("pickers")
    @classmethod
    def _can_walk_there(cls, pickers: PickersSpec | None, info: ValidationInfo) -> PickersSpec | None:
        tasks, fleet, layout = (info.data.get(key) for key in ("tasks", "fleet", "layout"))
        if pickers is None or tasks is None or fleet is None or layout is None:
            return pickers
        if info.data.get("pods") is not None:
            raise wrong("beside pods, which are brought to the people who pick, expected one of the two")
        if layout.lifts:
            raise wrong("beside lifts: people pick on one floor only, expected a layout without lifts")
        fit_for_pickers(pickers, tasks.flows)
        if pickers.stay == "order":
            if fleet.start_on_lanes:
                text = "a picker who stays is met in a bay or station, not in the lane; leave it out"
                raise wrong(text, TOP, "fleet", "start_on_lanes")
            own = [good.to for good in tasks.goods if isinstance(good, Good)] if isinstance(tasks.goods, tuple) else []
            unload_at = [*tasks.unload_at, *(name for name in own if name is not None)]
            fit_for_staying(tasks.flows, unload_at, known(info).zones.get("stations", {}))
        return pickers

    @field_validator("battery")
    @classmethod
    def _for_all(cls, battery: BatterySpec | None, info: ValidationInfo) -> BatterySpec | None:
        fleet: Fleet | None = info.data.get("fleet")
        for name, kind in () if fleet is None or battery is not None else fleet.kinds.items():
            if kind.battery is not None:
                text = "a battery for these robots, and none for others, expected `battery` in the model, too"
                raise wrong(text, TOP, "fleet", "kinds", name, "battery")
        return battery

    @field_validator("policies")
    @classmethod
    def _one_pod_at_a_time(cls, policies: Policies, info: ValidationInfo) -> Policies:
        if info.data.get("pods") is not None and policies.batching.name != "single":
            raise wrong(f"a robot carries one pod (got {got(policies.batching.name)}), expected single", "batching")
        return policies

    @field_validator("policies")
    @classmethod
    def _threshold_is_given(cls, policies: Policies, info: ValidationInfo) -> Policies:
        battery, fleet = info.data.get("battery"), info.data.get("fleet")
        if battery is None or fleet is None:
            return policies
        own = [(kind.battery, kind.charging, name) for name, kind in fleet.kinds.items()]
        for own_battery, charging, kind in [(battery, policies.charging, None), *own]:
            spec, policy = own_battery or battery, charging or policies.charging
            if (own_battery is None and charging is None) or policy.own or "threshold" in spec.model_fields_set:
                continue
            if catalogue.reads_threshold(policy.name, policy.params):
                place = "policies.charging" if charging is None or kind is None else f"fleet.kinds.{kind}.charging"
                expected = f"the level of energy at which robots charge, by {place}: {policy.name}"
                key = ("battery",) if own_battery is None or kind is None else ("fleet", "kinds", kind, "battery")
                raise wrong(f"missing, expected {expected}", TOP, *key, "threshold")
        return policies

    @field_validator("run")
    @classmethod
    def _ends(cls, run: RunSpec, info: ValidationInfo) -> RunSpec:
        tasks: Tasks | None = info.data.get("tasks")
        if tasks is None:
            return run
        if tasks.never_end and run.length is None:
            raise wrong(f"missing, expected the time at which the run ends, {_without_end(tasks)}", "length")
        if run.length is not None and "units" in info.data:
            hour = info.data["units"].hour
            rates = [mean_rate(flow, run.length, hour, run.start) or 0.0 for flow in tasks.flows.values()]
            if isinstance(tasks.goods, PoissonGoods):
                rates = [tasks.goods.poisson]
            at_most("tasks", round(math.fsum(rates) * tasks.demand * run.length / hour), "length")
        if problems := too_many({**info.data, "run": run}):
            raise all_wrong(problems)
        return run

    @property
    def is_deterministic(self) -> bool:
        """Whether runs of the model draw no random numbers, so that all are equal and one is enough.

        Known before a run, from what each section says of itself; what a run did is in `Run.deterministic`.
        """
        return not self.is_random(self)

    @property
    def floor(self) -> Layout:
        """The model's layout as it is driven, with the speed limits of slow zones that always hold.

        Raises:
            LayoutError: where two things claim one node.
        """
        slow = self.traffic.slow.values()
        return build(self.layout, *((zone.members, zone.speed) for zone in slow if zone.hours is None))

    @property
    def waits_apart(self) -> tuple[str, ...]:
        """The kinds of waits that runs of the model may have beside waits for other robots."""
        return tuple(name for name, state in APART.items() if state.applies(self))

    def hours(self, calendar: str | None) -> Hours:
        """Return a calendar as times of a run, or None for always."""
        if calendar is None:
            return ALWAYS
        return self.calendars[calendar].hours(self.run.start, 1 / self.units.seconds)

    def rates(self, profile: Profile, demand: float = 1.0) -> Rates:
        """Return a profile as times of a run."""
        return Rates(profile, self.units.hour, self.run.start, demand)

    def timetable(self, flow: FlowSpec) -> Timetable:
        """Return the departures of a flow as times of a run; without any if it has none."""
        return Timetable.of(flow.due_at, self.run.start, 1 / self.units.seconds)

    def __repr__(self) -> str:
        """Return the name, the size and the digest; sections print in full, such as `model.fleet`."""
        blocks, length = self.layout.blocks, self.run.length
        size = f"robots={self.fleet.size}, nodes={blocks.nodes if blocks else len(self.layout.nodes)}"
        run = "until all work is done" if length is None else f"length={length:g} {self.units.time}"
        return f"Model({self.name}: {size}, {run}, digest={self.digest()[:8]})"

    __str__ = __repr__

    def content(self) -> dict[str, Any]:
        """Return the content of the model, defaults too, as plain JSON values: equal models, equal content.

        Keys of sections stand in the order of the schema. Named parts (nodes, bays, stations, kinds) stand in the order
        of the file, which numbers them. `load` reads it back.
        """
        content: dict[str, Any] = super().content()
        return content

    def digest(self) -> str:
        """Return the SHA-256 of the content and of the user's own policies: equal for equal models, however written."""
        content = json.dumps(self.content(), separators=(",", ":"))
        return hashlib.sha256(content.encode() + self.policies.sources()).hexdigest()

    def replace(self, overrides: Mapping[str, Any], *, run_code: bool = False) -> Model:
        """Make a changed copy, checked like a file.

        Args:
            overrides: dotted keys and their values, such as `{"fleet.size": 3}`.
            run_code: ask the user's own policies about their parameters, too; see `load`.

        Raises:
            ModelError: with every problem of the changed model.
        """
        return model_of(from_mapping(self.content(), f"model '{self.name}'"), overrides, run_code=run_code)


OUTLINE = Outline(Model)
"""The keys that a model can have."""


def model_of(
    document: Document, overrides: Mapping[str, Any], named: str = "override", *, run_code: bool = False
) -> Model:
    """Make the model that a document and overrides say: every step of its way, in order.

    Raises:
        ModelError: with every problem of the values; where they are right, of the policies, and then of the orders.
    """
    override(document, overrides, OUTLINE, named)
    resolve(document, OUTLINE)
    model = valid(document, Model, OUTLINE)
    if problems := model.policies.problems(run_code):
        raise ModelError(report(problems, document.positions))
    _check_orders(model, document.positions.source)
    return model


def _check_orders(model: Model, source: str) -> None:
    """Read the files of orders once; raises ModelError with what is wrong with them, by row and column."""
    files = files_of(model.tasks.flows)
    try:
        problems = problems_of(files, reading(model, model.floor), source) if files else []
    except LayoutError:
        return  # the check of the layout says so
    if problems:
        raise ModelError(problems)


def reading(model: Model, layout: Layout) -> Reading:
    """Return the facts by which files of orders are read on a layout of a model."""
    return Reading.of(layout, model.run.start, model.units.seconds, model.pods)
