"""Reports: a notebook run on a study or run folder, as one self-contained HTML page."""

from __future__ import annotations

import asyncio
import os
import tempfile
import warnings
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ReportError, reason
from desim_warehouse.run.folder import PLAN, RUN, STUDY

if TYPE_CHECKING:
    from collections.abc import Iterator

    from nbformat import NotebookNode

_NEEDED = ("nbclient", "nbconvert", "nbformat", "ipykernel")
KINDS = {"plan": PLAN, "study": STUDY, "run": RUN}
"""Notebook: the file by which its kind of folder is known."""
_DEEPEST = 6
"""Levels of headings."""


def report(
    folder: str | Path,
    out: str | Path | None = None,
    *,
    pdf: bool = False,
    code: bool = False,
    keep: str | Path | None = None,
    replay: bool = False,
) -> Path:
    """Write the report of the folder of a plan, a study or a run.

    Args:
        folder: what `desim plan`, `study`, `what-if`, `size`, `best` or `run` wrote with `--out`.
        out: the page; default: report.html in the folder (report.pdf with `pdf`).
        pdf: print the page with an installed Chromium or Chrome.
        code: show the notebook's code cells, too.
        keep: write the executed notebook here, to continue in Jupyter.
        replay: write a replay of one run beside the page, NAME-replay.html, and link to it on the first page.

    Returns:
        What was written.

    Raises:
        ReportError: no such folder, the extra `report` is not installed, no browser for `pdf`, a cell that fails.
    """
    missing = [name for name in _NEEDED if find_spec(name) is None]
    if missing:
        raise ReportError(f"reports need {', '.join(missing)}; install them with pip install 'desim-warehouse[report]'")
    folder = Path(folder)
    kind = kind_of(folder)
    path = folder / ("report.pdf" if pdf else "report.html") if out is None else Path(out)
    beside = path.with_name(f"{path.stem}-replay.html").resolve()
    notebook = executed(kind, folder, replay=beside if replay else None)
    if keep is not None:
        _write(Path(keep), _as_file(notebook))
    page = page_of(notebook, title_of(notebook), code=code)
    if pdf:
        from desim_warehouse.report.browser import print_pdf

        print_pdf(page, path)
    else:
        _write(path, page)
    return path


def kind_of(folder: Path) -> str:
    """Whether a folder holds a plan, a study or a run."""
    for kind, file in KINDS.items():
        if (folder / file).is_file():
            return kind
    raise ReportError(
        f"{folder}: neither a plan, nor a study, nor a run there; desim plan, what-if, study or run --out DIR makes one"
    )


def template(kind: str) -> Path:
    """The notebook of a kind of report: in the installed package, or in reports/ of the source tree."""
    name = f"{kind}.ipynb"
    for home in (Path(__file__).parent / "notebooks", Path(__file__).parents[2] / "reports"):
        if (home / name).is_file():
            return home / name
    raise ReportError(f"{name} is missing from this installation of desim-warehouse")


def executed(kind: str, folder: Path | None, *, replay: Path | None = None) -> NotebookNode:
    """A kind's notebook, run from the first cell to the last: with its parameters for a folder, or as it is."""
    with _quiet(), tempfile.TemporaryDirectory(prefix="desim-", ignore_cleanup_errors=True) as sockets:
        import nbformat
        from nbclient import NotebookClient
        from nbclient.exceptions import CellExecutionError, DeadKernelError

        here = str((folder or Path(sockets)).resolve())
        notebook = nbformat.read(template(kind), as_version=4)
        if folder is not None:
            set_parameters(notebook, {"folder": here, "replay": replay and str(replay)})
        client = NotebookClient(
            notebook,
            timeout=None,
            kernel_name="python3",
            config=_settings(sockets),
            resources={"metadata": {"path": here}},
        )
        try:
            asyncio.run(client.async_execute())
        except CellExecutionError as error:
            raise ReportError(f"{folder}: the report stopped: {error.ename}: {error.evalue}") from error
        except (DeadKernelError, RuntimeError) as error:
            raise ReportError(f"{folder}: the report's Python process did not start, or died ({error})") from error
    return notebook


def _settings(sockets: str) -> Any:
    """Where the system allows, messages of the notebook's process go through private files, not ports."""
    from traitlets.config import Config

    ours = {"transport": "ipc", "ip": f"{sockets}/kernel"} if os.name == "posix" else {}
    return Config({"KernelManager": ours})


def set_parameters(notebook: NotebookNode, values: dict[str, Any]) -> None:
    """Set the parameters as papermill does: in a cell of their own after the tagged one."""
    from nbformat.v4 import new_code_cell

    tagged = [n for n, cell in enumerate(notebook.cells) if "parameters" in cell.metadata.get("tags", [])]
    source = "\n".join(f"{name} = {value!r}" for name, value in values.items())
    cell = new_code_cell(source, id="injected-parameters", metadata={"tags": ["injected-parameters"]})
    notebook.cells.insert(tagged[0] + 1, cell)


def title_of(notebook: NotebookNode) -> str:
    """The page's title: the heading of the first cell."""
    from html.parser import HTMLParser

    class Heading(HTMLParser):
        inside, text = False, ""

        def handle_starttag(self, tag: str, attrs: object) -> None:  # noqa: ARG002
            self.inside = self.inside or tag == "h1"

        def handle_endtag(self, tag: str) -> None:
            self.inside = self.inside and tag != "h1"

        def handle_data(self, data: str) -> None:
            self.text += data if self.inside else ""

    for source in _shown(notebook):
        parser = Heading()
        parser.feed(source)
        if parser.text:
            return parser.text
    return "Report"


def _shown(notebook: NotebookNode) -> Iterator[str]:
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            if "text/html" in output.get("data", {}):
                yield "".join(output["data"]["text/html"])


def page_of(notebook: NotebookNode, title: str, *, code: bool = False) -> str:
    """An executed notebook as one page: styles and figures inside, no scripts, no external links.

    Sections in which there is nothing to show are left out, unless code is shown.
    """
    with _quiet():
        import nbformat
        from nbconvert import HTMLExporter

        if not code:
            notebook = nbformat.from_dict({**notebook, "cells": _filled(notebook.cells)})

        exporter = HTMLExporter(
            template_name="desim",
            extra_template_basedirs=[str(Path(__file__).parent / "templates")],
            exclude_input=not code,
            exclude_input_prompt=True,
            exclude_output_prompt=True,
            exclude_anchor_links=True,
        )
        page, _ = exporter.from_notebook_node(notebook, resources={"report_title": title})
    return str(page)


def _filled(cells: list[NotebookNode]) -> list[NotebookNode]:
    """The cells without headings that nothing follows."""
    kept: list[NotebookNode] = []
    lowest = 0  # the highest heading that has something below it already, from the end on; 0: a heading would be empty
    for cell in reversed(cells):
        level = _heading(cell)
        if level is None:
            lowest = _DEEPEST if cell.get("outputs") else lowest
        elif lowest >= level:
            lowest = level - 1
        else:
            continue
        kept.append(cell)
    return kept[::-1]


def _heading(cell: NotebookNode) -> int | None:
    """The level of a markdown heading; None: another cell."""
    if cell.cell_type != "markdown" or not cell.source.startswith("#"):
        return None
    return len(cell.source) - len(cell.source.lstrip("#"))


def _as_file(notebook: NotebookNode) -> str:
    import nbformat

    return str(nbformat.writes(notebook)) + "\n"


def _write(path: Path, text: str) -> None:
    from desim_warehouse.run.folder import write_whole

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
    except OSError as error:
        raise ReportError(f"{path}: cannot be written ({reason(error)})") from error


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence the notebook libraries' warnings about one another."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
