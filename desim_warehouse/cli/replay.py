"""`desim replay`."""

from __future__ import annotations

import click

from desim_warehouse.cli.options import run_of, with_overrides, with_seed
from desim_warehouse.errors import ReportError


@click.command("replay")
@click.argument("source", metavar="MODEL|RUN_DIR")
@click.option("-o", "--out", "output", metavar="FILE", help="The page to write.  [default: replay.html]")
@with_overrides
@with_seed
@click.option(
    "--beside",
    metavar="MODEL|RUN_DIR",
    help="Another run, shown next to it on the same clock; --set and --accept change only MODEL.",
)
@click.option("--from", "start", type=float, metavar="T", help="First moment shown, in the model's time unit.")
@click.option("--to", "end", type=float, metavar="T", help="Last moment shown.")
@click.option("--gif", metavar="FILE", help="Write an animated GIF of the window instead of the page.")
@click.option("--mp4", metavar="FILE", help="Write a film of the window instead of the page (needs ffmpeg).")
@click.option(
    "--palette",
    type=click.Choice(["safe", "paper"]),
    default="safe",
    show_default=True,
    help="Colours safe for colour-blind people, or the paper's.",
)
@click.option("--speed", type=float, metavar="X", help="GIF and MP4: times real time.  [default: to last 20 s]")
def command(
    source: str,
    output: str | None,
    assignments: tuple[str, ...],
    seed: int,
    beside: str | None,
    start: float | None,
    end: float | None,
    gif: str | None,
    mp4: str | None,
    palette: str,
    speed: float | None,
) -> None:
    """Write a page that plays a run in any browser, without a network: simulated from MODEL, or read from RUN_DIR."""
    films = [path for path in (gif, mp4) if path is not None]
    if films and beside is not None:
        raise ReportError("--beside is for the page; a film shows one run: leave out --beside, or --gif and --mp4")
    run = run_of(source, assignments, seed)
    if films:
        from desim_warehouse.report.film import film

        for path in films:
            click.echo(film(run, path, start=start, end=end, speed=speed, palette=palette))
    if output is not None or not films:
        other = None if beside is None else run_of(beside, (), seed)
        page = run.replay(output or "replay.html", start=start, end=end, palette=palette, beside=other)
        click.echo(f"{output or 'replay.html'}: {len(page.html) / 1e6:.1f} MB; open it in a browser")
