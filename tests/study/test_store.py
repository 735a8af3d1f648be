"""The store: nothing that is finished gets lost, nothing damaged is used, and the message says what happened."""

import errno
import json
import os
import subprocess
import sys
import zlib
from pathlib import Path

import pandas as pd
import pytest

import desim_warehouse as dw
from desim_warehouse.folders import JOURNAL
from desim_warehouse.study.execution.store import FolderLock, Store
from desim_warehouse.study.execution.work import Outcome

from .conftest import MULTIBOTS


def study(**more):
    return dw.Study(MULTIBOTS, {"fleet.size": [1, 2]}, changes={"tasks.goods": {"random": 2}}, **more)


def opened(folder):
    notes = []
    with Store(folder, notes.append) as store:
        return dict(store.runs), notes


def filled(folder, count=5):
    with Store(folder, print) as store:
        for seed in range(count):
            store.add("model", seed, Outcome({"T": seed / 3, "S": seed, "x": float("nan")}, 0.1))
    return folder / JOURNAL


def test_a_run_is_exact_only_if_its_line_says_so(tmp_path):
    with Store(tmp_path, print) as store:
        store.add("model", 0, Outcome({"T": 1.0}, 0.1, deterministic=True))
        store.add("model", 1, Outcome({"T": 1.0}, 0.1))
    assert b"deterministic" not in (tmp_path / JOURNAL).read_bytes().splitlines()[1]
    with Store(tmp_path, print, read_only=True) as again:
        assert [again.get("model", seed).deterministic for seed in (0, 1)] == [True, False]


def test_values_come_back_exactly(tmp_path):
    filled(tmp_path)
    runs, notes = opened(tmp_path)
    assert not notes
    assert [runs["model", seed].values["T"] for seed in range(5)] == [seed / 3 for seed in range(5)]  # noqa: PD011
    assert type(runs["model", 1].values["S"]) is int  # noqa: PD011
    assert runs["model", 1].values["x"] != runs["model", 1].values["x"]  # noqa: PD011


def test_a_line_cut_short_anywhere_costs_that_run_only(tmp_path):
    journal = filled(tmp_path)
    whole = journal.read_bytes()
    begin = whole.rindex(b"\n", 0, -1) + 1
    for end in range(begin + 1, len(whole)):
        journal.write_bytes(whole[:end])
        runs, notes = opened(tmp_path)
        assert len(runs) == 4
        assert "cut short" in notes[0]
        assert journal.read_bytes() == whole[:begin]  # mended: the next line starts afresh
    assert opened(tmp_path)[1] == []


def test_a_damaged_byte_costs_that_run_only(tmp_path):
    journal = filled(tmp_path)
    whole = bytearray(journal.read_bytes())
    whole[whole.index(b'"T":0.66') + 6] ^= 1
    journal.write_bytes(whole)
    runs, notes = opened(tmp_path)
    assert ("model", 2) not in runs
    assert len(runs) == 4
    assert "1 run is damaged and not used" in notes[0]


SOUND = {"model": "model", "seed": 9, "version": dw.__version__, "values": {"T": 1.5}, "time": 0.1}


def line_of(text):
    """A line of the journal with the right checksum."""
    return b"%08x %s\n" % (zlib.crc32(text.encode()), text.encode())


@pytest.mark.parametrize(
    "text",
    [
        "[]",
        "3",
        "{}",
        100_000 * "[" + 100_000 * "]",
        json.dumps(SOUND)[:-1] + ', "more": ' + 100_000 * '{"a":' + "1" + 100_001 * "}",
        json.dumps(SOUND | {"model": ["model"]}),
        json.dumps(SOUND | {"seed": "9"}),
        json.dumps(SOUND | {"seed": True}),
        json.dumps(SOUND | {"version": {"of": 1}}),
        json.dumps(SOUND | {"values": None}),
        json.dumps(SOUND | {"values": ["T"]}),
        json.dumps(SOUND | {"values": {"T": "1.5"}}),
        json.dumps(SOUND | {"values": {"T": None}}),
        json.dumps(SOUND | {"values": {"\ud800": 1}}),
        json.dumps(SOUND | {"time": "0.1"}),
        json.dumps(SOUND | {"error": 3}),
        json.dumps(SOUND | {"error": "\udfff"}),
        json.dumps(SOUND | {"error": "x", "final": "no"}),
        json.dumps(SOUND | {"seed": 0}).replace("0,", "9" * 5000 + ","),
    ],
    ids=lambda text: text[:10] if len(text) < 10 else f"{text[:5]}{zlib.crc32(text.encode()):x}",
)
def test_odd_content_under_a_right_checksum_costs_that_run_only(tmp_path, text):
    journal = filled(tmp_path)
    journal.write_bytes(line_of(text) + journal.read_bytes() + line_of(json.dumps(SOUND)))
    runs, notes = opened(tmp_path)
    assert sorted(seed for _, seed in runs) == [0, 1, 2, 3, 4, 9]
    assert runs["model", 9].values == {"T": 1.5}  # noqa: PD011
    (note,) = notes
    assert note.startswith(f"{journal}: 1 run is damaged and not used; done again where needed")


def test_a_value_of_any_size_under_a_right_checksum_is_shown_in_the_table(tmp_path):
    made = study(replications=2).run(out=tmp_path)
    journal = tmp_path / JOURNAL
    entries = [json.loads(line[9:]) for line in journal.read_bytes().splitlines()]
    entries[0]["values"]["S"] = 10**30
    journal.write_bytes(b"".join(line_of(json.dumps(entry)) for entry in entries))
    again = study(replications=2).run(out=tmp_path)
    assert again.notes == []
    assert again.table["S"].tolist() == [1e30, *made.table["S"].tolist()[1:]]
    assert again.table["T"].equals(made.table["T"])


def test_an_error_that_is_no_proper_text_is_kept_as_one(tmp_path, policies):
    Path(policies).write_text(Path(policies).read_text().replace("no bay for me", "no \\udce4 bay"))
    parking = {"name": f"{policies}:Home", "what": "raise"}
    made = dw.Study(MULTIBOTS, {"policies.parking": [parking]})
    with pytest.raises(dw.StudyError, match="no run finished"):
        made.run(out=tmp_path / "out")
    assert r"no \udce4 bay" in made.table["error"][0]
    assert dw.Study.open(tmp_path / "out").table.equals(made.table)


def test_runs_of_another_version_are_kept_but_not_used(tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr("desim_warehouse.study.execution.store.__version__", "0.0.1")
        filled(tmp_path)
    runs, notes = opened(tmp_path)
    assert not runs
    assert "5 runs are of version 0.0.1 not used again" in notes[0]
    assert len((tmp_path / JOURNAL).read_bytes().splitlines()) == 5


def test_an_error_that_may_not_happen_again_is_tried_again_and_one_that_will_is_not(tmp_path):
    with Store(tmp_path, print) as store:
        store.add("model", 0, Outcome({}, 1.0, "time-out: not finished after 1 s", final=False))
        store.add("model", 1, Outcome({}, 1.0, "StallError: stalled"))
    with Store(tmp_path, print) as store:
        assert store.missing("model", 0)
        assert not store.missing("model", 1)
        assert store.get("model", 0).error.startswith("time-out")
        store.add("model", 0, Outcome({"T": 1}, 1.0))
    with Store(tmp_path, print) as store:
        assert not store.missing("model", 0)
        assert store.get("model", 0).values == {"T": 1}  # noqa: PD011


@pytest.mark.parametrize("part", [0, 10])
def test_a_full_disk_ends_the_study_with_what_is_finished_kept(tmp_path, monkeypatch, part):
    write, count = os.write, 0

    def full(file, data):
        nonlocal count
        if data[8:9] == b" " and b'"model"' in data:
            count += 1
            if count > 3:
                if not part:
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                return write(file, data[:part])
        return write(file, data)

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        with pytest.raises(dw.StudyError, match=r"runs.jsonl: cannot be written \(No space left.*kept: make room"):
            study(replications=3).run(out=tmp_path)
    assert len(opened(tmp_path)[0]) == 3
    assert len(pd.read_parquet(tmp_path / "results.parquet")) == 3
    again = study(replications=3).run(out=tmp_path)
    assert again.notes == []
    assert len((tmp_path / JOURNAL).read_bytes().splitlines()) == 6


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs /dev/full's kin: a limit on file size")
def test_a_real_limit_on_the_disk_is_survived(tmp_path):
    """The file system refuses to let the journal grow beyond 3000 bytes (RLIMIT_FSIZE)."""
    code = f"""
import resource, signal
import desim_warehouse as dw
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
study = dw.Study({str(MULTIBOTS)!r}, {{"fleet.size": [1, 2]}}, changes={{"tasks.goods": {{"random": 2}}}},
                 replications=20, indicators=["T"])
resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
try:
    study.run(out={str(tmp_path)!r})
except dw.StudyError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "make room and start the study again" in done.stdout
    kept = len(opened(tmp_path)[0])
    assert 0 < kept < 40
    study(replications=20).run(out=tmp_path)
    assert len((tmp_path / JOURNAL).read_bytes().splitlines()) == 40


def test_a_damaged_table_is_made_again_from_the_journal(tmp_path):
    made = study(replications=2).run(out=tmp_path)
    for content in (b"", b"not parquet", (tmp_path / "results.parquet").read_bytes()[:-40]):
        (tmp_path / "results.parquet").write_bytes(content)
        again = study(replications=2).run(out=tmp_path)
        assert "results.parquet: damaged; rebuilt" in again.notes[0]
        assert pd.read_parquet(tmp_path / "results.parquet").equals(made.table)


def test_a_damaged_study_record_is_told_and_written_again_by_the_study(tmp_path):
    made = study(replications=2).run(out=tmp_path)
    (tmp_path / "study.json").write_text('{"format": 1, "na')
    with pytest.raises(dw.StudyError, match=r"study.json: cannot be read .* the runs are safe"):
        dw.Study.open(tmp_path)
    study(replications=2).run(out=tmp_path)
    assert dw.Study.open(tmp_path).table.equals(made.table)


def test_the_record_names_models_seeds_and_versions(tmp_path):
    made = study(replications=2).run(out=tmp_path)
    record = json.loads((tmp_path / "study.json").read_text())
    assert record["run_seeds"] == made.table["seed"].unique().tolist()
    assert record["points"][1]["model"] == made.plan.base.replace({"fleet.size": 2}).digest()
    assert dw.load(record["base"]) == made.plan.base
    assert record["versions"]["desim-warehouse"] == dw.__version__


def test_two_studies_in_one_folder_at_once_are_refused(tmp_path):
    lock = FolderLock(tmp_path)
    with pytest.raises(dw.StudyError, match=rf"another study is at work there \(process {os.getpid()} on "):
        study().run(out=tmp_path)
    lock.release()
    study().run(out=tmp_path)


def test_a_folder_that_cannot_be_used_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(dw.StudyError, match="cannot be used as a study folder"):
        study().run(out=tmp_path / "file")


def test_ctrl_c_between_journal_and_memory_leaves_them_agreed(tmp_path, monkeypatch):
    """The run has just been written down when Ctrl-C comes: the table has it too."""
    write, count = Store._write, 0

    def interrupted(self, line):
        nonlocal count
        write(self, line)
        count += 1
        if count == 3:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Store, "_write", interrupted)
        with pytest.raises(KeyboardInterrupt):
            study(replications=3).run(out=tmp_path)
    assert len(pd.read_parquet(tmp_path / "results.parquet")) == 3
    assert len((tmp_path / JOURNAL).read_bytes().splitlines()) == 3
