"""`desim validate`."""

from __future__ import annotations

import click

from desim_warehouse.cli.options import load_model, with_json, with_overrides


@click.command("validate")
@click.argument("model")
@click.option("--against", "logs", multiple=True, required=True, metavar="LOG", help="A real day; may be repeated.")
@click.option("--orders", multiple=True, metavar="ORDERS", help="The orders of that day, one file for each LOG.")
@click.option(
    "--runs", type=click.IntRange(39), default=40, show_default=True, help="Simulated days for each real one."
)
@with_overrides
@with_json("verdict, p, bound, and of each measure the real and simulated means, and how far it lies out")
def command(
    model: str, logs: tuple[str, ...], orders: tuple[str, ...], runs: int, assignments: tuple[str, ...], as_json: bool
) -> None:
    """Say whether real days refute MODEL: rank their figures among those of simulated days, all at once.

    A LOG is a file of VDA 5050 state messages (JSON lines), of trips (CSV), or the folder of a run.
    """
    import json

    from desim_warehouse.cli.tables import sheet, show
    from desim_warehouse.fleet_log.validate import validate

    found = validate(load_model(model, assignments), logs, orders=orders, runs=runs)
    means = {name: (float(found.real[:, k].mean()), found.simulated[:, :, k]) for k, name in enumerate(found.names)}
    if as_json:
        measures = {
            name: {"real": real, "simulated": float(days.mean()), "off": found.off[name]}
            for name, (real, days) in means.items()
        }
        verdict = {"refuted": found.refuted, "p": found.p_value, "bound": found.bound, "outside": found.outside}
        click.echo(json.dumps({**verdict, "measures": measures}))
    else:
        click.echo("\n".join(found.lines()))
        table = sheet(None, "measure", ">real", ">simulated", ">band", "verdict")
        for name, (real, days) in means.items():
            middle, reach = float(days.mean()), found.bound * float(days.std(axis=1, ddof=1).mean())
            reach /= len(logs) ** 0.5
            out = f"OUTSIDE ({found.off[name]:+.1f})" if name in found.outside else f"inside ({found.off[name]:+.1f})"
            band = f"{max(middle - reach, 0.0):.4g} to {middle + reach:.4g}"
            table.add_row(name, f"{real:.4g}", f"{middle:.4g}", band, out)
        show(table)
