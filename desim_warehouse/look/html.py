"""Parts of a report as HTML, by the macros of templates/parts.html, which escape all names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import TYPE_CHECKING
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

if TYPE_CHECKING:
    from jinja2 import Template


class Html(Markup):
    """A piece of HTML that Jupyter shows; pieces can be added."""

    def _repr_html_(self) -> str:
        """What Jupyter shows."""
        return str(self)


@cache
def template(name: str) -> Template:
    """A template of the package; what is put in is escaped unless it is a piece of HTML."""
    loader = PackageLoader("desim_warehouse.look")
    made = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return made.get_template(name)


def _part(macro: str, *values: object) -> Html:
    return Html(getattr(template("parts.html").module, macro)(*values))


def figure(macro: str, *values: object) -> Html:
    """A figure of templates/figures.html."""
    return Html(getattr(template("figures.html").module, macro)(*values))


def paragraph(text: str, kind: str = "", end: Html | None = None) -> Html:
    """A paragraph: a lead, a question or a note by its `kind`, with an `end` such as a link."""
    return _part("paragraph", text, kind, end or "")


def link(text: str, address: str) -> Html:
    """A link to a file beside the page."""
    return _part("link", text, quote(address))


def heading(text: str) -> Html:
    """The title of a report."""
    return _part("heading", text)


def tiles(found: Iterable[tuple[str, str, str]]) -> Html:
    """Large numbers: each with what it is, and a note such as its interval."""
    return _part("tiles", list(found))


def bullets(lines: Iterable[str], kind: str = "") -> Html:
    """A list of sentences."""
    return _part("bullets", list(lines), kind)


def code(text: str) -> Html:
    """A command or file as it is typed."""
    return _part("code", text)


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    words: int = 1,
    name: str = "",
    marked: frozenset[int] = frozenset(),
) -> Html:
    """A table.

    Args:
        head: the names of the columns.
        rows: the cells, as text.
        words: how many columns from the left are words; all others are numbers.
        name: the table's id, for programs.
        marked: rows to set apart, such as the baseline.
    """
    return _part("table", head, list(rows), words, name, marked)


def facts(pairs: Iterable[tuple[str, str]], name: str = "") -> Html:
    """Names and values, one pair per line."""
    return _part("facts", list(pairs), name)


def picture(data: str, width: int, words: str) -> Html:
    """A picture in PNG format, its data in base64; `words` say what it shows."""
    return _part("picture", data, width, words)
