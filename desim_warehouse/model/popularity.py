"""How the demand is spread over the storage places."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from desim_warehouse.model.schema import Popularity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.layout.layout import StoragePlace


def shares(popularity: Popularity | Literal["uniform", "layout"], storage: Sequence[StoragePlace]) -> Any:
    """The share of every storage place in the demand for drawn goods, a numpy array; None: all alike."""
    import numpy as np

    if popularity == "uniform":
        return None
    if isinstance(popularity, Popularity) and popularity.classes:
        weights = np.empty(len(storage))
        begin, share = 0, 0.0
        for item in popularity.classes:
            share += item.share
            end = round(share * len(storage))
            weights[begin:end] = item.demand / max(end - begin, 1)
            begin = end
    elif isinstance(popularity, Popularity):
        weights = np.array(popularity.weights, dtype=float)
    else:
        weights = np.array([place.popularity for place in storage])
    return weights / weights.sum()
