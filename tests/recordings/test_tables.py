"""Tables as others write them: repeated names, units, dates and times, rows of other lengths."""

import json

import numpy as np
import pytest
from astropy import units as u
from astropy.table import QTable
from click.testing import CliRunner

from pyport.cli import pyport as program
from pyport.columns import angle_of
from pyport.errors import BadInput
from pyport.recordings import read
from pyport.recordings.formats import mapped
from pyport.recordings.formats.sheet import sheet
from pyport.recordings.raw import FileOptions

ARCSEC = np.degrees(1) * 3600
MAP = "az_deg=az, el_deg=el, d_el_arcsec=del"


def table(tmp_path, text, name="night.txt"):
    """Return a file of some text."""
    path = tmp_path / name
    path.write_text(text)
    return path


def by(path, columns, **given):
    """Return the recordings of a file by a map of its columns."""
    return read(path, FileOptions(mapping=mapped.parse(columns), **given))


def looked(path):
    """Return what `look` proposes, and what it doubts."""
    said = json.loads(CliRunner().invoke(program, ["look", str(path), "--json"]).output)
    return said["columns"], "; ".join(said["doubts"])


OFFS = "AZ EL OFF ERR OFF ERR WIND\n" + "10 40 1 0.1 2 0.2 3\n" * 3


@pytest.mark.parametrize("header", ["", "# "])
def test_numbers_count_the_columns_of_the_file(tmp_path, header):
    """Also where a name stands there twice."""
    given = "az_deg=1,el_deg=2,d_xel_arcsec=3,sigma_xel_arcsec=4,d_el_arcsec=-5,sigma_el_arcsec=6"
    found = by(table(tmp_path, header + OFFS), f"{given},wind_speed_m_s=7")

    np.testing.assert_allclose(found.x * ARCSEC, 1)
    np.testing.assert_allclose(found.y * ARCSEC, -2)
    np.testing.assert_allclose(found.sigma_x * ARCSEC, 0.1)
    np.testing.assert_allclose(found.sigma_y * ARCSEC, 0.2)
    np.testing.assert_allclose(found.at.column("wind_speed_m_s"), 3)


def test_a_name_that_stands_there_twice_is_refused_with_its_numbers(tmp_path):
    """Nobody knows which is meant; `look` proposes numbers."""
    path = table(tmp_path, OFFS)
    with pytest.raises(BadInput, match=r"txt:1: .*columns 3 and 5 are called 'OFF', .*arcsec=3"):
        by(path, "az_deg=AZ,el_deg=EL,d_el_arcsec=OFF")

    twice = table(tmp_path, "az el dxel del del\n1 2 3 4 5\n")
    assert mapped.propose(sheet(twice))["d_el_arcsec"] == "4"


@pytest.mark.parametrize(
    ("names", "columns", "said"),
    [
        ("az,el,del_mdeg", "d_el_arcsec=del_mdeg", "in mdeg, expected d_el_mdeg=del_mdeg"),
        ("az,el,del [mdeg]", "d_el_arcsec=3", "in mdeg, expected d_el_mdeg=3"),
        ("az,el,del(mdeg)", "d_el_arcsec=-del", "in mdeg, expected d_el_mdeg=-del"),
        ('az,el,"dEl[""]"', "d_el_deg=3", "in arcsec, expected d_el_arcsec=3"),
        ("az,el,del [urad]", "d_el_arcsec=3", "in urad, expected numbers in deg, arcmin"),
        ("# del: observed - true [deg]\naz,el,del", "d_el_arcsec=del", "in deg, expected d_el_deg"),
        ("az,el,del\ndeg,deg,mdeg", "d_el_arcsec=del", "in mdeg, expected d_el_mdeg=del"),
    ],
)
def test_a_unit_of_the_file_is_not_overridden(tmp_path, names, columns, said):
    """In a name, in brackets, in the header or below the names; the right map is said."""
    path = table(tmp_path, f"{names}\n10,40,1\n20,50,2\n", "night.csv")

    with pytest.raises(BadInput) as caught:
        by(path, f"az_deg=1,el_deg=2,{columns}")
    assert said in str(caught.value)


def test_a_unit_of_ecsv_is_not_overridden(tmp_path):
    """The one that stands beside the name; in the same unit the column is read."""
    path = tmp_path / "night.ecsv"
    angles = {"az": [1.0, 2] * u.deg, "el": [40.0, 50] * u.deg, "del": [3.0, 4] * u.mdeg}
    QTable(angles).write(path)

    with pytest.raises(BadInput, match="has it in mdeg, expected d_el_mdeg=del"):
        by(path, MAP)
    with pytest.raises(BadInput, match="has it in deg, expected az_deg=az"):
        by(path, "az_rad=az, el_deg=el, d_el_mdeg=del")
    np.testing.assert_allclose(by(path, MAP.replace("arcsec", "mdeg")).y * ARCSEC, [10.8, 14.4])


@pytest.mark.parametrize(
    ("name", "ours", "wanted"),
    [
        ("T [K]", "temperature_c", "deg_C"),
        ("wind (km/h)", "wind_speed_m_s", "m/s"),
        ("freq (GHz)", "frequency_mhz", "MHz"),
        ("P (mbar)", "pressure_hpa", ""),
        ("T (C)", "temperature_c", ""),
    ],
)
def test_a_condition_in_another_unit_is_refused(tmp_path, name, ours, wanted):
    """Not proposed either; the same unit by another name, or one that is not known, is read."""
    path = table(tmp_path, f"az,el,del,{name}\n10,40,1,300\n20,50,2,310\n")

    if wanted:
        with pytest.raises(BadInput, match=rf"--columns {ours}=4: .*, expected {wanted}"):
            by(path, f"{MAP}, {ours}=4")
    else:
        assert len(by(path, f"{MAP}, {ours}=4")) == 2
    assert not wanted or ours not in mapped.propose(sheet(path))


@pytest.mark.parametrize(
    ("name", "ours"),
    [
        ("errAz", "sigma_az_arcsec"), ("AzErr", "sigma_az_arcsec"), ("sigma_el", "sigma_el_arcsec"),
        ("Elevation offset error [deg]", "sigma_el_deg"), ("rms_xel", "sigma_xel_arcsec"),
        ("el_error", "sigma_el_arcsec"), ("dAz err", "sigma_az_arcsec"),
        ("collOffsetAz", "d_az_arcsec"), ("az_off", "d_az_arcsec"), ("dAz*cosE", "d_xel_arcsec"),
    ],
)  # fmt: skip
def test_an_error_is_never_proposed_as_an_offset(tmp_path, name, ours):
    """Whatever stands before or behind it in the name."""
    path = table(tmp_path, f"az,el,{name}\n10,40,1\n")

    assert [one for one in mapped.propose(sheet(path)) if angle_of(one)][2:] == [ours]


@pytest.mark.parametrize(
    ("names", "cells", "columns"),
    [
        ("date,time", "2024-02-01,18:30:00", {"date_utc": "date", "ut_h": "time"}),
        ("Date,UT", "01.02.2024,18:30", {"date_utc": "Date", "ut_h": "UT"}),
        ("Date,UT", "01-Feb-2024,18.5", {"date_utc": "Date", "ut_h": "UT"}),
        ("day,timestamp", "x,2024.032.18:30:00.00", {"time_utc": "timestamp"}),
        ("day,date", "x,2024-02-01T18:30", {"time_utc": "date"}),
        ("MJD,n", "60341.770833333,1", {"time_utc": "MJD|mjd"}),
    ],
)
def test_a_day_and_a_time_of_day(tmp_path, names, cells, columns):
    """What `look` proposes for them is what is read."""
    path = table(tmp_path, f"{names},az,el,del\n{cells},10,40,1\n{cells},20,50,2\n")
    proposed, _ = looked(path)
    times = {key: proposed[key] for key in ("time_utc", "date_utc", "ut_h") if key in proposed}

    assert times == columns
    found = read(path, FileOptions(mapping=proposed)).at.column("time")
    np.testing.assert_allclose(found, 1706812200.0, atol=1e-3)


@pytest.mark.parametrize(
    ("name", "cell", "said"),
    [
        ("timestamp", "01/02/2024 18:00", "day and month could be exchanged"),
        ("timestamp", "2024 Jan 01 18:00:00", "timestamp has '2024 Jan 01 18:00:00', expected ISO"),
        ("seen", "2024-01-01 18:00 CET", ""),
        ("UT", "18:00:00", "UT has hours of a day, expected a column of days too"),
        ("MJD", "2460311.25", "MJD has '2460311.25', expected days since 1858-11-17 (MJD) between"),
        ("MJD", "310.75", "MJD has '310.75', expected days since 1858-11-17"),
    ],
)
def test_look_proposes_no_time_that_is_refused(tmp_path, name, cell, said):
    """It says what was expected."""
    path = table(tmp_path, f"{name},az,el,del\n{cell},10,40,1\n{cell},20,50,2\n")
    proposed, doubts = looked(path)

    assert said in doubts
    assert set(proposed) - {"session"} == {"az_deg", "el_deg", "d_el_arcsec"}
    assert len(read(path, FileOptions(mapping=proposed))) == 2


@pytest.mark.parametrize(
    ("columns", "cell", "said"),
    [
        ("time_utc=t|mjd", "2460311.25", "days since 1858-11-17 (MJD) between 1950 and 2100"),
        ("time_utc=t|mjd", "310.75", "days since 1858-11-17 (MJD) between 1950 and 2100"),
        ("time_utc=t|jd", "60310.75", "days of a Julian date between 1950 and 2100"),
        ("time_utc=t|unix", "1704132000000", "seconds since 1970 between 1950 and 2100"),
        ("time_utc=t", "1858-11-17", "a time between 1950 and 2100"),
        ("time_utc=t", "2024.367.18:00:00", "ISO 8601"),
        ("time_utc=t", "2024.001", "ISO 8601 such as 2003-06-01T18:37:12Z"),
        (
            "time_utc=t",
            "60310.75",
            "ISO 8601 such as 2003-06-01T18:37:12Z (--columns '...|mjd' reads such numbers)",
        ),
        (
            "time_utc=t",
            "2460311.25",
            "ISO 8601 such as 2003-06-01T18:37:12Z (--columns '...|jd' reads such numbers)",
        ),
        (
            "time_utc=t",
            "1704132000",
            "ISO 8601 such as 2003-06-01T18:37:12Z (--columns '...|unix' reads such numbers)",
        ),
        ("date_utc=t, ut_h=u", "2024-01-01", "hours or h:m:s"),
    ],
)
def test_a_time_that_none_can_be_is_refused(tmp_path, columns, cell, said):
    """Another count than was thought; one line says which cell, and what was expected."""
    path = table(tmp_path, f"t,u,az,el,del\n{cell},18:61,10,40,1\n{cell},18:61,20,50,2\n")

    with pytest.raises(BadInput) as caught:
        by(path, f"{columns}, {MAP}")
    assert "night.txt:2: " in str(caught.value)
    assert f"expected {said}" in str(caught.value)


def test_angles_with_colons(tmp_path):
    """`|dms` reads them, `look` proposes it, without it they are refused."""
    path = table(tmp_path, "az el del\n-10:30:00 +40:15 1\n350:00:36.0 50:00:00 2\n")
    proposed, doubts = looked(path)
    found = read(path, FileOptions(mapping=proposed))

    assert (proposed["az_deg"], proposed["el_deg"], doubts) == ("az|dms", "el|dms", "")
    np.testing.assert_allclose(np.degrees(found.at.az), [-10.5, 350.01])
    np.testing.assert_allclose(np.degrees(found.at.el), [40.25, 50])
    with pytest.raises(BadInput, match=r"2: az_deg is '-10:30:00', .*\|dms"):
        by(path, MAP)


def test_a_tab_separated_row_may_end_with_an_empty_cell(tmp_path):
    """Or begin with one."""
    rows = "az\tel\tdel\tnote\n10\t40\t1\twindy\n\t40\t1\t\n20\t50\t2\t\n"
    found = by(table(tmp_path, rows), MAP)

    np.testing.assert_allclose(np.degrees(found.at.az), [10, 20])
    assert [one.line for one in found.set_aside] == [3]


@pytest.mark.parametrize(("sign", "odd"), [(",", "1,2,3"), ("\t", "1\t2\t3"), (None, "1 2 3")])
def test_the_first_row_of_another_length_is_named(tmp_path, sign, odd):
    """With its count and the expected one."""
    names, row = ["az", "el", "dxel", "del"], ["10", "40", "1", "2"]
    lines = [(sign or " ").join(one) for one in (names, row, row)] + [odd]

    with pytest.raises(BadInput, match=r"txt:4: 3 cells, expected 4 as in the others"):
        by(table(tmp_path, "\n".join(lines) + "\n"), MAP)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "az el del note\n1 2 3 a b\n1 2 3 a\n1 2 3 a b c\n",
            "2: 5 cells, expected 4 as in line 1",
        ),
        ("A summary\naz\tel\tdel\n1\t2\t3\n1\t2\t3\n", "1: 1 cell, expected 3 as in the others"),
        ("one\ntwo\n", "1: 1 cell, expected a table delimited by commas"),
    ],
)
def test_what_is_no_table_is_refused_with_counts(tmp_path, text, said):
    """Of the first line that is odd, however the cells are taken."""
    with pytest.raises(BadInput) as caught:
        by(table(tmp_path, text), MAP)
    assert f"night.txt:{said}" in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "time,az,el,del\nUTC,deg,,mdeg\n2024-01-01,10,40,1\n2024-01-01,20,50,2\n",
        "time\taz\tel\tdel\n\t(deg)\t(deg)\t(mdeg)\n2024-01-01\t10\t40\t1\n2024-01-01\t20\t50\t2\n",
        "# time  az (deg)  el (deg)  del (mdeg)\n2024-01-01 10 40 1\n2024-01-01 20 50 2\n",
        "! time  az [deg]  el [deg]  del [mdeg]\n2024-01-01 10 40 1\n2024-01-01 20 50 2\n",
    ],
)
def test_units_below_or_behind_names(tmp_path, text):
    """Are units: `look` proposes them, and no row is made of them."""
    path = table(tmp_path, text)
    proposed, _ = looked(path)

    assert "d_el_mdeg" in proposed
    np.testing.assert_allclose(read(path, FileOptions(mapping=proposed)).y * ARCSEC, [3.6, 7.2])


def test_a_table_without_names_says_so(tmp_path):
    """A name that is asked for is not one of the numbers."""
    path = table(tmp_path, "az,el,del\nx,y,z\n10,40,1\n")

    with pytest.raises(BadInput, match=r"no column 'az': no line of names was found, .* 1 to 3"):
        by(path, MAP)


@pytest.mark.parametrize("name", ["night.dat", "night.xtr", "night.err", "night.log"])
def test_a_map_means_a_table(tmp_path, name):
    """Whatever the suffix says, unless a format is named."""
    path = table(tmp_path, "! a night\n! az el del\n10 40 1\n20 50 2\n", name)

    assert len(by(path, MAP)) == 2
    with pytest.raises(BadInput, match="ALTAZ"):
        by(path, MAP, format="tpoint-dat")


def test_a_table_under_the_suffix_of_another_format_is_told_of_maps(tmp_path):
    """Where it is refused."""
    path = table(tmp_path, "! a night\n! az el del\n10 40 1\n20 50 2\n", "night.dat")

    with pytest.raises(BadInput, match="--columns reads any other table"):
        read(path)


def test_radians_under_degrees_are_noticed(tmp_path):
    """By `look`, with a map and without."""
    rows = "".join(f"{n},{n / 5},1\n" for n in range(7))
    path = table(tmp_path, f"az,el,del\n{rows}")
    mapped_to = CliRunner().invoke(program, ["look", str(path), "--columns", MAP]).output

    assert "radians" in looked(path)[1]
    assert "radians" in mapped_to
    path = table(tmp_path, f"az,el,del\n{rows}200,40,1\n")
    assert "radians" not in looked(path)[1]


@pytest.mark.parametrize("name", ["night.fits", "night.csv", "night.log"])
def test_a_fits_file_is_called_one(tmp_path, name):
    """With the way to a table, and with a map too."""
    path = tmp_path / name
    path.write_bytes(b"SIMPLE  =                    T".ljust(2880) + b"\0\xff")

    for given in (FileOptions(), FileOptions(mapping=mapped.parse(MAP))):
        with pytest.raises(BadInput, match=r"a FITS file, expected a table.*Table\.read"):
            read(path, given)


@pytest.mark.parametrize(
    "header",
    [
        "UT,HA,Dec,dHA,dDec,Side",
        "timestamp,HA_deg,DEC_deg,dHA_arcsec,dDEC_arcsec,Pier",
        "DATE-OBS,hour_angle,declination,delta_ha,decl_offset,side of pier",
    ],
)
def test_columns_of_an_equatorial_mount_are_proposed(tmp_path, header):
    """Hour angle, declination, their offsets and the side of the pier."""
    row = "2020-08-07T19:46:06,-30.1,-0.66,-782.8,-618.7,west\n"
    path = table(tmp_path, f"# latitude_deg: 48\n{header}\n" + row * 3)
    proposed, doubts = looked(path)
    ours = ["time_utc", "hour_angle_deg", "dec_deg", "d_ha_arcsec", "d_dec_arcsec", "pier_side"]

    assert [*proposed] == ours
    assert proposed == dict(zip(ours, header.split(","), strict=True))
    assert not doubts
