"""Signs of terms: by a mount that is turned, and by what TPOINT's fits leave of its own files."""

import re

import numpy as np
import pytest
from samples import sample

from pyport.angles import ARCSEC
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.examiner.worlds.mount import Mount, Wave, axes, readings
from pyport.formats import models, tpoint_mod
from pyport.formats.convert import convert
from pyport.models.terms import field_system, tpoint
from pyport.recordings import read

AZ, EL = (one.ravel() for one in np.meshgrid(np.linspace(-3, 3, 9), np.linspace(0.2, 1.3, 7)))

#: What is askew in a mount -> the terms that say so, with their signs.
ASKEW = {
    "azimuth_zero": ("IA", "P1"),
    "elevation_zero": ("-IE", "P7"),
    "beam_left": ("CA", "-P4"),
    "skew": ("NPAE", "P3"),
    "tilt_north": ("AN", "P5"),
    "tilt_east": ("-AW", "P6"),
    "sag_cosine": ("TF", "P8"),
    "sag_sine": ("-ECES", "P11"),
    "elevation_scale": ("P9",),
    "azimuth_scale": ("P12",),
    "centre_right": ("ACEC", "-P13"),
    "centre_ahead": ("ACES", "P14"),
}


def offsets(mount):
    """Return what the encoders read minus what is true, across and along elevation."""
    az, el = readings(mount, *axes(mount, AZ, EL))
    return (az - AZ) * np.cos(EL), el - EL


@pytest.mark.parametrize(
    ("part", "name"), [(part, name) for part, names in ASKEW.items() for name in names]
)
def test_a_turned_mount_reads_what_the_term_says(part, name):
    """A chain of rotations with one thing askew, against one unit of the term."""
    word = tpoint.word(name.lstrip("-")) or field_system.word(name.lstrip("-"))
    sign = -1 if name.startswith("-") else 1
    expected = np.array(word.columns(Circumstances(AZ, EL))) * sign

    actual = np.array(offsets(Mount(**{part: ARCSEC}))) / ARCSEC

    np.testing.assert_allclose(actual, expected, atol=2e-4)


@pytest.mark.parametrize(
    ("name", "wave"),
    [
        ("P15", Wave("el", "az", 2, 0.0, ARCSEC)),
        ("P16", Wave("el", "az", 2, ARCSEC, 0.0)),
        ("P17", Wave("az", "az", 2, 0.0, ARCSEC)),
        ("P18", Wave("az", "az", 2, ARCSEC, 0.0)),
        ("P19", Wave("el", "el", 8, 0.0, ARCSEC)),
        ("P20", Wave("el", "el", 8, ARCSEC, 0.0)),
        ("P21", Wave("el", "az", 1, 0.0, ARCSEC)),
        ("P22", Wave("el", "az", 1, ARCSEC, 0.0)),
    ],
)
def test_an_encoder_that_waves_reads_what_the_parameter_says(name, wave):
    """Harmonics in the readings of a mount."""
    expected = field_system.word(name).columns(Circumstances(AZ, EL))

    np.testing.assert_allclose(
        np.array(offsets(Mount(waves=(wave,)))) / ARCSEC, expected, atol=2e-4
    )


#: Observations, the model fitted to them, and how near linear terms come to the rms it printed:
#: TPOINT applies its terms one after the other.
FITS = {
    "six terms": ("AT_point_data_20220406_tw004_corr", "at_20220406_ia_ie_an_aw_tx10_ca", 0.001),
    "automatic": ("AT_point_data_20220406_tw004_corr", "at_20220406_fauto", 0.002),
    "overfit": ("AT_point_file_20200315T022713", "at_20200314_fauto", 0.3),
}


def left(stars, entries, turned=""):
    """Return the squared distances on the sky that a model leaves [arcsec2], one sign turned."""
    x, y = stars.x / ARCSEC, stars.y / ARCSEC
    for entry in entries:
        value = float(entry.value) * (-1 if entry.name == turned else 1)
        own_x, own_y = tpoint.word(entry.name).columns(stars.at)
        x, y = x - value * own_x, y - value * own_y
    return x**2 + y**2


def rms(squares, fitted):
    """Return the rms of as many as the model was fitted to: TPOINT left the worst one out."""
    return float(np.sqrt(np.sort(squares)[:fitted].mean()))


@pytest.mark.parametrize("case", FITS)
def test_tpoints_models_leave_what_tpoint_says(case):
    """The rms that it printed, and any other sign of a term leaves more."""
    observations, model, tolerance = FITS[case]
    stars = read(sample(f"auxtel/{observations}.dat"))
    file = tpoint_mod.read(sample(f"auxtel/{model}.mod"))
    told = file.details["statistics"]
    fitted = int(told["stars"])

    found = rms(left(stars, file.entries), fitted)

    assert found == pytest.approx(float(told["sky_rms_arcsec"]), abs=tolerance)
    for entry in file.entries:
        if entry.value:
            assert rms(left(stars, file.entries, entry.name), fitted) > found, entry.name


@pytest.mark.parametrize("case", ["six terms", "automatic"])
def test_least_squares_gives_tpoints_coefficients_and_sigmas(case):
    """Within a third of a sigma; sigmas are sky rms times the root of the inverse's diagonal."""
    observations, model, _ = FITS[case]
    stars = read(sample(f"auxtel/{observations}.dat"))
    file = tpoint_mod.read(sample(f"auxtel/{model}.mod"))
    entries = [entry for entry in file.entries if not entry.fixed]
    fitted = int(file.details["statistics"]["stars"])
    kept = np.argsort(left(stars, file.entries))[:fitted]
    pairs = [tpoint.word(entry.name).columns(stars.at) for entry in entries]
    design = np.array([np.concatenate([x[kept], y[kept]]) for x, y in pairs]).T
    measured = np.concatenate([stars.x[kept], stars.y[kept]]) / ARCSEC

    value, (square,), *_ = np.linalg.lstsq(design, measured)
    sigma = np.sqrt(square / fitted * np.diag(np.linalg.inv(design.T @ design)))

    printed = np.array([[float(entry.value), float(entry.sigma)] for entry in entries])
    np.testing.assert_allclose(sigma, printed[:, 1], rtol=1e-2)
    assert np.abs((value - printed[:, 0]) / sigma).max() < 0.33


def test_every_term_of_the_real_models_is_known():
    """Nothing in these files is passed over."""
    for _, model, _ in FITS.values():
        text = sample(f"auxtel/{model}.mod").read_text()
        names = re.findall(r"^[& ][= ]([A-Z][A-Z0-9]+) ", text, re.MULTILINE)
        assert [entry.name for entry in tpoint_mod.read(sample(f"auxtel/{model}.mod")).entries] == (
            names
        )


#: TPOINT's formulae in its azimuth, from south through east: what is added to azimuth (on the
#: sky) and to elevation.
IN_ITS_FRAME = {
    "NPAE": lambda a, e: (np.sin(e), 0 * a),
    "AN": lambda a, e: (np.sin(a) * np.sin(e), np.cos(a)),
    "AW": lambda a, e: (-np.cos(a) * np.sin(e), np.sin(a)),
    "ECES": lambda a, e: (0 * a, np.sin(e)),
    "NRX": lambda _, e: (np.cos(e), -np.sin(e)),
    "NRY": lambda _, e: (np.sin(e), np.cos(e)),
}


@pytest.mark.parametrize("name", IN_ITS_FRAME)
def test_terms_of_its_frame_turn_into_ours(name):
    """Terms that a turned mount confirms and the two of a Nasmyth rotator go by one rule."""
    across, up = IN_ITS_FRAME[name](np.pi - AZ, EL)

    x, y = tpoint.word(name).columns(Circumstances(AZ, EL))

    np.testing.assert_allclose(x, across, atol=1e-12)
    np.testing.assert_allclose(y, -up, atol=1e-12)


def test_a_model_without_its_end_may_be_cut_off(tmp_path):
    """What a copy that broke off lost is not taken for zero."""
    path = tmp_path / "cut.mod"
    path.write_text("Mine\nT   54   3.1416    0.000   0.0000\n  IA  -292.0063  2.1\n")

    with pytest.raises(BadInput, match=r"cut.mod:3: no line END below the terms"):
        tpoint_mod.read(path)


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("IA 1\nIE 2\n IA 3\nEND\n", 5, "IA stands twice, expected each term once"),
        ("IA 1\nEND\nsecond\nT 0 0 0 0\nIE 2\nEND\n", 5, "below END, expected one model"),
        ("IA 1e12\nEND\n", None, "IA is 1E.12 arcsec, expected less than a turn"),
    ],
)
def test_a_model_that_says_too_much_is_refused(tmp_path, text, line, said):
    """The terms were added up, the second model was lost, and a turn of an axis is none."""
    path = tmp_path / "model.mod"
    path.write_text(f"two\nT 0 0 0 0\n{text}")
    with pytest.raises(BadInput, match=said) as refused:
        models.read(path)
    assert refused.value.line == line


def test_a_first_axis_that_rises_beyond_the_zenith_is_refused(tmp_path):
    """Phi is an elevation."""
    path = tmp_path / "model.toml"
    path.write_text(
        'vocabulary = "field-system"\nphi_deg = 95\n[[term]]\nname = "P1"\nvalue_deg = 0.1\n'
    )
    with pytest.raises(BadInput, match="phi is 95 deg, expected -90 to 90"):
        models.read(path)


def test_a_table_of_recordings_is_no_model(tmp_path):
    """It was said to be no katpoint description, and nothing of what to do."""
    night = tmp_path / "night.csv"
    night.write_text("az_deg,el_deg,d_el_arcsec\n10,40,3\n")
    with pytest.raises(BadInput, match=r"night.csv:1: .*--save writes a model of them"):
        convert(str(night), tmp_path / "night.mod")
