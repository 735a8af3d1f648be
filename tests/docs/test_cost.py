"""The table of costs: its check says which row is missing, is no longer nearly true, or spoils the sum."""

import pytest

from docs.make_cost import Row, stale, written

PAGE = """
# Costs

| feature | lines | of tests | options |
| --- | ---: | ---: | ---: |
| pods | 1,300 | 40 | 0 |
| plan | 200 | 60 | 27 |
| all | 1,500 | 100 | 27 |
"""
NOW = {"pods": Row(1300, 40, 0), "plan": Row(200, 60, 27), "all": Row(1500, 100, 27)}


def test_a_page_is_read_as_it_is_written():
    assert written(PAGE) == NOW


@pytest.mark.parametrize(
    ("changed", "complaints"),
    [
        ({}, []),
        ({"pods": Row(1420, 90, 0), "plan": Row(250, 10, 27)}, []),  # a tenth, and 50 lines, are nearly the same
        ({"pods": Row(1460, 40, 0)}, ["pods"]),
        ({"plan": Row(200, 120, 27)}, ["plan"]),
        ({"plan": Row(200, 60, 28)}, ["plan"]),
        ({"why": Row(5, 0, 0)}, ["rows"]),
    ],
)
def test_a_row_may_be_off_by_a_tenth(changed, complaints):
    assert [line.partition(":")[0] for line in stale(written(PAGE), NOW | changed)] == complaints


def test_rows_add_up():
    assert stale(NOW | {"all": Row(1499, 100, 27)}, NOW) == [
        "all: the rows add up to Row(lines=1500, of_tests=100, options=27)"
    ]
