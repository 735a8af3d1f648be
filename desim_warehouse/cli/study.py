"""`desim study`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from desim_warehouse._version import __version__
from desim_warehouse.cli.answers import give
from desim_warehouse.cli.completion import AtPath
from desim_warehouse.cli.options import with_json, with_overrides
from desim_warehouse.cli.study_options import (
    at_home,
    interruptible,
    refuse_page,
    study_plan,
    with_page,
    with_search,
    write_page,
)
from desim_warehouse.cli.tables import show_failures, show_quantiles

if TYPE_CHECKING:
    from desim_warehouse.questions.study import Results
    from desim_warehouse.study.search import Search


def _share(context: click.Context, option: click.Parameter, text: str | None) -> float | None:
    """Return a share such as 0.95 or 95 % as a number."""
    if text is None:
        return None
    try:
        number = text.strip().removesuffix("%")
        share = float(number) / (100 if number != text.strip() else 1)
    except ValueError:
        share = 0.0
    if not 0 < share < 1:
        raise click.BadParameter(f"{text}: expected a share between 0 and 1, such as 95%", context, option)
    return share


@click.command("study")
@click.argument("study", type=AtPath())
@with_overrides
@click.option(
    "--quantile",
    "share",
    metavar="SHARE",
    callback=_share,
    help="Show, instead of means, the values that this share of all runs stay below, such as 95%, with intervals.",
)
@with_page
@with_json()
@with_search()
def command(
    study: str,
    assignments: tuple[str, ...],
    share: float | None,
    page: str | None,
    search: Search,
    *,
    as_json: bool,
) -> None:
    """Run the study file STUDY, such as studies/paper.yaml, or resume the study in the folder STUDY.

    Runs stored in the folder are not repeated. Runs made by another version are only shown; with --out, all are
    simulated again. DIR/results.parquet has one row per run.
    """
    from desim_warehouse.questions.study import Study

    whole = Study.of(study_plan(study, assignments, timeout=search.timeout))
    refuse_page(page, whole.plan)
    results = None if search.out else _as_saved(study)
    if results is None:
        search = at_home(search, study)
        with interruptible(whole, search):
            whole.run_by(search)
        results = whole.results
    if share is None:
        show_failures(results)
        out = search.out if results.folder is None else None
        give(results.answer, out, None, as_json=as_json)
    elif as_json:
        raise click.UsageError("--json is for means; --quantile prints a table")
    else:
        show_quantiles(results, share)
    write_page(page, results)


def _as_saved(study: str) -> Results | None:
    """Return the results of a folder whose study another version finished, which is shown as it is; None otherwise."""
    from desim_warehouse.questions.study import Results

    results = Results.load(study) if Path(study).is_dir() else None
    return results if results is not None and results.is_whole and results.version != __version__ else None
