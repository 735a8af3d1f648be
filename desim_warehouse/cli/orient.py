"""`desim orient`."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse.cli.completion import AtPath, indicators
from desim_warehouse.cli.options import load_model, refuse_files, with_force, write_files
from desim_warehouse.cli.study_options import interruptible, with_search
from desim_warehouse.cli.tables import NONE_MEETS
from desim_warehouse.errors import first_of
from desim_warehouse.study.statistics.limits import SEARCH_RUNS

if TYPE_CHECKING:
    from desim_warehouse.layout.orient import Orientation
    from desim_warehouse.model import Model
    from desim_warehouse.study.search import Search

_AGAINST = (1.5, 2)
_OPEN = "throughput_per_hour"
_FAR = 1.3
_SHOWN = 12
_RUNS = 5


@click.command("orient")
@click.argument("model", type=AtPath())
@click.option("-o", "--out", "file", required=True, metavar="FILE", help="Model file to write.")
@click.option(
    "--indicator",
    shell_complete=indicators,
    metavar="NAME",
    help="Search by simulation for the directions that are best in this indicator, such as on_time.",
)
@click.option(
    "--prefer",
    is_flag=True,
    help="Also try two-way lanes that prefer a direction, and write the floor that performs best.",
)
@click.option(
    "--runs",
    type=click.IntRange(0),
    help=f"Maximum number of runs.  [default: {_RUNS} for each floor compared; with --indicator {SEARCH_RUNS}]",
)
@with_search("seed", out="--study")
@with_force
def command(
    model: str,
    file: str,
    indicator: str | None,
    search: Search,
    *,
    prefer: bool,
    force: bool,
) -> None:
    """Make two-way lanes of MODEL one-way wherever the floor stays connected, or search for better directions.

    Without --indicator, parallel aisles alternate at first; then aisles and lanes are reversed as long as that shortens
    the mean trip between goods and stations. Bridges stay two-way. The command reports how much longer trips become
    and, from paired runs, which of the two floors performs better. With --prefer, the best of these floors is written:
    lanes one-way; lanes two-way, but counting 1.5 or 2 times as long against the preferred direction (key against); or
    lanes as they are, in which case nothing is written. Bridges stay as they are.

    With --indicator, one-way aisles may be reversed, too, and two-way aisles may become one-way or prefer a direction.
    The search simulates the floors; the best is then compared with the original floor in runs that the search did not
    use, also with other fleets and demands. Exit status 3: nothing better was found, and nothing is written.
    Example: desim orient w.yaml -o turned.yaml --indicator throughput_per_hour
    """
    if indicator is not None:
        if prefer:
            raise click.UsageError(
                "--prefer is for floors without --indicator, which tries preferred directions anyhow"
            )
        _search(model, file, indicator, search, force=force)
    elif prefer:
        _prefer(model, file, search, force=force)
    else:
        _by_distance(model, file, search, force=force)


def _search(model: str, file: str, indicator: str, search: Search, *, force: bool) -> None:
    from desim_warehouse.model.oriented import turned_files
    from desim_warehouse.questions.orient import orient

    base = load_model(model, ())
    refuse_files([Path(file)], force=force)
    with interruptible(None, search):
        better = orient(base, indicator, search=search)
    click.echo("\n".join(better.answer.answer))
    if better.gain is None:
        sys.exit(NONE_MEETS)
    write_files(turned_files(Path(model), base, better.ways, Path(file)), force=force)
    _written(file)


def _by_distance(model: str, file: str, search: Search, *, force: bool) -> None:
    from desim_warehouse.model.oriented import orientation, oriented_files

    base = load_model(model, ())
    directions = orientation(base)
    write_files(oriented_files(Path(model), base, directions, Path(file)), force=force)
    click.echo("\n".join(_sentences(directions)))
    if each := _of_each(search, 2):
        click.echo(_compared(base, load_model(file, ()), each))
    _written(file)


def _of_each(search: Search, floors: int) -> range:
    """Return the seeds with which each floor is simulated."""
    return range(search.seed, search.seed + (_RUNS if search.runs is None else search.runs // floors))


def _written(file: str) -> None:
    click.echo(f"{file} is written; next: desim check {file}")


def _sentences(directions: Orientation) -> list[str]:
    lines = [f"{len(directions.kept)} two-way lanes are one-way now; trips between storage and stations are "]
    lines[0] += f"{directions.stretch:.2f} times as long"
    if round(directions.stretch, 2) > _FAR:  # rounded, as it is printed
        lines.append(f"warning: more than {_FAR} times as long; two-way lanes may serve better here")
    if directions.bridges:
        names = first_of(["-".join(lane) for lane in directions.bridges], _SHOWN)
        lines.append(f"{len(directions.bridges)} stay two-way, as they alone lead to what is beyond: {names}")
    return lines


def _prefer(path: str, file: str, search: Search, *, force: bool) -> None:
    """Write the best of the floors by paired runs, and print the results of each floor."""
    from desim_warehouse.answer import words
    from desim_warehouse.model.oriented import orientation, oriented, oriented_files
    from desim_warehouse.study.statistics.comparison import paired

    base = load_model(path, ())
    directions = orientation(base)
    key = _judged_by(base)
    floors: dict[str, float | None] = {"one-way": None} | {f"preferred, {factor:g}": factor for factor in _AGAINST}
    each = _of_each(search, 1 + len(floors))
    if not each:
        raise click.UsageError(f"--prefer chooses by runs; expected --runs {1 + len(floors)} or more")
    kpis = {"two-way": _runs(base, key, each)}
    kpis |= {name: _runs(oriented(base, directions, factor), key, each) for name, factor in floors.items()}
    means = {name: math.fsum(values) / len(each) for name, values in kpis.items()}
    best = (max if key == _OPEN else min)(means, key=means.__getitem__)
    scale = words.scale(key, base, list(means.values()))
    click.echo(f"{words.in_sentence(key)} of {len(each)} runs each, and the difference to two-way by pairs:")
    for name, values in kpis.items():
        gain = "" if name == "two-way" else f"  {scale.estimate(paired(values, kpis['two-way']))}"
        click.echo(f"  {name:15}{scale.value(means[name]):>12}{gain}{'  best' if name == best else ''}")
    if best == "two-way":
        click.echo(f"two-way lanes as they are do best: {file} is not written")
        return
    write_files(oriented_files(Path(path), base, directions, Path(file), floors[best]), force=force)
    if floors[best] is None:
        click.echo("\n".join(_sentences(directions)))
    else:
        click.echo(f"{len(directions.kept)} two-way lanes prefer a direction: against: {floors[best]:g} on each")
    _written(file)


def _judged_by(model: Model) -> str:
    """Return the indicator that compares floors: throughput if tasks are always open, else mean cycle time or T."""
    if model.tasks.never_end and not model.tasks.arrive:
        return _OPEN
    return "cycle_time_mean" if model.run.length else "T"


def _runs(floor: Model, key: str, seeds: range) -> list[float]:
    from desim_warehouse import simulate

    return [simulate(floor, seed).kpis[key] for seed in seeds]


def _compared(two_way: Model, one_way: Model, seeds: range) -> str:
    """Return a sentence that compares the two floors by paired runs."""
    from desim_warehouse.answer import words
    from desim_warehouse.study.statistics.comparison import paired

    key = _judged_by(two_way)
    kpis = [_runs(floor, key, seeds) for floor in (one_way, two_way)]
    gain = paired(kpis[0], kpis[1])
    interval = gain.interval or (gain.mean, gain.mean)
    verdict = "no significant difference"
    if key == _OPEN:
        interval = -interval[1], -interval[0]
    if interval[1] < 0:
        verdict = "one-way does better"
    elif interval[0] > 0:
        verdict = "two-way does better"
    means = [math.fsum(values) / len(seeds) for values in kpis]
    scale = words.scale(key, two_way, means)
    both = " against ".join(map(scale.value, means))
    name = words.in_sentence(key)
    return f"{name} of {len(seeds)} runs each: one-way {both} two-way, {scale.estimate(gain)} by pairs: {verdict}"
