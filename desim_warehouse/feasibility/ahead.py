"""What the world must know ahead of a run: the energy balance of a fleet in free flow."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.feasibility.estimate import MeanTask, mixed
from desim_warehouse.feasibility.free_flow import mean_task
from desim_warehouse.feasibility.pods import driven, pile_on
from desim_warehouse.feasibility.power import power
from desim_warehouse.model.facts.demand import arrival_rate
from desim_warehouse.model.facts.destinations import destinations

if TYPE_CHECKING:
    from desim_warehouse.feasibility.power import Power
    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model


def balance(model: Model, layout: Layout) -> Power | None:
    """The energy balance of a model, all tours full and driven as for one load; None without battery."""
    if model.pods is not None:
        model = driven(model, pile_on(model).most)
    if model.battery is None:
        return None
    draws, loads, tasks = model.battery.draws, most_loads(model), {}
    kinds = model.fleet.kinds_of_robots()
    for kind, robot in dict(zip(kinds, model.fleet.robots(), strict=True)).items():
        one = mean_task(model, layout, robot.speed, robot.loaded_speed).shared(loads)
        tasks[kind] = MeanTask(one.empty, one.load, one.loaded, one.unload, one.clear, one.energy(draws), 0.0)
    mean = mixed(tasks, {kind: kinds.count(kind) for kind in tasks})
    return power(model, layout, mean, tasks, arrival_rate(model), at_work(model, layout))


def most_loads(model: Model) -> int:
    """The most loads of a tour; with a batching policy of the user's as many as a robot carries."""
    if model.policies.batching.name == "single":
        return 1
    most, size = model.fleet.largest_capacity, model.policies.batching.params.get("size")
    return most if size is None else min(most, int(size))


def at_work(model: Model, layout: Layout) -> int:
    """Robots that can be on a task at once: each needs a slot at its station from the beginning."""
    used = destinations(model, layout)
    if model.tasks.flows or not all(node in layout.stations for node in used):
        return model.fleet.size
    return min(model.fleet.size, sum(layout.stations[node].places for node in used))
