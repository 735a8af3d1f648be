"""Random warehouses by number with one planted bottleneck, and what `why` says of them.

`python -m tests.study.bottlenecks 0 10` prints what it says of ten of them, and what carrying out the advice gains on
other days. From number 100 on they are such that plain waiting misleads: most of it is the consequence of something
else, or no robot waits for what is scarce.
"""

import math
import random
import sys
from dataclasses import dataclass

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.questions.why import why
from tests.study.told import told

MISLEADING = 100
"""The first number of a warehouse in which plain waiting misleads."""
DAYS = 40
OTHER_SEED = 1000
HALF = 0.5
"""What the bottleneck lets through of what the warehouse does without it."""
CONSUMPTION = 0.1
AS_DRAFTED_BEFORE = {
    "fleet.robot.acceleration": None,
    "traffic.node_time": 1,
    "traffic.turn_time": 0,
    "fleet.start_energy": {"uniform": [0.4, 1]},
}
"""Robots are at their speed at once and start more than half full, as in the warehouses of version 0.2.0: what pages
say was counted in those."""
BUSY = 0.8
"""The power of a charger at which many robots queue, as a share of what a fleet draws that never stands still; and the
capacity of a server for whom robots wait, as a share of what the warehouse does: neither limits half of it."""


def planted(number):
    """A model with work always waiting, in which one thing lets through half of what all others do; and its name."""
    draw = random.Random(number)
    kinds = (_node_and_chargers, _places, _robots) if number >= MISLEADING else (_node, _station, _chargers)
    plant = kinds[number % len(kinds)]
    size = draw.randint(14, 30), draw.randint(14, 30)
    robots = draw.randint(9, 14) if plant is _node_and_chargers else draw.randint(4, 8)
    drafted = draft(Draft(size, orders=60, stations=1, robots=robots, chargers=robots))
    whole = dw.Model.model_validate(read_yaml(drafted, "draft").data)
    changes = {
        **AS_DRAFTED_BEFORE,
        "tasks.goods": {"saturated": 3 * robots},
        "battery.consumption": {"standing": 0, **dict.fromkeys(("empty", "loaded", "handling"), CONSUMPTION)},
        "battery.charge_rate": 0.5,
        "battery.reserve": 100,  # with it, and as robots that wait draw nothing, no battery runs flat
        # Slots to wait in where chargers are scarce: as many as robots, over all nodes.
        "layout.bays.charging.places": math.ceil(robots / len(whole.layout.bays["charging"].at)),
        "layout.stations.packing.servers": robots,
        "tasks.load_time": draw.randint(5, 15),
        "run.length": 3000,
        "run.warm_up": 600,
        "log": "all",
    }
    whole = whole.replace(changes)
    changes, name = plant(whole, dw.simulate(whole, number), draw)
    return whole.replace(changes), name


def _rate(run):
    """Tasks a second."""
    return run.kpis["throughput_per_hour"] / 3600


def _node(_, run, draw):
    """A slow intersection."""
    each = {name: run.nodes.passages[name] / run.kpis["tasks"] for name in run.nodes.index}
    busy = sorted(name for name, passages in each.items() if passages > HALF)
    node = draw.choice(busy)
    time = 1 / (HALF * _rate(run) * each[node])
    return {f"traffic.nodes.{node}.time": time}, f"intersection {node}"


def _station(_, run, __):
    """A station with one server."""
    return _packer(run, HALF), "packers"


def _packer(run, share):
    return {"layout.stations.packing.servers": 1, "tasks.unload_time": 1 / (share * _rate(run))}


def _chargers(whole, _, __, share=HALF):
    """A single charger."""
    power = CONSUMPTION * whole.fleet.size * share
    return {"layout.bays.charging.total_chargers": 1, "battery.charge_rate": power}, "chargers"


def _node_and_chargers(whole, run, draw):
    """A slow intersection; most of the fleet is not needed, and part of it queues for the only charger."""
    slow, name = _node(whole, run, draw)
    return {**slow, **_chargers(whole, run, draw, BUSY)[0]}, name


def _places(whole, _, __):
    """Few slots at the station, which robots hold from setting out: those without one stand in bays or charge."""
    slots = max(whole.fleet.size // 2, 2)
    return {"layout.stations.packing.servers": 1, "layout.stations.packing.places": slots}, "places at the stations"


def _robots(whole, run, _):
    """Half the robots: scarce, though nothing waits for them; they wait for a server with capacity to spare."""
    return {**_packer(run, BUSY), "fleet.size": whole.fleet.size // 2}, "the number of robots"


@dataclass
class Blame:
    """What was planted, what is blamed, what plain waiting blames, and the gain promised and achieved."""

    number: int
    planted: str
    named: str
    by_waiting: str | None
    clear: bool
    interval: tuple[float, float]
    gain: float
    runs: int

    @property
    def right(self):
        """The planted one is named."""
        return self.clear and self.named == self.planted

    @property
    def as_promised(self):
        """The gain on other days lies in the interval."""
        return self.interval[0] <= self.gain <= self.interval[1]


def blame(number):
    """Ask why, carry out the advice on other days, and see what it gains."""
    model, name = planted(number)
    diagnosis = why(model, search=dw.Search(seed=number))
    suspect, gain = diagnosis.ranked[0]
    study = dw.Study(
        model, {"relief": {"cases": {"no": {}, "yes": dict(suspect.overrides)}}}, replications=DAYS, seed=OTHER_SEED
    )
    study.run()
    had = study.compare(diagnosis.indicator).differences[0].estimate.mean
    waiting = [one for one, _ in diagnosis.ranked if one.waited]  # who would be blamed without a test
    return Blame(
        number,
        name,
        suspect.name,
        max(waiting, key=lambda one: one.waited).name if waiting else None,
        diagnosis.gains.clear,
        (gain.low, gain.high),
        had,
        diagnosis.gains.runs,
    )


def summary(blames):
    """How many are right, keep their promise, and would be wrong by plain waiting."""
    right, kept = sum(one.right for one in blames), sum(one.as_promised for one in blames)
    misled = sum(one.by_waiting != one.planted for one in blames)
    return f"{len(blames)}: {right} right, {kept} gains as promised; plain waiting would be wrong in {misled}"


def main(first, last):
    """Print who is blamed, and how often rightly."""
    blames = told(range(first, last), blame)
    for name, among in (
        ("planted", [one for one in blames if one.number < MISLEADING]),
        ("planted where waiting misleads", [one for one in blames if one.number >= MISLEADING]),
    ):
        if among:
            sys.stdout.write(f"{name}: {summary(among)}\n")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
