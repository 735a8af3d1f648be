"""Small files and short words that would build something huge: each is refused in one line, in 500 MB."""

import io
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.daily import some

ROOT = Path(__file__).parents[2]
TUTORIAL, DAY, PLANT, PODS = (
    str(ROOT / "models" / name)
    for name in ("tutorial.yaml", "my_own_day.yaml", "how-to/plant.yaml", "gallery/goods-to-person.yaml")
)
MEGABYTES = 500
"""Of a command at most."""
MEASURED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
from benchmarks.memory import peak
from desim_warehouse.cli import main
try:
    sys.exit(main())
finally:
    print(peak())
"""
SHEET = '<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><dimension ref="A1:XFD1048576"/>'
HEAD = '<sheetData><row r="1"><c r="A1" t="inlineStr"><is><t>release</t></is></c></row>'
STATE = (
    '{{"timestamp":{0},"serialNumber":"r{1}","lastNodeId":"n{0}","driving":true,"errors":[],"actionStates":[],'
    '"batteryState":{{"batteryCharge":5}}}}\n'
)


def written(path, text):
    path.write_text(text)
    return str(path)


def workbook(path, rows):
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, the extra excel, is not installed")
    plain = io.BytesIO()
    openpyxl.Workbook().save(plain)
    with zipfile.ZipFile(plain) as source, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for part in source.infolist():
            sheet = part.filename == "xl/worksheets/sheet1.xml"
            file.writestr(part, f"{SHEET}{HEAD}{rows}</sheetData></worksheet>" if sheet else source.read(part))
    return str(path)


def parquet(path, **columns):
    import pyarrow as pa
    from pyarrow import parquet as pq

    pq.write_table(pa.table(columns), path)
    return str(path)


def drawing(path, blocks):
    """A DXF drawing of blocks inside each other, each with eight of the one before, or of one in an array."""
    ezdxf = pytest.importorskip("ezdxf", reason="ezdxf, the extra dxf, is not installed")
    document = ezdxf.new()
    document.blocks.new("B0").add_line((0, 0), (1, 0))
    for rank in range(1, blocks):
        block = document.blocks.new(f"B{rank}")
        for place in range(8):
            block.add_blockref(f"B{rank - 1}", (place, rank))
    many = {} if blocks > 1 else {"row_count": 30_000, "column_count": 30_000, "row_spacing": 2, "column_spacing": 2}
    document.modelspace().add_blockref(f"B{blocks - 1}", (0, 0), dxfattribs=many)
    document.saveas(path)
    return str(path)


def far(folder):
    return workbook(folder / "day.xlsx", '<row r="1048576"><c r="A1048576"><v>3</v></c></row>')


def wide(folder):
    return workbook(
        folder / "day.xlsx", "".join(f'<row r="{r}"><c r="XFD{r}"><v>1</v></c></row>' for r in range(2, 9000))
    )


ORDERS = {
    "a used range of the whole sheet": (far, "too many rows, expected at most 1,000,000"),
    "rows to the end of the sheet": (wide, "a row of 16,384 cells, expected at most 1,000"),
    "a cell of Parquet": (
        lambda folder: parquet(folder / "day.parquet", release=[1.0], order=["x" * 300_000_000]),
        "too large when it is unfolded",
    ),
    "rows of Parquet": (
        lambda folder: parquet(folder / "day.parquet", release=[1.0] * 5_000_000),
        "too many rows, expected at most 1,000,000",
    ),
    "one text of many rows": (
        lambda folder: parquet(folder / "day.parquet", release=[1.0] * 30_000, order=["x" * 20_000] * 30_000),
        "30,000 rows have 600 MB of texts",
    ),
    "a line of CSV": (
        lambda folder: written(folder / "day.csv", "release,order\n1," + "x" * 210_000_000),
        "too large, expected CSV of at most 200 MB",
    ),
    "rows of CSV": (lambda folder: written(folder / "day.csv", "release\n" + "1\n" * 2_000_000), "too many rows"),
}
LOGS = {
    "rows of trips": (
        lambda folder: written(folder / "t.csv", "robot,pick,drop,start,end\n" + "r,A,B,1,2\n" * 600_000),
        "too many rows, expected at most 500,000",
    ),
    "robots of messages": (
        lambda folder: written(folder / "log.jsonl", "".join(STATE.format(rank, rank) for rank in range(20_000))),
        "more than 10,000 robots, expected the log of a fleet",
    ),
    "nodes of messages": (
        lambda folder: written(folder / "log.jsonl", "".join(STATE.format(rank, 1) for rank in range(120_000))),
        "more than 100,000 nodes, expected the log of a fleet",
    ),
}
LAYOUTS = {
    "an array of blocks": (lambda folder: drawing(folder / "plan.dxf", 1), "too many entities in blocks"),
    "blocks inside blocks": (lambda folder: drawing(folder / "plan.dxf", 12), "too many entities in blocks"),
    "elements of XML": (
        lambda folder: written(
            folder / "plan.graphml",
            '<graphml><graph edgedefault="directed">' + '<node id="a"/>' * 600_000 + "</graph></graphml>",
        ),
        "too many elements, expected 500,000 at most",
    ),
    "values of JSON": (
        lambda folder: written(
            folder / "plan.json", '{"directed":true,"nodes":[' + '{"id":1},' * 2_000_000 + '{}],"links":[]}'
        ),
        "too many values, expected 1,000,000 at most",
    ),
    "cells of a grid": (
        lambda folder: written(folder / "a.map", "type octile\nheight 100000\nwidth 100000\nmap\n" + "." * 9_000_000),
        "row 0 has 9000000 cells, expected 100000 as the head of the file says",
    ),
}
NEW = {
    ("--packers", "1000000000"): "--packers 1000000000: out of range, expected 1 to 20000",
    ("--orders", "200000/h"): "--orders 200000/h: too many, expected at most 100000/h",
    ("--robots", "1000000000"): "--robots 1000000000: out of range, expected 1 to 1000",
    ("--inbound", "1000000000/h"): "--inbound 1000000000/h: too many, expected at most 100000/h",
    ("--size", "1000000x1000000m"): "aisles with 10,288,323,045 nodes, expected at most 100,000",
}
SET = {
    (PODS, "tasks.flows.picks.lines=[1, 1000000000]"): "lines.1: too large (got 1000000000), expected at most 10,000",
    (PODS, "pods.items=1000000000"): "pods.items: too large (got 1000000000), expected at most",
    (TUTORIAL, "tasks.goods={random: 1000000000}"): "random: too large (got 1000000000), expected at most 1,000,000",
    (TUTORIAL, "layout.bays.parking.places=1000000000"): "places: too large (got 1000000000), expected at most 10,000",
    (TUTORIAL, "calendars={a: {every: 1 ms, lasts: 0.5 ms}}"): "about 14400000 openings and closings in an hour",
}


def refused(message, *words, most=MEGABYTES):
    """The one line that a command says, with what it refuses; its memory is measured."""
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, *words], cwd=ROOT, capture_output=True, text=True, check=False, timeout=120
    )
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr[-2000:]
    assert message in done.stderr
    assert float(done.stdout.split()[-1]) <= most


@pytest.mark.parametrize("name", some(ORDERS, 7))
def test_orders_that_would_fill_the_memory(name, tmp_path):
    make, message = ORDERS[name]
    refused(message, "orders", make(tmp_path), "--model", DAY)


@pytest.mark.parametrize("name", some(LOGS, 3))
def test_logs_that_would_fill_the_memory(name, tmp_path):
    make, message = LOGS[name]
    refused(message, "calibrate", make(tmp_path), "--model", PLANT, "--out", str(tmp_path / "c.yaml"))


@pytest.mark.parametrize("name", some(LAYOUTS, 5))
def test_layouts_that_would_fill_the_memory(name, tmp_path):
    make, message = LAYOUTS[name]
    refused(message, "import", make(tmp_path), "-o", str(tmp_path / "m.yaml"))


@pytest.mark.parametrize("words", some(NEW, 5))
def test_drafts_that_would_fill_the_memory(words, tmp_path):
    refused(NEW[words], "new", str(tmp_path / "m.yaml"), *words)


@pytest.mark.parametrize("change", some(SET, 5))
def test_changes_that_would_fill_the_memory(change):
    refused(SET[change], "check", change[0], "--set", change[1])


@pytest.mark.long
def test_pods_times_what_each_holds():
    message = "pods.per_pod: too large (got 36000000), expected at most 2,000,000 (items on all"
    words = [word for key in ("count=40", "items=1000000", "per_pod=900000") for word in ("--set", f"pods.{key}")]
    refused(message, "check", PODS, *words)


@pytest.mark.long
@pytest.mark.parametrize("values", [5_000_000, 2_000_000])
def test_values_of_yaml_that_would_fill_the_memory(values, tmp_path):
    goods = "tasks:\n  goods: [" + "3," * values + "3]\n"
    refused(
        "too many values, expected 1,000,000 at most", "check", written(tmp_path / "m.yaml", goods[:9_999_990] + "]\n")
    )
