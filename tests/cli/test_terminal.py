"""What a terminal gets: no line longer than it is wide, and verdicts in colour; a pipe gets neither."""

import os
import re
import sys

import pytest

from desim_warehouse.answer.standing import WORDS
from desim_warehouse.cli import _Formatter, terminal
from desim_warehouse.cli.answers import COLOURS, say
from tests.cli.test_commands import call
from tests.docs.pages import run_desim

pytestmark = pytest.mark.usefixtures("brief_probes")

LONG = "warning: somewhere: " + "words " * 30 + "[CODE]"
COLOURS_OF_TEXT = re.compile("\x1b\\[[0-9;]*m")
COLOURED = re.compile("\x1b\\[(3[0-9])m(.*?)\x1b\\[0m")


def terminal_of_80(monkeypatch):
    """Take standard output for a terminal of 80 columns."""
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setattr(terminal.shutil, "get_terminal_size", lambda *_, **__: os.terminal_size((80, 24)))
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")


def printed(capsys, text=LONG):
    terminal.show(text, lambda line: terminal.DOUBTFUL if line.startswith("warning") else "")
    return capsys.readouterr().out


def test_a_terminal_gets_folded_lines_and_colours(capsys, monkeypatch):
    terminal_of_80(monkeypatch)
    out = printed(capsys, f"{LONG}\nno verdict: all is well\n  {LONG[9:]}")
    lines = COLOURS_OF_TEXT.sub("", out).splitlines()
    assert out.startswith("\x1b[33mwarning\x1b[0m: somewhere: words")
    assert out.count("\x1b[33m") == 1
    assert max(map(len, lines)) <= 80
    assert " ".join(line.strip() for line in lines[:3]) == LONG
    assert lines[-1].startswith("    ")
    for name, value in (("NO_COLOR", "1"), ("TERM", "dumb")):
        with monkeypatch.context() as inner:
            inner.setenv(name, value)
            assert "\x1b" not in printed(capsys)


def test_what_options_were_shown_to_be_is_in_colour_in_tables_and_at_the_end_of_sentences(capsys, monkeypatch):
    terminal_of_80(monkeypatch)
    text = "9 robots, at least 95 %: 97 %, met.\n9 robots met nobody.\n9 robots  97 %  met  33\n8 robots  93 %  not met"
    say(text)
    out = capsys.readouterr().out
    assert COLOURS_OF_TEXT.sub("", out) == f"{text}\n"
    assert COLOURED.findall(out) == [("32", "met"), ("32", "met"), ("31", "not met")]
    assert set(COLOURS) <= set(WORDS.values())
    monkeypatch.setenv("NO_COLOR", "1")
    say(text)
    assert capsys.readouterr().out == f"{text}\n"


def test_help_pages_break_no_option_from_its_value_and_no_word():
    formatter = _Formatter(width=30)
    formatter.write_text("Example: desim plan w.yaml --price-robot 9000 --workers 2, for one-way aisles at 95 %")
    lines = formatter.getvalue().splitlines()
    assert "--price-robot 9000" in formatter.getvalue()
    assert all(len(line) <= 30 and not line.endswith("-") for line in lines)
    assert any(line.endswith("95 %") for line in lines)
    assert formatter.getvalue().isascii()


def test_a_pipe_gets_neither(capsys):
    assert printed(capsys) == f"{LONG}\n"


def test_check_of_a_first_draft_is_one_screen_of_80_by_24(tmp_path, capsys, monkeypatch):
    path = str(tmp_path / "w.yaml")
    assert run_desim(f"desim new {path}")[0] == 0
    plain = call("check", path).stdout
    terminal_of_80(monkeypatch)
    terminal.show(plain)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) < 24
    assert max(map(len, lines)) <= 80
    assert lines[0] == "no errors"
    assert lines[2] == "Demand: 200 an hour = 4,800 orders a day."
