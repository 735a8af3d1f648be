"""The paper's experiment: the goods of its groups, and what its figures and its authors' program give."""

import csv
from pathlib import Path

import benchmarks

GROUPS = dict(enumerate(benchmarks.GROUPS, start=1))
with (Path(__file__).parent / "program.csv").open() as file:
    CELLS = [{column: float(value) for column, value in row.items()} for row in csv.DictReader(file)]
