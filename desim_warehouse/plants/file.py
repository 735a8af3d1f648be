"""The bytes of a file from an untrusted source: a regular file of limited size.

For `desim import`.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from desim_warehouse.errors import ModelError, reason
from desim_warehouse.values.fields import LIMITS


def content_of(path: Path, expected: str, most: int = LIMITS["bytes"][0]) -> bytes:
    """Return the bytes of a foreign file.

    Raises:
        ModelError: no regular file of at most `most` bytes that can be read; `expected`: what it should be, for
            messages.
    """
    try:
        regular = path.is_file() or not path.exists()  # a pipe or a device may never end
        with path.open("rb") if regular else BytesIO() as file:
            content = file.read(most + 1)
    except FileNotFoundError:
        raise ModelError([f"{path}: no such file, expected {expected}"]) from None
    except (OSError, ValueError) as error:
        raise ModelError([f"{path}: cannot be read ({reason(error)}), expected {expected}"]) from None
    if not regular:
        raise ModelError([f"{path}: not a file, expected {expected}"])
    if len(content) > most:
        raise ModelError([f"{path}: too large, expected {expected} of at most {most:,} bytes"])
    return content
