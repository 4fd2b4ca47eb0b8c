"""Models changed by names, fits saved, and the warnings that come with them."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

from pyport.angles import ARCSEC, DEG
from pyport.cli.fit import command
from pyport.diagnosis.preparing import prepare
from pyport.effects import CATALOGUE, Circumstances
from pyport.errors import BadInput
from pyport.fitting import soundness
from pyport.fitting.fit import completed, fit
from pyport.formats import models
from pyport.formats.completed import write_model
from pyport.formats.models import load
from pyport.models.terms.editing import edited, named
from pyport.recordings import read

#: Truth of the recordings [arcsec].
TRUTH = {"IA": 30.0, "IE": -55.0, "CA": 21.0, "AN": 8.0, "AW": -5.0, "TF": 44.0}


def coefficients(model):
    """Return the names of a model's coefficients, fixed ones with `=`."""
    return [
        ("=" if term.fixed else "") + one.name
        for term in model.terms
        for one in term.effect.coefficients
    ]


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    """Return recordings of TRUTH with a tenth of an arcsecond of noise, over two sources."""
    rng = np.random.default_rng(4)
    az, el = rng.uniform(0, 2 * np.pi, 120), rng.uniform(0.1, 1.5, 120)
    at = Circumstances(az, el)
    x, y = rng.normal(0, 0.1, (2, 120))
    for name, value in TRUTH.items():
        own_x, own_y = named(name)[0].effect.columns(at)
        x, y = x + value * own_x[:, 0], y + value * own_y[:, 0]
    path = tmp_path_factory.mktemp("night") / "night.csv"
    rows = "".join(
        f"{a / DEG:.9f},{e / DEG:.9f},{u:.6f},{v:.6f},{'Vir A' if n % 3 else '3C84'}\n"
        for n, (a, e, u, v) in enumerate(zip(az, el, x, y, strict=True))
    )
    path.write_text("az_deg,el_deg,d_xel_arcsec,d_el_arcsec,source\n" + rows)
    return path


def test_terms_are_dropped_added_and_fixed_by_any_name():
    """One coefficient of an effect, TPOINT's name, the Field System's, an effect's id."""
    model = edited(
        load("altaz"),
        drop=["AN", "skew"],
        add=["P11", "HASA3", "azimuth_harmonics"],
        fix=["IE=-213.05"],
    )

    assert coefficients(model) == [
        "azimuth_zero",
        "=IE",
        "collimation",
        "tilt_east",
        "sag_cosine",
        "P11",
        "HASA3",
        "azimuth_harmonic_sine",
        "azimuth_harmonic_cosine",
    ]
    x, y = model.offsets(Circumstances(np.zeros(3), np.array([0.1, 0.5, 1.0])))
    np.testing.assert_allclose(y / ARCSEC, 213.05)
    np.testing.assert_array_equal(x, 0)


@pytest.mark.parametrize(
    ("text", "arcsec"),
    [("P7=0.06", 216), ("P7=60arcsec", 60), ("IE=1", -1), ("elevation_zero = 1e-2deg", 36)],
)
def test_a_fixed_value_has_the_names_unit_or_its_own(text, arcsec):
    """All of them are the elevation's zero."""
    _, y = edited(load("none"), fix=[text]).offsets(Circumstances(np.zeros(1), np.ones(1)))

    assert y / ARCSEC == pytest.approx([arcsec])


def test_a_name_alone_is_held_where_it_is(tmp_path):
    """What an old model gives stays; what it does not give is zero."""
    path = tmp_path / "old.mod"
    path.write_text("old\nT 1 1 0 0\n  IA  +12.5  0.5\n  CA  -3.0  0.5\nEND\n")

    model = edited(load(str(path)), fix=["IA"])

    assert coefficients(model) == ["=IA", "CA"]
    assert model.terms[0].values == (12.5 * ARCSEC,)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"drop": ["TX"]}, "--drop TX: the model has no such term, it has azimuth_zero"),
        ({"drop": ["QQ"]}, "no term is called 'QQ'"),
        ({"add": ["IA"]}, "--add IA: the model has it already, as azimuth_zero"),
        ({"add": ["P24"]}, "P24 does nothing"),
        ({"fix": ["tilt=1"]}, "several coefficients, fix tilt_north, tilt_east one by one"),
        ({"fix": ["IE=one"]}, "the value is 'one', expected a number"),
        ({"fix": ["IE=1parsec"]}, "the value is '1parsec'"),
        ({"fix": ["TX"]}, "--fix TX: the model has no such term"),
    ],
)
def test_a_change_that_makes_no_sense_is_refused(change, words):
    """With the option, and what the model has."""
    with pytest.raises(BadInput, match=words):
        edited(load("altaz"), **change)


def test_every_effect_can_be_added_by_its_id():
    """And each coefficient under its own name, where it is not one of several choices."""
    for effect in CATALOGUE.values():
        if effect.coefficients:
            assert len(named(effect.id)) == len(effect.coefficients)


@pytest.mark.slow
def test_a_diagnosis_holds_what_is_fixed(night):
    """Its base are the terms that are fitted; fixed ones are taken off."""
    problem = prepare(read(night), edited(load("altaz"), fix=["IE=-55", "NPAE=0"]))

    names = [one.candidate.effect.coefficients[0].name for one in problem.base]
    assert names == ["azimuth_zero", "collimation", "tilt_north", "tilt_east", "sag_cosine"]
    elevation = problem.residual[problem.stack.is_y]
    assert elevation.mean() / ARCSEC == pytest.approx(44 * 0.7, abs=15)


def test_a_fit_from_an_old_model_gives_whole_values(night, tmp_path):
    """Not corrections to it; fixed terms are taken off and stay."""
    path = tmp_path / "old.mod"
    text = "".join(f"  {name}  {value + 3:+.2f}  1.0\n" for name, value in TRUTH.items())
    path.write_text("old\nT 1 1 0 0\n" + text + "END\n")

    done = fit(read(night), edited(load(str(path)), fix=["IE=-55", "NPAE=0"]))

    found = {
        one.term.effect.coefficients[0].name: one.value[0] / ARCSEC for one in done.coefficients
    }
    assert found == pytest.approx({k: v for k, v in TRUTH.items() if k != "IE"}, abs=0.2)


@pytest.mark.parametrize("name", ["x.mod", "x.ctl", "x.txt", "x.xml", "x.toml", "x.json"])
def test_a_fit_is_saved_in_any_format(night, tmp_path, name):
    """From composite effects, with what was fixed: the file points as the fit does."""
    done = fit(read(night), edited(load("altaz"), fix=["NPAE=0"]))
    write_model(completed(done), tmp_path / name)

    x, y = load(str(tmp_path / name)).offsets(done.recordings.at)

    left = np.concatenate([done.recordings.x - x, done.recordings.y - y])
    np.testing.assert_allclose(left, done.residual, atol=1e-3 * ARCSEC)


def test_a_saved_fit_starts_the_next_one(night, tmp_path):
    """TPOINT's line of statistics tells the stars and the rms on the sky."""
    done = fit(read(night), load("altaz"))
    write_model(completed(done), tmp_path / "x.mod")

    told = models.read(tmp_path / "x.mod").details["statistics"]

    assert told["stars"] == 120
    assert float(told["sky_rms_arcsec"]) == pytest.approx(0.14, abs=0.02)


def test_a_term_that_a_format_cannot_name_is_refused(night, tmp_path):
    """Nothing is left out of a saved model."""
    done = fit(read(night), edited(load("altaz"), add=["HESE3"]))

    with pytest.raises(BadInput, match="no name for HESE3"):
        write_model(completed(done), tmp_path / "x.ctl")
    with pytest.raises(BadInput, match="suffix is none of a model"):
        write_model(completed(done), tmp_path / "x.dat")


def test_warnings_name_what_is_weak_tied_or_open(night):
    """Skew was not put in; with little range in elevation the classical three tie together."""
    whole = read(night)
    low = whole.take(whole.at.el < 0.4)

    assert any("zero: skew" in one for one in soundness.warnings(fit(whole, load("altaz"))))
    tied = list(soundness.warnings(fit(low, load("altaz"))))
    assert any(
        re.match(r"azimuth_zero and collimation correlate by -(0\.99|1\.0)", t) for t in tied
    )
    assert any("only cos E, 1 and sin E distinguish them" in one for one in tied)
    assert any("condition number" in one for one in tied)
    open_ = fit(whole, edited(load("none"), add=["P8"])).model
    both = fit(whole, type(open_)("both", (*open_.terms, *named("TF"))))
    assert any(one.startswith("not determined: P8, TF") for one in soundness.warnings(both))


def test_the_command_does_all_of_it(night, tmp_path):
    """Names, filters, a saved model, residuals recording by recording and by source."""
    options = ["--model", "altaz", "--drop", "skew", "--fix", "IE=-55", "--where", "el_deg > 20"]
    outputs = ["--save", str(tmp_path / "x.mod"), "--out", str(tmp_path)]
    printed = CliRunner().invoke(command, [str(night), *options, *outputs], catch_exceptions=False)

    assert printed.exit_code == 0
    assert re.search(r"^IE +-55\.0000 arcsec, fixed$", printed.output, re.MULTILINE)
    assert "residuals by source" in printed.output
    report = json.loads((tmp_path / "fit.json").read_text())
    assert {one["source"] for one in report["residuals"]["source"]} == {"3C84", "Vir A"}
    names = report["correlation"]["names"]
    assert np.array(report["correlation"]["matrix"]).shape == (len(names), len(names))
    head, *rows = (tmp_path / "residuals.csv").read_text().splitlines()
    assert head.startswith("line,axis,source,az_deg")
    assert len(rows) == 2 * sum(
        float(line.split(",")[1]) > 20 for line in night.read_text().splitlines()[1:]
    )
    assert " =IE        -55.0000\n" in (tmp_path / "x.mod").read_text()
