"""How large each step of the reduction was in the RT32's two campaigns, beside the document."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import ARCSEC, DEG, Array, wrap
from pyport.effects import Circumstances, Site
from pyport.effects.sky.frame import (
    TT_MINUS_UTC_DAYS,
    UNIX_EPOCH_JD,
    axes,
    days,
    pole,
    sun,
    ut1_minus_utc,
)
from pyport.recordings.sky import horizon
from pyport.studies.rt32.reduction import ARCSEC_PER_SECOND, STEPS, left_out

#: The 32 m telescope at Piwnice near Torun.
RT32 = Site(53.0955 * DEG, 18.5640 * DEG, 133.0)

#: First and last day of the document's campaigns.
CAMPAIGNS = {"2003": ("2003-03-15", "2003-06-12"), "2004": ("2004-01-29", "2004-05-06")}

#: Metres on the ground for each arcsecond of the pole.
_METRES_PER_ARCSEC = 6.371e6 * ARCSEC

#: The air that the sizes are printed for: spring at Torun.
AIR = {"pressure_hpa": 1000.0, "temperature_c": 8.0, "humidity_pct": 75.0}

#: The steps that are the sky's and not the air's, precession taken.
_OF_THE_SKY = ("nutation", "annual_aberration", "diurnal_aberration", "ut1", "polar_motion")

_DAY_S = 86400.0
_LOWEST = 10 * DEG


@dataclass(frozen=True)
class Size:
    """The size of a step in one campaign [arcsec]: rms and largest over the sky and the days."""

    step: str
    campaign: str
    rms: float
    largest: float


def sky_over(site: Site, first: str, last: str, seed: int = 0, count: int = 4000) -> Circumstances:
    """Return directions spread evenly over the sky above 10 deg, at moments spread evenly."""
    rng = np.random.default_rng(seed)
    start, stop = (np.datetime64(day, "s").astype(float) for day in (first, last))
    return Circumstances(
        az=rng.uniform(-np.pi, np.pi, count),
        el=np.arcsin(rng.uniform(np.sin(_LOWEST), 1, count)),
        site=site,
        columns={
            "time": rng.uniform(start, stop + _DAY_S, count),
            **{name: np.full(count, value) for name, value in AIR.items()},
        },
    )


def sizes(site: Site = RT32) -> list[Size]:
    """Return the size of every step in every campaign."""
    found = []
    for campaign, span in CAMPAIGNS.items():
        at = sky_over(site, *span)
        for step, shift in STEPS.items():
            offset = np.hypot(*shift(at)) / ARCSEC
            rms = float(np.sqrt(np.mean(offset**2)))
            found.append(Size(step, campaign, rms, float(offset.max())))
    return found


@dataclass(frozen=True)
class Agreement:
    """How far all steps together are from astropy's AltAz [arcsec].

    `away_from_sun` is the largest miss more than 30 deg from the Sun, whose
    gravity bends light by 0.1 arcsec at 5 deg: astropy counts that, no step does.
    """

    median: float
    largest: float
    away_from_sun: float


def against_astropy(count: int = 400) -> Agreement:
    """Compare with astropy's AltAz, an independent way from catalogue to horizon.

    Catalogue positions (J2000) are precessed and turned by mean sidereal time of
    UTC, as the RT32's were; then every other step is added. Refraction is left out
    on both sides. The last 10 deg to the zenith are too: a shift along a great
    circle is no longer one in azimuth there.
    """
    from astropy import units
    from astropy.coordinates import AltAz, EarthLocation, SkyCoord
    from astropy.time import Time
    from astropy.utils import iers

    misses, near_sun = [], []
    for span in CAMPAIGNS.values():
        drawn = sky_over(RT32, *span, seed=1, count=count)
        ra, dec, at = _precessed(drawn.take(drawn.el < 80 * DEG))
        x, y = left_out(at, _OF_THE_SKY)
        place = EarthLocation.from_geodetic(
            at.longitude() * units.rad, at.latitude() * units.rad, RT32.height_m * units.m
        )
        with iers.conf.set_temp("auto_download", value=False):
            times = Time(at.column("time"), format="unix")
            seen = SkyCoord(ra * units.rad, dec * units.rad).transform_to(
                AltAz(obstime=times, location=place)
            )
        miss_x = wrap(seen.az.rad - at.az) * np.cos(at.el) - x
        misses.append(np.hypot(miss_x, seen.alt.rad - at.el - y) / ARCSEC)
        sun_az, sun_el = sun(at)
        cosine = np.sum(axes(at)[2] * axes(replace(at, az=sun_az, el=sun_el))[2], axis=1)
        near_sun.append(cosine > np.cos(30 * DEG))
    miss, near = np.concatenate(misses), np.concatenate(near_sun)
    return Agreement(float(np.median(miss)), float(miss.max()), float(miss[~near].max()))


def _precessed(drawn: Circumstances) -> tuple[Array, Array, Circumstances]:
    """Return catalogue positions near drawn directions, and where precession alone puts them."""
    import erfa

    utc = days(drawn)
    date = UNIX_EPOCH_JD, utc + TT_MINUS_UTC_DAYS
    turn = erfa.gmst06(UNIX_EPOCH_JD, utc, *date) + drawn.longitude()
    hour_angle, dec = erfa.ae2hd(drawn.az, drawn.el, drawn.latitude())
    bias_and_precession = erfa.bp06(*date)[2]
    of_date = erfa.s2c(turn - hour_angle, dec)
    ra, dec_j2000 = erfa.c2s(np.einsum("nji,nj->ni", bias_and_precession, of_date))
    az, el = horizon(hour_angle, dec, drawn.latitude())
    return ra, dec_j2000, Circumstances(az, el, drawn.site, drawn.columns)


@dataclass(frozen=True)
class Orientation:
    """Ranges in one campaign: nutation and pole [arcsec], UT1-UTC [s]; (lowest, highest) each."""

    campaign: str
    in_longitude: tuple[float, float]
    in_obliquity: tuple[float, float]
    ut1_utc_s: tuple[float, float]
    pole: tuple[float, float]


def orientations() -> list[Orientation]:
    """Return how the Earth was turned in each campaign."""
    import erfa

    found = []
    for campaign, span in CAMPAIGNS.items():
        at = sky_over(RT32, *span)
        psi, epsilon = erfa.nut00b(UNIX_EPOCH_JD, days(at) + TT_MINUS_UTC_DAYS)
        found.append(
            Orientation(
                campaign,
                _range(psi / ARCSEC),
                _range(epsilon / ARCSEC),
                _range(ut1_minus_utc(at)),
                _range(np.hypot(*pole(at))),
            )
        )
    return found


def _range(values: Array) -> tuple[float, float]:
    return float(values.min()), float(values.max())


def refraction_at_45(**other: float) -> float:
    """Return the refraction at 45 deg [arcsec] in spring air, or in `other` than that."""
    air = {name: np.array([value]) for name, value in {**AIR, **other}.items()}
    at = Circumstances(np.zeros(1), np.array([45 * DEG]), RT32, air)
    return float(STEPS["weather_refraction"](at)[1][0]) / ARCSEC


def text() -> str:
    """Return all sizes beside the document's figures, and why they differ."""
    found = sizes()
    names = [f"{campaign} {what}" for campaign in CAMPAIGNS for what in ("rms", "largest")]
    lines = [f"{'step [arcsec on the sky]':26s}{''.join(f'{n:>14s}' for n in names)}    document"]
    for step in STEPS:
        numbers = "".join(f"{s.rms:14.2f}{s.largest:14.2f}" for s in found if s.step == step)
        lines.append(f"{step:26s}{numbers}    {_PRINTED.get(step, '')}".rstrip())
    lines.append(f"over the sky above {_LOWEST / DEG:.0f} deg, all hours and days")
    for one in orientations():
        lines += ["", *_orientation(one)]
    agreement = against_astropy()
    spring, dry = refraction_at_45(), refraction_at_45(humidity_pct=0.0)
    lines += [
        "",
        *_EXPLAINED,
        f"- refraction: in spring air ERFA gives radio waves {spring:.1f} arcsec at 45 deg,",
        f"  {spring - dry:.1f} of them by water vapour; it grows more slowly than 1/tan H.",
        "",
        "All steps but precession and refraction together, against astropy's AltAz [arcsec]:",
        f"median {agreement.median:.3f}, at most {agreement.away_from_sun:.3f};",
        f"within 30 deg of the Sun {agreement.largest:.3f}, where its gravity bends light",
    ]
    return "\n".join(lines)


def as_json() -> dict[str, object]:
    """Return the sizes of each step, the campaigns' orientations and what astropy says."""
    return {
        "sizes_arcsec": sizes(),
        "orientations": orientations(),
        "against_astropy_arcsec": against_astropy(),
    }


def _orientation(one: Orientation) -> list[str]:
    metres = one.pole[1] * _METRES_PER_ARCSEC
    turn = max(map(abs, one.ut1_utc_s)) * ARCSEC_PER_SECOND
    psi, epsilon, ut1, out = one.in_longitude, one.in_obliquity, one.ut1_utc_s, one.pole
    return [
        f"{one.campaign}: nutation in longitude {psi[0]:.1f} to {psi[1]:.1f} arcsec,",
        f"      in obliquity {epsilon[0]:.1f} to {epsilon[1]:.1f}",
        f"      UT1-UTC {ut1[0]:.3f} to {ut1[1]:.3f} s, at most {turn:.1f} arcsec of hour angle",
        f"      pole {out[0]:.2f} to {out[1]:.2f} arcsec from its origin, at most {metres:.0f} m",
    ]


#: The document's figures.
_PRINTED = {
    "nutation": '17"',
    "nutation_apparent_time": '17"',
    "annual_aberration": '20" (with the diurnal)',
    "ut1": '13"',
    "polar_motion": "17 m",
    "mean_refraction": '60"/tan H',
}

_EXPLAINED = (
    "- precession: the document's positions had it already; from J2000 it would be this much.",
    "- nutation: 17 arcsec is its amplitude in longitude, which 2003 comes close to. It shows",
    "  whole where sidereal time is the apparent one; with the mean one sky and clock move alike",
    "  and half is left. The document does not tell which time its positions were turned by.",
    "- aberration: as the document has it; the Earth's spin adds 0.2.",
    "- UT1: 13 arcsec would be 0.87 s, near the 0.9 s at which a leap second is due. It is a",
    "  bound: in these campaigns it was half of that or less.",
    "- polar motion: 17 m is what the pole did in 2003; on the sky it is half an arcsecond.",
)
