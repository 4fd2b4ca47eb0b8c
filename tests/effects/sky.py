"""A campaign with every column of the contract: eight sources followed over a year of nights."""

import dataclasses

import erfa
import numpy as np

from pyport.angles import DEG, HOUR
from pyport.effects import Circumstances, Site

#: Torun, Piwnice.
SITE = Site(53.0955 * DEG, 18.5641 * DEG, 100.0)
#: 2003-09-01 00:00 UTC [s since 1970].
START_S = 1_062_374_400.0
NIGHTS = 12
LOWEST_EL, HIGHEST_EL = 8 * DEG, 84 * DEG


def julian(time_s):
    """Return a time [s, UTC since 1970] as the two parts of a Julian date."""
    return 2440587.5, time_s / 86400


def stars(number=400, seed=1, start_s=START_S, nights=NIGHTS):
    """Return times [s], right ascensions and declinations [rad] of what stands well up."""
    rng = np.random.default_rng(seed)
    time = start_s + (rng.integers(0, nights, 4 * number) * 30.4 + rng.random(4 * number)) * 86400
    source = rng.integers(0, 8, 4 * number)
    ra, dec = np.linspace(0.4, 6.0, 8)[source], np.linspace(-10, 80, 8)[source] * DEG
    hour_angle = erfa.gmst06(*julian(time), *julian(time)) + SITE.longitude - ra
    _, el = erfa.hd2ae(hour_angle, dec, SITE.latitude)
    up = np.flatnonzero((el > LOWEST_EL) & (el < HIGHEST_EL))[:number]
    up = up[np.argsort(time[up])]
    return time[up], ra[up], dec[up], source[up]


def campaign(number=400, seed=1, start_s=START_S, nights=NIGHTS):
    """Return the circumstances of a campaign with every column of the contract."""
    time, ra, dec, source = stars(number, seed, start_s, nights)
    rng = np.random.default_rng(seed)
    n = len(time)
    hour_angle = erfa.gmst06(*julian(time), *julian(time)) + SITE.longitude - ra
    az, el = erfa.hd2ae(hour_angle, dec, SITE.latitude)
    columns = {
        "time": time,
        "hour_angle": (hour_angle + np.pi) % (2 * np.pi) - np.pi,
        "ra": ra,
        "dec": dec,
        "source": np.char.add("S", source.astype(str)),
        "antenna": np.full(n, "RT32"),
        "session": np.char.add(
            "night ", ((time - start_s) // (30.4 * 86400)).astype(int).astype(str)
        ),
        "receiver": rng.choice(["C", "L"], n),
        "channel": rng.choice(["1", "2", "3"], n),
        "polarisation": rng.choice(["left", "right"], n),
        "scan_axis": rng.choice(["az", "el"], n),
        "scan_direction": rng.choice([-1.0, 1.0], n),
        "scan_rate": rng.choice([1.0, 2.0], n) * 8 * DEG / 3600,
        "temperature_c": rng.uniform(-15, 30, n),
        "humidity_pct": rng.uniform(20, 95, n),
        "wind_speed_m_s": rng.uniform(0, 15, n),
        "wind_az": rng.uniform(0, 2 * np.pi, n),
        "sun_az": rng.uniform(0, 24 * HOUR, n),
        "sun_el": rng.uniform(-60 * DEG, 60 * DEG, n),
        "frequency_mhz": rng.choice([1420.0, 1666.0, 5000.0], n),
        "pressure_hpa": rng.uniform(980, 1030, n),
        "rotator_deg": rng.uniform(-170, 170, n),
    }
    return Circumstances(az % (2 * np.pi), el, SITE, columns)


def two_turns(az):
    """Return azimuths from -180 to 540 deg: every other one is a turn further on."""
    return (az + np.pi) % (2 * np.pi) - np.pi + 2 * np.pi * (np.arange(len(az)) % 2)


def without(at, name):
    """Return circumstances that lack a column or header key, under the contract's name."""
    if name == "latitude_deg":
        return dataclasses.replace(at, site=None)
    if name == "longitude_deg":
        return dataclasses.replace(at, site=dataclasses.replace(at.site, longitude=None))
    own = INSIDE.get(name, name)
    return dataclasses.replace(at, columns={k: v for k, v in at.columns.items() if k != own})


def replaced(at, **columns):
    """Return circumstances with other values in some columns."""
    return dataclasses.replace(at, columns={**at.columns, **columns})


#: The contract's names of columns that the program keeps in radians and seconds.
INSIDE = {
    "time_utc": "time",
    "hour_angle_h": "hour_angle",
    "sun_az_deg": "sun_az",
    "sun_el_deg": "sun_el",
    "wind_az_deg": "wind_az",
    "scan_rate_arcmin_per_min": "scan_rate",
}
