"""How many robots and chargers a warehouse needs."""

from desim_warehouse.study.fleet.answers import FleetPlan, Shown, Sized, Strategy
from desim_warehouse.study.fleet.designs import Designs, refused
from desim_warehouse.study.fleet.options import OptionsPlan, plan_options
from desim_warehouse.study.fleet.plan import plan_fleet
from desim_warehouse.study.fleet.utilisation import utilisation

__all__ = [
    "Designs",
    "FleetPlan",
    "OptionsPlan",
    "Shown",
    "Sized",
    "Strategy",
    "plan_fleet",
    "plan_options",
    "refused",
    "utilisation",
]
