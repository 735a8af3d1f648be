"""Headings of tables, however people write them."""

import pytest

from desim_warehouse.values.headings import heading


@pytest.mark.parametrize(
    ("title", "read"),
    [
        ("Max. speed [m/s]", ("maxspeed", "m/s")),
        ("max_speed", ("maxspeed", None)),
        ("Menge\n(Stk)", ("menge", "Stk")),
        ("Auftrags-Nr.", ("auftragsnr", None)),
        (" Stück ( ) ", ("stück", "")),
        ("(x) left", ("xleft", None)),
        (")", ("", None)),
        (7, ("7", None)),
        (None, ("", None)),
    ],
    ids=str,
)
def test_a_heading_is_its_letters_and_digits_and_the_unit_behind_it(title, read):
    assert heading(title) == read
