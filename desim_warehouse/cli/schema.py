"""`desim schema`."""

from __future__ import annotations

import json

import click


@click.command("schema")
@click.option("--study", is_flag=True, help="That of study files.")
@click.option("--answer", is_flag=True, help="That of answer.json, which --out and --json write.")
def command(study: bool, answer: bool) -> None:
    """Print the JSON Schema of model files, or of study files or answers, for editors."""
    from desim_warehouse.answer.answer import Answer
    from desim_warehouse.study.file import schema

    click.echo(json.dumps(Answer.model_json_schema() if answer else schema(study=study), indent=2))
