"""Options that several subcommands share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from desim_warehouse.model import Model

with_overrides = click.option(
    "--set",
    "assignments",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change a key of the model, such as fleet.size=3 or tasks.goods=[11,8]; may be repeated.",
)
with_seed = click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of all random streams."
)


def load_model(path: str, assignments: tuple[str, ...]) -> Model:
    """The model of a file that is to be simulated or checked, with `--set` applied."""
    from desim_warehouse.model import load, parse_assignment

    overrides: dict[str, Any] = dict(parse_assignment(text) for text in assignments)
    return load(path, overrides, named="--set", run_code=True)
