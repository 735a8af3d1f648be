"""What it would save to have fast movers nearest to the stations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from desim_warehouse.findings import amount
from desim_warehouse.model.sections.goods import Popularity

if TYPE_CHECKING:
    from collections.abc import Callable

    from desim_warehouse.model import Model

_LEAST = 0.01
"""Part of a task's time that is worth a line."""


def nearer(model: Model) -> dict[str, Any]:
    """The overrides by which classes that lie otherwise lie by distance; none where there is nothing to move."""
    if model.pods is not None:
        return {}
    return {
        ".".join(("tasks", *keys, "by")): "distance"
        for keys, popularity in model.tasks.popularities()
        if isinstance(popularity, Popularity) and popularity.classes and popularity.by != "distance"
        if not any("." in key for key in keys)
    }


def lines(model: Model, time_of_task: Callable[[Model], float]) -> list[str]:
    """What a task takes less with fast movers nearer, in a line; none where nothing is to be gained."""
    from desim_warehouse.errors import ModelError

    changes = nearer(model)
    try:
        moved = model.replace(changes) if changes else None
    except ModelError:  # no station is near
        return []
    if moved is None:
        return []
    now, then = map(time_of_task, (model, moved))
    if now - then < _LEAST * now:
        return []
    saved = f"{amount(now - then)} of {amount(now)} {model.units.time} a task"
    return [f"fast movers nearest to the stations save {saved}, by estimate: {', '.join(changes)}: distance"]
