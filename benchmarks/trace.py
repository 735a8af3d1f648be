"""Through how many modules does an answer go, from what is typed to its sentence? `python -m benchmarks.trace`.

Counted are the modules of the package of which a function runs, in this process and in its runs; class bodies and
imports do not count, and the world, where a run happens, counts as one. Read it when a command is to be followed by
somebody who is new here.
"""

import sys
import tempfile
import threading
from pathlib import Path
from types import CodeType, FrameType

from click.testing import CliRunner

from desim_warehouse.cli import desim

PACKAGE = str(Path(__file__).resolve().parent.parent / "desim_warehouse")
COMMANDS = {
    "check": "check models/tutorial.yaml",
    "run": "run models/tutorial.yaml --set run.length=600",
    "plan": "plan models/tutorial.yaml --target {target} --robots 2..4 --chargers 1..2 --workers 1 --cap 10",
}
TARGET = "throughput_per_hour >= 150"


def modules(words: list[str]) -> list[str]:
    """The modules of which a function runs while a command is carried out."""
    seen: set[CodeType] = set()

    def look(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            seen.add(frame.f_code)

    threading.setprofile(look)
    sys.setprofile(look)
    try:
        result = CliRunner().invoke(desim, words)
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    run = {code.co_filename for code in seen if code.co_name != "<module>" and code.co_flags & 1}  # 1: CO_OPTIMIZED
    names = {name.removeprefix(PACKAGE)[1:] for name in run if name.startswith(PACKAGE)}
    return sorted({"world" if name.startswith("world") else name for name in names})


def main() -> None:
    """Print the number of modules for each command, and with a command's name those of it."""
    for name, text in COMMANDS.items():
        words = [TARGET if word == "{target}" else word for word in text.split()]
        with tempfile.TemporaryDirectory() as folder:
            passed = modules([*words, "--out", folder] if name == "run" else words)
        print(f"{name}: {len(passed)} modules")
        if name in sys.argv[1:]:
            print("\n".join(f"  {one}" for one in passed))


if __name__ == "__main__":
    main()
