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
