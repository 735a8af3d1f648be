"""Statistics of the runs of a study: pure functions of numbers, without simulation or files.

| question                                        | function                                                     |
|-------------------------------------------------|--------------------------------------------------------------|
| what is the mean, and its interval?             | `intervals.estimate`                                         |
| how many replications?                          | `precision.replications_to_run`, `.replications_needed`      |
| does a design differ from today's?              | `comparison.paired`, `comparison.compare`                    |
| which design is best?                           | `selection.kn_steps`                                         |
| does a design meet a target?                    | `judge.Judge`, `judge.judged`                                |
| what is the smallest fleet that does it?        | `cheapest.cheapest_meeting_steps`, with one count            |
| does it meet the target, asked after every run? | `judge.looked_at`                                            |
| how many robots and chargers together?          | `cheapest.cheapest_meeting_steps`, `cheapest.scout_steps`    |
| where does more stop paying?                    | `knee.knee`, `knee.smallest_within`                          |
| when does the warm-up end?                      | `warmup.mser`, `warmup.welch`                                |
| which value do 95 % of the days stay below?     | `intervals.quantile`                                         |
| what do measured times follow?                  | `study.fit.fit`                                              |
| which of several changes gains most?            | `effects.gains_steps`                                        |
| which factor matters?                           | `screening.main_effects`                                     |

Searches choose the next runs by the results of the runs before. Each is a generator that yields a batch of runs and is
sent their values, so that the batch can be spread over workers; `follow` carries out such a procedure.
"""
