"""What holds a warehouse up: planted bottlenecks are found, and relieving them gains what was said."""

import json

import pytest

import desim_warehouse as dw
from desim_warehouse.answer.answer import load
from desim_warehouse.errors import StudyError
from desim_warehouse.questions.why import why, worded
from desim_warehouse.study.held_up import HeldUp, usual_indicator
from desim_warehouse.study.statistics.effects import Gain, Gains
from desim_warehouse.study.suspects import Suspect, suspects
from tests.docs import pages
from tests.study import bottlenecks
from tests.world.test_hours import SQUARE

MODEL = "models/mir250.yaml"
SHORT = {"run.length": 3600, "run.warm_up": 600, "log": "all"}


@pytest.fixture(scope="module")
def run():
    return dw.simulate(dw.load(MODEL, {**SHORT, "traffic.nodes.r1c4.time": 6}))


def test_suspects_come_from_the_account_of_time_worst_first(run):
    ranked = suspects(run)
    waited = [suspect.waited for suspect in ranked if suspect.waited is not None]
    assert waited == sorted(waited, reverse=True)
    nodes = run.account(by="node")["before_intersection"]
    at = next(suspect for suspect in ranked if suspect.name.startswith("intersection"))
    assert at.name == f"intersection {nodes.idxmax()}"
    assert at.waited == pytest.approx(nodes.max() / (run.history.counted * 12))
    # all bay places are taken, so there is no room for a robot more; nine places at stations for twelve robots
    rest = {"packers", "chargers", "handling", "demand", "places at the stations", "the way out of bays"}
    rest |= {"where items lie", "narrow aisles"}  # its classes are by number; robots load in the lanes
    assert {suspect.name for suspect in ranked if not suspect.name.startswith("intersection")} == rest
    for suspect in ranked:
        run.model.replace(suspect.overrides)  # every relief is a model


def test_costs_are_counted_in_what_the_demand_lets_change(run):
    assert usual_indicator(run) == "cycle_time_mean"
    assert (
        usual_indicator(dw.simulate(dw.load(MODEL, {**SHORT, "tasks.goods": {"saturated": 20}})))
        == "throughput_per_hour"
    )
    assert usual_indicator(dw.simulate(dw.load("models/multibots.yaml", {"tasks.goods": [1]}))) == "T"


GATED = {
    "tasks.goods": {"saturated": 4},
    "run.length": 4000,
    "log": "all",
    "calendars": {"night": {"every": 1000, "lasts": 800}, "day": {"every": 1000, "lasts": 600}},
}
EVERYTHING = {
    "traffic.closures": {"gate": {"members": [["A", "B"]], "hours": "night", "tasks": "go"}},
    "traffic.slow": {"ramp": {"members": [["C", "E"]], "speed": 0.5}},
    "people": {"pickers": {"per_hour": 10, "stay": 20}},
    "layout.stations.desk": {"at": ["E"], "hours": "day", "at_close": "pause", "work_time": 9, "buffer": 1},
    "layout.bays.home.outages": {"every": 900, "repair": 90},
    "fleet.hours": "day",
    "fleet.size": 3,
    "fleet.robot.delays": {"share": 0.2, "time": 3},
    "fleet.kinds": {"old": {"count": 1, "hours": "night", "breakdowns": {"every": 500, "repair": 50}}},
    "battery": {"capacity": 1e5, "threshold": 10, "consumption": 1, "charge_rate": 100},
}


def test_broken_robots_off_the_lanes_are_a_relief_where_repairs_are_long():
    model = dw.load(SQUARE, {**GATED, "fleet.robot.breakdowns": {"every": 900, "repair": 600}})
    [suspect] = [one for one in suspects(dw.simulate(model)) if one.relief == "broken robots off the lanes after 2 min"]
    assert suspect.name == "breakdowns"
    assert suspect.overrides == {"fleet.robot.breakdowns.clear": 120}


def test_what_goes_wrong_and_what_is_closed_are_suspects():
    run = dw.simulate(dw.load(SQUARE, {**GATED, **EVERYTHING}))
    by_name = {suspect.name: suspect for suspect in suspects(run)}
    assert by_name.keys() >= {
        "closures",
        "zones that are slow",
        "people in the aisles",
        "hours of desk",
        "shifts of robots",
        "workers of desk",
        "breakdowns",
        "delays",
        "outages of chargers",
    }
    assert by_name["closures"].waited > run.kpis["share_waiting_closed"] > 0  # robots behind the first wait for it, too
    assert by_name["workers of desk"].overrides == {"layout.stations.desk.workers": 2, "layout.stations.desk.buffer": 2}
    for suspect in by_name.values():
        run.model.replace(suspect.overrides)
    relieved = run.model.replace({key: to for one in by_name.values() for key, to in one.overrides.items()})
    gone = [relieved.fleet.breaks_down, relieved.fleet.has_hours, relieved.layout.has_hours]
    assert not any([*gone, relieved.traffic.closures, relieved.traffic.slow, relieved.people])


def two_chargers(charging):
    """A ring of 160 m with a charger at either end; robots that come from the station pass that at d first."""
    return dw.load(
        {
            "name": "two chargers",
            "layout": {
                "nodes": {"a": [0, 0], "b": [30, 0], "c": [60, 0], "d": [60, 20], "e": [30, 20], "f": [0, 20]},
                "edges": [["a", "b"], ["b", "c"], ["c", "d"], ["d", "e"], ["e", "f"], ["f", "a"]],
                "bays": {
                    name: {"at": [node], "places": 6, "total_chargers": 1}
                    for name, node in (("left", "a"), ("right", "d"))
                },
                "stations": {"up": {"at": ["b"], "places": 16, "servers": 3}, "down": {"at": ["e"], "places": 16}},
            },
            "fleet": {"size": 8, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1}, "start_energy": "settled"},
            "battery": {
                "capacity": 100,
                "consumption": {"standing": 0.001, "empty": 0.03, "loaded": 0.03, "handling": 0},
                "charge_rate": 0.06,
            },
            "tasks": {
                "load_time": 2,
                "unload_time": 2,
                "flows": {"up": {"from": "down", "to": "up", "arrivals": {"poisson": 70}}},
            },
            "run": {"length": "4 h", "warm_up": "1 h"},
            "policies": {"allocation": "nearest", "charging": charging},
            "log": "all",
        }
    )


def test_robots_that_queue_at_one_charger_are_sent_to_the_other():
    # all unload at b and pass the charger at d next: it was always taken, the other for a third of the time
    queued = dw.simulate(two_chargers("four-thresholds"), 1)
    (spread,) = [one for one in suspects(queued) if one.name == "the choice of chargers"]
    assert spread.overrides == {"policies.charging": {"name": "four-thresholds", "charger": "least-loaded"}}
    shared = dw.simulate(queued.model.replace(spread.overrides), 1)
    assert shared.kpis["throughput_per_hour"] > queued.kpis["throughput_per_hour"] + 8
    assert not [one for one in suspects(shared) if one.name == "the choice of chargers"]


def test_an_aisle_that_is_closed_is_named_and_not_the_robots_that_wait_before_it():
    """Robots go round in 75 s, and the only lane out is closed 800 s of 1,000."""
    diagnosis = why(dw.load(SQUARE, {**GATED, "traffic.closures": EVERYTHING["traffic.closures"]}))
    sentence = diagnosis.answer.answer[0]
    assert sentence.startswith("Closures are the main bottleneck. ")
    assert "no other ranked change gains more than" in sentence


def test_a_run_on_disk_and_a_model_give_the_same_answer(tmp_path, monkeypatch):
    few, (model, _) = "--quiet --first 3 --cap 4", bottlenecks.planted(1)
    model = model.replace({"run.length": 1500, "run.warm_up": 300})
    (tmp_path / "w.yaml").write_text(json.dumps(model.content()), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert pages.run_desim("desim run w.yaml --out run")[0] == 0
    status, out, _ = pages.run_desim(f"desim why w.yaml {few} --out study")
    assert status == 0
    sentence = next(line for line in out.splitlines() if " the main bottleneck. " in line)
    assert sentence.startswith("Packers are the main bottleneck. A second packer at each station (+100 %): throughput ")
    answer = json.loads(pages.run_desim(f"desim why run {few} --json")[1])
    assert answer["answer"] == out.split("\n\n")[0].splitlines()
    assert answer["answer"][0] == sentence
    assert answer["options"][0]["set"] == {"layout.stations.packing.servers": 2}
    kept = load("study")
    assert kept.command == f"desim why w.yaml {few} --out study"
    assert str(kept) + "\n" == out


def test_a_run_without_waits_in_its_log_is_refused():
    run = dw.simulate(dw.load(MODEL, {**SHORT, "log": "tasks"}))
    with pytest.raises(dw.ReportError, match="needs log: all"):
        why(run)


def test_an_indicator_without_a_better_side_is_refused(run):
    with pytest.raises(StudyError, match="neither less nor more of it is better"):
        why(run, indicator="share_idle")


@pytest.mark.parametrize("number", [100, pytest.param(101, marks=pytest.mark.long), 108])
def test_where_robots_wait_longest_is_not_what_is_scarce(number):
    """No slot at the station (robots stand in bays), too few robots, a charger for which spare robots queue."""
    model, planted = bottlenecks.planted(number)
    run = dw.simulate(model, number)
    longest = max(suspects(run), key=lambda suspect: suspect.waited or 0)
    assert longest.waited > 0
    assert longest.name != planted


@pytest.mark.long
@pytest.mark.parametrize("number", [0, 1, 2, 3, 4, 101])
def test_a_planted_bottleneck_is_found_and_its_relief_gains_what_was_said(number):
    blame = bottlenecks.blame(number)
    assert blame.right, blame
    assert blame.as_promised, blame


@pytest.mark.long
def test_most_of_a_hundred_planted_bottlenecks_are_named():
    """About half an hour of one processor."""
    blames = [bottlenecks.blame(number) for number in range(100)]
    assert sum(one.right for one in blames) >= 89
    assert sum(one.as_promised for one in blames) >= 89


@pytest.mark.long
def test_thirty_where_plain_waiting_misleads():
    """About ten minutes of one processor."""
    blames = [bottlenecks.blame(number) for number in range(bottlenecks.MISLEADING, bottlenecks.MISLEADING + 30)]
    assert sum(one.right for one in blames) >= 26
    assert sum(one.as_promised for one in blames) >= 26
    assert sum(one.by_waiting != one.planted for one in blames) >= 15


def test_the_largest_gain_is_named_where_it_takes_many_changes():
    """Two lanes for each of 60: little for each 10 %, and most of all as a whole."""
    lanes = {
        f"layout.edges.{rank}": {"from": f"a long name of one of the nodes {rank}", "to": "hub"} for rank in range(60)
    }
    crossing = Suspect("intersection A", "nobody waits at A", {"traffic.nodes.A.free": True}, 0.02)
    every = Suspect("two-way lanes", "two lanes for each of 60 two-way lanes", lanes, dose=20.0)
    gains = [Gain(1, 18, -58, 94, 6), Gain(2, 330, 275, 384, 6, scale=every.scale)]
    both = tuple(zip((crossing, every), gains, strict=True))
    costs = HeldUp(dw.load(SQUARE), "throughput_per_hour", both, Gains(tuple(gains), 851, 8.5, 0.95, 12))
    answer = worded(costs).answer
    sentence = answer.answer[0]
    assert (
        "do not yet show what helps most. Gain in throughput, per 10 % more: nobody waits at A 18 tasks/h (" in sentence
    )
    assert sentence.endswith(
        "Of whole changes, two lanes for each of 60 two-way lanes gains most: 330 tasks/h (275 to 384)."
    )
    assert ("two lanes for each of 60 two-way lanes", "+2,000 %", "", "330 tasks/h (275 to 384)") in answer.tables[
        0
    ].rows
    assert [one.standing for one in answer.options] == ["perhaps", "perhaps"]


def peaks_and_robots(robots):
    """What is said of peaks, which gain 88 s, and of a third robot: `robots`, the bounds of its whole gain."""
    peaks = Suspect("peaks", "the same orders evenly", {"tasks.flows.orders.arrivals": {"poisson": 40}})
    robot = Suspect("the number of robots", "one robot more", {"fleet.size": 3}, dose=0.5)
    gains = [Gain(1, 88, 16, 276, 12), Gain(2, sum(robots) / 2, *robots, 12, scale=robot.scale, beaten=True)]
    both = tuple(zip((peaks, robot), gains, strict=True))
    costs = HeldUp(dw.load(SQUARE), "cycle_time_mean", both, Gains(tuple(gains), 600, 6, 0.95, 36))
    first = worded(costs).answer.answer[0]
    return first.partition("Peaks are the main bottleneck. ")[2]


def test_a_change_that_gains_less_for_a_tenth_may_gain_most_as_a_whole():
    """A third robot gains 146 s, 29 s for a tenth more robots: less than the 88 s of peaks, and more as a whole."""
    evenly = "The same orders evenly: mean cycle time falls by 1.5 min (0.3 to 4.6); "
    less = "on the same days every other ranked change gains less per 10 %."
    assert peaks_and_robots((80, 212)) == (
        f"{evenly}{less} Of whole changes, one robot more may gain most: 2.4 min (1.3 to 3.5)."
    )
    assert peaks_and_robots((280, 320)).endswith(
        " Of whole changes, one robot more gains most: 5.00 min (4.67 to 5.33)."
    )
    assert peaks_and_robots((80, 90)).endswith(less)
