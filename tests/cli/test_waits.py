"""The table of what people wait for, on a floor small enough to wait for."""

import pytest

from benchmarks import waits


@pytest.mark.long
def test_every_command_ends_well_and_has_a_row(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(waits, "SIDES", {121: 10})
    monkeypatch.setattr(waits, "ANSWERS", {})
    monkeypatch.setattr(waits, "DAYS", {})
    monkeypatch.setattr(waits.bytecodes, "RUNS", {})
    monkeypatch.setattr(waits.bytecodes, "NEW", {})
    waits.report(long=True)
    rows = capsys.readouterr().out.splitlines()
    assert [row.split(",")[0] for row in rows] == [f"desim {name.split(',')[0]}" for name in waits.FLOORS]
    with pytest.raises(SystemExit, match="no such file"):
        waits.row("desim check, no file", ["check", "nothing.yaml"], tmp_path)
