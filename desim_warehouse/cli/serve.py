"""`desim serve`."""

from __future__ import annotations

import signal
import threading
from typing import TYPE_CHECKING, Any

import click

from desim_warehouse.cli.completion import AtPath, keys_then
from desim_warehouse.cli.options import load_model, with_overrides
from desim_warehouse.cli.study_options import read_vary
from desim_warehouse.cli.warned import warn

if TYPE_CHECKING:
    from desim_warehouse.live import Live


@click.command("serve")
@click.argument("model", type=AtPath())
@click.option(
    "--vary",
    shell_complete=keys_then("="),
    multiple=True,
    metavar="KEY[=VALUES]",
    help="A key that the page lets you change, with values as in desim what-if; may be repeated.  [default: robots, "
    "chargers, demand and dispatching]",
)
@click.option("--target", help="Target for designs to meet.  [default: on_time >= 95 % if tasks have due times]")
@with_overrides
@click.option(
    "--workers",
    default="auto",
    show_default=True,
    metavar="N|auto",
    help="Number of processes that simulate; auto: one for each processor.",
)
@click.option("--out", metavar="DIR", help="Folder to store all runs in.  [default: a folder in the cache]")
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port on 127.0.0.1.  [default: a free port]")
@click.option(
    "--embed",
    multiple=True,
    metavar="ORIGIN",
    help="Origin of a site that may embed the page in a frame; may be repeated.",
)
@click.option("--open/--no-open", "opens", default=True, show_default=True, help="Open the page in the browser.")
def command(
    model: str,
    vary: tuple[str, ...],
    target: str | None,
    assignments: tuple[str, ...],
    workers: str,
    out: str | None,
    port: int,
    embed: tuple[str, ...],
    opens: bool,
) -> None:
    """Open a live page on this machine: change MODEL with sliders, and watch the answer become more precise.

    Example: desim serve w.yaml --vary fleet.size=4..16 --vary policies.allocation
    """
    from desim_warehouse.live import serve

    base = load_model(model, assignments)
    warn(base, model, assignments)
    with serve(base, vary=_vary(vary), target=target, workers=workers, out=out, port=port, embed=embed) as live:
        _wait(live, opens=opens)


def _vary(texts: tuple[str, ...]) -> dict[str, Any]:
    """Return keys with their values, None for the usual values."""
    factors: dict[str, Any] = {}
    for text in texts:
        factors |= read_vary((text,)) if "=" in text else {text.strip(): None}
    return factors


def _wait(live: Live, *, opens: bool) -> None:
    """Print the address of the page, and wait until it is stopped."""
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else [])):
        signal.signal(number, lambda *_: ended.set())
    click.echo(f"{live.address}\nOnly this machine can open it. Runs are kept in {live.folder}")
    click.echo("Ctrl-C ends it.")
    if opens:
        import webbrowser

        webbrowser.open(live.address)
    while not ended.wait(0.5):  # on some systems, a signal is handled only between two waits
        pass
    click.echo("stopped")
