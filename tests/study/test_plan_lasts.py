"""What a plan names as enough is enough on the days after: fleets of random warehouses, three battery lives later."""

import itertools
import random

import pytest
from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.run.quick import estimate

TARGET, ZONE = 0.9, 0.01
FRESH_DAYS = 20


def warehouse(seed):
    """A small draft, with a charging policy and a battery drawn for it."""
    some = random.Random(seed)
    words = Draft(
        size=(some.choice((16, 24, 30)), some.choice((14, 20))),
        orders=some.choice((40, 60, 90, 120)),
        due=some.choice((3, 5, 8)),
    )
    drafted = dw.load(YAML(typ="safe").load(draft(words)))
    policy = some.choice(("four-thresholds", "threshold", "reach-aware", "opportunity"))
    changes = {"policies.charging": policy, "battery.charge_rate": some.choice((0.01, 0.02, 0.04))}
    if policy == "threshold":
        changes["battery.threshold"] = 0.3 * drafted.battery.capacity
    return drafted.replace(changes)


def falls_short(seed):
    """Whether the fleet that a plan names misses its target later; None where it names none."""
    model = warehouse(seed)
    plan = plan_fleet(model, f"on_time >= {TARGET}", strategies={}, search=dw.Search(runs=600, seed=seed))
    if plan.today.best is None or not plan.feasible:
        return None
    chosen = model.replace(plan.today.best.overrides)
    lasts = estimate(chosen).power.lasts
    later = chosen.replace({"run": {"warm_up": 3 * lasts, "length": 3 * lasts + 4 * 3600}})
    shares = []
    for day in range(FRESH_DAYS):
        try:
            shares.append(dw.simulate(later, 1000 + day).kpis["on_time"])
        except dw.BatteryError:
            shares.append(0.0)
    return sum(shares) / len(shares) < TARGET - ZONE


@pytest.mark.long
def test_at_most_two_of_twenty_plans_fall_short_three_battery_lives_later():
    """A plan takes half a minute of processor and more, so sixty would keep one of two processes busy for an hour."""
    outcomes = (falls_short(seed) for seed in itertools.count())
    named = itertools.islice((short for short in outcomes if short is not None), 20)
    assert sum(named) <= 2
