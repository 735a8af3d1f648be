"""Random plants: how often the interval of each figure holds what is true."""

from collections import defaultdict

import numpy as np
import pytest

from desim_warehouse.fleet_log.calibrate import calibrate
from tests.fleet_log import plants
from tests.fleet_log.conftest import plant

PLANTS = 200
LEAST = 0.88
"""Of each figure: 91 %, less what chance may take from it in 200 plants."""


@pytest.mark.long
def test_intervals_hold_what_is_true(tmp_path_factory):
    held = defaultdict(list)
    for seed in range(PLANTS):
        there = plant(tmp_path_factory.mktemp("plant"), seed)
        truth = plants.known(there.truth)
        for one in calibrate(there.sheet, [there.log]).estimates:
            key = "slow" if one.key.startswith("traffic.slow") else one.key
            if key in truth and np.isfinite(one.low):
                held[key].append(one.low <= truth[key] <= one.high)
        there.log.unlink()  # tens of megabytes
    shares = {key: np.mean(ones) for key, ones in held.items()}
    assert 0.93 <= np.mean([one for ones in held.values() for one in ones]) <= 0.97, shares
    assert min(shares.values()) >= LEAST, shares
