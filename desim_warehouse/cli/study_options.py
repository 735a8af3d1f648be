"""Options of subcommands for studies, and the study that they describe."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields as dataclass_fields
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click
from click.core import ParameterSource

from desim_warehouse.cli.answers import typed
from desim_warehouse.cli.completion import keys_then
from desim_warehouse.cli.options import F, TimeIn, with_confidence, with_seed
from desim_warehouse.errors import ReportError, reason
from desim_warehouse.folders import filled_folder, refuse_other
from desim_warehouse.study.statistics.limits import COMMON_DAYS, FIRST, FIRST_OF_MEANS, MOST_REPLICATIONS, RARE_DAYS

if TYPE_CHECKING:
    from desim_warehouse.model.messages import Keys
    from desim_warehouse.questions.study import Results, Study
    from desim_warehouse.study.plan import StudyPlan
    from desim_warehouse.study.search import Search


with_vary = click.option(
    "--vary",
    shell_complete=keys_then("="),
    multiple=True,
    metavar="KEY=VALUES",
    help="A key and the values to try, such as fleet.size=1..12, battery.threshold=2,3.5,5 or "
    "policies.charging=threshold,{name: ...}; if repeated, all combinations are tried.",
)
with_page = click.option(
    "--page", metavar="FILE", help="Write a page with sliders that select a design, and with two designs side by side."
)
_STATED = ("confidence", "seed", "timeout")
"""Fields of a search that a study file may also set."""
_OPTIONS: dict[Keys, str] = {
    ("replications",): "--replications",
    ("replications", "indicator"): "--until",
    ("replications", "half_width"): "--half-width",
    ("replications", "confidence"): "--confidence",
    ("replications", "cap"): "--cap",
    ("design",): "--design",
    ("indicators",): "--indicator",
    ("warm_up",): "--warm-up",
    ("target",): "--target",
}
"""The options that set keys of a study."""
_SEARCH: dict[str, Callable[[F], F]] = {
    "confidence": with_confidence,
    "seed": with_seed,
    "workers": click.option(
        "--workers",
        default="auto",
        show_default=True,
        metavar="N|auto",
        help="Number of parallel processes, at most 256; auto: one for each processor if that saves time.",
    ),
    "cluster": click.option(
        "--cluster",
        metavar="ADDRESS",
        help="Run on a Dask cluster: the address of its scheduler, such as tcp://10.0.0.1:8786, or local.",
    ),
    "timeout": click.option(
        "--timeout",
        type=TimeIn("s"),
        metavar="TIME",
        help="Time limit for each run, in seconds or with a unit, such as 5min.",
    ),
}
"""The options that set fields of `Search`."""
BY_TARGET = f"{FIRST} for shares, else {FIRST_OF_MEANS}"
"""Default number of replications at the first look at a design: see `desim_warehouse.study.target.first_look`."""
BY_DAYS = f"{COMMON_DAYS.cap}, {RARE_DAYS.cap} with rare failures"
"""Default largest number of replications of a design: see `desim_warehouse.study.rare.days_needed`."""


def study_of(
    model: str,
    assignments: tuple[str, ...],
    factors: Mapping[str, Any],
    search: Search,
    *,
    varied: str = "--vary",
    **content: Any,
) -> Study:
    """Return the study of MODEL that options describe.

    Args:
        model: the model file.
        assignments: values of `--set`.
        factors: values by varied key.
        search: the search, for confidence, seed and time limit.
        varied: the option that sets the factors, for messages.
        content: further keys of a study file.

    Raises:
        ModelError: all problems, each with its option.
    """
    from desim_warehouse.questions.study import Study
    from desim_warehouse.study.reading import plan_of

    changes = read_assignments(assignments)
    options: dict[Keys, str] = {
        **_OPTIONS,
        **{("set", key): f"--set {key}" for key in changes},
        **{("factors", key): f"{varied} {key}" for key in factors},
    }
    stated = {name: getattr(search, name) for name in _STATED}
    return Study.of(plan_of(model, {**content, "set": changes, "factors": factors, **stated}, options))


def with_search(
    *fields: str, first: int | str | None = None, cap: int | str | None = None, out: str = "--out"
) -> Callable[[F], F]:
    """Add the options on how runs are done; the command receives all of them as one `search`.

    Other options that have the name of a field of `Search`, such as `--runs`, also become part of it.

    Args:
        fields: the options to add among `confidence` and `seed`.
        first: default of `--first`, in words if it depends on the target; None for no such option.
        cap: default of `--cap`, in words if it depends on the model; None for no such option.
        out: name of the option for the folder of runs.
    """
    looks = [] if first is None or cap is None else _looks(first, cap)
    options = [
        *looks,
        *(_SEARCH[name] for name in (*fields, "workers", "cluster", "timeout")),
        click.option(
            out, "out", metavar="DIR", help="Folder to store the study in; runs already stored there are reused."
        ),
        click.option(
            "--no-cache",
            is_flag=True,
            help=f"Without {out}, neither store runs in the cache (in the folder DESIM_CACHE) nor reuse them.",
        ),
        click.option("--quiet", is_flag=True, help="Do not show progress."),
    ]

    def add(function: F) -> F:
        @wraps(function)
        def call(*, no_cache: bool, quiet: bool, **arguments: Any) -> Any:
            from desim_warehouse.study.search import Search

            settings = {
                field.name: arguments.pop(field.name) for field in dataclass_fields(Search) if field.name in arguments
            }
            return function(
                **arguments, search=Search(**settings, cache=not no_cache, progress=not quiet, command=typed())
            )

        decorated = cast("F", call)
        for option in reversed(options):
            decorated = option(decorated)
        return decorated

    return add


def _looks(first: int | str, cap: int | str) -> list[Callable[[F], F]]:
    """Return the options `--first` and `--cap`: the first and the largest number of replications of a design."""
    count = click.IntRange(2, MOST_REPLICATIONS)

    def looked(option: str, default: int | str, text: str) -> Callable[[F], F]:
        if isinstance(default, int):
            return click.option(option, type=count, default=default, show_default=True, help=text)
        return click.option(option, type=count, help=f"{text}  [default: {default}]")

    return [
        looked("--first", first, "Replications of a design before the first decision about it."),
        looked("--cap", cap, "Maximum number of replications of a design."),
    ]


def at_home(search: Search, study: str) -> Search:
    """Return the search with a folder: a study in a folder is resumed there."""
    return replace(search, out=search.out or study) if Path(study).is_dir() else search


def stated(search: Search) -> dict[str, Any]:
    """Return the fields of a search that were typed as options and that a study file may also set."""
    source = click.get_current_context().get_parameter_source
    return {name: getattr(search, name) for name in _STATED if source(name) not in {None, ParameterSource.DEFAULT}}


def read_assignments(assignments: tuple[str, ...], option: str = "--set") -> dict[str, Any]:
    """Return the keys and values of an option such as `--set`."""
    from desim_warehouse.model import parse_assignment

    return dict(parse_assignment(text, option) for text in assignments)


def study_plan(path: str, assignments: tuple[str, ...], **changes: Any) -> StudyPlan:
    """Return the plan of a study file or folder; changes that are None are ignored."""
    from desim_warehouse.errors import StudyError
    from desim_warehouse.study.reading import read_study
    from desim_warehouse.study.record import read_record

    folder = Path(path).is_dir()
    if folder and assignments:
        raise StudyError(f"{path}: a study folder, whose model is fixed; --set is for study files")
    plan = read_record(Path(path)).plan if folder else read_study(path, read_assignments(assignments), named="--set")
    return replace(plan, **{key: value for key, value in changes.items() if value is not None})


def read_vary(vary: tuple[str, ...]) -> dict[str, Any]:
    """Return the factors of `--vary`."""
    from desim_warehouse.errors import ModelError

    factors: dict[str, Any] = {}
    problems = []
    for text in vary:
        key, equals, values = (part.strip() for part in text.partition("="))
        if not equals or not values or not key:
            problems.append(f"--vary {text}: nothing to vary, expected KEY=VALUES such as fleet.size=1..12")
        elif key in factors:
            problems.append(f"--vary {text}: {key} given twice, expected all its values once")
        else:
            factors[key] = read_values(values, f"--vary {key}", problems)
    if problems:
        raise ModelError(problems)
    return factors


def read_values(text: str, option: str, problems: list[str]) -> Any:
    """Return the values of a factor from YAML: a list with commas, a range or a section; add to `problems`."""
    from desim_warehouse.model.parse import read_yaml

    listed = read_yaml(f"[{text}]", option)
    problems += [f"{option}: {problem.text}" for problem in listed.problems]
    data = listed.data
    section = len(data) == 1 and isinstance(data[0], Mapping) and "name" not in data[0]
    return data[0] if section else data


@contextmanager
def interruptible(study: Study | None, search: Search) -> Iterator[None]:
    """End on Ctrl-C with exit status 130, on SIGTERM with 143, and print where finished runs are kept.

    `study`: the study, for the number of its runs; None for several studies.
    """
    from desim_warehouse.study.execution.signals import interrupt

    kept = search.out or ("the cache" if search.cache else None)
    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    except KeyboardInterrupt as stop:
        number = "" if study is None else f"{len(study.rows)} "
        resumes = f"{number}finished runs are kept in {kept}; the same command resumes"
        click.echo(f"stopped: {resumes if kept else 'nothing is kept without --out DIR'}", err=True)
        sys.exit(128 + (stop.args[0] if stop.args else signal.SIGINT))
    finally:
        signal.signal(signal.SIGTERM, before)


def refuse_page(page: str | None, plan: StudyPlan) -> None:
    """Refuse a page that cannot be made before any simulation, and make its folder.

    The folder goes again if the command ends without the page. Raises ReportError.
    """
    if page is not None:
        from desim_warehouse.live.frozen import check

        check(plan)
        try:
            click.get_current_context().with_resource(filled_folder(Path(page).parent))
            refuse_other(Path(page), "page")
        except OSError as error:
            raise ReportError(f"{page}: the page cannot be written ({reason(error)})") from error


def write_page(page: str | None, results: Results) -> None:
    """Write the page of `--page`, if requested, and print its path."""
    if page is not None:
        from desim_warehouse.live.frozen import what_if_page

        made = what_if_page(results, page, command=typed())
        click.echo(f"{page}: {len(made.html) / 1e3:,.0f} kB; open it in a browser")
