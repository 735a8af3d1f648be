"""Every policy of the package, and the worked examples, pass the contract of their kind."""

from pathlib import Path

import pytest

from desim_warehouse import contracts
from desim_warehouse.policies.catalogue import OURS
from tests.policies.ours import required

EXAMPLES = Path(__file__).parents[2] / "studies" / "my_policies.py"
KINDS = {
    "allocation": contracts.AllocationContract,
    "routing": contracts.RoutingContract,
    "charging": contracts.ChargingContract,
    "parking": contracts.ParkingContract,
    "batching": contracts.BatchingContract,
    **{
        kind: type(f"Of{kind}", (contracts.PodsContract,), {"decides": kind})
        for kind in ("pod", "storage", "order_station", "put")
    },
}
CASES = [
    (contract, test, name)
    for kind, contract in KINDS.items()
    for name in [*OURS[kind], *([f"{EXAMPLES}:Patient", f"{EXAMPLES}:Lottery"] if kind == "allocation" else [])]
    for test in sorted(dir(contract))
    if test.startswith("test_")
]


@pytest.mark.parametrize(("contract", "test", "name"), CASES, ids=lambda item: str(item).rpartition("/")[2][:40])
def test_every_policy_keeps_its_contract(contract, test, name):
    case = type("Case", (contract,), {"name": name})()
    case.parameters = required(case.kind, name)
    getattr(case, test)()


IN_TURNS = """import os
        turn = int(os.environ["TURN"]) % len(situation.robots)
        os.environ["TURN"] = str(turn + 1)
        some = [*situation.robots[turn:], *situation.robots[:turn]]
        return [(r.number, t.number) for r, t in zip(some, situation.tasks) if situation.feasible(r, t)]"""
"""Another robot is the first in each decision, whatever the seed: what it knows outlives a run."""


def broken(tmp_path, body, kind="allocation", method="assign(self, situation)"):
    path = tmp_path / "mine.py"
    path.write_text(f"class Mine:\n    def {method}:\n        {body}\n")
    contract = KINDS[kind]
    return type("Case", (contract,), {"name": f"{path}:Mine"})()


@pytest.mark.parametrize(
    ("body", "test"),
    [
        ("return [(situation.robots[0].number, t.number) for t in situation.tasks] * 2", "answers_can_be_carried_out"),
        ("return [(0, 999)]", "answers_can_be_carried_out"),
        (IN_TURNS, "the_same_seed_gives_the_same_log"),
        ("situation.robots.clear(); return []", "the_situation_is_left_as_it_was"),
    ],
)
def test_the_contract_finds_faults(tmp_path, monkeypatch, body, test):
    monkeypatch.setenv("TURN", "0")
    with pytest.raises(AssertionError):
        getattr(broken(tmp_path, body), f"test_{test}")()


@pytest.mark.parametrize(
    ("body", "test", "message"),
    [
        ("return [TaskBatch(tuple(t.number for t in waiting.tasks))]", "batches_can_be_carried", "nobody carries"),
        ("return [TaskBatch((0,)), TaskBatch((0,))]", "batches_can_be_carried", "in two batches"),
        ("return []", "the_last_tasks_do_not_wait_for_others", "not every task"),
        (
            "return [TaskBatch((t.number,), 1e400) for t in waiting.tasks]",
            "the_last_tasks_do_not_wait_for_others",
            "never",
        ),
        ("waiting.tasks.pop(); return []", "the_same_tasks_give_the_same_batches", "changed"),
    ],
)
def test_the_contract_of_batching_finds_faults(tmp_path, body, test, message):
    body = f"from desim_warehouse.policies import TaskBatch\n        {body}"
    with pytest.raises(AssertionError, match=message):
        getattr(broken(tmp_path, body, "batching", "batches(self, waiting)"), f"test_{test}")()


def test_the_contracts_find_faults_of_the_other_kinds(tmp_path):
    with pytest.raises(AssertionError, match="leaves the edges"):
        broken(
            tmp_path, "return [origin, goal]", "routing", "route(self, origin, goal, roads)"
        ).test_every_way_leads_along_edges_from_origin_to_goal()
    with pytest.raises(AssertionError, match="none of the given bays"):
        broken(
            tmp_path, "return robot.node", "parking", "choose(self, robot, bays, travel)"
        ).test_the_bay_is_one_of_those_shown()
