"""State messages of VDA 5050 as real robots send them, made from a run: shares no code with what reads them.

Real ones are sent about once a second, some are lost, some radio holes last a minute, positions are some centimetres
off in axes of their own, clocks and levels are rounded.
"""

import json
from bisect import bisect_right
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np

BEGIN = datetime(2026, 3, 2, 6, tzinfo=UTC)
ACTIONS = {"loading": "pick", "unloading": "drop", "charging": "startCharging"}


@dataclass(frozen=True)
class Radio:
    """How a fleet reports: see above. `turned`: the angle of its axes; `scale`: of its unit of length.

    `digits`: of levels of charge.
    """

    noise: float = 0.03
    jitter: float = 0.05
    lost: float = 0.01
    holes: float = 1.0
    turned: float = 0.3
    shift: tuple[float, float] = (12.0, -7.0)
    scale: float = 1.0
    digits: int = 1


def states_of(run, robot):
    """When the states of a robot began, with a load or without: read from the rows of the log."""
    rows = run.log[(run.log["robot"] == robot) & run.log["kind"].isin([*run.robots.columns, "idle"])]
    begins, names, loads = [0.0], ["idle"], [False]
    for time, kind, task in zip(rows["time"], rows["kind"], rows["task"], strict=True):
        works = kind in {"loaded", "unloading"} or (kind == "queueing" and task >= 0)
        loads.append(loads[-1] if kind == "broken" else works)
        begins.append(time)
        names.append(kind)
    return begins, names, loads


def write(run, path, seed=0, radio=Radio()):
    """Write the messages of all robots to a file, in order of time."""
    rng = np.random.default_rng(seed)
    ends = np.arange(1.0, run.history.end - 1)
    times = np.sort(ends + rng.normal(0, radio.jitter, len(ends)))
    places = run.positions(times)
    fleet = run.model.fleet.size
    x = places["x"].to_numpy().reshape(-1, fleet)
    y = places["y"].to_numpy().reshape(-1, fleet)
    node = places["node"].to_numpy().reshape(-1, fleet)
    real = radio.scale * (x - 1j * y) * np.exp(1j * radio.turned) + complex(*radio.shift)
    real += radio.scale * radio.noise * (rng.normal(size=real.shape) + 1j * rng.normal(size=real.shape))
    waits = run.waits
    lines = []
    for robot in range(fleet):
        begins, names, loads = states_of(run, robot)
        mine = waits[waits["robot"] == robot]
        held = np.zeros(len(times), bool)
        for start, end in zip(mine["start"], mine["end"], strict=True):
            held |= (times >= start) & (times < end)
        level = np.full(len(times), 100.0)
        if run.model.battery is not None:
            level = np.interp(times, *run.history.energy_curves[robot]) / run.model.battery.capacity * 100
        sent = rng.random(len(times)) >= radio.lost
        for start in rng.uniform(0, times[-1], rng.poisson(radio.holes * times[-1] / 3600)):
            sent &= (times < start) | (times > start + rng.uniform(20, 90))
        for k in np.flatnonzero(sent).tolist():
            at = bisect_right(begins, times[k]) - 1
            state = names[at]
            action = ACTIONS.get(state)
            lines.append(
                (
                    times[k],
                    {
                        "headerId": k,
                        "timestamp": (BEGIN + timedelta(seconds=round(float(times[k]), 2))).isoformat(),
                        "version": "2.0.0",
                        "manufacturer": "somebody",
                        "serialNumber": f"AMR-{robot}",
                        "orderId": "",
                        "orderUpdateId": 0,
                        "lastNodeId": node[k, robot],
                        "lastNodeSequenceId": 0,
                        "driving": state in {"empty", "loaded", "returning"} and not bool(held[k]),
                        "nodeStates": [],
                        "edgeStates": [],
                        "agvPosition": {
                            "x": round(float(real[k, robot].real), 3),
                            "y": round(float(real[k, robot].imag), 3),
                            "theta": 0.0,
                            "mapId": "hall",
                            "positionInitialized": True,
                        },
                        "loads": [{"loadId": "box"}] if loads[at] else [],
                        "actionStates": [{"actionId": f"a{at}", "actionType": action, "actionStatus": "RUNNING"}]
                        if action
                        else [],
                        "batteryState": {
                            "batteryCharge": round(float(level[k]), radio.digits),
                            "charging": state == "charging",
                        },
                        "operatingMode": "AUTOMATIC",
                        "errors": [{"errorType": "motor", "errorLevel": "FATAL"}] if state == "broken" else [],
                        "safetyState": {"eStop": "NONE", "fieldViolation": False},
                    },
                )
            )
    lines.sort(key=lambda line: line[0])
    path.write_text("".join(json.dumps(message) + "\n" for _, message in lines), encoding="utf-8")
    return path
