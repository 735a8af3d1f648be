"""Outputs on pages are made anew in the order in which they are printed, none of their lines twice."""

from docs.make_outputs import _change

PRINTED = """\
option    on time
8 robots  43 %
9 robots  56 %
11 robots 98 %

4 runs.
"""


def test_lines_shown_one_after_the_other_become_lines_printed_one_after_the_other():
    shown = ["...", "8 robots  41 %", "9 robots  40 %", "...", "3 runs."]
    assert _change(10, shown, PRINTED) == [(11, 2, ["8 robots  43 %", "9 robots  56 %"]), (14, 1, ["4 runs."])]


def test_an_output_that_holds_stays():
    assert _change(10, ["...", "9 robots  56 %", "..."], PRINTED) == []


def test_an_output_without_elisions_is_replaced_as_a_whole():
    assert _change(10, ["?"], PRINTED) == [(10, 1, PRINTED.strip().splitlines())]
