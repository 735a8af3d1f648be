"""`desim new`."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.options import TimeIn, with_force, write_model

if TYPE_CHECKING:
    from desim_warehouse.draft import Draft

_WORKED_OUT = "worked out by hand"


@click.command("new")
@click.argument("file", required=False)
@click.option("--size", default="60x40", show_default=True, metavar="WxH", help="The floor in metres, width x height.")
@click.option("--orders", default="200/h", show_default=True, metavar="RATE", help="Orders that arrive at random.")
@click.option("--aisles", type=int, metavar="N", help="Aisles side by side.  [default: as many as fit]")
@click.option("--stations", type=int, metavar="N", help="Packing stations.  [default: as many as the orders need]")
@click.option("--robots", type=int, metavar="N", help=f"[default: {_WORKED_OUT}]")
@click.option("--chargers", type=int, metavar="N", help=f"[default: {_WORKED_OUT}]")
@click.option(
    "--due",
    type=TimeIn("min", most=120),
    default="15min",
    show_default=True,
    metavar="TIME",
    help="Time from an order to its due time; a plain number is in minutes.",
)
@with_force
def command(file: str | None, *, force: bool, **given: Any) -> None:
    """Write a commented model FILE from a few words, ready for `check`, `draw`, `run` and `plan`.

    Without FILE it asks. Example: desim new w.yaml --size 60x40 --aisles 8 --stations 3 --orders 200/h
    """
    from desim_warehouse.draft import draft

    if file is None:
        if not sys.stdin.isatty():
            raise click.UsageError("which file? Expected FILE, such as w.yaml; in a terminal `desim new` asks")
        file, given = _asked(given)
    text = draft(_words(given))
    write_model(file, text, force=force)
    click.echo(text.splitlines()[0].removeprefix("# "))
    click.echo(f"{file} is written; next: desim check {file}")


def _words(given: dict[str, Any]) -> Draft:
    from desim_warehouse.draft import Draft, read_orders, read_size

    return Draft(**{**given, "size": read_size(given["size"]), "orders": read_orders(given["orders"])})


def _asked(given: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """The same words, prompted for one by one; Enter alone takes the default in brackets."""
    file = click.prompt("Model file to write", default="warehouse.yaml")
    words = dict(given)
    words["size"] = click.prompt("Floor in metres, width x height", default=given["size"])
    words["orders"] = click.prompt("Orders", default=given["orders"])
    words["due"] = click.prompt("Due after how many minutes", default=f"{given['due']:g}", type=TimeIn("min"))
    for name, what in (("aisles", "as many as fit"), ("stations", "as many as needed"), ("robots", _WORKED_OUT)):
        words[name] = _number(name, what)
    words["chargers"] = _number("chargers", _WORKED_OUT)
    return file, words


def _number(name: str, otherwise: str) -> int | None:
    """How many; None by default."""
    while True:
        said = click.prompt(f"How many {name}", default=otherwise)
        if said == otherwise:
            return None
        if said.isdecimal():
            return int(said)
        click.echo(f"{said}: not a number; Enter alone: {otherwise}")
