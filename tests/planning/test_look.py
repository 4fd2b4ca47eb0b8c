"""A look before fitting: coverage is counted, classes are right, what it suggests is worth it."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from pages import recordings

from pyport.angles import ARCSEC, DEG, separation
from pyport.cli.observe import look as command
from pyport.effects import catalogue
from pyport.fitting.fit import fit
from pyport.formats.models import load
from pyport.mounts.equatorial import EQUATORIAL
from pyport.planning import look
from pyport.planning.design import cells, coverage, design
from pyport.planning.separate import classes, separate
from pyport.planning.suggest import directions, suggest
from pyport.planning.summary import as_json, text
from pyport.recordings import read
from pyport.thresholds import VISIBLE

ALTAZ = load("altaz")


def between(low_deg, high_deg, n=240):
    """Return recordings in a band of elevation."""
    made = recordings(n)
    el = np.linspace(low_deg, high_deg, n)[np.random.default_rng(2).permutation(n)] * DEG
    return replace(made, at=replace(made.at, el=el))


def alike(found, effect):
    """Return what an effect could not be told from."""
    return {name for one in found.seen if one.effect == effect for name, _ in one.alike}


def test_cells_tile_the_sky():
    """Every cell has its own centre and, within a few per cent, the same area."""
    whole = cells(0.0)
    height = 15 * DEG
    lower, upper = whole[:, 1] - height / 2, whole[:, 1] + height / 2
    around = np.array([(whole[:, 1] == el).sum() for el in whole[:, 1]])
    area = 2 * np.pi / around * (np.sin(upper) - np.sin(lower))

    assert len(np.unique(whole, axis=0)) == len(whole)
    np.testing.assert_allclose(area.sum(), 2 * np.pi, rtol=1e-9)
    assert area.max() < 1.4 * area.min()


def test_a_whole_sky_has_no_holes_and_half_a_sky_has_one_opposite():
    """Recordings at every cell cover all; in the south only, the north is the hole."""
    whole = cells(10.0)
    full = coverage(whole[:, 0], whole[:, 1], 10.0)
    south = whole[np.cos(whole[:, 0]) < 0]
    half = coverage(south[:, 0], south[:, 1], 10.0)

    assert (full.covered, full.holes) == (full.cells, ())
    assert half.covered == len(south)
    assert min(half.holes[0].az_deg, 360 - half.holes[0].az_deg) < 20


@given(st.floats(-7, 7), st.floats(-1.5, 1.5), st.floats(-7, 7), st.floats(-1.5, 1.5))
def test_separation_is_a_distance_on_the_sphere(az, el, other_az, other_el):
    """It agrees with the angle between unit vectors and does not mind which comes first."""
    vectors = [
        np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        for a, e in ((az, el), (other_az, other_el))
    ]
    expected = np.arctan2(np.linalg.norm(np.cross(*vectors)), vectors[0] @ vectors[1])
    found = separation(az, el, np.array([other_az]), np.array([other_el]))[0]

    assert found == pytest.approx(expected, abs=3e-8)


def test_refraction_needs_low_elevations():
    """From 6 to 85 deg it is told from harmonics of elevation, from 40 to 60 deg it is not.

    In five degrees the model takes up what they show of a sag.
    """
    wide, narrow = (separate(design(between(*band), ALTAZ)) for band in ((6, 85), (40, 60)))
    sigma = {
        name: next(one.sigma for one in found.seen if one.effect == "refraction")
        for name, found in (("wide", wide), ("narrow", narrow))
    }

    assert alike(wide, "refraction") == set()
    assert "elevation_encoder_harmonics" in alike(narrow, "refraction")
    assert "sag_sine" in separate(design(between(45, 50), ALTAZ)).hidden
    assert sigma["narrow"] > 20 * sigma["wide"]


def test_what_the_model_draws_itself_is_taken_up():
    """A latitude error is a tilt: beside a tilt it shows nothing."""
    found = separate(design(recordings(), ALTAZ))

    assert "site_latitude" in found.hidden
    assert "tilt" not in {one.effect for one in found.seen}
    assert "site_latitude" in {
        one.effect for one in separate(design(recordings(), load("none"))).seen
    }


def test_what_rounding_leaves_of_a_curve_that_the_model_draws_has_no_error():
    """A receiver on a platform acts by sine and cosine of elevation: sag takes up one of them."""
    found = separate(design(recordings(200), ALTAZ, ARCSEC))
    (sight,) = (one for one in found.seen if one.effect == "nasmyth")

    assert sight.inflation < 1 / VISIBLE


def test_an_error_beside_the_model_is_the_one_that_a_fit_gives():
    """The stated sigma is that of a least-squares fit of the model and the effect."""
    given_ = recordings()
    made = design(given_, ALTAZ, noise=5 * ARCSEC)
    (sight,) = (one for one in separate(made).seen if one.effect == "refraction")
    candidate = next(
        one
        for one in made.candidates
        if (one.effect.id, one.effect.variant) == ("refraction", sight.variant)
    )
    columns = np.concatenate([made.base, made.others[:, candidate.columns]], axis=1)
    sigma = 5 * ARCSEC * np.sqrt(np.linalg.inv(columns.T @ columns)[-1, -1])

    assert sight.sigma == pytest.approx(sigma / ARCSEC, rel=1e-6)


def test_a_few_rows_that_were_not_measured_make_no_noise():
    """Of two elevation offsets of -999 arcsec the noise is what it was."""
    good = recordings(120)
    y = good.y.copy()
    y[[7, 80]] = -999 * ARCSEC

    assert look(replace(good, y=y), ALTAZ).noise == pytest.approx(look(good, ALTAZ).noise, rel=0.1)


def test_directions_beat_chance():
    """Suggested directions bring more than the mean of ten random choices of as many."""
    made = design(between(35, 70), ALTAZ, noise=5 * ARCSEC)
    pairs = [
        one
        for one in separate(made).pairs
        if {one.one.effect.id, one.other.effect.id} == {"refraction", "sag_sine"}
    ]
    targets = directions(10, 85)
    _, (best,) = suggest(made, pairs, targets, 4)
    rng = np.random.default_rng(0)
    chance = []
    for _ in range(10):
        few = rng.permutation(len(targets.az))[:4]
        some = replace(targets, az=targets.az[few], el=targets.el[few], source=("",) * 4)
        chance.append(suggest(made, pairs, some, 4)[1][0].after)

    assert best.after < np.mean(chance)
    assert best.after < 0.2 * best.before


def test_what_is_promised_is_what_more_recordings_give():
    """Recordings at the suggested directions, added, leave the promised error."""
    given_ = between(35, 70)
    made = design(given_, ALTAZ, noise=5 * ARCSEC)
    pair = next(
        one
        for one in separate(made).pairs
        if {one.one.effect.id, one.other.effect.id} == {"refraction", "sag_sine"}
    )
    ahead, (promise,) = suggest(made, [pair], directions(10, 85), 3)
    rows = np.append(np.arange(len(given_)), [0, 0, 0])
    added = [np.array([getattr(one, name) for one in ahead]) * DEG for name in ("az_deg", "el_deg")]
    at = replace(
        given_.at.take(rows),
        az=np.append(given_.at.az, added[0]),
        el=np.append(given_.at.el, added[1]),
    )
    wider = design(replace(given_.take(rows), at=at), ALTAZ, noise=5 * ARCSEC)
    members = [(one.effect.id, one.effect.variant) for one in (pair.other, pair.one)]
    by_name = {(one.effect.id, one.effect.variant): one for one in wider.candidates}
    others = [wider.others[:, by_name[name].columns] for name in members]
    columns = np.concatenate([wider.base, *others], axis=1)
    sigma = 5 * ARCSEC * np.sqrt(np.linalg.inv(columns.T @ columns)[-1, -1])

    assert promise.after == pytest.approx(sigma / ARCSEC, rel=1e-4)


@settings(max_examples=30)
@given(st.sets(st.tuples(st.integers(0, 6), st.integers(0, 6)), max_size=8))
def test_classes_are_what_hangs_together(edges):
    """Every likeness lies within one class, and no effect is in two."""
    names = [str(n) for n in range(7)]
    likeness = {name: {} for name in names}
    for a, b in edges:
        if a != b:
            likeness[str(a)][str(b)] = 1.0
    found = classes(likeness)
    flat = [name for one in found for name in one]

    assert len(flat) == len(set(flat))
    assert all(any({str(a), str(b)} <= set(one) for one in found) for a, b in edges if a != b)


def test_sources_are_suggested_where_they_stand():
    """With sources, each suggestion is one of the file's, at an hour angle, above the limit."""
    rng = np.random.default_rng(5)
    dec = rng.uniform(-0.3, 1.0, 7)[np.arange(240) % 7]
    found = look(
        recordings(dec=dec, hour_angle=rng.uniform(-1, 1, 240)),
        ALTAZ,
        sources=True,
        elevations=(20, 80),
    )

    assert len(found.next) == 6
    assert all(one.source.startswith("source ") for one in found.next)
    assert all(20 <= one.el_deg <= 80 and one.hour_angle_h is not None for one in found.next)


def test_of_an_array_the_busiest_antenna_is_looked_at():
    """Two antennas: the one with more recordings, and the text says so."""
    names = np.where(np.arange(240) < 200, "W06", "C01")
    found = look(recordings(antenna=names), ALTAZ)

    assert (found.antenna, found.antennas, len(found.recordings)) == ("W06", 2, 200)
    assert "antenna W06 of 2" in text(found)


def test_many_recordings_are_thinned_and_weigh_as_much():
    """Of 5000 recordings a part stands for all: the errors are those of all."""
    big = recordings(5000)
    whole = separate(design(big, ALTAZ, noise=5 * ARCSEC))
    thinned = look(big, ALTAZ, noise_arcsec=5)
    sigmas = [
        next(one.sigma for one in found.seen if one.effect == "refraction")
        for found in (whole, thinned.separation)
    ]

    assert sigmas[1] == pytest.approx(sigmas[0], rel=0.05)
    assert thinned.noise == pytest.approx(5 * ARCSEC)


def test_the_command_prints_text_or_json(tmp_path):
    """The example of the help works; JSON is on standard output and in the folder, the same."""
    run = CliRunner().invoke(command, ["gmrt-2003-06-02", "--model", "gmrt-paper"])
    also = CliRunner().invoke(
        command, ["gmrt-2003-06-02", "--model", "gmrt-paper", "--json", "--out", str(tmp_path)]
    )

    assert "To observe next" in run.output
    assert "needs temperature_c: temperature" in run.output
    assert json.loads(also.output) == json.loads((tmp_path / "look.json").read_text())


def test_a_look_is_the_same_every_time():
    """Nothing is drawn that is not drawn the same again."""
    one, other = (json.dumps(as_json(look(recordings(), ALTAZ))) for _ in range(2))

    assert one == other


def test_what_the_model_takes_of_an_effect_of_known_size_is_said(tmp_path):
    """In minutes precession is not seen: hour angle and polar axis take it, as a fit shows."""
    rng = np.random.default_rng(4)
    lines = ["# latitude_deg: 48", "# longitude_deg: 11.6", "# mount: fork"]
    lines.append("time_utc,ha_deg,dec_deg,d_ha_arcsec,d_dec_arcsec")
    for n in range(40):
        ha, dec = rng.uniform(-60, 60), rng.uniform(-10, 70)
        at = f"2021-03-04T20:{n // 12:02d}:{5 * (n % 12):02d}"
        lines.append(f"{at},{ha:.4f},{dec:.4f},{rng.normal()},{rng.normal()}")
    (tmp_path / "night.csv").write_text("\n".join(lines) + "\n")
    made = read(tmp_path / "night.csv")
    model = ALTAZ.on(made.at.mount)
    seen = separate(design(made, model, 10 * ARCSEC)).seen
    (sight,) = (one for one in seen if one.effect == "precession")
    (effect,) = (
        one
        for one in catalogue(made.at.mount)["precession"].variants(made.at)
        if one.variant == sight.variant
    )
    x, y = (one[:, 0] for one in effect.columns(made.at))
    before, after = (
        fit(one, model, weights="equal").coefficients
        for one in (made, replace(made, x=made.x + x, y=made.y + y))
    )
    changed = {
        coefficient.name: (new.value[n] - old.value[n]) / ARCSEC
        for old, new in zip(before, after, strict=True)
        for n, coefficient in enumerate(old.term.effect.coefficients)
    }

    assert sight.known_sigmas < 2
    assert abs(sight.taken_for[0][1]) > 200
    assert dict(sight.taken_for) == pytest.approx(changed, abs=1e-3)
    said = text(look(made, model, noise_arcsec=10))
    assert "not seen at the size that physics gives it: " + sight.taken_for[0][0] in said


def test_a_suggestion_for_another_mount_names_its_axes():
    """An observer at an equatorial mount was given azimuths."""
    made = recordings(200)
    turned = replace(made, at=replace(made.at, mount=EQUATORIAL))
    lines = text(look(turned, load("equatorial"))).splitlines()
    (first,) = [one for one in lines if one.startswith("  1. ")]

    assert ", hour angle " in first
    assert ", declination " in first
