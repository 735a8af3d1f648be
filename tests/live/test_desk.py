"""The live page as a script sees it: runs, verdicts, differences, and what is left behind."""

import json
import math
import os
import signal
import stat
import subprocess
import sys
import threading
from time import monotonic, sleep

import httpx
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.answer import words
from desim_warehouse.cli import desim
from desim_warehouse.questions.judged import within as told
from desim_warehouse.questions.study import Results
from desim_warehouse.report.write import report
from desim_warehouse.study.plan import run_seed
from desim_warehouse.study.statistics.judge import looked_at
from desim_warehouse.study.target import read_target
from tests.live.client import TUTORIAL, Client, client

pytestmark = pytest.mark.usefixtures("brief_probes")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    vary = {"fleet.size": [1, 2, 3, 4, 5], "battery.consumption": [10], "policies.allocation": None}
    with client(tmp_path_factory.mktemp("live"), vary=vary) as made:
        yield made


@pytest.fixture(scope="module")
def slow(tmp_path_factory):
    """A page of which each run takes seconds."""
    with client(tmp_path_factory.mktemp("slow"), changes={"tasks.goods": {"random": 600}}) as made:
        yield made


@pytest.mark.usefixtures("whole_probes")
def test_the_hand_calculation_comes_first_then_run_by_run_what_the_runs_say(page):
    by_hand = page.design(robots=5)  # for which no other test of this page asks, with short probes
    assert by_hand["sentence"] == (
        "5 robots can do about 217 tasks an hour, limited by the number of slots at the stations."
    )
    answers = list(iter_until_done(page, by_hand["id"]))
    counts = [one["n"] for one in answers]
    assert counts == sorted(counts)
    assert counts[-1] == 35
    assert answers[-1]["done"] == "all"
    assert answers[-1]["verdict"] == "known"  # there is no target


def iter_until_done(page, design, **query):
    for answer in page.answers(design, **query):
        yield answer
        if answer["done"]:
            return


def test_numbers_are_those_that_what_if_prints_from_the_same_folder(tmp_path, page):
    answer = page.until(page.design(robots=4)["id"])
    (tmp_path / "runs.jsonl").write_bytes((page.live.folder / "runs.jsonl").read_bytes())
    line = f"what-if {TUTORIAL} --vary fleet.size=4 --replications 35 --workers 1 --quiet --out {tmp_path}"
    shown = [word for one in answer["measured"] for word in ("--indicator", one["name"])]
    result = CliRunner().invoke(desim, [*line.split(), *shown], catch_exceptions=False, env={"COLUMNS": "300"})
    assert answer["measured"][0]["text"] in result.output
    results = Results.load(tmp_path)
    assert [row.value("T") / 60 for row in results.rows] == pytest.approx(answer["values"], rel=1e-12)
    for one in answer["measured"]:
        estimate = results.estimate(results.rows, one["name"])
        scale = words.scale_of(one["name"], results.base, [estimate])
        assert told(one["name"], scale, (estimate.mean, *(estimate.interval or (None, None)))).text == one["text"]


def test_a_pinned_design_grows_beside_and_differences_are_paired_run_by_run(page):
    pinned, now = page.design(robots=3), page.design(robots=2)
    answer = page.until(now["id"], lambda one: one["done"] and "Difference" in str(one["more"]), pinned=pinned["id"])
    before = page.until(pinned["id"])
    gaps = [a - b for a, b in zip(answer["values"], before["values"], strict=True)]
    mean = sum(gaps) / len(gaps)
    assert answer["more"][-1].startswith(f"Difference, run by run: {mean:.3f} min (")
    assert answer["pinned_at"][0] == pytest.approx(sum(before["values"]) / 35)


def test_going_back_simulates_nothing(page):
    page.until(page.design(robots=2)["id"])
    design = page.design(robots=2)
    assert design["runs"] == 35
    assert next(page.answers(design["id"]))["done"] == "all"


def test_what_one_client_tries_is_in_the_list_of_another(page):
    mine, other = page.design(robots=2)["id"], Client(page.live)
    with other.http:
        theirs = other.design(**{"fleet.size": 3, "policies.allocation": "auction"})["id"]
        other.until(theirs, lambda one: one["n"])
        answer = page.until(mine, lambda one: theirs in {tried["id"] for tried in one["tried"]})
    assert any("auction" in tried["words"] for tried in answer["tried"])


def test_thirty_more_runs_on_request(page):
    design = page.design(robots=1)["id"]
    assert page.until(design)["n"] == 35
    assert page.until(design, runs=45)["n"] == 45


@pytest.mark.long  # every day in a browser, and what the first look says in test_first_runs.py
def test_a_verdict_ends_the_runs_and_stands(tmp_path):
    with client(tmp_path, target="T <= 8 min", workers=1) as page:
        answers = list(iter_until_done(page, page.design(robots=2)["id"]))
        assert answers[-1]["verdict"] == "met"
        assert answers[-1]["done"] == "verdict"
        assert answers[-1]["n"] == 35
        # one interval: that of the look, in the sentence and beside it, and none before the first look
        first = answers[-1]["measured"][0]
        assert answers[-1]["sentence"] == f"Task time {first['text']} with 2 robots and 3 chargers."
        look = looked_at(
            [60 * value for value in answers[-1]["values"]], read_target("T <= 480"), 0.95, within=(0, math.inf)
        )
        assert (first["low"], first["high"]) == pytest.approx((look.low / 60, look.high / 60))
        assert all("(" not in one["sentence"] for one in answers if one["verdict"] == "early")
        worse = page.until(page.design(robots=1)["id"])
        assert (worse["verdict"], worse["done"]) == ("not met", "verdict")
        easier = page.until(page.design(robots=1)["id"], target=20)
        assert easier["verdict"] == "met"
        workers = [worker.process.pid for worker in page.live.desk.pool.workers]
    assert workers
    assert not any(map(alive, workers))
    with client(tmp_path, workers=1) as page:
        assert page.design(robots=1)["runs"] == easier["n"] == 35


def test_what_nobody_listens_to_is_stopped_within_half_a_second(slow):
    desk = slow.live.desk
    answers = slow.answers(slow.design(robots=2)["id"])
    next(answers)
    until(lambda: desk.pool.workers and all(worker.handles for worker in desk.pool.workers))
    pids = {worker.process.pid for worker in desk.pool.workers}
    sleep(0.3)  # they are in the middle of it
    answers.close()
    with desk.lock:
        desk.listeners.clear()
        desk._schedule()
    asked = monotonic()
    until(lambda: not any(worker.handles for worker in desk.pool.workers))
    assert monotonic() - asked < 0.6
    assert {worker.process.pid for worker in desk.pool.workers} == pids  # none was killed for it


def until(condition, seconds=30.0):
    end = monotonic() + seconds
    while not condition():
        assert monotonic() < end
        sleep(0.01)


@pytest.mark.long  # every day one that executors share, in tests/study
def test_a_worker_that_is_killed_changes_no_number(page):
    desk, changes = page.live.desk, {"policies.allocation": "regret"}
    design = page.design(**changes)["id"]
    for answer in page.answers(design):
        if answer["n"]:
            os.kill(desk.pool.workers[0].process.pid, signal.SIGKILL)
            break
    answer = page.until(design)
    model = dw.load(TUTORIAL, changes)
    times = [dw.simulate(model, run_seed(0, r)).T / 60 for r in range(12)]  # with those that were under way
    assert answer["n"] == 35
    assert answer["values"][:12] == pytest.approx(times, rel=1e-12)


@pytest.mark.parametrize(("clients", "designs"), [(3, 2), pytest.param(20, 5, marks=pytest.mark.long)])
def test_many_clients_on_two_workers_get_right_answers_and_none_starves(page, clients, designs):
    sizes, answers, firsts = [1 + i % designs for i in range(clients)], {}, {}
    fresh = {"policies.allocation": "nearest"}

    def listen(number):
        mine = Client(page.live)
        begin = monotonic()
        design = mine.design(robots=sizes[number], **fresh)["id"]
        for answer in iter_until_done(mine, design):
            if answer["n"] and number not in firsts:
                firsts[number] = monotonic() - begin
            answers[number] = answer
        mine.http.close()

    threads = [threading.Thread(target=listen, args=(number,)) for number in range(clients)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert {answers[number]["n"] for number in range(clients)} == {35}
    for number in range(clients):
        run = dw.simulate(dw.load(TUTORIAL, {"fleet.size": sizes[number], **fresh}), run_seed(0, 0))
        assert answers[number]["values"][0] == pytest.approx(run.T / 60)


@pytest.mark.parametrize("moves", [4, pytest.param(50, marks=pytest.mark.long)])
def test_of_many_moves_only_the_last_design_stays_at_work(slow, moves):
    desk = slow.live.desk
    for move in range(moves):
        answers = slow.answers(slow.design(robots=1 + move % 7)["id"])
        next(answers)
        answers.close()
    answers = slow.answers(slow.design(robots=5)["id"])
    last = next(answers)["id"]
    until(lambda: {design.id for design, _ in list(desk.of.values())} == {last})
    until(lambda: [one.design.id for one in desk.listeners if one.most > 2] == [last])
    assert len(desk.pool.workers) == 2
    answers.close()


def test_designs_that_cannot_be_are_refused_with_key_value_and_cure(page):
    refused = page.http.post("/api/design", json={"levels": {"fleet.size": 7}})
    assert refused.status_code == 422
    assert refused.json() == {"problems": ["fleet.size: 7 is not offered, expected one of 1, 2, 3, 4, 5"]}
    refused = page.http.post("/api/design", json={"levels": {"battery.consumption": 10}})
    assert refused.status_code == 422
    assert "[BATTERY_TOO_SMALL]" in refused.json()["problems"][0]


def test_the_shared_page_has_the_same_numbers(page):
    pair = [page.design(robots=size)["id"] for size in (3, 2)]
    texts = [page.until(design)["measured"][0]["text"] for design in pair]
    made = page.http.post("/api/share", json={"ids": pair})
    assert made.status_code == 200
    data = json.loads(made.text.split('id="frozen">')[1].split("</script>")[0])
    assert [answer["measured"][0]["text"] for _, answer in data["designs"]] == texts
    assert [asked["runs"] for asked, _ in data["designs"]] == [35, 35]
    assert data["differences"][0][1].startswith("1.")
    [knob] = data["about"]["knobs"]
    assert knob["values"] == [2, 3]
    assert (data["pinned"], data["start"]) == (0, 1)


def test_the_folder_can_be_reported_while_the_page_is_served(page, tmp_path):
    page.until(page.design(robots=2)["id"])
    with page.live.desk.lock:
        page.live.desk._write()
    results = Results.load(page.live.folder)
    assert "2 robots" in str(list(results.designs))
    assert len(results.runs("Design=2 robots")) == 35
    page_of = report(page.live.folder, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "2 robots" in page_of


PRICES = {"hours": 4000, "robot": 9000}


def test_a_new_server_on_an_old_folder_lists_what_was_tried_and_what_it_costs(tmp_path):
    offered = {
        "vary": {"fleet.size": [1, 2, 3, 4]},
        "changes": {"prices": PRICES},
        "target": "T <= 6 min",
        "workers": 1,
    }
    with client(tmp_path, **offered) as page:
        first = page.until(page.design(robots=4)["id"])
    with client(tmp_path, **offered | {"vary": {"fleet.size": [1, 3, 4]}}) as page:
        again = page.until(page.design(robots=4)["id"], lambda one: len(one["tried"]) == 2)
    assert again["n"] >= first["n"]
    assert again["values"][: first["n"]] == first["values"]
    assert {one["words"] for one in again["tried"]} == {"3 robots", "4 robots"}
    assert again["sentence"].endswith(" with 4 robots, 36,000 a year.")


def test_the_floor_of_a_run_is_what_the_replay_page_plays(page):
    design = page.design(robots=2)["id"]
    page.until(design, lambda one: one["floor"], floor=1)
    floor = page.http.get(f"/api/design/{design}/floor").json()
    assert floor["header"]["name"] == "tutorial"
    assert len(floor["header"]["radii"]) == 2


def test_the_folder_in_the_cache_is_the_users_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("DESIM_CACHE", str(tmp_path / "cache"))
    with dw.serve(TUTORIAL, workers=1) as live:
        assert tmp_path / "cache" in live.folder.parents
        for folder in (live.folder, *live.folder.parents[:2]):
            assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        with pytest.raises(dw.StudyError, match="another study is at work there"):
            dw.serve(TUTORIAL, workers=1)


SERVED = "desim serve models/tutorial.yaml --no-open --workers 2 --out {out} --port 0"


@pytest.mark.parametrize("how", [pytest.param(signal.SIGINT, marks=pytest.mark.long), signal.SIGKILL])
def test_a_server_that_is_ended_or_killed_leaves_no_worker_and_loses_no_run(tmp_path, how):
    code = f"import sys; sys.argv = {SERVED.format(out=tmp_path).split()}; from desim_warehouse.cli import main; main()"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as server:
        address = server.stdout.readline().strip()
        base, token = address.split("/#")
        http = httpx.Client(base_url=base, headers={"Authorization": f"Bearer {token}"}, timeout=30)
        design = http.post("/api/design", json={"levels": {}}).json()["id"]
        with http.stream("GET", f"/api/design/{design}/events") as stream:
            next(line for line in stream.iter_lines() if counts(line) >= 5)
            children = children_of(server.pid)
            server.send_signal(how)
        server.wait(10)
        assert server.returncode == (0 if how == signal.SIGINT else -signal.SIGKILL)
        until(lambda: not any(map(alive, children)), 5)
    with client(tmp_path, workers=1) as page:
        assert page.design()["runs"] >= 5


def children_of(process):
    with open(f"/proc/{process}/task/{process}/children") as file:  # noqa: PTH123 - not a file on disk
        return [int(child) for child in file.read().split()]


def alive(process):
    try:
        with open(f"/proc/{process}/stat") as file:  # noqa: PTH123 - not a file on disk
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def counts(line):
    """The runs that an event tells of."""
    return json.loads(line[6:])["n"] if line.startswith('data: {"id"') else 0


def test_a_disk_that_is_full_is_said_and_the_last_answer_stays(tmp_path, monkeypatch):
    def full(*_):
        raise dw.StudyError("runs.jsonl: cannot be written (No space left on device)")

    with client(tmp_path, workers=1) as page:
        monkeypatch.setattr(page.live.desk.store, "add", full)
        answer = page.until(page.design(robots=2)["id"])
    assert answer["done"] == "fails"
    assert answer["more"][-1].startswith("Nothing more can be simulated: runs.jsonl: cannot be written")
