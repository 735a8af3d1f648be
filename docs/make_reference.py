"""The made parts of the documentation, made anew: `python -m docs.make_reference`.

A page has such a part between two comments:

    <!-- made: cli -->
    ...
    <!-- end -->

What stands between them comes from the program itself, so the reference cannot say anything else than the program
does. With `--check` nothing is written; pages that are not up to date are named and the exit status is 1.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import spoken
from desim_warehouse.outcome.indicators import INDICATORS
from desim_warehouse.outcome.log import COLUMNS, KINDS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

ROOT = Path(__file__).resolve().parent.parent
_MADE = re.compile(r"(<!-- made: ([a-z-]+) -->\n).*?(<!-- end -->)", re.DOTALL)
_WIDTH = 100  # columns of help texts


def table(heads: Iterable[str], rows: Iterable[Iterable[Any]], aligned: str = "") -> str:
    """A table in Markdown; `aligned` has an `r` for every column of numbers."""
    heads = list(heads)
    aligned = aligned.ljust(len(heads), "l")
    lines = [heads, ["---:" if side == "r" else "---" for side in aligned], *rows]
    return "\n".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


# The model file, from its JSON Schema


def model_keys() -> str:
    """Every section of a model file with its keys."""
    from desim_warehouse.model import json_schema

    schema = json_schema()
    return "\n".join(_sections(schema, schema["$defs"]))


def distributions() -> str:
    """The distributions of times that vary."""
    import inspect

    from desim_warehouse.values.distributions import KINDS

    docs = [(inspect.getdoc(kind) or "").partition("\n")[0].partition(": ") for kind in KINDS.values()]
    matches = [re.fullmatch(r"(`.*`): (.*)", "".join(doc)) for doc in docs]
    return table(("written", "what it is"), [one.groups() for one in matches if one is not None])


def limits() -> str:
    """What a file may hold at most."""
    from desim_warehouse.values.fields import LIMITS, SMALLEST

    rows = [(what, f"{most:,}") for most, what in LIMITS.values()]
    return table(("what", "limit"), [*rows, ("a number that must be above 0", f"at least {SMALLEST:g}")], "lr")


def units() -> str:
    """The units that values may be written with."""
    from desim_warehouse.values.units import EXAMPLES, TABLE

    def known(kind: str) -> str:
        if kind == "speed":
            return "a length unit and a time unit, as in `m/s` or `km/h`; `mph`"
        return ", ".join(f"`{unit}`" for unit in TABLE[kind])

    return table(("kind", "example", "units"), ((kind, f"`{EXAMPLES[kind]}`", known(kind)) for kind in TABLE))


def _sections(schema: Mapping[str, Any], defs: Mapping[str, Any]) -> Iterator[str]:
    """Yield the keys of the file, then each section; a section that stands in several places in full at one of them."""
    yield "## The file\n"
    yield _keys(schema)
    below = [item for key, part in schema["properties"].items() for item in _below(part, key, defs)]
    paths = [path for path, _ in below]
    sections = [
        (f"{path}: {{{next(iter(section['properties']))}: …}}" if paths.count(path) > 1 else path, _told(section))
        for path, section in below
    ]
    homes = dict[str, str]()
    for path, text in sections:
        homes[text] = min(homes.get(text, path), path, key=lambda each: each.count("."))
    elsewhere = tuple(f"{path.partition(':')[0]}." for path, text in sections if homes[text] != path)
    for path, text in sections:
        if homes[text] == path:
            yield f"## {path}\n"
            yield text
        elif not path.startswith(elsewhere):
            yield f"## {path}\n"
            yield f"The keys of `{homes[text]}`.\n"


def _told(section: Mapping[str, Any]) -> str:
    """Return what a section is, and its keys."""
    more = section["description"].partition("\n\n")[2]
    return "\n".join((f"{_sentence(section['description'])}\n", *([f"{more}\n"] if more else []), _keys(section)))


def _below(part: Mapping[str, Any], path: str, defs: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The sections that a key may hold, each with its dotted key; then what is below them."""
    if "$ref" in part:
        part = defs[part["$ref"].rpartition("/")[2]]
    if "a distribution such as" in part.get("errorMessage", ""):
        return  # described once, for all times that may vary
    for form in (*part.get("anyOf", ()), *part.get("oneOf", ())):
        yield from _below(form, path, defs)
    if "items" in part:
        yield from _below(part["items"], f"{path}[i]", defs)
    if isinstance(part.get("additionalProperties"), dict):
        yield from _below(part["additionalProperties"], f"{path}.NAME", defs)
    if "properties" in part and not _is_policy(part):
        yield path, part
        for key, inner in part["properties"].items():
            yield from _below(inner, f"{path}.{key}", defs)


def _is_policy(part: Mapping[str, Any]) -> bool:
    return part.get("title") == "PolicySpec"


def _sentence(text: str) -> str:
    first = " ".join(text.partition("\n\n")[0].split())
    return first if first.endswith((".", ":")) else first + "."


def _keys(section: Mapping[str, Any]) -> str:
    required = section.get("required", ())
    return table(
        ("key", "expected", "default", "meaning"),
        (
            (f"`{key}`", _expected(part), _default(key, part, required), part.get("description", ""))
            for key, part in section["properties"].items()
        ),
    )


def _default(key: str, part: Mapping[str, Any], required: Iterable[str]) -> str:
    if key in required:
        return "must be given"
    value = part.get("default")
    if value is None or value in ([], {}, ""):
        return "none"
    if isinstance(value, dict):
        return f"`{value['name']}`" if set(value) == {"name"} else "as below"
    return f"`{value:g}`" if isinstance(value, float) else f"`{value}`"


def _expected(part: Mapping[str, Any]) -> str:  # noqa: PLR0911 - a table
    """What a key expects, in words."""
    if "errorMessage" in part:
        return str(part["errorMessage"]).removeprefix("expected ")
    if "$ref" in part:
        return "a section"
    if "enum" in part:
        return ", ".join(f"`{word}`" for word in part["enum"])
    forms = [form for form in (*part.get("anyOf", ()), *part.get("oneOf", ())) if form.get("type") != "null"]
    if forms:
        return " or ".join(_expected(form) for form in forms)
    match part.get("type"):
        case "array" if "prefixItems" in part:
            return "a list of " + ", ".join(_expected(item) for item in part["prefixItems"])
        case "array":
            return f"a list of {_several(part.get('items', {}))}"
        case "object" if isinstance(part.get("additionalProperties"), dict):
            return f"names, each followed by {_expected(part['additionalProperties'])}"
        case "integer" | "number" as kind:
            return ("a whole number" if kind == "integer" else "a number") + _bounds(part)
        case "string" if "examples" in part:
            return f"with a unit (`{part['examples'][0]}`)"
    return "text"


def _several(item: Mapping[str, Any]) -> str:
    words = {"a section": "sections", "text": "names", "a number": "numbers"}
    expected = _expected(item)
    first = re.match(r"a number", expected)
    return words.get(expected, expected.replace("a number", "numbers", 1) if first else expected)


def _bounds(part: Mapping[str, Any]) -> str:
    signs = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}
    bounds = [f"{sign} {part[name]:g}" for name, sign in signs.items() if name in part]
    return " " + ", ".join(bounds) if bounds else ""


# Policies and commands


def policies() -> str:
    """The policies of every kind."""
    import dataclasses
    import inspect

    from desim_warehouse.policies.catalogue import OURS, find, parameters_of

    def shown(value: Any) -> str:
        if value is dataclasses.MISSING:
            return "must be given"
        return "none" if value is None else str(value).lower() if isinstance(value, bool) else str(value)

    lines = []
    for kind, names in OURS.items():
        rows = []
        for name in names:
            cls = find(kind, name)
            given = [f"`{key}` ({shown(default)})" for key, (_, default) in parameters_of(cls).items()]
            rows.append((f"`{name}`", (inspect.getdoc(cls) or "").partition("\n")[0], ", ".join(given) or "none"))
        lines += [f"### policies.{kind}\n", table(("name", "rule", "parameters (default)"), rows)]
    return "\n".join(lines)


def commands() -> str:
    """The help text of every command."""
    import click

    from desim_warehouse.cli import COMMANDS, desim

    def said(command: click.Command, name: str, parent: click.Context | None = None) -> str:
        with click.Context(command, parent, name, terminal_width=_WIDTH, **command.context_settings) as context:
            return "```text\n" + command.get_help(context).rstrip() + "\n```\n"

    outer = click.Context(desim, info_name="desim", **desim.context_settings)
    lines = ["## desim\n", said(desim, "desim")]
    for name in COMMANDS:
        command = desim.get_command(outer, name)
        if command is None:
            raise SystemExit(f"desim {name}: no such command")
        lines += [f"## desim {name}\n", said(command, name, outer)]
    return "\n".join(lines)


# Python


def public() -> str:
    """The public names, with the members of classes and modules that people use."""
    import desim_warehouse as dw

    names = [name for name in dw.__all__ if not name.startswith("_")]
    lines = ["## desim_warehouse\n", table(("name", "what it is"), (_entry(name, getattr(dw, name)) for name in names))]
    for name in ("Model", "Run", "Study", "Results"):
        shown = [
            _entry(member, value) for member, value in _members(getattr(dw, name)).items() if _is_shown(member, value)
        ]
        lines += [f"## {name}\n", table(("member", "what it is"), shown)]
    figures = [_entry(name, getattr(dw.plot, name)) for name in dw.plot.__all__ if callable(getattr(dw.plot, name))]
    lines += ["## plot\n", table(("function", "what it draws"), figures)]
    return "\n".join(lines)


def _members(cls: type) -> dict[str, Any]:
    """The members of a class and of the data that it shows, by name: those of the class that defines them first."""
    ours = re.compile(r"desim_warehouse\.(model|run|study|questions)\b")
    classes = [each for each in reversed(cls.__mro__) if ours.match(each.__module__)]
    members = {member: value for each in classes for member, value in vars(each).items()}
    return {
        member: value.__func__ if isinstance(value, classmethod | staticmethod) else value
        for member, value in members.items()
    }


def _is_shown(member: str, value: Any) -> bool:
    documented = callable(value) or isinstance(value, property) or hasattr(value, "attrname")
    return documented and not member.startswith(("_", "model_")) and bool(value.__doc__)


def _entry(name: str, value: Any) -> tuple[str, str]:
    """A name, called as it is, and the first sentence about it."""
    import inspect

    first = " ".join((inspect.getdoc(value) or "").partition("\n\n")[0].split())
    called = inspect.isfunction(value)
    return f"`{name}{'()' if called else ''}`", first


# The log and the indicators


def log_columns() -> str:
    """The columns of the log."""
    return table(("column", "meaning"), ((f"`{name}`", meaning) for name, meaning in COLUMNS.items()))


def log_kinds() -> str:
    """The kinds of rows."""
    rows = ((f"`{kind}`", event, value, f"`{level}`") for kind, (level, event, value) in KINDS.items())
    return table(("kind", "what happened", "`value`", "from `log:`"), rows)


_UNITS = {
    "tasks": "count",
    "tasks per hour": "1/h",
    "weighted": "-",
    "capacity per hour": "1/h",
    "encounters per hour": "1/h",
    "ratio": "-",
    "share of tasks": "share",
    "share of orders": "share",
    "share of fleet time": "share",
    "share of charger time": "share",
    "share of capacity": "share",
    "share of people's time": "share",
}
"""How the reference writes kinds of units, where not as they are called."""


def indicators() -> str:
    """The indicators with unit and meaning."""
    rows = ((f"`{one.name}`", _UNITS.get(one.unit, one.unit), one.meaning) for one in INDICATORS.values())
    of_flows = ", ".join(f"`{one.name}`" for one in INDICATORS.values() if one.by_flow is not None)
    notes = f"\nEach flow (`tasks.flows`) has some of them of its own, as in `on_time:outbound`: {of_flows}.\n"
    of_parts = spoken([f"`{one.name}`" for one in INDICATORS.values() if one.by_time])
    notes += (
        f"\nWhere orders come by the clock (`arrivals.profile`), {of_parts} are known by the part of the day, as in "
        "`on_time@11:30-13:00` or `robots_busy@11:30-13:00`: of the tasks that come in it, and utilisation of what "
        "happens in it. Parts are the stretches in which no rate changes, those of more than two hours by the hour.\n"
    )
    return table(("indicator", "unit", "what it is"), rows) + notes


def study_keys() -> str:
    """The keys of a study file."""
    from desim_warehouse.study.file import StudyFile

    defaults = {
        "name": "the file's name",
        "model": "must be given",
        "factors": "none: the model as it is",
        "design": "`grid`",
        "replications": "`1`",
        "seed": "`0`",
        "indicators": "all",
        "baseline": "the first design",
        "confidence": "`0.95`",
    }
    return table(
        ("key", "expected", "default"),
        ((f"`{key}`", field.description, defaults.get(key, "none")) for key, field in StudyFile.model_fields.items()),
    )


# What desim check says


def codes() -> str:
    """The codes of findings, errors first."""
    from typing import get_args

    from desim_warehouse.findings import CODES, Acceptable

    rows = (
        (f"`{code}`", level, "yes" if code in get_args(Acceptable) else "", meaning)
        for code, (level, meaning) in CODES.items()
    )
    return table(("code", "severity", "can be accepted", "meaning"), rows)


def verdicts() -> str:
    """When there is which verdict."""
    from desim_warehouse.outcome.verdicts import RULES

    rows = (
        (f"`{code}`", f"`{rule.mark}`", rule.text.format("…", "…"), rule.when[:1].upper() + rule.when[1:])
        for code, rule in RULES.items()
    )
    return table(("code", "mark", "verdict", "when"), rows)


# Layouts of other programs


def layouts() -> str:
    """What is read of each format, as its reader says."""
    from desim_warehouse.plants import grid, model
    from desim_warehouse.plants.formats import FORMATS

    def said(module: Any) -> str:
        return str(module.__doc__).strip() + "\n"

    lines = ["## Every drawing\n", said(model), "## Grids\n", said(grid)]
    homes = dict[str, str]()
    for form in FORMATS:
        reader = form.read.__module__
        home = homes.setdefault(reader, form.name)
        lines += [f"## {form.name}\n", said(sys.modules[reader]) if home == form.name else f"Read as {home} is.\n"]
    return "\n".join(lines)


# The paper's experiment


def paper() -> str:
    """T, S and C of the paper's cells, means over its five goods groups: figure, program, here."""
    from desim_warehouse.report.paper import reproduce

    cells = reproduce(ROOT / "studies" / "paper.yaml").table
    cells["T_seconds_program"] = cells["T_steps_program"] * (cells["T_seconds"] / cells["T"])
    means = cells.groupby("robots").mean(numeric_only=True)
    names = [f"{name}{end}" for name in ("T_seconds", "S", "C") for end in ("_figure", "_program", "")]
    heads = ("robots", "T (s) figure", "program", "here", "S figure", "program", "here", "C figure", "program", "here")
    rows = ((robots, *(f"{means.loc[robots, name]:.1f}" for name in names)) for robots in means.index)
    return table(heads, rows, "r" * len(heads))


MAKERS: dict[str, Callable[[], str]] = {
    "model-keys": model_keys,
    "distributions": distributions,
    "limits": limits,
    "units": units,
    "policies": policies,
    "cli": commands,
    "python": public,
    "codes": codes,
    "verdicts": verdicts,
    "log-columns": log_columns,
    "log-kinds": log_kinds,
    "indicators": indicators,
    "study-keys": study_keys,
    "layouts": layouts,
    "paper": paper,
}


def pages() -> list[Path]:
    """All pages of the documentation."""
    return [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]


def made(text: str) -> str:
    """A page with its made parts made anew."""

    def fill(match: re.Match[str]) -> str:
        if match[2] not in MAKERS:
            raise SystemExit(f"no made part is called {match[2]!r}; there are {', '.join(MAKERS)}")
        return f"{match[1]}\n{MAKERS[match[2]]()}\n{match[3]}"

    return _MADE.sub(fill, text)


def main(arguments: list[str]) -> int:
    """Make all pages, or check them."""
    stale = 0
    for page in pages():
        before = page.read_text(encoding="utf-8")
        after = made(before)
        if after == before:
            continue
        stale += 1
        name = page.relative_to(ROOT)
        if "--check" in arguments:
            sys.stderr.write(f"{name}: not up to date; python -m docs.make_reference makes it\n")
        else:
            page.write_text(after, encoding="utf-8")
            sys.stdout.write(f"{name}\n")
    return int(bool(stale) and "--check" in arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
