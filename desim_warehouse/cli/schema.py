"""`desim schema`."""

from __future__ import annotations

import json

import click


@click.command("schema")
def command() -> None:
    """Print the JSON Schema of model files, for editors."""
    from desim_warehouse.model import json_schema

    click.echo(json.dumps(json_schema(), indent=2))
