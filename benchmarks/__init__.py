"""Measurements: how fast, how large, how well; each module has `report()`, a line of figures."""
