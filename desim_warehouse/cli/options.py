"""Options that several subcommands share."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast, get_args

import click

from desim_warehouse.cli.completion import indicators, keys_then
from desim_warehouse.errors import ModelError, ReportError, reason
from desim_warehouse.findings import Acceptable

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.questions.run import Run

F = TypeVar("F", bound=Callable[..., Any])
_set = click.option(
    "--set",
    "assignments",
    shell_complete=keys_then("="),
    multiple=True,
    metavar="KEY=VALUE",
    help="Set a key of the model, such as fleet.size=3 or tasks.goods=[11,8]; may be repeated.",
)
_unset = click.option(
    "--unset",
    "removed",
    shell_complete=keys_then(""),
    multiple=True,
    metavar="KEY",
    help="Remove a key from the model, such as tasks.goods, as if it were not in the file; may be repeated.",
)
_accept = click.option(
    "--accept",
    "accepted",
    multiple=True,
    type=click.Choice(get_args(Acceptable)),
    metavar="CODE",
    help="Simulate despite this error found by `desim check`; may be repeated. Short for --set accept=[CODE, ...].",
)
with_seed = click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the random number streams."
)
with_confidence = click.option(
    "--confidence",
    type=click.FloatRange(0, 1, min_open=True, max_open=True),
    default=0.95,
    show_default=True,
    help="Confidence level of intervals and verdicts.",
)
with_indicator = click.option(
    "--indicator",
    "indicators",
    shell_complete=indicators,
    multiple=True,
    metavar="NAME",
    help="An indicator to show, or all; may be repeated.  [default: the usual ones for this kind of model]",
)
with_dates = click.option(
    "--dates",
    type=click.Choice(["us", "uk"]),
    help="How to read a date such as 03/02/2026: us, March 2; uk, 3 February.",
)
with_force = click.option("--force", is_flag=True, help="Overwrite existing files.")


def with_overrides(command: F) -> F:
    """Add `--set`, `--unset` and `--accept`; the command receives all of them as `assignments`."""

    @wraps(command)
    def call(
        *, assignments: tuple[str, ...], removed: tuple[str, ...], accepted: tuple[str, ...], **options: Any
    ) -> Any:
        from desim_warehouse.model import UNSET

        accept = (f"accept=[{', '.join(accepted)}]",) if accepted else ()
        gone = (f"{key}={UNSET.value}" for key in removed)
        return command(assignments=(*assignments, *gone, *accept), **options)

    return cast("F", _set(_unset(_accept(call))))


def with_json(content: str = "") -> Callable[[F], F]:
    """Add `--json`; `content` describes the object in the help."""
    return click.option(
        "--json", "as_json", is_flag=True, help=f"Print one JSON object{': ' if content else ''}{content}."
    )


class TimeIn(click.ParamType[float]):
    """A time above 0 with a unit, such as `20 min`; a plain number is in the unit of the option."""

    name = "time"

    def __init__(self, unit: str, most: float = math.inf) -> None:
        """Set the unit of plain numbers, and the number (`most`) above which a plain number gets a warning."""
        self.unit, self.most = unit, most

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the time in the unit of the option."""
        from desim_warehouse.values.units import SECONDS, UnitNames, quantity

        if not isinstance(value, str):
            return float(value)
        try:
            time = quantity(value, "time", UnitNames("m", self.unit, float(SECONDS[self.unit])))
        except ValueError as error:
            self.fail(str(error), param, ctx)
        if not time > 0:
            self.fail(f"{value} is not above 0", param, ctx)
        if time > self.most and value.strip()[-1:].isdecimal():
            click.echo(f"warning: {value} is {value} {self.unit}; for seconds write {value}s", err=True)
        return time


def refuse_files(paths: Iterable[Path], *, force: bool) -> None:
    """Refuse to overwrite files without `force`; raises ModelError."""
    for path in paths if not force else ():
        if path.exists():
            raise ModelError([f"{path}: the file exists; choose another name, or overwrite it with --force"])


def write_files(files: Mapping[Path, str], *, force: bool) -> None:
    """Write a model file and the files that belong to it.

    Raises:
        ModelError: a file that exists (without `force`) or cannot be written.
    """
    refuse_files(files, force=force)
    for path, text in files.items():
        try:
            path.write_text(text, encoding="utf-8")
        except (OSError, ValueError) as error:
            raise ModelError([f"{path}: cannot be written ({reason(error)})"]) from None


def load_model(path: str, assignments: tuple[str, ...], **besides: Any) -> Model:
    """Load the model of a file for a simulation or check, with the overrides `besides` and then `--set` applied."""
    from desim_warehouse.model import load, parse_assignment

    overrides: dict[str, Any] = {**besides, **dict(parse_assignment(text) for text in assignments)}
    return load(path, overrides, named="--set", run_code=True)


def load_source(source: str, assignments: tuple[str, ...], **besides: Any) -> Model | Run:
    """Return the run of a folder, or the model of a file with the overrides `besides` and then `--set` applied.

    Raises:
        ReportError: overrides of a finished run.
    """
    from desim_warehouse.questions.run import load_run

    if not Path(source).is_dir():
        return load_model(source, assignments, **besides)
    if assignments:
        raise ReportError(f"{source} is a run that is over: --set is for models")
    return load_run(source)


def run_of(
    source: str,
    assignments: tuple[str, ...],
    seed: int,
    *,
    until: Callable[[Model], float | None] = lambda _: None,
    **besides: Any,
) -> Run:
    """Return the run of a folder, or simulate a model file; raises as `load_source`.

    `until`: returns the time at which a simulation of a model ends, None for its whole run.
    """
    from desim_warehouse.questions.run import Run as Done

    start = load_source(source, assignments, **besides)
    return start if isinstance(start, Done) else simulated(start, seed, until=until(start))


def simulated(model: Model, seed: int, *, until: float | None = None) -> Run:
    """Simulate a run of a model, up to `until` if given, with its settled fleet from the user's cache.

    A terminal shows the progress.
    """
    from desim_warehouse.cli.waiting import Waiting
    from desim_warehouse.questions.run import Run
    from desim_warehouse.study.execution.kept_fleets import FleetsOfACommand

    with Waiting("simulating", model, until) as waiting:
        return Run.simulated(model, seed, waiting, until=until, fleets=FleetsOfACommand(cache=True))
