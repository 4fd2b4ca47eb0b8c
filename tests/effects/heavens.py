"""Cases of a sky that was computed wrongly: by spherical trigonometry, ERFA, Snell."""

import erfa
import numpy as np
from astropy.coordinates import AltAz, EarthLocation, get_sun
from astropy.time import Time
from astropy.utils import iers
from effects.cases import AT, Case
from effects.mechanics import NORTH, NORTHWARD, leaning, mounted
from effects.sky import SITE, julian, replaced, stars, without

from pyport.angles import ARCSEC, DEG
from pyport.effects import Circumstances

HOUR_ANGLE, DEC, TIME = (AT.columns[name] for name in ("hour_angle", "dec", "time"))
UT = julian(TIME)
TT = UT[0], UT[1] + 64.184 / 86400
#: The hour angle of a star turns by so much in a second of UT1 [rad/s].
TURN = 2 * np.pi / 86164.0905


def apart(az, el, of=AT):
    """Return (x, y) of another direction less that of some circumstances."""
    return ((az - of.az + np.pi) % (2 * np.pi) - np.pi) * np.cos(of.el), el - of.el


def seen(hour_angle, dec, latitude=SITE.latitude):
    """Return (x, y) of where a source stands less where it was thought to."""
    return apart(*erfa.hd2ae(hour_angle, dec, latitude))


def speeds():
    """Return how fast the axes turn to follow the sky [rad/s], from two places a second apart."""
    before, after = (
        erfa.hd2ae(HOUR_ANGLE + half * TURN, DEC, SITE.latitude) for half in (-0.5, 0.5)
    )
    return (after[0] - before[0] + np.pi) % (2 * np.pi) - np.pi, after[1] - before[1]


def ahead(axis, reach_s):
    """Return the offsets of a telescope that one axis of leads the sky by some seconds."""
    offsets = list(seen(HOUR_ANGLE + TURN * reach_s, DEC))
    offsets[1 - axis] = 0 * AT.az
    return tuple(offsets)


def misplaced(size):
    """Return the offsets of source S3 when it stands 6" east and 4" south of its catalogue."""
    there = size * (AT.columns["source"] == "S3") * ARCSEC
    return seen(HOUR_ANGLE - there * 6 / np.cos(DEC), DEC - there * 4)


def aside(size):
    """Return the offsets of a camera that sees what is 12" west and 5" north of its axis."""
    west, north = size * 12 * ARCSEC, size * 5 * ARCSEC
    return seen(HOUR_ANGLE + west / np.cos(DEC), DEC + north)


def near(size):
    """Return the offsets of what is so near that its horizontal parallax is 30"."""
    sine = np.sin(size * 30 * ARCSEC)
    return 0 * AT.az, np.arctan2(np.sin(AT.el) - sine, np.cos(AT.el)) - AT.el


def losing(seconds_a_day):
    """Return how fast the sky gets ahead of a clock that loses so much [rad/s]."""
    return TURN * seconds_a_day / 86400


def evening():
    """Return the time since the first row of each row's session [s]."""
    session = AT.columns["session"]
    return TIME - np.array([TIME[session == one].min() for one in session])


SPHERE = [
    Case("rotator_circle", (12.0, 5.0), aside, variant="phi = -parallactic angle", tolerance=1e-3),
    Case(
        "site_latitude",
        (20.0,),
        lambda s: seen(HOUR_ANGLE, DEC, SITE.latitude + s * 20 * ARCSEC),
    ),
    Case("site_longitude", (20.0,), lambda s: seen(HOUR_ANGLE + s * 20 * ARCSEC, DEC)),
    Case("clock", (2.0,), lambda s: seen(HOUR_ANGLE + s * 30 * ARCSEC, DEC)),
    Case("epoch_clock", tuple(NORTH / 15), lambda s: seen(HOUR_ANGLE + s * NORTHWARD, DEC)),
    Case("clock_rate", (6.0,), lambda s: seen(HOUR_ANGLE + s * losing(6) * evening(), DEC)),
    Case("source_position", (6.0, -4.0), misplaced, variant="S3"),
    Case("parallax", (30.0,), near, at=replaced(AT, source=np.full(len(AT), "Ceres"))),
    Case(
        "backlash_azimuth",
        (15.0,),
        lambda s: (s * 15 * ARCSEC * np.sign(speeds()[0]) * np.cos(AT.el), 0 * AT.az),
    ),
    Case(
        "backlash_elevation", (15.0,), lambda s: (0 * AT.az, s * 15 * ARCSEC * np.sign(speeds()[1]))
    ),
    Case("servo_lag_azimuth", (0.8,), lambda s: ahead(0, s * 0.8)),
    Case("servo_lag_elevation", (0.8,), lambda s: ahead(1, s * 0.8)),
]


def horizon(direction, era):
    """Return azimuth and elevation of celestial directions when the Earth has turned by `era`."""
    ra, dec = erfa.c2s(direction)
    return erfa.hd2ae(era + SITE.longitude - ra, dec, SITE.latitude)


def omitted(effect, amount, thought, true, *, time=TIME, **more):
    """Return a case of a steering that thinks a source is at one (az, el) when it is at another."""
    at = Circumstances(*thought, SITE, {"time": time})
    return Case(effect, (amount,), lambda _: apart(*true, at), at=at, scales=False, **more)


def astrometry():
    """Return the cases of what steering programs forget, by chains of ERFA that forget it too."""
    _, ra, dec, _ = stars()
    star = erfa.s2c(ra, dec)
    # Models other than the catalogue's: IAU 1976 precession, 1980 nutation, 1994 sidereal time.
    precessed = np.einsum("nij,nj->ni", erfa.pmat76(*TT), star)
    nutated = np.einsum("nij,nj->ni", erfa.nutm80(*TT), star)
    mean, apparent = erfa.gmst82(*UT), erfa.gst94(*UT)
    geocentre, _ = erfa.apci13(*TT)
    observer, _ = erfa.apco13(
        *UT, 0.0, SITE.longitude, SITE.latitude, SITE.height_m, 0, 0, 0, 0, 0, 1
    )
    era = erfa.era00(*UT)

    def proper(at):
        place = erfa.ab(star, at["v"], at["em"], at["bm1"])
        return horizon(np.einsum("nij,nj->ni", geocentre["bpn"], place), era)

    unshifted = horizon(np.einsum("nij,nj->ni", geocentre["bpn"], star), era)
    return [
        omitted(
            "nutation",
            1.0,
            horizon(star, mean),
            horizon(nutated, apparent),
            variant="mean sidereal time",
            tolerance=2e-3,
        ),
        omitted(
            "nutation",
            1.0,
            horizon(star, apparent),
            horizon(nutated, apparent),
            variant="apparent sidereal time",
            tolerance=2e-3,
        ),
        *(
            omitted(
                "precession",
                1.0,
                horizon(thought, mean),
                horizon(precessed, mean),
                variant=f"coordinates of {variant}",
                tolerance=tolerance,
            )
            for variant, thought, tolerance in _precessions(star, precessed)
        ),
        omitted("annual_aberration", 20.4955, unshifted, proper(geocentre), tolerance=5e-4),
        omitted("diurnal_aberration", 0.32, proper(geocentre), proper(observer), tolerance=3e-3),
    ]


def _precessions(star, precessed):
    """Yield whose coordinates are taken for whose, and where the star is then thought to be.

    Of B1950 it is thought half a degree off, where a turn is not quite a shift.
    """
    since, older = erfa.pmat76(*TT), erfa.pmat76(2433282.0, 0.42345905)
    old = np.einsum("ij,nj->ni", older, star)
    toward = "those of J2000, or those of J2000 turned back, not on"
    yield "J2000 were taken for those of date", star, 2e-3
    yield (
        "date were taken for those of J2000",
        np.einsum("nij,nj->ni", since, precessed),
        2e-3,
    )
    yield "B1950 were taken for those of date", old, 2e-2
    yield f"B1950 were taken for {toward}", np.einsum("nij,nj->ni", since, old), 2e-2


def orientation():
    """Return the cases of the Earth's orientation, by ERFA's whole chain and astropy's IERS.

    The second campaign lasts three years, with a leap second in between.
    """
    series = iers.IERS_B.open()
    x_p, y_p = (angle.to_value("rad") for angle in series.pm_xy(*UT))
    time, ra, dec, _ = stars(nights=36)
    seconds = series.ut1_utc(*julian(time)).to_value("s")
    long = time, ra, dec
    return [
        omitted(
            "polar_motion",
            1.0,
            observed(*stars()[:3]),
            observed(*stars()[:3], x_p=x_p, y_p=y_p),
        ),
        omitted(
            "clock",
            1.0,
            observed(*long),
            observed(*long, dut1=seconds),
            time=time,
            variant="UT1-UTC left out",
            tolerance=5e-4,
        ),
    ]


def observed(time, ra, dec, *, dut1=0.0, x_p=0.0, y_p=0.0):
    """Return azimuth and elevation of stars by ERFA's whole chain, without refraction."""
    az, zenith_distance, *_ = erfa.atco13(
        *(ra, dec, 0, 0, 0, 0),
        *(*julian(time), dut1, SITE.longitude, SITE.latitude, 0, x_p, y_p, 0, 0, 0, 1),
    )
    return az, np.pi / 2 - zenith_distance


def sunlit():
    """Return the case of a lean away from the Sun where astropy sees it, by day and late."""
    at = without(without(AT, "sun_az_deg"), "sun_el_deg")
    where = EarthLocation.from_geodetic(SITE.longitude / DEG, SITE.latitude / DEG, SITE.height_m)
    with iers.conf.set_temp("auto_download", False):  # noqa: FBT003 - theirs
        then = Time(TIME - 2 * 3600, format="unix")
        sun = get_sun(then).transform_to(AltAz(obstime=then, location=where))
    power = 25 * ARCSEC * (sun.alt.rad > 0)
    return mounted(
        "thermal_tilt",
        (25.0,),
        lambda s: leaning(s * power, sun.az.rad + np.pi),
        variant="while the Sun is up, 2 h late",
        at=at,
    )


def bent(excess):
    """Return the offsets by a plane atmosphere whose refractive index is 1 + `excess`: Snell."""
    return 0 * AT.az, np.arccos(np.cos(AT.el) / (1 + excess)) - AT.el


#: Above the elevations at which the next power of cot E counts.
HIGH = AT.take(AT.el > 15 * DEG)


def curved(size, excess=6 * ARCSEC, height=8 / 6371):
    """Return what a homogeneous round atmosphere (Cassini's) adds to the term in cot E."""
    sine = np.cos(HIGH.el) / (1 + height)
    bending = np.arcsin((1 + size * excess) * sine) - np.arcsin(sine)
    return 0 * HIGH.az, bending - size * excess * (1 - height) / np.tan(HIGH.el)


def vapour_hpa():
    """Return the pressure of water vapour by the formula of Tetens."""
    t = AT.columns["temperature_c"]
    return AT.columns["humidity_pct"] / 100 * 6.1078 * 10 ** (7.5 * t / (237.3 + t))


def through_electrons(size):
    """Return the bending of a ray step by step through 10^17 electrons/m^2 at 400 km."""
    radius = np.linspace(6371e3 + 300e3, 6371e3 + 500e3, 801)[:, None]
    density = np.exp(-0.5 * ((radius - 6771e3) / 10e3) ** 2) / (10e3 * np.sqrt(2 * np.pi))
    frequency = AT.columns["frequency_mhz"] * 1e6
    slowness = -40.3 * size * 1e17 * density / frequency**2
    sine = np.cos(AT.el) * 6371e3 / radius / (1 + slowness)
    tangent = sine / np.sqrt(1 - sine**2)
    steps = -np.diff(slowness, axis=0) * (tangent[1:] + tangent[:-1]) / 2
    return 0 * AT.az, steps.sum(axis=0)


AIR = [
    Case("refraction", (58.0,), lambda s: bent(s * 58 * ARCSEC), tolerance=0.01),
    Case("refraction_curvature", (-6 * 8 / 6371,), curved, at=HIGH, tolerance=0.07),
    Case("wet_refraction", (0.9,), lambda s: bent(s * 0.9 * ARCSEC * vapour_hpa()), tolerance=0.01),
    Case(
        "ionosphere",
        (40.3 * 1e17 / 1e18 / 6771e3 / ARCSEC,),
        through_electrons,
        tolerance=0.01,
    ),
]

CASES = [*SPHERE, *astrometry(), *orientation(), sunlit(), *AIR]
