"""Figures and page of real days held against a model: what stands where, and what is said of it."""

import numpy as np
import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ReportError
from desim_warehouse.fleet_log.ranks import ranked
from desim_warehouse.fleet_log.runs import from_run
from desim_warehouse.fleet_log.validate import Validation
from desim_warehouse.plot.days import LESS, MORE
from desim_warehouse.report import validation_page
from desim_warehouse.report.example import example

plot = dw.plot


@pytest.fixture(scope="module")
def model():
    return example().replace({"run.length": 1800, "run.warm_up": 0, "log": "all", "fleet.start_energy": 0.9})


@pytest.fixture(scope="module")
def day(model):
    """What the robots of the model reported every five seconds in half an hour."""
    return from_run(dw.simulate(model, 77), 5.0)


@pytest.fixture(scope="module")
def right(model, day):
    return dw.validate(model, [day], runs=39)


@pytest.fixture(scope="module")
def wrong(model, day):
    """The same day against a model with a sixth of the orders."""
    return dw.validate(model.replace({"tasks.goods.poisson": 10}), [day], runs=39)


def steps(ax):
    """What each outline of a figure is called: its values, and what is below it."""
    return {patch.get_label(): (patch.get_data().values, patch.get_data().baseline) for patch in ax.patches}


def by_hand(model, real, simulated):
    """Three robots an hour came along each edge on all days, but on the first two edges; robots stood nowhere."""
    edges = model.floor.graph.number_of_edges()
    chance = np.random.default_rng(0).normal(0, 0.1, (1, 40, edges))
    passed = ranked(np.full((1, edges), 3.0), 3 + chance, alike=True)
    passed.real[0, :2] = 9, 0.5
    passed = ranked(passed.real, passed.simulated, alike=True)
    stood = ranked(np.zeros((1, edges)), np.zeros((1, 40, edges)), alike=True)
    drops = ranked(np.array([real]), np.array([simulated]))
    hours = np.arange(len(real) + 1) * 3600.0
    measures = ranked(np.array([[30.0]]), np.array([[[30.0 + n % 3] for n in range(40)]]))
    return Validation(model, ("monday",), ("drops_per_hour",), measures, (hours,), (drops,), passed, stood)


def test_a_verdict_prints_as_lines_and_a_table_of_its_measures(model):
    """On the real day 30 loads an hour were put down, on 40 simulated days 30, 31 or 32."""
    monday = by_hand(model, [3.0], [[3.0 + n % 2] for n in range(40)])
    verdict, power, head, measure = str(monday).splitlines()
    assert verdict.startswith("not refuted (1 day, 40 simulated for each, p = ")
    assert power.endswith("for drops per hour")
    assert head.split() == ["Measure", "Real", "Simulated", "Band", "Verdict"]
    assert measure.split()[:5] == ["Drops", "per", "hour", "30", "31"]
    assert repr(monday) == f"Validation({model.name}: {verdict})"
    row = monday.table.iloc[0]
    assert (row["name"], row["real"], row["simulated"], row["outside"]) == ("drops_per_hour", 30, 30.975, False)


def test_the_line_of_a_right_day_lies_in_the_band(right):
    shown = steps(plot.real_day(right))
    high, low = shown["band of 39 simulated days"]
    line, _ = shown["real day"]
    assert right.drops[0].real[0].tolist() == line.tolist()
    assert ((low <= line) & (line <= high)).all()
    assert line.sum() > 0
    assert len(plot.real_day(right).lines) == 0
    for number in (-1, len(right.days), 0.5, "a"):
        with pytest.raises(dw.ReportError, match=f"day {number!r}: there are days 0 to"):
            plot.real_day(right, number)
    assert not right.refuted


def test_drops_over_the_day_add_up_to_those_of_the_run(right, model):
    run = dw.simulate(model, 77)
    hours = np.diff(right.parts[0]) / 3600
    put_down = sum(task.delivered <= right.parts[0][-1] for task in run.history.done)
    assert (right.drops[0].real[0] * hours).sum() == pytest.approx(put_down, abs=1.01)


def test_robots_along_an_edge_are_those_of_the_run(model):
    """With a message each second: in five a robot drives from bay to bay, over two edges, unseen."""
    model = model.replace({"run.length": 600})
    run = dw.simulate(model, 77)
    right = dw.validate(model, [from_run(run, 1.0)], runs=39)
    edges = [">".join(edge) for edge in model.floor.graph.edges]
    hours = right.parts[0][-1] / 3600
    assert right.passed.real[0] * hours == pytest.approx(run.edges.loc[edges, "passages"].to_numpy(), abs=2)


def test_the_line_of_a_day_with_more_orders_leaves_the_band(wrong):
    ax = plot.real_day(wrong)
    shown = steps(ax)
    high, _ = shown["band of 39 simulated days"]
    out = shown["real day"][0] > high
    assert out.any()
    (marks,) = ax.lines
    assert len(marks.get_xdata()) == out.sum()
    assert wrong.refuted


def test_an_hour_without_messages_is_left_blank(model):
    simulated = [[20.0 + n % 5, 30.0 + n % 4, 25.0 - n % 3] for n in range(40)]
    validation = by_hand(model, [21.0, np.nan, 40.0], simulated)
    assert validation.drops[0].out.tolist() == [False, False, True]
    line, _ = steps(plot.real_day(validation))["real day"]
    assert np.isnan(line).tolist() == [False, True, False]


def test_edges_outside_are_coloured_and_named(model):
    validation = by_hand(model, [3.0], [[3.0 + n % 2] for n in range(40)])
    first, second, *_ = (">".join(edge) for edge in model.floor.graph.edges)
    ax = plot.passages(validation)
    marks = {line.get_label(): line for line in ax.lines}
    assert marks["more than simulated"].get_ydata().tolist() == [9]
    assert marks["less than simulated"].get_ydata().tolist() == [0.5]
    assert {text.get_text() for text in ax.texts} == {first, second}
    floor = plot.residuals(validation)
    lanes = floor.collections[0]
    assert lanes.get_linewidths()[:3] == [5, 5, 2.5]
    red, _, blue, _ = np.array(lanes.get_colors()).T
    assert red[0] > blue[0]
    assert red[1] < blue[1]
    assert MORE != LESS
    assert any(text.get_text().startswith(f"{first} +6") for text in floor.texts)


def test_trips_do_not_say_where_robots_drove(model):
    from dataclasses import replace

    validation = replace(by_hand(model, [3.0], [[3.0 + n % 2] for n in range(40)]), passed=None, stood=None)
    with pytest.raises(ReportError, match="logs of trips do not say where robots drove"):
        plot.residuals(validation)
    with pytest.raises(ReportError, match="by 'x': expected passed or stood"):
        plot.residuals(validation, by="x")
    html = validation_page.page(validation)
    assert "Where robots drove" not in html


def test_the_page_begins_with_the_verdict_and_its_power(wrong):
    html = validation_page.page(wrong, "desim validate m.yaml").replace("\u00a0", " ")
    begins = ("Refuted by", "To notice a 10 %", "<img", "<table")
    verdict, power, figure, table = (html.index(words) for words in begins)
    assert verdict < power < figure < table
    assert "desim validate m.yaml" in html
    assert html.count("<img") == 4
