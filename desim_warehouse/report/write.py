"""Write reports: the folder of an answer, a study or a run as a self-contained HTML page, and as a notebook."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from desim_warehouse.answer.answer import Answer, load
from desim_warehouse.answer.page import page
from desim_warehouse.errors import ReportError, StudyError, WarehouseError, reason
from desim_warehouse.folders import (
    ANSWER,
    PAGE,
    RESULTS,
    RUN,
    STUDY,
    Made,
    filled_folder,
    refuse_other,
    shipped,
    write_whole,
)
from desim_warehouse.model import load as load_model
from desim_warehouse.questions.run import page as run_page
from desim_warehouse.questions.study import Results
from desim_warehouse.report.kept import PLAN, WHY, read_kept
from desim_warehouse.run import RunData

KINDS = {"answer": (ANSWER, PLAN, WHY, STUDY), "run": (RUN,)}
"""Files that identify a kind of folder, by kind of report."""


def report(
    source: str | Path | RunData,
    out: str | Path | None = None,
    *,
    notebook: str | Path | None = None,
    replay: bool = False,
) -> Path:
    """Write the report of a run, or of a folder with an answer, a study or a run. No code in the folder is executed.

    Args:
        source: a run, or a folder that `desim plan`, `why`, `size`, `study`, `what-if`, `best` or `run` wrote with
            `--out`.
        out: path of the page; by default report.html in the folder or, for a run, in the working folder.
        notebook: path of a notebook that is also written, with the folder's runs as a pandas table, not executed.
        replay: whether to write a replay of one run beside the page, as NAME-replay.html, and link to it.

    Returns:
        The path of the page.

    Raises:
        ReportError: no such folder, a damaged folder, or a file that cannot be written.
    """
    folder = Path() if isinstance(source, RunData) else Path(source)
    kind = "run" if isinstance(source, RunData) else kind_of(folder)
    path = folder / PAGE if out is None else Path(out)
    beside = path.with_name(f"{path.stem}-replay.html") if replay else None
    with _made(path.parent):
        try:
            text = _page_of_run(source, beside) if kind == "run" else page_of_answer(read_answer(folder), beside)
        except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
            raise ReportError(f"{folder}: damaged, as it seems: no report can be made ({reason(error)})") from error
        _write(path, text, "page")
    if notebook is not None:
        _write(Path(notebook), _filled_in(folder.resolve()), "notebook")
    return path


def _page_of_run(source: str | Path | RunData, replay: Path | None) -> str:
    run = run_page.read(source)
    return run_page.page(run, None if run is source else Path(str(source)), _replayed(run, replay))


def page_of_answer(answer: Answer, replay: Path | None = None) -> str:
    """Compose the page of an answer, with a new run of the design that it is about.

    If the answer is about no design, or its run fails, the page has no run. `replay`: file for a replay of the run, to
    which the page links.
    """
    about, run, worst = answer.about, None, None
    if about is not None:
        try:
            model = load_model(about.model)
            run = run_page.in_full(model, about.seed)
            worst = run_page.in_full(model, about.worst.seed) if run is not None and about.worst is not None else None
        except WarehouseError:  # such as with a user's own policy, which no report may run
            return page(answer)
    return page(answer) if run is None else run_page.page_with(answer, run, worst, _replayed(run, replay))


def _replayed(run: RunData, replay: Path | None) -> str:
    """Write the replay of a run, and return the name of its file; "" if `replay` is None."""
    if replay is None:
        return ""
    run.replay(replay)
    return replay.name


def read_answer(folder: str | Path) -> Answer:
    """Read the answer stored in a folder, also by version 0.3, or compose it from the finished runs of a study.

    Returns:
        The answer as it was stored, or as composed.

    Raises:
        ReportError: the folder is damaged, or no run has finished.
    """
    if Path(folder, ANSWER).is_file():
        return load(folder)
    old = [path for path in (Path(folder, PLAN), Path(folder, WHY)) if path.is_file()]
    if old:
        return read_kept(old[0])
    try:
        results = Results.load(folder)
    except StudyError as error:
        raise ReportError(str(error)) from error
    errors = [row.outcome.error for row in results.rows]
    if None not in errors:
        why = f"every run failed, the first with: {errors[0]}" if errors else "no run has finished"
        raise ReportError(f"{Path(folder) / RESULTS}: {why}, so there is nothing to report")
    return results.answer


def kind_of(folder: Path) -> str:
    """Return the kind of a folder, `answer` (also for a study) or `run`; raise ReportError for any other folder."""
    for kind, files in KINDS.items():
        if any((folder / file).is_file() for file in files):
            return kind
    raise ReportError(
        f"{folder}: neither an answer, nor a study, nor a run there; desim plan, study or run --out DIR makes one"
    )


def template() -> Path:
    """Return the path of the notebook for any folder of runs, in the installed package or in the source tree."""
    return shipped("notebooks") / "report.ipynb"


def _filled_in(folder: Path) -> str:
    """Return the notebook as JSON, with the folder in the cell of parameters."""
    notebook = json.loads(template().read_text(encoding="utf-8"))
    lines = next(cell for cell in notebook["cells"] if cell["cell_type"] == "code")["source"]
    lines[0] = f"folder = {str(folder)!r}\n"
    return json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"


@contextmanager
def _made(folder: Path) -> Iterator[None]:
    """A folder for a page, as `filled_folder`; raises ReportError where that cannot be."""
    with ExitStack() as made:
        try:
            made.enter_context(filled_folder(folder))
        except OSError as error:
            raise ReportError(f"{folder}: cannot be made ({reason(error)})") from error
        yield


def _write(path: Path, text: str, made: Made) -> None:
    with _made(path.parent):
        try:
            refuse_other(path, made)
            write_whole(path, text)
        except OSError as error:
            raise ReportError(f"{path}: cannot be written ({reason(error)})") from error
