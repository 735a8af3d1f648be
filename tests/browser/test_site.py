"""The site, as `make docs` builds it: whole, found by its search, read by everybody, and without a network."""

import os
import re
import subprocess
import sys
from importlib.resources import files
from importlib.util import find_spec
from pkgutil import resolve_name

import pytest

import desim_warehouse as dw
from tests.browser.pages import Opened
from tests.browser.test_axe import AXE, EVERY
from tests.docs.pages import ROOT

READ = (
    "gallery",
    "index",
    "reference/indicators",
    "pages",
    "plan-a-warehouse",
    "examples",
    "how-to/robots",
    "how-to/own-layout",
    "reference/check",
    "source/CONTRIBUTING",
)
"""Pages of every kind, with pictures, code, tables, frames and signatures."""
STILL = "document.head.append(Object.assign(document.createElement('style'), {textContent: arguments[0]}))"
HITS = "return [...document.querySelectorAll('.md-search-result__item > a:first-of-type')].map((hit) => hit.href)"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    if find_spec("material") is None or find_spec("mkdocstrings") is None:
        pytest.skip("no site: pip install --editable '.[dev]'")
    place = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(place)]
    built = subprocess.run(
        command, cwd=ROOT, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}, capture_output=True, text=True, check=False
    )
    assert (built.returncode, built.stderr) == (0, "")
    return place


@pytest.mark.long
def test_it_is_built_strictly_and_shows_what_its_examples_write(site):
    page = (site / "examples.html").read_text("utf-8")
    frames = re.findall(r'<iframe class="live" src="([^"]+)"', page)
    assert frames == ["live/replay.html", "live/what-if.html", "live/report.html"]
    assert all("<!doctype html>" in (site / frame).read_text("utf-8")[:100].lower() for frame in frames)


def test_its_navigation_has_every_page_once_and_its_reference_names_that_are_there():
    """What a strict build refuses, without the build, which takes 10 s."""
    nav = (ROOT / "mkdocs.yml").read_text("utf-8").partition("\nnav:")[2].partition("\n\n")[0]
    named = re.findall(r": (\S+\.md)$", nav, re.MULTILINE)
    written = {path.relative_to(ROOT / "docs").as_posix(): path for path in (ROOT / "docs").rglob("*.md")}
    assert len(named) == len(set(named))
    assert written.keys() - {"README.md"} <= set(named)  # the list of pages there is pages.md
    text = "\n".join(path.read_text("utf-8") for path in written.values())
    shown = re.findall(r"^::: (\S+)", text, re.MULTILINE)
    assert shown
    for name in shown:
        resolve_name(name)


def test_every_public_name_is_in_the_full_reference():
    page = (ROOT / "docs/reference/api.md").read_text("utf-8")
    names = re.findall(r"(?m)^::: desim_warehouse\.(?:report\.)?(\w+)$", page)
    assert sorted(names) == sorted(set(dw.__all__) - {"__version__"})


@pytest.mark.long
@pytest.mark.parametrize(
    ("words", "page"),
    [
        ("night shift", "how-to/shifts"),
        ("on_time", "reference/indicators"),
        ("breakdown", "how-to/robots"),
        ("LIF", "how-to/from-lif-to-a-fleet-size"),
    ],
)
def test_its_search_finds_it_among_the_first_three(browser, site, words, page):
    opened = Opened(browser, site / "index.html")
    browser.find_element("css selector", ".md-search__input").send_keys(words)
    hits = []
    for _ in range(40):
        opened.pause(0.25)
        if hits := browser.execute_script(HITS):
            break
    assert [hit for hit in hits[:3] if f"/{page}.html" in hit], hits
    assert opened.complaints() == []
    assert opened.requests() == []


@pytest.mark.long
@pytest.mark.parametrize("name", READ)
def test_axe_finds_nothing(browser, site, name):
    """Frames hold pages of their own, which test_axe.py sees to."""
    violations = []
    for scheme in ("light", "dark"):
        page = Opened(browser, site / f"{name}.html")
        browser.execute_cdp_cmd(
            "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        )
        browser.execute_script(files("axe_core_python").joinpath("axe.min.js").read_text("utf-8"))
        browser.execute_script(STILL, "* { transition: none !important }")
        for width, height in ((1400, 900), (390, 844)):
            page.enlarge(width, height)
            violations += [
                (scheme, width, one["id"], [node["html"][:120] for node in one["nodes"][:3]])
                for one in browser.execute_async_script(AXE, {**EVERY, "iframes": False})
            ]
            assert browser.execute_script("return document.documentElement.scrollWidth") <= width
        assert page.requests() == []
    assert violations == []
