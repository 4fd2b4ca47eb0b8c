"""The document's fit recovers the document's model from a campaign like the document's."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pyport.angles import ARCSEC, DEG
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.pointing import Rt32Model, printed, printed_sigmas
from pyport.recordings.schema import Recordings
from pyport.studies.rt32 import LEVEL, METHODS, BoxStep, box_step, fit_rt32
from pyport.studies.rt32.fit import bootstrap, honest_sigmas, sessions


def without_noise(seed=0, n=600, **more):
    """Return offsets that are the published model's and nothing else."""
    rng = np.random.default_rng(seed)
    at = Circumstances(
        az=rng.uniform(-90, 450, n) * DEG, el=rng.uniform(8, 84, n) * DEG, columns=more
    )
    x, y = Rt32Model(printed()).offsets(at)
    one_axis = rng.random(n) < 0.5
    nothing = np.full(n, np.nan)
    return Recordings(
        at, np.where(one_axis, x, np.nan), np.where(one_axis, np.nan, y),
        nothing, nothing, np.arange(n), Path("made.csv"),
    )  # fmt: skip


def rough(recordings):
    """Return the recordings with offsets off by a milliarcsecond."""
    wave = 1e-3 * ARCSEC * np.cos(40 * recordings.at.az)
    return replace(recordings, x=recordings.x + wave, y=recordings.y + wave)


@pytest.mark.parametrize("method", ["document", "huber"])
def test_without_noise_the_parameters_come_back(method):
    """From zero the exact form is found to a microarcsecond."""
    fit = fit_rt32(without_noise(), method=method)

    np.testing.assert_allclose(fit.values, printed(), rtol=0, atol=1e-6 * ARCSEC)
    assert fit.inside.all()


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_every_method_recovers_model3(fits, method):
    """All parameters lie within three honest sigmas of those that were put in."""
    fit, sigmas = fits[method]
    pull = (fit.values - printed()) / sigmas

    assert np.abs(pull).max() < 3
    assert np.sqrt(np.mean(pull**2)) < 1.6


def test_points_and_rms_are_those_put_in(document, errors):
    """As many points within 0.007 deg, and as their rms, as the errors that were put in."""
    small = np.abs(errors * ARCSEC) <= LEVEL

    assert document.stack.is_y.sum() == 2758
    assert (~document.stack.is_y).sum() == 2857
    assert document.inside.sum() == pytest.approx(small.sum(), rel=0.01)
    assert document.rms / ARCSEC == pytest.approx(np.sqrt(np.mean(errors[small] ** 2)), rel=0.02)


def test_correlations_are_those_of_the_document(document):
    """About 0.95 of p1 with p3 and p4, higher still among p2, p7 and p8."""
    size = np.abs(document.correlation)

    assert 0.92 < size[0, 2] < 0.97
    assert size[0, 3] > 0.95
    assert size[1, 6] > size[0, 2]
    assert size[1, 7] > size[0, 2]
    assert size[6, 7] > 0.9
    assert np.max(size[0, 4:]) < 0.2


def test_formal_sigmas_are_of_the_published_order_and_too_small(document, honest):
    """Formal sigmas are within a factor three of the printed ones; sessions say twice or more."""
    share = document.sigmas / printed_sigmas()
    ratio = honest / document.sigmas

    assert share.min() > 1 / 3
    assert share.max() < 3
    assert np.median(ratio) > 1.5


def test_the_step_of_the_box_is_found(campaign):
    """Fitted rather than subtracted, the step comes out as the 0.017 deg that was put in."""
    fit = fit_rt32(campaign, method="student-t", box=box_step(campaign, "fit"))
    sigma = honest_sigmas(fit)[-1]

    assert len(fit.values) == 13
    assert abs(fit.values[-1] - 0.017 * DEG) < 3 * sigma
    assert sigma < 0.002 * DEG


def test_forgetting_the_step_costs_points(campaign, document):
    """With the step neither subtracted nor fitted fewer points lie within the level."""
    without = fit_rt32(campaign, box=box_step(campaign, "0"))

    assert without.inside.sum() < 0.9 * document.inside.sum()


def test_both_forms_agree_away_from_the_zenith(campaign, document, honest):
    """The approximate form gives the same parameters within a twentieth of their sigmas."""
    approximate = fit_rt32(campaign, exact=False, box=box_step(campaign))

    assert np.max(np.abs(document.values - approximate.values) / honest) < 0.05


def test_points_beyond_the_level_count_for_a_thousandth(document):
    """The weights are one inside the level and 0.001 outside, and they agree with the residuals."""
    np.testing.assert_array_equal(document.weight, np.where(document.inside, 1, 1e-3))


def test_bootstrap_of_white_noise_agrees_with_formal_sigmas():
    """Where errors are independent and normal, sessions drawn anew scatter as the fit says."""
    sessions_of_10 = np.repeat([f"s{k}" for k in range(200)], 10)
    quiet = without_noise(5, 2000, session=sessions_of_10)
    noise = 10 * ARCSEC * np.random.default_rng(6).normal(size=(2, 2000))
    fit = fit_rt32(replace(quiet, x=quiet.x + noise[0], y=quiet.y + noise[1]), method="huber")
    ratio = bootstrap(fit, 400).std(axis=0) / fit.sigmas

    np.testing.assert_allclose(ratio, 1, atol=0.25)


def test_bootstrap_is_the_same_every_time(document):
    """The same seed draws the same sessions."""
    np.testing.assert_array_equal(bootstrap(document, 3, seed=1), bootstrap(document, 3, seed=1))


def test_days_stand_for_sessions_without_names():
    """Recordings with times alone are drawn day by day."""
    time = np.array([0.0, 10.0, 86400.0, 90000.0, 86400.0 * 7])
    some = without_noise(n=5, time=time)

    np.testing.assert_array_equal(sessions(some), [0, 0, 1, 1, 2])


def test_one_session_has_no_honest_sigma():
    """With nothing to draw from the honest sigma is unknown, and drawing is refused."""
    fit = fit_rt32(without_noise())

    assert np.isnan(honest_sigmas(fit)).all()
    with pytest.raises(BadInput, match="one session"):
        bootstrap(fit)


def test_what_the_recordings_leave_open_is_not_made_up():
    """Altitude offsets alone say nothing of the azimuth's parameters."""
    all_of_it = without_noise(n=400)
    altitudes = all_of_it.take(np.isfinite(all_of_it.y))
    fit = fit_rt32(altitudes, exact=False)

    assert np.isnan(fit.values[[0, 2, 3, 8, 9]]).all()
    np.testing.assert_allclose(
        fit.values[[1, 4, 5, 6, 7, 10, 11]],
        printed()[[1, 4, 5, 6, 7, 10, 11]],
        atol=0.2 * ARCSEC,
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda r: fit_rt32(r, method="l2"), "no method is called 'l2'"),
        (lambda r: fit_rt32(rough(r), level=1e-20), r"\d offsets within .* a larger level"),
        (lambda r: fit_rt32(r.take(slice(5))), "5 measured offsets cannot determine 12"),
        (lambda r: box_step(r, "a lot"), "expected known, fit or degrees"),
    ],
)
def test_what_cannot_be_done_is_said(call, message):
    """One line says what is wrong and what was expected."""
    with pytest.raises(BadInput, match=message):
        call(without_noise())


def test_several_antennas_are_no_telescope():
    """Offsets of two antennas are not fitted as if one had made them."""
    two = without_noise(antenna=np.repeat(["E02", "W01"], 300))

    with pytest.raises(BadInput, match="2 antennas, expected one"):
        fit_rt32(two)


def test_recordings_of_one_campaign_have_no_step():
    """Nothing is subtracted where all recordings lie on one side of the change."""
    for time in (0.0, 2e9):
        some = without_noise(n=50, time=np.full(50, time))

        assert not box_step(some).earlier.any()


def test_a_step_that_nothing_shows_is_not_fitted():
    """Asked to fit a step where there is one campaign, the fit has twelve parameters."""
    some = without_noise()
    fit = fit_rt32(some, box=BoxStep(np.zeros(len(some), bool), None))

    assert len(fit.values) == 12
