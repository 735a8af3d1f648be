"""What a server of a live page stands: many listeners at once, thousands of designs, requests that are never whole."""

import socket
from time import monotonic, sleep

import pytest

from desim_warehouse.live import app, desk
from tests.live.client import Client, client

pytestmark = pytest.mark.usefixtures("brief_probes")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    with client(tmp_path_factory.mktemp("live"), vary={"fleet.size": list(range(1, 21))}, workers=1) as made:
        yield made


def request(page, path, *more):
    lines = [f"GET {path} HTTP/1.1", f"Host: 127.0.0.1:{page.live.port}", f"Authorization: Bearer {page.live.token}"]
    return "\r\n".join((*lines, *more, "", "")).encode()


def connected(page):
    return socket.create_connection(("127.0.0.1", page.live.port), timeout=30)


def test_of_all_who_listen_at_once_no_more_are_let_in_than_promised(page):
    design = page.design(robots=2)["id"]
    sockets = [connected(page) for _ in range(desk.MOST_LISTENERS + 30)]
    for one in sockets:
        one.sendall(request(page, f"/api/design/{design}/events"))
    answers = [one.recv(16) for one in sockets]
    let_in = sum(b" 200 " in one for one in answers)
    assert let_in < desk.MOST_LISTENERS == len(page.live.desk.listeners)  # one of them is the server's own
    assert sum(b" 422" in one for one in answers) == len(sockets) - let_in
    for one in sockets:
        one.close()
    until = monotonic() + 20
    while len(page.live.desk.listeners) > 1 and monotonic() < until:
        sleep(0.05)
    assert len(page.live.desk.listeners) == 1


def test_of_more_designs_than_are_kept_those_that_nobody_listens_to_are_forgotten_and_their_runs_stay(
    page, monkeypatch
):
    monkeypatch.setattr(desk, "MOST_DESIGNS", 3)
    first = page.until(page.design(robots=2)["id"], lambda one: one["n"] >= 3)
    listening = page.answers(page.design(robots=1)["id"])
    shown = next(listening)["id"]
    for robots in range(4, 10):
        page.design(robots=robots)
    assert len(page.live.desk.designs) == 3
    assert {shown, page.design()["id"]} <= set(page.live.desk.designs)
    assert first["id"] not in page.live.desk.designs
    assert page.design(robots=2)["runs"] >= 3
    listening.close()


@pytest.mark.parametrize("sent", ["", "GET / HT", "POST /api/design HTTP/1.1\r\nContent-Length: 100\r\nHost: "])
def test_whoever_sends_half_a_request_is_not_waited_for(page, monkeypatch, sent):
    monkeypatch.setattr(app, "WITHIN", 0.3)
    with connected(page) as half:
        half.sendall(sent.encode() + (f"127.0.0.1:{page.live.port}\r\n\r\nhalf".encode() if "POST" in sent else b""))
        began = monotonic()
        while half.recv(4096):
            pass
        assert 0.2 < monotonic() - began < 5


def test_half_a_second_request_on_a_connection_is_not_waited_for_either(page, monkeypatch):
    monkeypatch.setattr(app, "WITHIN", 0.3)
    with connected(page) as half:
        half.sendall(request(page, "/api/model"))
        assert b" 200 " in half.recv(65536)
        half.sendall(b"GET /api/mo")
        while half.recv(65536):
            pass


def test_whoever_listens_is_not_cut_off(page, monkeypatch):
    monkeypatch.setattr(app, "WITHIN", 0.1)
    with Client(page.live).http as http:  # on a connection of its own
        began, path = monotonic(), f"/api/design/{page.design(robots=3)['id']}/events"
        with http.stream("GET", path, params={"runs": 500}) as stream:
            for _ in stream.iter_lines():
                if monotonic() - began > 0.5:
                    break
    assert monotonic() - began > 0.5
