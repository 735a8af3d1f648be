"""The design of a study: which models are simulated. Points come from factors by a rule.

A study file, such as studies/fleet_size.yaml; only `model` must be there:

    name: Fleet size                       # for tables and figures
    description: one or two sentences
    model: ../models/multibots.yaml        # a model file, relative to the study file; or a whole model
    set:                                   # changes to the model, for all runs, as `--set` makes them
      tasks.goods: {random: 20}
    factors:                               # what is varied: any key of a model, and its values
      fleet.size: 1..6                     # whole numbers, both ends; 1..12..2 in steps of 2
      battery.threshold: [2, 3.5, 5]       # a list; ranges such as 1..3 may stand in it
      battery.capacity: {linspace: [5, 20, 4]}    # 4 values from 5 to 20
      policies.charging:                   # whole policies, with parameters
        - threshold
        - {name: opportunity, margin: 1}
      tasks.goods:                         # values with names: tables and figures show the names
        named: {group 1: [11, 8, 39], group 2: [74, 50, 62]}
      demand:                              # several keys changed together; the factor has a name of its own
        cases:
          today: {tasks.goods: {poisson: 200}}
          plus 30 %: {tasks.goods: {poisson: 260}, fleet.size: 6}
    design: grid                           # all combinations (default); or
                                           # paired: first values of all factors, then second values, ...
                                           # {latin-hypercube: 50}, {sobol: 64}: so many points; then a factor may
                                           #   also be {between: [2, 5]} (whole numbers if both ends are whole;
                                           #   {between: [2.0, 5.0]} is continuous)
                                           # {saltelli: 64}: for Sobol indices, 64 x (factors + 2) points
    replications: 20                       # a number; or until the mean is known well enough:
    # replications: {indicator: T, half_width: 2 %, confidence: 0.95, minimum: 10, cap: 200}
    seed: 0                                # replication r has the same run seed at every point
    indicators: [T, S, C]                  # columns of the table; default: all
    baseline: {fleet.size: 3}              # the design that others are compared with; default: the first
    confidence: 0.95
    timeout: 60                            # seconds that a run may take; default: no limit
"""
