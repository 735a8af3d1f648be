"""The user's cache: a question asked again costs only what is new, and nothing wrong is ever answered from it."""

import errno
import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.study.execution import cache as caching
from desim_warehouse.study.execution.cache import Cache, cache_folder
from desim_warehouse.study.execution.store import Store
from desim_warehouse.study.execution.work import Outcome, Simulator
from desim_warehouse.study.procedures import race

from .conftest import MULTIBOTS, PATIENCE
from .test_faults import DESIM

posix = pytest.mark.skipif(os.name != "posix", reason="kill -9 and owners of folders")
CHANGES = {"tasks.goods": {"random": 2}}


@pytest.fixture
def simulated(monkeypatch):
    """The runs that were simulated in this process, as (overrides, seed)."""
    done = []
    run = Simulator.run

    def counted(self, base, wanted, *limits):
        done.append((dict(wanted.overrides), wanted.seed))
        return run(self, base, wanted, *limits)

    monkeypatch.setattr(Simulator, "run", counted)
    return done


def chosen(fleets=(1, 2, 3), **where):
    """What `best` says, all of it, and the study that it was asked of."""
    made = dw.Study(MULTIBOTS, {"fleet.size": list(fleets)}, changes=CHANGES)
    return race(made, "T", 50, search=dw.Search(first=5, cap=15, **where)), made


def journals():
    return sorted(cache_folder().glob("runs-*/*.jsonl"))


def test_a_question_asked_again_is_answered_without_a_run(simulated):
    first, _ = chosen()
    before = list(simulated)
    assert before
    again, _ = chosen()
    assert again == first
    assert simulated == before
    wider, _ = chosen(fleets=(1, 2, 3, 4))
    new = simulated[len(before) :]
    assert {"fleet.size": 4} in [overrides for overrides, _ in new]
    assert not [run for run in new if run in before]
    assert wider == chosen(fleets=(1, 2, 3, 4), cache=False)[0]


@pytest.mark.parametrize("changed", [{"seed": 5}, {"changes": {**CHANGES, "log": "moves"}}, {"changes": {}}])
def test_another_seed_log_level_or_model_is_another_run(simulated, changed):
    chosen()
    simulated.clear()
    race(
        dw.Study(MULTIBOTS, {"fleet.size": [1, 2]}, **{"changes": CHANGES, **changed}),
        "T",
        50,
        search=dw.Search(cap=10),
    )
    assert simulated


def test_a_policy_that_was_changed_is_another_run(simulated, policies):
    factors = {"policies.parking": [{"name": f"{policies}:Home"}, "home"]}

    def ask():
        simulated.clear()
        race(dw.Study(MULTIBOTS, factors, changes=CHANGES), "T", 50, search=dw.Search(first=2, cap=2))
        return len(simulated)

    assert ask()
    assert not ask()
    Path(policies).write_text(Path(policies).read_text() + "\n")
    assert ask() == 2  # ours is as it was


def test_no_cache_keeps_and_reads_nothing(simulated):
    chosen(cache=False)
    assert not journals()
    chosen()
    simulated.clear()
    chosen(cache=False)
    assert simulated


def test_out_keeps_runs_in_its_folder_alone(tmp_path, simulated):
    chosen(out=tmp_path / "out")
    assert not journals()
    simulated.clear()
    chosen(out=tmp_path / "out")
    assert not simulated


def test_a_study_that_is_run_in_python_is_not_kept_unless_asked():
    dw.Study(MULTIBOTS, changes=CHANGES).run()
    assert not journals()
    dw.Study(MULTIBOTS, changes=CHANGES).run(cache=True)
    assert len(journals()) == 1


def test_a_cache_of_other_code_is_not_used(simulated, monkeypatch):
    chosen()
    simulated.clear()
    monkeypatch.setattr(caching, "program", lambda: "of another version")
    chosen()
    assert simulated
    assert len({path.parent for path in journals()}) == 2


def test_the_files_of_packages_are_read_once_for_their_versions(monkeypatch):
    before = caching.versions()
    monkeypatch.setattr(caching.metadata, "version", None)
    assert caching.versions() == before


def test_damaged_entries_are_simulated_again(simulated):
    first, _ = chosen()
    whole = {path: path.read_bytes() for path in journals()}
    path, content = max(whole.items(), key=lambda item: len(item[1]))
    lines = content.count(b"{") // 2
    damages = {
        content[:-9]: 1,  # cut short
        b"": lines,
        os.urandom(len(content)): lines,
        content.replace(b'"T":', b'"T":1', 1): 1,
        content.replace(b"\n", b"", 3): 2,  # two lines in one
        b"\x00" * 4096 + content: 0,
    }
    for damaged, lost in damages.items():
        path.write_bytes(damaged)
        simulated.clear()
        again, _ = chosen()
        assert again == first
        assert len(simulated) == lost
        path.write_bytes(content)


def test_the_runs_of_one_model_in_the_file_of_another_are_not_taken_for_its_own(simulated):
    first, _ = chosen()
    one, other, *_ = journals()
    shutil.copy(one, other)
    simulated.clear()
    assert chosen()[0] == first
    assert simulated


@pytest.mark.parametrize("room", [0, 40])
def test_a_full_disk_is_said_once_and_changes_no_answer(monkeypatch, room):
    """Of each line only `room` bytes fit; those before it are kept."""
    kept, _ = chosen(fleets=(1, 2))
    before = len(journals())
    write = os.write

    def full(file, data):
        if bytes(data).startswith(b"\n"):
            if not room:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            return write(file, data[:room])
        return write(file, data)

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        choice, made = chosen(fleets=(1, 2, 3))
    notes = [note for note in made.notes if "cache" in note]
    assert len(notes) == 1
    assert "cannot be written (No space left on device)" in notes[0]
    assert choice == chosen(fleets=(1, 2, 3), cache=False)[0]
    assert chosen(fleets=(1, 2))[0] == kept
    again, _ = chosen(fleets=(1, 2, 3))  # there is room again, after a line that was cut short
    assert again == choice
    assert len(journals()) == before + 1
    assert chosen(fleets=(1, 2, 3))[0] == choice


def test_a_line_after_one_that_was_cut_short_is_found(simulated):
    chosen()
    for path in journals():
        path.write_bytes(path.read_bytes()[:-20])
    chosen()
    simulated.clear()
    chosen()
    assert simulated == []


def test_a_folder_that_cannot_be_used_is_said_and_changes_no_answer(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("DESIM_CACHE", str(tmp_path / "file"))
    choice, made = chosen()
    assert choice == chosen(cache=False)[0]
    (note,) = made.notes
    assert "cannot be used (a file is in the place of a folder)" in note
    assert "DESIM_CACHE names another folder" in note


@posix
def test_only_the_user_reads_it_and_a_folder_of_others_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv("DESIM_CACHE", str(tmp_path / "new" / "cache"))
    chosen()
    (journal, *_) = journals()
    for path in (cache_folder(), journal.parent):
        assert path.stat().st_mode & 0o777 == 0o700
    assert journal.stat().st_mode & 0o777 == 0o600
    cache_folder().chmod(0o777)
    (note,) = chosen()[1].notes
    assert "others may write there" in note


def test_there_is_never_more_than_its_limit_and_what_was_used_last_stays(monkeypatch):
    monkeypatch.setattr(caching, "MOST", 64_000)
    line = b"x" * 500 + b"\n"
    made = Cache(print)
    for number in range(250):
        made.keep(f"{number:03}", line)
        os.utime(cache_folder() / made.folder.name / f"{number:03}.jsonl", (number, number))
        if number % 20 == 0:
            made.lines("000")  # used: as new as now
        assert sum(path.stat().st_size for path in journals()) <= 64_000
    made.close()
    names = [path.stem for path in journals()]
    assert names[0] == "000"
    assert names[1:] == [f"{number:03}" for number in range(250 - len(names) + 1, 250)]
    assert len(names) > 50


def test_runs_that_may_end_otherwise_next_time_are_not_kept():
    with Store(None, print, cache=Cache(print)) as store:
        store.add("model", 0, Outcome({}, 1.0, "time-out", final=False))
        store.add("model", 1, Outcome({"T": 1.0}, 1.0))
    with Store(None, print, cache=Cache(print)) as again:
        assert [again.missing("model", seed) for seed in (0, 1)] == [True, False]


def command(fleets, first):
    """A race of fleets of one robot and more, with so many runs of each before the first look."""
    vary = ["best", str(MULTIBOTS), "--vary", f"fleet.size=1..{fleets}", "--indicator", "T", "--delta", "1", "--quiet"]
    return [*vary, "--set", "tasks.goods={random: 8}", "--first", str(first), "--cap", str(2 * first)]


def started(arguments, *more):
    return subprocess.Popen([*DESIM, *arguments, *more], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def lines():
    return sum(path.read_bytes().count(b"{") // 2 for path in journals())


def answer(arguments):
    done = CliRunner().invoke(desim, arguments)
    assert done.exit_code == 0, done.output
    return done.stdout


LONG = [(6, 50, signal.SIGKILL, "2"), (6, 50, signal.SIGKILL, "auto"), (6, 50, signal.SIGINT, "1")]


@posix
@pytest.mark.parametrize(
    ("fleets", "first", "number", "workers"),
    [(2, 10, signal.SIGKILL, "1"), *(pytest.param(*each, marks=pytest.mark.long) for each in LONG)],
)
def test_a_command_that_was_stopped_loses_nothing_that_ended(simulated, fleets, first, number, workers):
    process = started(command(fleets, first), "--workers", workers)
    end = time.monotonic() + PATIENCE
    while lines() < first:
        assert time.monotonic() < end
        time.sleep(0.01)
    process.send_signal(number)
    _, stderr = process.communicate(timeout=PATIENCE)
    if number == signal.SIGINT:
        assert process.returncode == 130
        assert "finished runs are kept in the cache; the same command resumes" in stderr
    kept = lines()
    whole, resumed = (
        dw.Study(MULTIBOTS, {"fleet.size": range(1, fleets + 1)}, changes={"tasks.goods": {"random": 8}})
        for _ in range(2)
    )
    expected = race(whole, "T", 1, search=dw.Search(first=first, cap=2 * first, cache=False))
    simulated.clear()
    assert race(resumed, "T", 1, search=dw.Search(first=first, cap=2 * first)) == expected
    assert len(simulated) == len(resumed.rows) - kept


@pytest.mark.long
@posix
def test_two_commands_on_one_cache_at_once_answer_as_one():
    both = [started(command(6, 50), "--workers", number) for number in "12"]
    outputs = [process.communicate(timeout=PATIENCE) for process in both]
    assert [process.returncode for process in both] == [0, 0], outputs
    assert outputs[0] == outputs[1]
    assert outputs[0][0] == answer(command(6, 50))


def test_a_second_plan_of_the_same_question_takes_under_two_seconds(tmp_path):
    arguments = ["plan", str(Path(__file__).parent / "always_on_time.yaml"), "--target", "on_time >= 90 %", "--quiet"]
    arguments += ["--robots", "3..4", "--first", "4", "--cap", "8"]
    first = CliRunner().invoke(desim, arguments)
    began = time.process_time()
    again = CliRunner().invoke(desim, arguments)
    assert time.process_time() - began < 2
    assert again.stdout == first.stdout
    assert again.stderr == ""
