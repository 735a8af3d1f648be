"""Short probes, and fits with few samples, for tests of what is said and not of figures.

A tenth of the tasks of a probe leads to the same words.
"""

from functools import lru_cache

from desim_warehouse.run import examined, probe, quick, together
from desim_warehouse.study.fleet import loads

FEWER = (
    (probe, "LOOKS", (25, 50)),
    (probe, "MOST", 100),
    (probe, "CALM", 15),
    (together, "TASKS", 50),
    (quick, "TASKS", 50),
)
"""How many tasks a probe takes, and a fleet that works together."""
KEPT = (
    (probe, "_probe"),
    (probe, "_calm"),
    (together, "_pace"),
    (examined, "_examined"),
    (loads, "_quick_estimate"),
)
"""What keeps measurements."""
OWN = [(module, name, lru_cache(getattr(module, name).__wrapped__)) for module, name in KEPT]
"""Each with a memory of its own, so that no other test is given short ones."""

FEWER_SAMPLES = 39
"""Of the test of a fit: they can say 0.05, and 0.025 at the least."""


def probe_briefly(monkeypatch):
    for module, name, value in (*FEWER, *OWN):
        monkeypatch.setattr(module, name, value)
