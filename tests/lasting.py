"""Batteries that last, for tests of something else: they need no long run of each fleet in which they settle."""

LASTING = {"fleet.start_energy": 1, "battery.consumption": 1e-4}
