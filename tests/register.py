"""Python in a process of its own, whose register of states was edited before anything read it."""

import re
import subprocess
import sys
from pathlib import Path

import desim_warehouse

_ROOT = Path(desim_warehouse.__file__).parent
_BEGIN = """
import sys, types
source, place, script = sys.argv[1:]
module = sys.modules["desim_warehouse.states"] = types.ModuleType("desim_warehouse.states")
exec(compile(source, "states.py", "exec"), module.__dict__)
sys.path[:0] = [place]
exec(compile(script, "script", "exec"), {"__name__": "__main__"})
"""


def python(script, register=None):
    """What a script prints, given the text of `states.py`; default: as it is."""
    source = (_ROOT / "states.py").read_text() if register is None else register
    command = [sys.executable, "-W", "error", "-c", _BEGIN, source, str(_ROOT.parent), script]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


def renamed(prefix):
    """The register with other names for all states of the log."""
    source = (_ROOT / "states.py").read_text()
    log, rest = source.split("WAITING = State(")
    log, count = re.subn(r'(\n {8}State\(\n {12}")(\w+")', rf"\g<1>{prefix}\g<2>", log)
    assert count > 0
    return f"{log}WAITING = State(".replace('["queueing"]', f'["{prefix}queueing"]') + rest.replace(
        'STATES["queueing"]', f'STATES["{prefix}queueing"]'
    )


def extended(entry):
    """The register with one entry more in `STATES`, as docs/dev/adding.md says."""
    source = (_ROOT / "states.py").read_text()
    end = '    )\n}\n"""By name, in the order of tables and indicators."""'
    assert source.count(end) == 1
    return source.replace(end, entry + end)
