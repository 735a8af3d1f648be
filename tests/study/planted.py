"""Two dozen warehouses with one planted bottleneck of as many kinds, and what `why` names first.

`python -m tests.study.planted` prints the table, with what the advice gains on other days. Numbers or words of titles
choose some of them, and `quick` leaves the other days out. Days are short, and there are batteries only where they are
the point.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.outcome.indicators import find
from desim_warehouse.questions.why import why
from tests.study.told import told

SEED, OTHER_SEED = 77, 5000
CAP = 20
DAYS = 14
NOTHING = "nothing"
FLAT = "runs flat"
SHOP = {"battery": None, "run.length": "75 min", "run.warm_up": "15 min", "log": "all"}
BATTERIES = {
    "battery": {"capacity": 100, "consumption": 0.005, "charge_rate": 0.02},
    "fleet.start_energy": {"uniform": [0.3, 0.7]},
    "run.length": "3 h",
    "run.warm_up": "1 h",
}
ORDERS = "tasks.flows.orders"


@dataclass(frozen=True)
class Planted:
    """A draft of 22 x 18 m with `orders` an hour and `changes`, in which `named` holds things up."""

    title: str
    named: str
    changes: dict = field(default_factory=dict)
    orders: float = 70
    robots: int = 6
    layout: dict | None = None

    def model(self):
        """The warehouse."""
        if self.layout is not None:
            return dw.load(self.layout, self.changes)
        words = Draft((22, 18), orders=self.orders, stations=1, robots=self.robots, chargers=2)
        return dw.Model.model_validate(read_yaml(draft(words), "draft").data).replace({**SHOP, **self.changes})


def _flow(**flow):
    """One flow from storage to packing in place of the draft's orders."""
    return {"tasks": {"load_time": 10, "unload_time": 20, "flows": {"orders": _orders(**flow)}}}


def _orders(**flow):
    return {"from": "storage", "to": "packing", "due_within": 900, **flow}


RING = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [30, 0], "C": [30, 10], "E": [0, 10]},
        "edges": [["A", "B"], {"from": "B", "to": "C", "speed": 0.2}, ["C", "E"], ["E", "A"]],
        "storage": [{"edge": ["C", "E"], "offset": 5}],
        "bays": {"home": {"at": ["A"], "places": 8}},
        "stations": {"desk": {"at": ["E"], "servers": 2}},
    },
    "fleet": {"size": 3, "robot": {"radius": 0.3, "speed": 1.5}},
    "tasks": {"goods": {"poisson": 60, "due_within": 100}, "unload_at": ["desk"], "load_time": 5, "unload_time": 5},
    "run": {"length": "75 min", "warm_up": "15 min"},
    "log": "all",
}
BRIDGE = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [30, 0], "A1": [-10, -5], "A2": [-10, 5], "B1": [40, -5], "B2": [40, 5]},
        "edges": [
            *(["A", "A1"], ["A1", "A2"], ["A2", "A"], ["B", "B1"], ["B1", "B2"], ["B2", "B"]),
            {"from": "A", "to": "B", "two_way": True},
        ],
        "storage": [{"edge": ["B1", "B2"], "offset": 5}],
        "bays": {"home": {"at": ["A1"], "places": 8}},
        "stations": {"desk": {"at": ["A2"], "servers": 4, "places": 8}},
    },
    "fleet": {"size": 4, "robot": {"radius": 3, "speed": 1}},
    "tasks": {"goods": {"poisson": 60}, "unload_at": ["desk"], "load_time": 5, "unload_time": 5},
    "run": {"length": "75 min", "warm_up": "15 min"},
    "log": "all",
}

CASES = [
    Planted("a packer who takes 75 s", "packers", {"tasks.unload_time": 75}),
    Planted(
        "two workers who take 110 s",
        "packers",
        {"layout.stations.packing.work_time": 110, "layout.stations.packing.workers": 2},
    ),
    Planted(
        "one charger for six robots",
        FLAT,
        {**BATTERIES, "battery.consumption": 0.01, "layout.bays.charging.total_chargers": 1},
    ),
    Planted("people in the aisles", "people in the aisles", {"people": {"pickers": {"per_hour": 200, "stay": 60}}}),
    Planted(
        "robots repaired in the lanes", "breakdowns", {"fleet.robot.breakdowns": {"every": "20 min", "repair": "6 min"}}
    ),
    Planted(
        "a closure",
        "closures",
        {
            "calendars.shut": {"every": 1000, "lasts": 600},
            "traffic.closures": {"gate": {"members": ["G"], "hours": "shut", "tasks": "go"}},
        },
    ),
    Planted("two robots", "the number of robots", robots=2),
    Planted(
        "peaks of 200 an hour", "peaks", _flow(arrivals={"profile": {"per_hour": [200, 27, 27, 26], "every": "15 min"}})
    ),
    Planted(
        "charging from 85 % on, with a taper",
        "the charging policy",
        {
            **BATTERIES,
            "fleet.start_energy": {"uniform": [0.85, 1]},
            "battery.taper": {"start": 0.8, "end_rate": 0.1},
            "policies.charging": {"name": "threshold", "level": 85},
        },
    ),
    Planted("a crossing that takes 25 s", "intersection G", {"traffic.nodes.G.time": 25}),
    Planted(
        "batches of six",
        "batching",
        {"policies.batching": {"name": "fixed-size", "size": 6}, "fleet.robot.capacity": 6},
        orders=40,
    ),
    Planted("nothing", NOTHING, orders=30),
    Planted(
        "a slow zone",
        "zones that are slow",
        {"traffic.slow": {"ramp": {"members": [["G", "F"], ["H", "G"], ["G", "C"]], "speed": 0.1}}},
    ),
    Planted(
        "one robot at a time before the station",
        "zones with a rule",
        {"traffic.zones": {"lift": {"members": [["H", "G"], ["G", "F"], ["G", "C"]], "rule": "one-robot"}}},
    ),
    Planted("two robots under way at most", "the cap on robots under way", {"traffic.most_out": 2}),
    Planted(
        "one robot that lifts heavy loads",
        "robots of kind lifter",
        {
            **_flow(arrivals={"poisson": 50}),
            f"{ORDERS}.kinds": ["lifter"],
            "fleet.kinds": {"lifter": {"count": 1}},
            "tasks.flows.light": _orders(arrivals={"poisson": 20}),
        },
    ),
    Planted(
        "robots at work 25 min an hour",
        "shifts of robots",
        {"calendars.day": {"every": 3600, "lasts": 1500}, "fleet.hours": "day"},
    ),
    Planted(
        "a station open 25 min an hour",
        "hours of packing",
        {"calendars.day": {"every": 3600, "lasts": 1500}, "layout.stations.packing.hours": "day"},
    ),
    Planted("delays at nodes", "delays", {"fleet.robot.delays": {"share": 0.5, "time": 15}}),
    Planted(
        "a minute to leave a bay",
        "the way out of bays",
        {"fleet.exit_time": 60, "tasks.goods.due_within": 150},
        orders=40,
    ),
    Planted("decisions every 5 min", "the interval of decisions", {"policies.interval": 300}),
    Planted("one slot at the station", "places at the stations", {"layout.stations.packing.places": 1}),
    Planted("a lane with a speed limit", "limits of speed", layout=RING),
    Planted("a two-way lane", "two-way lane A - B", layout=BRIDGE),
]


@dataclass
class Named:
    """What was said of a case: the first suspect, whether it is clear, and its gain said and on other days."""

    case: Planted
    first: str
    clear: bool
    sentence: str
    runs: int
    bounds: tuple[float, float] | None = None
    gain: float | None = None

    @property
    def right(self):
        """The planted one is named, and nothing else beside it."""
        return self.clear and self.first == self.case.named

    def __str__(self):
        """A row of the table."""
        bounds = "" if self.bounds is None else f" [{self.bounds[0]:.4g} to {self.bounds[1]:.4g}]"
        other = "" if self.gain is None else f", on other days {self.gain:.4g}"
        verdict = "right" if self.right else "first" if self.first == self.case.named else "WRONG"
        return f"{verdict:5}  {self.case.title}: {self.sentence}{bounds}{other} ({self.runs} runs)"


def named(case, *, days=0):
    """Ask why; with `days` carry out the advice on so many other days."""
    model = case.model()
    diagnosis = why(model, search=dw.Search(seed=SEED, cap=CAP, workers=1))
    sentence = diagnosis.answer.answer[0]
    if not diagnosis.ranked:
        return Named(case, FLAT if FLAT in sentence else "", clear=True, sentence=sentence, runs=1)
    if not diagnosis.is_held_up:
        return Named(case, NOTHING, clear=True, sentence=sentence, runs=diagnosis.gains.runs)
    suspect, gain = diagnosis.ranked[0]
    answer = Named(case, suspect.name, diagnosis.is_clear, sentence, diagnosis.gains.runs, (gain.low, gain.high))
    if days:
        cases = {"cases": {"no": {}, "yes": dict(suspect.overrides)}}
        study = dw.Study(model, {"relief": cases}, replications=days, seed=OTHER_SEED)
        study.run(workers=1)
        more = study.compare(diagnosis.indicator).differences[0].estimate.mean
        answer.gain = more if find(diagnosis.indicator).better == "more" else -more
    return answer


def main(*wanted):
    """Print the table; `quick`: without other days."""
    days, wanted = 0 if "quick" in wanted else DAYS, [word for word in wanted if word != "quick"]
    chosen = [
        case
        for number, case in enumerate(CASES)
        if not wanted or any(word == str(number) or word in case.title for word in wanted)
    ]
    answers = told(chosen, lambda case: named(case, days=days))
    sys.stdout.write(f"{sum(one.right for one in answers)} of {len(answers)} named first and alone\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
