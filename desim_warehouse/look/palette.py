"""Colours of figures and pages.

For `plot`, the replay, the live page and pages of answers.
"""

from __future__ import annotations

from desim_warehouse.states import ROLES, TIMES

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8C8C00")
"""Okabe & Ito (2008), Color Universal Design, darkest first for lines on white; yellow is darkened to be visible."""
STATE_COLOURS = {state.name: state.colour for state in sorted(TIMES.values(), key=lambda state: state.stacked)}
"""Colours of the states of a robot in figures, in the order in which they are stacked."""
INK, FAINT = "#222222", "#777777"
PAGE = {
    "light": {
        "back": "#f2f4f6",
        "panel": "#ffffff",
        "ink": "#16202a",
        "soft": "#51606e",
        "line": "#c9d1d9",
        "accent": "#0062a3",
        "second": "#b35100",
        "charge": "#00735a",
        "a": "#0062a3",
        "b": "#d55e00",
        "one": "#6d3fb8",
        "two": "#0f766e",
    },
    "dark": {
        "back": "#0e1216",
        "panel": "#171c22",
        "ink": "#e8edf2",
        "soft": "#a3b0bd",
        "line": "#36414c",
        "accent": "#6cb8f0",
        "second": "#ff9d57",
        "charge": "#2fc79b",
        "a": "#56b4e9",
        "b": "#ff8a3d",
        "one": "#c9a4ff",
        "two": "#5fd3c4",
    },
}
"""Colours of a page around its figures, on a light or dark ground.

`second`: stations; `charge`: chargers; `a`, `b`: two designs compared; `one`, `two`: two runs side by side, in colours
without another meaning.
"""

GROUND = {
    "light": {
        "back": "#eceff2",
        "floor": "#ffffff",
        "border": "#8995a1",
        "aisle": "#aab4be",
        "ink": "#16202a",
        "soft": "#51606e",
        "bar": "#b9c3cc",
        "barLine": "#16202a",
        "outline": "#16202a",
        "label": "#ffffff",
        "bay": "#e3efe8",
        "bayLine": "#5c7a69",
        "out": "#f4e9dc",
        "outLine": "#8a6a3f",
        "cell": "#ffffff",
        "wall": "#c6ced6",
    },
    "dark": {
        "back": "#0b0e12",
        "floor": "#1a2027",
        "border": "#5b6874",
        "aisle": "#55616d",
        "ink": "#e8edf2",
        "soft": "#a3b0bd",
        "bar": "#4a5560",
        "barLine": "#e8edf2",
        "outline": "#f2f5f8",
        "label": "#ffffff",
        "bay": "#1d2b25",
        "bayLine": "#7fa38f",
        "out": "#2f271d",
        "outLine": "#c09b68",
        "cell": "#1a2027",
        "wall": "#3a4651",
    },
}
"""Colours of the floor of a replay page on a light or dark ground."""

_SAFE = {
    "light": {
        **{role: light for role, (light, _) in ROLES.items()},
        "shut": "#8c6d1f",
        "person": "#c2185b",
        "good": "#a0418a",
        "pod": "#8f9ba6",
        "none": "#dfe5ea",
        "low": "#d55e00",
        "full": "#00735a",
        "ring": "#7a7a00",
    },
    "dark": {
        **{role: dark for role, (_, dark) in ROLES.items()},
        "shut": "#b8912f",
        "person": "#ff6fa5",
        "good": "#e58fcb",
        "pod": "#66737f",
        "none": "#2b343d",
        "low": "#ff8a3d",
        "full": "#2fc79b",
        "ring": "#d5d53a",
        "label": "#0b0e12",
    },
}
PALETTES = {
    "safe": _SAFE,
    "paper": {
        "light": _SAFE["light"]
        | {
            "empty": "#0000ff",
            "loaded": "#ff0000",
            "idle": "#008000",
            "charging": "#008000",
            "good": "#ff0000",
            "low": "#ff0000",
            "full": "#008000",
            "ring": "#c000c0",
        },
        "dark": _SAFE["dark"]
        | {
            "empty": "#6f8dff",
            "loaded": "#ff4d4d",
            "idle": "#3ddc5a",
            "charging": "#3ddc5a",
            "good": "#ff3b3b",
            "low": "#ff4d4d",
            "full": "#3ddc5a",
            "ring": "#ff7bff",
        },
    },
}
"""Colours of robots, by the role of their state, and of goods and people, on a light or dark ground.

`safe`: distinguishable for colour-blind people (after Okabe and Ito); `paper`: the colours of the paper.
"""

COURSE = {
    "light": {
        "work": "#0062a3",
        "queue": "#a0418a",
        "traffic": "#b8860b",
        "picker": "#c2185b",
        "charging": "#00735a",
        "empty": "#d55e00",
        "broken": "#22272c",
        "free": "#c9d1d9",
        "off": "#e6eaee",
        "delivered": "#0062a3",
        "open": "#8995a1",
        "battery": "#7d8f4e",
    },
    "dark": {
        "work": "#3f93d0",
        "queue": "#e58fcb",
        "traffic": "#ffd34d",
        "picker": "#ff6fa5",
        "charging": "#2fc79b",
        "empty": "#ff8a3d",
        "broken": "#f2f5f8",
        "free": "#4a5560",
        "off": "#2b343d",
        "delivered": "#3f93d0",
        "open": "#7d8a97",
        "battery": "#a9b96f",
    },
}
"""Colours of curves over time on a light or dark ground: activities of robots (`outcome.day.DOING`), and others."""

WAITED_STEPS = (0.01, 0.05, 0.2)
"""Lower bounds of the colour steps of waiting maps: shares of the time in which a robot waits at a place.

They are equal for all floors, so that a map with little waiting does not look jammed. Below the first step there is no
colour.
"""
HEAT = {
    "light": ["#b8860b", "#d1491a", "#7a0f2b"],
    "dark": ["#b98f2f", "#ff9a4d", "#fff0c2"],
}
"""Colours of the steps of waiting maps, by ground."""
NO_WAIT = "#DDDDDD"
"""Colour of places with hardly any waiting, in figures on white."""
BAY, CHARGER, STATION = GROUND["light"]["bayLine"], PAGE["light"]["charge"], GROUND["light"]["outLine"]
"""Colours of places in figures, as on pages."""
