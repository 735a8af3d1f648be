"""Nobody but the user of a live page gets an answer, and whatever is asked, nothing breaks and nothing is run."""

import json
import random
import socket

import httpx
import pytest

import desim_warehouse as dw
from desim_warehouse.live import _bound
from desim_warehouse.live.messages import openapi
from tests.live.client import TUTORIAL, client

HOSTILE = "</script><img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    with client(tmp_path_factory.mktemp("live"), dw.load(TUTORIAL, {"name": HOSTILE}), workers=1) as made:
        yield made


@pytest.fixture(autouse=True)
def nothing_is_run(page):
    designs, runs = set(page.live.desk.designs), len(page.live.desk.listeners)
    yield
    assert set(page.live.desk.designs) == designs
    assert len(page.live.desk.listeners) == runs


@pytest.mark.parametrize(
    ("status", "call"),
    [
        (401, {"headers": {"Authorization": ""}}),
        (401, {"headers": {"Authorization": "Bearer wrong"}}),
        (401, {"headers": {"Authorization": b"Bearer \xff"}}),
        (421, {"headers": {"Host": "evil.example"}}),
        (421, {"headers": {"Host": "127.0.0.1"}}),
        (403, {"headers": {"Origin": "http://evil.example"}}),
        (403, {"headers": {"Origin": "null"}}),
        (405, {"method": "PUT"}),
        (405, {"method": "POST", "json": {}}),
        (404, {"url": "/api/models"}),
        (404, {"url": "/api/../api/model/"}),
        (404, {"url": "/api/design/none/floor"}),
        (404, {"url": "/api/design/none/events"}),
        (404, {"url": "/favicon.ico"}),
        (415, {"url": "/api/design", "method": "POST", "content": b"{}"}),
        (413, {"url": "/api/design", "method": "POST", "json": {"levels": {"fleet.size": "x" * 70_000}}}),
        (400, {"url": "/api/design", "method": "POST", "json": []}),
        (400, {"url": "/api/design", "method": "POST", "json": {"levels": {"fleet.size": None}}}),
        (400, {"url": "/api/design", "method": "POST", "json": {"levels": {"fleet.size": {"file": "/etc/passwd"}}}}),
        (400, {"url": "/api/design", "method": "POST", "json": {"levels": {}, "more": 1}}),
        (422, {"url": "/api/design", "method": "POST", "json": {"levels": {"layout.file": "/etc/passwd"}}}),
        (422, {"url": "/api/design", "method": "POST", "json": {"levels": {"policies.allocation": "os:system"}}}),
        (422, {"url": "/api/design", "method": "POST", "json": {"levels": {"fleet.size": "3"}}}),
        (422, {"url": "/api/design", "method": "POST", "json": {"levels": {"fleet.size": 10**400}}}),
        (400, {"url": "/api/design", "method": "POST", "json": {"levels": {"fleet.size": True}}}),
        (400, {"url": "/api/share", "method": "POST", "json": {"ids": ["a"]}}),
        (404, {"url": "/api/share", "method": "POST", "json": {"ids": ["a", "b"]}}),
    ],
)
def test_what_is_not_the_pages_own_is_refused_and_says_why(page, status, call):
    answer = page.http.request(**{"method": "GET", "url": "/api/model", **call})
    assert answer.status_code == status, answer.text
    assert answer.headers.get("access-control-allow-origin") is None
    assert answer.json()["problems"]


def test_a_query_that_is_not_understood_is_refused(page):
    design = next(iter(page.live.desk.designs), None) or page.design()["id"]
    for query in (
        {"runs": "x"},
        {"runs": -1},
        {"runs": 10**9},
        {"runs": 1.5},
        {"target": 5},
        {"floor": 2},
        {"more": 1},
    ):
        answer = page.http.get(f"/api/design/{design}/events", params=query)
        assert answer.status_code == 422, query


def test_the_page_itself_has_no_data_and_lets_only_its_own_script_run(page):
    answer = httpx.get(f"http://127.0.0.1:{page.live.port}/")
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "unsafe-inline" not in policy.partition("script-src")[2]
    word = policy.partition("'nonce-")[2].partition("'")[0]
    assert answer.text.count(f'<script nonce="{word}">') == 1 == answer.text.count("<script")
    assert word not in httpx.get(f"http://127.0.0.1:{page.live.port}/").text  # another one each time
    assert page.live.token not in answer.text
    assert HOSTILE not in answer.text


def test_nothing_listens_beyond_this_machine(page):
    assert page.live._socket.getsockname()[0] == "127.0.0.1"
    others = {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)} - {"127.0.0.1"}
    for address in others:
        with socket.socket() as other, pytest.raises(OSError, match=r"."):
            other.connect((address, page.live.port))


def test_frames_are_for_those_that_are_named(tmp_path):
    with client(tmp_path, workers=1, embed=["https://lab.example"]) as other:
        policy = httpx.get(f"http://127.0.0.1:{other.live.port}/").headers["content-security-policy"]
    assert policy.endswith("frame-ancestors https://lab.example")


def test_a_notebook_shows_the_page_in_a_frame(page):
    shown = page.live._repr_html_()
    assert f'src="http://127.0.0.1:{page.live.port}/#{page.live.token}"' in shown


def fuzz(page, times, seed=0):
    """Requests of which nearly all are wrong in some way: none is a fault of ours."""
    rng = random.Random(seed)
    designs = ["/api/design/x/events", "/api/design/x/floor"]
    paths = ["/", "/api/model", "/api/design", "/api/share", *designs, "//", "/%2e%2e"]
    words = ["levels", "fleet.size", "policies.allocation", "ids", "", "\u2028", HOSTILE, "a" * 5000, "__proto__"]

    def value(depth=0):
        kind = rng.randrange(8 if depth < 4 else 6)
        if kind < 6:
            return [None, rng.random() * 1e308, rng.choice(words), -1, True, 2**70][kind]
        if kind == 6:
            return [value(depth + 1) for _ in range(rng.randrange(4))]
        return {rng.choice(words): value(depth + 1) for _ in range(rng.randrange(4))}

    for _ in range(times):
        body = rng.choice([rng.randbytes(rng.randrange(60)), json.dumps(value()).encode(), b"[" * 5000])
        headers = {"content-type": rng.choice(["application/json", "text/plain", "application/json; charset=x"])}
        if rng.random() < 0.3:
            headers["authorization"] = rng.choice(["", "Bearer", f"Bearer {page.live.token}x", "Basic eA=="])
        call = page.http.build_request(rng.choice(["GET", "POST", "PUT", "DELETE"]), "/", content=body, headers=headers)
        path = rng.choice(paths) + rng.choice(["", "?runs=9", "?a=%00"])
        call.url = call.url.copy_with(raw_path=path.encode("latin-1", "replace"))
        try:
            answer = page.http.send(call)
        except httpx.RemoteProtocolError:
            continue  # no HTTP: the connection is closed
        assert answer.status_code < 500, (call, body)
        assert "Traceback" not in answer.text


def test_150_wrong_requests_are_refused_without_a_fault(page, capfd):
    fuzz(page, 150)
    assert page.http.get("/api/model").status_code == 200
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.long
def test_10000_wrong_requests_are_refused_without_a_fault(page, capfd):
    fuzz(page, 10_000, seed=1)
    assert page.http.get("/api/model").status_code == 200
    assert "Traceback" not in capfd.readouterr().err


def test_the_calls_are_described_by_the_types(page):
    told = page.http.get("/api/openapi.json").json()
    assert told == json.loads(json.dumps(openapi()))
    assert set(told["paths"]) == {
        "/api/model",
        "/api/design",
        "/api/design/{id}/events",
        "/api/design/{id}/floor",
        "/api/share",
        "/api/openapi.json",
    }
    references = json.dumps(told).split('"$ref": "#/components/schemas/')[1:]
    assert {reference.partition('"')[0] for reference in references} <= set(told["components"]["schemas"])


def test_what_cannot_be_served_says_why(tmp_path):
    with pytest.raises(dw.StudyError, match=r"--vary tasks\.load_time: no values, expected tasks\.load_time=VALUES"):
        dw.serve(TUTORIAL, vary=["tasks.load_time"], out=tmp_path)
    with pytest.raises(dw.StudyError, match=r"did you mean 'fleet\.size'"):
        dw.serve(TUTORIAL, vary=["fleet.sise"], out=tmp_path)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(dw.StudyError, match=r"port \d+: cannot be used"):
            dw.serve(TUTORIAL, out=tmp_path, port=taken.getsockname()[1])
    for port in (-1, 65536, 1.5, "x", True):
        with pytest.raises(dw.StudyError, match=f"port {port!r}: expected a whole number from 0 to 65535"):
            _bound(port)
    with pytest.raises(dw.StudyError, match="on_tim"):
        dw.serve(TUTORIAL, target="on_tim >= 95 %", out=tmp_path)
