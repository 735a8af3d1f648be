"""Changed files of every reader: each is read, or refused by an error of the package, never by any other."""

import json
import random
import warnings

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import WarehouseError
from desim_warehouse.fleet_log import read_log
from desim_warehouse.orders.day import order_day
from desim_warehouse.plants import import_layout
from desim_warehouse.run import RunData
from desim_warehouse.study.reading import read_study
from tests.fleet_log.test_reading import message
from tests.orders.test_dates import HALL
from tests.plants.damage import damaged
from tests.plants.drawings import DRAWN

EACH, DAILY = 90, 3
"""Changed files of a reader in the long run, some 2,000 in all, and every day."""
ORDERS = [["order", "created", "Menge", "due", "note"]] + [
    [str(rank), f"2026-03-02 {6 + rank % 9:02}:{rank:02}", str(1 + rank % 3), f"03.03.2026 1{rank % 9}:00", "a, b"]
    for rank in range(40)
]


def orders_csv(folder):
    path = folder / "day.csv"
    path.write_text("\n".join(";".join(row) for row in ORDERS))
    return path


def orders_excel(folder):
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, the extra excel, is not installed")
    book = openpyxl.Workbook()
    for row in ORDERS:
        book.active.append(row)
    book.save(folder / "day.xlsx")
    return folder / "day.xlsx"


def orders_parquet(folder):
    import pandas as pd

    pd.DataFrame(ORDERS[1:], columns=ORDERS[0]).to_parquet(folder / "day.parquet")
    return folder / "day.parquet"


def trips(folder):
    path = folder / "trips.csv"
    rows = [f"r{rank % 3},A,B,2026-03-02 06:{rank:02}:00,02.03.2026 06:{rank:02}:40" for rank in range(50)]
    path.write_text("\n".join(["robot,pick,drop,start,end", *rows]))
    return path


def messages(folder):
    path = folder / "log.jsonl"
    path.write_text("\n".join(json.dumps(message(second, f"R{second % 3}")) for second in range(60)))
    return path


def a_model(folder):
    path = folder / "model.yaml"
    path.write_text(json.dumps(HALL, indent=1))
    return path


def a_study(folder):
    a_model(folder)
    path = folder / "study.yaml"
    path.write_text("model: model.yaml\nfactors:\n  fleet.size: [1, 2]\nreplications: 2\n")
    return path


def a_run(folder):
    changes = {"tasks.flows.day.arrivals": {"schedule": [{"at": 0, "tasks": 3}]}, "log": "all"}
    dw.simulate(dw.load(HALL, changes)).save(folder / "run")
    return folder / "run"


READERS = {
    **{f"layout {name}": (draw, import_layout) for name, draw in DRAWN.items()},
    **{f"orders {draw.__name__}": (draw, None) for draw in (orders_csv, orders_excel, orders_parquet)},
    "trips": (trips, read_log),
    "messages": (messages, read_log),
    "model": (a_model, dw.load),
    "study": (a_study, read_study),
    "run": (a_run, RunData.load),
}


def fuzzed(folder, name, count, first=0):
    """Read changed files of a reader; returns how many of them were refused."""
    make, read = READERS[name]
    hall = dw.load(HALL)
    path, refused = make(folder), 0
    beside = sorted(one for one in folder.rglob("*") if one.is_file())
    content = {one: one.read_bytes() for one in beside}
    for number in range(first, first + count):
        draw = random.Random(f"{name} {number}")
        hit = beside[number % len(beside)]
        hit.write_bytes(damaged(content[hit], draw))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                order_day(path, hall) if read is None else read(path)
        except WarehouseError:
            refused += 1
        except Exception as error:
            error.add_note(f"{name}, changed file {number}: {hit.name}")
            raise
        hit.write_bytes(content[hit])
    return refused


@pytest.mark.parametrize("name", READERS)
def test_a_changed_file_is_read_or_refused(name, tmp_path):
    fuzzed(tmp_path, name, DAILY)


@pytest.mark.long
@pytest.mark.parametrize("name", READERS)
def test_many_changed_files_are_read_or_refused(name, tmp_path):
    assert fuzzed(tmp_path, name, EACH, DAILY) > 0
