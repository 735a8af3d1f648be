"""Rows of orders are compared whole, and columns that are not read are named; files of a few rows, by hand."""

import pandas as pd
import pytest

from desim_warehouse.errors import ModelError
from desim_warehouse.orders.day import order_day

WAYS = ("csv", "parquet")


def read(folder, model, rows, how="csv", **options):
    """A day whose table has these rows; the first has the headings."""
    head, *below = [row.split(";") for row in rows]
    frame = pd.DataFrame(below, columns=head)
    path = folder / f"day.{how}"
    if how == "csv":
        frame.to_csv(path, index=False, sep=";")
    else:
        frame.to_parquet(path, index=False)
    return order_day(path, model, **options)


@pytest.mark.parametrize("how", WAYS)
def test_lines_that_differ_in_any_cell_are_no_doubles(hall, tmp_path, how):
    rows = ["release;order;from;line;sku", "60;a;1;10;4711", "60;a;1;20;4712", "60;a;1;20;4713", "60;a;1;20;4713"]
    day = read(tmp_path, hall, rows, how)
    assert len(day.lines) == 3
    assert day.unread == ("line", "sku")
    (problem,) = day.problems
    assert "row 4, order: the same row as one before (got 'a')" in problem
    assert list(day.skipped.columns) == ["release", "order", "from", "row"]


@pytest.mark.parametrize("how", WAYS)
@pytest.mark.parametrize("state", ["CANCELLED", "canceled", "Storno", "storniert", "Returned", "Retoure", "gelöscht"])
def test_orders_that_were_called_off_are_asked_about(hall, tmp_path, how, state):
    rows = ["release;order;Status", "60;a;SHIPPED", f"70;b;{state}", "80;c;shipped"]
    day = read(tmp_path, hall, rows, how)
    assert [line.order for line in day.lines] == ["a", "c"]
    (problem,) = day.problems
    assert f"row 2, Status: an order that was called off (got '{state}'), expected orders that are driven" in problem


@pytest.mark.parametrize("text", ["storno possible", "not cancelled", "open", "", "returns desk"])
def test_other_states_are_driven(hall, tmp_path, text):
    day = read(tmp_path, hall, ["release;order;Remark", f"60;a;{text}"])
    assert (len(day.lines), day.problems, day.unread) == (1, (), ("Remark",))


def test_columns_with_places_of_the_model_that_are_not_read_say_so(hall, tmp_path):
    day = read(tmp_path, hall, ["release;Wo;Wer;Nr", "60;A;Ann;1", "70;Z-99;Bob;2"])
    assert day.unread == ("Wo (it has places of the model)", "Wer", "Nr")


def test_rows_with_nothing_but_a_remark_are_no_orders(hall, tmp_path):
    assert len(read(tmp_path, hall, ["release;order;Remark", "60;a;x", ";;printed by Ann"]).lines) == 1


def test_errors_of_a_spreadsheet_are_no_values(hall, tmp_path):
    """Two rows whose formula lost its cell are not two lines of one order #REF!, and an unknown article is no place."""
    (tmp_path / "day.csv").write_text("release,from,order\n60,0,A1\n70,#N/A,A2\n80,1,#REF!\n90,2,#REF!\n")
    day = order_day(tmp_path / "day.csv", hall)
    assert [line.order for line in day.lines] == ["A1"]
    order, place = sorted(problem.partition("day.csv")[2] for problem in day.problems)
    assert order.startswith(", order: an error of Excel (2 rows from row 3 on, 1 value: '#REF!'), expected a value: ")
    assert place == ", row 2, from: an error of Excel (got '#N/A'), expected a value: correct its formula there"


def test_nothing_is_said_where_all_columns_are_read(hall, tmp_path):
    assert read(tmp_path, hall, ["release;order", "60;a"]).unread == ()


@pytest.mark.parametrize("title", ["Storniert", "is_cancelled", "Storno-Kz", "DELETED", "returned flag"])
@pytest.mark.parametrize(("yes", "no"), [("X", ""), ("true", "false"), ("1", "0"), ("ja", "nein"), ("2026-03-01", "-")])
def test_a_column_may_say_by_its_heading_what_was_called_off(hall, tmp_path, title, yes, no):
    day = read(tmp_path, hall, [f"release;order;{title}", f"60;a;{no}", f"70;b;{yes}", f"80;c;{no}"])
    assert [line.order for line in day.lines] == ["a", "c"]
    assert f"row 2, {title}: an order that was called off (got '{yes}')" in day.problems[0]


def test_a_column_without_a_heading_is_named_by_its_number_if_something_stands_there(hall, tmp_path):
    (tmp_path / "day.csv").write_text("release;;order;\n60;x;a;\n70;;b;\n")
    assert order_day(tmp_path / "day.csv", hall).unread == ("column 2",)


@pytest.mark.parametrize("title", ["Cancelled at", "Storniert am", "Cancellation reason", "Stornogrund", "deleted_at"])
@pytest.mark.parametrize("no", ["", "NULL", "0000-00-00 00:00:00", "N/A"])
def test_a_column_may_say_when_or_why_an_order_was_called_off(hall, tmp_path, title, no):
    day = read(tmp_path, hall, [f"release;order;{title}", f"60;a;{no}", "70;b;2026-03-02 07:00"])
    assert [line.order for line in day.lines] == ["a"]
    assert f"row 2, {title}: an order that was called off (got '2026-03-02 07:00')" in day.problems[0]


@pytest.mark.parametrize(
    "state", ["Cancelled by customer", "CANCELLED_BY_CUSTOMER", "canceled (sold out)", "Storno: X"]
)
def test_a_state_may_have_more_words(hall, tmp_path, state):
    day = read(
        tmp_path, hall, ["release;order;Order status", "60;a;not cancelled", f"70;b;{state}", "80;c;Stornoladen"]
    )
    assert [line.order for line in day.lines] == ["a", "c"]
    assert f"row 2, Order status: an order that was called off (got '{state}')" in day.problems[0]
    assert len(read(tmp_path, hall, ["release;order;Article", f"70;b;{state}"]).lines) == 1


def test_the_header_is_the_row_with_most_headings(hall, tmp_path):
    text = "Date;03.03.2026 07:00\nHall;Nord\n\nAuftrag;Datum;Platz;Ziel\n1;02.03.2026 06:05;3;pack\n"
    (tmp_path / "day.csv").write_text(text)
    day = order_day(tmp_path / "day.csv", hall)
    assert [(line.order, line.release, line.source, line.target) for line in day.lines] == [("1", 300, 3, "pack")]
    assert "the header is row 4" in day.assumed


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("day.xls", b"<html><table><tr><td>order</td></tr></table></html>", "a web page or XML; open it in"),
        (
            "day.xls",
            b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(99),
            "a workbook of Excel before 2007; save it as .xlsx",
        ),
        ("day.csv", b"PK\x03\x04" + bytes(99), "a workbook or another zip file; save it as .xlsx or CSV"),
        ("day.csv", b'\xef\xbb\xbf[{"order": 1}]', "JSON; save it as CSV"),
        ("day.xlsx", b"order,created\n1,06:05\n", "text; call it .csv"),
        ("day.csv", "order,created\n1,06:05\n".encode("utf-16-le"), "no text, or UTF-16 without its mark; save it as"),
    ],
)
def test_a_file_of_another_kind_is_called_by_it(hall, tmp_path, name, content, why):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ModelError) as refused:
        order_day(tmp_path / name, hall)
    assert f"{name}: cannot be read ({why}" in str(refused.value)
