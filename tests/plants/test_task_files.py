"""Files of tasks: each is read by its own reader, and refused by all others."""

from pathlib import Path

import pytest

import desim_warehouse as dw
from desim_warehouse.plants import import_layout, read_plant
from desim_warehouse.plants.formats import FORMATS, TASK_FILES
from tests.plants import drawings, grids

MAPD = "2\n1\n0\t1\t2\t0\t0\n5\t0\t1\t0\t0\n"
"""As the benchmark is published: the number of tasks, the horizon, then tasks with tabs."""
TASKS = {
    "openTCS": Path(__file__).with_name("orders.xml").read_text(),
    "LoRR": grids.ERRANDS,
    "LoRR of one cell each": "2\n1\n5\n",
    "MAPD": MAPD,
    "MAPD without a horizon": MAPD.replace("2\n1\n", "2\n", 1),
    "MAPD with both on one line": MAPD.replace("2\n1\n", "2 1\n", 1),
}


@pytest.mark.parametrize("name", TASKS)
def test_tasks_are_read_by_their_own_reader_and_refused_by_the_others(name, tmp_path):
    path = grids.written(tmp_path, "day.txt", TASKS[name])
    content = path.read_bytes()
    mine = name.split()[0]
    assert [one.name for one in TASK_FILES if one.looks(path, content)][:1] == [mine]
    for one in TASK_FILES:
        if one.name != mine:
            with pytest.raises(dw.ModelError):
                one.read(path, content, read_plant(drawings.kiva(tmp_path)))


@pytest.mark.parametrize("ending", [".txt", ".task", ".tasks"])
@pytest.mark.parametrize("name", drawings.DRAWN)
def test_no_reader_of_tasks_accepts_a_layout(name, ending, tmp_path):
    content = drawings.DRAWN[name](tmp_path).read_bytes()
    path = tmp_path / f"layout{ending}"
    for one in TASK_FILES:
        with pytest.raises(dw.ModelError):
            one.read(path, content, read_plant(drawings.kiva(tmp_path)))


@pytest.mark.parametrize("name", TASKS)
def test_no_reader_of_layouts_accepts_tasks(name, tmp_path):
    path = grids.written(tmp_path, "day", TASKS[name])
    for one in FORMATS:
        with pytest.raises(dw.ModelError):
            one.read(path, path.read_bytes())


@pytest.mark.parametrize("name", [name for name in TASKS if name.startswith("MAPD")])
def test_the_horizon_of_mapd_is_no_task(name, tmp_path):
    tasks = grids.written(tmp_path, "kiva.task", TASKS[name])
    made = import_layout(drawings.kiva(tmp_path), tasks=tasks)
    assert [(order.name, order.release, len(order.stops)) for order in made.plant.transports] == [
        ("task 0", 0.0, 2),
        ("task 1", 5.0, 2),
    ]


def test_tasks_of_mapd_that_are_called_as_those_of_lorr_are(tmp_path):
    tasks = grids.written(tmp_path, "kiva.tasks", MAPD)
    assert len(import_layout(drawings.kiva(tmp_path), tasks=tasks).plant.transports) == 2
