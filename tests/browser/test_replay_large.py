"""A thousand robots: the page shows them all where they are; how fast is reported, not judged."""

import re

import numpy as np
import pytest

import desim_warehouse as dw
from benchmarks import replay as benchmark
from desim_warehouse.outcome.positions import Positions
from tests.browser.pages import Page


@pytest.fixture(scope="module")
def run():
    return dw.simulate(dw.load(benchmark.large(1000, 600.0)), seed=1)


@pytest.mark.long
def test_a_thousand_robots_are_drawn_where_they_are(browser, tmp_path, run):
    page, where = Page(browser, run, tmp_path), Positions(run.history)
    for time in np.random.default_rng(7).uniform(0, 600, 5):
        off = np.array(page.ask("page.positions(arguments[0])", float(time))) - where.points(float(time))
        assert len(off) == 1000
        assert np.abs(off).max() * page.ask("page.scale()") < 1
    assert page.complaints() == []
    assert page.requests() == []


@pytest.mark.long
def test_an_hour_of_a_thousand_robots_fits_into_15_megabytes(run):
    """Ten minutes, as full of drives as any, in a sixth of that."""
    assert len(run.replay().html.encode()) * 6 <= 15e6


@pytest.mark.long
def test_load_time_and_frame_rate_are_reported(browser, tmp_path, run, record_property, capsys):
    timings = benchmark.measure(run, tmp_path)
    assert timings["frames_per_second"] > 0
    line = ", ".join(f"{key} {value:.4g}" for key, value in timings.items())
    record_property("replay of 1,000 robots", line)
    with capsys.disabled():
        print(f"\nreplay of 1,000 robots for 600 s: {line}")  # noqa: T201
    assert re.search(r"load_seconds [\d.]+", line)
