"""People who pick into robots: who walks where, who waits for whom, and until when, worked out by hand."""

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ModelError, StallError
from tests.accounting import faults
from tests.auditor import audit
from tests.recount import differences

RING = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, -10], "D": [0, -10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["A", "B"], "offset": offset} for offset in (5, 10, 15)],
        "bays": {"home": {"at": ["A"], "places": 4}},
        "stations": {"packing": {"at": ["C"], "places": 4, "servers": 1}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.4, "speed": 1, "margin": 0.2}},
    "tasks": {"goods": [0], "unload_at": ["packing"], "load_time": 7, "unload_time": 4},
    "pickers": {"count": 1, "speed": 0.5},
}
"""One way round, 20 x 10, at a speed of 1; people at half of that, one of them at the middle place at the start."""
AROUND = [{"edge": edge, "offset": offset} for edge, offset in ((["A", "B"], 5), (["C", "D"], 10), (["D", "A"], 5))]
BOTH = {"fleet.robot.capacity": 2, "policies.batching": "fixed-size"}


def ring(**changes):
    """A run of the ring; nothing impossible happens in it, and all is counted."""
    run = dw.simulate(dw.load(RING, {key.replace("__", "."): value for key, value in changes.items()}))
    assert audit(run) == []
    assert faults(run) == []
    assert differences(run) == []
    return run


def times(run, kind, robot=0):
    return [row.time for row in run.history.rows(kind) if row.robot == robot]


def walks(run):
    """Who walks when for which robot, and until when."""
    return [(one.picker, one.robot, one.start, one.end) for one in run.history.pickers_work if not one.picks]


def test_robot_waits_for_the_picker():
    """5 to the place, where the picker comes from 5 away at 15; 7 to pick, 25 to drive, 4 to unload, 30 home."""
    run = ring()
    assert times(run, "awaiting_picker") == [5]
    assert walks(run) == [(0, 0, 5, 15)]
    assert times(run, "loading") == [15]
    assert run.kpis["T"] == 22 + 25 + 4 + 30
    assert run.kpis["picker_walking"] == pytest.approx(10 / 81)
    assert run.kpis["picker_utilisation"] == pytest.approx(7 / 81)
    assert run.kpis["share_awaiting_picker"] == pytest.approx(10 / 81)
    assert run.kpis["lines_per_picker"] == pytest.approx(3600 / 81)


def test_robot_behind_one_that_waits_for_a_picker_waits_for_him_too():
    """1 behind the first until 22, it is at 15 m at 33; then the picker walks 10 m."""
    run = ring(tasks__goods=[0, 2], fleet__size=2)
    assert times(run, "awaiting_picker", 1) == [33]
    assert times(run, "loading", 1) == [53]
    assert run.kpis["T"] == 53 + 7 + 5 + 10 + 4 + 30
    lost = {row.root: row.time for row in run.lost_time.itertuples()}
    assert lost == {"awaiting_picker": (15 - 5) + (15 - 5) + (53 - 33), "loading": 22 - 15, "crossing": 1}
    assert dict(zip(run.lost_time["root"], run.lost_time["root_at"], strict=True))["awaiting_picker"] == ""


def test_nobody_waits_for_a_picker_who_is_there():
    """Two of them begin at 5 m and 15 m, where the robots stop."""
    run = ring(tasks__goods=[2, 0], fleet__size=2, pickers__count=2)
    assert run.kpis["picker_walking"] == run.kpis["share_awaiting_picker"] == 0
    assert run.kpis["T"] == 75


def test_picker_is_free_after_each_pick():
    """He sets out for the second place when the robot is there, 10 after the first pick."""
    run = ring(tasks__goods=[0, 2], **BOTH)
    assert walks(run) == [(0, 0, 5, 15), (0, 0, 32, 52)]
    assert run.kpis["T"] == 59 + 5 + 10 + 8 + 30


@pytest.mark.parametrize("how", [{"stay": "order"}, {"call": "ahead"}])
def test_picker_who_stays_or_is_sent_ahead_walks_while_the_robot_drives(how):
    """He sets out with the robot at 0 and is there at 10, 5 after it; for the second he walks 20 beside its 10."""
    run = ring(tasks__goods=[0, 2], **BOTH, pickers={"count": 1, "speed": 0.5, **how})
    assert walks(run) == [(0, 0, 0, 10), (0, 0, 17, 37)]
    assert times(run, "loading") == [10, 37]
    assert run.kpis["T"] == 44 + 5 + 10 + 8 + 30


def test_robot_waits_in_its_bay_for_a_picker_who_stays():
    """The second sets out when the first is picked at 17: he walks 20 for its drive of 15, and nobody is in the way."""
    run = ring(tasks__goods=[0, 2], fleet__size=2, pickers__stay="order")
    assert walks(run) == [(0, 0, 0, 10), (0, 1, 17, 37)]
    assert times(run, "awaiting_picker", 1) == [0, 32]
    assert times(run, "empty", 1) == [0, 17]
    assert run.robots["awaiting_picker"].tolist() == [5, 17 + 5]
    assert run.kpis["T"] == 44 + 5 + 10 + 4 + 30


@pytest.mark.parametrize(("choose", "loads"), [("nearest", (97, 147)), ("longest-waiting", (177, 127))])
def test_next_robot_is_the_nearest_or_the_one_that_waited_longest(choose, loads):
    """The picker is done at AB at 77. A robot has waited at CD, 25 m away, since 41, another at DA, 10 m, since 55."""
    goods = {"tasks.goods": [2, 1, 0], "tasks.load_time": 20, "layout.storage": AROUND, "fleet.size": 3}
    run = ring(**goods, pickers__choose=choose)
    assert times(run, "loading", 2) == [57]
    assert (*times(run, "loading", 0), *times(run, "loading", 1)) == loads


@pytest.mark.parametrize(("call", "then"), [("there", [(55, 75)]), ("ahead", [(33, 53)])])
def test_one_who_was_sent_ahead_is_called_to_a_robot_that_waits(call, then):
    """He stands at DA, where a robot comes at 55. Another waits at AB from 6 on, 10 m away, and is picked at 33."""
    storage = [AROUND[0], AROUND[2]]
    run = ring(tasks__goods=[1, 0], layout__storage=storage, fleet__size=2, pickers__call=call)
    own = [(start, end) for _, _, start, end in walks(run) if end > start]
    assert own == [(6, 26), *then]
    assert times(run, "loading", 0) == [max(then[0][1], 55)]


def test_pickers_finish_what_they_have_begun_when_their_hours_end():
    """From 5 on he is busy until 22, though his hours end at 12; the second robot waits from 33 until he is back."""
    hours = {"calendars": {"day": {"between": [[0, 12], [100, 200]]}}, "pickers.hours": "day"}
    run = ring(tasks__goods=[0, 2], fleet__size=2, **hours)
    assert walks(run) == [(0, 0, 5, 15), (0, 1, 100, 120)]
    assert run.kpis["T"] == 127 + 5 + 10 + 4 + 30
    assert run.kpis["picker_walking"] == pytest.approx((12 - 5 + 20) / (12 + 76))
    assert run.kpis["picker_utilisation"] == pytest.approx(7 / (12 + 76))
    assert run.kpis["lines_per_picker"] == pytest.approx(2 * 3600 / (12 + 76))


def test_run_says_that_pickers_never_come_again():
    model = dw.load(RING, {"calendars": {"day": {"between": [[0, 4]]}}, "pickers.hours": "day"})
    with pytest.raises(StallError, match="robots that wait for a picker, whose hours are over for good: 0"):
        dw.simulate(model)


def test_nobody_leaves_their_zone():
    """One of each of two zones: he of the first is free, and the other, at 15 m, is away at 10 m when 15 m calls."""
    goods = {"tasks.goods": [2, 1, 2], "fleet.size": 3, "tasks.load_time": 40}
    run = ring(**goods, pickers={"count": 2, "speed": 0.5, "zones": 2})
    assert {one.picker for one in run.history.pickers_work} == {1}
    assert {one.picker for one in ring(**goods, pickers__count=2).history.pickers_work} == {0, 1}


def test_what_is_brought_is_put_away_by_a_picker():
    """Loaded at the dock without one, 10 + 20 + 10 + 5 to the place, where he comes from 5 away."""
    flow = {"from": "packing", "to": "storage", "arrivals": {"schedule": [{"at": 0, "tasks": 1}]}}
    tasks = {"flows": {"in": flow}, "load_time": 7, "unload_time": 4}
    run = ring(tasks=tasks, layout__storage=[AROUND[0]])
    assert times(run, "awaiting_picker") == [30 + 7 + 35]
    assert [(one.start, one.end, one.picks) for one in run.history.pickers_work] == [(72, 72, False), (72, 76, True)]
    assert times(run, "delivered") == [76]


def test_flows_without_pickers_are_done_by_robots_alone():
    schedule = {"schedule": [{"at": 0, "tasks": 1}]}
    flows = {
        "in": {"from": "packing", "to": "storage", "arrivals": schedule},
        "out": {"from": "storage", "to": "packing", "arrivals": schedule},
    }
    run = ring(tasks={"flows": flows, "load_time": 7, "unload_time": 4}, pickers__flows=["out"])
    assert [run.record.flows[one.task] for one in run.history.pickers_work if one.picks] == ["out"]


def test_pickers_who_are_everywhere_at_once_are_as_none():
    """The same times of all that robots do; they walk in no time."""
    with_them = ring(tasks__goods=[2, 0, 1], fleet__size=2, pickers={"count": 2, "speed": 1e9})
    without = ring(tasks__goods=[2, 0, 1], fleet__size=2, pickers=None)
    assert with_them.kpis["T"] == pytest.approx(without.kpis["T"])
    assert {"walking", "picking"}.isdisjoint(row.kind for row in without.history.rows())


# What a model may say

FLOW = {"from": "storage", "to": "packing", "arrivals": {"schedule": [{"at": 0, "tasks": 1}]}}
CURE = "a picker who stays is met in a bay or station; expected stations"
ACROSS = {**FLOW, "from": "B"}
WRONG = [
    ({"pickers.zones": 2}, "pickers.zones: 2 zones for 1 picker, expected at most one for each"),
    (
        {"pickers": {"count": 9, "speed": 1, "zones": 4}},
        "pickers.zones: 4 zones of 3 storage places, expected at most one for each",
    ),
    (
        {"pickers": {"count": 2, "speed": 1, "zones": 2, "stay": "order"}},
        "pickers.stay: nobody leaves their zone, so nobody stays with a robot that does, expected zones: 1",
    ),
    (
        {"pickers.stay": "order", "pickers.call": "ahead"},
        "pickers.call: a picker who stays is with the robot before it sets out; leave it out",
    ),
    ({"pickers.flows": ["out"]}, "pickers.flows.0: no such flow (got 'out'), expected none, as there are no flows"),
    (
        {"tasks": {"flows": {"out": FLOW, "on": ACROSS}, "load_time": 1, "unload_time": 1}, "pickers.flows": ["on"]},
        "pickers.flows.0: it neither begins nor ends at a storage place (got 'on'), expected one of out",
    ),
    (
        {"tasks": {"flows": {"on": ACROSS}, "load_time": 1, "unload_time": 1}},
        "pickers: no flow begins or ends at a storage place, where pickers would come; leave them out",
    ),
    (
        {"pickers.stay": "order", "tasks.unload_at": ["B"]},
        f"tasks.unload_at: puts loads down in the lane (got 'B'): {CURE}",
    ),
    (
        {
            "tasks": {"flows": {"in": {**FLOW, "from": "B", "to": "storage"}}, "load_time": 1, "unload_time": 1},
            "pickers.stay": "order",
        },
        f"tasks.flows.in.to: ends at a storage place, in the lane: {CURE}",
    ),
    (
        {"pickers.stay": "order", "fleet.start_on_lanes": [{"node": "B"}]},
        "fleet.start_on_lanes: a picker who stays is met in a bay or station, not in the lane; leave it out",
    ),
    ({"pickers.hours": "day"}, "pickers.hours: no such calendar (got 'day'), expected one of calendars, of which"),
]


@pytest.mark.parametrize(("changes", "text"), WRONG)
def test_model_says_what_is_wrong_with_pickers(changes, text):
    with pytest.raises(ModelError) as error:
        dw.load(RING, changes)
    assert text in str(error.value)
