"""Small random warehouses by number, planned by `plan_fleet`, and what became of its answer on many other days.

`python -m tests.study.plans 0 10` prints what it says of ten of them, and what is true.
"""

from __future__ import annotations

import random
import sys
from dataclasses import dataclass
from pathlib import Path

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.run import check
from desim_warehouse.study.fleet import plan_fleet

ON_TIME = Path(__file__).parent / "always_on_time.yaml"
"""A small floor on which four robots are never late."""
DAYS = 100
"""Fresh days on which an answer is looked at."""
OTHER_SEED = 1000


def model(number):
    """A warehouse of up to 24 x 24 m, an hour of random orders, and a target."""
    draw = random.Random(number)
    size = (draw.randint(10, 24), draw.randint(10, 24))
    drafted = dw.Model.model_validate(read_yaml(draft(Draft(size, orders=draw.randint(40, 140))), "draft").data)
    due = round(check(drafted).calculation.cycle.time * draw.uniform(2, 3.5))
    changes = {
        "tasks.goods": {"poisson": drafted.tasks.goods.poisson, "due_within": due},
        "battery.consumption": draw.choice([0.03, 0.05]),
        "battery.charge_rate": 0.2,
        "policies.allocation": draw.choice(["in-order", "nearest", "hungarian"]),
        "run.length": 4200,
        "run.warm_up": 600,
        "log": "tasks",
    }
    return drafted.replace(changes), draw.choice([0.8, 0.9, 0.95])


@dataclass
class Answer:
    """What was said, and the mean on other days of the design named and of those that rule out smaller ones."""

    number: int
    target: float
    zone: float
    runs: int
    named: tuple[int, int] | None = None
    true: float = 0.0
    below: tuple[tuple[tuple[int, int], str, float], ...] = ()

    @property
    def meets(self):
        """The design named meets the target."""
        return self.true >= self.target

    @property
    def smallest(self):
        """None of those said to be too small is better than the target by the indifference zone."""
        return all(mean < self.target + self.zone for _, said, mean in self.below if said != "undecided")

    @property
    def misses(self):
        """Smaller ones even miss the target less the indifference zone: more than is promised."""
        return all(mean < self.target - self.zone for _, _, mean in self.below)


def on_other_days(described, changes):
    """The mean of on_time over fresh days; 0 for a day on which a robot runs flat, or whose backlog grows on."""
    study = dw.Study(described, changes={**changes}, replications=DAYS, seed=OTHER_SEED)
    study.run()
    if any(said.is_lasting for said in study.results.verdicts[str(study.points[0])]):
        return 0.0
    return sum(0.0 if row.outcome.error else row.value("on_time") for row in study.rows) / DAYS


def answer(number):
    """Plan a model, and look at the answer."""
    described, target = model(number)
    found = plan_fleet(described, f"on_time >= {target}", strategies={}, seed=number)
    said = Answer(number, target, found.zone, found.runs)
    if found.today.best is not None:
        best = found.today.best
        said.named, said.true = (best.robots, best.chargers), on_other_days(described, best.overrides)
        said.below = tuple(
            ((one.robots, one.chargers), one.vetoed or one.verdict.verdict, on_other_days(described, one.overrides))
            for one in found.today.below
        )
    return said


def main(first, last):
    """Print the answers and how many of them hold."""
    found = []
    for number in range(first, last):
        found.append(answer(number))
        sys.stdout.write(f"{found[-1]}\n")
        sys.stdout.flush()
    named = [said for said in found if said.named]
    counts = [sum(getattr(said, name) for said in named) for name in ("meets", "smallest", "misses")]
    sys.stdout.write("{} answers of {}: {} meet, {} smallest, {} miss\n".format(len(named), len(found), *counts))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
