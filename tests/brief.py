"""Short probes, for tests of what a check says and not of its figures: a fifth of the tasks leads to the same words."""

from functools import lru_cache

from desim_warehouse.run import examined, probe, quick, together

FEWER = (
    (probe, "LOOKS", (50, 100)),
    (probe, "MOST", 200),
    (probe, "CALM", 30),
    (together, "TASKS", 100),
    (quick, "TASKS", 100),
)
"""How many tasks a probe takes, and a fleet that works together."""
KEPT = ((probe, "_probe"), (probe, "_calm"), (together, "_pace"), (examined, "_examined"))
"""What keeps measurements."""
OWN = [(module, name, lru_cache(getattr(module, name).__wrapped__)) for module, name in KEPT]
"""Each with a memory of its own, so that no other test is given short ones."""


def probe_briefly(monkeypatch):
    for module, name, value in (*FEWER, *OWN):
        monkeypatch.setattr(module, name, value)
