"""Made-up plants whose thresholds are known exactly, and what a search says of them.

`python -m tests.study.tipping_banks 50` prints how many thresholds lie in their intervals, and how wide these are:
those of plants, and those of inputs with a mean of each shape.
"""

import math
import random
import sys
from functools import cache

import numpy as np

from desim_warehouse.study.designs.thresholds import DAYS, _Input, threshold_steps
from desim_warehouse.study.statistics.procedure import follow
from desim_warehouse.study.target import read_target

TARGET = read_target("on_time >= 95 %")
SHARED, OWN = 0.03, 0.02
KEYS = ("fleet.robot.speed", "tasks.load_time", "tasks.unload_time", "traffic.node_time", "tasks.demand")


class Plant:
    """Robots that drive, load, unload and pass nodes; orders are late where they have too little time for all.

    As many as are enough where all inputs have the middle of their ranges.
    """

    def __init__(self, number):
        self.name = f"plant {number}"
        draw = random.Random(self.name)
        self.middle = [draw.uniform(1.2, 1.6), draw.uniform(8, 16), draw.uniform(10, 25), draw.uniform(1, 2.5), 1.0]
        wide = [draw.uniform(0.05, 0.2), draw.uniform(0.1, 0.5), draw.uniform(0.1, 0.4), draw.uniform(0.2, 0.7), 0.1]
        self.ranges = [(m * (1 - w), m * (1 + w)) for m, w in zip(self.middle, wide, strict=True)]
        self.way, self.nodes, self.hourly = draw.uniform(60, 140), draw.randint(4, 12), draw.uniform(120, 260)
        self.mean = cache(self.mean)
        self.robots = 1
        while not TARGET.met_by(self.mean(tuple(self.middle))):
            self.robots += 1
            self.mean.cache_clear()

    def at(self, key, value):
        """All inputs, of which one has another value than that of the middle."""
        return tuple(value if one == key else middle for one, middle in zip(KEYS, self.middle, strict=True))

    def slack(self, values):
        speed, load, unload, node, demand = values
        cycle = self.way / speed + load + unload + self.nodes * node
        return self.robots * 3600 / cycle / (demand * self.hourly) - 1.12

    def mean(self, values):
        slack, both = self.slack(values), math.hypot(SHARED, OWN)
        steps = [-4 + 0.2 * step for step in range(41)]
        weights = [math.exp(-z * z / 2) for z in steps]
        return sum(w / (1 + math.exp(-(slack + both * z) / 0.05)) for w, z in zip(weights, steps, strict=True)) / sum(
            weights
        )

    def run(self, values, day):
        noise = SHARED * random.Random(f"{self.name} {day}").gauss(0, 1)
        noise += OWN * random.Random(f"{self.name} {day} {values}").gauss(0, 1)
        return 1 / (1 + math.exp(-(self.slack(values) + noise) / 0.05))

    def threshold(self, key, low, high):
        """Where an input makes the fleet too small, by halving; None: nowhere in its range."""
        enough_low = TARGET.met_by(self.mean(self.at(key, low)))
        if enough_low == TARGET.met_by(self.mean(self.at(key, high))):
            return None
        for _ in range(40):
            middle = (low + high) / 2
            is_lower = TARGET.met_by(self.mean(self.at(key, middle))) == enough_low
            low, high = (middle, high) if is_lower else (low, middle)
        return (low + high) / 2


def searched(plant, seed=0):
    """The thresholds that a search says, and how many runs it took."""
    designs = []

    def number(key, value):
        designs.append((key, value))
        return len(designs) - 1

    inputs = [_Input(key, *ends, TARGET) for key, ends in zip(KEYS, plant.ranges, strict=True)]
    steps = threshold_steps(inputs, number, DAYS)
    runs = follow(steps, lambda design, day: plant.run(plant.at(*designs[design]), f"{seed} {day}"))
    return [one.threshold() for one in inputs], runs


def judged(plant, thresholds):
    """Of each threshold whether it is in its interval, and how wide that is as a part of the range.

    One that is not confirmed, where its interval ends with the range, may lie beyond.
    """
    right, widths = [], []
    for one in thresholds:
        if one.at is None:
            continue
        low, high = one.within
        truth = plant.threshold(one.key, one.low, one.high)
        beyond = not one.confirmed and (low == one.low or high == one.high)
        right.append(beyond if truth is None else low <= truth <= high)
        widths.append((high - low) / (one.high - one.low))
    return right, widths


class Curve:
    """One input, 0 to 1, whose mean has a shape; days share most of their noise, which is skewed for every other."""

    key, low, high = "tasks.demand", 0.0, 1.0
    goal = read_target("cycle_time_mean <= 100")

    def __init__(self, shape, number):
        self.name = f"{shape} {number}"
        draw = random.Random(self.name)
        self.truth, self.noise, self.skewed = draw.uniform(0.1, 0.9), 10 ** draw.uniform(-1.8, -0.3), number % 2
        full, width = draw.uniform(0.6, 0.98), 10 ** draw.uniform(-2, -0.5)
        self.mean = {
            "line": lambda x: x,
            "hyperbola": lambda x: 1 / (1 - full * x),
            "logistic": lambda x: 1 / (1 + math.exp((self.truth - x) / width)),
            "step": lambda x: float(x > self.truth),
        }[shape]
        self.at_truth = 0.5 if shape == "step" else self.mean(self.truth)
        self.varies = 1.5 if shape == "hyperbola" else 0  # as queues do, the more the longer they are

    def run(self, x, day):
        both = [random.Random(f"{self.name} {day} {own}") for own in ("", x)]
        shared, own = ((r.gammavariate(2, 1) - 2) / math.sqrt(2) if self.skewed else r.gauss(0, 1) for r in both)
        noise = self.noise * self.mean(x) ** self.varies * (0.8 * shared + 0.6 * own)
        return 100 + self.mean(x) - self.at_truth + noise


class Queue:
    """A station M/M/1 and 30 s of driving: mean cycle time 30 + 100 / (1 - 0.3 demand), so 230 s at a demand of 5/3.

    A service takes 100 s, and 10.8 orders an hour arrive at a demand of 1, a load of 0.3.
    """

    key, truth = "tasks.demand", 5 / 3
    goal = read_target("cycle_time_mean <= 230")

    def __init__(self, _, number):
        self.name, draw = number, random.Random(number)
        self.low, self.high = (1.0, 3.2) if number % 2 else (draw.uniform(0.3, 1.4), draw.uniform(2.2, 3.2))

    def run(self, x, day):
        rng = np.random.default_rng([self.name, int(day)])
        between, services = rng.exponential(3600 / 10.8, 500), rng.exponential(100, 500)
        arrivals = np.cumsum(between) / x
        services = services[arrivals < 40_000]
        arrivals, work = arrivals[: len(services)], np.cumsum(services)
        ends = work + np.maximum.accumulate(arrivals - work + services)
        counted = (ends > 5_000) & (ends < 40_000)
        return 30 + float((ends - arrivals)[counted].mean())


SHAPES = {"line": Curve, "hyperbola": Curve, "logistic": Curve, "step": Curve, "station": Queue}


def shaped(shape, count):
    """Of inputs with a mean of one shape: whether each threshold is in its interval, how wide, and if confirmed."""
    told = []
    for number in range(count):
        curve, probes = SHAPES[shape](shape, number), []

        def design(_, value, probes=probes):
            probes.append(value)
            return len(probes) - 1

        ranged = _Input(curve.key, curve.low, curve.high, curve.goal)
        follow(
            threshold_steps([ranged], design, DAYS),
            lambda at, day, curve=curve, probes=probes: curve.run(probes[at], day),
        )
        threshold = ranged.threshold()
        if threshold.at is not None:
            low, high = threshold.within
            told.append((low <= curve.truth <= high, (high - low) / (curve.high - curve.low), threshold.confirmed))
    return told


def main(count):
    """Print how many thresholds are in their intervals."""
    right, widths, runs, confirmed, missed = [], [], 0, 0, 0
    for number in range(count):
        plant = Plant(number)
        thresholds, needed = searched(plant)
        runs = max(runs, needed)
        confirmed += sum(one.confirmed for one in thresholds if one.at is not None)
        missed += sum(
            one.at is None and one.confirmed and plant.threshold(one.key, one.low, one.high) is not None
            for one in thresholds
        )
        some, wide = judged(plant, thresholds)
        right, widths = right + some, widths + wide
    width = sorted(widths)[len(widths) // 2]
    sys.stdout.write(
        f"{count} plants: {sum(right)} of {len(right)} thresholds in their intervals, {confirmed} confirmed on both "
        f"sides, {missed} said to be nowhere, half of the intervals below {100 * width:.0f} % of the range; "
        f"at most {runs} runs\n"
    )
    for shape in SHAPES:
        inside, wide, confirmed = zip(*shaped(shape, count), strict=True)
        sys.stdout.write(
            f"{shape}: {sum(inside)} of {len(inside)} in their intervals, {sum(confirmed)} confirmed, "
            f"half of the intervals below {100 * sorted(wide)[len(wide) // 2]:.0f} % of the range\n"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]))
