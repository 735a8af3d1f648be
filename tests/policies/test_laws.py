"""What holds for every policy on random warehouses; that all work is done and no battery runs flat is in tests/laws."""

import json
import os
import subprocess
import sys

import pytest

from desim_warehouse import load, simulate
from tests.laws.features import warehouse

ONE_RUN = """
import hashlib, json, sys
from desim_warehouse import load, simulate

for world in json.load(sys.stdin):
    run = simulate(load(world), 3)
    print(hashlib.sha256(repr((run.record.rows, run.kpis)).encode()).hexdigest())
"""

pytestmark = pytest.mark.slow


def test_a_run_can_be_repeated():
    for number in range(20):
        model = load(warehouse(number, "policies"))
        assert simulate(model, 1).record.rows == simulate(model, 1).record.rows, number


def test_log_and_indicators_do_not_depend_on_the_hash_seed():
    drawn = [warehouse(number, "policies") for number in range(6)]
    logs = {
        subprocess.run(
            [sys.executable, "-c", ONE_RUN],
            input=json.dumps(drawn),
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("0", "4242")
    }
    assert len(logs) == 1
    assert len(logs.pop().split()) == len(drawn)
