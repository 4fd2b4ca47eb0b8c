"""The filter and the detector against what they stand for, computed the long way."""

from copy import deepcopy

import numpy as np
import pytest
from drawn_nights import world
from scipy.special import logsumexp

from pyport.formats.models import load
from pyport.recordings.from_table import from_table
from pyport.watch import adopt, antenna, detector, null, steps
from pyport.watch.baseline import past
from pyport.watch.calibrate import calibrated
from pyport.watch.prepare import prepare


@pytest.fixture(scope="module")
def known():
    """Return a baseline, its filter and states, and the rows of a night."""
    drawn = world()
    before = past(from_table(drawn.past, drawn.header), load("altaz"))
    start, states, _ = calibrated(before)
    return (
        before.baseline,
        start,
        states,
        prepare(before.baseline, from_table(drawn.watched, drawn.header)),
    )


def gaussian(start, monkeypatch):
    """Let the filter take every reading for one of a normal of known scale."""
    monkeypatch.setattr(null, "weight", lambda *_: (1.0, 1.0))
    start.learning = False
    start.scale = np.ones(2)


def test_a_change_taken_over_is_what_a_filter_with_it_from_the_start_finds(known, monkeypatch):
    """The biases that are followed give the joint state exactly, whatever else is filtered."""
    baseline, _, states, rows = known
    start = null.begin(states)
    gaussian(start, monkeypatch)
    layout = detector.layout(baseline.changes)
    watch = antenna.begin(baseline, states, start, detector.standing(layout, start), 1e300)
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
    adopt.adopt(watch, first, change, None, watch.detector)

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
    baseline, start, states, rows = known
    layout = detector.layout(baseline.changes)
    scale, degrees, share, tail = 1.3, 20.0, 0.01, 0.05
    before = scale, degrees, share, tail
    own = detector.fresh(layout, len(states))
    detector.start(own, layout, start, 1, 0.0, np.zeros(layout.members))

    def told(own, value, n, axis):
        one = null.Innovation(axis, value, 3e-5, np.zeros(len(states)))
        columns = rows.nuisance[n, axis], rows.change[n, axis]
        detector.update(own, layout, one, *columns, before)

    for n, value in enumerate((2.0, -1.0, 3.0, 6.0)):
        told(own, value, n, n % 2)
    # far into the tails of both densities
    grid = np.sinh(np.linspace(-6, 6, 1201))
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
    baseline, start, states, _ = known
    layout = detector.layout(baseline.changes)
    own = detector.fresh(layout, len(states))
    for row in range(1, 2000):
        detector.start(own, layout, start, row, float(row), np.zeros(layout.members))

    assert len(own.row) == detector.STARTS
    assert np.all(np.diff(own.row) > 0)
    assert own.row[-1] == 1999
    assert own.row[0] < 1000
    # the mass of what was merged is kept: one for each pointing
    stands = detector.standing(layout, start)
    assert np.exp(detector.evidence(own, layout, stands)) == pytest.approx(1999, rel=1e-9)


def test_a_ratio_is_taken_to_the_best_of_what_may_have_stood(known):
    """Nothing that an effect explains that was always there counts for a change since."""
    baseline, start, states, rows = known
    layout = detector.layout(baseline.changes)
    own, stands = detector.fresh(layout, len(states)), detector.standing(layout, start)
    for row in range(1, 5):
        detector.start(own, layout, start, row, float(row), stands.log_mass[0, : layout.members])
        one = null.Innovation(row % 2, 4.0, 3e-5, np.zeros(len(states)))
        columns = rows.nuisance[row, row % 2], rows.change[row, row % 2]
        for each in (own, stands):
            detector.update(each, layout, one, *columns, (1.0, 20.0, 0.01, 0.05))
    alone = own.log_mass + layout.log_share
    beside = detector.log_odds(own, layout, stands)
    since = stands.log_mass[0, : layout.members] - own.stood

    assert since.max() > 5
    np.testing.assert_allclose(alone - beside, np.repeat(since.max(1)[:, None], alone.shape[1], 1))
    assert detector.evidence(own, layout, stands) < 5 < logsumexp(alone)
