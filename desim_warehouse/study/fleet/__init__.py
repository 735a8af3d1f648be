"""How many robots and chargers a warehouse needs."""

from desim_warehouse.study.fleet.answers import FleetPlan, Shown, Sized, Strategy
from desim_warehouse.study.fleet.designs import Designs, refused
from desim_warehouse.study.fleet.plan import plan_fleet
from desim_warehouse.study.fleet.utilisation import utilisation

__all__ = ["Designs", "FleetPlan", "Shown", "Sized", "Strategy", "plan_fleet", "refused", "utilisation"]
