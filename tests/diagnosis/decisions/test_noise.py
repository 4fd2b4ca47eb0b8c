"""The noise: what is too little to estimate it, what is an outlier, what remains of a drift."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.decisions.stubs import candidate

from pyport.angles import DEG
from pyport.diagnosis.case import Problem
from pyport.effects import Circumstances
from pyport.mounts import KINDS
from pyport.noise import common_mode, scatter
from pyport.noise.coefficients import tempered
from pyport.noise.covariance import Covariance
from pyport.noise.estimation import (
    departing,
    departures,
    drift,
    estimate,
    first,
    likelihood,
    pooling,
)
from pyport.noise.pointings import pointings
from pyport.noise.series import Departures, Noise, Possible, Series
from pyport.noise.whitening import whitening
from pyport.pointing.kernel import Columns
from pyport.recordings.schema import Recordings, stack


def normal(n, seed=0):
    """Return the quantiles of a normal distribution in random order, shape (n,)."""
    from scipy.special import ndtri

    return np.random.default_rng(seed).permutation(ndtri((np.arange(n) + 0.5) / n))


def series(n, *, is_y=True, start=0, antenna="", time=None, number=None):
    """Return a series of n lone readings, a minute apart."""
    rows = np.arange(n)
    return Series(
        rows + start,
        rows,
        60.0 * rows if time is None else time,
        rows if number is None else number,
        antenna,
        is_y,
    )


def plain(*parts, weights=None, **more):
    """Return white noise of one for some series."""
    m = sum(len(one.rows) for one in parts)
    return Covariance(
        tuple(parts),
        (Noise(0.0, 1.0),) * len(parts),
        np.ones(m) if weights is None else weights,
        np.ones(m),
        **more,
    )


def recordings(n, **columns):
    """Return n elevations of nothing, with columns."""
    nothing = np.full(n, np.nan)
    at = Circumstances(np.linspace(0, 5, n), np.full(n, 0.7), None, columns)
    return Recordings(at, nothing, np.zeros(n), nothing, nothing, np.arange(n), Path("made"))


@pytest.mark.parametrize(
    ("weight", "used"), [(0.051, True), (0.049, False), (0.03, False), (0.09, True)]
)
def test_a_reading_of_little_weight_is_an_outlier(weight, used):
    """Below a twentieth it counts in no rms."""
    found = plain(series(2), weights=np.array([1.0, weight]))

    assert found.used.tolist() == [True, used]


@pytest.mark.parametrize("sigmas", [30.0, 2000.0, 1e5])
def test_a_gross_error_counts_for_no_more_than_the_tails_allow(sigmas):
    """However gross it is: scatter, and what it weighs in, are those of the others."""
    part, value = series(400), normal(400)
    value[7] = sigmas
    given = frame_of(part)
    found = estimate.estimate(value, np.ones((400, 1)), given)

    assert found.noises[0].floor == pytest.approx(1.0, abs=0.1)
    assert found.weights[7] * sigmas**2 < 60.0


@pytest.mark.parametrize(
    ("sigmas", "kept"), [(2.9, 1.0), (5.5, None), (6.6, 0.0), (10.0, 0.0), (4.0, None)]
)
def test_the_first_look_ends_at_six_sigma(sigmas, kept):
    """Within three it takes no weight; at six and beyond all."""
    value = normal(400)
    value[7] = sigmas
    part = series(400)
    found = estimate.reweighed(plain(part), value, np.ones((400, 1)), frame_of(part))

    if kept is None:
        assert 0 < found.weights[7] < 1
    else:
        assert found.weights[7] == pytest.approx(kept, abs=1e-9)


@pytest.mark.parametrize("ratio", [8.0, 12.0])
def test_a_drift_may_be_ten_times_the_scatter(ratio):
    """The scatter beside it comes out, rather than one that makes up for part of the drift."""
    n, memory = 400, 40
    drift, change = np.zeros(n), normal(n, seed=3)
    for one in range(1, n):
        kept = np.exp(-1 / memory)
        drift[one] = kept * drift[one - 1] + np.sqrt(1 - kept**2) * change[one]
    found = estimate.estimate(
        ratio * drift + normal(n), np.ones((n, 1)), frame_of(series(n)), averaged=False
    )

    assert found.noises[0].floor > 0.6 * ratio
    assert found.noises[0].drift / found.noises[0].between > 6.0


def frame_of(*parts, drivers=()):
    """Return a frame of some series alone."""
    return estimate.Frame(tuple(parts), (), tuple(drivers), None)


@pytest.mark.parametrize(("n", "estimated"), [(8, True), (7, False), (5, False), (12, True)])
def test_eight_pointings_show_tails(n, estimated):
    """Of fewer the weights of the first look stand."""
    part, value = series(n), 10 * normal(n)
    value[0] = 70.0
    found = estimate._scattered(
        plain(part), value, np.zeros((n, 0)), frame_of(part), {True: 0.0, False: 0.0}
    )

    assert (found.noises[0].between != 1.0) == estimated


def test_readings_of_one_pointing_show_no_tails():
    """Their mean has another distribution."""
    part = replace(series(40), pointing=np.arange(40) // 2, time=60.0 * np.arange(20))
    found = estimate._scattered(
        plain(part), 10 * normal(40), np.zeros((40, 0)), frame_of(part), {True: 0.0}
    )

    assert found.noises[0].between == 1.0


def pair_at_the_end(n):
    """Return a series of n readings, the last two of one pointing."""
    lone = series(n - 1)
    pointing = np.append(lone.pointing, n - 2)
    return replace(lone, rows=np.arange(n), pointing=pointing)


def test_a_pair_among_lone_readings_hides_nothing():
    """Tails and growth are those of the others; the pair's scatter grows with them."""
    n = 400
    driver, part = np.linspace(-1.7, 1.7, n), pair_at_the_end(n)
    value = np.exp(0.5 * driver) * normal(n)
    value[7] = 30.0
    frame = frame_of(part, drivers=[scatter.Driver("made", driver[:, None])])
    found = estimate._scattered(plain(part), value, np.zeros((n, 0)), frame, {True: 0.0})

    assert np.polyfit(driver, np.log(found.precision), 1)[0] < -0.4
    assert found.precision[-1] < 0.5
    assert found.weights[7] < 0.05


def test_the_scatter_of_lone_readings_is_both_together():
    """What they share with repeats and what these differ by: tails widen the sum."""
    n = 400
    part, value = pair_at_the_end(n), normal(n) / np.abs(normal(n, seed=5)) ** 0.5
    found = [
        estimate._scattered(
            replace(plain(part), noises=(noise,)),
            value,
            np.zeros((n, 0)),
            frame_of(part),
            {True: 0.0},
        ).noises[0]
        for noise in (Noise(0.0, 1.0), Noise(0.6, 0.8))
    ]

    assert abs(found[0].between - 1) > 0.1
    assert np.hypot(found[1].within, found[1].between) == pytest.approx(found[0].between, rel=0.01)
    assert found[1].within == 0.6


def test_a_lone_reading_counts_by_its_weight_beside_repeats():
    """All of its variance, where of repeats the weight tells what they differ by."""
    part = replace(series(6), pointing=np.array([0, 1, 2, 2, 3, 3]), time=60.0 * np.arange(4))
    weights, precision = np.array([0.1, 1, 1, 1, 1, 0.5]), np.array([1.0, 4, 4, 4, 1, 1])
    found = whitening(weights, precision, part, Noise(0.5, 1.0)).variance

    assert found == pytest.approx([12.5, 1.25 / 4, (1 + 0.125) / 4, 1 + 0.25 / 1.5])


@pytest.mark.parametrize(("n", "follows"), [(41, True), (40, True), (39, False), (21, False)])
def test_forty_deviations_show_what_the_scatter_follows(n, follows):
    """Fewer, and the variance is constant."""
    driver = np.linspace(-1.7, 1.7, n)[:, None]
    deviation = np.exp(driver[:, 0]) * np.where(np.arange(n) % 2, 1.0, -1.0)
    log_variance = scatter.variance_function(deviation, np.ones(n), [driver], np.ones(n, bool))

    assert np.ptp(log_variance) > 3 if follows else np.ptp(log_variance) == 0


@pytest.mark.parametrize(("blank", "follows"), [(0, True), (1, True), (50, True), (51, False)])
def test_the_scatter_may_follow_a_wind_that_half_of_the_rows_have(blank, follows):
    """The others count as usual."""
    wind = np.linspace(0.0, 20.0, 100)
    wind[:blank] = np.nan
    found = {one.name: one.columns for one in scatter.drivers(recordings(100, wind_speed_m_s=wind))}

    assert ("wind" in found) == follows
    if follows:
        assert np.isfinite(found["wind"]).all()
        assert found["wind"][:blank] == pytest.approx(0.0)


def test_the_variance_function_is_that_of_the_scatter():
    """Growing as the exponential of a driver, beside one that does nothing."""
    rng = np.random.default_rng(1)
    driver, idle = rng.normal(size=(2, 1500, 1))
    deviation = np.exp(0.4 * driver[:, 0]) * rng.normal(size=1500)
    log_variance = scatter.variance_function(
        deviation, np.ones(1500), [driver, idle], np.ones(1500, bool)
    )
    slope, _ = line = np.polyfit(driver[:, 0], log_variance, 1)

    assert slope == pytest.approx(0.8, abs=0.1)
    assert np.std(log_variance - np.polyval(line, driver[:, 0])) < 0.1
    assert abs(log_variance.mean()) < 1e-9


def test_a_scatter_that_follows_nothing_is_constant():
    """Whatever ten idle drivers could do by chance."""
    rng = np.random.default_rng(2)
    idle = [rng.normal(size=(400, 2)) for _ in range(5)]
    log_variance = scatter.variance_function(
        rng.normal(size=400), np.ones(400), idle, np.ones(400, bool)
    )

    assert np.std(log_variance) < 0.2


def test_gross_errors_scatter_by_three_times_at_least():
    """Of normal deviations the mixture has a second part three times as wide, with little in it."""
    close, _, _ = scatter._gross_errors(normal(500), 1.0)
    far = np.concatenate([normal(450), 4.2 * normal(50)])
    found, _, _ = scatter._gross_errors(far, 1.0)

    assert 2.9 < close.width < 3.5
    assert 3.5 < found.width < 5.0


@pytest.mark.parametrize(("share", "far", "gross"), [(0.2, 20, 0.2), (0.4, 20, 0.0)])
def test_gross_errors_are_a_third_of_all_at_most(share, far, gross):
    """A fit of many columns goes through most of few readings: the others are no gross errors."""
    count = 40
    sound = np.random.default_rng(4).permutation(normal(count))
    deviation = np.where(np.arange(count) < share * count, far * np.sign(sound), sound)

    found, size = scatter.tails(deviation)

    assert found.gross == pytest.approx(gross, abs=0.03)
    assert (size > 1.2) == (gross == 0)


@pytest.mark.parametrize(
    ("draw", "inverse", "gross"),
    [
        (lambda rng: rng.normal(size=2000), 0.0, 0.0),
        (lambda rng: rng.standard_t(3, 2000), 1 / 3, 0.0),
        (lambda rng: rng.normal(size=2000) * np.where(rng.random(2000) < 0.05, 12, 1), 0.0, 0.05),
    ],
)
def test_tails_are_those_of_the_deviations(draw, inverse, gross):
    """Normal, Student's t with three degrees, or a twentieth of gross errors; the scale of each."""
    found, scale = scatter.tails(draw(np.random.default_rng(0)))

    assert found.inverse == pytest.approx(inverse, abs=0.09)
    assert found.gross == pytest.approx(gross, abs=0.015)
    assert scale == pytest.approx(1.0, rel=0.08)


def test_tails_weigh_what_is_far():
    """Student's t: 1 / (1 + u^2 / degrees); gross errors: one over the width squared."""
    student = scatter.Tails(inverse=0.25)
    mixed = scatter.Tails(gross=0.05, width=10.0)

    np.testing.assert_allclose(student.weights(np.array([0.0, 2.0, 6.0])), [1.0, 0.5, 0.1])
    np.testing.assert_allclose(mixed.weights(np.array([0.0, 9.0])), [0.995, 0.01], atol=6e-3)


@pytest.mark.parametrize(
    "tails", [scatter.Tails(inverse=0.25), scatter.Tails(gross=0.05, width=10.0)]
)
def test_the_slope_is_the_derivative_of_weighted_deviations(tails):
    """By differences."""
    unit = np.linspace(-6, 6, 25)
    psi = lambda u: tails.weights(u) * u  # noqa: E731
    step = 1e-5

    np.testing.assert_allclose(
        tails.slope(unit), (psi(unit + step) - psi(unit - step)) / (2 * step), atol=1e-6
    )


def test_an_estimate_by_weights_scatters_as_huber_says():
    """The mean of heavy-tailed deviations by their weights, over many draws."""
    rng = np.random.default_rng(3)
    tails, unit = scatter.Tails(inverse=1 / 3), rng.standard_t(3, (4000, 60))
    weight = tails.weights(unit)
    mean = np.zeros(4000)
    for _ in range(20):
        weight = tails.weights(unit - mean[:, None])
        mean = (weight * unit).sum(axis=1) / weight.sum(axis=1)
    said = scatter.spread(tails, unit.ravel()) / (60 * weight.mean())

    assert mean.var() == pytest.approx(said, rel=0.06)


def none_departing(n):
    """Return that nothing departs in a series of n readings."""
    return likelihood.Departing(Columns.of(np.zeros((n, 0)), 0), np.zeros((0, 0)))


def drafted(n, columns=1):
    """Return how likely no drift is in a series of n readings that drift by far."""
    part = series(n)
    value = np.cumsum(normal(n)) * 5 + 0.01 * normal(n, 1)
    grid = drift.grid_of([part])
    found = drift.draft(
        value,
        np.vander(np.linspace(-1, 1, n), columns),
        none_departing(n),
        np.ones(n),
        np.ones(n),
        value,
        part,
        grid,
        0.0,
    )
    return found.chance[0]


@pytest.mark.parametrize(
    ("n", "columns", "certain"), [(21, 1, False), (20, 1, True), (24, 5, True), (25, 5, False)]
)
def test_a_drift_needs_twenty_numbers_beyond_the_columns(n, columns, certain):
    """Fewer, and there is none."""
    assert (drafted(n, columns) == 1.0) == certain


@pytest.mark.parametrize(("n", "there"), [(35, False), (41, False), (80, True)])
def test_a_drift_is_found_where_there_are_enough(n, there):
    """A walk is no white noise; a series without times shows no drift at all."""
    assert not there or drafted(n) < 0.01
    part = replace(series(n), time=None)
    grid = drift.grid_of([series(n)])
    ones = np.ones(n)
    found = drift.draft(
        np.cumsum(normal(n)), ones[:, None], none_departing(n), ones, ones, ones, part, grid, 0.0
    )

    assert found.chance[0] == 1.0


@pytest.mark.usefixtures("both_paths")
@pytest.mark.parametrize("drifts", [[], [(1.5, 300.0)], [(1.5, 300.0), (0.8, 4e4)]])
@pytest.mark.parametrize("faint", [0, 2])
def test_the_restricted_likelihood_is_that_of_dense_algebra(drifts, faint):
    """White noise, drifts and departures in the directions that matter, the scale profiled out."""
    n, q = 60, 5
    time, rng = 60.0 * np.arange(n), np.random.default_rng(4)
    columns, value = np.vander(np.linspace(-1, 1, n), 2), rng.normal(size=n)
    variance = rng.uniform(0.5, 2, n)
    moved = rng.normal(size=(n, q)) * (rng.integers(0, q, (n, 1)) == np.arange(q))
    turned = np.linalg.qr(rng.normal(size=(q, q)))[0]
    kept = turned[:, faint:]
    data = np.concatenate([moved, columns, value[:, None]], axis=1)
    known = likelihood.Likelihood(Columns.of(data, q), variance, time, turned[:, :faint])
    lack, scale = known.at(drifts)
    dense = np.diag(variance) + moved @ kept @ kept.T @ moved.T
    for amplitude, memory in drifts:
        dense += amplitude**2 * np.exp(-np.abs(time[:, None] - time) / memory)
    inverse = np.linalg.inv(dense)
    normal_ = columns.T @ inverse @ columns
    left = inverse - inverse @ columns @ np.linalg.solve(normal_, columns.T @ inverse)
    misfit = value @ left @ value

    assert known.dof == n - 2
    assert scale == pytest.approx(np.sqrt(misfit / (n - 2)))
    assert lack == pytest.approx(
        np.linalg.slogdet(dense)[1] + np.linalg.slogdet(normal_)[1] + (n - 2) * np.log(misfit)
    )


def test_no_drift_is_as_likely_beforehand_as_all_drifts_together():
    """The other axis counts as likely as not."""
    part = (series(5, is_y=False), series(5))
    prior = drift._prior(9)
    drafts = [
        SimpleNamespace(chance=one)
        for one in (np.full(9, 1 / 9), np.where(np.arange(9) == 4, 1.0, 0.0))
    ]
    heard = drift.beside(drafts, part, 0)

    assert prior[0] == pytest.approx(prior[1:].sum())
    assert heard[4] > 5 * heard[3]
    assert heard.sum() == pytest.approx(1)


def test_the_noise_is_averaged_over_drifts():
    """Each process stands with its variance times its probability."""
    grid = drift.Grid(np.array([0.0, 2.0]), np.array([0, 0]), (((1.0, 100.0),),))
    known = drift.Draft(0.0, 1.0, np.array([1.0, 1.0]), np.array([0.75, 0.25]), grid, 50.0, "reml")
    found = known.noise(known.chance, 0.0)

    assert found.between == pytest.approx(1.0)
    assert found.drifts == ((pytest.approx(1.0), 100.0),)


@pytest.mark.parametrize(("correlation", "coupled"), [(0.4, True), (0.25, False), (0.2, False)])
def test_axes_are_coupled_from_three_standard_errors(correlation, coupled):
    """Of a hundred pointings 0.3."""
    assert bool(coupling(100, correlation)) == coupled


@pytest.mark.parametrize(
    ("n", "correlation", "coupled"),
    [(40, 0.9, True), (39, 0.9, False), (25, 0.9, False), (100, 0.5, True)],
)
def test_axes_are_coupled_from_forty_pointings(n, correlation, coupled):
    """Fewer do not show it, however close."""
    assert bool(coupling(n, correlation)) == coupled


def coupling(n, correlation):
    """Return the coupling of two axes whose deviations correlate."""
    x = normal(n)
    y = normal(n, 1)
    y = y - x * (x @ y) / (x @ x)
    y = correlation * x + np.sqrt(1 - correlation**2) * y * np.sqrt((x @ x) / (y @ y))
    # Normal quantiles of a small set stay within three sigma, so that nothing is cut.
    return estimate._coupling([series(n, is_y=False), series(n, start=n)], np.concatenate([x, y]))


def test_coupled_axes_are_whitened():
    """What they share is taken out of elevation."""
    x, y = series(4, is_y=False), series(4, start=4)
    found = plain(x, y, coupling={"": 0.6})
    white = found.whiten(np.eye(8))
    shared = np.kron([[1, 0.6], [0.6, 1]], np.eye(4))

    np.testing.assert_allclose(white.T @ white, np.linalg.inv(shared), atol=1e-12)
    assert found.log_determinant == pytest.approx(np.linalg.slogdet(shared)[1])


def test_departures_are_whitened():
    """The dense inverse and determinant of noise with a random effect."""
    part, moved = series(5), np.arange(1.0, 6.0)[:, None]
    found = plain(part, departures=(Departures("zero", "session", "", ("a",), moved, 0.8),))
    dense = np.eye(5) + 0.8**2 * moved @ moved.T
    white = found.whiten(np.eye(5))

    np.testing.assert_allclose(white.T @ white, np.linalg.inv(dense), atol=1e-9)
    assert found.log_determinant == pytest.approx(np.linalg.slogdet(dense)[1])


def test_what_a_session_departs_by_is_predicted():
    """Shrunk toward zero by the noise over its own variance."""
    part = series(4)
    moved = np.array([[1.0, 0], [1, 0], [0, 1], [0, 1]])
    found = plain(part, departures=(Departures("zero", "session", "", ("a", "b"), moved, 2.0),))

    np.testing.assert_allclose(
        found.departed(np.array([1.0, 3, -1, -1])),
        np.array([4, 4, -2, -2]) * 2**2 / (1 + 2 * 2**2),
    )


@pytest.mark.parametrize(("gain", "kept"), [(1.2, True), (0.8, False), (0.6, False), (1.9, True)])
def test_a_variance_must_earn_one(gain, kept):
    """In twice the log of the restricted likelihood."""
    projected = SimpleNamespace(
        triangle=lambda variances: variances, lack=lambda v, _: 0.0 if v[0] > 0 else gain
    )

    assert bool(departures._without_idle(projected, np.array([4.0]))[0]) == kept


def projected(rng, sessions, size, each=30):
    """Return what data say of sessions that depart by `size`, and those data."""
    part = series(sessions * each)
    inside = np.repeat(np.eye(sessions), each, axis=0)
    value = inside @ (size * normal(sessions)) + rng.normal(size=sessions * each)
    one = Departures("zero", "session", "", tuple("abcdefghijklmnopqrst"[:sessions]), inside)
    return plain(part), value, one


@pytest.mark.parametrize("size", [0.0, 0.7, 3.0])
def test_the_variance_of_departures_is_restricted_maximum_likelihood(size):
    """Of a balanced design that of the analysis of variance: between less within."""
    known, value, one = projected(np.random.default_rng(5), 20, size)
    possible = Possible((one,), known.parts)
    (found,) = departures.estimate(known, value, np.ones((600, 1)), possible) or (replace(one),)
    groups = value.reshape(20, 30)
    between = groups.mean(axis=1).var(ddof=1)
    within = groups.var(axis=1, ddof=1).mean()

    # The scale of the noise is profiled out: the variance is in units of it.
    assert found.sigma**2 == pytest.approx(max(0.0, (between - within / 30) / within), rel=0.02)


def test_data_that_are_fitted_exactly_have_no_departures():
    """What is left is rounding."""
    known, _, one = projected(np.random.default_rng(5), 5, 1.0)

    possible = Possible((one,), known.parts)

    for size in (1e-6, 1e-12):
        left = one.columns @ normal(5) + 0.01 * normal(150)
        assert departures.estimate(known, size * left, np.ones((150, 1)), possible) == ()


@pytest.mark.parametrize(("size", "some"), [(1e-2, 1), (1e-12, 0)])
def test_of_an_exact_fit_no_variance_is_asked_for(monkeypatch, size, some):
    """Whatever would be estimated from rounding."""
    known, _, one = projected(np.random.default_rng(5), 5, 1.0)
    monkeypatch.setattr(departures, "_fitted", lambda *_: np.array([1.0]))
    monkeypatch.setattr(departures, "_without_idle", lambda _, variances: variances)
    left = size * normal(150)

    found = departures.estimate(known, left, np.ones((150, 1)), Possible((one,), known.parts))
    assert len(found) == some


def test_a_variance_that_earns_nothing_is_left_out(monkeypatch):
    """However the likeliest one was found."""
    known, value, one = projected(np.random.default_rng(5), 20, 0.0)
    monkeypatch.setattr(departures, "_fitted", lambda *_: np.array([1e-6]))
    possible = departures.Possible((one,), known.parts)

    assert departures.estimate(known, value, np.ones((600, 1)), possible) == ()


@pytest.mark.parametrize("readings", [1, 2])
def test_an_outlier_says_nothing_whatever_the_noise(readings):
    """Its variance does not move with that of the others."""
    part = replace(series(6), pointing=np.arange(6) // readings)
    weights = np.array([1.0, 1, 1, 1, 1e-10, 1e-10])
    one, other = (
        whitening(weights, np.ones(6), part, Noise(0.1, size)).variance for size in (1.0, 3.0)
    )

    assert one[-1] == other[-1]
    assert other[0] > 5 * one[0]


@pytest.mark.parametrize(("nights", "there"), [(3, True), (2, False), (1, False), (5, True)])
def test_three_sessions_may_depart(nights, there):
    """Of two neither is the odd one."""
    given = recordings(30, session=np.array([f"n{k}" for k in np.arange(30) * nights // 30]))
    found = departing.possible(given, stack(given))

    assert any(one.of == "session" for one in found) == there


@pytest.mark.parametrize(("rows", "several"), [(80, True), (79, False), (30, False)])
def test_short_sessions_depart_in_their_zeros_alone(rows, several):
    """Of fewer than eight readings on average."""
    given = recordings(rows, session=np.array([f"n{k}" for k in np.arange(rows) * 10 // rows]))
    found = departing.possible(given, stack(given))

    assert any(one.term.startswith("zero in ") for one in found)
    assert any(not one.term.startswith("zero in ") for one in found) == several


@pytest.mark.parametrize(
    ("rows", "count"),
    [(149, 0), (151, 8), (160, 8), (400, 20), (1990, 100), (4000, 100)],
)
def test_stretches_of_rows_depart_where_their_order_is_all_that_is_known(rows, count):
    """Of about twenty pointings each, eight stretches to a hundred; a short run is one night.

    The columns of all that a long file has took memory with the square of its rows.
    """
    given = recordings(rows, order=np.arange(float(rows)))
    found = departing.possible(given, stack(given))

    labels = [tuple(dict.fromkeys(one.labels)) for one in found]

    assert {one.of for one in found} == ({"stretch"} if count else set())
    assert all(len(each) == count for each in labels)
    assert {len(one.labels) for one in found} == ({count, 2 * count} if count else set())
    assert all(np.abs(one.columns).sum(axis=0).all() for one in found)
    assert all(each[0].startswith("rows 1 ") for each in labels)
    assert all(each[-1].endswith(f" {rows}") for each in labels)


@pytest.mark.parametrize(
    ("sources", "rows", "there"),
    [
        (10, 20, True),
        (10, 19, False),
        (10, 12, False),
        (10, 38, True),
        (2, 20, False),
        (3, 9, True),
    ],
)
def test_sources_that_were_pointed_at_again_may_depart(sources, rows, there):
    """Twice each on average, three of them at least."""
    names = np.array([f"S{k % sources}" for k in range(rows)])
    given = recordings(rows, time=1e9 + 600.0 * np.arange(rows), source=names)
    found = departing.possible(given, stack(given))

    assert any(one.of == "source" for one in found) == there


def test_what_remains_of_drifts_where_coefficients_are_estimated():
    """Between a tenth and a fifth of the variance of drifts and departures; the rest is white."""
    one = Departures("zero", "session", "", ("a",), np.ones((3, 1)), 2.0)
    known = replace(plain(series(3), departures=(one,)), noises=(Noise(0.0, 1.0, ((3.0, 500.0),)),))
    found = tempered(known)
    (drifted,) = found.noises
    share = drifted.drift**2 / 9

    assert 0.1 < share < 0.2
    assert found.departures[0].sigma ** 2 / 4 == pytest.approx(share)
    assert drifted.between**2 == pytest.approx(1 + (1 - share) * 9)
    assert tempered(plain(series(3))).noises == plain(series(3)).noises


@pytest.mark.parametrize(
    ("pointings_", "shapes", "taken"),
    [(40, 20, 10), (16, 20, 4), (80, 90, 20), (200, 90, 30), (400, 90, 30), (120, 90, 30)],
)
def test_one_direction_for_four_pointings_is_projected_out(pointings_, shapes, taken):
    """And thirty at most."""
    rng = np.random.default_rng(0)
    found = first._rich(np.ones((pointings_, 1)), rng.normal(size=(pointings_, shapes)), pointings_)

    assert found.shape[1] == 1 + min(taken, shapes)
    np.testing.assert_allclose(found.T @ found, np.eye(found.shape[1]), atol=1e-9)


def test_eight_slow_directions_at_most_are_projected_out():
    """More would leave nothing by which a drift is known."""
    time = np.linspace(0, np.pi, 400)
    slow = np.stack([np.cos(k * time) for k in range(1, 20)], axis=1)

    assert first._rich(np.ones((400, 1)), slow, 400).shape[1] == 1 + 8


def noisy(antennas, quiet=1.0, dof=10.0):
    """Return the noises of an array in which one antenna is quieter than the others."""
    parts = [series(3, antenna=f"A{n}", start=3 * n) for n in range(antennas)]
    noises = [Noise(0.0, quiet if n == 0 else 4.0, dof=dof) for n in range(antennas)]
    return pooling.moderated(noises, parts)


def test_a_quiet_antenna_is_drawn_to_the_array():
    """The usual variance counts as six deviations; a noisy one is believed."""
    found = noisy(5)
    loud = noisy(5, quiet=9.0)

    assert found[0].between ** 2 == pytest.approx((10 + 6 * 16) / 16, rel=1e-6)
    assert found[0].dof == 16
    assert loud[0].between == 9.0


@pytest.mark.parametrize(("antennas", "drawn"), [(4, True), (3, False), (2, False), (7, True)])
def test_four_antennas_have_a_usual_noise(antennas, drawn):
    """A median of fewer is one antenna's."""
    assert (noisy(antennas)[0].between > 1.0) == drawn


def shaken(antennas, scans, size=3.0, fitted=0):
    """Return the excess of an array that is shaken from scan to scan, beside some common terms."""
    rng = np.random.default_rng(0)
    scan = np.repeat(np.arange(scans), antennas)
    left = rng.normal(size=len(scan)) + size * normal(scans)[scan]
    columns = rng.normal(size=(scans, 1))[scan]
    model = np.linalg.qr(rng.normal(size=(scans, fitted))[scan])[0]
    left, columns = (one - model @ (model.T @ one) for one in (left, columns))
    return common_mode.excess(left, np.ones(len(scan)), [columns], model, scan)


@pytest.mark.parametrize(
    ("antennas", "scans", "shown"),
    [
        (4, 40, True),
        (3, 40, False),
        (2, 40, False),
        (7, 40, True),
        (6, 8, True),
        (6, 7, False),
        (6, 5, False),
        (6, 15, True),
    ],
)
def test_a_common_mode_needs_four_antennas_and_eight_scans(antennas, scans, shown):
    """Fewer, and the mean is one antenna's, or chance."""
    assert (shaken(antennas, scans).factor > 1) == shown


def together(scans, shapes, others=0, fitted=0):
    """Return the excess of six antennas that one of several effects of some shapes moves alike.

    Beside a model with some terms in common.
    """
    rng = np.random.default_rng(1)
    scan = np.repeat(np.arange(scans), 6)
    effects = [rng.normal(size=(scans, shapes))[scan] for _ in range(1 + others)]
    left = rng.normal(size=len(scan)) + 3 * effects[0].sum(axis=1)
    model = np.linalg.qr(rng.normal(size=(scans, fitted))[scan])[0]
    left, *effects = (one - model @ (model.T @ one) for one in (left, *effects))
    return common_mode.excess(left, np.ones(len(scan)), effects, model, scan)


@pytest.mark.parametrize(("shapes", "explains"), [(2, True), (10, True), (11, False)])
def test_what_draws_more_than_a_quarter_of_the_scans_explains_nothing(shapes, explains):
    """It would take the noise away."""
    found = together(40, shapes)

    assert (found.factor < 3) == explains
    assert found.dof == 40 - shapes * explains


def test_what_the_model_has_fitted_is_missing_from_the_common_mode():
    """Ten common terms take ten of forty scans' deviations."""
    assert together(40, 2, fitted=10).dof == pytest.approx(40 - 10 - 2)
    assert shaken(6, 8, fitted=5).dof == pytest.approx(3)
    assert shaken(6, 8, fitted=8).dof == np.inf
    assert shaken(4, 40, fitted=20).factor == pytest.approx(shaken(4, 40).factor, rel=0.4)


def test_an_effect_of_all_antennas_is_no_noise_that_they_share():
    """The excess is what is left beside the one of several that explains it."""
    assert together(60, 2, others=4).factor == pytest.approx(1, abs=0.4)


def test_the_common_mode_is_as_large_as_it_was_drawn():
    """Of four antennas that shake together by three sigma: 1 + 4 * 9 times the variance."""
    assert shaken(4, 2000).factor == pytest.approx(37, rel=0.12)
    assert shaken(4, 2000, size=0.0).factor == pytest.approx(1, abs=0.12)


@pytest.mark.parametrize(
    ("seconds", "degrees", "one"),
    [
        (0.9, 0.0, True),
        (1.1, 0.0, False),
        (0.6, 0.0, True),
        (1.9, 0.0, False),
        (0.0, 0.019, True),
        (0.0, 0.021, False),
        (0.0, 0.011, True),
        (0.0, 0.039, False),
    ],
)
def test_readings_within_a_second_at_a_place_are_one_pointing(seconds, degrees, one):
    """At most 0.02 deg apart; of a named source, which tells what exposures share."""
    given = recordings(2, time=1e9 + np.array([0.0, seconds]), source=np.array(["one", "one"]))
    at = replace(given.at, az=np.zeros(2), el=np.array([0.7, 0.7 + degrees * DEG]))

    assert (len(np.unique(pointings(replace(given, at=at)))) == 1) == one


@pytest.mark.parametrize(
    ("degrees", "one"), [(0.0009, True), (0.0011, False), (0.0006, True), (0.0019, False)]
)
def test_without_times_only_the_same_place_is_one_pointing(degrees, one):
    """At most a thousandth of a degree apart."""
    given = recordings(2)
    at = replace(given.at, az=np.array([0.0, degrees * DEG]) / np.cos(0.7), el=np.full(2, 0.7))

    assert (len(np.unique(pointings(replace(given, at=at)))) == 1) == one


TURN_S, STEP_S = 7.292e-5, 25.0


def tracked(exposures, stars=20, step_s=STEP_S, slew_s=90.0, drift_rad=0.0, **columns):
    """Return exposures of stars one after the other, as the telescope tracks them."""
    star, shot = (one.ravel() for one in np.indices((stars, exposures)))
    rng = np.random.default_rng(3)
    az, el = (rng.uniform(*span, stars)[star] for span in ((0, 6), (0.5, 1.2)))
    given = recordings(
        stars * exposures,
        time=1e9 + star * (slew_s + (exposures - 1) * step_s) + shot * step_s,
        **({"session": np.full(stars * exposures, "one")} | columns),
    )
    el = el + shot * step_s * (0.9 * TURN_S + drift_rad / STEP_S)
    return replace(given, at=replace(given.at, az=az, el=el))


@pytest.mark.parametrize(
    ("exposures", "step_s", "drift_deg", "visits"),
    [
        (3, 25.0, 0.0, 20),
        (10, 25.0, 0.0, 20),
        (11, 25.0, 0.0, 220),
        (3, 149.0, 0.0, 20),
        (3, 151.0, 0.0, 60),
        # What moves by more than the sky turns was slewed.
        (3, 25.0, 0.025, 20),
        (3, 25.0, 0.04, 60),
    ],
)
def test_exposures_of_a_star_without_a_slew_are_one_pointing(exposures, step_s, drift_deg, visits):
    """Ten at most, in five minutes: what is longer is a record of tracking."""
    given = tracked(exposures, step_s=step_s, drift_rad=drift_deg * DEG)

    assert len(np.unique(pointings(given))) == visits


def test_exposures_of_named_sources_are_pointings_of_their_own():
    """What they share is the source's; each session and each scan direction is by itself."""
    named = tracked(3, source=np.repeat(np.arange(20).astype(str), 3))
    blank = tracked(3, source=np.repeat(["star", *[""] * 19], 3))
    scanned = tracked(4, scan_direction=np.tile([1.0, -1.0], 40))
    parted = tracked(3, stars=1, session=np.array(["one", "one", "two"]))

    assert len(np.unique(pointings(parted))) == 2
    assert len(np.unique(pointings(named))) == 60
    assert len(np.unique(pointings(blank))) == 3 + 19
    assert len(np.unique(pointings(scanned))) == 40


def test_exposures_on_either_side_of_the_pier_are_two_visits():
    """Between them the mount turned over."""
    side = np.tile(["east", "east", "west"], 20)
    given = tracked(3, pier_side=side)
    given = replace(given, at=replace(given.at, mount=KINDS["german"]))

    assert len(np.unique(pointings(given))) == 40


@pytest.mark.parametrize(
    ("effect", "projected"),
    [("refraction", True), ("epoch_tilt", False), ("source_position", False)],
)
def test_what_nights_and_sources_do_is_noise_to_the_search(effect, projected):
    """A change, or a source's place, has to stand out of what the others do."""
    one = candidate(effect)
    case = SimpleNamespace(candidates=[one], blocks=SimpleNamespace(antennas=1))

    assert Problem.lasting.fget(case) == [one] * projected
