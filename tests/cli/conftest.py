"""The program called in this process, where the start of another is not what is tested."""

import gc
import subprocess
import sys

import pytest

from desim_warehouse.cli import main


@pytest.fixture
def desim(monkeypatch, capsys):
    """Call the program with words, and return its exit status and output as `subprocess.run` does."""

    def call(*words):
        with monkeypatch.context() as patch:
            patch.setattr(sys, "argv", ["desim", *words])
            patch.setattr(sys, "stdout", sys.stdout)  # which `main` replaces
            patch.setattr(gc, "set_threshold", lambda *_: None)
            with pytest.raises(SystemExit) as ended:
                main()
        printed = capsys.readouterr()
        return subprocess.CompletedProcess(words, ended.value.code or 0, printed.out, printed.err)

    return call
