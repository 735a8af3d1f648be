"""A day of orders from an ERP: ten files as messy as real ones, and hostile ones."""

import datetime as dt
import io
import json
import shlex
import zipfile

import pandas as pd
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.answer.root_words import root
from desim_warehouse.cli import desim
from desim_warehouse.orders.day import order_day
from desim_warehouse.outcome.chains import LANE, Root
from desim_warehouse.questions.check import check
from desim_warehouse.questions.run import load_run
from desim_warehouse.questions.run.page import lost_time
from desim_warehouse.report.export import export
from desim_warehouse.values.fields import LIMITS

pytestmark = pytest.mark.usefixtures("brief_probes")


def rows(form, separator=";", header="Auftragsnr;Angelegt am;Von Platz;Ziel;Menge", places=range(8)):
    """Sixteen lines of eight orders, two an hour from 06:05 on, each of three pieces."""
    lines = [header.replace(";", separator)]
    for number in range(16):
        time = MORNING + dt.timedelta(minutes=30 * number)
        cells = [f"{4711 + number // 2}", time.strftime(form), str(places[number % 8]), "pack", "3"]
        lines.append(separator.join(cells))
    return lines


MORNING = pd.Timestamp("2026-03-02 06:05").to_pydatetime()
GERMAN = "%d.%m.%Y %H:%M:%S"
ORDER_HEADINGS = ["order", "release", "from", "to", "due", "quantity"]
HEAD = "Auftragsnr;Anlagedatum;Lagerplatz;Ziel;Menge"


def book(*sheets, merge=(), formulas=()):
    """A workbook with sheets of rows."""
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, the extra excel, is not installed")
    made = openpyxl.Workbook()
    made.remove(made.active)
    for name, cells in sheets:
        sheet = made.create_sheet(name)
        for row in cells:
            sheet.append(row)
        for cell, formula in formulas:
            sheet[cell] = formula
        for cells_ in merge:
            sheet.merge_cells(cells_)
    out = io.BytesIO()
    made.save(out)
    return out.getvalue()


def excel_rows():
    return [
        [f"{4711 + number // 2}", MORNING + dt.timedelta(minutes=30 * number), number % 8, "pack", 3]
        for number in range(16)
    ]


def text(lines, encoding="utf-8"):
    return "\r\n".join(lines).encode(encoding)


def two_columns():
    lines = rows("%d.%m.%Y;%H:%M", header="Auftrag;Datum;Uhrzeit;Platz;Ziel;Menge")
    return text(lines)


MESSY = {
    "semicolons, German dates": ("a.csv", text(rows(GERMAN, header=HEAD)), []),
    "Windows, umlauts": (
        "a.csv",
        text(rows(GERMAN, header="Auftragsnr;Anlagedatum;Lagerplatz;Ziel;Stück"), "cp1252"),
        [],
    ),
    "UTF-16, tabs": ("a.txt", text(rows("%Y-%m-%dT%H:%M", "\t", header=HEAD), "utf-16"), []),
    "US dates": ("a.csv", text(rows("%m/%d/%Y %I:%M %p", ",", header=HEAD)), ["--dates", "us"]),
    "title above, in no order, comments": (
        "a.csv",
        text(["Orders of Monday;;;;", "", *(lines := rows(GERMAN, header=HEAD))[:1], *reversed(lines[1:])]),
        [],
    ),
    "date and time apart": ("a.csv", two_columns(), []),
    "thousands and decimals": (
        "a.csv",
        text([line.removesuffix(";3") + ";3,0" * (";3" in line[-3:]) or line for line in rows(GERMAN, header=HEAD)][:1])
        + b"\r\n"
        + text([line.removesuffix("3") + "3,0" for line in rows(GERMAN, header=HEAD)[1:]]),
        [],
    ),
    "names of its own": (
        "a.csv",
        text(rows("%Y-%m-%d %H:%M", "|", header="nr;wann;wo;wohin;wieviel")),
        [
            part
            for pair in ("order=nr", "release=wann", "from=wo", "to=wohin", "quantity=wieviel")
            for part in ("--map", pair)
        ],
    ),
    "Excel, title, second sheet": (
        "a.xlsx",
        lambda: book(("notes", [["see orders"]]), ("orders", [["Orders"], [], HEAD.split(";"), *excel_rows()])),
        ["--sheet", "orders"],
    ),
    "Excel, units below headings": (
        "a.xlsx",
        lambda: book(("orders", [[*HEAD.split(";")[:4], "Menge\n(Stk)"], *excel_rows()])),
        [],
    ),
    "Excel, merged": (
        "a.xlsx",
        lambda: book(
            ("orders", [HEAD.split(";"), *excel_rows()]), merge=[f"A{2 * rank}:A{2 * rank + 1}" for rank in range(1, 9)]
        ),
        [],
    ),
}


@pytest.mark.parametrize("name", MESSY)
def test_a_messy_file_gives_a_day_in_two_commands(name, hall, tmp_path):
    file, content, options = MESSY[name]
    path = tmp_path / file
    path.write_bytes(content() if callable(content) else content)
    out = tmp_path / "orders.parquet"
    done = CliRunner().invoke(desim, ["orders", str(path), "--model", str(hall), "--out", str(out), *options])
    assert done.exit_code == 0, done.output
    assert "8 orders, 16 lines, 48 pieces, 16 trips, 06:05 to 13:35, from 2026-03-02 on" in done.output
    assert "busiest hour: 06:00 to 07:00, 2 trips" in done.output
    run = dw.simulate(dw.load(hall))
    assert run.kpis["tasks"] == 16
    releases = [task.released for task in run.history.tasks.values()]
    assert releases == [300 + 1800 * number for number in range(16)]


def refused(model, **orders):
    """Why a model that names a file of orders is refused, a line for each problem."""
    with pytest.raises(dw.ModelError) as error:
        dw.load(model, {"tasks.flows.day.arrivals.orders": orders})
    return error.value.problems


HEADINGS = {"order": "Auftragsnr", "release": "Anlagedatum", "from": "Lagerplatz", "to": "Ziel", "quantity": "Menge"}


@pytest.mark.parametrize(
    ("keys", "tasks"),
    [
        ({}, 16),
        ({"quantity": "pieces", "pieces_per_load": 2}, 32),
        ({"columns": HEADINGS}, 48),
        ({"columns": HEADINGS, "quantity": "pieces", "dates": "uk"}, 16),
    ],
)
def test_a_model_that_names_an_export_is_refused_with_the_command_that_makes_a_plain_table(keys, tasks, hall, tmp_path):
    (tmp_path / "day.csv").write_bytes(MESSY["semicolons, German dates"][1])
    (problem,) = refused(hall, file=str(tmp_path / "day.csv"), **keys)
    assert problem.startswith("override tasks.flows.day.arrivals.orders.file: no plain")
    assert f"column '{HEAD}'; no column 'release')" in problem
    assert all(key in problem for key in keys)
    program, *arguments = shlex.split(problem.partition("the one that this makes: ")[2])
    assert program == "desim"
    done = CliRunner().invoke(desim, arguments)
    assert done.exit_code == 0, done.output
    plain = dw.load(hall, {"tasks.flows.day.arrivals.orders": {"file": arguments[-1]}})
    assert dw.simulate(plain).kpis["tasks"] == tasks


@pytest.mark.parametrize(
    ("content", "seen"),
    [
        ("Created,bin\n06:05,1\n", "columns 'Created', 'bin'; no column 'release'"),
        ("relase,from\n06:05,1\n", "column 'relase'; did you mean 'release'?"),
        ("release,from,Status\n06:05,1,open\n", "column 'Status'"),
        ("release,release\n06:05,06:05\n", "column 'release' twice"),
        ("from,to\n1,pack\n", "no column 'release'"),
        ("", "no column 'release'"),
        ("release,Stück\n06:05,1\n".encode("cp1252"), "not text in UTF-8"),
    ],
)
def test_what_makes_a_file_an_export_is_named(content, seen, hall, tmp_path):
    path = tmp_path / "day.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    (problem,) = refused(hall, file=str(path))
    assert f"no plain table of orders (got {seen}), expected" in problem
    assert problem.endswith(f"desim orders {path} --model {hall} --out {path.with_suffix('.parquet')}")


def test_a_workbook_is_no_plain_table(hall, tmp_path):
    (tmp_path / "day.xlsx").write_bytes(book(("orders", [["release"], [60]])))
    (problem,) = refused(hall, file=str(tmp_path / "day.xlsx"), sheet="orders")
    assert "(got sheet: 'orders'; a workbook)" in problem
    assert "day.xlsx --sheet orders --model" in problem


@pytest.mark.parametrize("cell", ["02.03.2026 06:05", "2026-03-02T06:05Z", "2026-03-02", '"1,200"', "6:05 AM", "-"])
def test_a_plain_table_has_cells_in_one_form(cell, hall, tmp_path):
    (tmp_path / "day.csv").write_text(f"release,from\n{cell},1\n")
    problem, command = refused(hall, file=str(tmp_path / "day.csv"))
    bare = cell.strip('"')
    assert f"row 1, release: not a time (got '{bare}'), expected a number of at least 0, or a time such as" in problem
    assert f"is read by: desim orders {tmp_path / 'day.csv'} --model {hall}" in command


def test_a_parquet_file_of_another_program_is_not_written_over(hall, tmp_path):
    pd.DataFrame({"Created": [60], "bin": [1]}).to_parquet(tmp_path / "day.parquet")
    (problem,) = refused(hall, file=str(tmp_path / "day.parquet"))
    assert problem.endswith(f"--out {tmp_path / 'day-plain.parquet'}")


def test_a_model_of_an_earlier_version_may_say_what_was_so_anyway(hall, tmp_path):
    (tmp_path / "day.csv").write_text("release,from\n06:05,1\n2026-03-02T06:15,1\n2700,1\n")
    nothing = {"columns": {}, "sheet": None, "dates": None, "quantity": "tasks", "pieces_per_load": None}
    named, bare = (
        dw.load(hall, {"tasks.flows.day.arrivals.orders": {"file": str(tmp_path / "day.csv"), **keys}})
        for keys in (nothing, {})
    )
    assert named.digest() == bare.digest()
    assert [task.released for task in dw.simulate(named).history.tasks.values()] == [300, 900, 2700]


def bad_day():
    """Ninety rows of unknown places, 3 doubles, an empty place, a soon, a total, and 16 good rows."""
    good = rows(GERMAN, header=HEAD)
    unknown = [f"5{n:03};02.03.2026 07:00:00;{('R-17-B', '999', '1234')[n % 3]};pack;1" for n in range(90)]
    others = ["6000;02.03.2026 08:00;;pack;1", "6001;soon;1;pack;1", "6002;02.03.2026 08:00;1;pack;1,5", "Summe;;;;138"]
    return text([*good, good[1], good[2], good[2], *unknown, *others])


def test_all_kinds_of_problems_are_told_at_once(hall, tmp_path):
    path, out = tmp_path / "day.csv", tmp_path / "orders.parquet"
    path.write_bytes(bad_day())
    asked = ["orders", str(path), "--model", str(hall), "--out", str(out)]
    refused = CliRunner().invoke(desim, asked).exception
    assert isinstance(refused, dw.ModelError)
    told = "\n".join(refused.problems)
    assert len(refused.problems) == 7
    assert (
        f"{path}, Lagerplatz: no such place (90 rows from row 20 on, 3 values: '999', '1234', 'R-17-B')"
        in told.replace("'R-17-B', '999', '1234'", "'999', '1234', 'R-17-B'")
    )
    for problem in (
        "Auftragsnr: the same row as one before (3 rows from row 17 on",
        "row 110, Lagerplatz: nothing there",
        "row 111, Anlagedatum: not a time (got 'soon')",
        "row 112, Menge: not a number of this kind (got '1,5')",
        "row 113: a total (got 'Summe",
        "--skip-bad leaves out 97 rows; row 1 is the first below the header",
    ):
        assert problem in told, problem
    assert not out.exists()
    done = CliRunner().invoke(desim, [*asked, "--skip-bad"])
    assert done.exit_code == 0, done.output
    assert "16 lines, 48 pieces, 16 trips" in done.output
    skipped = pd.read_csv(tmp_path / "orders.skipped.csv", dtype=str)
    assert len(skipped) == 97
    assert skipped["row"].tolist()[:3] == ["17", "18", "19"]
    assert dw.simulate(dw.load(hall)).kpis["tasks"] == 16


@pytest.mark.parametrize(
    "form",
    [
        "%a %-d %b %Y %H:%M",
        "%A, %B %-d, %Y, %I:%M %p",
        "%d-%b-%y %H:%M:%S",
        "%b %-dnd %Y %H:%M",
        "Mo., %-d. März %Y, %H:%M Uhr",
        "%-d. mrz. %Y %H:%M",
    ],
)
@pytest.mark.parametrize("unit", [" ST", " pcs", "ea", " Stk.", ",00 Stück"])
def test_months_in_words_and_quantities_with_a_word_for_pieces(form, unit, hall, tmp_path):
    lines = rows(form, header=HEAD)
    (path := tmp_path / "day.csv").write_bytes(text([lines[0], *[line + unit for line in lines[1:]]]))
    day = order_day(path, hall)
    assert day.problems == ()
    assert (day.pieces, day.midnight) == (48, pd.Timestamp("2026-03-02"))
    assert [line.release for line in day.lines] == [300 + 1800 * number for number in range(16)]


def test_words_that_are_no_month_and_units_that_are_no_pieces_are_refused(hall, tmp_path):
    (path := tmp_path / "day.csv").write_text(
        "release;quantity\n2 Mar 2026 07:00;3 KG\n2 Mar 2026 07:00;3 ST 4\n2 Foo 2026;1\n31 Feb 2026;1\n"
    )
    dated, weighed = order_day(path, hall).problems
    assert "quantity: not a number of this kind (2 rows from row 1 on, 2 values: '3 KG', '3 ST 4')" in weighed
    assert "expected a whole number of at least 1, alone or with ST or pcs" in weighed
    assert "release: not a time (2 rows from row 3 on, 2 values: '2 Foo 2026', '31 Feb 2026')" in dated


@pytest.mark.parametrize("pieces", [0, -1, 1.5, float("nan"), "two", True])
def test_pieces_on_a_load_are_a_whole_number(pieces, hall):
    with pytest.raises(dw.ModelError, match=r"^pieces_per_load .*: expected a whole number above 0$"):
        dw.order_day("day.csv", hall, pieces_per_load=pieces)


def test_what_was_assumed_is_said(hall, tmp_path):
    path = tmp_path / "day.csv"
    path.write_bytes(MESSY["Windows, umlauts"][1])
    assert order_day(path, hall).assumed == (
        "'Anlagedatum' is release, 'Lagerplatz' is from, 'Ziel' is to, 'Stück' is quantity, 'Auftragsnr' is order",
        "encoding cp1252",
        "cells end with ';'",
        "'Stück' counts pieces, all of a row on one load",
    )


def test_dates_with_slashes_are_refused_until_it_is_said_how_they_are_meant(hall, tmp_path):
    path = tmp_path / "day.csv"
    path.write_text("release,from\n03/02/2026 07:00,1\n")
    [problem] = order_day(path, hall).problems
    assert "a date that may be meant in two ways (got '03/02/2026 07:00'), expected --dates us or uk" in problem
    days = {dates: order_day(path, hall, dates=dates).midnight for dates in ("us", "uk")}
    assert days == {"us": pd.Timestamp("2026-03-02"), "uk": pd.Timestamp("2026-02-03")}
    path.write_text("release,from\n13/02/2026 07:00,1\n")
    assert order_day(path, hall, dates="us").problems  # there is no month 13


HOSTILE = {
    "nothing": ("a.csv", b"", "empty, expected a header with a column 'release'"),
    "blank lines": ("a.csv", b"\n;;\n\n", "empty, expected a header with a column 'release'"),
    "garbage": ("a.csv", bytes(range(256)) * 20, "cannot be read|no column"),
    "garbage in Excel": ("a.xlsx", b"PK\3\4" + b"x" * 1000, "cannot be read"),
    "garbage in Parquet": ("a.parquet", b"PAR1" + b"x" * 1000, "cannot be read"),
    "text in Excel": ("a.xlsx", b"release\n1\n", "cannot be read"),
    "huge numbers": ("a.csv", b"release,quantity\n1,1e308\n", "not a number of this kind"),
    "huge times": ("a.csv", b"release\n1e308\n-1e308\nnan\ninf\n", "release"),
    "a quote that never ends": ("a.csv", b'release\n"' + b"x" * 200_000, "cannot be read|no column|not a time"),
    "too many cells": ("a.csv", b"release;from\n1;2;3;4;5\n", "cells beyond the header"),
    "commands in cells": ("a.csv", b"release\n=cmd|' /C calc'!A0\n", "not a time"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_refused_in_few_lines(name, hall, tmp_path):
    file, content, expected = HOSTILE[name]
    if file.endswith("xlsx"):
        pytest.importorskip("openpyxl")
    path = tmp_path / file
    path.write_bytes(content)
    refused = CliRunner().invoke(desim, ["orders", str(path), "--model", str(hall)]).exception
    assert isinstance(refused, dw.ModelError)
    assert any(one in str(refused) for one in expected.split("|")), refused
    assert len(str(refused)) < 3000
    with pytest.raises(dw.ModelError):
        dw.load(hall, {"tasks.flows.day.arrivals.orders": {"file": str(path)}})


def test_formulas_count_as_they_were_last_worked_out(hall, tmp_path):
    path = tmp_path / "a.xlsx"
    path.write_bytes(book(("orders", [["release", "from"], [10, 1], [None, 2]]), formulas=[("A3", "=A2+10")]))
    [problem] = order_day(path, hall).problems  # nobody has worked it out
    cure = "open and save the file in Excel"
    assert f"row 2, release: no value (got 'a formula without a stored value'), expected one; {cure}" in problem


@pytest.mark.parametrize("column", ORDER_HEADINGS)
def test_a_formula_that_was_never_calculated_is_no_empty_cell(column, hall, tmp_path):
    (path := tmp_path / "a.xlsx").write_bytes(
        book(
            ("orders", [ORDER_HEADINGS, ["a", 10, 1, "pack", 90, 3]] + [[]] * 2),
            formulas=[(f"{'ABCDEF'[ORDER_HEADINGS.index(column)]}2", "=3+0"), ("H1", "=2+2"), ("H2", "=2+2")],
        )
    )
    [problem] = order_day(path, hall).problems
    assert f"row 1, {column}: no value (got 'a formula" in problem


def test_a_formula_whose_value_is_an_empty_text_is_an_empty_cell(hall, tmp_path):
    source, out = zipfile.ZipFile(io.BytesIO(book(("a", [["release", "due"], [60, 90], [70, 95]])))), io.BytesIO()
    with zipfile.ZipFile(out, "w") as file:
        for part in source.infolist():
            empty = b'<c r="B2" t="str"><f>""</f><v></v></c>'
            file.writestr(part, source.read(part).replace(b'<c r="B2" t="n"><v>90</v></c>', empty))
    (path := tmp_path / "a.xlsx").write_bytes(out.getvalue())
    assert [line.due for line in order_day(path, hall).lines] == [None, 95]


def test_cells_are_merged_in_the_sheet_that_is_read_wherever_it_stands(hall, tmp_path):
    """A cover that was moved to the front keeps its part of the file, the second."""
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, the extra excel, is not installed")
    rows_ = [["order", "release"], ["a", 60], [None, 70]]
    made = openpyxl.load_workbook(io.BytesIO(book(("orders", rows_), ("cover", [["Export"]]))))
    made["orders"].merge_cells("A2:A3")
    made.save(path := tmp_path / "a.xlsx")
    source, out = zipfile.ZipFile(io.BytesIO(path.read_bytes())), io.BytesIO()
    with zipfile.ZipFile(out, "w") as file:
        for part in source.infolist():
            content = source.read(part)
            if part.filename == "xl/workbook.xml":
                begin, end = content.index(b"<sheets>") + 8, content.index(b"</sheets>")
                first, second, _ = content[begin:end].split(b"/>")
                content = content[:begin] + second + b"/>" + first + b"/>" + content[end:]
            file.writestr(part, content)
    path.write_bytes(out.getvalue())
    assert [line.order for line in order_day(path, hall, sheet="orders").lines] == ["a", "a"]


def test_a_cover_in_front_of_the_orders_is_told_with_the_other_sheets(hall, tmp_path):
    path = tmp_path / "a.xlsx"
    path.write_bytes(book(("Cover", [["Export of 2 March"]]), ("Data", [["Pos"], [1]]), ("Notes", [])))
    with pytest.raises(dw.ModelError) as cover:
        order_day(path, hall)
    assert "no column 'release' in sheet 'Cover' (it has 'Export of 2 March'); desim orders --map" in str(cover.value)
    assert str(cover.value).endswith("; --sheet reads another: 'Data', 'Notes'")
    with pytest.raises(dw.ModelError) as notes:
        order_day(path, hall, sheet="Notes")
    assert str(notes.value) == (
        f"{path}: empty in sheet 'Notes', expected a header with a column 'release'; "
        "--sheet reads another: 'Cover', 'Data'"
    )
    path.write_bytes(book(("Cover", [])))
    with pytest.raises(dw.ModelError, match=r"a.xlsx: empty, expected a header with a column 'release'$"):
        order_day(path, hall)


def test_which_of_several_sheets_was_read_is_said(hall, tmp_path):
    (path := tmp_path / "a.xlsx").write_bytes(book(("May", [["release"], [60]]), ("June", [["release"], [70]])))
    day = order_day(path, hall)
    assert [line.release for line in day.lines] == [60]
    assert "sheet 'May', the first of 2" in day.assumed
    assert not any("sheet" in one for one in order_day(path, hall, sheet="June").assumed)


def test_a_folder_is_no_file_of_orders(hall, tmp_path):
    with pytest.raises(dw.ModelError, match=r"cannot be read \(a folder\), expected orders in CSV"):
        order_day(tmp_path, hall)


@pytest.mark.parametrize("name", ["orders.xlsx", "orders.txt", "orders"])
def test_orders_are_written_under_no_name_that_models_read_otherwise(name, hall, tmp_path):
    (tmp_path / "day.csv").write_text("release\n60\n")
    done = CliRunner().invoke(
        desim, ["orders", str(tmp_path / "day.csv"), "--model", str(hall), "--out", str(tmp_path / name)]
    )
    assert done.exit_code == 2
    assert "is no table that models read, expected one that ends in .parquet or .pq or .csv" in done.output
    assert not (tmp_path / name).exists()


def test_a_workbook_that_unfolds_to_gigabytes_is_refused(hall, tmp_path, monkeypatch):
    monkeypatch.setitem(LIMITS, "texts", (1_000_000, *LIMITS["texts"][1:]))
    path = tmp_path / "bomb.xlsx"
    path.write_bytes(book(("orders", [["release"], [1]])))
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as file, file.open("xl/sharedStrings.xml", "w") as words:
        words.write(b" " * 2_000_000)
    with pytest.raises(dw.ModelError, match="too large when it is unfolded"):
        order_day(path, hall)


NAMED = {"pattern": "R-{aisle:02}-{bay:02}-{level_letter}", "levels": 2}


def time(number, form):
    return (MORNING + dt.timedelta(minutes=30 * number)).strftime(form)


PRINTED = [
    f"|{4711 + number // 2:010}|{time(number, '%d.%m.%Y|%H:%M:%S')}|{number % 8:>5}|pack |  1.000|"
    for number in range(16)
]
LINE = "-" * 50
WITH_TOTALS = {
    "a list as SAP prints it": text(
        [LINE, "|Beleg|ErDat|Uhrzeit|VLPla|NLPla|Menge|", LINE, *PRINTED, LINE, "|*  |  |  |   |   | 16.000|"], "cp1252"
    ),
    "UTF-16, days of the week, leading zeros": text(
        [
            HEAD,
            *[
                f'"{4711 + number // 2:010}";"Mo., {time(number, GERMAN)}";{number % 8:03};pack;"1.000,00"'
                for number in range(16)
            ],
            "Gesamtsumme;;;;16.000,00",
        ],
        "utf-16",
    ),
    "line breaks, times with Uhr": text(
        [
            f"{HEAD};Bemerkung",
            *[
                f'{4711 + number // 2};{time(number, "Montag, %d.%m.%Y, %H:%M Uhr")};{number % 8};pack;1000;"an\nTor;1"'
                for number in range(16)
            ],
            "Summe;;;;16000;",
        ],
        "cp1252",
    ),
}


@pytest.mark.parametrize("name", WITH_TOTALS)
def test_lists_with_totals_are_a_day_without_them(name, hall, tmp_path):
    (path := tmp_path / "a.txt").write_bytes(WITH_TOTALS[name])
    day = order_day(path, hall)
    assert (day.orders, len(day.lines), day.pieces, day.busiest) == (8, 16, 16_000, (6 * 3600, 2))
    assert [line.release for line in day.lines] == [300 + 1800 * number for number in range(16)]
    [problem] = day.problems
    assert "a total (got" in problem


@pytest.mark.parametrize("names", [NAMED, "table"])
def test_orders_name_storage_places_as_people_do(names, hall, tmp_path):
    if names == "table":
        table = [f"R-01-{bay:02}-{level},{bay - 1}" for bay in range(1, 9) for level in "AB"]
        (tmp_path / "names.csv").write_text("\n".join(["name,place", *table]))
        names = {"file": "names.csv"}
    model = json.loads(hall.read_text())
    model["layout"]["storage_names"] = names
    hall.write_text(json.dumps(model))
    (tmp_path / "day.csv").write_text("release,from\n10,R-01-03-B\n20,R-01-08-A\n30,7\n")
    day = order_day(tmp_path / "day.csv", hall)
    assert [line.source for line in day.lines] == [2, 7, 7]
    (tmp_path / "bad.csv").write_text("release,from\n10,R-01-09-B\n")
    assert "did you mean 'R-01-0" in order_day(tmp_path / "bad.csv", hall).problems[0]
    written = dw.load(hall, {"tasks.flows.day.arrivals.orders.file": str(tmp_path / "day.csv")})
    assert written.floor.called[2] == "R-01-03-A"
    [note] = [one for one in check(written).findings if one.code == "SHARED_NAMES"]
    assert "8 places have several names" in note.text
    assert "show the first, such as R-01-0" in note.text


def test_a_name_for_each_place_is_nothing_to_note(hall):
    model = json.loads(hall.read_text())
    model["layout"]["storage_names"] = {**NAMED, "levels": 1}
    model["tasks"] = {"goods": [0], "unload_at": ["pack"], "load_time": 5, "unload_time": 5}
    assert "SHARED_NAMES" not in {one.code for one in check(dw.load(model)).findings}


def test_the_log_of_a_run_and_its_exports_name_storage_places(hall, tmp_path):
    (tmp_path / "day.csv").write_text("release,from\n10,2\n20,R-01-08-A\n")
    orders = {"tasks.flows.day.arrivals.orders.file": str(tmp_path / "day.csv")}
    run = dw.simulate(dw.load(hall, {**orders, "layout.storage_names": NAMED}))
    released = run.log[run.log["kind"] == "released"]
    assert released[["value", "place"]].to_numpy().tolist() == [[2.0, "R-01-03-A"], [7.0, "R-01-08-A"]]
    assert set(run.log["place"][run.log["task"] == 1]) == {"R-01-08-A"}
    assert run.log["place"][run.log["task"] < 0].isna().all()
    export(run, "csv", tmp_path / "tables")
    assert "R-01-03-A" in (tmp_path / "tables" / "log.csv").read_text()
    run.save(tmp_path / "run")
    pd.testing.assert_frame_equal(load_run(tmp_path / "run").log, run.log)
    (tmp_path / "plain.csv").write_text("release,from\n10,2\n20,7\n")
    plain = dw.simulate(dw.load(hall, {"tasks.flows.day.arrivals.orders.file": str(tmp_path / "plain.csv")}))
    assert "place" not in plain.log
    assert plain.record.rows == run.record.rows  # names are for people: the run is the same


def test_reports_say_where_robots_waited_by_the_names_of_storage_places(hall):
    """Three robots come to one stand, where loading takes a minute; two more places lie along the next lane."""
    model = json.loads(hall.read_text())
    aisle = [{"edge": ["B", "C"], "offset": offset} for offset in (6, 3)]
    model["layout"] |= {"storage": [{"node": "B"}, *aisle], "storage_names": {"pattern": "R-{aisle}-{bay}"}}
    model["fleet"]["size"] = 3
    model["tasks"] = {"goods": [0, 0, 0], "unload_at": ["pack"], "load_time": 60, "unload_time": 5}
    run = dw.simulate(dw.load(model, {"log": "all"}))
    assert "for robots loading at B (R-1-1)" in str(lost_time(run))
    assert root(Root("loading", "C>D"), run.model) == "for robots loading on C>D"  # not: at what lies ahead
    assert root(Root(LANE, "B>C"), run.model) == "behind others on B>C (R-2-1 to R-2-2)"
    assert root(Root(LANE, "C>D"), run.model) == "behind others on C>D"


def test_a_drawing_has_the_names_of_storage_places(hall, tmp_path):
    model = json.loads(hall.read_text())
    model["layout"]["storage_names"] = NAMED
    model["tasks"] = {"goods": [0], "unload_at": ["pack"], "load_time": 5, "unload_time": 5}
    hall.write_text(json.dumps(model))
    path = tmp_path / "floor.svg"
    for names, there in ((["--names"], True), ([], False)):
        done = CliRunner().invoke(desim, ["draw", str(hall), "-o", str(path), *names])
        assert done.exit_code == 0, done.output
        assert ("R-01-03-A" in path.read_text()) == there


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ({"pattern": "{aisle}"}, "1 names are those of several places, such as '1'"),
        ({"pattern": "{bay:9999}"}, "unknown field 'bay'"),
        ({"pattern": "{bay.real}"}, "unknown field 'bay.real'"),
        ({"pattern": "{bay"}, "not a pattern"),
        ({"pattern": "shelf"}, "no field"),
        ({"places": {"a": 8}}, "'a' is place 8, expected 0 to 7"),
        ({"places": {"B": 0}}, "storage_names: 'B' is also a node or station, which orders then mean"),
        ({"places": {"pack": 0}}, "storage_names: 'pack' is also a node or station"),
        ({}, "expected a pattern, or names one by one"),
    ],
    ids=str,
)
def test_names_that_cannot_be_are_refused(names, message, hall):
    model = json.loads(hall.read_text())
    model["layout"]["storage_names"] = names
    model["tasks"]["flows"]["day"]["arrivals"] = {"schedule": [{"at": 0}]}
    with pytest.raises(dw.WarehouseError, match=message):
        dw.simulate(dw.load(model))


def test_rows_that_are_left_out_count_to_the_most_that_are_read(hall, tmp_path, monkeypatch):
    """Ten million wrong rows would otherwise all be kept to be written beside."""
    monkeypatch.setitem(LIMITS, "tasks", (16, *LIMITS["tasks"][1:]))
    wrong = rows(GERMAN, places=["R-17-B"] * 8)[1:]
    (path := tmp_path / "day.csv").write_bytes(text([*rows(GERMAN, header=HEAD), *wrong]))
    with pytest.raises(dw.ModelError, match="too many rows, expected at most 16; split the file by days"):
        order_day(path, hall)
