"""Reading: the contract's columns, units and signs."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

import pyport
from pyport.angles import ARCMIN, ARCSEC, DEG, HOUR, MDEG
from pyport.recordings import SetAside, read
from pyport.recordings.raw import seconds_of


def written(folder, text):
    """Write a CSV file and return its path."""
    path = folder / "night.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("unit", "radians"), [("deg", DEG), ("arcmin", ARCMIN), ("arcsec", ARCSEC), ("mdeg", MDEG)]
)
def test_units(tmp_path, unit, radians):
    """An offset may come in any of the contract's units."""
    path = written(tmp_path, f"az_deg,el_deg,d_xel_{unit},d_el_{unit}\n10,40,3,-2\n")

    night = read(path)

    assert night.x == pytest.approx([3 * radians])
    assert night.y == pytest.approx([-2 * radians])
    assert night.at.az == pytest.approx([10 * DEG])


def test_azimuth_offset_is_a_coordinate(tmp_path):
    """`d_az` is multiplied by cos El, `d_xel` already is."""
    path = written(tmp_path, "az_deg,el_deg,d_az_arcsec\n0,60,10\n")

    assert read(path).x == pytest.approx([5 * ARCSEC])


def test_zenith_distance_offset_has_the_opposite_sign(tmp_path):
    """`d_zd` is minus `d_el`."""
    path = written(tmp_path, "az_deg,el_deg,d_zd_arcsec\n0,60,10\n")

    assert read(path).y == pytest.approx([-10 * ARCSEC])


def test_azimuth_from_south_is_turned_and_stays_unwrapped(tmp_path):
    """A_S counted from south through west becomes A = A_S + 180 deg, past 360 deg too."""
    text = "# azimuth_zero: south\naz_deg,el_deg,d_el_deg,sun_az_deg\n-90,40,0,0\n270,40,0,90\n"

    night = read(written(tmp_path, text))

    assert night.at.az / DEG == pytest.approx([90, 450])
    assert night.at.column("sun_az") / DEG == pytest.approx([180, 270])


def test_blank_axis_is_not_a_number(tmp_path):
    """Either axis may be blank in a row; a sigma that is blank is unknown."""
    text = "az_deg,el_deg,d_xel_deg,d_el_deg,sigma_el_deg\n1,2,,0.1,\n1,2,0.2,,0.01\n"

    night = read(written(tmp_path, text))

    assert np.isnan(night.x).tolist() == [True, False]
    assert np.isnan(night.y).tolist() == [False, True]
    assert np.isnan(night.sigma_y).tolist() == [True, False]


def test_unusable_rows_are_listed(tmp_path):
    """Rows without offset or position, or flagged, are excluded with line and reason."""
    text = (
        "az_deg,el_deg,d_el_deg,set_aside\n1,2,0.1,\n1,2,,\n,2,0.1,\n\n1,2,0.1,wind above 15 m/s\n"
    )

    night = read(written(tmp_path, text))

    assert night.line.tolist() == [2]
    assert night.set_aside == (
        SetAside(3, "no offset on either axis"),
        SetAside(4, "no azimuth or no elevation"),
        SetAside(6, "wind above 15 m/s"),
    )


def test_columns_get_the_names_that_effects_know(tmp_path):
    """Times are seconds, angles radians, labels text, everything else is kept."""
    text = (
        "# latitude_deg: 53.1\n# longitude_deg: 18.56\n# height_m: 133\n# telescope: RT32\n"
        "az_deg,el_deg,d_el_deg,time_utc,hour_angle_h,ra_deg,dec_arcmin,channel,scan_axis,"
        "scan_direction,scan_rate_arcmin_per_min,temperature_c,oil_bar,weather\n"
        "10,40,0,2003-06-01T12:00:00Z,6,15,60,130,el,-1,20,11.5,3.25,fog\n"
        "10,40,0,,6,15,60,130,,,20,,,\n"
    )

    night = read(written(tmp_path, text))
    at = night.at

    assert at.site is not None
    assert (at.site.latitude, at.site.longitude) == pytest.approx((53.1 * DEG, 18.56 * DEG))
    assert at.site.height_m == 133
    assert night.meta["telescope"] == "RT32"
    assert at.column("time")[0] == 1054468800
    assert np.isnan(at.column("time")[1])
    assert at.column("hour_angle") == pytest.approx([6 * HOUR] * 2)
    assert at.column("ra") == pytest.approx([15 * DEG] * 2)
    assert at.column("dec") == pytest.approx([1 * DEG] * 2)
    assert at.column("channel").tolist() == ["130", "130"]
    assert at.column("scan_axis").tolist() == ["el", ""]
    assert at.column("scan_direction").tolist() == [-1, 0]
    assert at.column("scan_rate") == pytest.approx([20 * ARCMIN / 60] * 2)
    assert at.column("temperature_c")[0] == 11.5
    assert at.column("oil_bar")[0] == 3.25
    assert at.column("weather").tolist() == ["fog", ""]


@pytest.mark.parametrize(
    "moment",
    ["2003-06-01T12:00", "2003-06-01 17:30+05:30", datetime(2003, 6, 1, 12)],  # noqa: DTZ001
)
def test_one_function_reads_times(moment):
    """Of recordings, filters, models and options: UTC unless a zone is told."""
    package = Path(pyport.__file__).parent
    reading = [one for one in package.rglob("*.py") if "fromisoformat" in one.read_text("utf-8")]

    assert seconds_of(moment) == 1054468800
    assert {one.parts[len(package.parts)] for one in reading} == {"recordings", "examiner"}
    assert sum("examiner" not in one.parts for one in reading) == 1


def test_a_time_may_carry_its_zone(tmp_path):
    """A time with an offset from UTC is brought to UTC, one without is UTC."""
    text = (
        "az_deg,el_deg,d_el_deg,time_utc\n1,2,0,2003-06-01T17:30:00+05:30\n1,2,0,2003-06-01 12:00\n"
    )

    time = read(written(tmp_path, text)).at.column("time")

    assert time.tolist() == [1054468800, 1054468800]


def test_position_from_hour_angle_and_declination(tmp_path):
    """With hour angle, declination and latitude no azimuth and elevation are needed."""
    text = "# latitude_deg: 19\nhour_angle_h,dec_deg,d_el_arcmin\n0,40,1\n-6,0,1\n6,0,1\n"

    at = read(written(tmp_path, text)).at

    assert at.el / DEG == pytest.approx([69, 0, 0], abs=1e-9)
    assert at.az / DEG == pytest.approx([0, 90, -90])


def test_hour_angle_and_declination_from_position(tmp_path):
    """Where the site is known, effects find hour angle and declination of every row."""
    text = "# latitude_deg: 19\naz_deg,el_deg,d_el_arcmin\n0,69,1\n90,0,1\n270,0,1\n"

    at = read(written(tmp_path, text)).at

    assert at.column("dec") / DEG == pytest.approx([40, 0, 0])
    assert at.column("hour_angle") / HOUR == pytest.approx([0, -6, 6], abs=1e-9)


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_windows_files(tmp_path, newline, mark):
    """A byte-order mark and CRLF change nothing."""
    text = mark + newline.join(["# latitude_deg: 1", "az_deg,el_deg,d_el_deg", "1,2,3", ""])
    path = tmp_path / "night.csv"
    path.write_bytes(text.encode())

    night = read(path)

    assert night.y == pytest.approx([3 * DEG])
    assert night.line.tolist() == [3]


@pytest.mark.parametrize("rows", ["sep=,\n{}", "# telescope: T\nSEP=,\r\n{}", "\n sep=,\n{}"])
def test_the_line_that_excel_takes_the_separator_from_is_none_of_names(tmp_path, rows):
    """It is passed over, and lines are counted with it."""
    night = read(written(tmp_path, rows.format("az_deg,el_deg,d_el_deg\n1,2,3\n")))

    assert night.y == pytest.approx([3 * DEG])
    assert night.line.tolist() == [rows.count("\n") + 2]


def test_quotes_and_comments(tmp_path):
    """A quoted cell may hold commas; a line that begins with # is no row."""
    text = 'az_deg,el_deg,d_el_deg,source\n1,2,3,"Cyg A, core"\n# clouds\n1,2,3,3C84\n'

    night = read(written(tmp_path, text))

    assert night.at.column("source").tolist() == ["Cyg A, core", "3C84"]
    assert night.line.tolist() == [2, 4]


@pytest.mark.parametrize(
    ("name", "good", "none"),
    [
        ("temperature_c", "-20", "-999"),
        ("temperature_c", "45", "99.9"),
        ("pressure_hpa", "780.5", "0"),
        ("humidity_pct", "100.3", "-1"),
        ("wind_speed_m_s", "31", "9999"),
    ],
)
def test_weather_that_is_none_counts_as_blank(tmp_path, name, good, none):
    """A number that stands for a missing one is no weather; the header says where it was so."""
    path = tmp_path / "night.csv"
    lines = [f"{10 * n},50,1,2,{none if n == 3 else good}" for n in range(6)]
    path.write_text("\n".join([f"az_deg,el_deg,d_xel_arcsec,d_el_arcsec,{name}", *lines]) + "\n")
    night = read(path)

    assert np.flatnonzero(~np.isfinite(night.at.column(name))).tolist() == [3]
    assert night.meta["taken_for_blank"].startswith(f"{name} outside (")
    assert night.meta["taken_for_blank"].endswith("in 1 row")


@pytest.mark.parametrize(
    ("cells", "blank"),
    [
        ("-2.0 -1.5 -999 -0.8 -9999.0 -1.6", [2, 4]),  # what a focus cannot be
        ("1 1 999 1 1 1", [2]),
        ("700 640 999 520 810 745", []),  # a signal-to-noise ratio that is one
        ("997 998 999 1000 1001 1002", []),  # a counter
        ("999 999 999 999 999 999", []),  # nothing to be far from
        ("-2.0 -1.5 -998 -0.8 -1.2 -1.6", []),  # odd, and no nines
    ],
)
def test_nines_far_from_all_other_numbers_count_as_blank(tmp_path, cells, blank):
    """In any column that is no angle, as logs write what was not measured."""
    path = tmp_path / "night.csv"
    lines = [f"{10 * n},50,1,2,{cell}" for n, cell in enumerate(cells.split())]
    path.write_text("\n".join(["az_deg,el_deg,d_xel_arcsec,d_el_arcsec,focus_mm", *lines]) + "\n")
    night = read(path)

    assert np.flatnonzero(~np.isfinite(night.at.column("focus_mm"))).tolist() == blank
    told = night.meta.get("taken_for_blank", "")
    assert told.endswith(f"in {len(blank)} row{'s' * (len(blank) > 1)}") if blank else not told
