"""TPOINT's equatorial records: a star's catalogue place, the place that was observed, the time.

Right ascension and declination as they are in the catalogue and as the telescope, which corrected
nothing, stood, and the local sidereal time. Where proper motions and an equinox stand behind the
catalogue's place it is a mean one, otherwise an apparent one of the date. The run's record tells
the weather, by which the catalogue's place is refracted: the telescope saw through the air. A night
of the JCMT bears that out: what follows cot E in it is the air's 36.3 arcsec, 33.6 +- 3.4, and
nothing, -2.0 +- 3.5, once the places are refracted.
"""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCSEC, DEG, Array, wrap
from pyport.recordings.formats.text import Line
from pyport.recordings.sky import Place, equator, equinox, horizon, to_j2000

#: Words of a record: RA, Dec, observed RA and Dec of three each, sidereal time of two.
APPARENT = 14
#: So many hours, degrees and minutes in whole numbers are no angles in degrees.
SHORTEST = 6
#: With two proper motions and an equinox.
MEAN = APPARENT + 3
#: Weather behind the date of the run's record: temperature [C], pressure [hPa], height [m],
#: relative humidity, wavelength [um]; a lapse rate may follow, which ERFA does not use.
WEATHER = ("temperature_c", "pressure_hpa", "height_m", "humidity", "wavelength_um")
#: What is taken where a record ends before these: half humid, which moves light by less than 0.1
#: arcsec at 45 deg, and TPOINT's wavelength.
USUAL = {"height_m": 0.0, "humidity": 0.5, "wavelength_um": 0.55}


@dataclass(frozen=True)
class Star:
    """A record, in degrees."""

    #: `az`, `el`: where the star stood, refracted where the weather is known.
    az: float
    el: float
    #: `seen_az`, `seen_el`: where the telescope stood.
    seen_az: float
    seen_el: float
    #: `ra`, `dec`: of the catalogue, apparent.
    ra: float
    dec: float
    rest: tuple[str, ...]  #: the words behind
    latitude: float  #: of the site
    over: bool  #: whether the telescope had turned over: its declination was beyond the pole

    def across(self) -> dict[str, float]:
        """Return the place and the telescope less it, as an alt-azimuth mount has them."""
        return {
            "az_deg": self.az % 360,
            "el_deg": self.el,
            "d_az_deg": _turn(self.seen_az - self.az),
            "d_el_deg": self.seen_el - self.el,
            "ra_deg": self.ra,
            "dec_deg": self.dec,
        }

    def polar(self) -> dict[str, float]:
        """Return the place and the telescope less it, as an equatorial mount has them."""
        (ha, dec), (seen_ha, seen_dec) = (
            [float(one[0]) / DEG for one in equator(*_radians(*place), self.latitude * DEG)]
            for place in ((self.az, self.el), (self.seen_az, self.seen_el))
        )
        return {
            "ha_deg": ha,
            "dec_deg": dec,
            "d_ha_deg": _turn(seen_ha - ha),
            "d_dec_deg": seen_dec - dec,
            "ra_deg": self.ra,
        }


def _radians(az_deg: float, el_deg: float) -> tuple[Array, Array]:
    return np.array([az_deg * DEG]), np.array([el_deg * DEG])


def _turn(degrees: float) -> float:
    """Return a difference of angles [deg] within half a turn."""
    return float(wrap(degrees * DEG)) / DEG


def is_star(line: Line, words: Sequence[str]) -> bool:
    """Tell whether a line is such a record: hours and minutes are whole, degrees are not.

    Raises `BadInput`: it begins like one, and is too short: TPOINT has two more kinds of records,
      which no public source describes.
    """
    whole = (one.lstrip("+-").isdecimal() for one in (*words[:2], *words[3:5]))
    begins = len(words) >= SHORTEST and all(whole)
    if begins and len(words) < APPARENT:
        wanted = f"expected {APPARENT} or more (format 1), or angles in degrees (format 4)"
        raise line.error(f"{len(words)} words of hours, degrees and minutes, {wanted}")
    return begins


def star(line: Line, words: Sequence[str], site: Sequence[str]) -> Star:
    """Return the star of a record.

    `line`, `words`: where it stands, and its words.
    `site`: the words of the run's record: latitude, date, weather.
    Raises `BadInput`: a word is no number, or an angle is none.
    """
    mean = len(words) >= MEAN and equinox(words[8]) is not None
    latitude = _sexagesimal(line, site[:3], "the latitude", 90) * DEG
    ra, dec = _place(line, words[:6], "the catalogue's place")
    if mean:
        ra, dec = _apparent(line, ra, dec, words[6:9], site)
    seen = words[9:] if mean else words[6:]
    seen_ra, seen_dec = _place(line, seen[:6], "the observed place", 270)
    if over := abs(seen_dec) > 90:
        seen_ra, seen_dec = seen_ra + 180, math.copysign(180, seen_dec) - seen_dec
    lst = _sexagesimal(line, (*seen[6:8], "0"), "the sidereal time", 24) * 15
    places = [
        horizon(np.array([(lst - r) * DEG]), np.array([d * DEG]), latitude)
        for r, d in ((ra, dec), (seen_ra, seen_dec))
    ]
    (az, el), (seen_az, seen_el) = ((float(a[0]), float(e[0])) for a, e in places)
    el += _refraction(site, el)
    return Star(
        az / DEG,
        el / DEG,
        seen_az / DEG,
        seen_el / DEG,
        ra,
        dec,
        tuple(seen[8:]),
        latitude / DEG,
        over,
    )


def _place(line: Line, words: Sequence[str], what: str, largest: float = 90) -> tuple[float, float]:
    """Return right ascension and declination [deg]; a mount may show one beyond the pole."""
    ra = _sexagesimal(line, words[:3], what, 24) * 15
    return ra, _sexagesimal(line, words[3:6], what, largest)


def _sexagesimal(line: Line, words: Sequence[str], what: str, largest: float) -> float:
    """Return hours or degrees from three words."""
    whole, minutes, seconds = (float(line.decimal(word, what)) for word in words)
    value = abs(whole) + minutes / 60 + seconds / 3600
    if not (0 <= minutes < 60 and 0 <= seconds < 60 and value <= largest):
        raise line.error(f"{what} is {' '.join(words)}, expected up to {largest:g} 59 59.9")
    return -value if words[0].startswith("-") else value


def _apparent(
    line: Line, ra: float, dec: float, further: Sequence[str], site: Sequence[str]
) -> tuple[float, float]:
    """Return the apparent place of date of a mean place [deg], by ERFA's IAU 2006 astrometry.

    Proper motions are those of TPOINT: seconds of time, and of arc, in a year.
    """
    import erfa

    pm_ra, pm_dec = (float(line.decimal(word, "a proper motion")) for word in further[:2])
    of = equinox(further[2])
    if of is None or not of.known:
        wanted = "expected B1950.0, a Julian one such as J2000.0, or an apparent place"
        raise line.error(f"the equinox is {further[2]}, {wanted}")
    if len(site) < 6:
        raise line.error("the run's record gives no date, by which the mean place moves")
    year, month, day = (int(float(line.decimal(word, "the date"))) for word in site[3:6])
    try:
        dt.date(year, month, day)
    except (ValueError, OverflowError):
        wanted = f"the date is {' '.join(site[3:6])}, expected year, month and day"
        raise line.error(wanted) from None
    place = to_j2000(Place(ra * DEG, dec * DEG, pm_ra * 15 * ARCSEC, pm_dec * ARCSEC), of)
    star_ra, star_dec, origins = erfa.atci13(
        place.ra, place.dec, place.pm_ra, place.pm_dec, 0.0, 0.0, *erfa.cal2jd(year, month, day)
    )
    return math.degrees(float(star_ra) - float(origins)) % 360, math.degrees(float(star_dec))


def refracted(site: Sequence[str]) -> str:
    """Return in words what `star` makes of refraction with a run's record."""
    numbers = _weather(site)
    if numbers is None:
        return (
            "the catalogue's places are not refracted, for the run's record has no weather or a "
            "pressure of 0: the elevation offsets hold all refraction that was not corrected for"
        )
    celsius, hpa, _, humidity, micron = numbers
    weather = f"{celsius:g} C, {hpa:g} hPa, humidity {humidity:g}, {micron:g} um"
    said = f"the catalogue's places are refracted by the run's weather ({weather})"
    taken = [name for name in WEATHER[_given(site) :] if name != "height_m"]
    if not taken:
        return said
    names = " and ".join(name.partition("_")[0] for name in taken)
    return f"{said}; its record does not give the {names}, for which the usual is taken"


def as_seen(site: Sequence[str]) -> str:
    """Return in words what is made of refraction where angles in degrees stand in the file."""
    unused = "" if _weather(site) is None else ", and the run's weather is not used"
    taken = "places are taken for refracted ones, as the telescope sees them"
    return f"{taken} (TPOINT's format 4): no refraction is added{unused}"


def _weather(site: Sequence[str]) -> list[float] | None:
    """Return the weather of a run's record, None where it tells none or a pressure of zero.

    What it does not give behind the pressure is as usual.
    """
    given = _given(site)
    numbers = [float(word) for word in site[6 : 6 + given]]
    if given < len(WEATHER) - len(USUAL) or numbers[1] <= 0:
        return None
    return numbers + [USUAL[name] for name in WEATHER[given:]]


def _given(site: Sequence[str]) -> int:
    """Return how many numbers of the weather a run's record gives."""
    for count, word in enumerate(site[6 : 6 + len(WEATHER)]):
        try:
            float(word)
        except ValueError:
            return count
    return len(site[6 : 6 + len(WEATHER)])


def _refraction(site: Sequence[str], el: float) -> float:
    """Return how much higher a star stands in the run's weather [rad]; 0 where it tells none."""
    import erfa

    weather = _weather(site)
    if weather is None:
        return 0.0
    celsius, hpa, _, humidity, micron = weather
    a, b = erfa.refco(hpa, celsius, humidity, micron)
    # the constants are for what is seen: come to rest from the true place
    seen = el
    for _ in range(5):
        tan_z = 1 / math.tan(max(seen, 0.05))
        seen = el + a * tan_z + b * tan_z**3
    return float(seen - el)
