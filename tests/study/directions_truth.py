"""Small floors whose best directions are known, as all were simulated, and what a search finds on them.

`python -m tests.study.directions_truth 0 20` prints for twenty of them how far the directions found with at most 500
runs are from the best that there are. Runs of a search are drawn from those done for the truth.
"""

import random
import statistics
import sys
from dataclasses import dataclass

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.study.designs.directions import Floor
from desim_warehouse.study.designs.search import LocalSearch
from desim_warehouse.study.statistics import follow

RUNS = 500
DAYS = 12
"""Runs of every design of a floor."""


def model(number):
    """A floor of up to 5 x 3 blocks, on which work always waits."""
    draw = random.Random(number)
    words = Draft((20, 20), orders=60, stations=2, robots=8)
    drafted = dw.Model.model_validate(read_yaml(draft(words), "draft").data)
    robots = draw.randint(4, 12)
    columns = draw.randint(3, 5)
    return drafted.replace(
        {
            "tasks.goods": {"saturated": 2 * robots},
            "tasks.load_time": 2,
            "tasks.unload_time": 2,
            "fleet.size": robots,
            "layout.blocks": {
                **drafted.layout.blocks.content(),
                "columns": columns,
                "rows": draw.randint(2, 3),
                "block_depth": draw.randint(2, 5),
            },
            "layout.stations": {"packing": {"along": "south", "every": 2, "places": robots, "servers": 4}},
            "layout.bays": {"parking": {"along": "north", "places": robots}},
            "fleet.start": ["parking"],
            "battery": None,
            "run": {"length": 900, "warm_up": 100},
            "log": "tasks",
        }
    )


@dataclass(frozen=True)
class Found:
    """How many designs a floor has, the best mean, that of the floor as drawn, of what was found, and its error."""

    number: int
    designs: int
    best: float
    drawn: float
    chosen: float
    error: float

    @property
    def right(self):
        """Nothing that there is is better by more than two standard errors of a difference."""
        return self.chosen >= self.best - 2 * self.error


def bank(floor, described):
    """The indicator of every design that keeps the floor connected, day by day."""
    seen, new = set(), [floor.drawn]
    while new:
        seen.update(new)
        new = list({other for one in new for other in floor.neighbours(one) if floor.allows(other)} - seen)
    return {
        design: [
            dw.simulate(described.replace(floor.changes(design)), day).kpis["throughput_per_hour"]
            for day in range(DAYS)
        ]
        for design in sorted(seen)
    }


def found(number):
    """LocalSearch a floor, and look up what was found."""
    described = model(number)
    floor = Floor(described)
    runs = bank(floor, described)
    designs = list(runs)
    days = [random.Random(f"{number} {day}").randrange(DAYS) for day in range(RUNS)]
    steps = LocalSearch(floor, designs.index, RUNS * 4 // 5, random.Random(number), maximise=True).steps()
    chosen = follow(steps, lambda one, day: runs[designs[one]][days[day]])[0]
    means = {design: statistics.fmean(values) for design, values in runs.items()}
    best = max(means, key=means.get)
    gaps = [one - other for one, other in zip(runs[best], runs[chosen], strict=True)]
    error = statistics.stdev(gaps) / DAYS**0.5
    return Found(number, len(runs), means[best], means[floor.drawn], means[chosen], error)


def main(first, last):
    """Print what was found on each floor, and how often it is the best."""
    every = []
    for number in range(first, last):
        every.append(found(number))
        sys.stdout.write(f"{every[-1]}\n")
        sys.stdout.flush()
    sys.stdout.write(f"{len(every)}: {sum(one.right for one in every)} right\n")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
