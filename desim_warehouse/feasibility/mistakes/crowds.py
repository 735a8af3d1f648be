"""Too much for the floor or fleet: robots on the lanes, loads on a robot, chargers; and settings that contradict."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of
from desim_warehouse.findings import Finding, amount
from desim_warehouse.model.facts.demand import arrival_rate

if TYPE_CHECKING:
    from collections.abc import Iterator

    from desim_warehouse.feasibility.estimate import QuickEstimate
    from desim_warehouse.model import Model


BESIDE = 0.1
"""Metres on either side of a robot in an aisle, at least: where people walk, rules ask for half a metre."""
EPS = 1e-9


def warnings(model: Model, found: QuickEstimate) -> Iterator[Finding]:
    """What cannot all be used at once."""
    fleet, batching = model.fleet, model.policies.batching
    out = min(fleet.size, model.traffic.most_out or fleet.size)
    if out > found.lanes_hold > 0:
        text = f"{out} robots, and the lanes hold {found.lanes_hold} at once: they would stand bumper to bumper"
        yield Finding("MORE_THAN_FIT", "fleet.size", text, "fewer robots, a longer floor, or traffic.most_out")
    size, most = batching.params.get("size"), fleet.largest_capacity
    if isinstance(size, int) and not batching.own and size > most > 1:
        text = f"tours of {size} loads, and a robot carries {most}: tours have {most}"
        yield Finding("MORE_THAN_FIT", "policies.batching.size", text, "fleet.robot.capacity, or a smaller size")
    yield from _windows(model)
    yield from _aisles(model, found)
    yield from _chargers(model)
    yield from _pace(model)


def _windows(model: Model) -> Iterator[Finding]:
    """Windows in which mostly no second task comes, so that there is nothing to put together."""
    batching, rate, unit = model.policies.batching, arrival_rate(model), model.units.time
    window = batching.params.get("window")
    if batching.name == "time-window" and isinstance(window, int | float) and rate and window * rate < 1:
        text = f"in {amount(window)} {unit} {amount(window * rate)} tasks come on average: few go together"
        yield Finding("UNUSUAL", "policies.batching.window", text, f"a longer window; times are in {unit}")


def _aisles(model: Model, found: QuickEstimate) -> Iterator[Finding]:
    """Aisles that are hardly wider than a robot."""
    blocks = model.layout.blocks
    if blocks is None or found.metre is None:
        return
    width = 2 * max(robot.radius for robot in model.fleet.distinct())
    for key in ("aisle_width", "cross_aisle_width"):
        aisle = getattr(blocks, key)
        if aisle is not None and width <= aisle < width + 2 * BESIDE / found.metre * (1 - EPS):
            unit = model.units.length
            text = f"an aisle is {aisle:g} {unit} wide, a robot {amount(width)} (2 x its radius)"
            yield Finding("NARROW_AISLES", f"layout.blocks.{key}", text, "fleet.robot.radius is half of its width")


def _chargers(model: Model) -> Iterator[Finding]:
    """More chargers than robots, where their number is given."""
    layout, robots = model.floor, model.fleet.size
    nodes = {name: sum(bay.zone == name for bay in layout.bays.values()) for name in model.layout.bays}
    bays = model.layout.bays.items()
    given = sum(bay.total_chargers or (bay.chargers or 0) * nodes[name] for name, bay in bays)
    if model.battery is not None and given > robots:
        text = f"{number_of(given, 'charger')} for {number_of(robots, 'robot')}"
        yield Finding("MORE_THAN_FIT", "layout.bays", text, "chargers is at each node, total_chargers in all")


def _pace(model: Model) -> Iterator[Finding]:
    """Robots that stop at every node though they accelerate, or are faster with a load."""
    robots, node_time = model.fleet.distinct(), model.traffic.node_time
    if node_time and any(robot.acceleration for robot in robots):
        text = (
            f"{amount(node_time)} {model.units.time} at every node beside an acceleration: robots stop at every node, "
            "and gather speed again"
        )
        yield Finding("STOPS_AT_NODES", "traffic.node_time", text, "node_time: 0, and turn_time for turns")
    for robot in robots:
        if robot.loaded_speed > robot.speed:
            text = f"{robot.loaded_speed:g} with a load, {robot.speed:g} without"
            yield Finding("FASTER_LOADED", "fleet.robot.speed_loaded", text, "a speed below fleet.robot.speed")
            return
