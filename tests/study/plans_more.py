"""Random warehouses planned with packers, over years and with two vendors, and what is true on many other days.

`python -m tests.study.plans_more packers 0 10` prints what it says of ten of them; so do `years` and `vendors`.
"""

import itertools
import random
import sys

import desim_warehouse as dw
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.questions.plan.options import plan_options
from desim_warehouse.study.search import Search
from desim_warehouse.study.statistics.cheapest import within_counts
from tests.study import plans
from tests.study.told import told

ROBOTS, CHARGERS, PACKERS = range(1, 11), range(1, 4), range(1, 4)
GLANCE, DAYS = 5, 40
"""Days on which every design is looked at, and those that may meet the target."""
FAR = 0.1
"""So far below the target a design is left after a glance."""
GROWTH, YEARS = 1.2, 3


def on_days(model, changes, days):
    """The mean of on_time on fresh days; 0 where the design cannot last."""
    study = dw.Study(model, changes=changes, replications=days, seed=plans.OTHER_SEED)
    study.run(cache=False)
    if any(verdict.is_lasting for verdict in study.results.verdicts[str(study.points[0])]):
        return 0.0
    return sum(0.0 if row.outcome.error else row.value("on_time") for row in study.rows) / days


def truth(plan, designs):
    """The mean of each design on other days, by its counts; few days of those that are far below the target."""
    means = {}
    for counts in designs:
        changes = plan.designs.overrides(counts)
        means[counts] = on_days(plan.model, changes, GLANCE)
        if means[counts] > plan.target.value - FAR or counts == plan.today.best.counts:
            means[counts] = on_days(plan.model, changes, DAYS)
    return means


def packed(number):
    """A warehouse of `plans.model` whose packers are busy, in a single station, and its target."""
    model, target = plans.model(number)
    rate = model.tasks.goods.poisson / 3600
    time = round(random.Random(number).uniform(0.6, 1.8) / rate, 1)
    spec = {"at": model.layout.stations["packing"].content()["at"][:1], "places": 12}
    due = model.tasks.goods.due_within + 2 * time
    changes = {
        "layout.stations.packing": spec,
        "tasks.unload_time": {"lognormal": {"mean": time, "cv": 0.3}},
        "tasks.goods.due_within": due,
    }
    return model.replace(changes), target


def packers(number):
    """Whether the counts named meet the target, and none cheaper does by more than the zone, down to a robot less.

    `cheapest` leaves out those of which the answer says that they may be enough, too; `smallest` does not.
    """
    model, target = packed(number)
    ranges = {"robots": list(ROBOTS), "chargers": list(CHARGERS), "packers": f"packing={PACKERS[0]}..{PACKERS[-1]}"}
    plan = plan_fleet(model, f"on_time >= {target}", strategies={}, search=Search(seed=number), **ranges)
    best = plan.today.best
    if best is None:
        return {"number": number, "named": None, "runs": plan.runs}
    near = itertools.product((best.robots - 1, best.robots), CHARGERS, PACKERS)
    cheaper = [counts for counts in near if counts[0] and counts <= best.counts]
    means = truth(plan, cheaper)
    true = means.pop(best.counts)
    left = [one.counts for one in plan.today.below if one.verdict.verdict == "undecided"]
    beyond = {counts: mean for counts, mean in means.items() if mean >= target + plan.zone}
    unsaid = {counts: mean for counts, mean in beyond.items() if not any(within_counts(counts, one) for one in left)}
    holds = {"meets": true >= target, "cheapest": not unsaid, "smallest": not beyond}
    return {
        "number": number,
        "target": target,
        "named": best.counts,
        "true": true,
        "beyond": beyond,
        **holds,
        "runs": plan.runs,
    }


def years(number):
    """Whether the years of a plan are those of separate plans, and the runs of both."""
    model, target = plans.model(number)
    how = {"strategies": {}, "search": Search(seed=number)}
    plan = plan_fleet(model, f"on_time >= {target}", growth="20%/year", years=YEARS, **how)
    alone = [
        plan_fleet(model.replace({"tasks.demand": round(GROWTH**year, 9)}), f"on_time >= {target}", **how)
        for year in range(YEARS + 1)
    ]
    together, separate = (
        [one.best and one.best.counts for one in answers] for answers in (plan.demands, [one.today for one in alone])
    )
    runs = plan.runs, sum(one.runs for one in alone)
    return {"number": number, "same": together == separate, "said": together, "separate": separate, "runs": runs}


def vendors(number):
    """Whether the difference in cost covers that of the cheapest fleets that meet the target on other days."""
    model, target = plans.model(number)
    draw = random.Random(-number)
    prices = {"hours": 4000, "robot": 6000, "charger": draw.choice([800, 2500])}
    speed = draw.uniform(1.2, 2.0)
    faster = {"fleet.robot.speed": round(speed, 2), "prices.robot": round(6000 * draw.uniform(0.9, 1.6), -2)}
    options = {"A": model.replace({"prices": prices, "fleet.robot.speed": 1}), "B": model.replace({"prices": prices})}
    options["B"] = options["B"].replace(faster)
    ranges = {"robots": list(ROBOTS), "chargers": list(CHARGERS)}
    comparison = plan_options(options, f"on_time >= {target}", search=Search(seed=number), **ranges)
    if not comparison.feasible:
        return {"number": number, "covers": None}
    costs = {}
    for name, plan in comparison.plans.items():
        best = plan.today.best
        designs = [one for one in plan.today.counts if abs(one[0] - best.robots) <= 1]
        designs = [one for one in designs if plan.designs.key(one) <= plan.designs.key(best.counts)]
        means = truth(plan, designs)
        costs[name] = min(plan.designs.cost(one) for one, mean in means.items() if mean >= target or one == best.counts)
    (one,) = comparison.against
    true = costs[one.name] - costs[comparison.first]
    return {
        "number": number,
        "said": (one.mean, one.low, one.high),
        "true": true,
        "covers": one.low <= true <= one.high,
    }


def main(kind, first, last):
    """Print what is said and what is true, and how many hold."""
    answers = told(range(int(first), int(last)), {"packers": packers, "years": years, "vendors": vendors}[kind])
    marks = [
        mark for mark in ("meets", "cheapest", "smallest", "same", "covers") if any(mark in one for one in answers)
    ]
    for mark in marks:
        decided = [one[mark] for one in answers if one.get(mark) is not None]
        sys.stdout.write(f"{mark}: {sum(decided)} of {len(decided)}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
