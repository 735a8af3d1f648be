"""`desim screen`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import with_indicator
from desim_warehouse.cli.tables import sheet, show

if TYPE_CHECKING:
    from desim_warehouse.questions.study import Results


@click.command("screen")
@click.argument("folder", type=AtPath())
@with_indicator
def command(folder: str, indicators: tuple[str, ...]) -> None:
    """Show which factors of a study FOLDER matter: main effects, and shares of the variance.

    Total shares, with interactions, need the design {saltelli: n}.
    """
    from desim_warehouse.questions.study import Results

    results = Results.load(folder)
    for indicator in indicators or results.plan.indicators or results.usual(3):
        results.chosen([indicator])
        _show(results, indicator)


def _show(study: Results, indicator: str) -> None:
    from desim_warehouse.answer import words

    effects = study.main_effects(indicator)
    total = study.sobol(indicator) if study.plan.rule.name == "saltelli" else None
    first = None if total else study.first_order(indicator)
    shares = total.first if total else first.shares if first else {}
    scale = words.scale(indicator, study.base, (effects.grand_mean,))
    mean = scale.value(effects.grand_mean)
    if all(math.isnan(share) for share in shares.values()):
        click.echo(f"{indicator}: {mean} on average in every option that ran, so no factor matters")
        return
    heads = ["factor", ">largest - smallest mean", ">share alone", *([">with interactions"] if total else [])]
    columns = (*heads, "mean at each value, minus the grand mean")
    table = sheet(f"{indicator}: mean {mean}", *columns)
    for effect in effects.factors:
        levels = ", ".join(
            f"{level}: {'+' * (value > 0)}{scale.bare(value)}" for level, value in effect.effects.items()
        )
        share = first.text(effect.factor) if first else f"{100 * shares[effect.factor]:.1f} %"
        cells = [effect.factor, scale.bare(effect.swing), share]
        if total:
            cells.append(f"{100 * total.total[effect.factor]:.1f} %")
        table.add_row(*cells, levels)
    show(table)
    if first and first.warning:
        click.echo(first.warning)
