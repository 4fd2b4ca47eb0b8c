"""The shipped GMRT recordings: made from the printed tables, every cell accounted for."""

from __future__ import annotations

import csv
from collections import Counter

import numpy as np
import pytest

from pyport.angles import ARCMIN, DEG
from pyport.recordings import read
from pyport.recordings.files import DATA, NAMES, shipped
from pyport.studies.gmrt.published import ANTENNAS, SESSIONS, utc_seconds
from pyport.studies.gmrt.recovery import build, checks, printed
from pyport.studies.gmrt.recovery.recovery import recovery

DAYS = [session for session in SESSIONS if session.table != 13]
JUNE = [session for session in SESSIONS if "2003-06" in session.date]


def rows_of(name):
    """Return the rows of a shipped file by column name, as text."""
    lines = shipped(name).read_text().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


@pytest.mark.slow
def test_made_from_the_printed_tables(tmp_path):
    """The shipped files and the README's figures are what the command makes of the tables."""
    build.write_all(tmp_path)

    for made in tmp_path.iterdir():
        assert (DATA / made.name).read_text() == made.read_text()
    assert {made.name for made in tmp_path.iterdir()} == {
        shipped.name for shipped in DATA.iterdir()
    }
    assert checks.readme() == checks.README.read_text()


@pytest.mark.parametrize("session", SESSIONS, ids=lambda session: session.date)
def test_every_printed_offset_is_there_once(session):
    """Each printed offset is a row that names it, none twice and none missing."""
    table = printed.antennas_down() if session.table == 13 else printed.day(session.table)
    wanted = Counter(
        (str(row.number), str(row.column(k)), text)
        for row in table
        for k, text in enumerate(row.offsets)
    )

    found = Counter(
        (row["printed_row"], row["printed_column"], row["printed"])
        for row in rows_of(session.date)
        if row["printed_column"]
    )

    assert found == wanted


@pytest.mark.parametrize("session", SESSIONS, ids=lambda session: session.date)
def test_an_offset_is_used_as_printed_or_set_aside(session):
    """No number was mended: what is used is what is printed, the rest has a reason."""
    for row in rows_of(session.date):
        if row["set_aside"]:
            assert row["d_el_arcmin"] == ""
        else:
            assert int(row["d_el_arcmin"]) == int(row["printed"])
            assert abs(int(row["printed"])) != 999


@pytest.mark.parametrize("session", SESSIONS, ids=lambda session: session.date)
def test_read_back(session):
    """Reading a file gives its used rows and lists all others with line and reason."""
    rows = rows_of(session.date)
    recordings = read(f"gmrt-{session.date}")

    assert len(recordings) == sum(not row["set_aside"] for row in rows)
    assert len(recordings) + len(recordings.set_aside) == len(rows)
    assert all(aside.reason for aside in recordings.set_aside)
    assert np.isnan(recordings.x).all()
    assert np.abs(recordings.y).max() < 60 * ARCMIN
    assert set(recordings.at.column("antenna").tolist()) <= set(ANTENNAS)
    assert set(recordings.at.column("scan_direction").tolist()) == {-1, 1}


def test_no_antenna_has_two_offsets_in_a_row():
    """A printed row gives an antenna at most one offset."""
    for session in DAYS:
        used = [row for row in rows_of(session.date) if not row["set_aside"]]

        places = Counter((row["printed_row"], row["antenna"]) for row in used)

        assert max(places.values()) == 1


def test_june_rows_are_usable():
    """At least 90 % of the printed rows of June keep offsets of half the antennas or more."""
    found = [recovery(session) for session in JUNE]

    assert [one.rows for one in found] == [len(printed.day(session.table)) for session in JUNE]
    assert sum(one.usable for one in found) >= 0.9 * sum(one.rows for one in found)
    assert [one.used for one in found] == [len(read(shipped(session.date))) for session in JUNE]
    assert all(one.used < one.vouched < one.cells for one in found)


def test_three_days_together():
    """`gmrt-cyg-a` holds the three days of June, distinguished by their session."""
    together = read("gmrt-cyg-a")

    alone = {session.date: len(read(f"gmrt-{session.date}")) for session in JUNE}

    assert Counter(together.at.column("session").tolist()) == alone


def test_names_and_dates():
    """A shipped set is found by its name or by its date alone."""
    assert shipped("2003-06-01") == shipped("gmrt-2003-06-01")
    assert all(shipped(name).is_file() for name in NAMES)
    with pytest.raises(KeyError):
        shipped("2003-06-03")


@pytest.mark.parametrize("session", DAYS, ids=lambda session: session.date)
def test_places(session):
    """Azimuth and elevation are those of the source at that time, by another road through ERFA."""
    from astropy import units
    from astropy.coordinates import CIRS, AltAz, EarthLocation, SkyCoord
    from astropy.time import Time
    from astropy.utils import iers

    at = read(f"gmrt-{session.date}").at.take(slice(None, None, 97))
    site = EarthLocation.from_geodetic(74.0497417 * units.deg, 19.0965167 * units.deg)
    time = Time(at.column("time"), format="unix", scale="utc")
    source = SkyCoord(session.source.ra_deg * units.deg, session.source.dec_deg * units.deg)

    with iers.conf.set_temp("auto_download", value=False):
        seen = source.transform_to(CIRS(obstime=time)).transform_to(
            AltAz(obstime=time, location=site)
        )

    # the printed hundredth of an hour is 0.15 deg, diurnal aberration and UT1 are far below
    assert (
        seen.separation(SkyCoord(at.az * units.rad, at.el * units.rad, frame=seen.frame)).deg.max()
        < 0.01
    )


def test_hour_angles_become_times_in_order():
    """Times run on with the hour angle, at the sidereal rate, from the session's date on."""
    session = SESSIONS[2]

    seconds = utc_seconds(session, np.array([-3.75, -2.75]) * 15 * DEG)

    assert np.datetime64(int(seconds[0]), "s").astype(str).startswith("2003-06-01T18:3")
    assert seconds[1] - seconds[0] == pytest.approx(3600 / 1.00273790935)
