"""Predictions: smooth misfits are carried over, noise is not, and picked terms pay for picking."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from samples import sample

from pyport.angles import ARCSEC, DEG
from pyport.cli.explain import predict
from pyport.effects import CATALOGUE, Circumstances, Site
from pyport.errors import BadInput
from pyport.fitting.fit import completed, fit
from pyport.formats.completed import write_model
from pyport.formats.models import load
from pyport.models.model import Term
from pyport.mounts import KINDS
from pyport.prediction import compare, contenders, grid, rehearsal, shrunk, unseen, words
from pyport.prediction.contenders import Night, OwnChoice, Picked, Refitted
from pyport.recordings import read, write
from pyport.recordings.schema import Recordings
from pyport.runs.workers import one_thread

ALTAZ = load("altaz")


def _night(n, seed, bent_arcsec=0.0, noise_arcsec=3.0, **columns):
    """Return a night of n pointings of a mount that is bent in elevation."""
    rng = np.random.default_rng(seed)
    az, el = rng.uniform(0, 2 * np.pi, n), rng.uniform(15 * DEG, 85 * DEG, n)
    x = 40 * np.cos(el) - 25 + 9 * np.sin(el) * np.sin(az)
    y = 60 * np.cos(el) + 9 * np.cos(az) + bent_arcsec * np.sin(8 * el)
    offsets = [one + noise_arcsec * rng.normal(size=n) for one in (x, y)]
    nothing = np.full(n, np.nan)
    at = Circumstances(az, el, Site(0.9), columns)
    x, y = (one * ARCSEC for one in offsets)
    return Recordings(at, x, y, nothing, nothing, np.arange(n) + 2, Path(f"night{seed}.csv"))


@pytest.fixture(autouse=True)
def _one_deal(monkeypatch):
    """Deal pointings once: what is tested here does not hang on how often."""
    monkeypatch.setattr(unseen, "DEALS", 1)


def _unseen(contender, night):
    """Return the rms [arcsec] on pointings left out."""
    scheme = next(iter(unseen.schemes(night, 0)))
    left = unseen.left_out(contender, scheme)
    everything = np.ones(len(left), bool)
    return unseen.on_the_sky(left, night.stack.is_y, everything) / ARCSEC


@given(st.floats(-3, 1))
def test_a_spectrum_adds_up_to_one_and_slopes_as_it_says(log_length):
    """However long the waves are, their variances add up to one."""
    for family in shrunk.FAMILIES:
        lengths = np.full(len(family.length), log_length)
        log, slope = family.spectrum(lengths)
        step = 1e-6 * np.eye(len(lengths))
        numbers = [
            (family.spectrum(lengths + one)[0] - family.spectrum(lengths - one)[0]) / 2e-6
            for one in step
        ]

        assert np.exp(log).sum() == pytest.approx(1)
        assert slope == pytest.approx(np.stack(numbers, axis=1), abs=1e-3, rel=1e-5)


@settings(max_examples=5)
@given(st.integers(0, 1000))
def test_the_evidence_slopes_as_it_says(seed):
    """The slopes that the search follows are those of the evidence."""
    night = Night.of(_night(20, 1, 8.0))
    known = OwnChoice(night, ALTAZ).known
    evidence = shrunk._Evidence(known, np.ones(40), 5 * ARCSEC)
    at = one_thread(evidence.at)
    rng = np.random.default_rng(seed)
    logs, along = (size * rng.normal(size=len(evidence.first())) for size in (0.1, 1.0))
    logs = logs + evidence.first()
    number = (at(logs + 1e-5 * along)[0] - at(logs - 1e-5 * along)[0]) / 2e-5

    assert at(logs)[1] @ along == pytest.approx(number, abs=1e-3, rel=1e-5)


def test_where_the_model_suffices_waves_cost_next_to_nothing():
    """On noise alone the model with waves predicts as the model does, to three in a hundred."""
    night = Night.of(_night(120, 2))

    assert _unseen(OwnChoice(night, ALTAZ), night) < 1.03 * _unseen(Refitted(night, ALTAZ), night)


def test_a_smooth_misfit_is_predicted_at_readings_left_out():
    """A curve in elevation that no term has is predicted down to little more than the noise."""
    night = Night.of(_night(120, 3, 20.0))
    own, model = _unseen(OwnChoice(night, ALTAZ), night), _unseen(Refitted(night, ALTAZ), night)

    assert own < 1.3 * 3 * np.sqrt(2)
    assert model > 2 * own


def test_a_curve_carries_over_to_another_night_with_other_zero_points():
    """What the telescope has on one night it has on the next, but for its zero points."""
    first, second = _night(100, 4, 20.0), _night(100, 5, 20.0)
    second = replace(second, y=second.y + 90 * ARCSEC)
    night, other = Night.of(first), Night.of(second)
    everything = np.ones(200, bool)
    own, model = (
        unseen.on_the_sky(unseen.on_another(one, night, other), other.stack.is_y, everything)
        for one in (OwnChoice(night, ALTAZ), Refitted(night, ALTAZ))
    )

    assert own < 0.5 * model


def test_one_gross_outlier_moves_no_prediction():
    """A reading off by ten minutes of arc leaves the others' predictions where they were."""
    clean = _night(100, 6, 15.0)
    spoilt = replace(clean, y=clean.y + 600 * ARCSEC * (np.arange(100) == 50))
    night, bad = Night.of(clean), Night.of(spoilt)
    everything = np.ones(200, bool)
    before, after = (OwnChoice(one, ALTAZ).residual(everything) for one in (night, bad))
    others = ~(night.stack.is_y & (night.stack.row == 50))

    assert np.abs(before - after)[others].max() < 2 * ARCSEC


def test_terms_picked_from_noise_flatter_themselves_only_while_they_are_held():
    """Twelve terms of noise: better than the model where they saw it, worse where not."""
    night = Night.of(_night(60, 7))
    held, anew = (Picked(night, ALTAZ, 19, anew=one) for one in (False, True))
    model = _unseen(Refitted(night, ALTAZ), night)

    assert _unseen(held, night) < model < _unseen(anew, night)


def test_picking_takes_the_term_that_is_there():
    """The second harmonic of azimuth in elevation is the first to be picked."""
    recordings = _night(60, 8, noise_arcsec=0.1)
    recordings = replace(recordings, y=recordings.y + 20 * ARCSEC * np.sin(2 * recordings.at.az))
    night = Night.of(recordings)
    terms = contenders.listed_columns(recordings.at, night.stack.row, night.stack.is_y)
    first = contenders.pick(night.columns(ALTAZ), terms, night.value(ALTAZ), 1)
    expected = np.sin(2 * recordings.at.az)[night.stack.row] * night.stack.is_y

    assert terms[:, first[0]] == pytest.approx(expected)


@pytest.mark.slow
def test_a_rehearsal_knows_what_terms_picked_from_few_points_are_worth(monkeypatch):
    """On a telescope that is the model, picked terms claim less than they leave elsewhere."""
    monkeypatch.setattr(rehearsal, "NIGHTS", 1)
    many = replace(load("altaz"), name="many")
    extra = [Term(CATALOGUE[one]) for one in ("sag_sine", "azimuth_eccentricity", "refraction")]
    many = replace(many, terms=(*many.terms, *extra))
    first, _ = rehearsal.rehearse(_night(40, 11), ALTAZ, many)
    picked_terms = next(name for name in first.fresh if "picked" in name)

    assert first.truth == "many"
    assert first.claimed[picked_terms] < first.fresh[picked_terms]
    assert first.fresh["model with waves"] < first.fresh[picked_terms]
    assert "exactly as many says" in words.of_rehearsals([first])


def test_too_few_readings_are_refused():
    """Five pointings cannot be left out in turn beside seven coefficients."""
    with pytest.raises(BadInput, match="too few to leave some out"):
        compare.compare(_night(4, 12), ALTAZ)


def test_a_term_that_lacks_a_column_is_refused():
    """A cosine of hour angle needs an hour angle."""
    with pytest.raises(BadInput, match="needs hour_angle_h"):
        compare.compare(_night(30, 13), load("gmrt-paper"))


def test_several_antennas_are_told_to_come_one_by_one():
    """One antenna's mount says nothing of another's."""
    names = np.array(["A", "B"] * 20)

    with pytest.raises(BadInput, match="2 antennas, expected one"):
        Night.of(_night(40, 9, antenna=names))


@pytest.mark.slow
def test_the_command_tells_what_picking_costs_and_writes_a_grid(tmp_path):
    """The table, the verdict and the grid; the grid reads as recordings."""
    at = _night(44, 10, 20.0)
    file, model = tmp_path / "night.csv", tmp_path / "many.toml"
    write(at, file)
    terms = "azimuth_zero elevation_zero collimation skew tilt sag_cosine sag_sine azimuth_track"
    model.write_text("".join(f'[[term]]\neffect = "{one}"\n' for one in terms.split()))
    arguments = [str(file), "--against", str(model), "--grid", str(tmp_path / "grid.csv")]
    done = CliRunner().invoke(predict, [*arguments, "--out", str(tmp_path / "out"), "--json"])
    told = json.loads(done.output)
    grid = read(tmp_path / "grid.csv")

    assert done.exit_code == 0
    assert json.loads((tmp_path / "out" / "prediction.json").read_text()) == told
    assert told["contenders"][0]["name"] == "altaz"
    assert told["contenders"][-1]["name"] == "model with waves"
    curve = 20 * np.sin(8 * grid.at.el) + 60 * np.cos(grid.at.el) + 9 * np.cos(grid.at.az)
    assert np.sqrt(np.mean((grid.y / ARCSEC - curve) ** 2)) < 5
    assert np.isfinite(grid.sigma_y).all()


@pytest.mark.slow
def test_an_automatic_choice_of_many_terms_on_few_points_is_told_an_overfit():
    """The Auxiliary Telescope's 44 points: as many terms picked anew do far worse than held."""
    few = read(sample("auxtel/AT_point_file_20200315T022713.dat"))
    done = compare.compare(few, ALTAZ, [load(str(sample("auxtel/at_20200314_fauto.mod")))])
    held, anew = done.picked

    assert anew.unseen["pointings"] > 1.5 * held.unseen["pointings"]
    assert all(done.own.unseen[way] < anew.unseen[way] for way in done.own.unseen)
    assert "are an overfit here" in words.text(done)


def test_models_of_one_name_are_called_by_their_files(tmp_path):
    """In the table, in the verdict and in JSON; those of one file name by their paths."""
    at = _night(30, 12)
    file = tmp_path / "night.csv"
    write(at, file)
    models = [tmp_path / name for name in ("march.toml", "april.toml")]
    for one in models:
        write_model(completed(fit(at, ALTAZ)), one)
    arguments = [str(file), *(f"--against={one}" for one in models), "--json"]
    told = json.loads(CliRunner().invoke(predict, arguments).output)

    names = ["altaz", "march.toml", "april.toml"]
    assert [one["name"] for one in told["contenders"][:3]] == names
    assert list(told["cancel"]) == names[1:]
    assert [one.partition(":")[0] for one in told["verdict"] if ": 7 terms" in one] == names[1:]
    found = compare.distinct([ALTAZ, ALTAZ, load("gmrt-paper")], ["a/m.toml", "b/m.toml", "m"])
    assert [one.name for one in found] == ["a/m.toml", "b/m.toml", "gmrt-paper"]
    found = compare.distinct([ALTAZ, ALTAZ], ["altaz", "m.toml"])
    assert [one.name for one in found] == ["altaz", "m.toml"]


@pytest.mark.parametrize(("worse", "overfit"), [(1.02, False), (1.04, True), (1.5, True)])
def test_terms_that_leave_as_much_unseen_as_in_the_fit_are_no_overfit(worse, overfit):
    """However little the model with waves leaves: an rms of 700 numbers is known to 2.7 %."""
    ways = ("pointings", "elevation bands", "azimuth sectors")

    def row(name, terms, fitted, unseen):
        return compare.Row(name, terms, fitted, dict.fromkeys(ways, unseen), {})

    held, anew = (row(name, 9.0, 6.0, 6.0 * worse) for name in ("held", "anew"))
    model, rival = row("altaz", 7.0, 7.0, 7.1), row("mine", 9.0, 3.0, 3.1)
    waves = row("model with waves", 25.0, 5.2, 5.4)
    done = compare.Comparison(
        "n.csv", 352, 704, 4, (), model, (rival,), (), waves, (held, anew), {"mine": 1.0}, {}, ()
    )

    assert any("overfit" in one for one in words.verdict(done)) == overfit


def test_repeats_of_a_pointing_are_left_out_together():
    """Ten readings of one direction are one pointing, and foretell each other in no fold."""
    once = _night(25, 3, time=1e9 + 300.0 * np.arange(25))
    often = Night.of(once.take(np.repeat(np.arange(25), 10)))

    assert len(often.pointings[0]) == 25
    for way in unseen.schemes(often, 0):
        parts = way.parts[0].reshape(2, 25, 10)
        assert (parts == parts[:, :, :1]).all()
    own, alone = OwnChoice(often, ALTAZ), OwnChoice(Night.of(once), ALTAZ)
    assert _unseen(own, often) > 0.5 * _unseen(alone, Night.of(once))


def test_a_rival_of_the_models_own_terms_cancels_nothing():
    """What rounding leaves of both is no ratio: 3.1 was printed."""
    night = Night.of(_night(60, 13))
    again = replace(load("altaz"), name="again")

    assert compare.cancelled(Refitted(night, again), Refitted(night, ALTAZ)) == 0


def test_an_axis_that_was_not_measured_is_no_term_that_cancels():
    """Of a file of elevation alone some columns are empty."""
    night = _night(60, 5)
    alone = Night.of(replace(night, x=np.full(60, np.nan)))
    more = replace(ALTAZ, name="more", terms=(*ALTAZ.terms, Term(CATALOGUE["sag_sine"])))

    found = compare.cancelled(Refitted(alone, more), Refitted(alone, ALTAZ))
    assert np.isfinite(found)
    columns = np.concatenate([alone.columns(ALTAZ), np.zeros((60, 3))], axis=1)
    terms = np.eye(60)[:, :4]
    value = alone.value(ALTAZ)
    assert contenders.pick(columns, terms, value, 2) == contenders.pick(
        alone.columns(ALTAZ), terms, value, 2
    )


def test_two_nights_of_one_name_are_refused():
    """The table has a column for each."""
    nights = [replace(_night(40, seed), file=Path(f"{seed}/night.csv")) for seed in (5, 6)]
    with pytest.raises(BadInput, match="two nights are called night"):
        compare.compare(_night(40, 4), ALTAZ, others=nights)


def test_a_grid_of_a_narrow_band_has_its_two_edges(tmp_path):
    """Between 41 and 44 deg there is no multiple of five."""
    night = _night(40, 4)
    el = np.linspace(41, 44, 40) * DEG
    grid.write_grid(replace(night, at=replace(night.at, el=el)), ALTAZ, tmp_path / "grid.csv")

    assert np.unique(read(tmp_path / "grid.csv").at.el) / DEG == pytest.approx([41, 44])


def test_a_grid_of_another_mount_is_refused(tmp_path):
    """Its columns are those of an alt-azimuth one."""
    night = _night(40, 4)
    night = replace(night, at=replace(night.at, mount=KINDS["fork"]))
    with pytest.raises(BadInput, match="expected an alt-azimuth one"):
        grid.write_grid(night, ALTAZ, tmp_path / "grid.csv")
    assert not (tmp_path / "grid.csv").exists()


def test_a_model_with_coefficients_is_also_judged_as_it_stands():
    """Nothing is fitted to the readings: a model of last year is off by what has changed since."""
    measured = _night(80, 3)
    known = completed(fit(measured, ALTAZ))
    moved = replace(measured, y=measured.y + 20 * ARCSEC)
    done = compare.compare(moved, ALTAZ, [replace(known, name="last year's")])
    (row,) = done.standing

    assert (row.name, row.terms) == ("last year's as it stands", 0)
    assert row.fitted == pytest.approx(20, abs=2)
    assert set(row.unseen.values()) == {row.fitted}
    assert done.rivals[0].fitted < 6
    assert row in done.rows()
