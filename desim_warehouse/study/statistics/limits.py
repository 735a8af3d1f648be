"""The most that a study accepts. Anything larger would run for days, or not fit into memory."""

from __future__ import annotations

MOST_LEVELS = 100_000
"""Values of one factor."""
MOST_POINTS = 1_000_000
"""Designs of one study."""
MOST_REPLICATIONS = 100_000
"""Runs of one design."""
MOST_RUNS = 1_000_000
"""Runs of one study."""
LEAST_DELTA = 1e-9
"""Indifference zone of a choice of the best design, in the indicator's unit."""
MOST_ZONE = 0.2
"""Indifference zone of a share, and else as a part of what is aimed at: a larger one calls nearly all designs alike."""
FIRST, CAP = 5, 40
"""Replications at the first look at a design, and the most of them, by default."""
FIRST_OF_MEANS = 10
"""Replications at the first look at what has no upper end, such as a time: fewer do not show how skewed it is."""
RACED = 10, 1000
"""The first look and the cap of a race of designs, of which all but the best drop out."""
RELIEVED = 5, 160
"""Those of the suspects of a bottleneck."""
PLAN_RUNS, SEARCH_RUNS = 5000, 500
"""The most runs of a plan, and of a search of designs, by default."""
MOST_YEARS = 20
"""Years that a plan looks ahead."""
