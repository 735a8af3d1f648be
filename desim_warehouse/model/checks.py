"""What must fit together within a model, as far as it can be told without the graph of the layout."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import chain
from typing import TYPE_CHECKING, Any

from desim_warehouse.model import checks_layout
from desim_warehouse.model.checks_layout import node_problems, storage_places
from desim_warehouse.model.policy import KINDS
from desim_warehouse.model.problems import Problem, got
from desim_warehouse.model.schema import Good, PoissonGoods, Popularity, SaturatedGoods, SpreadEnergy
from desim_warehouse.policies.catalogue import problems

if TYPE_CHECKING:
    from desim_warehouse.model.places import Keys
    from desim_warehouse.model.schema import Model

_SUM = 1e-6  # shares written with a few digits add up to 1 within this


def check(model: Model, wrong: Iterable[Keys] = ()) -> list[Problem]:
    """Every problem between the values of a model.

    Args:
        model: the model; values known to be wrong replaced by any valid ones.
        wrong: the keys of these values: what depends on them is not checked.
    """
    bad = list(wrong)
    return [
        problem
        for find, needs in CHECKS
        if not any(_touch(tuple(need.split(".")), keys) for need in needs for keys in bad)
        for problem in find(model)
    ]


def _touch(one: Keys, other: Keys) -> bool:
    size = min(len(one), len(other))
    return one[:size] == other[:size]


def check_policies(
    model: Model, ask: Callable[[str, str, Mapping[str, Any]], list[tuple[str, str]]] | None = None
) -> list[tuple[str, str]]:
    """Ask the policies whether they can be had so: dotted keys, and what is wrong there.

    Args:
        model: the model with the names and parameters.
        ask: pairs of parameter ("" for the name) and message; default: the policies' own `problems`.
    """
    ask = ask or problems
    found = []
    for kind in KINDS:
        spec = getattr(model.policies, kind)
        for parameter, message in ask(kind, spec.name, spec.params):
            found.append((".".join(("policies", kind, *([parameter] if parameter else []))), message))
    return found


def _goods(model: Model) -> Iterator[Problem]:
    if not isinstance(model.tasks.goods, tuple):
        return
    places = storage_places(model.layout)
    for rank, item in enumerate(model.tasks.goods):
        listed = isinstance(item, Good)
        keys: Keys = ("tasks", "goods", rank, "good") if listed else ("tasks", "goods", rank)
        good = item.good if isinstance(item, Good) else item
        if good >= places > 0:
            expected = f"a number from 0 to {places - 1}" if places > 1 else "0, as there is one storage place"
            yield Problem.of(keys, "no such good", good, expected)


def _due(model: Model) -> Iterator[Problem]:
    goods = model.tasks.goods if isinstance(model.tasks.goods, tuple) else ()
    for rank, item in enumerate(goods):
        if isinstance(item, Good) and item.due is not None and item.due < item.release:
            expected = f"a time not before its release at {got(item.release)}"
            yield Problem.of(("tasks", "goods", rank, "due"), "due before it is known", item.due, expected)


def _start(model: Model) -> Iterator[Problem]:
    yield from node_problems(model.layout, ("fleet", "start"), model.fleet.start)


def _unload_at(model: Model) -> Iterator[Problem]:
    yield from node_problems(model.layout, ("tasks", "unload_at"), model.tasks.unload_at)


def _stations(model: Model) -> Iterator[Problem]:
    entries, size = len(model.tasks.unload_at), model.fleet.size
    if model.tasks.station_choice == "each" and entries not in {1, size}:
        robots = "1 robot" if size == 1 else f"{size} robots"
        expected = "one node" if size == 1 else f"one node for all, or {size}: one for each robot of fleet.size"
        wrong = f"{entries} nodes for {robots}"
        yield Problem.of(("tasks", "unload_at"), wrong, list(model.tasks.unload_at), expected)


def _popularity(model: Model) -> Iterator[Problem]:
    popularity, keys = model.tasks.popularity, ("tasks", "popularity")
    if not isinstance(popularity, Popularity):
        if popularity == "layout" and model.layout.blocks is not None:
            expected = "'uniform', classes or weights, as blocks say nothing of it"
            yield Problem.of(keys, "no popularity in the layout", popularity, expected)
        return
    if bool(popularity.classes) == bool(popularity.weights):
        both = "both classes and weights" if popularity.classes else "neither classes nor weights"
        yield Problem(keys, f"{both}, expected one of the two")
    for name in ("share", "demand") if popularity.classes else ():
        total = sum(getattr(item, name) for item in popularity.classes)
        if abs(total - 1) > _SUM:
            yield Problem.of((*keys, "classes"), f"{name}s do not add up", round(total, 9), "a sum of 1")


def _weights(model: Model) -> Iterator[Problem]:
    popularity, keys = model.tasks.popularity, ("tasks", "popularity", "weights")
    if not isinstance(popularity, Popularity) or not popularity.weights:
        return
    places, given = storage_places(model.layout), len(popularity.weights)
    if given != places:
        yield Problem(keys, f"{given} weights for {places} storage places, expected one for each")
    if not any(popularity.weights):
        yield Problem(keys, "all weights are 0, expected one above 0")


def _lifelong(model: Model) -> Iterator[Problem]:
    goods = model.tasks.goods
    if isinstance(goods, SaturatedGoods | PoissonGoods) and model.run.length is None:
        form = "saturated" if isinstance(goods, SaturatedGoods) else "poisson"
        value = {form: getattr(goods, form)}
        yield Problem.of(("tasks", "goods"), "work without an end", value, "run.length to say when a run ends")


def _threshold(model: Model) -> Iterator[Problem]:
    battery = model.battery
    if battery is not None and battery.threshold >= battery.capacity:
        expected = f"a level below battery.capacity, {got(battery.capacity)}"
        yield Problem.of(("battery", "threshold"), "too large", battery.threshold, expected)


def _start_energy(model: Model) -> Iterator[Problem]:
    spread = model.fleet.start_energy
    if isinstance(spread, SpreadEnergy) and spread.uniform[0] > spread.uniform[1]:
        expected = "the least first, then the most"
        yield Problem.of(("fleet", "start_energy", "uniform"), "turned round", list(spread.uniform), expected)


def _warm_up(model: Model) -> Iterator[Problem]:
    run = model.run
    if run.length is not None and run.warm_up >= run.length:
        expected = f"a time below run.length, {got(run.length)}"
        yield Problem.of(("run", "warm_up"), "too long", run.warm_up, expected)


def _kinds(model: Model) -> Iterator[Problem]:
    left = model.fleet.size
    for name, kind in model.fleet.kinds.items():
        if kind.count > left:
            wrong = f"more robots than are left of fleet.size, {model.fleet.size}"
            yield Problem.of(("fleet", "kinds", name, "count"), wrong, kind.count, f"at most {left}")
            return
        left -= kind.count


def _parameters(model: Model) -> Iterator[Problem]:
    for kind in KINDS:
        spec = getattr(model.policies, kind)
        for keys, value in _leaves(("policies", kind), spec.params):
            if isinstance(value, float) and value - value != 0:
                yield Problem.of(keys, "not a finite number", value, "a number")


def _leaves(keys: Keys, value: Any) -> Iterator[tuple[Keys, Any]]:
    if isinstance(value, Mapping):
        yield from chain.from_iterable(_leaves((*keys, key), item) for key, item in value.items())
    elif isinstance(value, tuple):
        yield from chain.from_iterable(_leaves((*keys, rank), item) for rank, item in enumerate(value))
    else:
        yield keys, value


_NODES = checks_layout.NODES
_PLACES = checks_layout.STORAGE_PLACES
CHECKS: tuple[tuple[Callable[[Model], Iterator[Problem]], tuple[str, ...]], ...] = (
    *checks_layout.CHECKS,
    (_start, (*_NODES, "fleet.start")),
    (_unload_at, (*_NODES, "tasks.unload_at")),
    (_stations, ("tasks.unload_at", "tasks.station_choice", "fleet.size")),
    (_goods, (*_PLACES, "tasks.goods")),
    (_due, ("tasks.goods",)),
    (_popularity, ("tasks.popularity", "layout.blocks")),
    (_weights, (*_PLACES, "tasks.popularity")),
    (_lifelong, ("tasks.goods", "run.length")),
    (_threshold, ("battery.threshold", "battery.capacity")),
    (_start_energy, ("fleet.start_energy",)),
    (_warm_up, ("run.warm_up", "run.length")),
    (_kinds, ("fleet.kinds", "fleet.size")),
    (_parameters, ("policies",)),
)
"""Every check with the keys it needs to be right."""
