"""`desim schema`."""

from __future__ import annotations

import json

import click


@click.command("schema")
@click.option("--study", is_flag=True, help="Print the schema of study files instead.")
@click.option(
    "--answer", is_flag=True, help="Print the schema of answers, as in answer.json and the output of --json, instead."
)
def command(study: bool, answer: bool) -> None:
    """Print the JSON Schema of model files, study files or answers, for editors and other programs."""
    from desim_warehouse.answer.answer import Answer
    from desim_warehouse.study.file import schema

    click.echo(json.dumps(Answer.model_json_schema() if answer else schema(study=study), indent=2))
