"""Subfleets: robots of kinds that share flows; no subfleet does the work of another."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from desim_warehouse.errors import spoken
from desim_warehouse.model.schema import Model
from desim_warehouse.model.sections.flows import FlowSpec


@dataclass(frozen=True)
class Subfleet:
    """Robots of some kinds ("": of none), by number, and the flows that they do and no other robot does."""

    kinds: tuple[str, ...]
    flows: tuple[str, ...]
    robots: tuple[int, ...]

    @property
    def name(self) -> str:
        """Its kinds, for the name of its robots: `kind small`, `kinds a and b`, `no kind`."""
        named = [kind for kind in self.kinds if kind]
        words = [f"kind{'s' * (len(named) > 1)} {spoken(named)}"] if named else []
        return spoken([*words, *["no kind"] * ("" in self.kinds)])


def flows_of(model: Model, kind: str) -> dict[str, FlowSpec]:
    """Return the flows whose tasks robots of a kind do."""
    fleet = model.fleet
    carries = fleet.robots()[fleet.kinds_of_robots().index(kind)].carries
    return {
        name: flow
        for name, flow in model.tasks.flows.items()
        if (not flow.kinds or kind in flow.kinds) and (not carries or not flow.load_type or flow.load_type in carries)
    }


@lru_cache(maxsize=64)
def subfleets(model: Model) -> tuple[Subfleet, ...]:
    """Return the subfleets; none where all robots share their work, as where goods are listed or stand on pods."""
    if not model.tasks.flows or model.pods is not None:
        return ()
    kinds, parts = model.fleet.kinds_of_robots(), list[tuple[set[str], set[str]]]()
    for kind in dict.fromkeys(kinds):
        flows = set(flows_of(model, kind))
        joined = [part for part in parts if part[1] & flows]
        parts = [part for part in parts if part not in joined]
        parts.append(({kind}.union(*(others for others, _ in joined)), flows.union(*(theirs for _, theirs in joined))))
    if len(parts) == 1:
        return ()
    return tuple(
        Subfleet(
            tuple(kind for kind in dict.fromkeys(kinds) if kind in mine),
            tuple(name for name in model.tasks.flows if name in flows),
            tuple(robot for robot, kind in enumerate(kinds) if kind in mine),
        )
        for mine, flows in parts
    )
