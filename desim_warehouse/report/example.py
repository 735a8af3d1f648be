"""A small warehouse as an example for reports."""

from __future__ import annotations

from desim_warehouse.draft import Draft, draft
from desim_warehouse.model import Model, load
from desim_warehouse.model.parse import read_yaml


def example() -> Model:
    """Return the model of a small warehouse that runs for an hour, with ten minutes of warm-up."""
    words = Draft(size=(16.0, 14.0), orders=60.0, due=2.5, name="an example")
    content = read_yaml(draft(words), "the example").data
    return load({**content, "run": {"length": 3600, "warm_up": 600}})
