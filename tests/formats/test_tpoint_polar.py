"""TPOINT on equatorial mounts: terms, sessions in every kind of record, models and back."""

import erfa
import numpy as np
import pytest
from mounts.steel import offsets, steel

import pyport
from pyport.angles import ARCSEC, DEG
from pyport.effects import Circumstances, Site
from pyport.errors import BadInput
from pyport.formats.convert import convert
from pyport.formats.model_file import WORDS
from pyport.formats.models import load
from pyport.models.terms import tpoint
from pyport.mounts import KINDS
from pyport.recordings import read

PHI = 41.3 * DEG
#: Coefficients of a German mount [arcsec], and the same as flaws of steel.
TRUTH = {"IH": 120.0, "ID": -80.0, "NP": 35.0, "CH": -60.0, "ME": 90.0, "MA": -70.0, "TF": 25.0}
FLAWS = {
    "read": lambda a, d: (-120 * ARCSEC + 0 * a, 80 * ARCSEC + 0 * d),
    "skew": -35 * ARCSEC,
    "collimation": 60 * ARCSEC,
    "lean": (-90 * ARCSEC, 70 * ARCSEC),
    "droop": 25 * ARCSEC,
}


def added(h, d):
    """Return what TPOINT adds to what an equatorial mount read, of a radian of each term."""
    return {
        "IH": (1, 0),
        "ID": (0, 1),
        "CH": (1 / np.cos(d), 0),
        "NP": (np.tan(d), 0),
        "ME": (np.sin(h) * np.tan(d), np.cos(h)),
        "MA": (-np.cos(h) * np.tan(d), np.sin(h)),
        "TF": (
            np.cos(PHI) * np.sin(h) / np.cos(d),
            np.cos(PHI) * np.cos(h) * np.sin(d) - np.sin(PHI) * np.cos(d),
        ),
        "FO": (0, np.cos(h)),
        "DAF": (-(np.cos(PHI) * np.cos(h) + np.sin(PHI) * np.tan(d)), 0),
        "HCES": (np.sin(h), 0),
        "HCEC": (np.cos(h), 0),
        "DCES": (0, np.sin(d)),
        "DCEC": (0, np.cos(d)),
        "PHH": (h, 0),
        "PDD": (0, d),
        "HHSH2": (np.sin(2 * h), 0),
        "HXCH3": (np.cos(3 * h) / np.cos(d), 0),
        "HDSH": (0, np.sin(h)),
        "HDSD": (0, np.sin(d)),
        "HHCH2SD3": (np.cos(2 * h) * np.sin(3 * d), 0),
    }


#: The names of those terms.
FORMULAE = tuple(added(0.1, 0.1))


def stars(n=120, seed=4):
    """Return hour angles, declinations and the sides of a pier of a session."""
    rng = np.random.default_rng(seed)
    hour_angle, dec = rng.uniform(-4.5, 4.5, 9 * n) * 15 * DEG, rng.uniform(-20, 75, 9 * n) * DEG
    up = np.flatnonzero(erfa.hd2ae(hour_angle, dec, PHI)[1] > 20 * DEG)[:n]
    return hour_angle[up], dec[up], hour_angle[up] < 0


@pytest.mark.parametrize("name", FORMULAE)
def test_terms_are_those_of_tpoint(name):
    """True minus read is what the term adds; gravity's and the axes' terms alike."""
    hour_angle, dec, _ = stars()
    az, el = erfa.hd2ae(hour_angle, dec, PHI)
    at = Circumstances(az, el, Site(PHI), mount=KINDS["equatorial"])
    x, y = tpoint.polar_word(name).columns(at)
    d_hour_angle, d_dec = added(hour_angle, dec)[name]

    np.testing.assert_allclose(x, -d_hour_angle * np.cos(dec) + 0 * dec, atol=1e-12)
    np.testing.assert_allclose(y, -d_dec + 0 * dec, atol=1e-12)


@pytest.mark.parametrize("name", FORMULAE)
def test_every_term_has_a_name(name):
    """What TPOINT calls a shape means it."""
    ((shape, sign),) = tpoint.polar_word(name).parts
    other, other_sign = tpoint.polar_name_of(shape)
    ((again, turned),) = tpoint.polar_word(other).parts

    assert again == shape
    assert turned == other_sign
    assert sign in (-1, 1)


def sexagesimal(value, digits):
    """Return hours or degrees as three words."""
    whole, minutes = divmod(abs(value), 1)[0], abs(value) % 1 * 60
    seconds = round(minutes % 1 * 60, digits)
    sign = "-" if value < 0 else "+"
    return f"{sign}{int(whole):02d} {int(minutes):02d} {seconds:0{3 + digits}.{digits}f}"


def records(kind):
    """Return a session's file: stars seen through the flaws of steel, from both sides of a pier."""
    hour_angle, dec, over = stars()
    az, el = erfa.hd2ae(hour_angle, dec, PHI)
    across, along = offsets(steel("equatorial", PHI), az, el, FLAWS, over)
    read_h, read_d = hour_angle + across / np.cos(dec), dec + along
    read_h = np.where(over, read_h + np.pi, read_h)
    read_d = np.where(over, np.pi - read_d, read_d)
    lines = []
    for h, d, seen_h, seen_d in np.degrees([hour_angle, dec, read_h, read_d]).T:
        if kind == "degrees":
            lines.append(f"{h % 360:011.7f} {d:+011.7f} {seen_h % 360:011.7f} {seen_d:+011.7f}")
            continue
        lst = 130.0
        place = sexagesimal((lst - h) / 15 % 24, 5)[1:], sexagesimal(d, 4)
        seen = sexagesimal((lst - seen_h) / 15 % 24, 5)[1:], sexagesimal(seen_d, 4)
        sidereal = f"{int(lst / 15):02d} {lst / 15 % 1 * 60:09.6f}"
        lines.append(" ".join((*place, *seen, sidereal)))
    head = ["drawn", ": EQUAT", "41 18 00.0"]
    return "\n".join([*head, *lines, "END", ""])


@pytest.mark.parametrize("kind", ["degrees", "right ascensions"])
def test_a_session_gives_back_its_model(tmp_path, kind):
    """Read, fitted with IH ID NP CH ME MA TF, written as .mod: the truth, digit for digit again."""
    night, mod = tmp_path / "night.dat", tmp_path / "old.mod"
    night.write_text(records(kind))
    zeros = "".join(f"  {name:8s}{0:10.4f}\n" for name in TRUTH)
    mod.write_text(f"drawn\nT  120   0.0000    0.000   0.0000\n{zeros}END\n")
    recordings = read(night)
    fit = pyport.fit(recordings, str(mod))
    fit.save(tmp_path / "new.mod")
    saved = load(str(tmp_path / "new.mod"))
    again = pyport.fit(recordings, str(tmp_path / "new.mod"))

    assert recordings.at.mount is KINDS["german"]
    assert (recordings.at.column("pier_side") == "west").sum() > 20
    for name, value in TRUTH.items():
        assert fit.coefficients[name].value == pytest.approx(value, abs=0.15)
    assert fit.rms["sky"].to_value("arcsec") < 0.15  # what second order leaves
    written = {t.effect.coefficients[0].name: t.values[0] / ARCSEC for t in saved.terms}
    assert list(written) == list(TRUTH)
    for name, value in written.items():
        assert fit.coefficients[name].value == pytest.approx(value, abs=1e-4)
        assert again.coefficients[name].value == pytest.approx(value, abs=1e-4)


def test_a_session_is_written_again(tmp_path):
    """Both sides of the pier, from a file of columns: what the mount read, to 4e-6 arcsec."""
    night, table, again = (tmp_path / name for name in ("night.dat", "night.csv", "again.dat"))
    night.write_text(records("degrees"))
    convert(str(night), table)
    convert(str(table), again)
    first, second = (read(one) for one in (night, again))

    assert ": EQUAT\n" in again.read_text()
    assert second.at.mount is KINDS["german"]
    np.testing.assert_array_equal(first.at.column("pier_side"), second.at.column("pier_side"))
    np.testing.assert_allclose([second.x, second.y], [first.x, first.y], atol=4e-6 * ARCSEC)
    np.testing.assert_allclose([second.at.az, second.at.el], [first.at.az, first.at.el])
    table.write_text("# mount: xy-ns\nx_deg,y_deg,d_x_deg,d_y_deg\n10,20,0.1,0.1\n")
    with pytest.raises(BadInput, match="TPOINT has no X-Y mount"):
        convert(str(table), again)


@pytest.mark.parametrize(
    ("record", "words"),
    [
        ("10 20 30.1 +20 10 11.2 10 20 31.0 +20 10 12.1", "12 words .*format 1"),
        ("10 20 30.1 +20 10 11.2 1234567 7654321", "8 words .*format 4"),
        ("10 20 30.1 +20 10 11.2 10 20 31.0 +20 10 12.1 100.2 30", "the sidereal time is 100.2"),
    ],
)
def test_records_of_other_formats_are_refused(tmp_path, record, words):
    """What is no catalogue's place with a sidereal time, and no degrees, is no record."""
    night = tmp_path / "night.dat"
    night.write_text(f"drawn\n: EQUAT\n41 18 00.0\n{record}\nEND\n")

    with pytest.raises(BadInput, match=f"night.dat:4: {words}"):
        read(night)


def test_a_model_of_one_mount_is_refused_by_another(tmp_path):
    """Equatorial terms are none of an alt-azimuth session's, and one file has terms of one."""
    mod = tmp_path / "polar.mod"
    mod.write_text(
        "polar\nT    1   0.0000    0.000   0.0000\n  IH       +1.0000\n  TF  +2.0\nEND\n"
    )
    table = {"az_deg": [1.0, 2.0], "el_deg": [30.0, 40.0], "d_az_deg": [0.1, 0.1]}

    assert load(str(mod)).mount is KINDS["equatorial"]
    with pytest.raises(BadInput, match="hour_angle_zero is none of an alt-azimuth mount"):
        pyport.fit(table, str(mod))
    mod.write_text(mod.read_text().replace("TF", "IA"))
    with pytest.raises(BadInput, match="IA is a term of an alt-azimuth mount"):
        load(str(mod))


def test_no_other_vocabulary_has_the_names():
    """A name of an equatorial mount's alone means nothing on an alt-azimuth one."""
    both = {name for name in tpoint.POLAR_NAMED if WORDS["tpoint"](name) is not None}

    assert both == {"TF", "TX"}


def test_a_model_goes_to_no_format_that_lacks_its_terms(tmp_path):
    """The Field System's file is refused by name, the TOML holds all."""
    night = tmp_path / "night.dat"
    night.write_text(records("degrees"))
    fit = pyport.fit(read(night))

    with pytest.raises(BadInput, match="no terms for a German equatorial mount"):
        fit.save(tmp_path / "new.ctl")
    fit.save(tmp_path / "new.toml")
    fit.save(tmp_path / "new.mod")
    model = pyport.load_model(tmp_path / "new.toml")
    at = read(night).at
    np.testing.assert_allclose(
        pyport.load_model(tmp_path / "new.mod").at(at), model.at(at), rtol=0, atol=1e-9
    )
    one = model.offsets(10.0, 60.0, pier_side="east")

    assert model.model.mount is KINDS["german"]
    assert np.isfinite(one.d_xel.value)
    with pytest.raises(BadInput, match="pier_side"):
        model.offsets(10.0, 60.0)
