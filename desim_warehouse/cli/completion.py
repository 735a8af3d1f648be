"""Shell completion of keys of a model, indicators and files."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import click
from click.shell_completion import BashComplete, CompletionItem

from desim_warehouse.errors import WarehouseError


class AtPath(click.ParamType[str]):
    """The path of a file or folder, checked only by the code that opens it."""

    name = "path"

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:  # noqa: ARG002
        """Let the shell complete the path."""
        return [CompletionItem(incomplete, type="file")]


class Bash(BashComplete):
    """Completion for bash that adds no space after `fleet.` and `fleet.size=`."""

    source_template = BashComplete.source_template.replace(
        "    return 0", "    [[ ${COMPREPLY[0]} == *[.=] ]] && compopt -o nospace\n    return 0"
    )


def keys_then(end: str) -> Callable[[click.Context, click.Parameter, str], list[str]]:
    """Return a completion of dotted keys of a model, section by section, with names from the model file on the line.

    `end`: the end of a complete key, such as `=`.
    """

    def complete(context: click.Context, _: click.Parameter, incomplete: str) -> list[str]:
        from desim_warehouse.model.schema import OUTLINE

        above = tuple(incomplete.split(".")[:-1])
        here = dict.fromkeys([*OUTLINE.keys_at(above), *_names(context.meta["desim.typed"], above)])
        paths = [(*above, key) for key in here]
        is_section = {path: OUTLINE.keys_at(path) or OUTLINE.keys_at((*path, "NAME")) for path in paths}
        offered = [".".join(path) + ("." if is_section[path] else end) for path in paths]
        return [key for key in offered if key.startswith(incomplete)]

    return complete


def indicators(_: click.Context, __: click.Parameter, incomplete: str) -> list[str]:
    """Return the names of indicators that complete a word."""
    from desim_warehouse.outcome.indicators import INDICATORS

    return [name for name in INDICATORS if name.startswith(incomplete)]


def _names(typed: Iterable[str], above: Iterable[str]) -> list[str]:
    """Return the keys of a section of the model file on the line; empty if the file cannot be read."""
    from desim_warehouse.model.parse import read_yaml

    file = next((word for word in typed if Path(word).is_file()), None)
    try:
        section = read_yaml(Path(file).read_text(encoding="utf-8"), file).data if file else None
    except (OSError, ValueError, WarehouseError):
        return []
    for key in above:
        section = section.get(key) if isinstance(section, dict) else None
    return list(map(str, section)) if isinstance(section, dict) else []
