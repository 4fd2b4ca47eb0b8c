"""Before the mount is given a model: how far it moves things, where, and what is unsound."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from diagnosis.made import recordings

import pyport
from pyport.angles import ARCSEC
from pyport.cli import pyport as program
from pyport.correction.compare import compare
from pyport.correction.compared import text
from pyport.correction.use import PointingModel
from pyport.errors import BadInput
from pyport.models.model import Model, Term
from pyport.models.terms.editing import named
from pyport.recordings import write


def of(**values):
    """Return a model of TPOINT's terms [arcsec]."""
    terms = tuple(
        replace(named(name)[0], values=(value * ARCSEC,)) for name, value in values.items()
    )
    return PointingModel(Model("m", terms))


def test_a_zero_moves_the_whole_sky_alike():
    """IE by 10 arcsec moves everything by 10; what moves most is where it does."""
    found = compare(of(IE=5, TF=0), of(IE=-5, TF=30))
    sky = found.sky

    assert compare(of(IE=5), of(IE=-5)).sky.rms_arcsec() == pytest.approx(10)
    assert sky.el_deg[np.argmax(sky.size_arcsec)] == 5
    assert sky.size_arcsec.max() == pytest.approx(10 + 30 * np.cos(np.radians(5)))
    assert found.rows is None
    assert sky.observed.all()


def test_the_beam_says_how_much_of_the_sky_is_lost():
    """Cos E times 60 arcsec is more than 30 below 60 deg: sin 60 less sin 5 of the sky."""
    found = compare(of(TF=0), of(TF=60))
    said = "\n".join(text(found, beam_arcsec=30))

    assert found.sky.share(30) == pytest.approx(0.87, abs=0.03)
    assert "elevations 5 to 59 deg" in said
    assert "nowhere" in "\n".join(text(found, beam_arcsec=61))


def test_rows_that_get_worse_and_what_was_not_observed():
    """Half of the sky seen: the other half is extrapolated; the outlier gets worse."""
    measured = recordings(300, 4)
    east = measured.take(np.sin(measured.at.az) > 0)
    fitted = pyport.fit(east).model
    found = compare(of(IE=0), fitted, east)
    rows = found.rows

    assert 0.25 < found.sky.observed.mean() < 0.75
    assert rows.rms_after["el"] < 0.4 * rows.rms_before["el"]
    assert len(rows.worse) < len(rows.line) / 2
    change = rows.after_arcsec - rows.before_arcsec
    assert rows.worse[0] == np.argmax(change)
    assert "further than 15 deg from any recording" in "\n".join(text(found))


def test_a_rounded_copy_is_no_worse():
    """What a file's last digit moves is no change of any recording."""
    found = compare(of(IE=10), of(IE=10.00004), recordings(100, 4))

    assert len(found.rows.worse) == 0
    assert "rows that get worse: 0 of 100" in "\n".join(text(found))


@pytest.mark.slow
def test_a_model_that_follows_the_air_is_compared_in_its_usual_state():
    """At the recordings' median temperature, or the one that is given."""
    measured = recordings(900, 5, y=lambda at: 1.5 * (at.columns["temperature_c"] - 8))
    new = pyport.diagnose(measured).model
    old = pyport.fit(measured).model
    usual = compare(old, new, measured).sky
    warm = compare(old, new, measured, {"temperature_c": np.array(28.0)}).sky

    assert float(usual.conditions["temperature_c"]) == pytest.approx(8, abs=0.5)
    assert usual.rms_arcsec() < 3
    assert warm.rms_arcsec() == pytest.approx(30, abs=3)
    with pytest.raises(BadInput, match="temperature_c"):
        compare(old, new)


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    """Return a narrow night's file, a model fitted to it, and the old model."""
    folder = tmp_path_factory.mktemp("night")
    whole = recordings(400, 9)
    narrow = whole.take(np.abs(whole.at.el - 0.9) < 0.08)
    write(narrow, folder / "night.csv")
    (folder / "old.mod").write_text("old\nT 1 1 0 0\n  IA 40\n  IE 15\n  CA -25\n  TF 60\nEND\n")
    pyport.fit(narrow, "altaz").save(folder / "new.toml")
    return folder


def test_a_term_without_significance_is_refused_and_accepted(night):
    """Skew from nine degrees of elevation: not significant, and the horizon moves by it."""
    words = ["compare", night / "old.mod", night / "new.toml", "--recordings", night / "night.csv"]
    refused = CliRunner().invoke(program, [str(word) for word in words])
    accepted = CliRunner().invoke(program, [*(str(word) for word in words), "--accept"])

    assert isinstance(refused.exception, BadInput)
    assert "azimuth_zero" in str(refused.exception)
    assert "which is not significant, and moves the" in refused.output
    assert accepted.exit_code == 0, accepted.output


def test_the_command_draws_and_answers_in_json(night, tmp_path):
    """A picture of the sky and all numbers for other programs."""
    drawn = tmp_path / "sky.png"
    words = ["compare", night / "old.mod", night / "old.mod", "--recordings", night / "night.csv"]
    done = CliRunner().invoke(program, [*map(str, words), "--picture", str(drawn), "--json"])
    told = json.loads(done.output)

    assert drawn.read_bytes()[:4] == b"\x89PNG"
    assert told["sky"]["rms_arcsec"] == 0
    assert told["recordings"]["worse"] == []
    assert told["recordings"]["rms_before_arcsec"] == told["recordings"]["rms_after_arcsec"]
    assert told["unsound"] == []


def test_a_sound_change_is_no_refusal():
    """A well known term may move the horizon by anything."""
    measured = recordings(600, 3, y=lambda at: 80 * np.cos(at.el))
    assert compare(of(IE=0), pyport.fit(measured).model, measured).unsound == ()
    assert Term(named("IE")[0].effect).values is None
