"""Small random warehouses by number, planned by `plan_fleet`, and what became of its answer on many other days.

`python -m tests.study.plans 0 10` prints what it says of ten of them, and what is true. Those from 1000 on have a noon
peak, robots that break down, or more orders than fleets of the floor can do, one after the other.
"""

import random
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.questions.check import check
from desim_warehouse.questions.plan import plan_fleet
from tests.study.told import told

ON_TIME = Path(__file__).parent / "always_on_time.yaml"
"""A small floor on which four robots are never late."""
DAYS = 100
"""Fresh days on which an answer is looked at."""
OTHER_SEED = 1000
HARD = 1000
"""The first of those that are harder."""


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
    target = draw.choice([0.8, 0.9, 0.95])
    if number >= HARD:
        del changes["tasks.goods"]
        changes |= harder(number % 3, drafted.tasks.goods.poisson, due, draw)
    return drafted.replace(changes), target


def harder(kind, rate, due, draw):
    """A peak in the middle of the hour, breakdowns, or three to six times the orders."""
    if kind == 0:
        usual, peak = round(0.8 * rate), round(draw.uniform(1.4, 2.0) * rate)
        profile = {"every": "10 min", "per_hour": [usual] * 3 + [peak] * 2 + [usual] * 2}
        orders = {"from": "storage", "to": "packing", "arrivals": {"profile": profile}, "due_within": due}
        return {"tasks": {"flows": {"orders": orders}, "load_time": 12, "unload_time": 12}}
    if kind == 1:
        broken = {"every": {"exponential": draw.choice([1800, 3600])}, "repair": {"exponential": 300}}
        return {"tasks.goods": {"poisson": rate, "due_within": due}, "fleet.robot.breakdowns": broken}
    return {"tasks.goods": {"poisson": rate * draw.uniform(3, 6), "due_within": due}}


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
        return all(mean < self.target + self.zone for _, verdict, mean in self.below if verdict != "undecided")

    @property
    def misses(self):
        """Smaller ones even miss the target less the indifference zone: more than is promised."""
        return all(mean < self.target - self.zone for _, _, mean in self.below)


def on_other_days(described, changes, *, drifting=False):
    """The mean of on_time over fresh days; 0 for a day on which a robot runs flat, and where a backlog grows on.

    So it is where batteries fall, but for a `drifting` design only where chargers are too few: a hundred days show a
    slow drift to where they settle that no plan of forty sees.
    """
    study = dw.Study(described, changes={**changes}, replications=DAYS, seed=OTHER_SEED)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # days that end with a flat battery count as 0
            study.run()
    except dw.StudyError as error:
        if "no run finished" not in str(error):
            raise
        return 0.0
    verdicts = study.results.verdicts[str(study.points[0])]
    if any(verdict.is_lasting and not (drifting and verdict.code == "NOT_SETTLED") for verdict in verdicts):
        return 0.0
    return sum(0.0 if row.outcome.error else row.value("on_time") for row in study.rows) / DAYS


def answer(number):
    """Plan a model, and look at the answer."""
    described, target = model(number)
    plan = plan_fleet(described, f"on_time >= {target}", strategies={}, search=dw.Search(seed=number))
    outcome = Answer(number, target, plan.zone, plan.runs)
    if plan.today.best is not None:
        best = plan.today.best
        outcome.named = best.robots, best.chargers
        outcome.true = on_other_days(described, best.overrides, drifting=True)
        outcome.below = tuple(
            ((one.robots, one.chargers), one.vetoed or one.verdict.verdict, on_other_days(described, one.overrides))
            for one in plan.today.below
        )
    return outcome


def main(first, last):
    """Print the answers and how many of them hold."""
    answers = told(range(first, last), answer)
    named = [one for one in answers if one.named]
    counts = [sum(getattr(one, name) for one in named) for name in ("meets", "smallest", "misses")]
    sys.stdout.write("{} answers of {}: {} meet, {} smallest, {} miss\n".format(len(named), len(answers), *counts))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
