"""Large files of something else: they are refused before all of them is read, which would take minutes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ruamel.yaml.composer import Composer

from desim_warehouse.errors import ModelError
from desim_warehouse.model.messages import Keys, dotted, printable

_LONGEST = 100  # characters of a key in the message
_MOST_STRANGE = 1000
"""Unknown keys, and values in them, that are read: more than there can be by slips."""


def watching(is_key: Callable[[Keys], bool], source: str) -> type[Composer]:
    """Make a composer of the YAML reader that stops where too many values are not at keys of ours."""

    class Watching(Composer):
        """Composes nodes and knows the path to each."""

        def __init__(self, loader: Any = None) -> None:
            super().__init__(loader=loader)
            self.path: list[str | int] = []
            self.strange = 0  # values so far at unknown keys, or within
            self.inside = False  # of the value at an unknown key

        def compose_node(self, parent: Any, index: Any) -> Any:
            """Compose a node, or stop at too many values at unknown keys; `index` is None for a key and the whole."""
            if index is None:
                return super().compose_node(parent, index)
            self.path.append(getattr(index, "value", index))
            before = self.inside
            self.inside = before or not (isinstance(index, int) or is_key(tuple(map(str, self.path))))
            self.strange += self.inside
            if self.strange > _MOST_STRANGE:
                mark, key = self.parser.peek_event().start_mark, printable(dotted(tuple(self.path))[:_LONGEST])
                complaint = f"{key}: unknown, as are {_MOST_STRANGE:,} values before it; is this another kind of file?"
                raise ModelError([f"{source}:{mark.line + 1}:{mark.column + 1}: {complaint}"])
            node = super().compose_node(parent, index)
            self.inside = before
            self.path.pop()
            return node

    return Watching
