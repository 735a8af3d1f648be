"""Orders files that can be read in two ways: one reading for a column, said or refused; and files that harm."""

import io
import zipfile

import pandas as pd
import pytest

import desim_warehouse as dw
from desim_warehouse.orders.day import order_day
from desim_warehouse.values.fields import LIMITS
from tests.orders.test_day import book


def read(folder, model, text, name="day.csv", **options):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return order_day(path, model, **options)


def refused(folder, model, content, name="day.csv", **options):
    """Why a file is refused as a whole."""
    with pytest.raises(dw.ModelError) as error:
        read(folder, model, content, name, **options)
    return str(error.value)


def test_a_heading_that_is_there_twice_is_refused(hall, tmp_path):
    message = refused(tmp_path, hall, "release,release,order\n60,120,1\n")
    assert "column 'release' given twice, expected it once" in message
    assert "column 'Menge' given twice" in refused(tmp_path, hall, "Anlagedatum;Menge;Menge\n60;1;2\n")
    assert read(tmp_path, hall, "release,note,note\n60,a,b\n").problems == ()  # nobody reads them


def test_of_headings_that_mean_the_same_those_that_are_left_are_named(hall, tmp_path):
    day = read(tmp_path, hall, "RELEASE,Timestamp,release\n70,80,60\n")
    assert [line.release for line in day.lines] == [60]
    assert day.unread == ("RELEASE", "Timestamp")
    day = read(tmp_path, hall, "Lagerplatz;Von;Anlagedatum\n1;2;60\n")
    assert [line.source for line in day.lines] == [1]
    assert "'Lagerplatz' is from" in day.assumed[0]
    assert day.unread == ("Von",)


@pytest.mark.parametrize(
    ("cells", "releases", "wrong"),
    [
        (["1,5", "2,5"], [1.5, 2.5], []),
        (["1.5", "2.25"], [1.5, 2.25], []),
        (["1,5", "1.234,5", "1.234"], [1.5, 1234, 1234.5], []),
        (["2.5", "1.234"], [1.234, 2.5], []),
        (["0.125", "1.234"], [0.125, 1.234], []),
        (["1.234", "2.000"], [1234, 2000], []),
        (["1,5", "2.5", "3"], [1.5, 3], ["2.5"]),
        (["1.234,5", "2.5", "1,5"], [1.5, 1234.5], ["2.5"]),
    ],
    ids=str,
)
def test_a_column_has_one_reading_of_points_and_commas(hall, tmp_path, cells, releases, wrong):
    day = read(tmp_path, hall, "release;from\n" + "".join(f"{cell};1\n" for cell in cells))
    assert [line.release for line in day.lines] == releases
    message = "release: a decimal point and a decimal comma in one column (got '{}'), expected the same in all rows"
    assert [problem.split("row 2, ")[1] for problem in day.problems] == [message.format(cell) for cell in wrong]
    assert ("points in 'release' stand between thousands" in day.assumed) == (cells == ["1.234", "2.000"])


@pytest.mark.parametrize("cell", ["1'200", "1’200", "1 200", "1\u00a0200", "1\u202f200 Stk", "1 200,0"])
def test_blanks_and_apostrophes_stand_between_thousands(hall, tmp_path, cell):
    day = read(tmp_path, hall, f"release;quantity\n60;{cell}\n")
    assert (day.problems, day.pieces) == ((), 1200)
    assert read(tmp_path, hall, "release;quantity\n60;12 20\n").problems


def test_a_column_is_read_by_all_of_its_rows(hall, tmp_path):
    day = read(tmp_path, hall, "release;from\n1.234;1\n2;1\n2.5;1\n3;1\n")
    assert [line.release for line in day.lines] == [1.234, 2, 2.5, 3]
    [problem] = read(tmp_path, hall, "release;from\n1,5;1\n2;1\n2.5;1\n3;1\n").problems
    assert "row 3, release: a decimal point" in problem


@pytest.mark.parametrize("cell", ["1e308", "1e300", "1772431205", "1772431205000", "2040-01-01T00:00"])
def test_a_release_beyond_all_days_is_refused(hall, tmp_path, cell):
    day = read(tmp_path, hall, f"release,from\n2026-03-02T07:00,1\n{cell},1\n")
    assert any("row 2, release: later than 10 years after the start of the run" in one for one in day.problems)


def test_a_time_zone_that_is_left_out_is_said_and_another_one_refused(hall, tmp_path):
    day = read(tmp_path, hall, "release,from\n2026-03-02T07:00:00Z,1\n2026-03-02T07:30:00Z,1\n")
    assert [line.release for line in day.lines] == [3600, 5400]
    assert "'release' is as on the clock of the hall: Z is left out" in day.assumed
    day = read(tmp_path, hall, "release,from\n2026-03-02T07:00:00Z,1\n2026-03-02T07:30:00+01:00,1\n")
    assert len(day.lines) == 1
    [problem] = day.problems
    assert "row 2, release: a time of another zone than Z (got '2026-03-02T07:30:00+01:00')" in problem
    frame = pd.DataFrame({"release": pd.to_datetime(["2026-03-02T07:00:00Z"])})
    frame.to_parquet(tmp_path / "day.parquet")
    assert (
        "'release' is as on the clock of the hall: Z is left out" in order_day(tmp_path / "day.parquet", hall).assumed
    )


def test_which_priority_is_first_is_said(hall, tmp_path):
    day = read(tmp_path, hall, "release,Prio\n60,1\n70,3\n", columns={"release": "release", "priority": "Prio"})
    assert "'Prio' is higher where it is more urgent: 3 before 1" in day.assumed
    assert read(tmp_path, hall, "release,priority\n60,1\n70,1\n").assumed == ()


def test_a_sheet_is_of_excel_alone(hall, tmp_path):
    message = refused(tmp_path, hall, "release\n60\n", sheet="orders")
    assert "sheet (got 'orders') of a file that is no Excel file, expected none" in message


def parquet(**columns):
    out = io.BytesIO()
    pd.DataFrame(columns).to_parquet(out)
    return out.getvalue()


def test_bytes_in_parquet_are_text_or_refused(hall, tmp_path):
    day = read(tmp_path, hall, parquet(release=[b"60", b"07:30"], **{"from": [b"1", b"2"]}), "day.parquet")
    assert [(line.release, line.source) for line in day.lines] == [(60, 1), (5400, 2)]
    message = refused(tmp_path, hall, parquet(release=[60, 70], order=[b"\xff\xfe\x00", b"\x80"]), "day.parquet")
    assert "cannot be read (column 'order' has bytes that are no text)" in message
    frame = pd.DataFrame({"release": [60, 70], "order": pd.Categorical([b"a", b"b"])})
    frame.to_parquet(tmp_path / "kinds.parquet")
    assert [line.order for line in order_day(tmp_path / "kinds.parquet", hall).lines] == ["a", "b"]
    message = refused(tmp_path, hall, parquet(release=[60, 70], order=[[1], [2]]), "day.parquet")
    assert "column 'order' has list<element: int64>, expected text, numbers or times" in message


def test_text_in_parquet_that_is_none_is_refused(hall, tmp_path):
    import pyarrow as pa
    from pyarrow import parquet as pq

    raw = pa.array([b"\xff\xfe", b"b"], pa.binary())
    broken = pa.Array.from_buffers(pa.string(), 2, raw.buffers())
    pq.write_table(pa.table({"release": [60, 70], "order": broken}), tmp_path / "day.parquet")
    with pytest.raises(dw.ModelError, match="column 'order' has bytes that are no text"):
        order_day(tmp_path / "day.parquet", hall)


def stuffed(content, stored=False):
    """A workbook whose sheet is this text."""
    source, out = zipfile.ZipFile(io.BytesIO(book(("orders", [["release"], [1]])))), io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED if stored else zipfile.ZIP_DEFLATED) as file:
        for part in source.infolist():
            sheet = part.filename == "xl/worksheets/sheet1.xml"
            file.writestr(part.filename, content if sheet else source.read(part))
    return out.getvalue()


SHEET = (
    '<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>'
    '<row r="1"><c r="A1" t="inlineStr"><is><t>release</t></is></c></row>'
    '<row r="2"><c r="A2" t="inlineStr"><is><t>{}</t></is></c></row></sheetData></worksheet>'
)


def test_a_workbook_of_one_huge_cell_is_refused_before_it_is_opened(hall, tmp_path, monkeypatch):
    pytest.importorskip("openpyxl")
    assert read(tmp_path, hall, stuffed(SHEET.format(60)), "day.xlsx").lines[0].release == 60
    monkeypatch.setattr("openpyxl.load_workbook", None)
    small = stuffed(SHEET.format("x" * 20_000_000))
    assert len(small) < 100_000
    assert "too large when it is unfolded" in refused(tmp_path, hall, small, "day.xlsx")
    large = stuffed(SHEET.format("x" * 2_000_000), stored=True)
    assert "a cell or row longer than Excel writes them" in refused(tmp_path, hall, large, "day.xlsx")
    wide = SHEET.format("</t></is></c>" + '<c r="B2"><v>1</v></c>' * 1_200_000 + "<c><is><t>")
    assert "a cell or row longer than Excel writes them" in refused(
        tmp_path, hall, stuffed(wide, stored=True), "a.xlsx"
    )


def test_a_workbook_whose_used_range_is_the_whole_sheet_is_read_by_its_cells(hall, tmp_path):
    pytest.importorskip("openpyxl")
    used = SHEET.format(60).replace("<sheetData>", '<dimension ref="A1:XFD1048576"/><sheetData>')
    used = used.replace("</sheetData>", '<row r="9000"><c r="A9000"><v>90</v></c></row></sheetData>')
    assert [line.release for line in read(tmp_path, hall, stuffed(used), "day.xlsx").lines] == [60, 90]
    wide = used.replace("</sheetData>", '<row r="9001"><c r="XFD9001"><v>90</v></c></row></sheetData>')
    assert "a row of 16,384 cells, expected at most 1,000" in refused(tmp_path, hall, stuffed(wide), "day.xlsx")


def test_texts_in_parquet_that_take_gigabytes_are_refused_before_they_are_there(hall, tmp_path, monkeypatch):
    monkeypatch.setitem(LIMITS, "texts", (300_000, LIMITS["texts"][1]))
    long = parquet(release=[60, 70], order=["a", "x" * 400_000])
    assert "too large when it is unfolded" in refused(tmp_path, hall, long, "day.parquet")
    often = parquet(release=[60] * 50, order=["x" * 20_000] * 50)  # one text, written once
    assert len(often) < 10_000
    assert "50 rows have 1 MB of texts" in refused(tmp_path, hall, often, "day.parquet")
    assert read(tmp_path, hall, parquet(release=[60, 70], order=["a", "b"]), "day.parquet").orders == 2


@pytest.mark.parametrize("part", ["xl/workbook.xml", "xl/styles.xml", "xl/worksheets/sheet1.xml"])
def test_a_workbook_with_a_damaged_part_is_refused(hall, tmp_path, part):
    pytest.importorskip("openpyxl")
    content = bytearray(book(("orders", [["release"], [60]])))
    info = zipfile.ZipFile(io.BytesIO(content)).getinfo(part)
    begin = info.header_offset + 30 + len(part)
    content[begin : begin + 8] = b"\xff" * 8
    assert "cannot be read (damaged: " in refused(tmp_path, hall, bytes(content), "day.xlsx")


def test_a_table_of_more_columns_than_a_table_has_is_refused(hall, tmp_path):
    message = refused(tmp_path, hall, "release," + ",".join(f"c{number}" for number in range(1000)) + "\n60\n")
    assert "cannot be read (1,001 columns, expected at most 1,000)" in message


def of_articles(cells):
    """Sixty orders of tube, from 06:05 on, a minute apart, some with another article."""
    rows = [
        f"{4700 + n};{cells.get(n, 'Rohr')};02.03.2026 {6 + (5 + n) // 60:02}:{(5 + n) % 60:02};1;3"
        for n in range(1, 61)
    ]
    return "\n".join(["Auftragsnr;Artikel;Anlagedatum;Lagerplatz;Menge", *rows, ""])


@pytest.mark.parametrize(
    ("cells", "reason"),
    [
        (
            {20: '"1/2 Zoll Rohr', 40: '"3/4 Zoll Rohr'},
            "line 21: a cell that begins with a quote does not end with it (",
        ),
        ({20: '"1/2 Zoll Rohr'}, "line 21: a cell that begins with a quote does not end with it ("),
        ({20: '"1/2" Rohr'}, "line 21: a cell that begins with a quote does not end with it ("),
        (
            {20: '"1/2 Zoll Rohr', 40: 'Rohr 3/4"'},
            "line 21: two readings up to line 41: one row with a quoted cell, or",
        ),
        ({20: '"1/2 Zoll Rohr', 40: '3/4"'}, "line 21: two readings up to line 41: one row with a quoted cell, or"),
    ],
)
def test_an_inch_sign_that_begins_a_cell_swallows_no_orders(hall, tmp_path, cells, reason):
    (path := tmp_path / "day.csv").write_text(of_articles(cells))
    with pytest.raises(dw.ModelError) as refused:
        order_day(path, hall)
    assert f"day.csv: cannot be read ({reason}" in str(refused.value)
    assert "write a quote in a cell twice, and the cell in quotes" in str(refused.value)


@pytest.mark.parametrize(
    "cell", ['Rohr 1/2"', '"""1/2 Zoll Rohr"', '"Rohr; 1/2 Zoll"', '"Rohr\r\n1/2 Zoll;\nverzinkt"']
)
def test_quotes_with_one_reading_are_read(hall, tmp_path, cell):
    (path := tmp_path / "day.csv").write_text(of_articles({20: cell, 40: cell}))
    day = order_day(path, hall)
    assert (day.orders, day.pieces, day.problems) == (60, 180, ())


def test_a_quote_that_spans_cells_of_one_row_is_refused(hall, tmp_path):
    (path := tmp_path / "day.csv").write_text('release;from;to\n60;1;pack\n70;"1;pack"\n')
    with pytest.raises(dw.ModelError, match="line 3: two readings up to line 3"):
        order_day(path, hall)


def test_a_quote_swallows_no_rows_of_a_plain_table(hall, tmp_path):
    (path := tmp_path / "day.csv").write_text('release,order\n60,"1/2 in\n70,b\n80,"3/4 in\n')
    with pytest.raises(dw.ModelError, match=r"day.csv: cannot be read \(line 2: a cell that begins with a quote"):
        dw.load(hall, {"tasks.flows.day.arrivals.orders": {"file": str(path)}})
