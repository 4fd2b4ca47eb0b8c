"""From catalogue place to true place: the known effects, taken out of measured offsets one by one.

Offsets are often measured against positions that were only precessed, as the
RT32's were. What the steering program left out then stands in the offsets as if
it were the telescope's. All of it is computed by ERFA with the IERS series that
comes with astropy; nothing is fetched.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.effects import CATALOGUE, Circumstances, Effect, MissingColumn
from pyport.effects.sky.astrometry import NUTATIONS
from pyport.effects.sky.frame import hour_angle_shift, ut1_minus_utc
from pyport.errors import BadInput
from pyport.recordings.schema import Recordings

#: Circumstances -> how far the source stands from where it is computed to be without the step:
#: (x, y) [rad], shape (n,) each.
Shift = Callable[[Circumstances], tuple[Array, Array]]

#: The document's mean refraction at 45 deg [arcsec].
MEAN_REFRACTION_ARCSEC = 60.0

#: Turns of the sky by UT1-UTC: arcseconds of hour angle in a second of time.
ARCSEC_PER_SECOND = 15.041

#: Beyond this ERFA takes a wavelength for a radio one [micrometre].
_RADIO_UM = 1e6


def of_nature(effect: Effect) -> Shift:
    """Return the shift of an effect whose coefficients nature fixes."""

    def shift(at: Circumstances) -> tuple[Array, Array]:
        size = np.array([(one.expected or 0.0) * one.scale for one in effect.coefficients])
        x, y = effect.columns(at)
        return x @ size, y @ size

    return shift


def ut1(at: Circumstances) -> tuple[Array, Array]:
    """Return the shift by the Earth's having turned by UT1 where the program took UTC."""
    angle = ut1_minus_utc(at) * ARCSEC_PER_SECOND * ARCSEC
    x, y = hour_angle_shift(at)
    return angle * x, angle * y


def mean_refraction(at: Circumstances) -> tuple[Array, Array]:
    """Return the document's refraction, 60 arcsec / tan H, whatever the weather."""
    x, y = CATALOGUE["refraction"].columns(at)
    return x[:, 0] * MEAN_REFRACTION_ARCSEC * ARCSEC, y[:, 0] * MEAN_REFRACTION_ARCSEC * ARCSEC


def weather_refraction(at: Circumstances) -> tuple[Array, Array]:
    """Return the refraction of radio waves in the air of each recording, by ERFA's refco.

    A tan Z + B tan^3 Z of the zenith distance at which the source is seen.
    """
    import erfa

    humidity = at.numbers("humidity_pct") / 100
    a, b = erfa.refco(at.numbers("pressure_hpa"), at.numbers("temperature_c"), humidity, _RADIO_UM)
    lift = np.zeros(len(at))
    for _ in range(5):
        tan_z = 1 / np.tan(np.maximum(at.el + lift, np.radians(1.0)))
        lift = a * tan_z + b * tan_z**3
    return np.zeros(len(at)), lift


#: Every step by its name. Nutation left out of the positions alone shows whole where the sidereal
#: time was the apparent one, and about half where it was the mean one.
STEPS: dict[str, Shift] = {
    "precession": of_nature(CATALOGUE["precession"]),
    "nutation": of_nature(NUTATIONS[0]),
    "nutation_apparent_time": of_nature(NUTATIONS[1]),
    "annual_aberration": of_nature(CATALOGUE["annual_aberration"]),
    "diurnal_aberration": of_nature(CATALOGUE["diurnal_aberration"]),
    "ut1": ut1,
    "polar_motion": of_nature(CATALOGUE["polar_motion"]),
    "mean_refraction": mean_refraction,
    "weather_refraction": weather_refraction,
}

#: What the document took out of its offsets, whose positions had been precessed.
DOCUMENT = (
    "nutation",
    "annual_aberration",
    "diurnal_aberration",
    "ut1",
    "polar_motion",
    "mean_refraction",
)


def left_out(at: Circumstances, steps: Collection[str] = DOCUMENT) -> tuple[Array, Array]:
    """Return what positions computed without these steps add to the offsets [rad].

    Raises `BadInput`: there is no such step.
    Raises `MissingColumn`: a step needs a time, a site or the weather.
    """
    x, y = np.zeros(len(at)), np.zeros(len(at))
    for name in steps:
        if name not in STEPS:
            raise BadInput(f"no step is called {name!r}, expected one of {', '.join(STEPS)}")
        more_x, more_y = STEPS[name](at)
        x, y = x + more_x, y + more_y
    return x, y


def reduced(recordings: Recordings, steps: Collection[str]) -> Recordings:
    """Return recordings whose offsets are free of these steps.

    The header says under `reduced` what was taken out, and keeps that it was.

    Raises `BadInput`: there is no such step, it was taken out before, or the recordings lack what
      it needs.
    """
    before = recordings.meta.get("reduced", "").split()
    again = [name for name in steps if name in before]
    if again:
        raise BadInput(f"{' '.join(again)} was taken out of these offsets before", recordings.file)
    try:
        x, y = left_out(recordings.at, steps)
    except MissingColumn as lack:
        raise BadInput(f"the reduction {lack}", recordings.file) from None
    meta = {**recordings.meta, "reduced": " ".join([*before, *steps])}
    return replace(recordings, x=recordings.x - x, y=recordings.y - y, meta=meta)
