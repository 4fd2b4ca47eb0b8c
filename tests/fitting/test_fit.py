"""Fits recover what was put in, and the GMRT's published curves."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pyport.angles import ARCSEC, DEG
from pyport.effects import CATALOGUE, Circumstances
from pyport.effects.circumstances import Site
from pyport.effects.empirical import fields as empirical
from pyport.errors import BadInput
from pyport.fitting.fit import fit, leftover_text
from pyport.fitting.soundness import linear, neglected, warnings
from pyport.fitting.table import as_json, text
from pyport.formats import models
from pyport.least_squares.gram import Solution
from pyport.models.model import CLASSICAL_TERMS, Term
from pyport.mounts import KINDS
from pyport.recordings.schema import Recordings

TRUTH = np.array([30.0, -55, 21, -13, 8, -5, 44]) * ARCSEC


def simulated(n, noise_arcsec, seed):
    """Return recordings of the classical seven terms with white noise."""
    rng = np.random.default_rng(seed)
    at = Circumstances(rng.uniform(0, 2 * np.pi, n), rng.uniform(0.2, 1.4, n))
    parts = [CATALOGUE[name].columns(at) for name in CLASSICAL_TERMS.split()]
    x, y = (np.concatenate(axis, axis=1) @ TRUTH for axis in zip(*parts, strict=True))
    x, y = (one + noise_arcsec * ARCSEC * rng.normal(size=n) for one in (x, y))
    nothing = np.full(n, np.nan)
    return Recordings(at, x, y, nothing, nothing, np.arange(n), Path("simulated"))


@pytest.mark.slow
def test_altaz_is_recovered_within_its_sigmas():
    """Over many noise draws the misses are normal with the sigmas that the fit states."""
    misses = []
    for seed in range(40):
        done = fit(simulated(150, 5, seed), models.load("altaz"))
        value = np.concatenate([one.value for one in done.coefficients])
        sigma = np.concatenate([one.sigma for one in done.coefficients])
        misses.append((value - TRUTH) / sigma)

    scatter = np.std(misses)

    assert 0.85 < scatter < 1.15
    assert np.abs(np.mean(misses, axis=0)).max() < 0.6


@pytest.mark.parametrize(("per", "kept"), [((), False), (("session",), True)])
def test_sessions_of_a_row_are_none_but_for_terms_of_their_own(per, kept):
    """What a term has for each label is fitted for each; noise does not depart by them."""
    plain = simulated(60, 5, 0)
    session = np.char.add("scan ", (np.arange(60) // 1.5).astype(str))
    made = replace(plain, at=replace(plain.at, columns={"session": session}))
    model = models.load("altaz")
    terms = [
        replace(one, per=per) if one.effect.id == "elevation_zero" else one for one in model.terms
    ]
    done = fit(made, replace(model, terms=tuple(terms)))
    zeros = [one for one in done.coefficients if one.term.effect.id == "elevation_zero"]

    assert ("session" in done.recordings.at) == kept
    assert len(zeros) == (40 if kept else 1)


def test_too_few_offsets_are_refused():
    """Seven coefficients cannot come from six numbers."""
    with pytest.raises(BadInput, match="6 measured offsets cannot determine 7"):
        fit(simulated(3, 1, 0), models.load("altaz"))


def test_a_fit_starts_from_the_values_that_the_model_has():
    """And ends where it does from nothing."""
    data, altaz = simulated(60, 1, 0), models.load("altaz")
    given = [
        replace(one, values=(300 * ARCSEC,) * len(one.effect.coefficients)) for one in altaz.terms
    ]

    first, second = fit(data, altaz), fit(data, replace(altaz, terms=tuple(given)))

    for one, other in zip(first.coefficients, second.coefficients, strict=True):
        np.testing.assert_allclose(one.value, other.value, atol=1e-6 * ARCSEC)


def test_each_antenna_has_coefficients_of_its_own():
    """Those of the readings that are its."""
    first, second = simulated(60, 1, 0), simulated(60, 1, 1)
    at = Circumstances(
        np.concatenate([first.at.az, second.at.az]),
        np.concatenate([first.at.el, second.at.el]),
        None,
        {"antenna": np.repeat(["A", "B"], 60)},
    )
    nothing = np.full(120, np.nan)
    both = Recordings(
        at,
        np.concatenate([first.x, second.x]),
        np.concatenate([first.y, second.y + 100 * ARCSEC]),
        nothing,
        nothing,
        np.arange(120),
        Path("both"),
    )
    found = {
        one.labels: float(one.value[0])
        for one in fit(both, models.load("altaz")).coefficients
        if one.term.effect.id == "elevation_zero"
    }

    assert (found["B",] - found["A",]) / ARCSEC == pytest.approx(100, abs=3)


def test_what_the_data_do_not_determine_has_no_value():
    """Zero, sag and skew at one elevation."""
    data = simulated(60, 1, 0)
    level = replace(data, at=Circumstances(data.at.az, np.full(60, 0.7)))
    values = {
        one.term.effect.id: one.value for one in fit(level, models.load("altaz")).coefficients
    }

    assert np.isnan(values["elevation_zero"]).all()
    assert np.isnan(values["sag_cosine"]).all()
    assert np.isfinite(values["tilt"]).all()


def test_what_is_left_is_less_than_what_was_there():
    """The sum of squares without what the columns take."""
    rng = np.random.default_rng(0)
    columns, data = rng.normal(size=(50, 3)), rng.normal(size=50)
    both = np.concatenate([columns, data[:, None]], axis=1)
    left = data - columns @ np.linalg.lstsq(columns, data)[0]

    assert Solution.of(both.T @ both).residual == pytest.approx(left @ left)


@pytest.mark.parametrize(
    ("mount", "said"),
    [
        ("altaz", "across and along elevation"),
        ("equatorial", "in cross-declination and in declination"),
    ],
)
def test_residuals_by_label_are_along_the_axes_of_the_mount(mount, said):
    """The head of the table says which they are."""
    given = simulated(60, 3, 4)
    source = np.array(["3C 84", "W3OH"])[np.arange(60) % 2]
    at = replace(given.at, columns={"source": source}, site=Site(0.9), mount=KINDS[mount])

    lines = [*leftover_text(fit(replace(given, at=at), models.load(mount)))]

    assert lines[1] == f"residuals by source: offsets, mean and rms [arcsec] {said}"


def test_a_field_that_says_how_far_it_may_be_from_its_values_is_fitted_to_few_readings():
    """Where they do not reach it keeps its values; one that says nothing needs as many readings."""
    bumps = {"kind": "sky", "width_rad": 0.3}
    count = empirical.values(bumps, simulated(2, 1, 0).at).shape[1]
    of_each = ([1] * count, range(count), np.eye(count).tolist(), "a field", "el: 17 deg wide")
    given, few = (3 * ARCSEC,) * count, simulated(30, 1, 0)
    free, held = (
        replace(models.load("altaz"), terms=(*models.load("altaz").terms, Term(one, values=given)))
        for one in (
            empirical.field(bumps, *of_each),
            empirical.field(bumps, *of_each, spread=[0.01 * ARCSEC] * count),
        )
    )
    with pytest.raises(BadInput, match="60 measured offsets cannot determine"):
        fit(few, free)
    of_field = fit(few, held, [*CLASSICAL_TERMS.split(), "unknown"]).coefficients[-1]

    assert count > 60
    assert all(one.term.effect.id != "unknown" for one in fit(few, held).coefficients)
    np.testing.assert_allclose(of_field.value, given, atol=0.02 * ARCSEC)
    np.testing.assert_allclose(of_field.sigma, 0.01 * ARCSEC, rtol=0.3)


def turned_by(at, tilt, collimation, zero):
    """Return x and y of an axis that leans toward north and a beam off its axis, by rotations."""
    beam = np.stack([np.cos(at.el) * np.ones_like(at.az), np.zeros_like(at.az), np.sin(at.el)])
    # The beam lies beside the plane in which elevation turns.
    beam = np.cos(collimation) * beam + np.sin(collimation) * np.array([[0.0], [1.0], [0.0]])
    turn = at.az + zero
    north = np.cos(turn) * beam[0] - np.sin(turn) * beam[1]
    east = np.sin(turn) * beam[0] + np.cos(turn) * beam[1]
    north, up = (
        np.cos(tilt) * north + np.sin(tilt) * beam[2],
        np.cos(tilt) * beam[2] - np.sin(tilt) * north,
    )
    az, el = np.arctan2(east, north), np.arctan2(up, np.hypot(north, east))
    return np.cos(at.el) * ((az - at.az + np.pi) % (2 * np.pi) - np.pi), el - at.el


@pytest.mark.parametrize("size_deg", [0.02, 0.2, 1.0])
def test_what_terms_lose_that_only_add_up_is_known_to_a_factor_of_three(size_deg):
    """Of exact rotations: what the fit leaves of them without any noise."""
    made = simulated(200, 0.0, 1)
    size = size_deg * DEG
    x, y = turned_by(made.at, size, -size, 1.3 * size)
    found = fit(replace(made, x=x, y=y), models.load("altaz"), weights="equal")
    given = found.stack, made.at, found.stack.value, found.noise.used
    lost = neglected(*given, left=0.0)
    left = np.sqrt(np.mean(found.residual**2))

    assert left / 3 < lost < 3 * left
    assert list(linear(*given, 2.1 * lost)) == []
    assert "only add up" in next(linear(*given, 1.9 * lost))


def test_terms_that_are_not_distinguished_are_fitted_all_the_same():
    """At one elevation nobody tells a zero from sag: what both draw is not left."""
    made = simulated(60, 5.0, 1)
    level = replace(made, at=replace(made.at, el=np.full(60, 0.7)), y=made.y + 300 * ARCSEC)
    found = fit(level, models.load("altaz"))
    open_ = [one.term.effect.id for one in found.coefficients if not np.isfinite(one.value).all()]

    assert {"elevation_zero", "sag_cosine"} <= {*open_}
    assert np.sqrt(np.mean(found.residual[found.stack.is_y] ** 2)) < 20 * ARCSEC


def test_zeros_alone_lose_nothing():
    """However large; of large offsets nothing is said where there is nothing to lose."""
    made = simulated(50, 0.0, 1)
    far = replace(made, x=3 * DEG * np.cos(made.at.el), y=np.full(50, -2 * DEG))
    found = fit(far, models.load("altaz"), weights="equal")

    given = found.stack, made.at, found.stack.value, found.noise.used
    assert neglected(*given, left=0.0) < 1e-3 * ARCSEC


def test_outliers_are_listed_line_by_line():
    """Ten on the terminal, all of them for programs."""
    made = simulated(120, 5.0, 1)
    y = made.y.copy()
    y[5:17] += 2000 * ARCSEC
    found = fit(replace(made, y=y), models.load("altaz"))
    said = [one for one in text(found).splitlines() if one.startswith("outlier: ")]
    told = as_json(found)["outliers"]

    assert len(said) == 11
    assert said[0] == f"outlier: line {made.line[5]}, {told[0]['why']}"
    assert said[-1] == "outlier: 2 more, see --json"
    assert [one["line"] for one in told] == made.line[5:17].tolist()
    assert all("elevation off by " in one["why"] for one in told)


def test_an_outlier_does_not_make_offsets_large():
    """Two degrees off it says nothing of the others; nor do few readings of their products."""
    made = simulated(60, 5.0, 1)
    x = made.x.copy()
    x[7] = 2 * DEG

    for one in (replace(made, x=x), made.take(np.arange(7))):
        assert not any("only add up" in said for said in warnings(fit(one, models.load("altaz"))))
