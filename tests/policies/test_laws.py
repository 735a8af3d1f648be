"""What holds for every policy on random small worlds."""

import json
import os
import subprocess
import sys

from hypothesis import HealthCheck, given, settings

from desim_warehouse import load, simulate
from tests.policies.worlds import worlds

ONE_RUN = """
import hashlib, json, sys
from desim_warehouse import load, simulate
for world in json.load(sys.stdin):
    run = simulate(load(world), 3)
    print(hashlib.sha256(repr(run.record.rows).encode()).hexdigest())
"""


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(worlds())
def test_all_work_is_done_no_battery_runs_flat_and_a_run_can_be_repeated(world):
    model = load(world)
    run = simulate(model, 1)
    done = sorted(row[3] for row in run.record.rows if row[1] == "delivered")
    assert done == list(range(len(world["tasks"]["goods"])))
    assert run.record.rows == simulate(model, 1).record.rows


def test_the_log_does_not_depend_on_the_hash_seed(tmp_path):
    drawn = []

    @settings(max_examples=25, deadline=None, database=None, derandomize=True)
    @given(worlds())
    def draw(world):
        drawn.append(world)

    draw()
    logs = {
        subprocess.run(
            [sys.executable, "-c", ONE_RUN],
            input=json.dumps(drawn),
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("0", "1", "4242")
    }
    assert len(logs) == 1
    assert len(logs.pop().split()) == len(drawn)
