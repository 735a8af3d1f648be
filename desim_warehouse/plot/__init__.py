"""Figures: functions of plain tables or a Run that return matplotlib Axes.

| you want to see                                | call                    | from                         |
|------------------------------------------------|-------------------------|------------------------------|
| an indicator by a factor, with intervals       | `by_factor`             | study table                  |
| the same for each level of a further factor    | `facets`                | study table                  |
| throughput by fleet size, and its knee         | `throughput`            | study table                  |
| what robots do                                 | `utilisation`, `gantt`  | Run (`utilisation`: or table) |
| how a run went by the clock                    | `day`                   | Run                          |
| batteries                                      | `battery`               | Run                          |
| where robots wait                              | `congestion`            | Run                          |
| the warehouse                                  | `layout`                | Model or Run                 |
| where the warm-up ends                         | `warm_up`               | Run or observations          |
| the same in Welch's plot                       | `welch`                 | `settle(model)` or observations |
| a real day over simulated ones                 | `real_day`              | `dw.validate`                |
| edges, real against simulated, and on the floor | `passages`, `residuals` | `dw.validate`               |
| measured times and fitted distributions        | `fitted`                | `fit.Fitted`                 |

Every function takes `title` (none by default), `style` ("light" for screens, "print" for papers) and `ax` (axes
to draw on; default: those of a new figure, which is `ax.figure`). `model` gives the axes their units. Nothing here
touches pyplot or leaves settings behind; in Jupyter the Axes at the end of a cell are shown.
"""

from __future__ import annotations

from desim_warehouse.look.palette import COLOURS
from desim_warehouse.plot.course import day
from desim_warehouse.plot.days import fitted, passages, real_day, residuals
from desim_warehouse.plot.factors import by_factor, facets, throughput
from desim_warehouse.plot.fleet import battery, gantt, utilisation
from desim_warehouse.plot.floor import layout
from desim_warehouse.plot.heat import congestion
from desim_warehouse.plot.series import warm_up, welch

__all__ = [
    "COLOURS",
    "battery",
    "by_factor",
    "congestion",
    "day",
    "facets",
    "fitted",
    "gantt",
    "layout",
    "passages",
    "real_day",
    "residuals",
    "throughput",
    "utilisation",
    "warm_up",
    "welch",
]
