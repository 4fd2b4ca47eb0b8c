"""The hours of a fit by the proportions of its sigmas, and a day continued over them."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.angles import ARCMIN, DEG, HOUR
from pyport.effects import CATALOGUE, Circumstances
from pyport.recordings import sky
from pyport.studies.gmrt.curves import Track, columns
from pyport.studies.gmrt.figures import continued, hours, until
from pyport.studies.gmrt.published import Wave

DEC, LATITUDE = 40.7 * DEG, 19.1 * DEG
LEFT = np.arange(-3.75, 1.5, 0.25) * HOUR


def offsets(hour_angle, terms):
    """Return zero, lean north and east, and sag [arcmin] at hour angles."""
    at = Circumstances(*sky.horizon(hour_angle, np.full(len(hour_angle), DEC), LATITUDE))
    parts = [CATALOGUE[name].columns(at)[1] for name in ("elevation_zero", "tilt", "sag_cosine")]
    return np.concatenate(parts, axis=1) @ np.array(terms) * ARCMIN


def published(hour_angle, seed, noise=0.5):
    """Return what a least-squares fit to one made antenna prints, its sigmas to one decimal."""
    rng = np.random.default_rng(seed)
    design = columns(hour_angle)
    a, b, d = rng.normal(8, 5), -rng.uniform(3, 12), rng.normal(0, 25) * DEG
    size = noise * rng.uniform(0.6, 1.8)
    covariance = np.linalg.inv(design.T @ design) * size**2
    turn = [[1, 0, 0], [0, np.cos(d), -np.sin(d)], [0, -np.sin(d) / b, -np.cos(d) / b]]
    of_a, of_b, of_d = np.sqrt(np.diag(turn @ covariance @ np.transpose(turn)))
    of_a, of_b, of_d = (np.round(s, 1) for s in (of_a, of_b, of_d / DEG))
    wave = Wave(
        f"C{seed:02d}", "day", a * ARCMIN, of_a * ARCMIN, b * ARCMIN, of_b * ARCMIN, d, of_d * DEG
    )
    return wave, size


@pytest.mark.parametrize("end", [1.6, 3.4, 5.0])
def test_sigmas_tell_how_far_the_scans_went_on(end):
    """From printed sigmas alone: the hour that they end at, and each antenna's scatter."""
    made = [published(until(LEFT, end * HOUR), seed) for seed in range(25)]
    found = hours(LEFT, [wave for wave, _ in made], DEC, LATITUDE)

    assert found.ended / HOUR == pytest.approx(end, abs=0.4)
    low, high = found.middle
    assert low <= found.ended <= high
    ratio = [found.scatter[wave.antenna] / ARCMIN / size for wave, size in made]
    assert np.median(ratio) == pytest.approx(1, abs=0.1)
    np.testing.assert_array_equal(found.scanned[: len(LEFT)], LEFT)


def test_few_curves_tell_no_hours():
    """Four antennas are not enough."""
    assert hours(LEFT, [published(LEFT, seed)[0] for seed in range(4)], DEC, LATITUDE) is None


def made_track(rng, terms, noise):
    """Return the left scans of a made antenna whose directions differ by 4 arcmin."""
    direction = np.where(np.arange(len(LEFT)) % 2, -1.0, 1.0)
    _, el = sky.horizon(LEFT, np.full(len(LEFT), DEC), LATITUDE)
    value = offsets(LEFT, terms) + (2 * direction + rng.normal(0, noise, len(LEFT))) * ARCMIN
    return Track("C00", "day", LEFT, el, value, direction)


@pytest.mark.parametrize("terms", [(10, 3, -2, 5), (-4, 0, 6, 0), (2, 1, 1, -8)])
def test_a_continued_day_is_what_all_hours_give(terms):
    """Without noise the cosine is that of least squares over all hours, not over those left."""
    scanned = until(LEFT, 5 * HOUR)
    track = made_track(np.random.default_rng(0), terms, 0)
    whole = np.linalg.lstsq(columns(scanned), offsets(scanned, terms), rcond=None)[0]
    cut = np.linalg.lstsq(columns(LEFT), offsets(LEFT, terms), rcond=None)[0]

    formal, _ = continued(track, scanned, DEC, LATITUDE)

    np.testing.assert_allclose(formal.value / ARCMIN, whole / ARCMIN, atol=0.01)
    assert np.abs(cut - whole).max() > 0.2 * ARCMIN


def test_sigmas_of_a_continued_day_are_true():
    """Over many made days the continued coefficients scatter as their sigmas say."""
    scanned, rng = until(LEFT, 5 * HOUR), np.random.default_rng(3)
    terms = (10, 3, -2, 5)
    truth = np.linalg.lstsq(columns(scanned), offsets(scanned, terms), rcond=None)[0]
    pulls, ratios = [], []
    for _ in range(150):
        formal, stretches = continued(made_track(rng, terms, 0.4), scanned, DEC, LATITUDE)
        pulls.append((formal.value - truth) / np.sqrt(np.diag(formal.covariance)))
        ratios.append(np.sqrt(stretches.covariance[0, 0] / formal.covariance[0, 0]))

    np.testing.assert_allclose(np.std(pulls, axis=0), 1, atol=0.2)
    assert 0.8 < np.median(ratios) < 2


def test_what_does_not_tell_is_not_continued():
    """Ten noisy scans far from the hours that are wanted give no curve."""
    track = made_track(np.random.default_rng(4), (10, 0, 0, 1), 2)
    few = slice(0, 9)
    short = Track("C00", "day", *(v[few] for v in (LEFT, track.el, track.offset, track.direction)))

    assert continued(short, until(LEFT, 5 * HOUR), DEC, LATITUDE) is None
