"""Small plants whose thresholds are found by brute force, and whether they lie in the intervals that are said.

`python -m tests.study.tipping_truth 0 50` prints for fifty plants each threshold said with at most 250 runs, beside the
true one: by halving and a last straight line, on the same many other days everywhere.
"""

import math
import random
import statistics
import sys
from dataclasses import dataclass
from functools import cache

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.study.plan import run_seed
from desim_warehouse.study.target import read_target
from desim_warehouse.study.tipping import tipping_points

RUNS = 250
FIRST, MOST = 24, 96
"""Days of a true threshold: doubled while it is not told on which side of an end of the interval it is."""
CLEAR = 2.5
"""Standard errors by which it is told."""
HALVINGS = 3
OTHER_SEED = 1_000_000


def plant(number):
    """A floor of up to 14 x 14 m for a quarter or half of an hour, a target, and the ranges of two or three inputs."""
    draw = random.Random(f"tipping {number}")
    words = Draft((draw.randint(8, 14), draw.randint(9, 14)), orders=100, stations=2)
    drafted = dw.Model.model_validate(read_yaml(draft(words), "draft").data)
    always = draw.random() < 0.65
    cycle = dw.check(drafted).calculation.cycle.time
    wanted = {"poisson": round(draw.uniform(2, 4) * 3600 / cycle), "due_within": round(cycle * draw.uniform(2, 3.5))}
    at = drafted.layout.stations["packing"].content()["at"]
    middle = {
        "tasks.load_time": draw.uniform(6, 20),
        "tasks.unload_time": draw.uniform(8, 20),
        "fleet.robot.speed": draw.uniform(0.8, 1.6),
        "traffic.turn_time": draw.uniform(1, 4),
        "fleet.robot.acceleration": draw.uniform(0.3, 1),
    }
    if not always:
        middle["tasks.demand"] = draw.uniform(0.8, 1.2)
    changes = {
        "tasks.goods": {"saturated": 40} if always else wanted,
        "layout.stations": {"packing": {"at": at, "places": 20, "servers": 6}},
        "policies.allocation": draw.choice(["in-order", "nearest", "hungarian"]),
        "run": {"length": 960 if always else 2100, "warm_up": 60 if always else 300},
        "log": "tasks",
        "battery.consumption": 0.005,
        **middle,
    }
    if draw.random() < 0.7:
        del changes["battery.consumption"]
        changes["battery"] = None
    ranges = {}
    for key in draw.sample(list(middle), draw.choice([2, 3])):
        part = draw.uniform(0.3, 0.6)
        ranges[key] = (middle[key] * (1 - part), middle[key] * (1 + part))
    model = drafted.replace(changes)
    if not always:
        return model, f"on_time >= {draw.choice([80, 90, 95])} %", ranges
    hourly = dw.simulate(model.replace({"fleet.size": draw.randint(3, 6)}), 0).kpis["throughput_per_hour"]
    return model, f"throughput_per_hour >= {draw.uniform(0.9, 1.05) * hourly:.0f}", ranges


class Truth:
    """What fleets do in the middle of all ranges but one, by days that no search uses."""

    def __init__(self, model, target, ranges, number):
        self.model, self.goal, self.ranges = model, read_target(target, model.units.names), ranges
        self.seed = OTHER_SEED + number
        self.run = cache(self.run)

    def run(self, key, value, robots, day):
        middle = {one: (low + high) / 2 for one, (low, high) in self.ranges.items()}
        changed = self.model.replace({**middle, key: value, "fleet.size": robots})
        return dw.simulate(changed, run_seed(self.seed, day)).kpis[self.goal.indicator]

    def beyond(self, key, value, robots, days):
        """The mean less the target, and its standard error."""
        runs = [self.run(key, value, robots, day) for day in range(days)]
        return statistics.fmean(runs) - self.goal.value, statistics.stdev(runs) / days**0.5

    def threshold(self, key, tip, days=FIRST):
        """Where the mean crosses the target and the standard error of that; infinite: beyond that end of the range.

        It is sought between the ends of the interval, or beside it, where both ends are on one side.
        """

        def side(value):
            return self.beyond(key, value, tip.robots, days)[0] >= 0

        low, high = tip.low, tip.high
        if days < MOST and not all(self._is_clear(key, end, tip, days) for end in (low, high)):
            return self.threshold(key, tip, 2 * days)
        if side(low) == side(high):
            first, last = self.ranges[key]
            beside = [
                ends for ends in ((first, low), (high, last)) if ends[0] < ends[1] and side(ends[0]) != side(ends[1])
            ]
            if not beside:
                return (math.inf if side(low) == tip.above else -math.inf), 0.0
            low, high = beside[0]
        ends = low, high
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if side(low) == side(middle) else (low, middle)
        (near, error), (far, _) = (self.beyond(key, end, tip.robots, days) for end in (low, high))
        whole = [self.beyond(key, end, tip.robots, days)[0] for end in ends]
        slope = abs(whole[1] - whole[0]) / (ends[1] - ends[0])
        return low + (high - low) * near / (near - far), error / slope

    def _is_clear(self, key, value, tip, days):
        mean, error = self.beyond(key, value, tip.robots, days)
        return abs(mean) > CLEAR * error


@dataclass(frozen=True)
class Judged:
    """A threshold that was said, and where it is: `true` is infinite where it lies beyond that end of the range."""

    number: int
    key: str
    said: tuple[float, float, float]
    of_range: float
    confirmed: bool
    true: float
    error: float
    inside: bool


def judged(number):
    """What is said of a plant, each threshold beside the true one, and how many runs that took."""
    model, target, ranges = plant(number)
    found = tipping_points(model, target, ranges, search=dw.Search(runs=RUNS, seed=number, workers=1, cache=False))
    truth = Truth(model, target, ranges, number)
    every = []
    for one in found.inputs:
        for tip in one.tips:
            at, error = truth.threshold(one.key, tip)
            # An interval that ends with the range has all that lies beyond.
            low = -math.inf if tip.low == one.low else tip.low
            high = math.inf if tip.high == one.high else tip.high
            width, said = (tip.high - tip.low) / (one.high - one.low), (tip.low, tip.at, tip.high)
            every.append(Judged(number, one.key, said, width, tip.confirmed, at, error, low <= at <= high))
    return found, every


def main(first, last):
    """Print each threshold, and how many lie in their intervals."""
    every, silent, runs = [], 0, 0
    for number in range(first, last):
        found, thresholds = judged(number)
        every += thresholds
        silent += not found.says_something
        runs = max(runs, found.runs)
        sys.stdout.write(f"plant {number}: {found.target.text}, R2 {found.fit:.2f}, {found.runs} runs\n")
        for one in thresholds:
            true = f"{one.true:.4g} +- {one.error:.2g}"
            said = " ".join(f"{value:.4g}" for value in one.said)
            confirmed = "confirmed" if one.confirmed else "not confirmed"
            sys.stdout.write(f"  {one.key}: {said} {confirmed}; true {true}: {'in' if one.inside else 'OUT'}\n")
        sys.stdout.flush()
    inside = sum(one.inside for one in every)
    confirmed = [one for one in every if one.confirmed]
    errors = sorted(one.error / (one.said[2] - one.said[0]) for one in every if math.isfinite(one.true))
    widths = sorted(one.of_range for one in every)
    sys.stdout.write(
        f"{last - first} plants, {silent} silent, at most {runs} runs: {inside} of {len(every)} thresholds inside; "
        f"of those confirmed {sum(one.inside for one in confirmed)} of {len(confirmed)}; "
        f"half of the intervals below {100 * widths[len(widths) // 2]:.0f} % of the range, "
        f"half of the standard errors of the true ones below {100 * errors[len(errors) // 2]:.0f} % of the interval\n"
    )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
