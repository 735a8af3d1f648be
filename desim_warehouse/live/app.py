"""HTTP calls of a live page, for its own user only.

Every call except the page itself needs the token. Host, and Origin if present, must be ours on every call, so that no
other page, and no other name of this address, can make calls. Other origins are allowed nothing, and bodies are small.

`TimedRequests` closes connections whose requests are not complete in time.
"""

from __future__ import annotations

import asyncio
import math
import secrets
from collections.abc import AsyncIterator, Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

import h11
from pydantic import ValidationError
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.responses import HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route
from uvicorn.protocols.http.h11_impl import H11Protocol

from desim_warehouse.answer.words import scale
from desim_warehouse.errors import CheckError, ModelError, StudyError, WarehouseError
from desim_warehouse.live.desk import MOST_RUNS, Design, Desk, Listener, asked
from desim_warehouse.live.messages import About, Ask, Message, ShareAsk, openapi
from desim_warehouse.look.web import joined
from desim_warehouse.model.json_text import JsonError, value_of

if TYPE_CHECKING:
    from asyncio import TimerHandle, Transport

    from starlette.requests import Request
    from starlette.types import ASGIApp, Receive, Scope, Send

M = TypeVar("M", bound=Message)
MOST_BODY = 64 * 1024
ALIVE = 5.0
"""Seconds between events if nothing changes."""
_OFTEN = 0.1
"""Least time between two answers, in seconds."""
SHARED = (
    *(f"replay/js/{name}.js" for name in ("01-unpack", "02-tracks", "03-story", "04-counts", "05-colours", "06-view")),
    *(
        f"replay/js/{name}.js"
        for name in ("07-floor", "08-ground", "09-lifts", "09-pods", "09-scene", "10-people", "10-robots", "11-heat")
    ),
    *(f"replay/js/{name}.js" for name in ("12-side", "15-player", "18-legend")),
)
"""Scripts of the replay that the live page uses."""

WITHIN = 10.0
"""Time limit for a complete request, also for the first after a connection opens, in seconds."""
HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


def application(desk: Desk, about: About, token: str, hosts: frozenset[str], frames: tuple[str, ...] = ()) -> ASGIApp:
    """Return the ASGI application of a desk, which serves any caller with the token."""
    calls = Calls(desk, about, frames)
    routes = [
        Route("/", calls.page, methods=["GET"]),
        Route("/api/model", calls.model, methods=["GET"]),
        Route("/api/openapi.json", calls.openapi, methods=["GET"]),
        Route("/api/design", calls.design, methods=["POST"]),
        Route("/api/design/{id}/events", calls.events, methods=["GET"]),
        Route("/api/design/{id}/floor", calls.floor, methods=["GET"]),
        Route("/api/share", calls.share, methods=["POST"]),
    ]
    handlers: Any = {HTTPException: _http, WarehouseError: _wrong}
    app = Starlette(routes=routes, exception_handlers=handlers)
    app.router.redirect_slashes = False
    return Guard(app, token, hosts)


def page(name: str) -> str:
    """Return the page as HTML, without a content security policy, which is sent as a header."""
    import html

    return joined("desim_warehouse.live", {"title": html.escape(name), "frozen": ""}, SHARED, policy="")


class Guard:
    """Middleware that refuses callers other than the user of the page, before anything is read or done."""

    def __init__(self, app: ASGIApp, token: str, hosts: frozenset[str]) -> None:
        self.app, self.token, self.hosts = app, token, hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a call on, or refuse it."""
        if scope["type"] != "http":
            if scope["type"] == "lifespan":
                await self.app(scope, receive, send)
            return
        headers: dict[str, list[str]] = {}
        for name, value in scope["headers"]:
            headers.setdefault(name.decode("latin-1"), []).append(value.decode("latin-1"))
        refusal = self._refusal(scope["path"], headers)
        if refusal is None:
            await self.app(scope, receive, send)
        else:
            await refused(*refusal)(scope, receive, send)

    def _refusal(self, path: str, headers: Mapping[str, list[str]]) -> tuple[int, str] | None:
        host, origin = headers.get("host", []), headers.get("origin", [])
        if len(host) != 1 or host[0] not in self.hosts:
            return 421, "Host: not the address of this server"
        if any(value.removeprefix("http://") not in self.hosts or not value.startswith("http://") for value in origin):
            return 403, "Origin: only the page of this server may ask"
        if path == "/":
            return None
        tokens = headers.get("authorization", [])
        if len(tokens) != 1 or not secrets.compare_digest(tokens[0].encode(), f"Bearer {self.token}".encode()):
            return 401, "Authorization: not the token of this server, which `desim serve` prints with its address"
        return None


def refused(status: int, *problems: str) -> JSONResponse:
    """Return a response that lists why a call was refused."""
    return JSONResponse({"problems": list(problems)}, status, HEADERS)


class Calls:
    """The calls that a page can make to a desk."""

    def __init__(self, desk: Desk, about: About, frames: tuple[str, ...]) -> None:
        self.desk, self.about, self.frames = desk, about, frames
        self.html = page(about.name)
        aim = desk.target
        self.by_target = 1.0 if aim is None else scale(aim.indicator, desk.model, (aim.value,)).by

    async def page(self, request: Request) -> Response:  # noqa: ARG002
        """Respond with the page, without data; its script is allowed by a nonce that is new for each response."""
        nonce, frames = secrets.token_urlsafe(16), " ".join(self.frames) or "'none'"
        policy = (
            "default-src 'none'; connect-src 'self'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; "
            f"form-action 'none'; script-src 'nonce-{nonce}'; frame-ancestors {frames}"
        )
        body = self.html.replace("<script>", f'<script nonce="{nonce}">', 1)
        return HTMLResponse(body, headers={**HEADERS, "Content-Security-Policy": policy})

    async def model(self, request: Request) -> Response:  # noqa: ARG002
        """Respond with the model, and the keys on offer."""
        return _json(self.about)

    async def openapi(self, request: Request) -> Response:  # noqa: ARG002
        """Respond with the calls as OpenAPI."""
        return JSONResponse(openapi(), headers=HEADERS)

    async def design(self, request: Request) -> Response:
        """Respond with the quick estimate of a design."""
        ask = await _read(request, Ask)
        design = await run_in_threadpool(self.desk.design, ask.levels)
        return _json(asked(design))

    async def events(self, request: Request) -> Response:
        """Respond with a stream of events, which hold the results of a design whenever they change."""
        design, query = self._known(request.path_params["id"]), request.query_params
        unknown = set(query) - {"runs", "pinned", "target", "floor"}
        if unknown or len(query.multi_items()) != len(query):
            raise StudyError("query: expected runs, pinned, target and floor, each once")
        pinned = self._known(query["pinned"]) if "pinned" in query else None
        runs = _number(query.get("runs", "0"), "runs", whole=True)
        if not 0 <= runs <= MOST_RUNS:
            raise StudyError(f"runs: {runs:g}, expected 0 to {MOST_RUNS}")
        if query.get("floor", "0") not in {"0", "1"}:
            raise StudyError(f"floor: {query['floor']!r:.80}, expected 0 or 1")
        target = self.desk.target
        if "target" in query:
            if target is None or self.about.target is None:
                raise StudyError("target: there is none, start `desim serve` with --target")
            shown = _number(query["target"], "target")
            target = replace(target, value=shown / self.by_target)
        changed, loop = asyncio.Event(), asyncio.get_running_loop()

        def notify() -> None:
            if not loop.is_closed():
                loop.call_soon_threadsafe(changed.set)

        listener = Listener(design, pinned, target, int(runs), notify, floor=query.get("floor") == "1")
        self.desk.listen(listener)  # before the response begins, as the desk may refuse
        stream = self._stream(listener, changed)
        leave = partial(self.desk.leave, listener)
        return _Stream(stream, leave, media_type="text/event-stream", headers=HEADERS)

    async def _stream(self, listener: Listener, changed: asyncio.Event) -> AsyncIterator[str]:
        number = 0
        while not self.desk.closing:
            changed.clear()
            answer = await run_in_threadpool(self.desk.answer, listener)
            number += 1
            yield f"id: {number}\nevent: answer\ndata: {answer.model_dump_json()}\n\n"
            await asyncio.sleep(_OFTEN)
            while not changed.is_set() and not self.desk.closing:
                try:
                    await asyncio.wait_for(changed.wait(), ALIVE)
                except TimeoutError:
                    yield "event: alive\ndata: {}\n\n"

    async def floor(self, request: Request) -> Response:
        """Respond with the replay of one run of a design, which the page plays."""
        design = self._known(request.path_params["id"])
        if not design.floor:
            raise HTTPException(404, "floor: none yet, expected after the event that says so")
        return JSONResponse(dict(design.floor), headers=HEADERS)

    async def share(self, request: Request) -> Response:
        """Respond with the page of some designs, which needs no server."""
        ask = await _read(request, ShareAsk)
        designs = [self._known(name) for name in dict.fromkeys(ask.ids)]
        made = await run_in_threadpool(self.desk.page, [design for design in designs if design.n], self.about)
        safe = {"Content-Disposition": "attachment", "Content-Security-Policy": "sandbox"}
        return HTMLResponse(made.html, headers={**HEADERS, **safe})

    def _known(self, name: str) -> Design:
        design = self.desk.designs.get(name)
        if design is None:
            raise HTTPException(404, f"{name!r:.40}: no such design, expected an id that POST /api/design gave")
        return design


class _Stream(StreamingResponse):
    """A streaming response that always makes its listener leave at the end, even if it ends before the first line."""

    def __init__(self, content: AsyncIterator[str], leave: Callable[[], None], **how: Any) -> None:
        super().__init__(content, **how)
        self._leave = leave

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._leave()


async def _read(request: Request, kind: type[M]) -> M:
    """Read the body of a call as a message.

    Raises:
        HTTPException: a body that is too long, of another content type, or no such message.
    """
    if request.headers.get("content-type", "").partition(";")[0].strip().lower() != "application/json":
        raise HTTPException(415, "Content-Type: expected application/json")
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > MOST_BODY:
            raise HTTPException(413, f"body: longer than {MOST_BODY:,} bytes")
    try:
        return kind.model_validate(value_of(body))
    except ValidationError as error:
        problems = [
            f"{'.'.join(map(str, problem['loc'])) or 'body'}: {problem['msg']}" for problem in error.errors()[:5]
        ]
        raise HTTPException(400, "\n".join(problems)) from None
    except JsonError as error:
        raise HTTPException(400, f"body{error.where}: {error}") from None


def _number(text: str, name: str, *, whole: bool = False) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number) or (whole and number != int(number)):
        raise StudyError(f"{name}: {text!r:.40}, expected a {'whole ' if whole else ''}number")
    return number


def _json(message: Message) -> Response:
    return Response(message.model_dump_json(), media_type="application/json", headers=HEADERS)


async def _http(_: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    return refused(error.status_code, *str(error.detail).split("\n"))


async def _wrong(_: Request, error: Exception) -> Response:
    problems = error.problems if isinstance(error, ModelError | CheckError) else [str(error)]
    return refused(422, *problems)


class TimedRequests(H11Protocol):
    """HTTP/1.1 protocol that closes connections whose requests are not complete in time; uvicorn would wait forever."""

    _late: TimerHandle | None = None

    def connection_made(self, transport: Transport) -> None:  # type: ignore[override]
        """Start the time limit of the first request."""
        super().connection_made(transport)
        self._watch()

    def data_received(self, data: bytes) -> None:
        """Continue the time limit while a request is incomplete, or stop it."""
        super().data_received(data)
        self._watch()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop the time limit."""
        self._stop()
        super().connection_lost(exc)

    def _watch(self) -> None:
        if self.conn.their_state not in {h11.IDLE, h11.SEND_BODY}:
            self._stop()
        elif self._late is None:
            self._late = self.loop.call_later(WITHIN, self.transport.close)

    def _stop(self) -> None:
        if self._late is not None:
            self._late.cancel()
            self._late = None
