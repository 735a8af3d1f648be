"""How much memory a process has needed."""

from __future__ import annotations

import resource
from pathlib import Path


def peak() -> float:
    """The most memory that this process has had, in MB; `getrusage` counts on Linux what its parent had, too."""
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    line = next(line for line in status.read_text(encoding="ascii").splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024
