"""A small study model, and policies that misbehave, for the tests of studies."""

import os
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MULTIBOTS = ROOT / "models" / "multibots.yaml"
PATIENCE = 300
"""Seconds until a test gives up on what should have happened: long, as the machine may be busy with other work."""

BAD_POLICIES = '''
import os, re, signal, subprocess, sys, time
from dataclasses import dataclass


@dataclass(frozen=True)
class Home:
    """Parks at home, after doing what it is named for."""

    what: str = "nothing"
    mark: str = ""

    def choose(self, robot, bays, travel):
        if self.what == "raise":
            raise ValueError("no bay for me")
        if self.what == "loop":
            while True:
                pass
        if self.what == "block":
            time.sleep(1000)
        if self.what == "block once" and self.is_first():
            time.sleep(1000)
        if self.what == "slow":
            time.sleep(0.01)
        if self.what == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.what == "exit":
            sys.exit(3)
        if self.what == "hold":  # for years, and no other thread of the process has its turn
            self.leave_mark(os.getpid())
            re.match("(a+)+$", 40 * "a" + "b")
        if self.what == "Ctrl-C as a generator is closed" and not os.path.exists(self.mark):
            self.leave_mark(os.getpid())
            closing = self.interrupted()
            next(closing)
            del closing
        if self.what == "start a process" and not os.path.exists(self.mark):
            self.leave_mark(subprocess.Popen(["sleep", "1000"]).pid)
        if self.what == "fork" and not os.path.exists(self.mark):
            copy = os.fork()
            if copy:
                self.leave_mark(copy)
        if self.what == "fork and wait" and not os.path.exists(self.mark):
            copy = os.fork()
            if not copy:
                time.sleep(1000)
            self.leave_mark(copy)
        if self.what == "fork and die" and not os.path.exists(self.mark):
            copy = os.fork()
            if not copy:
                time.sleep(1000)
            self.leave_mark(copy)
            os.kill(os.getpid(), signal.SIGKILL)
        if self.what == "die once" and not os.path.exists(self.mark):
            open(self.mark, "w").close()
            os.kill(os.getpid(), signal.SIGKILL)
        return next(bay.node for bay in bays if bay.node == robot.home)

    def is_first(self):
        try:
            open(self.mark, "x").close()
        except FileExistsError:
            return False
        return True

    def leave_mark(self, process):
        with open(self.mark, "w") as file:
            file.write(str(process))

    def interrupted(self):
        try:
            yield
        finally:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(1)
'''


def wait_for(what):
    """Until something holds, or it takes too long."""
    end = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.005)


def ample(usual):
    """A time-out, in seconds, ten times as long as the slowest of these runs took: it is cut off by no busy machine."""
    return max(1.0, round(10 * usual["run_time"].max(), 1))


@pytest.fixture
def two_processors(monkeypatch):
    """`auto` is two workers, whatever machine this is."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1}, raising=False)


@pytest.fixture
def policies(tmp_path):
    """A file of the user's own policies; `f"{policies}:Home"` is a parking policy."""
    path = tmp_path / "mine.py"
    path.write_text(BAD_POLICIES)
    return str(path)


@pytest.fixture
def parking(policies):
    """A parking policy that does what it is told: parking("raise")."""

    def make(what, **more):
        return {"name": f"{policies}:Home", "what": what, **more}

    return make
