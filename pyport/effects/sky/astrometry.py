"""Astrometry and sources: how far the sky truly stands from where it was computed to stand.

Each basis is the apparent place less the place that a steering program computes
when it leaves that one effect out, so where physics is all there is the
coefficient comes out as the constant of nature, or as one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.effects.base import SKY, Basis, Circumstances, Coefficient, Effect, MissingColumn, stack
from pyport.effects.sky.frame import (
    TT_MINUS_UTC_DAYS,
    UNIX_EPOCH_JD,
    days,
    earth_velocity,
    from_sky,
    hour_angle,
    hour_angle_shift,
    pole,
    project,
    turned,
)

_SUPPLEMENT = "Urban & Seidelmann 2013, Explanatory Supplement to the Astronomical Almanac"
_LEW = "Lew 2018, Experimental Astronomy 45, 81: what the RT32's steering left out"
_WHERE_AND_WHEN = ("time_utc", "latitude_deg", "longitude_deg")

#: Constant of aberration [arcsec], and of diurnal aberration: the equator's speed over light's.
KAPPA_ARCSEC = 20.49551
DIURNAL_ARCSEC = 0.3200


def annual_aberration(at: Circumstances) -> tuple[Array, Array]:
    """Return the shift toward where the Earth is moving, one for the mean speed of the orbit."""
    velocity = from_sky(at, earth_velocity(at))
    return stack(at, project(at, velocity / (KAPPA_ARCSEC * ARCSEC)))


def diurnal_aberration(at: Circumstances) -> tuple[Array, Array]:
    """Return the shift toward the east, where the site is carried: cos phi of the equator's."""
    speed = np.cos(at.latitude())
    x = speed * np.cos(at.az)
    return stack(at, (x, -speed * np.sin(at.az) * np.sin(at.el)))


def polar_motion(at: Circumstances) -> tuple[Array, Array]:
    """Return the shift by the pole's x_p, y_p of each day."""
    import erfa

    x_p, y_p = pole(at)
    return stack(at, turned(at, erfa.pom00(x_p * ARCSEC, y_p * ARCSEC, 0.0)))


def _nutation(variant: str) -> Effect:
    """Return nutation left out of the coordinates, and of sidereal time unless it is apparent."""
    apparent_time = variant == _APPARENT

    def basis(at: Circumstances) -> tuple[Array, Array]:
        import erfa

        utc = days(at)
        date = UNIX_EPOCH_JD, utc + TT_MINUS_UTC_DAYS
        in_longitude, in_obliquity = erfa.nut00b(*date)
        obliquity = erfa.obl06(*date)
        matrix = erfa.numat(obliquity, in_longitude, in_obliquity)
        mean = erfa.gmst06(UNIX_EPOCH_JD, utc, *date)
        apparent = mean + erfa.ee00(*date, obliquity, in_longitude)
        kept = apparent if apparent_time else mean
        return stack(at, turned(at, _spin(apparent) @ matrix @ _spin(-kept)))

    return Effect(
        "nutation",
        "nutation was left out of the positions",
        _LEW,
        (Coefficient("nutation", "", 1.0, expected=1.0),),
        basis,
        common="array",
        variant=variant,
        profile=lambda _: NUTATIONS,
        acts_in=SKY,
        pattern="as nutation turns the sky",
        needs=_WHERE_AND_WHEN,
        formula=("the sky nodded by ERFA (IAU 2000B), across", "the same, along elevation"),
        member={"variant": variant},
        make=_nutation,
    )


#: With mean sidereal time nutation in longitude hardly shows; with the apparent one it does whole.
_APPARENT = "apparent sidereal time"
NUTATIONS = (_nutation("mean sidereal time"), _nutation(_APPARENT))


def _precession(variant: str) -> Effect:
    """Return precession left out, or taken from, toward or by another equinox."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        import erfa

        utc = days(at)
        date = UNIX_EPOCH_JD, utc + TT_MINUS_UTC_DAYS
        since_j2000 = erfa.bp06(*date)[1]
        turn = erfa.gmst06(UNIX_EPOCH_JD, utc, *date)
        lacking = PRECESSIONS_LACK[variant](since_j2000, erfa.bp06(*B1950)[1].T)
        return stack(at, turned(at, _spin(turn) @ lacking @ _spin(-turn)))

    return Effect(
        "precession",
        f"precession is wrong: {variant}",
        _SUPPLEMENT,
        (Coefficient("precession", "", 1.0, expected=1.0),),
        basis,
        common="array",
        variant=variant,
        profile=lambda _: PRECESSIONS,
        acts_in=SKY,
        pattern="as precession turns the sky",
        needs=_WHERE_AND_WHEN,
        formula=(
            "the sky turned from J2000 to date by ERFA (IAU 2006), across",
            "the same, along elevation",
        ),
        member={"variant": variant},
        make=_precession,
    )


#: The equinox of old catalogues, a Julian date in two parts.
B1950 = 2433282.0, 0.42345905
#: What turns the place that was computed into the true one, of the precession since J2000 (n, 3, 3)
#: and that from B1950 to J2000, by what was taken for what.
PRECESSIONS_LACK: dict[str, Callable[[Array, Array], Array]] = {
    "coordinates of J2000 were taken for those of date": lambda since, _: since,
    "coordinates of date were taken for those of J2000": lambda since, _: since.mT,
    "coordinates of B1950 were taken for those of date": lambda since, older: since @ older,
    # On which a quarter of a century later the precession since J2000 is, twice.
    "coordinates of B1950 were taken for those of J2000, or those of J2000 turned back, not on": (
        lambda since, older: since @ older @ since.mT
    ),
}
PRECESSIONS = tuple(map(_precession, PRECESSIONS_LACK))


def _spin(angle: Array) -> Array:
    """Return the rotations about the pole by sidereal time, from the sky to the Earth."""
    import erfa

    return erfa.rz(angle, np.eye(3))


def parallactic(at: Circumstances) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return (x, y) of a step of one radian eastward, and of one northward, on the sky.

    At the pole itself east and north mean nothing and the steps are zero.
    """
    west_x, west_y = hour_angle_shift(at)
    length = np.hypot(west_x, west_y)
    with np.errstate(invalid="ignore", divide="ignore"):
        east_x, east_y = np.where(length > 0, (-west_x / length, -west_y / length), 0.0)
    return (east_x, east_y), (east_y, -east_x)


def _fixed(
    identity: str,
    sentence: str,
    basis: Basis,
    coefficient: Coefficient,
    needs: tuple[str, ...],
    formula: tuple[str, str],
    pattern: str,
) -> Effect:
    """Return an effect of the sky with one coefficient that physics fixes."""
    return Effect(
        identity,
        sentence,
        _SUPPLEMENT,
        (coefficient,),
        basis,
        common="array",
        needs=needs,
        formula=formula,
        acts_in=SKY,
        pattern=pattern,
    )


#: A source tells its position when it was seen at so many hour angles, this far apart. [rad]
ENOUGH_HOUR_ANGLES = 3
APART = 1 * DEG
#: So many single sources are tried by themselves, those that were observed most.
MOST_SOURCES = 20

#: Names under which observers record what is near enough to have a parallax.
SOLAR_SYSTEM = frozenset(
    {
        *("sun", "moon", "mercury", "venus", "mars", "jupiter", "saturn", "uranus", "neptune"),
        *("pluto", "ceres", "pallas", "juno", "vesta"),
    }
)


def _source_position(sources: Sequence[str] | None, variant: str) -> Effect:
    """Return a shift in right ascension and declination of each of some sources.

    Without names of all that a family finds.
    """

    def basis(at: Circumstances) -> tuple[Array, Array]:
        if sources is None:
            return _source_positions(at)[0].basis(at)
        east, north = parallactic(at)
        source = at.column("source")
        pairs = [
            (np.where(source == name, x, 0.0), np.where(source == name, y, 0.0))
            for name in sources
            for x, y in (east, north)
        ]
        return stack(at, *pairs)

    return Effect(
        "source_position",
        "the catalogue's position of a source is wrong",
        "Smart, Textbook on Spherical Astronomy, ch. II: the parallactic angle",
        tuple(
            Coefficient(f"{axis}[{name}]")
            for name in sources or ()
            for axis in ("ra_cos_dec", "dec")
        ),
        basis,
        common="array",
        variant=variant,
        profile=_source_positions,
        acts_in=SKY,
        pattern=f"an offset of {variant} on the sky",
        belongs_to="source",
        needs=("source", "latitude_deg"),
        formula=("-e cos q + n sin q, shifted by e eastward, n northward", "e sin q + n cos q"),
        member={"sources": list(sources), "variant": variant} if sources else {},
        make=_source_position,
    )


def _source_positions(at: Circumstances) -> tuple[Effect, ...]:
    """Return a wrong position of each source that moved over the sky, and of all of them.

    One source alone cannot tell: its shift is taken for the mount's.
    """
    names = _moving(at)
    single = [_source_position([name], name) for name in names[:MOST_SOURCES]]
    if len(names) <= MOST_SOURCES:
        return _source_position(sorted(names), "every source"), *single
    return tuple(single)


def _moving(at: Circumstances) -> list[str]:
    """Name the sources seen at several hour angles, the one observed most first."""
    names, source, count = np.unique(at.column("source"), return_inverse=True, return_counts=True)
    if len(names) < 2:
        raise MissingColumn("a second source")
    steps = np.round(hour_angle(at) / APART)
    places = np.unique(np.stack([source, steps]), axis=1)[0].astype(int)
    enough = np.bincount(places, minlength=len(names)) >= ENOUGH_HOUR_ANGLES
    order = np.argsort(-count, kind="stable")
    moving = [str(names[k]) for k in order if enough[k] and names[k] != ""]
    if not moving:
        raise MissingColumn("a source at three hour angles")
    return moving


def _near(at: Circumstances) -> NDArray[np.bool_]:
    """Tell which rows may have a parallax: solar-system targets, or all where none is named."""
    if "source" not in at or np.all(at.column("source") == ""):
        return np.ones(len(at), bool)
    near = np.isin(np.char.lower(at.column("source").astype(str)), sorted(SOLAR_SYSTEM))
    if not near.any():
        raise MissingColumn("a solar-system target")
    return near


def parallax(at: Circumstances) -> tuple[Array, Array]:
    """Return -HP cos E along elevation: what is near stands lower than from the Earth's centre."""
    return stack(at, (0, np.where(_near(at), -np.cos(at.el), 0.0)))


EFFECTS = (
    _fixed(
        "polar_motion",
        "the wandering of the pole was left out",
        polar_motion,
        Coefficient("polar_motion", "", 1.0, expected=1.0),
        _WHERE_AND_WHEN,
        (
            "the Earth turned under its pole by x_p, y_p of the IERS, across",
            "the same, along elevation",
        ),
        "as the pole wanders, as the IERS has it",
    ),
    _fixed(
        "annual_aberration",
        "aberration by the Earth's motion about the Sun was left out",
        annual_aberration,
        Coefficient("kappa", expected=KAPPA_ARCSEC),
        _WHERE_AND_WHEN,
        ("kappa V . e_A / V0, V the Earth's velocity by ERFA", "kappa V . e_E / V0"),
        "toward where the Earth moves about the Sun",
    ),
    _fixed(
        "diurnal_aberration",
        "aberration by the Earth's spin was left out",
        diurnal_aberration,
        Coefficient("diurnal_aberration", expected=DIURNAL_ARCSEC),
        ("latitude_deg",),
        ("k cos phi cos A", "-k cos phi sin A sin E"),
        "toward the east point",
    ),
    NUTATIONS[0],
    PRECESSIONS[0],
    _source_position(None, "every source"),
    Effect(
        "parallax",
        "the target is near and its parallax was left out",
        "Smart, Textbook on Spherical Astronomy, ch. IX: geocentric parallax",
        (Coefficient("horizontal_parallax"),),
        parallax,
        acts_in=SKY,
        pattern="in elevation, with the cosine of elevation, for near targets",
        common="array",
        formula=("", "-HP cos E"),
    ),
)
