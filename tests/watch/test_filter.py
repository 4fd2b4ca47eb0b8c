"""The filter and the detector against what they stand for, computed the long way."""

from copy import deepcopy
from types import SimpleNamespace

import numpy as np
import pytest
from drawn_nights import world
from scipy.special import logsumexp

from pyport.formats.models import load
from pyport.noise.series import Noise
from pyport.recordings.from_table import from_table
from pyport.watch import steps
from pyport.watch.detection import antenna, composite, detector, null
from pyport.watch.detection.baseline import LEAST_DOF, _drifts, past
from pyport.watch.detection.composite import calibrated
from pyport.watch.detection.prepare import prepare


@pytest.fixture(scope="module")
def known():
    """Return a baseline, the null after the past, and the rows of a night."""
    drawn = world()
    before = past(from_table(drawn.past, drawn.header), load("altaz"))
    _, nulls = calibrated(before)
    return before.baseline, nulls, prepare(before.baseline, from_table(drawn.watched, drawn.header))


def gaussian(start, monkeypatch):
    """Let the filter take every reading for one of a normal of known scale."""
    monkeypatch.setattr(null, "weight", lambda *_: (1.0, 1.0))
    start.learning = False
    start.scale = np.ones(2)


@pytest.mark.slow
def test_a_change_taken_over_is_what_a_filter_with_it_from_the_start_finds(known, monkeypatch):
    """The biases that are followed give the joint state exactly, whatever else is filtered."""
    baseline, past_nulls, rows = known
    states = past_nulls.levels[0].states
    layout = detector.layout(baseline.changes)
    nulls = composite.begin(states, layout)
    start = nulls.levels[0].null
    gaussian(start, monkeypatch)
    watch = antenna.begin(baseline, layout, nulls, 1e300)
    monkeypatch.setattr(detector, "learnt", lambda scale, *_: scale)
    monkeypatch.setattr(detector, "log_density", lambda square, *_: 0 * square)
    monkeypatch.setattr(detector, "log_usual", lambda square, *_: 0 * square)
    # weights of the changed telescope are then one: a normal of unit scale
    start.tail, start.dof, start.outliers = 0.0, np.full(2, 1e12), 0.0
    monkeypatch.setattr(null, "LEAST_GROSS", 1e-300)
    for n in range(20):
        steps.take(watch, rows, n, {}, 1)
    change = next(k for k, one in enumerate(baseline.changes) if one.effect.id == "tilt")
    first, size = 0, len(baseline.changes[change].prior)
    places = watch.layout.place[change, :size]
    wide = np.zeros((len(states) + size,) * 2)
    wide[: len(states), : len(states)] = states.covariance
    wide[len(states) :, len(states) :] = baseline.changes[change].prior
    mean = np.concatenate([states.mean, np.zeros(size)])
    one = null.Null(mean, wide)
    gaussian(one, monkeypatch)
    for n in range(20):
        null.advance(one, states, rows, n)
        for axis in (0, 1):
            column = np.concatenate([rows.nuisance[n, axis], rows.change[n, axis][places]])
            null.take(one, axis, rows.value[n, axis], column, rows.variance[n, axis])
    assert watch.detector.row[first] == 1
    watch.pending = 1
    steps.adopt(watch, first, change, None, watch.detector)

    sigma = np.sqrt(np.diag(one.covariance))
    assert np.abs((watch.null.mean - one.mean) / sigma).max() < 1e-5
    assert (
        np.abs(
            watch.null.covariance / np.outer(sigma, sigma) - one.covariance / np.outer(sigma, sigma)
        ).max()
        < 1e-5
    )


def test_every_likelihood_ratio_has_the_expectation_one(known):
    """Whatever came before, the mean of what a reading multiplies a ratio by is one at most."""
    baseline, nulls, rows = known
    start, states = nulls.levels[0].null, nulls.levels[0].states
    layout = detector.layout(baseline.changes)
    scale, degrees, share, tail = 1.3, 20.0, 0.01, 0.05
    before = null.Predictive(scale, degrees, share, tail)
    own = detector.fresh(layout, start)
    detector.start(own, layout, start, 1, 0.0, np.zeros(layout.members + 1))

    def told(own, value, n, axis):
        one = null.Innovation(axis, value, 3e-5, np.zeros(len(states)))
        columns = rows.nuisance[n, axis], rows.change[n, axis]
        detector.update(own, layout, one, *columns, before)

    for n, value in enumerate((2.0, -1.0, 3.0, 6.0)):
        told(own, value, n, n % 2)
    # far into the tails of both densities
    grid = np.sinh(np.linspace(-9, 9, 1801))
    wide = [null.log_gross(u * u, scale, share) for u in grid]
    density = np.exp(
        [null.log_density(u * u, scale, degrees, share, w) for u, w in zip(grid, wide, strict=True)]
    )
    ratios = []
    for value in grid:
        other = deepcopy(own)
        told(other, float(value), 5, 1)
        ratios.append(np.exp(other.log_mass - own.log_mass)[0])
    mean = np.trapezoid(density[:, None] * np.array(ratios), grid, axis=0)

    assert np.allclose(mean[:-1], 1, atol=2e-3)
    assert mean[-1] <= 1 + 1e-9


def test_starts_are_kept_near_and_thinned_far(known):
    """However long one watches there are as many starts, the newest ones without a gap."""
    baseline, nulls, _ = known
    start = nulls.levels[0].null
    layout = detector.layout(baseline.changes)
    own = detector.fresh(layout, start)
    for row in range(1, 2000):
        detector.start(own, layout, start, row, float(row), np.zeros(layout.members + 1))

    assert len(own.row) == detector.STARTS
    assert np.all(np.diff(own.row) > 0)
    assert own.row[-1] == 1999
    assert own.row[0] < 1000
    # the mass of what was merged is kept: one for each pointing
    none = np.zeros(layout.members + 1)
    assert np.exp(detector.evidence(own, layout, none)) == pytest.approx(1999, rel=1e-9)


def test_a_ratio_is_taken_to_the_best_of_what_may_have_stood(known):
    """Nothing that an effect explains that was always there counts for a change since."""
    baseline, nulls, rows = deepcopy(known)
    first, layout = nulls.levels[0], detector.layout(baseline.changes)
    own = detector.fresh(layout, first.null)
    for n in range(4):
        composite.advance(nulls, rows, n)
        detector.start(own, layout, first.null, n, float(n), nulls.log_ratio)
        rows.value[n, n % 2] += 6 * np.sqrt(rows.variance[n, n % 2])
        one, before, nuisance = composite.take(nulls, layout, rows, n, n % 2)
        detector.update(own, layout, one, nuisance, rows.change[n, n % 2], before)
    alone = own.log_mass + layout.log_share
    beside = detector.log_odds(own, layout, nulls.log_ratio)
    since = np.maximum((nulls.log_ratio - own.stood).max(1), 0)

    assert since.max() > 0.5
    np.testing.assert_allclose(alone - beside, np.repeat(since[:, None], alone.shape[1], 1))
    assert detector.evidence(own, layout, nulls.log_ratio) < logsumexp(alone) - 0.3


def test_the_weights_of_wilder_nights_are_those_of_their_likelihoods(known):
    """The mixture over levels of noise is the one computed from each level filtered alone."""
    baseline, past_nulls, rows = known
    layout = detector.layout(baseline.changes)
    nulls = composite.begin(past_nulls.levels[0].states, layout)
    alone = [null.begin(level.states) for level in nulls.levels]
    log_likelihood = np.zeros(3)
    for n in range(12):
        composite.advance(nulls, rows, n)
        for k, one in enumerate(alone):
            null.advance(one, nulls.levels[k].states, rows, n)
        for axis in (0, 1):
            composite.take(nulls, layout, rows, n, axis)
            for k, one in enumerate(alone):
                before = null.predictive(one, axis)
                column, variance = rows.nuisance[n, axis], rows.variance[n, axis]
                seen = null.take(one, axis, rows.value[n, axis], column, variance)
                log_likelihood[k] += before.log_density(seen.value**2) - np.log(seen.sigma)
    joint = np.log([1 / 2, 1 / 4, 1 / 4]) + log_likelihood

    assert nulls.nights == 1
    np.testing.assert_allclose(nulls.log_weight[:, -1], joint - logsumexp(joint), atol=1e-9)
    assert nulls.log_ratio[-1] == pytest.approx(logsumexp(joint) - log_likelihood[0])


def test_a_drift_that_outlasts_the_past_stands_for_what_it_changes_within_it():
    """However strong it would become: a fainter one of an hour is not left out beside it."""
    hour, span = 3600.0, 86400.0
    part = SimpleNamespace(span=span, is_y=True)
    drifts = ((1.0, hour), (50.0, 400 * span))
    noise = SimpleNamespace(parts=[part], noises=[Noise(0.0, 1.0, drifts)])
    short, long = _drifts(SimpleNamespace(noise=noise))

    assert (short.memory_s, long.memory_s) == pytest.approx((hour, span))
    assert short.covariance[0, 0] == pytest.approx(24 / 22)
    assert long.covariance[0, 0] == pytest.approx(50.0**2 / 400 * LEAST_DOF / (LEAST_DOF - 2))
