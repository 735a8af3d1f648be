"""Orders from a file: what their columns mean, what is wrong with them by row, indicators of orders, resampling."""

import time
import tracemalloc

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import desim_warehouse as dw
from desim_warehouse.errors import ModelError
from desim_warehouse.model.facts.demand import arrival_rate
from desim_warehouse.model.sections.flows import OrdersFile
from desim_warehouse.model.sections.order_lines import OrderLine, Reading
from desim_warehouse.model.sections.orders import read, resampled, summary
from desim_warehouse.values.streams import Streams
from tests.world.test_flows import RING

HOW = Reading(frozenset({"A", "B", "C", "D", "dock", "pack"}), 2, "06:00", 1.0)


def written(path, text):
    path.write_text(text, encoding="utf-8")
    return path


def lines(path, how=HOW, **more):
    return list(read(OrdersFile(file=str(path), **more), how))


def model(path, changes=(), **more):
    flow = {"from": "storage", "to": "pack", "arrivals": {"orders": {"file": str(path), **more}}}
    return dw.load(RING, {"tasks.flows": {"day": flow}, **dict(changes)})


def test_every_column_of_a_file_is_read(tmp_path):
    path = written(
        tmp_path / "orders.csv",
        "release,from,to,due,priority,quantity,order\n"
        "06:00,dock,1,06:30,2,3,a\n"
        "06:10:30,0,pack,,,,a\n"
        "2400,storage,,3000,,,b\n",
    )
    assert lines(path) == [
        OrderLine(0, "dock", 1, 1800, 2, 3, "a"),
        OrderLine(630, 0, "pack", None, None, 1, "a"),
        OrderLine(2400, "storage", None, 3000, None, 1, "b"),
    ]


@pytest.mark.parametrize(
    ("release", "start", "seconds", "expected"),
    [
        ("600", "06:00", 1, 600),
        ("06:10", "06:00", 1, 600),
        ("06:10", "06:00", 60, 10),
        ("2026-03-02T06:10", "06:00", 1, 600),
        ("2026-03-02 06:10:00", "2026-03-02T06:00", 1, 600),
        ("2026-03-03T05:00:00", "2026-03-02T06:00", 1, 23 * 3600),
    ],
)
def test_times_are_read_in_seconds_from_the_start(tmp_path, release, start, seconds, expected):
    path = written(tmp_path / "orders.csv", f"release\n{release}\n")
    (line,) = lines(path, Reading(HOW.names, 2, start, seconds))
    assert line.release == pytest.approx(expected)


def test_parquet_is_read_like_csv(tmp_path):
    table = pd.DataFrame(
        {
            "release": pd.to_datetime(["2026-03-02 06:00", "2026-03-02 06:05"]),
            "from": [0, 1],
            "due": pd.to_datetime(["2026-03-02 06:30", None]),
            "quantity": [1, 2],
            "order": ["a", "b"],
        }
    )
    table.to_parquet(tmp_path / "orders.parquet")
    assert lines(tmp_path / "orders.parquet") == [
        OrderLine(0, 0, None, 1800, None, 1, "a"),
        OrderLine(300, 1, None, None, None, 2, "b"),
    ]


def test_what_is_wrong_is_said_by_row_and_column_at_most_20_of_them(tmp_path):
    path = written(
        tmp_path / "orders.csv",
        "release,from,due,quantity\n06:00,0,06:30,1\nsoon,0,,1\n06:05,7,06:01,0\n06:04,pak,,1.5\n05:00,0,,1\n",
    )
    with pytest.raises(ModelError) as refused:
        lines(path)
    problems = refused.value.problems
    place = "expected a node, a station, 'storage', or a storage place from 0 to 1"
    whole = "expected a whole number of at least 1"
    later = "expected a time from 06:00 on, or an earlier run.start in the model"
    a_time = "expected a number of at least 0, or a time such as 06:15 or 2026-03-02T06:15"
    assert problems == [
        f"{path}, row 5, release: before the start of the run (got '05:00'), {later}",
        f"{path}, row 2, release: not a time (got 'soon'), {a_time}",
        f"{path}, row 3, due: due before its release (got '06:01'), expected a time not before it",
        f"{path}, from: no such place (2 rows from row 3 on, 2 values: '7', 'pak'), {place}",
        f"{path}, quantity: not a number of this kind (2 rows from row 3 on, 2 values: '0', '1.5'), {whole}",
    ]
    many = written(tmp_path / "many.csv", "release\n" + "x\n" * 100)
    with pytest.raises(ModelError) as refused:
        model(many)
    assert len(refused.value.problems) <= 21


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("relase\n1\n", "column 'relase'; did you mean 'release'"),
        ("release\n", "no rows, expected at least one order"),
    ],
)
def test_a_file_without_orders_is_refused(tmp_path, text, message):
    with pytest.raises(ModelError, match=message):
        model(written(tmp_path / "orders.csv", text))


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(ModelError, match=r"cannot be read .*none.csv"):
        model(tmp_path / "none.csv")


def test_orders_are_delivered_as_they_say(tmp_path):
    path = written(
        tmp_path / "orders.csv", "release,from,to,due,order\n0,1,pack,300,a\n10,dock,0,80,a\n500,1,dock,,b\n"
    )
    run = dw.simulate(model(path))
    # 1 to pack: loaded 34, at D 64, unloaded 70; then A 90, B 110: loaded 114; at offset 5 of C>D 139, unloaded 145
    first, second, third = run.history.tasks.values()
    assert (first.delivered, first.station, second.good, second.delivered) == (70, "D", -1, 145)
    assert third.released == 500
    assert [(one.order, one.released, one.done, one.deadline) for one in run.history.orders] == [
        ("a", 0, 145, (80, 145)),  # the second of its tasks is late
        ("b", 500, third.delivered, None),
    ]
    assert run.kpis["orders"] == 2
    assert run.kpis["order_cycle_time_mean"] == pytest.approx((145 + third.delivered - 500) / 2)
    assert run.kpis["orders_on_time"] == 0
    assert run.kpis["on_time"] == 0.5
    assert dw.load_run(run.save(tmp_path / "run")).kpis == run.kpis


@pytest.mark.parametrize(("hours", "rate"), [(1, 30), (2, 30), (4, 15)])
def test_the_rate_of_a_file_is_that_of_its_own_time_where_the_run_is_shorter(tmp_path, hours, rate):
    """Sixty orders, one every two minutes; a run of four hours asks for half as many an hour."""
    path = written(tmp_path / "orders.csv", "release\n" + "".join(f"{120 * (n + 1)}\n" for n in range(60)))
    asked = model(path, {"run.length": f"{hours} h"})
    assert 3600 * arrival_rate(asked) == pytest.approx(rate)


def test_a_row_to_storage_goes_to_any_other_place(tmp_path):
    """Of two places, the one on C>D is where the load comes from; the flow by itself goes to pack."""
    path = written(tmp_path / "orders.csv", "release,from,to\n" + 8 * "0,0,storage\n")
    rows = dw.simulate(model(path)).record.rows
    assert [row[5] for row in rows if row[1] == "delivered"] == 8 * [("B", "C")]


def test_a_run_can_be_looked_at_where_its_orders_are_not(tmp_path):
    path = written(tmp_path / "orders.csv", "release,from\n0,1\n")
    run = dw.simulate(model(path))
    folder = run.save(tmp_path / "run")
    path.unlink()
    again = dw.load_run(folder)
    assert again.kpis == run.kpis
    with pytest.raises(ModelError, match="no such file"):
        dw.simulate(again.model)


def test_a_file_that_is_an_export_by_the_time_of_the_run_is_refused(tmp_path):
    path = written(tmp_path / "orders.csv", "release,from\n0,1\n")
    before = model(path)
    written(path, "Created;bin\n06:05;1\n")
    with pytest.raises(ModelError, match=r"no plain table of orders \(got column 'Created;bin'; no column 'release'\)"):
        dw.simulate(before)


def test_other_orders_are_another_model(tmp_path):
    path = written(tmp_path / "orders.csv", "release,from\n0,1\n")
    before = model(path)
    assert model(path).digest() == before.digest()
    written(path, "release,from\n0,0\n")
    assert model(path).digest() != before.digest()


def test_a_quantity_is_so_many_tasks(tmp_path):
    run = dw.simulate(model(written(tmp_path / "orders.csv", "release,quantity\n0,3\n9,2\n")))
    assert [task.released for task in run.history.tasks.values()] == [0, 0, 0, 9, 9]
    assert run.kpis["tasks"] == 5
    assert run.kpis["orders"] == 2


# Resampling


def day_of(rates):
    """Orders of two rows, so many in each hour, evenly."""
    day = []
    for hour, rate in enumerate(rates):
        for n in range(rate):
            at, name = 3600.0 * hour + 3600 * n / rate, f"{hour}-{n}"
            day += [OrderLine(at, n, None, at + 60, None, 1, name), OrderLine(at, n, "D", None, None, 1, name)]
    return day


def test_resampling_keeps_the_pattern_of_the_day_and_whole_orders():
    rates, days = [20, 60, 5], 200
    counts = np.zeros((days, 3))
    for seed in range(days):
        streams = Streams(seed)
        drawn = list(resampled(iter(day_of(rates)), 3600, 1.0, lambda k, s=streams: s.stream("orders", k)))
        assert [line.release for line in drawn] == sorted(line.release for line in drawn)
        pairs = list(zip(drawn[::2], drawn[1::2], strict=True))
        assert all(one.order == two.order and one.release == two.release for one, two in pairs)
        assert len({one.order for one, _ in pairs}) == len(pairs)
        assert all(one.due - one.release == pytest.approx(60) for one, _ in pairs)
        counts[seed] = np.histogram([one.release for one, _ in pairs], 3, (0, 3 * 3600))[0]
    for hour, rate in enumerate(rates):
        low, high = stats.poisson.interval(0.999, days * rate)
        assert low <= counts[:, hour].sum() <= high
        assert stats.chi2.ppf(0.0005, days - 1) < counts[:, hour].var() / rate * days < stats.chi2.ppf(0.9995, days - 1)


def test_resampled_replications_differ_and_follow_demand(tmp_path):
    rows = "".join(f"{60 * n},{n % 2}\n" for n in range(60))
    path = written(tmp_path / "orders.csv", "release,from\n" + rows)
    changes = {"run.length": 3600, "log": "tasks"}
    runs = [dw.simulate(model(path, changes, resample=900), seed) for seed in (1, 2)]
    times = [[task.released for task in run.history.tasks.values()] for run in runs]
    assert times[0] != times[1]
    assert 30 < len(times[0]) < 90
    twice = dw.simulate(model(path, {**changes, "tasks.demand": 3}, resample=900), 1)
    assert 120 < len(twice.history.tasks) < 240
    with pytest.raises(ModelError, match=r"run.length: missing, .*flows.day goes on for ever"):
        model(path, resample=900)


# Many


@pytest.mark.long
def test_a_million_orders_take_no_more_memory_than_some_thousand(tmp_path):
    size = 1_000_000
    rng = np.random.default_rng(1)
    table = pd.DataFrame(
        {
            "release": pd.Timestamp("2026-03-02 06:00") + pd.to_timedelta(np.sort(rng.uniform(0, 57600, size)), "s"),
            "from": rng.integers(0, 600, size),
            "to": rng.choice(["pack", "dock"], size),
            "quantity": 1,
        }
    )
    path = tmp_path / "orders.parquet"
    table.to_parquet(path, row_group_size=100_000)
    del table
    how = Reading(frozenset({"pack", "dock"}), 600, "06:00", 1.0)
    spec = OrdersFile(file=str(path))
    began = time.perf_counter()
    assert summary(spec, how).tasks == size
    print(f"{size / (time.perf_counter() - began):,.0f} rows a second")  # noqa: T201 - for performance.md
    tracemalloc.start()
    assert sum(1 for _ in read(spec, how)) == size
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 120e6  # a chunk of 50,000 rows; all of them would be some 400 MB
