"""Figures by their data: what stands where, not how it looks."""

import io
import math

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from PIL import Image

import desim_warehouse as dw
from desim_warehouse.errors import ReportError
from desim_warehouse.look import palette
from desim_warehouse.outcome import day as outcome
from desim_warehouse.plot import paths
from desim_warehouse.plot.heat import edge_values
from desim_warehouse.study.statistics.warmup import mser, welch
from desim_warehouse.study.table import cells
from desim_warehouse.study.warm_up import settle
from tests.report.replay.floors import people_run, spurs_run
from tests.world.test_lifts import TWO

plot = dw.plot
HALF_WIDTH = 4.302652729911275 / np.sqrt(3)
"""Of three values 0, 1, 2: t quantile at 0.975 with 2 degrees of freedom, times 1, over √3."""


def lines(ax):
    """Label -> x and y of each line with an interval."""
    by_label = {}
    for container in ax.containers:
        line = container.lines[0]
        by_label[container.get_label()] = list(line.get_xdata()), list(line.get_ydata())
    return by_label


def half_widths(container):
    (bars,) = container.lines[2]
    return [(segment[1][1] - segment[0][1]) / 2 for segment in bars.get_segments()]


def test_a_line_for_each_group_goes_through_the_means(runs, model):
    ax = plot.by_factor(runs, "fleet.size", "T", group="battery.threshold", model=model)
    assert lines(ax) == {"2": ([1, 2, 4], [103, 203, 403]), "5": ([1, 2, 4], [106, 206, 406])}
    for container in ax.containers:
        assert half_widths(container) == pytest.approx([HALF_WIDTH] * 3)
    assert ax.get_xlabel() == "Number of robots, fleet.size"
    assert ax.get_ylabel() == "Task time (step)"
    assert ax.get_legend().get_title().get_text() == "Charging threshold (energy)"
    assert ax.get_title() == ""


def test_other_factors_are_averaged_over_within_each_replication(runs):
    ax = plot.by_factor(runs, "fleet.size", "T")
    (((x, y)),) = lines(ax).values()
    assert (x, y) == ([1, 2, 4], [104.5, 204.5, 404.5])
    assert half_widths(ax.containers[0]) == pytest.approx([HALF_WIDTH] * 3)  # of 3 replications, not of 6 runs
    assert ax.get_xlabel() == "Number of robots, fleet.size\naveraged over battery.threshold"


def test_every_figure_of_a_table_says_what_it_averages_over(runs):
    """Three factors: whoever shows one or two of them says so, as far as the rest varies at all."""
    table = pd.concat([runs.assign(rule=rule) for rule in ("nearest", "in-order")], ignore_index=True)
    table = table[["rule", *runs.columns]].assign(**{f"share_{state}": 0.125 for state in palette.STATE_COLOURS})

    def second_line(ax):
        return ax.get_xlabel().partition("\n")[2]

    assert second_line(plot.by_factor(table, "rule", "T")) == "averaged over fleet.size, battery.threshold"
    assert second_line(plot.by_factor(table, "rule", "T", group="fleet.size")) == "averaged over battery.threshold"
    assert second_line(plot.throughput(table, "fleet.size", "T")) == "averaged over rule, battery.threshold"
    assert second_line(plot.utilisation(table, "rule")) == "averaged over fleet.size, battery.threshold"
    some = table[table["battery.threshold"] == 2]
    assert second_line(plot.by_factor(some, "rule", "T", group="fleet.size")) == ""
    paired = table[table["battery.threshold"] == np.where(table["rule"] == "nearest", 2, 5)]
    assert second_line(plot.by_factor(paired, "rule", "T", group="fleet.size")) == ""


def test_a_panel_for_each_level_of_a_further_factor_averages_over_nothing(runs):
    table = pd.concat([runs.assign(rule=rule, T=runs["T"] + add) for rule, add in (("a", 0), ("b", 1000))])
    table = table[["rule", *runs.columns]]
    first = plot.facets(table, "fleet.size", "T", group="battery.threshold", by=["rule"])
    panels = first.figure.axes
    assert [ax.get_title("left") for ax in panels] == ["rule: a", "rule: b"]
    assert [lines(ax)["5"][1] for ax in panels] == [[106, 206, 406], [1106, 1206, 1406]]
    assert len({ax.get_ylim() for ax in panels}) == 1
    assert panels[0].get_ylim()[1] > 1406
    assert "averaged" not in "".join(ax.get_xlabel() for ax in panels)
    assert [ax.get_legend() is not None for ax in panels] == [False, True]
    with pytest.raises(ReportError, match="at least one factor"):
        plot.facets(table, "fleet.size", "T", by=[])


def test_a_replication_that_lacks_a_failed_run_is_left_out_of_the_average(runs):
    failed = runs.copy()
    lost = (failed["fleet.size"] == 2) & (failed["battery.threshold"] == 2) & (failed["replication"] == 2)
    failed.loc[lost, "T"] = np.nan
    (((_, y)),) = lines(plot.by_factor(failed, "fleet.size", "T")).values()
    assert y == [104.5, 204.0, 404.5]  # of (202 + 205) / 2 and (203 + 206) / 2; 207 alone is not taken


def test_times_are_shown_in_seconds_and_counts_as_they_are(runs, model):
    ax = plot.by_factor(runs.assign(S=runs["T"]), "fleet.size", "T", model=model, seconds=True)
    assert ax.get_ylabel() == "Task time (s)"
    assert next(iter(lines(ax).values()))[1] == pytest.approx([104.5 * 0.05, 204.5 * 0.05, 404.5 * 0.05])
    counted = plot.by_factor(runs.assign(S=runs["T"]), "fleet.size", "S", model=model, seconds=True)
    assert next(iter(lines(counted).values()))[1] == [104.5, 204.5, 404.5]
    with pytest.raises(ReportError, match="expected a model"):
        plot.by_factor(runs, "fleet.size", "T", seconds=True)


def test_named_levels_are_bars_in_the_order_of_the_table(runs):
    table = runs.assign(rule=["nearest" if size == 1 else "in-order" for size in runs["fleet.size"]])
    ax = plot.by_factor(table, "rule", "T", group="battery.threshold")
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["nearest", "in-order"]
    heights = [bar.get_height() for bar in ax.patches]
    assert heights == [103, 303, 106, 306]


def test_no_interval_where_chance_plays_no_part_or_there_is_one_replication(runs):
    once = runs[runs["replication"] == 0]
    ax = plot.by_factor(once[once["battery.threshold"] == 2], "fleet.size", "T")
    assert not ax.containers[0].has_yerr
    same = runs.assign(T=7.0, deterministic=True)
    assert not plot.by_factor(same, "fleet.size", "T").containers[0].has_yerr
    assert plot.by_factor(runs.assign(T=7.0), "fleet.size", "T").containers[0].has_yerr  # agree so far


def test_many_numbers_are_points_without_a_line():
    table = pd.DataFrame({"x.y": np.arange(40.0), "replication": 0, "T": np.arange(40.0) ** 2})
    assert plot.by_factor(table, "x.y", "T").containers[0].lines[0].get_linestyle() == "None"


def test_the_knee_of_a_throughput_curve_is_marked(model):
    sizes = [1, 2, 3, 4, 5, 6, 7, 8]
    rates = [100, 200, 300, 310, 315, 318, 320, 321]
    table = pd.DataFrame({"fleet.size": sizes, "replication": 0, "throughput_per_hour": rates})
    ax = plot.throughput(table, model=model)
    marks = {line.get_label(): line for line in ax.lines if not line.get_label().startswith("_")}
    assert marks["knee: 3"].get_xdata()[0] == 3
    assert marks["95 % of the maximum: from 4"].get_ydata()[0] == pytest.approx(0.95 * 321)
    assert ax.get_ylabel() == "Throughput (tasks per hour)"


def test_utilisation_stacks_to_one_and_shows_the_tallies(run):
    ax = plot.utilisation(run)
    assert [label.get_text() for label in ax.get_yticklabels()][:2] == ["0 %", "20 %"]
    stacks = np.array([[bar.get_height() for bar in container] for container in ax.containers])
    np.testing.assert_allclose(stacks.sum(axis=0), 1.0)
    states = [state for state in palette.STATE_COLOURS if state in run.robots]
    np.testing.assert_allclose(stacks[states.index("loaded")], run.robots["loaded"] / run.T)
    np.testing.assert_allclose(stacks[states.index("waiting")], run.robots["waiting"] / run.T)


def test_utilisation_by_a_factor_shows_the_means(run):
    rows = [{"fleet.size": size, "replication": r, **run.kpis} for size in (1, 2) for r in (0, 1)]
    ax = plot.utilisation(pd.DataFrame(rows), "fleet.size")
    assert ax.containers[0][1].get_height() == pytest.approx(run.kpis["share_loaded"])
    with pytest.raises(ReportError, match="expected a factor"):
        plot.utilisation(pd.DataFrame(rows))


def test_a_gantt_row_adds_up_to_the_tallies(run):
    ax = plot.gantt(run)
    rows = [c for c in ax.collections if len(c.get_facecolor()) > 1]
    loaded = mpl.colors.to_rgba(palette.STATE_COLOURS["loaded"])
    for number, row in enumerate(rows):
        width = sum(
            np.ptp(path.vertices[:, 0])
            for path, colour in zip(row.get_paths(), row.get_facecolor(), strict=True)
            if tuple(colour) == loaded
        )
        waited = run.waits[run.waits["robot"] == number]
        assert width >= run.robots["loaded"][number] - 1e-9
        assert width <= run.robots["loaded"][number] + (waited["end"] - waited["start"]).sum() + 1e-9
    assert len(rows) == 6
    assert ax.get_xlabel() == "Time (step)"


def test_a_gantt_of_a_window_and_some_robots(run):
    ax = plot.gantt(run, start=200, end=400, robots=[4, 1])
    assert ax.get_xlim() == (200, 400)
    assert [tick.get_text() for tick in ax.get_yticklabels()] == ["4", "1"]
    for robots in ([6], [-1], ["a"], [1.5], [True], math.nan):
        with pytest.raises(ReportError, match="robots 0 to 5"):
            plot.gantt(run, robots=robots)
    for start, end in ((400, 400), (0, math.inf), (math.nan, 400), ("a", 400), (0, [1])):
        with pytest.raises(ReportError, match="expected it to have a length"):
            plot.gantt(run, start=start, end=end)


def test_batteries_are_as_the_log_says_at_every_change(lifelong):
    ax = plot.battery(lifelong)
    log = lifelong.log[lifelong.log["kind"].isin(["loading", "loaded", "unloading", "charging", "parked"])]
    for number in range(6):
        line = next(line for line in ax.lines if line.get_label() == f"robot {number}")
        mine = log[log["robot"] == number]
        assert len(mine) > 20
        np.testing.assert_allclose(np.interp(mine["time"], *line.get_data()), mine["value"], atol=1e-9)


def test_batteries_fall_at_the_rates_of_the_model_while_driving_and_while_waiting(lifelong):
    """Between corners the slope is one of the consumption rates, or 0 at rest; charging alone rises."""
    rates = np.array([0.0, 0.002, 0.003, 0.005, 0.006])
    standing = 0
    for times, levels in lifelong.history.energy_curves:
        long_enough = np.diff(times) > 1e-3
        slopes = -np.diff(levels)[long_enough] / np.diff(times)[long_enough]
        falling = slopes[slopes > -1e-9]
        assert np.abs(falling[:, None] - rates).min(axis=1).max() < 1e-6
        standing += int((np.abs(falling - 0.002) < 1e-6).sum())
    assert standing >= len(lifelong.waits) / 2


def test_congestion_colours_edges_and_nodes_by_the_tallies(lifelong):
    ax = plot.congestion(lifelong)
    edges = next(c for c in ax.collections if isinstance(c, mpl.collections.LineCollection))
    counted = lifelong.history.counted
    np.testing.assert_allclose(edges.get_array(), lifelong.edges["blocked"] / counted)
    nodes = ax.collections[-1]
    np.testing.assert_allclose(nodes.get_array(), lifelong.nodes["blocked"] / counted)
    assert edges.get_clim() == nodes.get_clim() == (0.01, 1)  # a scale of its own would alarm on any floor
    bar = ax.figure.axes[1]
    assert [text.get_text() for text in bar.get_yticklabels()] == ["1 to 5 %", "5 to 20 %", "over 20 %"]
    episodes = plot.congestion(lifelong, by="waits").collections[-1]
    np.testing.assert_allclose(episodes.get_array(), lifelong.nodes["waits"])


def test_the_layout_shows_nodes_arrows_goods_and_bays(model):
    ax = plot.layout(model)
    assert sorted(text.get_text() for text in ax.texts) == [*"ABCDEFGHIJKLMNOPQR", "charging"]
    (arrows,) = heads_of(ax)
    a_to_b = next(i for i, at in enumerate(arrows.middles) if at.imag == 25 and 25 < at.real < 175)
    assert arrows.ways[a_to_b] == 150
    assert len(arrows.ways) == 27
    goods, fetched, lanes, bays = (len(path.vertices) for path in paths_of(ax)[:4])
    assert (goods / 5, fetched / 5, lanes / 2, bays / 5) == (70, 10, 27, 6)
    low, high = ax.get_ylim()
    assert low > high  # y grows downwards, as in the model file


def paths_of(ax):
    """The path of each kind of shape; dots of nodes are no such shapes."""
    return [path for c in ax.collections if len(c.get_offsets()) == 1 for path in c.get_paths()]


def heads_of(ax):
    return [c for c in ax.collections if isinstance(c, paths.Heads)]


def test_arrow_heads_have_one_size_on_paper_and_point_along_their_lanes():
    ax = Figure(figsize=(4, 2), dpi=100).add_subplot()
    ax.set(xlim=(0, 100), ylim=(10, 0))
    paths.heads(ax, np.array([50 + 5j, 20 + 5j]), np.array([30 + 0j, 0 + 1j]), 0.2, "black", 1)
    ax.figure.draw_without_rendering()
    (path,) = heads_of(ax)[0].get_paths()
    x, y = ax.transData.transform([(50, 5), (20, 5)]).T
    right, down = path.vertices.reshape(2, 4, 2)
    np.testing.assert_allclose(right[:3], [(x[0] - 10, y[0] - 10), (x[0] - 10, y[0] + 10), (x[0] + 10, y[0])])
    np.testing.assert_allclose(down[2], (x[1], y[1] - 10))


def test_many_shapes_are_a_few_paths():
    ax = Figure().add_subplot()
    paths.lines(ax, [((i, 0), (i, 1)) for i in range(12_000)], "black", 1, 1)
    assert [len(path.vertices) for path in paths_of(ax)] == [10_000, 10_000, 4_000]


def test_a_two_way_lane_is_drawn_and_coloured_as_one():
    run = spurs_run()
    # four two-way lanes, and two lanes side by side; an arrow for each direction
    drawn = plot.layout(run)
    lanes = next(c for c in drawn.collections if c.get_zorder() == 2).get_paths()[0]
    ends = {tuple(map(tuple, line)) for line in lanes.vertices.reshape(-1, 2, 2)}
    assert len(ends) == 6
    assert ((0, 0), (12, 0)) in ends  # in the middle of the aisle
    assert ((24, 0), (36, 0)) not in ends  # beside the lane back
    places = np.concatenate([some.middles for some in heads_of(drawn)])
    assert len(places) == 10
    assert {8.4, 3.6} <= set(np.round(places, 6))  # apart, not one lozenge
    driven, values = run.edges["passages"], edge_values(run, "passages")
    assert len(values) == 6
    assert values["a", "b"] == driven["a>b"] + driven["b>a"] > 0
    assert values["c", "d"] == driven["c>d"]
    assert sum(values.values()) == driven.sum()
    coloured = next(c for c in plot.congestion(run).collections if isinstance(c, mpl.collections.LineCollection))
    assert len(coloured.get_segments()) == 6


def test_the_warm_up_is_cut_where_mser_says(lifelong):
    values = [100.0, 80, 60, 40, 20] * 4 + [10.0, 11, 9, 10, 10] * 20
    ax = plot.warm_up(values, label="Cycle time (step)")
    truncation = mser(values)
    assert truncation.truncate == 20
    cut = next(line for line in ax.lines if line.get_label().startswith("cut at 20"))
    assert list(cut.get_xdata()) == [20, 20]
    assert plot.warm_up(lifelong).get_ylabel() == "Cycle time (step)"


def test_a_run_too_short_for_a_warm_up_says_so(run):
    with pytest.raises(ReportError, match="10 tasks delivered, expected at least 30"):
        plot.warm_up(run)
    with pytest.raises(dw.StudyError, match="batch 'five': expected a whole number"):
        plot.warm_up(run, "five")


@pytest.mark.parametrize("kind", ["light", "print"])
def test_no_setting_leaks_and_no_global_figure_is_left(runs, kind):
    from matplotlib import pyplot as plt

    before = dict(mpl.rcParams)
    ax = plot.by_factor(runs, "fleet.size", "T", style=kind, title="Fleet")
    assert dict(mpl.rcParams) == before
    assert plt.get_fignums() == []
    assert ax.get_title(loc="left") == "Fleet"


def test_figures_draw_on_axes_they_are_given(runs):
    from matplotlib.figure import Figure

    mine = Figure().add_subplot()
    assert plot.by_factor(runs, "fleet.size", "T", ax=mine) is mine


def test_dollar_signs_and_markup_in_names_stay_as_they_are(runs):
    name = r"$\frac{1}$ <b> & مستودع"
    table = runs.assign(rule=name)
    ax = plot.by_factor(table, "rule", "T", title=name)
    ax.figure.draw_without_rendering()
    assert ax.get_xticklabels()[0].get_text().replace(r"\$", "$") == name


def test_jupyter_shows_the_figure_with_words_for_those_who_cannot_see_it(runs):
    picture, facts = plot.by_factor(runs, "fleet.size", "T")._repr_png_()
    assert picture.startswith(b"\x89PNG")
    assert facts["alt"] == "Task time by number of robots"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda t: plot.by_factor(t, "fleet", "T"), "no column fleet; the table has fleet.size"),
        (lambda t: plot.by_factor(t.assign(T=np.nan), "fleet.size", "T"), "no run has a value"),
        (lambda t: plot.by_factor(t, "fleet.size", "T", style="dark"), "expected one of light, print"),
        (lambda t: plot.by_factor(t, "fleet.size", "T", target=math.inf), "target inf: expected a number"),
        (lambda t: plot.by_factor(t, "fleet.size", "T", target="much"), "target 'much': expected a number"),
    ],
)
def test_what_cannot_be_drawn_is_said(runs, call, message):
    with pytest.raises(ReportError, match=message):
        call(runs)


def test_models_without_batteries_have_no_battery_figure(model):
    with pytest.raises(ReportError, match="have none"):
        plot.battery(dw.simulate(model.replace({"battery": None})))


def test_the_use_of_stations_and_chargers_follows_from_the_account_of_time():
    from desim_warehouse.questions.run import page as run_parts

    short = {"run.length": 5400, "run.warm_up": 1800, "log": "all", "tasks.goods": {"poisson": 300}}
    run = dw.simulate(dw.load("models/mir250.yaml", short))
    table = run_parts.resources(run)
    shown = {row[0]: row[1:] for row in table.rows}
    account = run.account("node")
    busy = 100 * account["unloading"]["r2c2"] / (2 * 3600)
    assert shown["packing (r2c2)"][1] == f"{busy:.1f} %"
    # the two chargers at r0c0, and nobody else's
    assert shown["charging (r0c0)"][0] == "2 chargers"
    assert "parking" not in str(table)
    few = run_parts.resources(dw.simulate(dw.load("models/mir250.yaml", {**short, "log": "tasks"})))
    assert (few.rows, few.note) == ((), "This needs a run with log: all.")


def test_a_welch_plot_shows_the_observations_and_their_moving_averages():
    values = [[100.0, 80, 60, 40, 20] * 4 + [10.0, 11, 9, 10, 10] * 20] * 2
    ax = plot.welch(values)
    series, *curves = ax.lines
    assert list(series.get_ydata()) == values[0]
    assert [curve.get_label() for curve in curves] == ["w = 2", "w = 6", "w = 18"]
    assert list(curves[1].get_ydata()) == pytest.approx(list(welch(values, 6)))
    (only,) = plot.welch(values[0], 10).lines[1:]
    assert only.get_label() == "w = 10"


def test_a_welch_plot_of_a_model_has_its_units_and_the_cut():
    model = dw.load("models/tutorial.yaml", {"tasks.goods": {"saturated": 5}, "run.length": 1800})
    warm_up = settle(model, replications=2, observations=60, observed="cycle_time")
    ax = plot.welch(warm_up)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("Time (s)", "Cycle time (s)")
    assert list(ax.lines[0].get_ydata()) == list(warm_up.series)
    cut = ax.lines[-1]
    assert cut.get_label() == "cut by MSER-5"
    assert list(cut.get_xdata()) == [warm_up.time] * 2


def test_no_word_beside_a_floor_is_cut_off_at_the_edge_of_its_picture():
    data, size = plot.congestion(people_run())._repr_png_()
    drawn = np.asarray(Image.open(io.BytesIO(data)).convert("L"))
    assert min(drawn[:, 0].min(), drawn[:, -1].min(), drawn[0].min(), drawn[-1].min()) == 255
    assert drawn.shape == pytest.approx((2 * size["height"], 2 * size["width"]), abs=2)


def test_figures_have_the_intervals_of_the_table_and_do_not_cut_them_off():
    from desim_warehouse.study.table import cells

    changes = {"tasks.goods": {"poisson": 100, "due_within": 60}, "run": {"length": 1800, "warm_up": 300}}
    study = dw.Study("models/tutorial.yaml", {"fleet.size": [2, 3]}, changes=changes, replications=3).run().results
    intervals = [cell.estimate.interval for cell in cells(study.table, ["fleet.size"], "on_time")]
    assert intervals == [study.estimate(study.runs(design), "on_time").interval for design in study.designs]
    low, high = plot.by_factor(study.table, "fleet.size", "on_time", target=0.5).get_ylim()
    ends = [end for interval in intervals for end in interval]
    assert low <= min(*ends, 0.5) <= max(*ends, 0.5) <= high


def test_a_share_in_other_units_is_judged_as_the_number_that_it_is():
    """In per cent it is no share of tasks any more: its interval is that of a mean."""
    table = pd.DataFrame({"fleet.size": [4] * 4, "replication": range(4), "on_time": [0.9, 0.92, 0.94, 0.96]})
    plain, counted = (
        cells(table.assign(**more), ["fleet.size"], "on_time", scale=100)[0].estimate for more in ({}, {"tasks": 50})
    )
    assert plain.interval == counted.interval
    assert plain.mean == pytest.approx(93)


def test_the_course_of_a_run_is_drawn_as_it_is_computed(lifelong):
    ax, course = plot.day(lifelong), outcome.day(lifelong.history)
    robots, delivered, *_, battery = ax.child_axes
    assert [area.get_label() for area in robots.collections] == [outcome.DOING[name] for name in course.robots]
    assert robots.get_ylim() == (0, 6)
    for lane, values in ((delivered, course.delivered), (battery, course.battery)):
        (curve,) = lane.patches
        assert list(curve.get_data()[0]) == values.tolist()
    assert [tick.get_text() for tick in battery.get_yticklabels()] == ["0", "100 %"]
    assert [tick.get_text() for tick in battery.get_xticklabels()][:2] == ["0 s", "60 s"]


def test_a_lift_is_a_broken_line_between_its_cabins_on_two_floors():
    ax = plot.layout(dw.load(TWO))
    assert "lift main" in [text.get_text() for text in ax.texts]
    (shaft,) = ax.lines
    assert shaft.get_xydata().tolist() == [[20, 0], [20, 30]]
    assert shaft.get_linestyle() == "--"
    (arrows,) = heads_of(ax)
    assert len(arrows.ways) == 2 * 4  # one each way on four two-way lanes, and none for rides
