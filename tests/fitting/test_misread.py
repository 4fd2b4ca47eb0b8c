"""A file that was misread is told from one that is right, whatever the telescope does."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.angles import ARCSEC
from pyport.diagnosis.diagnose import diagnose
from pyport.fitting import misread as module
from pyport.fitting import readings
from pyport.fitting.fit import completed, fit
from pyport.fitting.misread import Fitted, misread, of_fit
from pyport.formats.models import load
from pyport.mounts import KINDS

ALTAZ = load("altaz")


def said(measured, model=ALTAZ):
    """Return what is said of recordings with the model alone fitted to them."""
    found = fit(measured, model)
    other = of_fit(found)
    return None if other is None else other.of_fit


def on_mount(kind, **columns):
    """Return recordings of a mount whose every term is 30 arcsec, and the model of these terms."""
    made = recordings(300, 7)
    at = replace(made.at, mount=KINDS[kind], columns={**made.at.columns, **columns})
    model = ALTAZ.on(at.mount)
    drawn = [term.effect.columns(at) for term in model.fitted(None)]
    x, y = (sum(one[axis].sum(axis=1) for one in drawn) * 30 * ARCSEC for axis in (0, 1))
    noise = 3 * ARCSEC * np.random.default_rng(7).normal(size=(2, 300))
    return replace(made, at=at, x=x + noise[0], y=y + noise[1]), model


def turned(measured, where, **sign):
    """Return recordings with the sign of some offsets turned."""
    signs = {
        axis: np.where(where, -getattr(measured, axis), getattr(measured, axis)) for axis in sign
    }
    return replace(measured, **signs)


def test_a_file_that_is_right_is_not_doubted():
    """Neither plain, nor with a sag that the model lacks, which zenith distances would draw too."""
    assert said(recordings(300, 1)) is None
    nodding = recordings(300, 2, y=lambda at: 60 * (np.sin(at.el) - np.cos(at.el)))

    assert "zenith" in said(nodding)
    assert "or the model lacks something" in said(nodding)
    assert diagnose(nodding, ALTAZ).misread is None


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (
            lambda r: replace(r, at=replace(r.at, az=-r.at.az)),
            "azimuth is counted in the opposite sense",
        ),
        (lambda r: replace(r, x=-r.x), "have the other sign"),
        (lambda r: replace(r, at=replace(r.at, el=np.pi / 2 - r.at.el)), "zenith distances"),
        (lambda r: replace(r, x=r.x / np.cos(r.at.el)), "lack the cosine that brings azimuth onto"),
        (
            lambda r: replace(r, x=r.x * np.cos(r.at.el)),
            "offsets of azimuth are on the sky already",
        ),
        (lambda r: replace(r, x=r.y, y=r.x), "in each other's place"),
        (lambda r: turned(r, r.at.column("session") == "s2", y=1), "elevation of session s2"),
        (lambda r: turned(r, r.at.column("session") == "s1", x=1, y=1), "both axes of session s1"),
    ],
)
def test_the_reading_that_is_right_is_named(wrong, words):
    """Of all that a column may hold the one that fits."""
    assert words in said(wrong(recordings(300, 3)))


def test_one_error_is_named_before_two():
    """A second one has to make the file much likelier, as a second name in a diagnosis does."""
    counted = recordings(60, 3)
    found = of_fit(fit(replace(counted, at=replace(counted.at, az=-counted.at.az)), ALTAZ))

    ((way,),) = found.ways
    assert "opposite sense" in way


def test_readings_that_the_data_do_not_distinguish_are_all_said(monkeypatch):
    """Those within odds of twenty to one of the best, the best first."""
    zero = np.zeros(120)
    worse = {(): 1e5, ("a",): 5.9, ("b",): 0.0, ("c",): 6.1, ("b", "d"): -10.0}
    readings = [module._Reading(by - 1e5, way, zero, zero + 1) for way, by in worse.items()]
    monkeypatch.setattr(module, "_refitted", lambda *_: readings)
    found = of_fit(fit(replace(recordings(60, 3), y=recordings(60, 3).y * 9), ALTAZ))

    assert found.ways == [("b",), ("a",)]
    assert "if b, or if a, the fit leaves" in found.of_fit


@pytest.mark.parametrize(("rows", "seed", "shown"), [(12, 2, False), (20, 1, True)])
def test_a_file_of_few_readings_is_not_doubted(rows, seed, shown):
    """Twenty numbers more than coefficients are needed, as to find anything."""
    made = recordings(rows, seed)

    assert (said(replace(made, x=-made.x)) is not None) == shown


def test_offsets_are_held_against_a_model_that_is_not_refitted():
    """Of the other sign, or measured with that model in use."""
    measured = recordings(300, 8)
    found = fit(measured, ALTAZ)
    steering = completed(found)
    none, zero = frozenset(), np.zeros(len(found.residual))

    def of(wrong):
        value = found.stack.spread(wrong.x, wrong.y)
        left = value - found.stack.spread(*steering.offsets(wrong.at))
        other = misread(wrong, steering, none, zero == 0, Fitted(left))
        return None if other is None else other.of_findings

    assert of(measured) is None
    assert "all offsets have the other sign" in of(replace(measured, x=-measured.x, y=-measured.y))
    x, y = steering.offsets(measured.at)
    in_use = replace(measured, x=measured.x - x, y=measured.y - y)
    assert "measured with this model in use" in of(in_use)


def test_terms_that_are_refitted_hide_no_model_that_was_in_use():
    """They adapt to what the offsets hold: held to its values the model says what they are."""
    tilt = {"x": lambda at: 40 * np.sin(at.az) * np.sin(at.el), "y": lambda at: 40 * np.cos(at.az)}
    measured = recordings(300, 8, **tilt)
    steering = completed(fit(measured, ALTAZ))
    x, y = steering.offsets(measured.at)
    in_use = replace(measured, x=measured.x - x, y=measured.y - y)
    turned = replace(measured, x=-measured.x, y=-measured.y)

    assert said(measured, steering) is None
    assert "measured with this model in use (--in-use)" in said(in_use, steering)
    assert "all offsets have the other sign" in said(turned, steering)
    added = steering.added_to(in_use)
    assert np.allclose(added.x, measured.x)
    assert np.allclose(added.y, measured.y)
    # A telescope that was rebuilt has offsets of its own: the old model says nothing of them.
    other = {
        "x": lambda at: 40 * np.cos(at.az) * np.sin(at.el),
        "y": lambda at: -40 * np.sin(at.az),
    }
    assert said(recordings(300, 9, **other), steering) is None


@pytest.mark.parametrize("times", [3.6, 15.0, 60.0, 1 / 60])
def test_a_session_in_another_unit_is_named(times):
    """Thousandths of a degree or minutes of arc under the others' seconds, or the reverse."""
    measured = recordings(300, 11)
    odd = np.where(measured.at.column("session") == "s2", 1 / times, 1.0)
    told = said(replace(measured, x=measured.x * odd, y=measured.y * odd))

    size = f"{times:g} times as large as" if times > 1 else "1/60 of"
    assert f"session s2 are in a unit {size} the others'" in told


def test_what_has_no_name_is_no_other_explanation():
    """A wave over the sky draws what a circle counted backwards does, and says nothing."""
    tilt = {"x": lambda at: 12 * np.sin(at.az) * np.sin(at.el), "y": lambda at: 12 * np.cos(at.az)}
    right = recordings(300, 4, **tilt)
    found = diagnose(replace(right, at=replace(right.at, az=-right.at.az)), ALTAZ)

    assert found.findings[0].verdict == "unknown"
    assert "counted in the opposite sense" in found.misread


def test_a_reading_that_leaves_more_than_curves_without_a_name_explains_nothing():
    """Whatever they are, the file holds what they draw."""
    measured = recordings(300, 9)
    backwards = replace(measured, x=-measured.x)
    found = fit(backwards, ALTAZ)
    right = fit(measured, ALTAZ).residual
    curves = [Fitted(right * share, 4) for share in (1.0, 0.8)]
    told = [
        misread(found.recordings, ALTAZ, None, found.noise.used, Fitted(found.residual), one)
        for one in curves
    ]

    assert "counted in the opposite sense" in told[0].of_findings
    assert told[1] is None


@pytest.mark.parametrize(("names", "said"), [(0, False), (1, False), (2, True)])
def test_two_names_are_worth_no_more_than_one_thing_read_otherwise(names, said):
    """A name costs as much, and beyond that the reading has to convince."""
    measured = recordings(300, 9)
    found = fit(replace(measured, x=-measured.x), ALTAZ)
    right = fit(measured, ALTAZ).residual
    other = misread(found.recordings, ALTAZ, None, found.noise.used, Fitted(right, 0, names))

    assert (other is not None) == said


@pytest.mark.parametrize("times", [60.0, 1 / 3600.0])
def test_a_session_in_another_unit_is_named_with_it(times):
    """Where its offsets are by chance smaller or larger than the others', too."""
    measured = recordings(300, 9)
    own = measured.at.column("session") == "s2"
    scale = np.where(own, 1 / times, 1.0)
    far = replace(measured, x=(measured.x + 100 * ARCSEC * own) * scale, y=measured.y * scale)

    assert f"unit {'60 times' if times == 60 else '1/3600 of'}" in of_fit(fit(far, ALTAZ)).of_fit


@pytest.mark.parametrize("larger", [1 / 4.3, 1.0, 4.3])
def test_three_units_allow_for_a_session_of_larger_or_smaller_offsets(larger):
    """Arcminutes are the third that is tried where offsets are 4.3 times as large as usual."""
    spread = np.tile([-1.0, 1.0], 60)
    own = np.arange(120) < 40
    offsets = np.where(own, larger / 60 * spread, spread)
    tried = readings._units(offsets, offsets, own)

    assert 60.0 in tried
    assert len(tried) == 3


def test_nights_that_differ_in_their_zeros_are_not_taken_for_signs():
    """A night off by as much the other way has no shape that says so."""
    night = {"s0": 20.0, "s1": 20.0, "s2": -20.0, "s3": 20.0}
    zeros = recordings(
        300, 5, y=lambda at: 24 * np.array([night[one] for one in at.column("session")]) / 20
    )

    assert said(zeros) is None


def test_outliers_say_nothing_and_neither_do_arrays():
    """One reading in twenty is wrong by anything; antennas have terms of their own."""
    measured = recordings(300, 6)
    wild = np.random.default_rng(6).random(300) < 0.05
    assert said(replace(measured, y=np.where(wild, measured.y + 4000 * ARCSEC, measured.y))) is None
    backwards = replace(measured, x=-measured.x)
    array = {**backwards.at.columns, "antenna": np.resize(["A", "B"], 300)}
    assert said(backwards) is not None
    assert said(replace(backwards, at=replace(backwards.at, columns=array))) is None


def test_the_axes_of_other_mounts_have_their_own_names():
    """An hour angle counted in the opposite sense; on that mount there is no height to misread."""
    right, model = on_mount("fork")

    assert said(right, model) is None
    assert "hour angle is counted in the opposite sense" in said(replace(right, x=-right.x), model)
    assert "hour angle are in seconds of time" in said(replace(right, x=right.x / 15), model)


def test_what_is_recorded_often_is_no_surer():
    """Each pointing ten times, a hundredth of an arcsecond apart, says what it says once."""
    for seed in range(8):
        few = recordings(30, seed)
        rows = np.repeat(np.arange(30), 10)
        apart = 0.01 * ARCSEC * np.random.default_rng(seed).normal(size=300)
        told = {name: column[rows] for name, column in few.at.columns.items()}
        at = replace(few.at, az=few.at.az[rows], el=few.at.el[rows], columns=told)
        nothing = np.full(300, np.nan)
        often = replace(
            few,
            at=at,
            x=few.x[rows] + apart,
            y=few.y[rows] - apart,
            sigma_x=nothing,
            sigma_y=nothing,
            line=np.arange(300),
        )

        assert said(often) is None


@pytest.mark.parametrize("side", ["east", "west"])
def test_a_telescope_on_either_side_of_its_pier_is_read_alike(side):
    """Turned over its declination counts beyond the pole: the cosine is that of the other side."""
    right, model = on_mount("german", pier_side=np.full(300, side))

    assert said(right, model) is None
    wrong = replace(right, x=right.x / right.at.onto_sky)
    assert "lack the cosine" in said(wrong, model)
