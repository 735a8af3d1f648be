"""What results depend on besides a model and its seed."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib import metadata
from pathlib import Path

from desim_warehouse import _version

_PACKAGES = ("simpy", "networkx", "numpy", "scipy", "pydantic")


def versions() -> dict[str, str]:
    """The versions that results depend on: ours, Python's and those of packages."""
    return {
        "desim-warehouse": _version.__version__,
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in _PACKAGES},
    }


@cache
def program() -> str:
    """A digest of these versions and of our code, which somebody may be changing."""
    found = hashlib.sha256(repr(sorted(versions().items())).encode())
    home = Path(_version.__file__).parent
    for path in sorted(home.rglob("*.py")):
        found.update(f"\0{path.relative_to(home)}\0".encode() + path.read_bytes())
    return found.hexdigest()[:16]
