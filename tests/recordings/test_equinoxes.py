"""Mean places of catalogues, against astropy's FK4 and FK5."""

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import FK4, FK5, SkyCoord
from astropy.time import Time

from pyport.recordings.sky import Equinox, Place, equinox, to_j2000

DATE = Time("2007-07-02")


@pytest.mark.parametrize("word", ["1950.0", "B1950", "J2015.5", "1984.0", "J2000"])
def test_places_at_a_date_are_astropys(word):
    """With proper motions of up to an arcsecond a year, all over the sky: 0.05 arcsec."""
    rng = np.random.default_rng(4)
    of = equinox(word)
    start = Time(of.year, format="byear" if of.besselian else "jyear")
    for ra, sine, across, along in rng.uniform([0, -0.98, -1, -1], [360, 0.98, 1, 1], (20, 4)):
        dec = np.degrees(np.arcsin(sine))
        pm_ra, pm_dec = np.radians([across / 3600 / np.sqrt(1 - sine**2), along / 3600])
        years = (DATE - start).to_value(u.yr)
        there = np.radians([ra, dec]) + years * np.array([pm_ra, pm_dec])
        if of.besselian:
            whole = FK4(*there * u.rad, equinox="B1950", obstime=DATE)
        else:
            whole = FK5(*there * u.rad, equinox=start)
        found = to_j2000(Place(*np.radians([ra, dec]), pm_ra, pm_dec), of)
        since = DATE.jyear - 2000
        mine = SkyCoord(
            (found.ra + since * found.pm_ra) * u.rad, (found.dec + since * found.pm_dec) * u.rad
        )

        assert mine.separation(SkyCoord(whole).icrs).to_value("arcsec") < 0.05


def test_words_of_equinoxes():
    """A letter says which; without one a year before 1984 is Besselian; others are none."""
    assert equinox("B1950.0") == equinox("1950") == Equinox(1950.0, besselian=True)
    assert equinox("j2000.0") == equinox("2000") == Equinox(2000.0, besselian=False)
    assert not equinox("B1900").known
    assert equinox("J1900").known
    assert equinox("12.5") is None
    assert equinox("HARPB") is None
