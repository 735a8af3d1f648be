"""Contract tests for policies: inherit one of these classes in a test file, name your policy, run pytest.

    from desim_warehouse.contracts import AllocationContract

    class TestMine(AllocationContract):
        name = "my_policies.py:Mine"
        parameters = {"patience": 60}

Every policy of this package passes the contract of its kind. The tests simulate a small warehouse with
batteries, two stations and few chargers; set `model` to run them on yours.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, ClassVar

from desim_warehouse.model import Model
from desim_warehouse.policies import WaitingTasks
from desim_warehouse.run import RunData

EXAMPLE: Mapping[str, Any] = {
    "name": "contract",
    "layout": {
        "blocks": {"columns": 3, "rows": 2, "block_depth": 3, "goods_size": 2, "aisle_width": 2},
        "bays": {
            "chargers": {"at": ["A"], "places": 2, "chargers": 1},
            "parking": {"at": ["B", "D"], "places": 4, "chargers": 0},
        },
    },
    "fleet": {"size": 4, "start": ["B", "D", "A"], "robot": {"radius": 0.4, "speed": 1}},
    "tasks": {
        "goods": [{"good": 5 * i % 36, "release": 15 * i, "due": 300 + 20 * i} for i in range(16)],
        "unload_at": ["I", "L"],
        "station_choice": "nearest",
        "load_time": 5,
        "unload_time": 8,
        "clear_time": 1,
    },
    "battery": {
        "capacity": 300,
        "threshold": 120,
        "consumption": {"standing": 0.1, "empty": 1, "loaded": 1.5, "handling": 0.5},
        "charge_rate": 5,
    },
    "policies": {"charging": "reach-aware", "parking": "nearest", "routing": "fastest"},
}


class _Contract:
    kind: ClassVar[str]
    name: ClassVar[str]
    parameters: ClassVar[Mapping[str, Any]] = {}
    model: ClassVar[Mapping[str, Any]] = EXAMPLE

    def make(self) -> Any:
        """Return the policy under test."""
        from desim_warehouse.policies import create

        return create(self.kind, self.name, self.parameters)

    def given(self) -> Model:
        """Return the model with the policy in it."""
        from desim_warehouse.model import load

        return load(self.model, {f"policies.{self.kind}": {"name": self.name, **self.parameters}})

    def played(self, seed: int = 1) -> RunData:
        """Return a whole run with the policy."""
        from desim_warehouse.run import RunData

        return RunData.simulated(self.given(), seed)

    def test_a_run_ends_with_all_work_done(self) -> None:
        """Every task is delivered, once."""
        history = self.played().history
        done = [row.task for row in history.rows("delivered")]
        released = [row.task for row in history.rows("released")]
        assert sorted(done) == sorted(released), "tasks released and tasks delivered are not the same"

    def test_the_same_seed_gives_the_same_log(self) -> None:
        """A decision depends on nothing but its arguments and the policy's own random stream."""
        assert self.played().record.rows == self.played().record.rows, "two runs with one seed differ"


class AllocationContract(_Contract):
    """For allocation policies: what `assign` returns can be carried out, at every decision of a run."""

    kind = "allocation"

    def test_nothing_is_kept_from_one_run_to_the_next(self) -> None:
        """A run is the same after a single decision of another: a counter in the class, even or odd, would show."""
        from desim_warehouse.learn.asktell import steps

        first = self.played().record.rows
        list(self.make().assign(next(steps(self.given(), 1)).situation))
        assert self.played().record.rows == first, "something is kept between runs: two runs with one seed differ"

    def test_answers_can_be_carried_out(self) -> None:
        """Only robots and tasks of the situation, each task once, nothing that the charging policy forbids."""
        from desim_warehouse.learn.asktell import steps

        policy, made = self.make(), steps(self.given(), 1)
        for decision in made:
            answer = list(policy.assign(decision.situation))
            tasks = {task.number: task for task in decision.tasks}
            robots = {robot.number: robot for robot in decision.robots}
            assigned = [task for _, task in answer]
            assert len(assigned) == len(set(assigned)), f"a task is assigned twice: {answer}"
            assert set(assigned) <= set(tasks), f"a task that is not open is assigned: {answer}"
            first: set[int] = set()
            for number, task in answer:
                if number in robots and number not in first:
                    first.add(number)
                    assert decision.feasible(robots[number], tasks[task]), f"robot {number} may not take {task}"
            made.tell(answer)

    def test_the_situation_is_left_as_it_was(self) -> None:
        """A policy answers alike when it is asked again (except for policies that draw at random)."""
        from desim_warehouse.learn.asktell import steps

        policy = self.make()
        decision = next(steps(self.given(), 1))
        before = list(decision.situation.robots), list(decision.situation.tasks)
        list(policy.assign(decision.situation))
        assert before == (list(decision.situation.robots), list(decision.situation.tasks)), "the situation was changed"


class RoutingContract(_Contract):
    """For routing policies: every answer is a path along the edges."""

    kind = "routing"

    def test_every_way_leads_along_edges_from_origin_to_goal(self) -> None:
        """For all pairs of nodes, in an empty warehouse."""
        from desim_warehouse.world import World

        world = World(self.given(), 1)
        roads, graph, policy = world.routes.roads, world.layout.graph, self.make()
        for origin in graph:
            for goal in graph:
                way = list(policy.route(origin, goal, roads))
                assert way[0] == origin, f"{way} does not begin at {origin}"
                assert way[-1] == goal, f"{way} does not end at {goal}"
                assert all(graph.has_edge(*edge) for edge in pairwise(way)), f"{way} leaves the edges"


class ChargingContract(_Contract):
    """For charging policies: the levels make sense whatever the robot's energy."""

    kind = "charging"

    def test_levels_are_levels_of_the_battery(self) -> None:
        """Finite, in order, and no charging above the capacity."""
        from desim_warehouse.world import World

        world = World(self.given(), 1)
        policy, view = self.make(), world.robots[0].view()
        levels_by_energy = [policy.levels(view._replace(energy=view.capacity * part / 10)) for part in range(11)]
        for levels in levels_by_energy:
            assert levels.fault(view) is None, levels.fault(view)
        if getattr(policy, "fixed", False):
            assert len(set(levels_by_energy)) == 1, "levels of a `fixed` policy depend on the energy"


class ParkingContract(_Contract):
    """For parking policies: the answer is one of the given bays."""

    kind = "parking"

    def test_the_bay_is_one_of_those_shown(self) -> None:
        """From every node, for every choice of two bays."""
        from itertools import combinations

        from desim_warehouse.policies import BayView
        from desim_warehouse.world import World

        world = World(self.given(), 1)
        policy, view = self.make(), world.robots[0].view()
        bays = [BayView(node, 1, 1, rank) for rank, node in enumerate(world.layout.graph)]
        for node in world.layout.graph:
            for shown in combinations(bays, 2):
                chosen = policy.choose(view._replace(node=node), shown, world.travel)
                assert chosen in {bay.node for bay in shown}, f"{chosen!r} is none of the given bays"


class PodsContract(_Contract):
    """For the four decisions of goods to person (pod, storage, order_station, put): name the kind in `decides`.

    What `choose` returns is one of what it is shown, which is checked at every decision of a run.
    """

    decides: ClassVar[str]
    model: ClassVar[Mapping[str, Any]] = {
        **{key: value for key, value in EXAMPLE.items() if key not in {"tasks", "battery"}},
        "layout": {**EXAMPLE["layout"], "stations": {"picking": {"at": ["I", "L"], "places": 2}}},
        "tasks": {
            "load_time": 2,
            "unload_time": 2,
            "flows": {
                "picks": {
                    "from": "storage",
                    "to": "picking",
                    "arrivals": {"schedule": [{"at": 0, "tasks": 12}, {"at": 200, "tasks": 8}]},
                    "lines": [1, 3],
                    "stop_time": 6,
                },
                "bundles": {
                    "from": "picking",
                    "to": "storage",
                    "arrivals": {"schedule": [{"at": 50, "tasks": 9}]},
                    "stop_time": 9,
                },
            },
        },
        "pods": {"count": 20, "items": 12, "per_pod": 5, "stock": 40, "orders": 3},
        "policies": {"parking": "nearest", "routing": "fastest"},
    }

    @property
    def kind(self) -> str:  # type: ignore[override]
        """The decision under test."""
        return self.decides

    def test_the_decisions_are_made_by_it_and_end_well(self) -> None:
        """Every pod is put down again where none stands, and every line is done at its station."""
        history = self.played().history
        stands: dict[int, int] = {}
        for row in history.rows("lifted", "stored"):
            pod = int(row.value or 0)
            if row.kind == "lifted":
                assert stands.pop(row.other, pod) == pod, f"pod {pod} is lifted where another stands"
            else:
                assert row.other not in stands, f"two pods on place {row.other}"
                stands[row.other] = pod
        assert not history.tasks.keys() - {task.number for task in history.delivered}, "a line is left"


class BatchingContract(_Contract):
    """For batching policies: every batch can be carried, and no task waits for ever."""

    kind = "batching"
    most: ClassVar[int] = 3
    """Loads that a robot carries."""
    model: ClassVar[Mapping[str, Any]] = {
        **EXAMPLE,
        "fleet": {**EXAMPLE["fleet"], "robot": {**EXAMPLE["fleet"]["robot"], "capacity": 3}},
        "battery": None,
    }

    def waiting(self, count: int, *, to_come: bool = False, after: float = 0.0) -> WaitingTasks:
        """Tasks released 10 apart, with the policy called `after` the last of them."""
        from desim_warehouse.policies import Task, WaitingTasks
        from desim_warehouse.world import World

        world = World(self.given(), 1)
        places = world.layout.storage
        tasks = [
            Task(number, place.number, place.edge, place.offset, 10.0 * number, order=str(number // 4))
            for number, place in enumerate(places[7 * number % len(places)] for number in range(count))
        ]
        return WaitingTasks(10.0 * count - 10 + after, tasks, self.most, to_come, world.travel)

    def test_batches_can_be_carried(self) -> None:
        """Only tasks that wait, each in one batch at most, no more of them than a robot carries."""
        policy = self.make()
        for count in range(1, 12):
            for to_come in (True, False):
                batches = list(policy.batches(self.waiting(count, to_come=to_come)))
                tasks = [number for batch in batches for number in batch.tasks]
                assert len(tasks) == len(set(tasks)), f"a task is in two batches: {batches}"
                assert set(tasks) <= set(range(count)), f"a task that does not wait is in a batch: {batches}"
                assert all(1 <= len(batch.tasks) <= self.most for batch in batches), (
                    f"one that nobody carries: {batches}"
                )

    def test_the_last_tasks_do_not_wait_for_others(self) -> None:
        """When no others are to come every task is in a batch, and the batch is made at some time."""
        import math

        policy = self.make()
        for count in range(1, 12):
            batches = list(policy.batches(self.waiting(count, after=1e6)))
            tasks = sorted(number for batch in batches for number in batch.tasks)
            assert tasks == list(range(count)), f"not every task is in a batch: {batches}"
            assert all(math.isfinite(batch.at) for batch in batches), f"a batch that is never made: {batches}"

    def test_the_same_tasks_give_the_same_batches(self) -> None:
        """An answer depends on what the policy is shown, and leaves that as it was."""
        policy, waiting = self.make(), self.waiting(7)
        before = list(waiting.tasks)
        assert list(policy.batches(waiting)) == list(policy.batches(waiting)), "the same tasks, other batches"
        assert list(waiting.tasks) == before, "the waiting tasks were changed"
