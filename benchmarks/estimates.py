"""How near is the quick estimate to long runs? Random drafts at 60 to 120 % load, or goods to person by each policy.

    python -m benchmarks.estimates [FIRST] [LAST]
    python -m benchmarks.estimates pods [FIRST] [LAST]

A draft's delivered tasks an hour are held against the range of `check`, up to what is asked for, and its warnings
against whether the run falls behind by more than 5 %. Floors with pods are asked for all that they can do. What runs
did is kept in build/estimates.json, as only the estimates change.
"""

import json
import random
import sys
from pathlib import Path
from typing import Any

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.model import Model
from desim_warehouse.model.parse import read_yaml, valid
from desim_warehouse.model.schema import OUTLINE
from desim_warehouse.questions.run.lasting import OVERLOADS
from desim_warehouse.run.probe import probe

KEPT = Path("build/estimates.json")
DRAFTS, FLOORS = 40, 6
BEHIND = 0.05
"""Part of what is asked for by which a run that falls behind is overloaded."""
NOISE = 0.02
"""Part by which a run may miss a bound."""
WIDE = 0.25
NEAR = 0.15
PODS = ("random", "nearest", "most-lines")


def hall(number: int) -> Model:
    """A random draft: its floor, robots, chargers and people, and a load of 60 to 120 % of what robots can carry."""
    drawn = random.Random(number)
    width, height, robots = drawn.randint(14, 45), drawn.randint(14, 34), drawn.randint(2, 9)
    stations, packers, people = drawn.choice([1, 2]), drawn.choice([1, 1, 2]), drawn.random() < 1 / 2
    changes: dict[str, Any] = {
        "fleet.robot.acceleration": drawn.choice([0.3, 0.5, 1.0]),
        "fleet.robot.speed": drawn.choice([1.0, 1.5, 2.0]),
        "battery.consumption": drawn.choice([0.0015, 0.003, 0.005]),
        "run.length": "14 h",
        "run.warm_up": "2 h",
    }
    if drawn.random() < 1 / 4:
        changes["layout.blocks.directions"] = "two-way"
    if drawn.random() < 1 / 4:
        changes["fleet.robot.breakdowns"] = {"every": {"exponential": "12 h"}, "repair": "15 min"}
    flows, load, spare = drawn.random() < 1 / 3, drawn.uniform(0.6, 1.2), drawn.choice([0, 1, 1])
    chargers = -(-robots * changes["battery.consumption"] // 0.02) + spare
    words = Draft(
        size=(width, height),
        orders=30,
        robots=robots,
        chargers=max(int(min(chargers, robots)), 1),
        stations=stations,
        packers=stations * packers,
        people=people,
    )
    first = valid(read_yaml(draft(words), f"draft {number}"), Model, OUTLINE)
    if flows:
        tasks = {key: value for key, value in first.content()["tasks"].items() if key not in {"goods", "unload_at"}}
        orders = {"from": "storage", "to": "packing", "arrivals": {"poisson": 30}}
        changes["tasks"] = {**tasks, "flows": {"orders": orders}}
    model = first.replace(changes)
    one = probe(model)
    rate = load * robots * 3600 / (one.time + one.charging)
    return model.replace({"tasks.flows.orders.arrivals.poisson" if flows else "tasks.goods.poisson": round(rate, 1)})


def floor(number: int, policy: str) -> Model:
    """A floor with pods of one of six sizes, its lines always waiting, with a policy of pods."""
    drawn = random.Random(number)
    side, robots, nodes = drawn.randint(3, 7), drawn.randint(3, 14), drawn.choice([1, 2])
    south = block_nodes(side, side)[-1]
    at = [south[1], south[-2]][:nodes]
    places = side * side * 8
    pods = {"count": int(places * 0.85), "items": drawn.choice([50, 100, 400]), "per_pod": drawn.choice([3, 8, 15])}
    waiting = drawn.choice([12, 40, 200])
    content = {
        "layout": {
            "blocks": {
                "columns": side,
                "rows": side,
                "block_width": 2,
                "block_depth": 4,
                "goods_size": 1,
                "aisle_width": 1,
                "directions": "ring",
            },
            "bays": {"parking": {"along": "north", "chargers": 0, "places": -(-robots // (side + 1)) + 1}},
            "stations": {"picking": {"at": at, "places": 9, "servers": 1}},
        },
        "fleet": {"size": robots, "robot": {"radius": 0.35, "margin": 0.2, "speed": 1.5}},
        "tasks": {
            "load_time": 2.2,
            "unload_time": 2.2,
            "flows": {
                "picks": {
                    "from": "storage",
                    "to": "picking",
                    "arrivals": {"saturated": waiting},
                    "stop_time": drawn.choice([4, 10]),
                }
            },
        },
        "pods": {**pods, "change_time": 5},
        "policies": {"allocation": "nearest", "routing": "fastest", "parking": "nearest", "pod": policy},
        "run": {"length": "6 h", "warm_up": "1 h"},
        "log": "tasks",
    }
    return dw.load(content)


def kept(name: str, model: Model) -> tuple[float, float]:
    """Tasks an hour that a long run did, and that came, kept from run to run."""
    rates = json.loads(KEPT.read_text("utf-8")) if KEPT.exists() else {}
    key = f"{name} {model.digest}"
    if key not in rates:
        kpis = dw.simulate(model, 1).kpis
        done = kpis["throughput_per_hour"]
        rates = json.loads(KEPT.read_text("utf-8")) if KEPT.exists() else {}
        rates[key] = done, done + kpis.get("backlog_growth_per_hour", 0.0)
        KEPT.parent.mkdir(exist_ok=True)
        KEPT.write_text(json.dumps(rates, indent=0), "utf-8")
    done, came = rates[key]
    return done, came


def drafts(first: int, last: int) -> None:
    """Print a row for each draft, and how many lie in their range."""
    inside = missed = wide = 0
    for number in range(first, last):
        model = hall(number)
        (done, came), checked = kept(f"draft {number}", model), dw.check(model)
        estimate = checked.calculation
        assert estimate is not None
        least, most = (does * 3600 for does in estimate.range)
        is_in = min(least, came) * (1 - NOISE) <= done <= min(most, came) * (1 + NOISE)
        width = (most - least) / ((most + least) / 2) if most else 0.0
        codes = [item.code for item in checked.findings if item.code in OVERLOADS]
        behind = 1 - done / came
        silent = behind > BEHIND and not codes
        inside, missed, wide = inside + is_in, missed + silent, wide + (width > WIDE)
        print(
            f"{number:3} {estimate.robots} robots came {came:6.1f} can {estimate.can_do(3600):>16} did {done:6.1f} "
            f"({100 * behind:+5.1f} % behind) need {estimate.robots_needed:.2f} {estimate.bottleneck}, {codes} "
            f"{'' if is_in else 'OUTSIDE '}{'SILENT ' if silent else ''}{'WIDE ' if width > WIDE else ''}"
            f"{'ZERO' if not estimate.most else ''}",
            flush=True,
        )
    print(f"{inside} of {last - first} inside, {wide} wider than {WIDE:.0%}, {missed} overloads missed")


def pods(first: int, last: int) -> None:
    """Print a row for each floor and policy of pods, and how many estimates are near."""
    near = every = 0
    for number in range(first, last):
        for policy in PODS:
            model = floor(number, policy)
            (done, _), estimate = kept(f"floor {number} {policy}", model), dw.check(model).calculation
            assert estimate is not None
            least, most = (does * 3600 for does in estimate.range)
            is_near = least * (1 - NEAR) <= done <= most * (1 + NEAR)
            near, every = near + is_near, every + 1
            print(f"{number} {policy:10} can {estimate.can_do(3600):>16} did {done:6.1f} {'' if is_near else 'FAR'}")
    print(f"{near} of {every} within {NEAR:.0%}")


def main() -> None:
    """Print the rows that are asked for."""
    of_pods = sys.argv[1:2] == ["pods"]
    numbers = [int(text) for text in sys.argv[2 if of_pods else 1 :]]
    first, last = [*numbers, *[0, FLOORS if of_pods else DRAFTS][len(numbers) :]]
    (pods if of_pods else drafts)(first, last)


if __name__ == "__main__":
    main()
