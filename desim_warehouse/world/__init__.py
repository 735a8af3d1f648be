"""The mechanism: robots as SimPy processes on one-way lanes. Read `robot` first, then `traffic`."""

from desim_warehouse.world.world import World

__all__ = ["World"]
