"""What the site has beyond docs/: the README as its first page, files that pages link to, and live examples."""

from __future__ import annotations

import logging
import os
import posixpath
import re
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from mkdocs.structure.files import File, InclusionLevel

from tests.docs import pages

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT = pages.ROOT
DOCS = ROOT / "docs"
MOVED = {ROOT / "README.md": "index.md", DOCS / "README.md": "pages.md"}
"""Files with another place on the site than in the repository."""
EXAMPLES = DOCS / "examples.md"
LIVE = re.compile(r"<!-- live: (\S+): (.+) -->")
BOOST = {"how-to/": 4.0, "reference/": 2.0, "source/": 0.001, "dev/": 0.001, "why.md": 0.001}
"""What hits are worth, by the beginning of a page's place; a word in a title is worth a thousand in the text."""
_LINK = re.compile(r"(\]\()([^)\s#]+)((?:#[^)\s]*)?\))")
_LOG = logging.getLogger("mkdocs.hooks.site")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what is not in docs/: the pages of the repository, files that are linked to, and the live examples."""
    for path, place in MOVED.items():
        if path.is_relative_to(DOCS):
            files.remove(files.src_uris[path.relative_to(DOCS).as_posix()])
        files.append(_at(place, path, config))
    outside = {target for page in pages.PAGES for target in _linked(page) if not target.is_relative_to(DOCS)}
    for path in sorted({*outside, *ROOT.glob("*.md")} - set(MOVED)):
        files.append(_at(_place(path), path, config))
    for name, made in examples().items():
        files.append(File.generated(config, f"live/{name}", content=made, inclusion=InclusionLevel.NOT_IN_NAV))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:  # noqa: ARG001
    """Point links to where files stand on the site, and show live examples in frames."""
    for place, boost in BOOST.items():
        if page.file.src_uri.startswith(place):
            page.meta["search"] = {"boost": boost}
    home = Path(str(page.file.abs_src_path))
    here = posixpath.dirname(page.file.src_uri)

    def moved(link: re.Match[str]) -> str:
        target = (home.parent / link[2]).resolve()
        if not target.is_file():
            return link[0]
        return link[1] + posixpath.relpath(_place(target), here or ".") + link[3]

    return LIVE.sub(_frame, _LINK.sub(moved, markdown))


def examples() -> dict[str, str]:
    """The pages that the commands of docs/examples.md write, by name."""
    home = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "models", Path(folder) / "models")
        os.chdir(folder)
        try:
            for block in pages.blocks(EXAMPLES):
                for command in pages.commands(block):
                    status, _, err = pages.run_desim(command.words)
                    if status:
                        _LOG.warning("%s: %s\n%s", EXAMPLES.name, command.words, err)
            return {path.name: path.read_text(encoding="utf-8") for path in Path().glob("*.html")}
        finally:
            os.chdir(home)


def _frame(match: re.Match[str]) -> str:
    name, title = match.groups()
    frame = f'<iframe class="live" src="live/{name}" title="{title}" loading="lazy"></iframe>'
    return f'{frame}\n\n<a href="live/{name}">The page on its own: {title}</a>'


def _linked(page: Path) -> set[Path]:
    targets = ((page.parent / link[2]).resolve() for link in _LINK.finditer(page.read_text(encoding="utf-8")))
    return {path for path in targets if path.is_file()}


def _place(path: Path) -> str:
    """Where a file of the repository stands on the site."""
    if path in MOVED:
        return MOVED[path]
    return path.relative_to(DOCS).as_posix() if path.is_relative_to(DOCS) else f"source/{path.relative_to(ROOT)}"


def _at(place: str, path: Path, config: MkDocsConfig) -> File:
    inside = InclusionLevel.INCLUDED if place.endswith(".md") else InclusionLevel.NOT_IN_NAV
    return File.generated(config, place, abs_src_path=str(path), inclusion=inside)
