"""Random warehouses by number with one planted bottleneck, and what `why` says of them.

`python -m tests.study.bottlenecks 0 10` prints what it says of ten of them, and what carrying out the advice gains on
other days.
"""

from __future__ import annotations

import random
import sys
from dataclasses import dataclass

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.study.why import why

KINDS = ("node", "station", "chargers")
DAYS = 40
OTHER_SEED = 1000
HALF = 0.5
"""What the bottleneck lets through of what the warehouse does without it."""
CONSUMPTION = 0.1


def planted(number):
    """A model with work always waiting, in which one thing lets through half of what all others do; and its name."""
    draw, kind = random.Random(number), KINDS[number % len(KINDS)]
    size, robots = (draw.randint(14, 30), draw.randint(14, 30)), draw.randint(4, 8)
    drafted = draft(Draft(size, orders=60, stations=1, robots=robots, chargers=robots))
    changes = {
        "tasks.goods": {"saturated": 3 * robots},
        "battery.consumption": CONSUMPTION,
        "battery.charge_rate": 0.5,
        "battery.reserve": 100,  # nobody runs flat, however scarce chargers are
        "layout.stations.packing.servers": robots,
        "tasks.load_time": draw.randint(5, 15),
        "run.length": 3000,
        "run.warm_up": 600,
        "log": "all",
    }
    whole = dw.Model.model_validate(read_yaml(drafted, "draft").data).replace(changes)
    run = dw.simulate(whole, number)
    rate = run.kpis["throughput_per_hour"] / 3600
    if kind == "node":
        each = {name: run.nodes.passages[name] / run.kpis["tasks"] for name in run.nodes.index}
        busy = sorted(name for name, passages in each.items() if passages > HALF)
        node = draw.choice(busy)
        time = 1 / (HALF * rate * each[node])
        return whole.replace({f"traffic.nodes.{node}.time": time}), f"intersection {node}"
    if kind == "station":
        return whole.replace(
            {"layout.stations.packing.servers": 1, "tasks.unload_time": 1 / (HALF * rate)}
        ), "station packing"
    draws = CONSUMPTION * robots * HALF
    scarce = {"layout.bays.charging.total_chargers": 1, "battery.charge_rate": draws}
    return whole.replace(scarce), "chargers"


@dataclass
class Blame:
    """Who was planted, who is blamed, whom plain waiting blames, and the gain promised and had."""

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
    found = why(model, seed=number)
    suspect, gain = found.found[0]
    study = dw.Study(
        model, {"relief": {"cases": {"no": {}, "yes": dict(suspect.overrides)}}}, replications=DAYS, seed=OTHER_SEED
    )
    study.run()
    had = study.compare(found.indicator).differences[0].estimate.mean
    waiting = found.by_waiting
    return Blame(
        number,
        name,
        suspect.name,
        waiting.name if waiting else None,
        found.gains.clear,
        (gain.low, gain.high),
        had,
        found.gains.runs,
    )


def main(first, last):
    """Print who is blamed, and how often rightly."""
    found = []
    for number in range(first, last):
        found.append(blame(number))
        sys.stdout.write(f"{found[-1]}\n")
        sys.stdout.flush()
    right, kept = sum(one.right for one in found), sum(one.as_promised for one in found)
    waiting = sum(one.by_waiting == one.planted for one in found)
    sys.stdout.write(f"{len(found)}: {right} right, {kept} gains as promised, {waiting} right by plain waiting\n")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
