"""Distributions proposed for measured times: the right family and its parameters, and what fits none."""

import numpy as np
import pytest

from desim_warehouse.errors import StudyError
from desim_warehouse.study.fit import Counted, _distance, families, fit, fit_between
from desim_warehouse.values.distributions import UniformTime
from tests.daily import some

pytestmark = pytest.mark.usefixtures("fewer_samples")


DRAWN = {
    "lognormal": lambda rng: rng.lognormal(2, 0.5, 600),
    "gamma": lambda rng: rng.gamma(2, 4, 600),
    "exponential": lambda rng: rng.exponential(8, 600),
    "weibull": lambda rng: 9 * rng.weibull(3, 600),
    "uniform": lambda rng: rng.uniform(4, 12, 600),
    "triangular": lambda rng: rng.triangular(4, 6, 12, 600),
}
ROUNDED = {kind: draw for kind, draw in DRAWN.items() if kind != "uniform"} | {
    "lognormal": lambda rng: rng.lognormal(np.log(5) - 0.08, 0.4, 300)
}


@pytest.mark.parametrize("kind", some(DRAWN, 2))
def test_the_family_that_times_were_drawn_from_is_proposed(kind):
    times = DRAWN[kind](np.random.default_rng(3))
    proposal = fit(times)
    assert proposal.best.kind == kind
    assert proposal.fits
    assert proposal.best.mean == pytest.approx(times.mean(), rel=0.03)
    assert proposal.best.cv == pytest.approx(times.std() / times.mean(), rel=0.1)
    assert [one.aic for one in proposal.candidates] == sorted(one.aic for one in proposal.candidates)


@pytest.mark.parametrize("kind", some(ROUNDED, 2))
def test_whole_seconds_give_back_the_family_and_its_parameters(kind):
    """A stopwatch reads 5 for all from 4.5 to 5.5: it was said that nothing fits, in 12 of 12."""
    exact = ROUNDED[kind](np.random.default_rng(3))
    proposal = fit(np.round(exact))
    assert proposal.step == 1.0
    assert proposal.best.kind == kind
    assert proposal.fits
    assert proposal.best.mean == pytest.approx(exact.mean(), rel=0.03)
    assert proposal.best.cv == pytest.approx(exact.std() / exact.mean(), rel=0.1)


def test_the_corners_of_a_triangle_are_found_from_whole_seconds():
    times = np.round(np.random.default_rng(8).triangular(10, 20, 60, 2000))
    assert fit(times).best.triangular == pytest.approx((10, 20, 60), abs=1.5)


def test_steps_that_are_small_beside_the_spread_change_nothing():
    times = np.random.default_rng(3).gamma(2, 40, 100)
    assert fit(np.round(times, 1)).step == 0.0
    assert fit(np.round(times)).best.mean == pytest.approx(times.mean(), rel=0.01)


def test_two_kinds_of_picks_in_whole_seconds_fit_no_curve():
    rng = np.random.default_rng(5)
    assert not fit(np.round([*rng.normal(5, 1, 200), *rng.normal(20, 1, 100)])).fits


def test_the_criterion_is_scipys_likelihood_by_hand():
    times = np.random.default_rng(5).exponential(8, 50)
    (aic,) = (one.aic for one in fit(times).candidates if one.distribution.kind == "exponential")
    # log L = -n (ln mean + 1), one parameter
    assert aic == pytest.approx(2 + 2 * 50 * (np.log(times.mean()) + 1))


PARAMETERS = {
    "exponential": [(0.0, 8.0)],
    "gamma": [(2.5, 0.0, 4.0), (0.5, 0.0, 4.0)],
    "lognormal": [(0.5, 0.0, 8.0)],
    "weibull": [(3.0, 0.0, 9.0), (0.7, 0.0, 9.0)],
    "uniform": [(4.0, 8.0)],
    "triangular": [(0.25, 4.0, 8.0), (0.0, 4.0, 8.0), (1.0, 4.0, 8.0)],
}


@pytest.mark.parametrize(("kind", "parameters"), [(kind, one) for kind, all_ in PARAMETERS.items() for one in all_])
def test_a_likelihood_is_scipys(kind, parameters):
    family, x = families()[kind], np.array([4.1, 5.0, 6.0, 7.3, 11.9])
    exactly = family.scipy.logpdf(x, *parameters).sum()
    assert family.cost(parameters, Counted.of(x, 0.0)) == pytest.approx(-exactly)
    wide = np.array([6.0, 12.0])
    rounded = np.log(family.scipy.cdf(wide + 3, *parameters) - family.scipy.cdf(wide - 3, *parameters)).sum()
    assert family.cost(parameters, Counted.of(wide, 6.0)) == pytest.approx(-rounded)


@pytest.mark.parametrize("kind", ["uniform", "triangular"])
def test_a_time_beyond_the_ends_is_impossible(kind):
    for beyond in (3.0, 12.5):
        assert families()[kind].cost(PARAMETERS[kind][0], Counted.of(np.array([beyond]), 0.0)) == np.inf


def test_the_distance_is_that_of_cramer_and_von_mises_by_hand():
    """Four times between 0 and 1: in the middle of each quarter 1/48; all at 0.5 it is 2 (3/8² + 1/8²) more."""
    uniform = families()["uniform"]
    assert _distance(uniform, (0.0, 1.0), np.array([0.875, 0.125, 0.625, 0.375]), 0.0) == pytest.approx(1 / 48)
    assert _distance(uniform, (0.0, 1.0), np.full(4, 0.5), 0.0) == pytest.approx(1 / 48 + 20 / 64)


def test_the_distance_of_rounded_times_is_measured_where_their_steps_end():
    """Twice 1 and twice 3 s of 0 to 4: up to 1.5, 2.5 and 3.5 s it is 3, 5 and 7 of 8, each 1/8 off what was seen."""
    times = np.array([1.0, 3.0, 1.0, 3.0])
    assert _distance(families()["uniform"], (0.0, 4.0), times, 1.0) == pytest.approx(4 * 7 / 8 / 8**2)


def test_a_uniform_time_is_tried_from_its_least_to_its_largest_and_never_below_0():
    made = families()["uniform"].made
    assert made(np.array([10.0, 40.0])) == (10, 30)
    assert made(np.array([-1.0, 40.0])) == (0, 40)


def test_times_between_two_looks_of_a_clock_have_no_ends_where_the_clock_put_them():
    """Of 40 times between 10 and 20 s, none likelier than another, begin and end are known to a second."""
    times = np.linspace(10, 20, 40)[:, None]
    begun = np.tile([0.0, 1.0], (40, 1))
    assert fit(times[:, 0]).best == UniformTime(uniform=(10, 20))
    assert not isinstance(fit_between(begun, times + begun), UniformTime)


def test_two_kinds_of_picks_fit_no_curve():
    rng = np.random.default_rng(5)
    assert not fit([*rng.normal(5, 0.3, 200), *rng.normal(20, 1, 100)]).fits


def test_with_thousands_of_times_some_are_tested():
    proposal = fit(np.random.default_rng(5).exponential(8, 20_000))
    assert proposal.best.kind in {"exponential", "gamma", "weibull"}  # which are all but the same here
    assert proposal.fits


def test_a_time_of_0_rules_out_what_has_none():
    proposal = fit([0.0, *np.random.default_rng(5).exponential(8, 50)])
    assert {one.distribution.kind for one in proposal.candidates} == {"exponential", "uniform"}


@pytest.mark.parametrize(
    ("times", "message"),
    [([1.0, 2.0], "too few"), ([5.0] * 30, "all times are 5"), ([-1.0, *range(30)], "negative or no numbers")],
)
def test_what_says_nothing_is_refused(times, message):
    with pytest.raises(StudyError, match=message):
        fit(times)
