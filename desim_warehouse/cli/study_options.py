"""The options of subcommands about studies, and the study that they describe."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click

from desim_warehouse.cli.answers import typed
from desim_warehouse.cli.completion import keys_then
from desim_warehouse.cli.options import TimeIn, with_overrides, with_study_confidence, with_study_seed
from desim_warehouse.errors import ReportError, reason
from desim_warehouse.folders import make_folder
from desim_warehouse.study.limits import FIRST, FIRST_OF_MEANS, MOST_REPLICATIONS

if TYPE_CHECKING:
    from desim_warehouse.model.messages import Keys
    from desim_warehouse.study.plan import StudyPlan
    from desim_warehouse.study.results import Results
    from desim_warehouse.study.study import Study

F = TypeVar("F", bound=Callable[..., Any])

with_vary = click.option(
    "--vary",
    shell_complete=keys_then("="),
    multiple=True,
    metavar="KEY=VALUES",
    help="What to vary: fleet.size=1..12, battery.threshold=2,3.5,5, or policies.charging=threshold,{name: ...}; "
    "may be repeated: all combinations.",
)
with_page = click.option(
    "--page", metavar="FILE", help="Write a page in which sliders choose the design and two designs are compared."
)


@dataclass(frozen=True)
class ExecutionOptions:
    """How runs are executed, and where they are stored."""

    workers: str
    cluster: str | None
    timeout: float | None
    out: str | None
    no_cache: bool
    quiet: bool

    def where(self) -> dict[str, Any]:
        """The arguments of `Study.run` and of the procedures."""
        where = {"workers": self.workers, "cluster": self.cluster, "out": self.out, "progress": not self.quiet}
        return {**where, "cache": not self.no_cache}

    @property
    def kept(self) -> str | None:
        """Where finished runs are kept, in words; None: nowhere."""
        return self.out or (None if self.no_cache else "the cache")

    def at_home(self, study: str) -> ExecutionOptions:
        """The same; a study that is a folder is resumed there."""
        return replace(self, out=self.out or study) if Path(study).is_dir() else self


@dataclass(frozen=True)
class ModelOptions:
    """The options of every question about a model."""

    assignments: tuple[str, ...]
    confidence: float | None
    seed: int | None

    def search(self, execution: ExecutionOptions) -> dict[str, Any]:
        """The arguments of `plan_fleet` and `why` that the options give."""
        stated = {"confidence": self.confidence or 0.95, "seed": self.seed or 0, "timeout": execution.timeout}
        return {**stated, **execution.where()}

    def study(
        self,
        model: str,
        factors: Mapping[str, Any],
        name: str,
        execution: ExecutionOptions,
        varied: str = "--vary",
        **content: Any,
    ) -> Study:
        """The study of MODEL that the options describe.

        Args:
            model: the file.
            factors: what is varied.
            name: for tables and messages.
            execution: for the time that a run may take.
            varied: the option that gives the factors, for messages.
            content: further keys of a study file.

        Raises:
            ModelError: with every problem, each at its option.
        """
        from desim_warehouse.study.reading import plan_of
        from desim_warehouse.study.study import Study

        changes = read_assignments(self.assignments)
        options: dict[Keys, str] = {
            **_OPTIONS,
            **{("set", key): f"--set {key}" for key in changes},
            **{("factors", key): f"{varied} {key}" for key in factors},
        }
        content |= {"set": changes, "factors": factors, "name": name}
        content |= {"confidence": self.confidence, "seed": self.seed, "timeout": execution.timeout}
        return Study.of(plan_of(model, content, options))


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
"""Key of a study: the option that gives it."""


def _gathered(kind: type, name: str, options: list[Callable[[F], F]]) -> Callable[[F], F]:
    """A decorator that adds options, and passes their values as one argument."""

    def add(function: F) -> F:
        @wraps(function)
        def call(**given: Any) -> Any:
            made = kind(**{field.name: given.pop(field.name) for field in fields(kind)})
            return function(**given, **{name: made})

        decorated = cast("F", call)
        for option in reversed(options):
            decorated = option(decorated)
        return decorated

    return add


with_question = _gathered(
    ModelOptions,
    "question",
    [
        with_overrides,
        with_study_confidence,
        with_study_seed,
    ],
)


def with_execution_in(folder: str) -> Callable[[F], F]:
    """Add the options that say how runs are carried out; `folder` is the option for where they are kept."""
    options: list[Callable[[F], F]] = [
        click.option(
            "--workers",
            default="auto",
            show_default=True,
            metavar="N|auto",
            help="Processes on this machine, at most 256; auto: one for each processor, where it is worth it.",
        ),
        click.option("--cluster", metavar="ADDRESS", help="A Dask scheduler such as tcp://10.0.0.1:8786, or local."),
        click.option(
            "--timeout",
            type=TimeIn("s"),
            metavar="TIME",
            help="Time that a run may take: seconds, or with a unit such as 5min.",
        ),
        click.option(folder, "out", metavar="DIR", help="Study folder; runs that are already there are reused."),
        click.option(
            "--no-cache",
            is_flag=True,
            help=f"Without {folder}, neither keep runs in the cache (DESIM_CACHE names its folder) nor reuse them.",
        ),
        click.option("--quiet", is_flag=True, help="Do not show progress."),
    ]
    return _gathered(ExecutionOptions, "execution", options)


with_execution = with_execution_in("--out")


def with_first_and_cap(first: int | None, cap: int) -> Callable[[F], F]:
    """Add `--first` and `--cap`: how many replications of a design a search begins with, and the most.

    `first` None: by the target, see `desim_warehouse.study.target.first_look`.
    """
    said = "" if first is not None else f"  [default: {FIRST} for shares, else {FIRST_OF_MEANS}]"

    def add(function: F) -> F:
        few = click.option(
            "--first",
            type=click.IntRange(2, MOST_REPLICATIONS),
            default=first,
            show_default=first is not None,
            is_eager=True,  # --cap looks at it
            help=f"Replications of a design before anything is decided about it.{said}",
        )
        many = click.option(
            "--cap",
            type=click.IntRange(2, MOST_REPLICATIONS),
            default=cap,
            show_default=True,
            callback=_not_below_first,
            help="Most replications of a design.",
        )
        return few(many(function))

    return add


def _not_below_first(context: click.Context, option: click.Parameter, cap: int) -> int:
    if cap < (context.params.get("first") or cap):
        raise click.BadParameter(f"{cap} is less than --first {context.params['first']}.", context, option)
    return cap


def read_assignments(assignments: tuple[str, ...], option: str = "--set") -> dict[str, Any]:
    """The keys and values that an option such as `--set` gives."""
    from desim_warehouse.model import parse_assignment

    return dict(parse_assignment(text, option) for text in assignments)


def study_plan(path: str, assignments: tuple[str, ...], **changes: Any) -> StudyPlan:
    """The plan of a study file or folder; changes that are None are ignored."""
    from desim_warehouse.errors import StudyError
    from desim_warehouse.study.reading import read_study
    from desim_warehouse.study.record import read_record

    folder = Path(path).is_dir()
    if folder and assignments:
        raise StudyError(f"{path}: a study folder, whose model is fixed; --set is for study files")
    plan = read_record(Path(path)).plan if folder else read_study(path, read_assignments(assignments), named="--set")
    return replace(plan, **{key: value for key, value in changes.items() if value is not None})


def read_vary(vary: tuple[str, ...]) -> dict[str, Any]:
    """The factors of `--vary`."""
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
    """The values of a factor: YAML with commas between them, or one range or section."""
    from desim_warehouse.model.parse import read_yaml

    listed = read_yaml(f"[{text}]", option)
    problems += [f"{option}: {problem.text}" for problem in listed.problems]
    data = listed.data
    section = len(data) == 1 and isinstance(data[0], Mapping) and "name" not in data[0]
    return data[0] if section else data


@contextmanager
def interruptible(study: Study | None, kept: str | None) -> Iterator[None]:
    """Ctrl-C ends with a message about what is kept, and exit status 130; SIGTERM likewise, with 143.

    `study` None: there are several. `kept`: see `ExecutionOptions.kept`.
    """
    from desim_warehouse.study.execution.signals import interrupt

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
    """Refuse a page that cannot be, before anything is simulated, and make its folder; raises ReportError."""
    if page is not None:
        from desim_warehouse.live.frozen import check

        check(plan)
        try:
            make_folder(Path(page).parent)
        except OSError as error:
            raise ReportError(f"{page}: the page cannot be written ({reason(error)})") from error


def write_page(page: str | None, results: Results) -> None:
    """Write the page of `--page`, if one is asked for, and say so."""
    if page is not None:
        made = results.page(page, command=typed())
        click.echo(f"{page}: {len(made.html) / 1e3:,.0f} kB; open it in a browser")
