"""The paper's experiment: the goods of its groups, what its figures and its authors' program give; settings like it."""

import csv
from pathlib import Path

import benchmarks
from tests.reference import stepped

GROUPS = dict(enumerate(benchmarks.GROUPS, start=1))
with (Path(__file__).parent / "program.csv").open() as file:
    CELLS = [{column: float(value) for column, value in row.items()} for row in csv.DictReader(file)]


def settings(draws, number, **fixed):
    """Random experiments whose outcome in the reference does not turn on who goes first at a tie."""
    while number:
        drawn = {
            "robots": draws.randint(2, 6),
            "goods": tuple(draws.randrange(80) for _ in range(draws.randint(6, 14))),
            "unload_at": draws.choice("MNOPQR"),
            "threshold": draws.choice([2.5, 3.5, 5.0]),
            "consumption": draws.choice([0.004, 0.005, 0.006]),
        }
        setting = stepped.Setting(**{**drawn, **fixed})
        expected = stepped.simulate(setting)
        if expected == stepped.simulate(setting, higher_first=False):
            number -= 1
            yield setting, expected


def changes(setting):
    """The same experiment as changes to models/multibots.yaml."""
    return {
        "fleet.size": setting.robots,
        "tasks.goods": list(setting.goods),
        "tasks.unload_at": [setting.unload_at],
        "battery.threshold": setting.threshold,
        "battery.consumption": setting.consumption,
        "battery.reserve": 100,  # in the reference no battery runs flat
        "fleet.robot.margin": setting.margin,
    }
