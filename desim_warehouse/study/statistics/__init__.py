"""Statistics of the runs of a study: pure functions of numbers, no simulation and no files.

| question                                       | function                                   |
|------------------------------------------------|--------------------------------------------|
| what is the mean, how sure?                    | `estimate`                                 |
| how many replications?                         | `replications_needed`, `check_precision`   |
| does a design differ from today's?             | `paired`, `compare`                        |
| which design is best?                          | `kn_steps`                                 |
| does a design meet a target?                   | `Judge`, `judged`, `parse_target`          |
| what is the smallest fleet that does it?       | `smallest_meeting_steps`                   |
| does it meet the target, asked after every run? | `looked_at`                               |
| how many robots and chargers together?         | `cheapest_meeting_steps`, `scout_steps`    |
| where does more stop paying?                   | `knee`, `smallest_within`                  |
| when does the warm-up end?                     | `mser`, `welch`                            |
| which value do 95 % of the days stay below?    | `quantile`                                 |
| what do measured times follow?                 | `fit`                                      |
| which of several changes gains most?           | `gains_steps`                              |
| which factor matters?                          | `main_effects`, `first_order`              |

Searches choose the next run from the runs before. They come as steps: a generator that asks for a batch of runs and is
sent their values, so that the batch can be spread over workers; `follow` carries one out.
"""

from __future__ import annotations

from desim_warehouse.study.statistics.cheapest import (
    NOTHING,
    Cheapest,
    Earlier,
    Larger,
    Sizing,
    cheapest_meeting_steps,
    line,
    scout_steps,
    smallest_meeting_steps,
)
from desim_warehouse.study.statistics.comparison import Comparison, Difference, compare, holm, paired
from desim_warehouse.study.statistics.effects import Gain, Gains, gains_steps
from desim_warehouse.study.statistics.intervals import (
    Estimate,
    QuantileEstimate,
    TaskShare,
    estimate,
    quantile,
    replications_for_quantile,
)
from desim_warehouse.study.statistics.judge import (
    GLANCE,
    MOST_TO_TELL,
    Budget,
    DesignVerdict,
    Judge,
    RunsEndedError,
    judged,
    looked_at,
    looks,
    looks_by,
    runs_to_tell,
    verdict_steps,
)
from desim_warehouse.study.statistics.knee import Knee, knee, smallest_within
from desim_warehouse.study.statistics.precision import (
    Precision,
    PrecisionRule,
    check_precision,
    replications_needed,
)
from desim_warehouse.study.statistics.procedure import Procedure, RunNumber, follow
from desim_warehouse.study.statistics.screening import (
    Between,
    FirstOrder,
    MainEffect,
    MainEffects,
    SaltelliDesign,
    SobolIndices,
    first_order,
    main_effects,
    saltelli_design,
    saltelli_indices,
)
from desim_warehouse.study.statistics.selection import Selection, kn_constants, kn_steps
from desim_warehouse.study.statistics.targets import Target, parse_target
from desim_warehouse.study.statistics.warmup import WarmUp, averaged, mser, welch

__all__ = [
    "GLANCE",
    "MOST_TO_TELL",
    "NOTHING",
    "Between",
    "Budget",
    "Cheapest",
    "Comparison",
    "DesignVerdict",
    "Difference",
    "Earlier",
    "Estimate",
    "FirstOrder",
    "Gain",
    "Gains",
    "Judge",
    "Knee",
    "Larger",
    "MainEffect",
    "MainEffects",
    "Precision",
    "PrecisionRule",
    "Procedure",
    "QuantileEstimate",
    "RunNumber",
    "RunsEndedError",
    "SaltelliDesign",
    "Selection",
    "Sizing",
    "SobolIndices",
    "Target",
    "TaskShare",
    "WarmUp",
    "averaged",
    "cheapest_meeting_steps",
    "check_precision",
    "compare",
    "estimate",
    "first_order",
    "follow",
    "gains_steps",
    "holm",
    "judged",
    "kn_constants",
    "kn_steps",
    "knee",
    "line",
    "looked_at",
    "looks",
    "looks_by",
    "main_effects",
    "mser",
    "paired",
    "parse_target",
    "quantile",
    "replications_for_quantile",
    "replications_needed",
    "runs_to_tell",
    "saltelli_design",
    "saltelli_indices",
    "scout_steps",
    "smallest_meeting_steps",
    "smallest_within",
    "verdict_steps",
    "welch",
]
