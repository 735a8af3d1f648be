"""Reports: the folder of an answer, a study or a run as one self-contained HTML page, and as a notebook."""

from __future__ import annotations

import json
from pathlib import Path

from desim_warehouse.errors import ReportError, reason
from desim_warehouse.folders import ANSWER, RUN, STUDY, make_folder, shipped, write_whole
from desim_warehouse.questions.run import page as run_page
from desim_warehouse.report.answer_page import PLAN, WHY
from desim_warehouse.run import RunData

KINDS = {"answer": (ANSWER, PLAN, WHY, STUDY), "run": (RUN,)}
"""Kind of report: the files by which its kind of folder is known."""


def report(
    source: str | Path | RunData,
    out: str | Path | None = None,
    *,
    notebook: str | Path | None = None,
    replay: bool = False,
) -> Path:
    """Write the report of a run, or of the folder of an answer, a study or a run. No code of the folder is run.

    Args:
        source: a run, or what `desim plan`, `why`, `size`, `study`, `what-if`, `best` or `run` wrote with `--out`.
        out: the page; default: report.html in the folder, of a run in the working folder.
        notebook: write the notebook for people who know pandas, with this folder and not yet run, here, too.
        replay: write a replay of one run beside the page, NAME-replay.html, and link to it on the first page.

    Returns:
        The page.

    Raises:
        ReportError: no such folder, it is damaged, or nothing can be written.
    """
    if isinstance(source, RunData):
        folder, kind = Path(), "run"
    else:
        folder = Path(source)
        kind = kind_of(folder)
    path = folder / "report.html" if out is None else Path(out)
    beside = path.with_name(f"{path.stem}-replay.html")
    _make(path.parent)
    try:
        content = source if isinstance(source, RunData) else folder
        page = _page(kind, content, str(beside) if replay else None)
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
        raise ReportError(f"{folder}: damaged, as it seems: no report can be made ({reason(error)})") from error
    _write(path, page)
    if notebook is not None:
        _write(Path(notebook), _filled_in(folder.resolve()))
    return path


def _page(kind: str, content: Path | RunData, replay: str | None) -> str:
    if kind == "answer" and isinstance(content, Path):
        from desim_warehouse.report import answer_page

        answer = answer_page.read(content)
        return answer_page.page(answer, answer_page.run_of(answer), replay)
    return run_page.page(content, replay).html()


def kind_of(folder: Path) -> str:
    """Whether a folder holds an answer, also as a study, or a run."""
    for kind, files in KINDS.items():
        if any((folder / file).is_file() for file in files):
            return kind
    raise ReportError(
        f"{folder}: neither an answer, nor a study, nor a run there; desim plan, study or run --out DIR makes one"
    )


def template() -> Path:
    """The notebook for any folder of runs: in the installed package, or in reports/ of the source tree."""
    return shipped("notebooks") / "report.ipynb"


def _filled_in(folder: Path) -> str:
    """The notebook with the folder in the cell that sets the parameters."""
    notebook = json.loads(template().read_text(encoding="utf-8"))
    lines = notebook["cells"][0]["source"]
    lines[0] = f"folder = {str(folder)!r}\n"
    return json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"


def _make(folder: Path) -> None:
    try:
        make_folder(folder)
    except OSError as error:
        raise ReportError(f"{folder}: cannot be made ({reason(error)})") from error


def _write(path: Path, text: str) -> None:
    _make(path.parent)
    try:
        write_whole(path, text)
    except OSError as error:
        raise ReportError(f"{path}: cannot be written ({reason(error)})") from error
