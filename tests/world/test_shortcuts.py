"""What is asked once because the answer cannot change gives the same run as asking every time."""

import pytest

import desim_warehouse as dw
from desim_warehouse.layout.oracle import RouteOracle
from desim_warehouse.policies.catalogue import OURS, find
from desim_warehouse.policies.routing import CongestionAware
from tests.policies.ours import every
from tests.world.test_determinism import BUSY, LIFELONG


def rows(changes):
    return dw.simulate(dw.load(BUSY, {**LIFELONG, **changes}), seed=5).record.rows


def ask_every_time(monkeypatch):
    for kind in ("routing", "charging"):
        for name in OURS[kind]:
            monkeypatch.setattr(find(kind, name), "fixed", False, raising=False)
    kept = RouteOracle.way
    monkeypatch.setattr(RouteOracle, "way", lambda oracle, *asked: oracle._way.cache_clear() or kept(oracle, *asked))


@pytest.mark.parametrize(
    "changes",
    [
        {"policies.routing": {"name": "congestion-aware", "detours": 1}},
        *(
            pytest.param({"policies.routing": {"name": "congestion-aware", "detours": detours}}, marks=pytest.mark.long)
            for detours in (0, 3)
        ),
        *({"policies.routing": policy} for policy in every("routing")),
        {"policies.routing": {"name": "shortest", "spread": 3}},
        *({"policies.charging": policy} for policy in every("charging")),
    ],
    ids=str,
)
def test_a_run_is_the_same_when_every_policy_is_asked_every_time(changes, monkeypatch):
    once = rows(changes)
    ask_every_time(monkeypatch)
    assert rows(changes) == once


@pytest.mark.parametrize("detours", [0, 3])
def test_which_would_not_hold_for_routes_that_go_by_the_traffic(detours, monkeypatch):
    changes = {"policies.routing": {"name": "congestion-aware", "detours": detours}}
    asked = rows(changes)
    monkeypatch.setattr(CongestionAware, "fixed", True, raising=False)
    assert rows(changes) != asked
