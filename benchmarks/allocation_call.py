"""What one allocation call costs with 1,000 free robots and 10,000 open tasks: `python -m benchmarks.allocation_call`.

Medians, as multiples of one scipy linear_sum_assignment of 200 x 1,000 in the same process.
"""

from __future__ import annotations

import json
import statistics
import time
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import linear_sum_assignment

from desim_warehouse import load
from desim_warehouse.learn.asktell import steps
from desim_warehouse.policies import create
from desim_warehouse.policies.catalogue import OURS

if TYPE_CHECKING:
    from collections.abc import Callable

MODEL = {
    "layout": {
        "blocks": {"columns": 39, "rows": 19, "block_depth": 8, "goods_size": 1, "aisle_width": 1},
        "bays": {"north": {"along": "north", "places": 30}},
    },
    "fleet": {"size": 1000, "robot": {"radius": 0.3, "speed": 1.5}},
    "tasks": {"goods": {"random": 10_000}, "unload_at": ["r19c20"], "load_time": 5, "unload_time": 5},
    "battery": {"capacity": 20_000, "threshold": 4000, "consumption": 1, "charge_rate": 10},
    "policies": {"charging": "reach-aware", "routing": "fastest"},
}
REPEATS = 5


def median(call: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median time of a call, in seconds."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def main() -> None:
    """One JSON object: seconds of the reference and, for every policy, multiples of it and pairs given out."""
    table = np.random.default_rng(1).random((200, 1000))
    reference = median(lambda: linear_sum_assignment(table), 15)
    decision = next(steps(load(MODEL), 1))
    result: dict[str, object] = {"linear_sum_assignment_200x1000_ms": round(reference * 1e3, 2)}
    for name in OURS["allocation"]:
        policy = create("allocation", name, {})
        pairs = len(list(policy.assign(decision.situation)))  # the distance oracle is warm from here on
        taken = median(lambda policy=policy: list(policy.assign(decision.situation)))  # type: ignore[misc]
        result[name] = {"multiple": round(taken / reference, 1), "ms": round(taken * 1e3, 1), "pairs": pairs}
    print(json.dumps(result, indent=2))


if __name__ == "__main__":
    main()
