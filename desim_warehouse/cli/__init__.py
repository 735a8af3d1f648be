"""The `desim` command, whose subcommands are each one call of the public API.

Subcommands are modules of this package, imported when they are called, so that `desim --help` is fast.
"""

from __future__ import annotations

import gc
import importlib
import os
import re
import sys
from collections.abc import Iterable
from typing import Any

import click
from click.shell_completion import CompletionItem, add_completion_class

from desim_warehouse._version import __version__

COMMANDS = {
    "new": ("new", "Write a first model file from a few options."),
    "draw": ("draw", "Draw the floor of a model as PNG or SVG."),
    "run": ("run", "Simulate a model once and show its indicators."),
    "replay": ("replay", "Write a page that plays a run in a browser."),
    "report": ("report", "Write the report of a model, run or study as one HTML page."),
    "export": ("export", "Export a run, or the layout of a model, for other programs."),
    "import": ("import_layout", "Convert a layout from another program into a model."),
    "orders": ("orders", "Read one day of orders exported from a WMS or ERP."),
    "check": ("check", "Check a model file and its layout."),
    "serve": ("serve", "Open a live page: move sliders, and watch the answer become more precise."),
    "study": ("study", "Run a study file, or resume the study in a folder."),
    "what-if": ("what_if", "Vary keys of a model, and show how the indicators change."),
    "compare": ("compare", "Compare the designs of a study with its baseline."),
    "plan": ("plan", "Find how many robots and chargers are needed, today and later, and what is scarce."),
    "why": ("why", "Find the bottlenecks of a warehouse, and what each of them costs."),
    "best": ("best", "Find the best of several designs with few runs."),
    "size": ("size", "Find the smallest fleet, or value of another key, that meets a target."),
    "calibrate": ("calibrate", "Estimate the parameters of a model from logs of the real fleet."),
    "validate": ("validate", "Test a model against logs of real days."),
    "fit": ("fit", "Fit a distribution to measured times."),
    "warm-up": ("warm_up", "Find how long a model without an end takes to warm up."),
    "paper": ("paper", "Repeat the paper's experiment, beside its published figures."),
    "policies": ("policies", "List all policies, or show one in detail."),
    "orient": ("orient", "Make two-way lanes one-way, or search for better directions of aisles."),
    "schema": ("schema", "Print the JSON Schema of model files, study files or answers."),
}
"""The module of this package with the function `command`, and the line in the overview, by subcommand."""
GONE = {
    "long-run": "desim what-if MODEL --replications 20: one interval over runs that do not depend on each other",
    "screen": "desim report FOLDER, which says which factor matters; docs/how-to/run-a-study.md has Sobol indices",
}
"""Replacements of removed subcommands."""


_GARBAGE = 200_000
"""Number of new objects between garbage collections; with Python's 700 these take a tenth of a small run."""


_TOGETHER = re.compile(r"(?<!\S)(--[\w-]+) (?=[^\s-])|(\d) (?=%)")
"""An option with its value, or a number before a per cent sign, in a help page."""
_WHOLE = {"-": "\u2011", " ": "\u00a0"}
"""Characters at which lines are folded, and their non-breaking equivalents."""


class _Formatter(click.HelpFormatter):
    """Formatter that folds help pages only at spaces, and not between an option and its value, which people copy."""

    def write_text(self, text: str) -> None:
        super().write_text(_whole(text))

    def write_dl(self, rows: Iterable[tuple[str, str]], col_max: int = 30, col_spacing: int = 2) -> None:
        super().write_dl([(first, _whole(second)) for first, second in rows], col_max, col_spacing)

    def getvalue(self) -> str:
        text = super().getvalue()
        for sign, whole in _WHOLE.items():
            text = text.replace(whole, sign)
        return text


def _whole(text: str) -> str:
    """Replace hyphens, and spaces between options and their values, by non-breaking characters."""
    return _TOGETHER.sub(rf"\1\2{_WHOLE[' ']}", text).replace("-", _WHOLE["-"])


class _Context(click.Context):
    formatter_class = _Formatter


class _Commands(click.Group):
    """Group of subcommands, which are imported from their modules on use."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        ctx.meta["desim.typed"] = list(args)
        return super().parse_args(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        if cmd_name not in COMMANDS:
            return None
        module, _ = COMMANDS[cmd_name]
        command: click.Command = importlib.import_module(f"desim_warehouse.cli.{module}").command
        command.context_class = _Context
        return command

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Complete subcommands without importing them."""
        names = [CompletionItem(name, help=line) for name, (_, line) in COMMANDS.items() if name.startswith(incomplete)]
        return names if incomplete[:1] != "-" else click.Command.shell_complete(self, ctx, incomplete)

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            click.echo("stopped", err=True)
            ctx.exit(130)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        typed = args[0]
        if typed in GONE:
            ctx.fail(f"{typed} went in 0.4; instead: {GONE[typed]}")
        if typed not in COMMANDS and not ctx.resilient_parsing:
            from desim_warehouse.errors import nearest

            if near := nearest(typed, COMMANDS):
                ctx.fail(f"No such command {typed!r}. Did you mean {near!r}?")
        name, command, rest = super().resolve_command(ctx, args)
        if command is not None and not ctx.resilient_parsing:
            inner = click.Context(command, ctx, name)
            try:
                _refuse_repeated(inner, rest)
            except click.NoSuchOption as error:
                if cure := self._instead(inner, error.option_name, rest):
                    inner.fail(f"No such option {error.option_name!r}. {cure}")
                raise
        return name, command, rest

    def _instead(self, ctx: click.Context, option: str, args: list[str]) -> str:
        """Suggest a replacement of an option that a command lacks: a key of the model, or a command that has it."""
        from desim_warehouse.errors import spoken
        from desim_warehouse.model.schema import OUTLINE

        word = option.removeprefix("--").replace("-", "_")
        if any("--set" in parameter.opts for parameter in ctx.command.params) and (key := OUTLINE.named(word)):
            _, _, value = next(arg for arg in args if arg.partition("=")[0] == option).partition("=")
            value = value or next(iter(args[args.index(option) + 1 :]), "")
            return f"Did you mean '--set {key}={value}'?"
        commands = ((name, self.get_command(ctx, name)) for name in COMMANDS)
        having = [
            name
            for name, command in commands
            if command and any(option in parameter.opts for parameter in command.params)
        ]
        return f"It is an option of desim {spoken(having)}." if having else ""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        with formatter.section("Commands"):
            formatter.write_dl([(name, line) for name, (_, line) in COMMANDS.items()])


def _refuse_repeated(ctx: click.Context, args: list[str]) -> None:
    """Refuse an option that takes one value and is typed twice; click would silently use the last value."""
    _, _, order = ctx.command.make_parser(ctx).parse_args(list(args))
    single = [
        option
        for option in order
        if isinstance(option, click.Option) and not (option.multiple or option.is_flag or option.count)
    ]
    repeated = next((option for place, option in enumerate(single) if option in single[:place]), None)
    if repeated is not None:
        ctx.fail(f"{repeated.opts[0]}: typed twice, expected once")


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="desim")
def desim() -> None:
    """What-if simulator for robot warehouses."""


_OBEYED = re.compile("\x1b(?!\\[[0-9;]*m)|[\x00-\x08\x0b-\x0d\x0e-\x1a\x1c-\x1f\x7f-\x9f]")
"""Control characters and sequences of a terminal, except colours, tabs and line ends."""


class _Harmless:
    """Standard output through which names of files and folders cannot control the terminal."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def write(self, text: str) -> None:
        """Write the text with control characters escaped."""
        self._stream.write(_OBEYED.sub(lambda match: repr(match[0])[1:-1], text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def main() -> None:
    """Run the command; errors of the package are printed as a message without traceback, with exit status 2."""
    from desim_warehouse.errors import WarehouseError, got, reason

    if "_DESIM_COMPLETE" in os.environ:
        from desim_warehouse.cli.completion import Bash

        add_completion_class(Bash)
    gc.set_threshold(_GARBAGE)  # before anything else is imported
    from desim_warehouse.study.execution import process

    process.alone()
    if sys.stdout is not None:  # None where the shell has closed it
        sys.stdout = _Harmless(sys.stdout)
    try:
        desim(standalone_mode=True)
    except WarehouseError as error:
        message = str(error)
    except OSError as error:  # an impossible path; code that opens files reports other errors in more detail
        message = f"{got(str(error.filename))}: {reason(error)}" if error.filename else reason(error)
    except UnicodeEncodeError as error:
        message = f"{got(str(error.object))}: not text that can be written in {error.encoding.upper()}"
    from desim_warehouse.model.messages import printable

    click.echo("\n".join(map(printable, message.split("\n"))), err=True)
    sys.exit(2)
