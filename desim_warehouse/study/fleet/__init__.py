"""Fleet sizing: how many robots and chargers a warehouse needs."""

from desim_warehouse.study.fleet.designs import Designs, OneKey
from desim_warehouse.study.fleet.loads import loads_at
from desim_warehouse.study.fleet.one_key import size_key
from desim_warehouse.study.fleet.options import ComparedOptions, compare_options
from desim_warehouse.study.fleet.plan import size_fleet
from desim_warehouse.study.fleet.sizes import FleetSizes, Shown, Sized, Strategy

__all__ = [
    "ComparedOptions",
    "Designs",
    "FleetSizes",
    "OneKey",
    "Shown",
    "Sized",
    "Strategy",
    "compare_options",
    "loads_at",
    "size_fleet",
    "size_key",
]
