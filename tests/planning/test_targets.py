"""Targets: chosen by what they decide, within limits, in time, as telescopes read them."""

from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner
from drawn_nights import world, write

from pyport.angles import ARCSEC
from pyport.cli import pyport as program
from pyport.effects.base import Circumstances, Site
from pyport.effects.sky.frame import sun
from pyport.errors import BadInput
from pyport.formats.models import load
from pyport.planning.look import thinned
from pyport.planning.separate import separate
from pyport.planning.suggest import suggest
from pyport.planning.target_lists import FORMATS, read_catalogue
from pyport.planning.targets import (
    STEP_S,
    Limits,
    Source,
    _offered,
    seen_from,
    sunrise,
    targets,
    to_icrs,
)
from pyport.recordings.from_table import from_table

DEG = np.pi / 180
SITE = Site(53.0955 * DEG, 18.564 * DEG, 133.0)
PLACE = ("az_deg", "el_deg")
START = float(np.datetime64("2024-03-28T02:00:00", "s").astype(float))


@pytest.fixture(scope="module")
def past():
    """Return recordings in a band of elevations."""
    drawn = world()
    return from_table(drawn.past, drawn.header | {"latitude_deg": 53.0955, "longitude_deg": 18.6})


def test_places_are_astropy_s():
    """Within two arcseconds, of which UT1 is most."""
    from astropy import units
    from astropy.coordinates import AltAz, EarthLocation, SkyCoord
    from astropy.time import Time

    ra, dec = np.array([10.0, 200.0, 310.0]), np.array([-5.0, 40.0, 75.0])
    time = START + np.array([0.0, 3600.0, 7200.0])
    az, el = seen_from(SITE, ra * DEG, dec * DEG, time)
    there = EarthLocation(lat=53.0955 * units.deg, lon=18.564 * units.deg, height=133 * units.m)
    expected = SkyCoord(ra, dec, unit="deg").transform_to(
        AltAz(obstime=Time(time, format="unix"), location=there)
    )

    assert np.allclose(np.cos(el) * np.sin(az - expected.az.rad), 0, atol=2 / 206265)
    assert np.allclose(el, expected.alt.rad, atol=2 / 206265)
    again = to_icrs(SITE, az, el, time)
    assert np.allclose(again, (ra * DEG, dec * DEG), atol=1e-9)


def test_the_sun_rises_when_it_does():
    """Its elevation is then what astropy has it at, within the minute that is looked at."""
    from astropy import units
    from astropy.coordinates import AltAz, EarthLocation, get_sun
    from astropy.time import Time

    rises = Time(sunrise(SITE, START), format="unix")
    there = EarthLocation(lat=53.0955 * units.deg, lon=18.564 * units.deg, height=133 * units.m)
    height = get_sun(rises).transform_to(AltAz(obstime=rises, location=there)).alt.deg

    assert -0.85 < height < -0.65
    assert 0 < rises.unix - START < 4 * 3600


def test_targets_keep_to_limits_and_to_the_time_left(past):
    """Elevations, time for slew and dwell, and no more than asked for."""
    limits = Limits(20, 70, START, START + 3600, 240.0, 0.5, 0.25)
    found = targets(past, load("altaz"), limits, 30)

    assert 5 < len(found) <= 15
    assert all(20 <= one.el_deg <= 70 for one in found)
    assert found[-1].time_s + 240 <= START + 3600
    for one, other in pairwise(found):
        turn = abs((other.az_deg - one.az_deg + 180) % 360 - 180)
        slew = max(turn / 0.5, abs(other.el_deg - one.el_deg) / 0.25)
        assert other.time_s - one.time_s == pytest.approx(240 + slew)
    assert any(one.decides for one in found)


def test_sources_are_where_they_stand_at_their_time(past):
    """A catalogue's sources, each at its place when observed; one that never rises is none."""
    some = [
        Source(f"S{n}", ra * DEG, dec * DEG)
        for n, (ra, dec) in enumerate(((200, 40), (250, 60), (300, 70), (150, -80), (180, 20)))
    ]
    limits = Limits(15, 85, START, START + 7200)
    found = targets(past, load("altaz"), limits, 10, some)

    assert {one.source for one in found} <= {"S0", "S1", "S2", "S4"}
    for one in found:
        az, el = seen_from(
            past.at.site, one.ra_deg * DEG, one.dec_deg * DEG, np.array([one.time_s])
        )
        assert one.az_deg == pytest.approx(float(az[0] / DEG) % 360)
        assert one.el_deg == pytest.approx(float(el[0] / DEG))
    with pytest.raises(BadInput, match="nothing is within the limits"):
        targets(past, load("altaz"), limits, 3, some[3:4])


def test_sources_are_observed_where_they_were_chosen_for(past):
    """What decides between effects low in the sky was observed hours later, high up in it."""
    some = read_catalogue("radio")
    limits = Limits(15, 80, START, START + 8 * 3600)
    offered = _offered(past.at.site, limits, some)
    made = thinned(past, load("altaz"), None)
    chosen, _ = suggest(made, separate(made).pairs, offered, 20)
    found = targets(past, load("altaz"), limits, 20, some)

    assert len(found) >= 18
    for one in found:
        turned = [
            abs(one.el_deg - each.el_deg)
            for each in chosen
            if each.source == one.source and 0 <= one.time_s - each.time_s <= 2 * STEP_S
        ]
        assert min(turned) < 10


@pytest.mark.parametrize("catalogue", [None, "radio"])
def test_no_target_is_near_the_sun_when_it_is_observed(past, catalogue):
    """Nine hours of a June day: the Sun goes halfway around the sky."""
    start = float(np.datetime64("2024-06-20T06:00:00", "s").astype(float))
    limits = Limits(15, 85, start, start + 9 * 3600, sun_deg=30)
    some = read_catalogue(catalogue) if catalogue else ()
    found = targets(past, load("altaz"), limits, 60, some)
    place, when = SITE, np.array([one.time_s for one in found])
    az, el = (
        np.array([getattr(one, name) for one in found]) * DEG for name in ("az_deg", "el_deg")
    )
    sun_az, sun_el = sun(Circumstances(az, el, place, {"time": when}))
    cosine = np.sin(el) * np.sin(sun_el) + np.cos(el) * np.cos(sun_el) * np.cos(az - sun_az)

    assert len(found) > 20
    assert np.arccos(cosine).min() > 29.9 * DEG


def test_lists_are_what_telescopes_read(past):
    """Field System commands, a grid, places, CSV."""
    limits = Limits(15, 85, START, START + 3600)
    some = [Source("3C 286", 202.7845 * DEG, 30.5092 * DEG), Source("low", 0.5, -0.01)]
    (one, *_) = targets(past, load("altaz"), limits, 1, some)
    snap = FORMATS["snap"]([one]).splitlines()

    assert snap[1] == "source=3c_286,133108.28,+303033.1,2000.0"
    assert snap[2].startswith("!2024.088.02:")
    assert FORMATS["radec"]([one]).split() == ["3C_286", "13", "31", "08.28", "+30", "30", "33.1"]
    assert FORMATS["tpoint"]([one]).split() == [f"{one.az_deg:.4f}", f"{one.el_deg:.4f}"]
    assert FORMATS["csv"]([one]).splitlines()[1].startswith("2024-03-28T02:")


@pytest.mark.parametrize(
    ("kind", "columns"),
    [("equatorial", "hour_angle_deg,dec_of_date_deg"), ("xy-ns", "x_deg,y_deg"), ("altaz", "")],
)
def test_other_mounts_are_given_the_angles_of_their_axes(kind, columns):
    """And nothing that they do not reach: it was a list of azimuths and elevations."""
    drawn = world()
    header = drawn.header | {"latitude_deg": 53.0955, "longitude_deg": 18.6, "mount": kind}
    past, limits = from_table(drawn.past, header), Limits(5, 85, START, START + 7200)
    mount = past.at.mount
    found = targets(past, load("altaz"), limits, 12)
    angles = mount.angles(
        *(np.array([getattr(t, k) for t in found]) * DEG for k in PLACE), SITE.latitude
    )

    assert len(found) == 12
    assert mount.reaches(*angles).all()
    head, *rows = FORMATS["csv"](found).splitlines()
    assert head == f"time_utc,source,az_deg,el_deg,ra_deg,dec_deg,{columns},decides".replace(
        ",,", ","
    )
    for row, one, first, second in zip(rows, found, *angles, strict=True):
        assert list(one.axes.values()) == pytest.approx(
            [first / DEG, second / DEG] if columns else [], abs=1e-9
        )
        assert len(row.split(",")) == len(head.split(","))


def test_the_command_writes_a_list_until_sunrise(tmp_path):
    """By default until the Sun rises; bad input is one line."""
    drawn = world()
    path = write(tmp_path / "past.csv", drawn.past, drawn.header)
    words = ["targets", str(path), "--start", "2024-03-28T01:00:00Z", "--count", "4"]
    done = CliRunner().invoke(program, [*words, "-o", str(tmp_path / "next.csv")])
    assert done.exit_code == 0, done.output
    assert len((tmp_path / "next.csv").read_text().splitlines()) == 5
    bad = CliRunner().invoke(program, ["targets", str(path), "--start", "tonight"])
    assert "expected ISO 8601" in str(bad.exception)


def test_a_catalogue_is_read_and_refused(tmp_path):
    """Names once, places on the sky."""
    path = tmp_path / "sources.csv"
    path.write_text("name,ra_h,dec_deg\n3C48,1.628139,33.159764\n")
    (one,) = read_catalogue(path)
    assert (one.name, round(one.ra / DEG, 4)) == ("3C48", 24.4221)
    for text, why in (
        ("name,dec_deg\na,1\n", "a catalogue has columns"),
        ("name,ra_deg,dec_deg\na,1,100\n", "dec_deg outside"),
        ("name,ra_deg,dec_deg\na,400,10\n", r"ra_deg outside \[0, 360\]"),
        ("name,ra_h,dec_deg\na,25,10\n", r"ra_h outside \[0, 24\]"),
        (
            "name,ra_deg,dec_deg\na,1,1\na,2,2\n",
            "csv:3: two sources have one name, 'a': line 2 has it",
        ),
        ("name,ra_h,dec_deg\na,,10\n", "csv:2: no place, expected ra_h and dec_deg"),
    ):
        path.write_text(text)
        with pytest.raises(BadInput, match=why):
            read_catalogue(path)
    with pytest.raises(BadInput, match=r"nope.csv:1: no such file, expected radio, stars or a CSV"):
        read_catalogue(tmp_path / "nope.csv")


@pytest.mark.parametrize(
    ("name", "count", "known"),
    [
        ("radio", 211, {"3C273B": (187.2779155, 2.0523883), "3C286": (202.7845333, 30.5091553)}),
        ("stars", 351, {"HIP 91262": (279.2347348, 38.7836889), "HIP 71683": (219.902, -60.834)}),
    ],
)
def test_catalogues_are_shipped(name, count, known):
    """Places published elsewhere: ICRF's of 3C 273 and 3C 286, Vega's, alpha Centauri's."""
    some = {one.name: one for one in read_catalogue(name)}

    assert len(some) == count
    for one, (ra, dec) in known.items():
        assert (some[one].ra / DEG, some[one].dec / DEG) == pytest.approx((ra, dec), abs=2e-3)
    later = {one.name: one for one in read_catalogue(name, 2025.0)}
    moved = max(
        np.hypot((later[n].ra - one.ra) * np.cos(one.dec), later[n].dec - one.dec)
        for n, one in some.items()
    )
    # alpha Centauri goes 3.7 arcsec a year
    assert moved / ARCSEC == pytest.approx(92 if name == "stars" else 0, abs=4)


def test_shipped_sources_are_offered(tmp_path):
    """By name; what is no catalogue is one line."""
    drawn = world()
    path = write(tmp_path / "past.csv", drawn.past, drawn.header)
    words = ["targets", str(path), "--start", "2024-03-28T01:00:00Z", "--hours", "2"]
    done = CliRunner().invoke(program, [*words, "--count", "3", "--catalogue", "radio"])
    assert done.exit_code == 0, done.output

    names = {one.name for one in read_catalogue("radio")}
    rows = [line.split(",") for line in done.stdout.splitlines()[1:]]
    assert rows
    assert {row[1] for row in rows} <= names
    bad = CliRunner().invoke(program, [*words, "--catalogue", "infrared"])
    assert "infrared" in str(bad.exception)
