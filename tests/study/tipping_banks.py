"""Made-up plants whose thresholds are known exactly, and what a search with 250 runs says of them.

`python -m tests.study.tipping_banks 50` prints how many thresholds lie in their intervals, and how many were missed.
"""

import math
import random
import sys
from functools import cache

from desim_warehouse.report.example import example
from desim_warehouse.study.statistics.procedure import follow
from desim_warehouse.study.target import read_target
from desim_warehouse.study.tipping import TippingSearch

TARGET = read_target("on_time >= 95 %")
SHARED, OWN = 0.03, 0.02
PRICED = example().replace({"prices": {"hours": 4000, "robot": 6000}})
KEYS = ("fleet.robot.speed", "tasks.load_time", "tasks.unload_time", "traffic.node_time", "tasks.demand")


class Plant:
    """Robots that drive, load, unload and pass nodes; orders are late where they have too little time for all."""

    def __init__(self, number):
        self.name = f"plant {number}"
        draw = random.Random(self.name)
        middle = [draw.uniform(1.2, 1.6), draw.uniform(8, 16), draw.uniform(10, 25), draw.uniform(1, 2.5), 1.0]
        wide = [draw.uniform(0.05, 0.2), draw.uniform(0.1, 0.5), draw.uniform(0.1, 0.4), draw.uniform(0.2, 0.7), 0.1]
        self.ranges = [(m * (1 - w), m * (1 + w)) for m, w in zip(middle, wide, strict=True)]
        self.way, self.nodes, self.hourly = draw.uniform(60, 140), draw.randint(4, 12), draw.uniform(120, 260)
        self.mean = cache(self.mean)

    def slack(self, values, robots):
        speed, load, unload, node, demand = values
        cycle = self.way / speed + load + unload + self.nodes * node
        return robots * 3600 / cycle / (demand * self.hourly) - 1.12

    def mean(self, values, robots):
        slack, both = self.slack(values, robots), math.hypot(SHARED, OWN)
        steps = [-4 + 0.2 * step for step in range(41)]
        weights = [math.exp(-z * z / 2) for z in steps]
        return sum(w / (1 + math.exp(-(slack + both * z) / 0.05)) for w, z in zip(weights, steps, strict=True)) / sum(
            weights
        )

    def run(self, values, robots, day):
        noise = SHARED * random.Random(f"{self.name} {day}").gauss(0, 1)
        noise += OWN * random.Random(f"{self.name} {day} {values} {robots}").gauss(0, 1)
        return 1 / (1 + math.exp(-(self.slack(values, robots) + noise) / 0.05))

    def threshold(self, rank, robots):
        """Where an input makes a fleet too small, the others in the middle, by halving; None: nowhere in its range."""

        def mean(value):
            values = [(low + high) / 2 for low, high in self.ranges]
            values[rank] = value
            return self.mean(tuple(values), robots)

        low, high = self.ranges[rank]
        if TARGET.met_by(mean(low)) == TARGET.met_by(mean(high)):
            return None
        enough_low = TARGET.met_by(mean(low))
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (middle, high) if TARGET.met_by(mean(middle)) == enough_low else (low, middle)
        return (low + high) / 2


def searched(plant, runs=250, seed=0, begin=20, most=40):
    """What a search says of a plant that begins at a fleet of this rank; fleets above `most` cannot go on."""
    designs = []

    def number(values, robots):
        if (values, robots) not in designs:
            designs.append((values, robots))
        return designs.index((values, robots))

    search = TippingSearch(plant.ranges, range(1, 41), TARGET, number, runs, seed, begin)

    def run(design, day):
        values, robots = designs[design]
        return plant.run(values, robots, f"{seed} {day}") if robots <= most else TARGET.missed

    follow(search.steps(), run)
    return search.answer(KEYS, PRICED, 0.95)


def judged(plant, found):
    """Of each threshold said whether it is in its interval, how wide that is, and how many are not said.

    One that is not confirmed on a side, where its interval ends with the range, may lie beyond.
    """
    right, widths, left = [], [], 0
    for one in found.inputs:
        rank = KEYS.index(one.key)
        said = {tip.robots for tip in one.tips}
        for tip in one.tips:
            truth = plant.threshold(rank, tip.robots)
            beyond = not tip.confirmed and (tip.low == one.low or tip.high == one.high)
            right.append(beyond if truth is None else tip.low <= truth <= tip.high)
            widths.append((tip.high - tip.low) / (one.high - one.low))
        for robots in (found.robots - 1, found.robots):
            left += robots not in said and plant.threshold(rank, robots) is not None
    return right, widths, left


def main(count):
    """Print how many thresholds are in their intervals."""
    right, widths, left, runs, silent, confirmed = [], [], 0, 0, 0, 0
    for number in range(count):
        plant = Plant(number)
        found = searched(plant)
        runs = max(runs, found.runs)
        silent += not found.says_something
        confirmed += sum(tip.confirmed for one in found.inputs for tip in one.tips)
        some, wide, missing = judged(plant, found)
        right, widths, left = right + some, widths + wide, left + missing
    width = sorted(widths)[len(widths) // 2]
    sys.stdout.write(
        f"{count} plants, {silent} of them silent: {sum(right)} of {len(right)} thresholds in their intervals, "
        f"{confirmed} confirmed on both sides, half of the intervals below {100 * width:.0f} % of the range; "
        f"{left} not said; at most {runs} runs\n"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]))
