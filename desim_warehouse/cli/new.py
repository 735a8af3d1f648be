"""`desim new`."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import TimeIn, refuse_files, with_force, write_files
from desim_warehouse.errors import ModelError
from desim_warehouse.folders import gallery

if TYPE_CHECKING:
    from desim_warehouse.draft import Draft

_WORKED_OUT = "by a quick estimate"
_OTHERS = ("file", "like", "schema", "force")
"""Parameters of the command that do not describe a draft."""
_QUESTIONS = {
    "size": ("Floor in metres, width x height", ""),
    "orders": ("Orders", ""),
    "due": ("Due after how many minutes", ""),
    "shifts": ("Shifts", "always"),
    "peak": ("Peak, such as 11:30-13x1.6", "none"),
    "packers": ("Packers, or auto", "not said"),
    "inbound": ("Loads put away", "none"),
    "floors": ("How many floors", "one"),
    "lifts": ("How many lifts", _WORKED_OUT),
    "aisles": ("How many aisles", "as many as fit"),
    "stations": ("How many stations", "as many as needed"),
    "robots": ("How many robots", _WORKED_OUT),
    "chargers": ("How many chargers", _WORKED_OUT),
}
"""Questions in the terminal, by option: the prompt, and words for no answer; empty: the default of the option."""


@click.command("new")
@click.argument("file", type=AtPath(), required=False)
@click.option(
    "--size",
    default="60x40",
    show_default=True,
    metavar="WxH",
    help="Width x height of each floor, in metres or with a unit, such as 200x130ft.",
)
@click.option(
    "--orders",
    default="200/h",
    show_default=True,
    metavar="RATE",
    help="Order rate, such as 200/h, or 1600/d for a whole day's orders within its opening hours.",
)
@click.option("--floors", type=int, metavar="N", help="Number of floors, one above the other.  [default: 1]")
@click.option("--lifts", type=int, metavar="N", help=f"Number of lifts between floors.  [default: {_WORKED_OUT}]")
@click.option("--aisles", type=int, metavar="N", help="Number of parallel aisles.  [default: as many as fit]")
@click.option(
    "--stations", type=int, metavar="N", help="Number of packing stations.  [default: as many as the orders need]"
)
@click.option("--robots", type=int, metavar="N", help=f"Number of robots.  [default: {_WORKED_OUT}]")
@click.option("--chargers", type=int, metavar="N", help=f"Number of chargers.  [default: {_WORKED_OUT}]")
@click.option(
    "--due",
    type=TimeIn("min", most=120),
    default="15min",
    show_default=True,
    metavar="TIME",
    help="Time from the arrival of an order until it is due; a plain number is in minutes.",
)
@click.option(
    "--shifts",
    metavar="FROM-TO",
    help="Hours in which orders arrive, such as 06-22, 6am-10pm or 22-06; open ones are still worked off between and "
    "after them.  [default: always]",
)
@click.option(
    "--peak",
    metavar="FROM-TOxTIMES",
    help="Hours with more orders, and how many times as many, such as 11:30-13x1.6.",
)
@click.option(
    "--packers", metavar="N", help="Number of people who pack, over all stations; auto: as many as are needed."
)
@click.option("--inbound", metavar="RATE", help="Rate of loads to put away, such as 60/h.  [default: none]")
@click.option(
    "--like",
    type=click.Choice(list(gallery())),
    help="Copy a complete warehouse from the gallery instead of drafting one.",
)
@click.option("--schema", is_flag=True, help="Also write the JSON Schema, with which editors complete and check keys.")
@with_force
@click.pass_context
def command(
    context: click.Context, /, file: str | None, *, like: str | None, schema: bool, force: bool, **wishes: Any
) -> None:
    """Write a commented model FILE from a few options, ready for `check`, `draw`, `run` and `plan`.

    Without FILE, the command asks for the options. Example: desim new w.yaml --size 70x45 --orders 420/h --shifts
    06-22 --peak 11:30-13x1.6
    """
    from desim_warehouse.draft import draft

    if like:
        file, text = file or f"{like}.yaml", _of_gallery(context, like)
        summary = " ".join(line.removeprefix("# ") for line in text.split("\nname:")[0].splitlines())
    else:
        if file is None:
            if not sys.stdin.isatty():
                raise click.UsageError("which file? Expected FILE, such as w.yaml; in a terminal `desim new` asks")
            file, text = _asked(wishes, force=force)
        else:
            text = draft(_words(wishes))
        summary = text.splitlines()[0].removeprefix("# ")
    write_files(_with_schema(Path(file), text) if schema else {Path(file): text}, force=force)
    click.echo(summary)
    click.echo(f"{file} is written; next: desim check {file}")


def _with_schema(model: Path, text: str) -> dict[Path, str]:
    """Return texts by path: the model, whose first line refers editors to the schema beside it, and the schema."""
    from desim_warehouse.model import json_schema

    beside = model.with_suffix(".schema.json")
    line = f"# yaml-language-server: $schema={beside.name}\n"
    return {model: line + text, beside: json.dumps(json_schema(), indent=2) + "\n"}


def _of_gallery(context: click.Context, like: str) -> str:
    """Return the text of a model of the gallery; raise UsageError for options of a draft, as they have no effect."""
    typed = ParameterSource.COMMANDLINE
    words = {str(option.name): option.opts[0] for option in context.command.params if option.name not in _OTHERS}
    flags = [flag for name, flag in words.items() if context.get_parameter_source(name) is typed]
    if flags:
        raise click.UsageError(f"{' and '.join(flags)}: not with --like; write the file, then correct it there")
    return gallery()[like].read_text(encoding="utf-8")


def _words(wishes: Mapping[str, Any]) -> Draft:
    from desim_warehouse.draft import Draft, read_orders, read_packers, read_size
    from desim_warehouse.working_day import WorkingDay, read_peak, read_shifts

    words = dict(wishes)
    shifts, peak = words.pop("shifts"), words.pop("peak")
    open_from_to = read_shifts(shifts) if shifts else ()
    day, even = WorkingDay(open_from_to, read_peak(peak, open_from_to) if peak else None), WorkingDay(open_from_to)
    read = {
        "size": read_size(words["size"]),
        "floors": 1 if words["floors"] is None else words["floors"],
        "orders": read_orders(words["orders"], day=day),
        "day": day,
        "packers": None if words["packers"] is None else read_packers(words["packers"]),
        "inbound": read_orders(words["inbound"], "--inbound", even) if words["inbound"] else 0.0,
        "people": any(wish is not None for wish in (shifts, peak, words["packers"], words["inbound"])),
    }
    return Draft(**{**words, **read})


def _asked(defaults: dict[str, Any], *, force: bool) -> tuple[str, str]:
    """Prompt for the file and the options of a draft one by one; return the file and its text.

    Enter accepts the default in brackets. A question is asked again if its answer is impossible, by itself or, once all
    are answered, beside the others.
    """
    from desim_warehouse.draft import draft

    file: str = click.prompt(
        "Model file to write", default="warehouse.yaml", value_proc=partial(_new_file, force=force)
    )
    words = dict(defaults)
    for name in _QUESTIONS:
        if name != "lifts" or words["floors"] not in {None, 1}:
            words[name] = _ask(name, words, defaults[name])
    while True:
        try:
            return file, draft(_words(words))
        except ModelError as error:
            if not (again := [name for name in _QUESTIONS if _about(name, error)]):
                raise
            for name in again:
                click.echo(f"Error: {_about(name, error)}")
                words[name] = _ask(name, words, defaults[name])


def _new_file(path: str, *, force: bool) -> str:
    """Return the path of a file that can be written; raise UsageError for another."""
    if not Path(path).absolute().parent.is_dir():
        raise click.UsageError(f"{path}: no such folder")
    try:
        refuse_files([Path(path)], force=force)
    except ModelError as error:
        raise click.UsageError(str(error)) from None
    return path


def _ask(name: str, words: Mapping[str, Any], default: Any) -> Any:
    """Prompt for one option of a draft until the answer is possible; return the default if it is accepted."""
    from desim_warehouse.draft import checked

    question, otherwise = _QUESTIONS[name]
    accepted = otherwise or (f"{default:g}" if isinstance(default, float) else default)

    def value_of(reply: str) -> Any:
        value: Any = reply
        if reply == accepted:
            value = default
        elif name == "due":
            value = TimeIn("min").convert(reply, None, None)
        elif question.startswith("How many"):
            if not reply.isdecimal():
                raise click.UsageError(f"{reply}: not a number; Enter alone: {otherwise}")
            value = int(reply)
        try:
            checked(_words({**words, name: value}))
        except ModelError as error:
            if wrong := _about(name, error):
                raise click.UsageError(wrong) from None
        return value

    return click.prompt(question, default=accepted, value_proc=value_of)


def _about(name: str, error: ModelError) -> str:
    """Return what an error says of an option of a draft, without its dashes; empty for nothing."""
    return next((problem[2:] for problem in error.problems if problem.startswith(f"--{name} ")), "")
