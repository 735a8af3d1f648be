"""Pages in a single file: `WebPage` saves or shows any page, `joined` assembles the replay and the live page.

For the replay, the live page and pages of answers.
"""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping, Sequence
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from desim_warehouse.errors import ReportError, reason
from desim_warehouse.folders import refuse_other
from desim_warehouse.look.palette import PAGE

ESCAPES = {"<": "\\u003c", ">": "\\u003e", "&": "\\u0026", "\u2028": "\\u2028", "\u2029": "\\u2029"}
"""Escapes of characters that are not safe in a script of a page."""

POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
"""Content security policy of a page in a file, which may run only its own scripts."""


class WebPage:
    """A page that needs neither a network nor other files: `save` writes it to a file, and Jupyter displays it."""

    sandbox = "allow-scripts"
    """Permissions of the page in its frame in Jupyter."""
    height = 720
    """Height of this frame in pixels."""

    def __init__(self, title: str, page: str) -> None:
        self.title = title
        self.html = page

    def save(self, path: str | Path) -> Path:
        """Write the page to a file, and return its path.

        Raises:
            ReportError: the file cannot be written, or exists and is not such a page.
        """
        path = Path(path)
        try:
            refuse_other(path, "page")
            path.write_text(self.html, encoding="utf-8")
        except OSError as error:
            raise ReportError(f"{path}: the page cannot be written ({reason(error)})") from error
        return path

    def _repr_html_(self) -> str:
        """Return the page in a frame for Jupyter."""
        return (
            f'<iframe title="{html.escape(self.title)}" srcdoc="{html.escape(self.html)}" '
            f'sandbox="{self.sandbox}" style="width:100%;height:{self.height}px;border:0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.title}, {len(self.html) / 1e6:.1f} MB)"


class StillPage(WebPage):
    """A page without scripts, in a frame that runs none."""

    sandbox = ""


def joined(
    package: str,
    parts: Mapping[str, str],
    shared: Sequence[str] = (),
    policy: str = POLICY,
    without: Sequence[str] = (),
) -> str:
    """Assemble the page of a package: its page.html as body, its page.css, and its scripts in the order of their names.

    Args:
        package: a package with page.html, page.css and js/.
        parts: HTML or text, already escaped, for each `{{name}}` in page.html, and for the `{{title}}`.
        shared: scripts of other pages that come first, such as `replay/js/07-floor.js`.
        policy: content security policy; empty if it is sent with the page.
        without: names of scripts that are left out.
    """
    common, home = files("desim_warehouse.look"), files(package)
    scripts = [common.joinpath("web.js"), *(files("desim_warehouse").joinpath(name) for name in shared)]
    own = (item for item in home.joinpath("js").iterdir() if item.name not in without)
    scripts += sorted(own, key=lambda item: item.name)
    whole = {
        "title": parts["title"],
        "policy": f'<meta http-equiv="Content-Security-Policy" content="{policy}">' if policy else "",
        "style": colours() + _read(common.joinpath("web.css")) + _read(home.joinpath("page.css")),
        "body": _filled(_read(home.joinpath("page.html")), parts),
        "script": "\n".join(_bare(_read(item)) for item in scripts if item.name.endswith(".js")),
    }
    return _filled(_read(common.joinpath("web.html")), whole)


def _filled(template: str, parts: Mapping[str, str]) -> str:
    """Replace each `{{name}}` of a template by the part of that name; parts are not searched for names."""
    result: list[str] = []
    for piece in template.split("{{"):
        name, mark, rest = piece.partition("}}")
        result.append(parts[name] + rest if mark else piece)
    return "".join(result)


def _bare(script: str) -> str:
    """Remove indentation and comment lines, a sixth of a script; no string may span two lines."""
    return re.sub(r"^ *(//.*\n)?", "", script, flags=re.MULTILINE)


def _read(item: Traversable) -> str:
    return item.read_text(encoding="utf-8")


def safe_json(value: Any) -> str:
    """Return JSON that is safe in a script element, whatever names it contains."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for character, escape in ESCAPES.items():
        text = text.replace(character, escape)
    return text


def colours(themes: bool = True) -> str:
    """Return the style with the colours of a page, on a light or dark ground; prints are on a light ground.

    `themes`: for a page that sets `data-theme`; without it only the system decides.
    """
    light, dark = (
        " ".join(f"--{name}: {colour};" for name, colour in PAGE[ground].items()) + f" color-scheme: {ground};"
        for ground in ("light", "dark")
    )
    if not themes:
        return f":root {{ {light} }}\n@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
    return (
        f":root {{ {light} }}\n"
        f'@media screen and (prefers-color-scheme: dark) {{ :root:not([data-theme="light"]) {{ {dark} }} }}\n'
        f'@media screen {{ :root[data-theme="dark"] {{ {dark} }} }}\n'
    )
