"""Golden logs: what runs of fixed models must give, row by row.

They say that nothing has changed, not that it is right. After a change of results that is meant,

    python -m tests.golden.make

writes them anew; look at the difference before it goes in, and tell it in CHANGELOG.md under "Results change".
"""

import csv
import json
from pathlib import Path

import desim_warehouse as dw
from desim_warehouse.outcome.log import LogRow

HERE = Path(__file__).parent
SHIPPED = HERE.parent.parent / "models"
OWN = HERE / "models"
YARD = HERE.parent / "plants" / "yard.xml"
CASES = {
    # the paper's cell with 4 robots and goods group 2, with collisions
    "multibots": (
        SHIPPED / "multibots.yaml",
        {"fleet.size": 4, "tasks.goods": [74, 50, 62, 15, 49, 34, 14, 72, 31, 37]},
        0,
    ),
    # a station and node times: 8 robots on a floor for 3
    "tutorial": (
        SHIPPED / "tutorial.yaml",
        {"fleet.size": 8, "tasks.goods": [*range(12)], "traffic.node_time": 0.5},
        0,
    ),
    # the banker's rule on two-way lanes, with zones
    "two_way_zones": (OWN / "two_way_zones.yaml", {}, 1),
    # an edge that closes, and pickers in the aisles
    "closures_people": (
        SHIPPED / "people.yaml",
        {
            "run": {"length": 600, "warm_up": 100},
            "calendars": {"cleaning": {"every": 300, "lasts": 60, "first": 40}},
            "traffic.closures": {"cross aisle": {"members": [["M2", "M3"]], "hours": "cleaning", "tasks": "go"}},
        },
        2,
    ),
    # closures alone: one that robots can pass by, one with goods in it, which open and close
    "closures_one_way": (
        SHIPPED / "people.yaml",
        {
            "people": {},
            "run": {"length": 900, "warm_up": 100},
            "calendars": {"cleaning": {"every": 500, "lasts": 180, "first": 40}, "works": {"between": [[300, 600]]}},
            "traffic.closures": {
                "cross aisle": {"members": [["M2", "M3"]], "hours": "cleaning", "tasks": "go"},
                "aisle 3": {"members": [["M3", "N3"]], "hours": "works"},
            },
        },
        6,
    ),
    # the same on two-way lanes, where routes are declared
    "closures_two_way": (OWN / "two_way_closures.yaml", {}, 7),
    # flows, tours, calendars, chargers that fail, a worker with a buffer, batteries
    "flows": (OWN / "flows.yaml", {}, 3),
    # robots that gather speed, brake, turn, lose time and break down
    "acceleration_breakdowns": (
        SHIPPED / "tutorial.yaml",
        {
            "fleet.size": 5,
            "tasks.goods": [*range(10)],
            "fleet.robot.acceleration": 0.5,
            "fleet.robot.deceleration": 0.8,
            "fleet.robot.breakdowns": {"every": {"exponential": 60}, "repair": 25},
            "fleet.robot.delays": {"share": 0.2, "time": {"uniform": [1, 3]}},
            "traffic.turn_time": 1.5,
        },
        4,
    ),
    # a plant of openTCS drawn for the tests, with transport orders
    "imported": (YARD, YARD.with_name("orders.xml"), 5),
}
INDICATORS = HERE / "indicators.json"
"""Of every file in models/, all indicators of one short run."""
SHORT = {"large": 120.0, "medium": 900.0, "mir250": 3600.0, "my_own_day": 7200.0, "people": 3600.0}
"""How long the runs of lifelong models are made, in seconds: long enough for all that they have to happen."""
RECIPE = "# golden: made by `python -m tests.golden.make`, which says when to make it anew\n"


def run(case):
    path, changes, seed = CASES[case]
    model = dw.read_layout(path, tasks=changes) if isinstance(changes, Path) else dw.load(path, changes)
    return dw.simulate(model, seed)


def table(outcome):
    """The log as text: one list of fields a row, numbers in full."""
    return [["" if field is None else ">".join(field) if isinstance(field, tuple) else str(field) for field in row]
            for row in outcome.record.rows]  # fmt: skip


def indicators(name):
    """Return every indicator of a shipped model, by name; to nine digits, so that no processor's last bit counts."""
    length = SHORT.get(name)
    changes = {} if length is None else {"run.length": length, "run.warm_up": length / 4}
    kpis = dw.simulate(dw.load(SHIPPED / f"{name}.yaml", changes), 0).kpis
    return {key: f"{value:.9g}" for key, value in sorted(kpis.items())}


def shipped():
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def make():
    for case in CASES:
        with (HERE / f"{case}.csv").open("w", encoding="utf-8", newline="") as file:
            file.write(RECIPE)
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(LogRow._fields)
            writer.writerows(table(run(case)))
    INDICATORS.write_text(json.dumps({name: indicators(name) for name in shipped()}, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    make()
