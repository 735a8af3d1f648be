"""A live page under test, and a client that asks it as a script does."""

import json
from contextlib import contextmanager

import httpx

import desim_warehouse as dw

TUTORIAL = "models/tutorial.yaml"
BUSY = {"tasks.goods": {"poisson": 150, "due_within": 300}, "tasks.end": None, "run.length": 3600, "run.warm_up": 600}


class Client:
    """What a script does with a live page."""

    def __init__(self, live):
        self.live = live
        headers = {"Authorization": f"Bearer {live.token}"}
        self.http = httpx.Client(base_url=f"http://127.0.0.1:{live.port}", headers=headers, timeout=60)

    def design(self, **levels):
        """A design by hand; `robots` stands for `fleet.size`."""
        asked = {"fleet.size" if key == "robots" else key: value for key, value in levels.items()}
        answer = self.http.post("/api/design", json={"levels": asked})
        assert answer.status_code == 200, answer.text
        return dict(answer.json())

    def answers(self, design, **query):
        """The answers on a design as they come."""
        with self.http.stream("GET", f"/api/design/{design}/events", params=query) as stream:
            assert stream.status_code == 200, stream.read()
            for line in stream.iter_lines():
                if line.startswith('data: {"id"'):
                    yield json.loads(line[6:])

    def until(self, design, ready=None, **query):
        """The first answer that is ready, by default done."""
        return next(one for one in self.answers(design, **query) if (ready or (lambda one: one["done"]))(one))


@contextmanager
def client(out, model=TUTORIAL, **options):
    """A live page in a folder, and its client."""
    with dw.serve(model, out=out, **{"workers": 2, **options}) as live:
        made = Client(live)
        with made.http:
            yield made
