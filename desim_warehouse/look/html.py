"""Pages without scripts: their templates, which escape all names, and their style and figures.

For the page of an answer or report, and for the course of a run in its replay.
"""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Collection
from functools import cache
from importlib.resources import files
from io import BytesIO
from typing import TYPE_CHECKING

from jinja2 import Environment, PackageLoader, StrictUndefined

from desim_warehouse.look.palette import COURSE, HEAT
from desim_warehouse.look.web import colours

if TYPE_CHECKING:
    from jinja2 import Template
    from markupsafe import Markup
    from matplotlib.axes import Axes


FIGURES = ("grid", "floor", "points")
"""CSS classes of figures with rules that other pages can omit."""
_COLOURS = 64
"""Number of colours of a picture."""


@cache
def template(name: str) -> Template:
    """Load a template of the package; inserted text is escaped unless it is Markup."""
    loader = PackageLoader("desim_warehouse.look")
    made = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return made.get_template(name)


def figure(macro: str, *values: object) -> Markup:
    """Render a figure by a macro of templates/figures.html."""
    drawn: Markup = getattr(template("figures.html").module, macro)(*values)
    return drawn


def picture(axes: Axes) -> Markup:
    """Embed a figure of matplotlib into the page as a picture, with its alternative text."""
    data, facts = axes._repr_png_()  # type: ignore[attr-defined] # as Jupyter does
    return figure("picture", b64encode(_in_few_colours(data)).decode("ascii"), facts["width"], facts["alt"])


def _in_few_colours(png: bytes) -> bytes:
    """Return a picture in a quarter of the bytes, as figures have few colours besides smoothed edges."""
    from PIL import Image  # a dependency of matplotlib

    with Image.open(BytesIO(png)) as picture:
        smaller = BytesIO()
        picture.convert("RGB").convert("P", palette=Image.Palette.ADAPTIVE, colors=_COLOURS).save(smaller, "PNG")
    return smaller.getvalue()


def style(figures: Collection[str] = FIGURES) -> str:
    """Return the style of a page with some kinds of `figures`, and with the colours of waiting of replays."""
    light, dark = (" ".join(f"--w{n}: {colour};" for n, colour in enumerate(HEAT[ground], 1)) for ground in HEAT)
    heat = f":root {{ {light} }}\n@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
    return (
        _short(colours(themes=False) + heat)
        + _without(set(FIGURES) - set(figures), _css("report.css"))
        + course_style()
    )


def _without(figures: Collection[str], css: str) -> str:
    """Remove the rules of a style that apply only to some kinds of figures."""
    if not figures:
        return css
    listed = "|".join(figures)
    return re.sub(rf"(?<=[{{}}])\.({listed})\b[^{{}},@]*\{{[^{{}}]*\}}", "", css)


def course_style(themes: bool = False) -> str:
    """Return the style of the course of a run, with its colours; `themes`: for a page that sets `data-theme`."""
    light, dark = (
        {f".c-{name}": f"{{ --c: {colour}; }}" for name, colour in COURSE[ground].items()} for ground in COURSE
    )
    rules = " ".join(f"{name} {rule}" for name, rule in light.items())
    wish = ':root:not([data-theme="light"]) ' if themes else ""
    by_system = " ".join(f"{wish}{name} {rule}" for name, rule in dark.items())
    by_hand = " ".join(f':root[data-theme="dark"] {name} {rule}' for name, rule in dark.items())
    shades = f"@media screen and (prefers-color-scheme: dark) {{ {by_system} }}\n"
    if themes:
        shades += f"@media screen {{ {by_hand} }}\n"
    return _short(f"{rules}\n{shades}") + _css("course.css")


def _css(name: str) -> str:
    """Read a style, and remove comments and spaces."""
    return _short(files("desim_warehouse.look").joinpath("templates", name).read_text("utf-8"))


def _short(css: str) -> str:
    """Shorten rules of a style: remove comments, spaces, the last semicolon, and a zero before the point."""
    css = re.sub(r"\s+", " ", re.sub(r"/\*.*?\*/", "", css, flags=re.DOTALL))
    css = re.sub(r" ?([{};,>]) ?", r"\1", css).replace(": ", ":").replace(";}", "}")
    return re.sub(r"(?<![\w.])0\.(?=\d)", ".", css).strip()
