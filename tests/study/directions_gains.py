"""What better directions gain on larger floors, on days that the search did not use, and whether they pass check.

`python -m tests.study.directions_gains 0 20` prints the gain on twenty floors over each as it is drawn: fourteen of 31
to 58 lanes, and six that others drew, which are read from the folder that `DESIM_PLANTS` names.
"""

import random
import sys
from pathlib import Path

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.plants import import_layout
from desim_warehouse.questions.orient import orient
from tests.plants.foreign import FOLDER

RUNS = 200
DRAWN = 14
"""Floors that this module draws; those that follow are imported."""
IMPORTED = {
    "opentcs/Demo-01_v7.xml": 4,
    "opentcs-touchmii/labmodel.xml": 5,
    "opentcs-touchmii/tsh.xml": 2,
    "rmf/office.building.yaml": 2,
    "ggo/kiva_small_r_mode_alternate_baseline_bi-directed.json": 8,
    "ggo/pibt_warehouse_33x36_w_mode.json": 8,
}
"""Layouts of others, with the robots on them."""


def model(number):
    """A floor of 4 x 3 to 6 x 4 blocks, or one that others drew, on which work always waits for ten minutes."""
    changes = {"battery": None, "run": {"length": 700, "warm_up": 100}, "log": "tasks"}
    if number >= DRAWN:
        name, robots = list(IMPORTED.items())[number - DRAWN]
        imported = import_layout(Path(FOLDER or "") / name, robots=robots).model
        return imported.replace(
            {**changes, "tasks.goods": {"saturated": 2 * robots}, "name": Path(name).name.split(".")[0]}
        )
    draw = random.Random(f"gains {number}")
    columns, rows, robots = draw.randint(4, 6), draw.randint(3, 4), draw.randint(6, 14)
    drafted = dw.Model.model_validate(read_yaml(draft(Draft((20, 20), orders=60, stations=2, robots=8)), "draft").data)
    blocks = {**drafted.layout.blocks.content(), "columns": columns, "rows": rows, "block_depth": draw.randint(3, 6)}
    return drafted.replace(
        {
            **changes,
            "name": f"{columns} x {rows} blocks",
            "tasks.goods": {"saturated": 2 * robots},
            "tasks.unload_at": ["packing"],
            "tasks.load_time": 3,
            "tasks.unload_time": 3,
            "fleet.size": robots,
            "layout.blocks": blocks,
            "layout.stations": {"packing": {"along": "south", "every": 2, "places": robots, "servers": 4}},
            "layout.bays": {"parking": {"along": "north", "places": robots}},
            "fleet.start": ["parking"],
        }
    )


def errors(described):
    """What `desim check` calls errors."""
    return {one.code for one in dw.check(described).findings if one.level == "error"}


def main(first, last):
    """Print the gain on each floor, and how many are shown to be gains."""
    shown, passed, searched = 0, 0, 0
    for number in range(first, last):
        drawn = model(number)
        directions = orient(
            drawn, "throughput_per_hour", search=dw.Search(runs=RUNS, seed=number, workers=1, cache=False)
        )
        lanes = len({frozenset(lane) for lane in drawn.floor.edges})
        passes = errors(directions.model) <= errors(drawn)
        gain = directions.gain
        finding = "nothing better than as drawn"
        if gain is not None:
            finding = f"{100 * gain.mean:+.1f} % ({100 * gain.low:+.1f} to {100 * gain.high:+.1f}), {gain.pairs} pairs"
        name = f"{drawn.name}, {lanes} lanes, {drawn.fleet.size} robots"
        sys.stdout.write(
            f"{number:2} {name}: {finding}; {len(directions.turned)} of {directions.units} turned, "
            f"{directions.runs} runs, {'passes check' if passes else 'DOES NOT PASS'}\n"
        )
        sys.stdout.flush()
        shown += gain is not None and bool(gain.is_better)
        passed, searched = passed + passes, searched + 1
    sys.stdout.write(f"{searched} floors: {shown} shown to gain, {passed} pass check\n")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
