"""A report on one page: its first page, its sections, and the appendix."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.resources import files
from typing import TYPE_CHECKING

from desim_warehouse.look import html
from desim_warehouse.look.html import Html
from desim_warehouse.look.palette import COURSE, HEAT
from desim_warehouse.look.web import colours

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    Parts = Sequence[Html | Axes | None]


@dataclass(frozen=True)
class ReportPage:
    """The content of a report: the parts of the first page, then what is folded away below, by name.

    A part is HTML or a figure; None: there is nothing to show, and what has no parts is left out.
    """

    title: str
    first: Parts
    folded: Mapping[str, Parts]

    def html(self) -> str:
        """The whole page: styles and figures inside, no scripts, no external links."""
        made = ((name, _shown(parts)) for name, parts in self.folded.items())
        folded = [(name, parts) for name, parts in made if parts]
        return html.template("report.html").render(
            title=self.title, style=style(), first=_shown(self.first), folded=folded
        )


def style() -> Html:
    """The style of a page, with the colours of waiting as on the floors of replays."""
    light, dark = (" ".join(f"--w{n}: {colour};" for n, colour in enumerate(HEAT[ground], 1)) for ground in HEAT)
    heat = f":root {{ {light} }}\n@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
    return Html(colours() + heat + _template("report.css") + course_style())


def course_style() -> str:
    """The style of the course of a run, with its colours; pages with a theme of their own set `data-theme`."""
    light, dark = (
        {f".c-{name}": f"{{ --c: {colour}; }}" for name, colour in COURSE[ground].items()}
        for ground in ("light", "dark")
    )
    rules = " ".join(f"{name} {rule}" for name, rule in light.items())
    by_system = " ".join(f':root:not([data-theme="light"]) {name} {rule}' for name, rule in dark.items())
    by_hand = " ".join(f':root[data-theme="dark"] {name} {rule}' for name, rule in dark.items())
    themes = f"@media screen and (prefers-color-scheme: dark) {{ {by_system} }}\n@media screen {{ {by_hand} }}\n"
    return f"{rules}\n{themes}" + _template("course.css")


def _template(name: str) -> str:
    return files("desim_warehouse.look").joinpath("templates", name).read_text("utf-8")


def _shown(parts: Parts) -> Html:
    shown = (part if isinstance(part, Html) else _picture(part) for part in parts if part is not None)
    return Html("\n").join(shown)


def _picture(axes: Axes) -> Html:
    data, facts = axes._repr_png_()  # type: ignore[attr-defined] # what Jupyter calls, too
    return html.picture(b64encode(data).decode("ascii"), facts["width"], facts["alt"])


_LEAD = 160
"""Letters of a description that stands before the answer; a longer one, as of imported plants, stands after it."""


def first_page(
    title: str,
    description: str,
    question: str,
    numbers: Iterable[tuple[str, str, str]],
    answer: Iterable[str],
    link: Html | None = None,
) -> Html:
    """Compose title, question, the numbers that answer it, the answer in sentences, the date, and a link."""
    now = datetime.now(UTC).astimezone()
    parts = html.heading(title)
    is_short = len(description) <= _LEAD
    parts += html.paragraph(description, "lead") if description and is_short else Html("")
    parts += html.paragraph(question, "question") + html.tiles(numbers) + html.bullets(answer, "answers")
    made = f"{now.day} {now:%B %Y}"
    parts += Html("") if is_short else html.paragraph(description, "note")
    return parts + (html.paragraph(made, "note") if link is None else html.paragraph(f"{made}. ", "note", link))
