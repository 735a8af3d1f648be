"""The live page of a model, and its server, for a single user on this machine.

`offers` lists the keys that may be changed. `desk` simulates the designs that have listeners, and `answers` puts their
results into words, before and after the first runs. `app` serves the HTTP calls and refuses other users; `messages`
has their types.
"""

from __future__ import annotations

import atexit
import html
import secrets
import socket
import threading
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Self

from desim_warehouse.answer import words
from desim_warehouse.errors import StudyError, reason, shown
from desim_warehouse.feasibility.mistakes.unused import has_due
from desim_warehouse.folders import make_folder
from desim_warehouse.live.answers import CONFIDENCE
from desim_warehouse.live.desk import RUNS, Desk
from desim_warehouse.live.messages import About, Aim, Knob
from desim_warehouse.live.offers import Offer, offers
from desim_warehouse.model import Model, Source, as_model
from desim_warehouse.outcome.targets import Target
from desim_warehouse.questions import judged
from desim_warehouse.replay.page import colours
from desim_warehouse.study.execution.cache import cache_folder, refuse_foreign
from desim_warehouse.study.execution.progress import in_notebook
from desim_warehouse.study.rare import days_needed
from desim_warehouse.study.statistics.judge import looks_by
from desim_warehouse.study.target import read_target
from desim_warehouse.values.arguments import is_whole

HOME = "127.0.0.1"
_LAST_PORT = 65535
_NOTEBOOKS = ("http://localhost:*", "http://127.0.0.1:*")
_END = 2.0  # seconds that open calls may take at the end


class Live:
    """A live page served at `address` until `close` is called or Python ends; Jupyter displays it.

    Only this machine can reach the page, so a notebook whose kernel runs elsewhere cannot show it.
    """

    def __init__(self, desk: Desk, about: About, port: int, embed: tuple[str, ...]) -> None:
        """Serve a desk on a port (0: any free port); raise StudyError for a taken port or without the extra `serve`."""
        try:
            import uvicorn

            from desim_warehouse.live.app import TimedRequests, application
        except ImportError as error:
            raise StudyError(f"a live page needs {error.name}; pip install 'desim-warehouse[serve]'") from None
        self.desk = desk
        self.token = secrets.token_urlsafe(32)
        self._socket = _bound(port)
        self.port = int(self._socket.getsockname()[1])
        hosts = frozenset({f"{HOME}:{self.port}", f"localhost:{self.port}"})
        app = application(desk, about, self.token, hosts, embed)
        config = uvicorn.Config(
            app,
            http=TimedRequests,
            ws="none",
            lifespan="off",
            log_level="critical",
            access_log=False,
            server_header=False,
            timeout_graceful_shutdown=1,
        )
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._server.run, kwargs={"sockets": [self._socket]}, daemon=True)
        self._thread.start()
        atexit.register(self.close)
        desk.begin()

    @property
    def address(self) -> str:
        """The address of the page, with the token after the #, which browsers do not send."""
        return f"http://{HOME}:{self.port}/#{self.token}"

    @property
    def folder(self) -> Path:
        """The study folder with all runs."""
        return self.desk.folder

    def close(self) -> None:
        """Stop the server and all workers; finished runs are kept."""
        atexit.unregister(self.close)
        if self._server.should_exit:
            return
        self._server.should_exit = True
        self.desk.close()
        self._thread.join(_END)
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_html_(self) -> str:
        """Return the page in a frame, for notebooks."""
        address = html.escape(self.address)
        return f'<iframe title="Live page" src="{address}" style="width:100%;height:900px;border:0"></iframe>'


def serve(
    model: Source,
    *,
    vary: Mapping[str, Any] | Iterable[str] = (),
    target: str | None = None,
    workers: int | str = "auto",
    out: str | Path | None = None,
    port: int = 0,
    embed: Iterable[str] | None = None,
    changes: Mapping[str, Any] | None = None,
) -> Live:
    """Serve a page on which sliders change the model, and answers become more precise with each run.

        live = dw.serve("w.yaml", target="on_time >= 95 %")
        print(live.address)

    Args:
        model: a model, its file, or its content.
        vary: keys that the page offers, with their values as in a study file, or None for the usual values; by default
            robots, chargers, demand, and allocation.
        target: target of designs; by default `on_time >= 95 %` if tasks have due times, else none.
        workers: number of processes that simulate, or `auto` for one per processor.
        out: study folder for all runs; by default a private folder in the user's cache.
        port: port on 127.0.0.1; 0 for a free port.
        embed: origins whose pages may show the page in a frame; by default none, or in Jupyter those of this machine.
        changes: overrides of the model.

    Returns:
        The live page, with its address and `close`.

    Raises:
        ModelError: all problems of the model, or of the values to vary.
        StudyError: an unusable target, key, folder or port, or the extra `serve` is missing.
    """
    base = as_model(model, changes)
    goal = _target(base, target)
    offered = offers(base, vary)
    main = goal.indicator if goal is not None else _main(base)
    frames = tuple(embed) if embed is not None else _NOTEBOOKS if in_notebook() else ()
    folder = Path(out) if out is not None else _home(base)
    desk = Desk(base, offered, main, goal, workers=workers, folder=folder)
    try:
        return Live(desk, _about(base, offered, main, goal, folder), port, frames)
    except BaseException:
        desk.close()
        raise


def _bound(port: int) -> socket.socket:
    if not is_whole(port, 0, _LAST_PORT):
        raise StudyError(f"port {shown(port):.60}: expected a whole number from 0 to {_LAST_PORT}; 0 takes a free one")
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((HOME, port))
    except OSError as error:
        listening.close()
        raise StudyError(f"port {port}: cannot be used ({reason(error)}); --port 0 takes a free one") from None
    return listening


def _home(model: Model) -> Path:
    """Make and return the private folder of a model in the user's cache.

    Raises:
        StudyError: the folder cannot be used.
    """
    try:
        root = cache_folder()
        for folder in (root, root / "live", root / "live" / model.digest()[:16]):
            make_folder(folder, mode=0o700)
            refuse_foreign(folder)
    except (OSError, RuntimeError) as error:
        raise StudyError(f"the cache cannot be used ({reason(error)}); --out DIR names another folder") from error
    return folder


def _target(model: Model, text: str | None) -> Target | None:
    if text is not None:
        return read_target(text, model.units.names)
    return read_target("on_time >= 95 %", model.units.names) if has_due(model) else None


def _main(model: Model) -> str:
    """Return the main indicator of designs without a target."""
    return "throughput_per_hour" if model.tasks.never_end else "T"


def _about(model: Model, offered: Mapping[str, Offer], main: str, goal: Target | None, folder: Path) -> About:
    scale = words.scale(main, model, () if goal is None else (goal.value,))
    return About(
        name=model.name,
        hash=model.digest(),
        knobs=[
            Knob(
                key=offer.key,
                label=offer.label,
                kind="number" if offer.is_number else "choice",
                values=list(offer.values),
                texts=list(offer.texts),
                today=offer.today,
            )
            for offer in offered.values()
        ],
        target=None if goal is None else _aim(goal, scale.by, "%" if scale.is_share else scale.unit),
        indicator=main,
        label=words.indicator_name(main),
        unit="%" if scale.is_share else scale.unit,
        runs=RUNS,
        promise=_promise(model),
        colours=colours(),
        folder=str(folder),
    )


def _aim(goal: Target, by: float, unit: str) -> Aim:
    value = round(by * goal.value, 9)
    share = unit == "%"
    least, most = (50.0, 100.0) if share else (0.0, 2 * value or 1.0)
    return Aim(
        indicator=goal.indicator,
        label=words.indicator_name(goal.indicator),
        relation=goal.sense,
        value=value,
        least=min(least, value),
        most=max(most, value),
        step=0.5 if share else (most - least) / 200,
        unit=unit,
    )


def _promise(model: Model) -> str:
    """Return the statement on verdicts of the live page: after which runs they come, and at which risk of error."""
    least = days_needed(model).least
    when = ", ".join(str(n) for n, _ in looks_by(30))
    error = f"{100 - 100 * CONFIDENCE:g} %"
    return (
        f"Verdicts are given only after {when} runs, then after half as many again, and never change. The {error} risk "
        "of error is shared among these checks, so waiting longer does not raise it. No option meets the target before "
        f"{least} runs: that covers days as rare as {judged.rarest(least)}. Run r has the same random numbers "
        "in every option, and differences to the pinned option are paired run by run."
    )
