"""`desim check`."""

from __future__ import annotations

import sys

import click

from desim_warehouse.cli.options import load_model, with_overrides


@click.command("check")
@click.argument("model")
@with_overrides
def command(model: str, assignments: tuple[str, ...]) -> None:
    """Check MODEL: the file, its layout and what robots will meet there.

    Errors are what `desim run` would refuse: exit status 2.
    """
    from desim_warehouse.run import check

    report = check(load_model(model, assignments))
    for line in report.facts:
        click.echo(line)
    for finding in report.findings:
        click.echo(str(finding))
    errors = sum(finding.level == "error" for finding in report.findings)
    click.echo("no errors" if not errors else f"{errors} error{'s' * (errors > 1)}: this model would be refused")
    sys.exit(2 if errors else 0)
