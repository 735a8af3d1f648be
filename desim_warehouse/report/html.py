"""Parts of a report as HTML; all names are escaped."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING
from urllib.parse import quote

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


class Html:
    """A piece of HTML that Jupyter shows; pieces can be added."""

    def __init__(self, source: str) -> None:
        self.source = source

    def __add__(self, other: Html) -> Html:
        return Html(f"{self.source}\n{other.source}")

    def _repr_html_(self) -> str:
        """What Jupyter shows."""
        return self.source


def paragraph(text: str, kind: str = "", end: Html | None = None) -> Html:
    """A paragraph; `kind` is lead, question or note; `end` such as a link."""
    return Html(f"<p{_class(kind)}>{escape(text)}{end.source if end else ''}</p>")


def link(text: str, address: str) -> Html:
    """A link to a file beside the page."""
    return Html(f'<a href="{escape(quote(address))}">{escape(text)}</a>')


def heading(text: str) -> Html:
    """The title of a report."""
    return Html(f"<h1>{escape(text)}</h1>")


def bullets(lines: Iterable[str], kind: str = "") -> Html:
    """A list of sentences."""
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return Html(f"<ul{_class(kind)}>{items}</ul>")


def code(text: str) -> Html:
    """A command or file as it is typed."""
    return Html(f"<pre>{escape(text)}</pre>")


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

    def cells(tag: str, row: Sequence[str]) -> str:
        return "".join(
            f"<{tag}{_class('' if place < words else 'number')}>{escape(cell)}</{tag}>"
            for place, cell in enumerate(row)
        )

    body = "".join(
        f"<tr{_class('baseline' if number in marked else '')}>{cells('td', row)}</tr>"
        for number, row in enumerate(rows)
    )
    found = f' id="{escape(name)}"' if name else ""
    return Html(
        f'<div class="wide"><table{found}><thead><tr>{cells("th", head)}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def facts(pairs: Iterable[tuple[str, str]], name: str = "") -> Html:
    """Names and values, one pair per line."""
    rows = "".join(f"<tr><th>{escape(key)}</th><td>{escape(value)}</td></tr>" for key, value in pairs)
    found = f' id="{escape(name)}"' if name else ""
    return Html(f'<div class="wide"><table{found}><tbody>{rows}</tbody></table></div>')


def _class(kind: str) -> str:
    return f' class="{kind}"' if kind else ""
