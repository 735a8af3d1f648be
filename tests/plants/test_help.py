"""Help texts name what can be read and written: they are made from the tables of formats."""

import re

from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim, export
from desim_warehouse.plants.export import LAYOUT_FORMATS
from desim_warehouse.plants.formats import FORMATS, TASK_FILES
from desim_warehouse.report.export import FORMATS as RUN_FORMATS


def test_help_names_every_format_and_the_options_of_each():
    lines = " ".join(CliRunner().invoke(desim, ["import", "--help"]).output.split())
    shown = re.sub(r"(?<=\w)- (?=\w)", "-", lines)  # of words that a line ends in
    for one in (*FORMATS, *TASK_FILES):
        assert one.title in shown
    for one in FORMATS:
        assert all(re.search(rf"--{option.replace('_', '-')} [^-]*{one.name}", shown) for option in one.options), one
        assert one.name in dw.read_layout.__doc__
        assert all(f" {option}: " in dw.read_layout.__doc__ for option in one.options), one


def test_export_offers_what_can_be_written():
    (choice,) = (option.type for option in export.command.params if option.name == "form")
    assert set(choice.choices) == {*RUN_FORMATS, *LAYOUT_FORMATS, "svg"}
