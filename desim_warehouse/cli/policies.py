"""`desim policies`."""

from __future__ import annotations

import dataclasses
import inspect
from typing import Any

import click

from desim_warehouse.errors import nearest
from desim_warehouse.policies.catalogue import OURS, find, parameters_of, source_of


@click.command("policies")
@click.option("--doc", "name", metavar="NAME", help="Show one policy in detail: its rule, its source and its code.")
def command(name: str | None) -> None:
    """List all policies with a summary and their parameters, or show one in detail."""
    if name is None:
        for kind, policies in OURS.items():
            click.echo(f"policies.{kind}:")
            for policy in policies:
                _line(kind, policy)
        click.echo("Your own: module:Class or file.py:Class, see docs/how-to/own-policy.md")
        return
    matches = [(kind, name) for kind in OURS if name in OURS[kind]]
    if not matches and ":" in name:
        matches = [(kind, name) for kind in OURS if _is_one(kind, name)]
    if not matches:
        every = dict.fromkeys(policy for policies in OURS.values() for policy in policies)
        near = nearest(name, every)
        hint = f"did you mean {near!r}? Expected" if near else "expected"
        raise click.UsageError(f"no policy {name!r}, {hint} one of {', '.join(every)}, or your own as file.py:Class")
    for kind, policy in matches:
        click.echo(f"policies.{kind}: {policy}\n")
        click.echo(inspect.cleandoc(find(kind, policy).__doc__ or "(no description)") + "\n")
        click.echo(source_of(kind, policy))


def _line(kind: str, policy: str) -> None:
    cls = find(kind, policy)
    first = (inspect.getdoc(cls) or "").partition("\n")[0]
    click.echo(f"  {policy:<21}{first}")
    shown = [_shown(key, default) for key, (_, default) in parameters_of(cls).items()]
    if shown:
        click.echo(f"  {'':<21}  parameters: {', '.join(shown)}")


def _shown(key: str, default: Any) -> str:
    if default is dataclasses.MISSING:
        return f"{key} (must be given)"
    return f"{key}={'none' if default is None else str(default).lower() if isinstance(default, bool) else default}"


def _is_one(kind: str, name: str) -> bool:
    from desim_warehouse.errors import PolicyError

    try:
        find(kind, name)
    except PolicyError:
        return False
    return True
