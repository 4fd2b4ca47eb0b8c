"""TPOINT files as they are met: equatorial records, remarks above the title, generic terms."""

from decimal import Decimal

import numpy as np
import pytest
from samples import sample

import pyport
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.formats import models
from pyport.formats.convert import convert
from pyport.formats.model_file import Entry, ModelFile, translated
from pyport.models.terms import editing, tpoint
from pyport.models.terms.editing import named
from pyport.recordings import read

TERMS = ["IA", "IE", "CA", "AN", "AW", "TF", "TX"]
AT = Circumstances(np.linspace(-3, 3, 41), np.linspace(0.1, 1.5, 41))
RUN = "+19 49 33.03  2007 07 02"
WEATHER = "     6.25  627.90   4111.00   0.034   866.963"
STAR = "21 02 37.996 +36 43 15.36  21 02 26.679 +36 44 41.42   21 15.84437   92.680 HARPB"


def written(tmp_path, *stars, run=RUN + WEATHER, above=""):
    """Return the path of a file of stars."""
    path = tmp_path / "stars.dat"
    path.write_text(
        f"{above}a title\n: ALTAZ\n{run}\n" + "".join(f"{s}\n" for s in stars) + "END\n"
    )
    return path


def test_right_ascensions_become_azimuths(tmp_path):
    """A star near the zenith of 19.8 deg: its place by the hour angle, its offset in arcminutes."""
    found = read(written(tmp_path, STAR))
    hour_angle = np.radians(15 * (21 + 15.84437 / 60 - (21 + 2 / 60 + 37.996 / 3600)))

    assert np.degrees(found.at.el[0]) == pytest.approx(72.9, abs=0.05)
    assert found.at.column("hour_angle")[0] == pytest.approx(hour_angle, abs=1e-4)
    assert np.degrees(found.x[0]) * 3600 == pytest.approx(-117.7, abs=0.2)
    assert np.degrees(found.at.column("ra")[0]) == pytest.approx(315.6583, abs=1e-3)
    assert found.at.column("auxiliary_2").tolist() == ["HARPB"]


def test_the_weather_of_the_run_lifts_the_star(tmp_path):
    """36.3 arcsec times tan z, by ERFA, at 628 hPa; without the weather nothing is lifted."""
    thin = read(written(tmp_path, STAR))
    none = read(written(tmp_path, STAR, run=RUN))
    lift = np.degrees(none.y[0] - thin.y[0]) * 3600

    assert lift == pytest.approx(36.29 / np.tan(np.radians(72.9)), rel=0.01)


@pytest.mark.parametrize(("weather", "most"), [(" 8 705 3050 0.2", 1e-9), (" 8 705", 0.03)])
def test_weather_without_a_wavelength_is_that_of_light(tmp_path, weather, most):
    """As TPOINT has it: 0.55 um; humidity moves light by hundredths of an arcsecond."""
    whole = read(written(tmp_path, STAR, run=f"{RUN} 8 705 3050 0.2 0.55 0.0065"))
    short = read(written(tmp_path, STAR, run=RUN + weather))

    assert np.degrees(short.y[0]) * 3600 == pytest.approx(np.degrees(whole.y[0]) * 3600, abs=most)


@pytest.mark.parametrize(
    ("star", "run", "said"),
    [
        (STAR, RUN + WEATHER, "refracted by the run's weather (6.25 C, 627.9 hPa, humidity 0.034,"),
        (STAR, f"{RUN} 8 705 3050 0.2", "humidity 0.2, 0.55 um); its record does not give the wav"),
        (STAR, f"{RUN} 8 705", "humidity 0.5, 0.55 um); its record does not give the humidity and"),
        (STAR, f"{RUN} 8", "not refracted, for the run's record has no weather"),
        (STAR, RUN, "not refracted, for the run's record has no weather or a pressure of 0"),
        (STAR, f"{RUN} 6 0 4111 0.03 0.55", "not refracted, for the run's record has no weather"),
        ("10 40 10.1 40.1", RUN, "taken for refracted ones, as the telescope sees them"),
        ("10 40 10.1 40.1", RUN + WEATHER, "is added, and the run's weather is not used"),
    ],
)
def test_what_was_assumed_of_refraction_is_said(tmp_path, star, run, said):
    """Beside what a file says against itself; a conversion keeps it."""
    file = written(tmp_path, star, run=run)
    (note,) = read(file).notes
    assert said in note

    convert(str(file), tmp_path / "stars.csv")
    assert read(tmp_path / "stars.csv").notes == (note,)


def test_a_mean_place_moves_to_the_date(tmp_path):
    """Precession of seven years is some 140 arcsec along the equator: the offset holds it not."""
    apparent = read(written(tmp_path, STAR))
    mean = STAR.replace("+36 43 15.36 ", "+36 43 15.36  0.0 0.0 2000.0 ")
    moved = read(written(tmp_path, mean))
    shift = np.degrees(moved.at.column("ra")[0] - apparent.at.column("ra")[0]) * 3600

    assert shift == pytest.approx(7.5 * 50.3 * 0.9, rel=0.35)
    with pytest.raises(BadInput, match=r"equinox is B1900, expected B1950\.0, a Julian one"):
        read(written(tmp_path, mean.replace("2000.0", "B1900")))


def test_a_day_that_is_none_is_refused(tmp_path):
    """Where a mean place needs the date."""
    mean = STAR.replace("+36 43 15.36 ", "+36 43 15.36  0.0 0.0 2000.0 ")
    spoilt = RUN.replace("2007 07 02", "2003 6 0")
    with pytest.raises(BadInput, match="the date is 2003 6 0, expected year, month and day"):
        read(written(tmp_path, mean, run=spoilt))


def test_the_same_star_from_two_catalogues(tmp_path):
    """3C 273 by its places of B1950 and of J2000: one on the date, to 0.2 arcsec."""
    seen = " 12 29 06.7 +02 03 08.6   15 45.5 0.0"
    old = read(written(tmp_path, "12 26 33.248 +02 19 43.26  0.0 0.0 1950.0" + seen))
    new = read(written(tmp_path, "12 29 06.700 +02 03 08.60  0.0 0.0 J2000" + seen))

    for name in ("az", "el"):
        assert getattr(old.at, name)[0] == pytest.approx(getattr(new.at, name)[0], abs=1e-6)
    apparent = read(written(tmp_path, "12 29 06.700 +02 03 08.60" + seen))
    assert abs(apparent.at.az[0] - new.at.az[0]) > 1e-4


def test_the_jcmts_night_needs_no_refraction():
    """16 stars: the catalogue's places are refracted by the run's weather, TX comes out nothing."""
    done = pyport.fit(sample("jcmt/harp20070702.dat"), "none", add=TERMS, weights="equal")
    tx = done.coefficients["TX"]

    assert len(done.result.recordings) == 16
    assert abs(tx.value) < 2 * tx.sigma
    assert done.rms["sky"].to_value("arcsec") < 8
    assert np.nanmax(np.abs(np.degrees(done.result.recordings.x))) < 0.2


def test_remarks_above_the_title_and_the_published_model():
    """The MMT's 80 stars of 2021-08-21 as format 4: the published AW, TF and TX."""
    done = pyport.fit(sample("mmt/k_and_e.dat"), "none", add=TERMS, weights="equal")
    published = {"AW": -10.33, "TF": 21.41, "TX": -2.72}

    for name, value in published.items():
        assert done.coefficients[name].value == pytest.approx(value, abs=0.05)


@pytest.mark.parametrize(
    ("star", "said"),
    [
        (STAR.replace("21 02 37.996", "21 62 37.996"), "the catalogue's place is 21 62 37.996"),
        (STAR.replace("21 15.84437", "25 15.84437"), "the sidereal time is 25 15.84437"),
        (f"{STAR}\n121.5 45.2 121.6 45.3", "a record of another kind than the first"),
    ],
)
def test_a_spoilt_record_is_one_line(tmp_path, star, said):
    """With file and line."""
    with pytest.raises(BadInput, match=said) as error:
        read(written(tmp_path, star))
    assert "stars.dat:" in str(error.value)


def test_an_offset_of_35_degrees_is_never_silent(tmp_path):
    """It is refused with its line, or allowed by name."""
    path = tmp_path / "far.csv"
    rows = "az_deg,el_deg,d_xel_deg,d_el_deg\n10,45,0.1,0.1\n20,45,35,0.1\n"
    path.write_text(rows)

    with pytest.raises(BadInput, match=r"far.csv:3: offset of 35 deg on the sky"):
        read(path)
    path.write_text("# largest_offset_deg: 36\n" + rows)
    assert len(read(path)) == 2


@pytest.mark.parametrize("k", range(1, 10))
def test_waves_of_zenith_distance(k):
    """Z is 90 deg less E: each is a wave of E, with the sign that a quarter turn gives."""
    z = np.pi / 2 - AT.el
    for letter, function in (("S", np.sin), ("C", np.cos)):
        across, along = (tpoint.word(f"H{axis}{letter}Z{k}").columns(AT) for axis in "SZ")
        np.testing.assert_allclose(across[0], function(k * z), atol=1e-12)
        np.testing.assert_allclose(along[1], function(k * z), atol=1e-12)


def test_polynomials_of_zenith_distance():
    """PZZ2 adds to a zenith distance as TF does, that is to an elevation offset; PSZ2 across."""
    z = np.pi / 2 - AT.el
    across, along = tpoint.word("PSZ2").columns(AT)

    np.testing.assert_allclose(tpoint.word("PZZ2").columns(AT)[1], z**2)
    np.testing.assert_allclose(tpoint.word("PEE").columns(AT)[1], -AT.el)
    np.testing.assert_allclose(across, z**2)
    assert not along.any()
    assert named("PZZ3")[0].effect.coefficients[0].name == "PZZ3"
    shape, sign = tpoint.word("PZZ2").parts[0]
    name, back = tpoint.name_of(shape)
    np.testing.assert_allclose(
        back * tpoint.word(name).columns(AT)[1], sign * tpoint.word("PZZ2").columns(AT)[1]
    )


@pytest.mark.parametrize("name", ["HVSA3", "PZA2", "PXZ2"])
def test_terms_whose_formula_is_not_known_are_refused(name, tmp_path):
    """By name, with the line that would say what they do."""
    assert tpoint.word(name) is None
    with pytest.raises(BadInput, match=f"no term is called '{name}': .* 'NAME: x = sin 3A sin E'"):
        named(name)
    path = tmp_path / "old.mod"
    path.write_text(f"a title\nT 54 3.1 0.0 0.0\n  IA -292.0 1.0\n& {name} 12.5 0.5\nEND\n")
    with pytest.raises(BadInput, match=f"old.mod:4: '{name}' is no term .* '! {name}: x = sin 3A"):
        models.read(path)


def test_a_user_says_what_a_term_does_in_one_line(tmp_path):
    """In a comment of a .mod, a line of TOML or --add: applied, and kept by every round trip."""
    old, again, toml = (tmp_path / name for name in ("old.mod", "again.mod", "new.toml"))
    old.write_text(
        "a title\nT 54 3.1 0.0 0.0\n! HVSA3: x = sin 3A sin E\n"
        "  IA -292.0 1.0\n& HVSA3 12.5 0.5\nEND\n"
    )
    file = models.read(old)
    moves = pyport.load_model(old).offsets(np.degrees(AT.az), np.degrees(AT.el))
    wanted = 12.5 * np.sin(3 * AT.az) * np.sin(AT.el) - 292 * np.cos(AT.el)

    np.testing.assert_allclose(moves.d_xel.to_value("arcsec"), wanted, atol=1e-9)
    assert not moves.d_el.value.any()
    for path in (again, toml):
        models.format_of(path).write(file, path)
        assert models.read(path).entries == file.entries
    added = editing.formula_word("HVSA3", "x = sin 3A sin E")
    (term,) = named("HVSA3: x = sin 3A sin E")
    np.testing.assert_allclose(term.effect.columns(AT)[0][:, 0], added.columns(AT)[0])
    moved = translated(file, "tpoint")
    assert [one.name for one in moved.entries] == ["IA", "HVSA3"]


@pytest.mark.parametrize(
    ("text", "across", "along"),
    [
        ("x = -cos A cos E", -np.cos(AT.az) * np.cos(AT.el), 0),
        ("y = cos 2Z * E^2", 0, -np.cos(2 * AT.el) * AT.el**2),
        ("x = sin E sin A, y = cos A", np.sin(AT.el) * np.sin(AT.az), np.cos(AT.az)),
        ("x = 1, y = -1", 1, -1),
    ],
)
def test_formulae(text, across, along):
    """Products of waves and powers, on either axis."""
    x, y = editing.formula_word("MINE", text).columns(AT)

    np.testing.assert_allclose(x, across + 0 * x, atol=1e-12)
    np.testing.assert_allclose(y, along + 0 * y, atol=1e-12)


@pytest.mark.parametrize("text", ["", "z = sin A", "x = tan E", "x = sin 3A +", "x = sin 12A"])
def test_what_is_no_formula_is_one_line(text):
    """With an example."""
    with pytest.raises(BadInput, match=r"MINE is .*expected such as 'x = sin 3A sin E'"):
        editing.formula_word("MINE", text)


def test_a_polynomial_is_none_of_another_programs():
    """The Field System has no name for it and says so."""
    file = ModelFile("tpoint", (Entry("PZZ2", Decimal(3), "arcsec"),))
    with pytest.raises(BadInput, match="no counterpart of PZZ2"):
        translated(file, "field-system")
