"""Routing policies: which way a robot drives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    import networkx as nx


@dataclass(frozen=True)
class Highways:
    """Algorithm 1 of the paper: breadth-first, fewest nodes; of several ways the first in the successors' order."""

    def route(self, origin: str, goal: str, highways: nx.DiGraph) -> Sequence[str]:
        """The nodes from origin to goal, both included."""
        import networkx as nx

        before = dict(nx.bfs_predecessors(highways, origin))
        way = [goal]
        while way[-1] != origin:
            way.append(before[way[-1]])
        return way[::-1]
