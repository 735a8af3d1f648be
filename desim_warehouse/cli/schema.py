"""`desim schema`."""

from __future__ import annotations

import json

import click


@click.command("schema")
@click.option("--study", is_flag=True, help="That of study files.")
def command(study: bool) -> None:
    """Print the JSON Schema of model files, or of study files, for editors."""
    from desim_warehouse.study.file import schema

    click.echo(json.dumps(schema(study=study), indent=2))
