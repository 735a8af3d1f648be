"""The graph that a routing policy of the user's own sees, in which a misspelt attribute of edges is an error.

Algorithms of networkx take 1 for a weight that an edge does not have, so that `weight="lenght"` counts edges unnoticed.
"""

from __future__ import annotations

from typing import Any

import networkx as nx

from desim_warehouse.errors import nearest

_ATTRIBUTES = ("length", "speed")
_USUAL = "weight"
"""The weight that networkx looks for where nobody names one."""


class _EdgeData(dict[str, Any]):
    def get(self, key: str, default: Any = None) -> Any:
        """The attribute; raises KeyError for one that no edge has."""
        if key not in self and key not in _ATTRIBUTES and key != _USUAL:
            near = nearest(key, _ATTRIBUTES)
            raise KeyError(f"edges have no {key!r}, {f'did you mean {near!r}?' if near else 'but length and speed'}")
        return super().get(key, default)


def strict_graph(graph: nx.DiGraph) -> nx.DiGraph:
    """A copy of a graph whose edges know only the attributes that they have, length and speed."""
    strict = nx.DiGraph()
    strict.edge_attr_dict_factory = _EdgeData
    strict.add_nodes_from(graph.nodes(data=True))
    strict.add_edges_from(graph.edges(data=True))
    return strict
