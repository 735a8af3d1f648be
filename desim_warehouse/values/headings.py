"""Headings of tables as people write them, to be compared with the names that a column may have."""

from __future__ import annotations

import re
from typing import Any


def heading(title: Any) -> tuple[str, str | None]:
    """Return a heading in small letters and digits alone, and the unit in brackets behind it, None for none.

    `Max. speed [m/s]` and `max_speed [m/s]` are both `maxspeed`, in `m/s`.
    """
    text, unit = str(title if title is not None else "").strip(), None
    begin = max(text.rfind("("), text.rfind("["))
    if begin >= 0 and text.endswith((")", "]")):
        text, unit = text[:begin], text[begin + 1 : -1].strip()
    return re.sub(r"[\W_]+", "", text.casefold()), unit
