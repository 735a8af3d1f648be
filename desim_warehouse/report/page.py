"""A report on one page: its first page, its sections, and the appendix."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.errors import WarehouseError
from desim_warehouse.look import html
from desim_warehouse.look.html import Html
from desim_warehouse.look.palette import HEAT
from desim_warehouse.look.web import colours

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from desim_warehouse.model import Model
    from desim_warehouse.run import Run

    Parts = Sequence[Html | Axes | None]


@dataclass(frozen=True)
class ReportPage:
    """The content of a report: the parts of the first page, then what is folded away below, by name.

    A part is HTML or a figure; None: there is nothing to show, and what has no parts is left out.
    """

    title: str
    first: Parts
    folded: dict[str, Parts]

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
    return Html(colours() + heat + files("desim_warehouse.look").joinpath("templates", "report.css").read_text("utf-8"))


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
    run: Run | None,
    replay: str | None,
) -> Html:
    """Title, question, the numbers that answer it, and the answer in sentences.

    Then the date, and a link to the replay of `run`, written to the path `replay`.
    """
    now = datetime.now(UTC).astimezone()
    parts = html.heading(title)
    is_short = len(description) <= _LEAD
    parts += html.paragraph(description, "lead") if description and is_short else Html("")
    parts += html.paragraph(question, "question") + html.tiles(numbers) + html.bullets(answer, "answers")
    made = f"{now.day} {now:%B %Y}"
    parts += Html("") if is_short else html.paragraph(description, "note")
    if run is None or replay is None:
        return parts + html.paragraph(made, "note")
    run.replay(replay)
    return parts + html.paragraph(f"{made}. ", "note", html.link("Watch a run", Path(replay).name))


def in_full(model: Model, seed: int) -> Run | None:
    """A run with everything logged. None where it fails, or would run code, as reports must be safe to open."""
    from desim_warehouse.run import simulate

    if model.policies.own():
        return None
    try:
        return simulate(model.replace({"log": "all"}), seed)
    except WarehouseError:
        return None


def example() -> Model:
    """A small warehouse for reports of no folder."""
    from desim_warehouse.draft import Draft, draft
    from desim_warehouse.model import load
    from desim_warehouse.model.parse import read_yaml

    words = Draft(size=(16.0, 14.0), orders=60.0, due=2.5, name="an example")
    content = read_yaml(draft(words), "the example").data
    return load({**content, "run": {"length": 3600, "warm_up": 600}})
